#!/usr/bin/env python3
"""Makes frames with exact depth for training."""

import argparse
import os
import pathlib
import sys
import time

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument(
    "--sources", required=True, help="folder with the bare git mirrors OWNER+NAME/repo"
)
parser.add_argument(
    "--cache", default="build/frames-cache", help="folder for extracted files and the renderer"
)
parser.add_argument("--out", required=True, help="folder for the frames")
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--first", type=int, default=0, help="number of the first frame")
parser.add_argument("--frames", type=int, default=100)
parser.add_argument(
    "--step", type=int, default=1, help="every how many frames: for several processes"
)
parser.add_argument("--families", default="", help="name=weight,...; all of them by default")
parser.add_argument(
    "--longer", type=int, default=288, help="px of a frame's longer side"
)
parser.add_argument("--held-out", action="store_true", help="use what is kept for validation")
if __name__ == "__main__":  # before what takes long to load or is missing
    args = parser.parse_args()

import cv2
import numpy as np

import camera
import scenes
import sources
from assets import Assets


def write(out, name, picture, inverse):
    """Writes a pair; the depth last and by rename: a pair is complete when its depth is there."""
    top = inverse.max()
    if not np.isfinite(top) or top <= 0:
        return False
    depth = np.round(inverse / top * 65535).astype(np.uint16)
    if np.ptp(depth) < 3000 or picture.std() < 6:  # nothing to learn from
        return False
    cv2.imwrite(
        str(out / f"{name}.jpg"),
        np.ascontiguousarray(picture[..., ::-1]),
        [cv2.IMWRITE_JPEG_QUALITY, 95],
    )
    part = out / f".{name}.part.png"
    cv2.imwrite(str(part), depth, [cv2.IMWRITE_PNG_COMPRESSION, 3])
    part.rename(out / f"{name}.d.png")
    return True


def frame(rng, assets, family):
    colour, inverse = scenes.FAMILIES[family](rng, assets)
    return camera.develop(rng, colour, inverse, family in scenes.NEAR_FOCUS), inverse


def main():
    a = args
    cv2.setNumThreads(1)
    scenes.LONGER = a.longer
    out = pathlib.Path(a.out)
    out.mkdir(parents=True, exist_ok=True)
    sources.extract(a.sources, pathlib.Path(a.cache) / "src")
    assets = Assets(pathlib.Path(a.cache), a.held_out)
    mix = dict(scenes.MIX)
    if a.families:
        mix = {
            k: float(w or 1) for k, _, w in (item.partition("=") for item in a.families.split(","))
        }
    names = sorted(mix)
    weights = np.array([mix[n] for n in names])
    start, made = time.time(), 0
    for number in range(a.first, a.first + a.frames, a.step):
        name = f"{number:06d}"
        if (out / f"{name}.d.png").exists():
            continue
        rng = np.random.default_rng([a.seed, number, int(a.held_out)])
        family = names[rng.choice(len(names), p=weights / weights.sum())]
        try:
            picture, inverse = frame(rng, assets, family)
        except (ValueError, ZeroDivisionError, IndexError, np.linalg.LinAlgError) as error:
            print(f"{name} ({family}): {error!r}", file=sys.stderr)
            continue
        if write(out, name, picture, inverse):
            with open(out / f"families.{os.getpid()}.txt", "a") as log:
                log.write(f"{name} {family}\n")
            made += 1
    print(f"{made} frames in {time.time() - start:.0f} s")


if __name__ == "__main__":
    main()
