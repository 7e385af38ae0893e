#!/usr/bin/env python3
"""Compares the renderer's depth with closed forms: check_render.py CACHE_FOLDER"""

import argparse
import pathlib

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("cache", metavar="CACHE_FOLDER", type=pathlib.Path)
if __name__ == "__main__":  # before what takes long to load or is missing
    args = parser.parse_args()

import numpy as np

import shapes
from render import Renderer, Scene, View, camera_axes, material, place


def main():
    renderer = Renderer(args.cache)
    sky = renderer.panorama(np.ones((32, 64, 3)))
    for yaw, pitch, roll in ((0.3, -0.5, 0.2), (-2.0, -1.2, 0.0), (1.0, 0.0, -0.4)):
        view, eye = View(), np.array([1.0, -2.0, 1.5])
        view.width, view.height, view.samples, view.background = 96, 64, 1, sky
        view.focal, view.exposure, view.lightScale, view.ambientReach = 70, 1, 1, 10
        view.centre[:], view.sun[:], view.position[:] = [48, 32], [0, 0, 1], list(eye)
        axes = camera_axes(yaw, pitch, roll)
        view.axes[:] = list(axes.ravel())
        scene = Scene(renderer)
        floor = shapes.quad((-500, 500, 0), (500, 500, 0), (-500, -500, 0), (500, -500, 0))
        scene.add_mesh(floor, place(), [material()])
        middle = eye + axes[2] * 1.2
        scene.add_mesh(shapes.ball(0.2, 256), place(middle - [0, 0, 0.2]), [material()])
        _, inverse, which = scene.render(view, np.ones((32, 64, 3)))

        # The closed form, for centres of pixels; the renderer's rays lie anywhere in the pixel.
        y, x = np.mgrid[0:64, 0:96] + 0.5
        rays = ((x - 48) / 70)[..., None] * axes[0] + ((y - 32) / 70)[..., None] * axes[1] + axes[2]
        plane = np.maximum(-rays[..., 2] / eye[2], 0)
        a, b, c = (rays**2).sum(-1), rays @ (eye - middle), 1.2**2 - 0.2**2
        inside = b * b - a * c
        ball = np.where(
            inside > 0, 1 / np.maximum((-b - np.sqrt(np.maximum(inside, 0))) / a, 1e-9), 0
        )
        truth = np.maximum(plane, ball)
        steps = np.maximum(np.abs(np.gradient(truth, axis=0)), np.abs(np.gradient(truth, axis=1)))
        smooth = steps < 0.01
        worst = (np.abs(inverse - truth) - 1.5 * steps)[smooth].max()
        assert worst < 2e-3, f"inverse depth is off by {worst}"
        assert (which[32, 48] == 1) and abs(
            inverse[32, 48] - 1.0
        ) < 5e-3, "the ball is not where it should be"
        assert smooth.mean() > 0.7
    print("depth of plane and ball: right")


if __name__ == "__main__":
    main()
