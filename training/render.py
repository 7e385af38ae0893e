"""Builds and calls render/render.cpp. World: metres, z up."""

import ctypes
import os
import pathlib
import subprocess

import numpy as np

FLOATS, INTS = np.float32, np.int32
UV, SOLID, PANORAMA, UNLIT = 0, 1, 2, 3
TRANSPARENT, SKY, NO_SHADOW = 1, 2, 4


class View(ctypes.Structure):
    """Mirrors the structure of the same name in render.cpp."""

    _fields_ = [
        ("position", ctypes.c_float * 3),
        ("axes", ctypes.c_float * 9),
        ("focal", ctypes.c_float),
        ("centre", ctypes.c_float * 2),
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("samples", ctypes.c_int32),
        ("background", ctypes.c_int32),
        ("turn", ctypes.c_float),
        ("exposure", ctypes.c_float),
        ("lightScale", ctypes.c_float),
        ("ambientReach", ctypes.c_float),
        ("projector", ctypes.c_float * 3),
        ("sun", ctypes.c_float * 3),
        ("sunColour", ctypes.c_float * 3),
        ("sunSize", ctypes.c_float),
        ("fog", ctypes.c_float),
        ("fogColour", ctypes.c_float * 3),
        ("seed", ctypes.c_uint32),
    ]


def build(into):
    """Compiles the renderer if it is missing or older than its source."""
    source = pathlib.Path(__file__).parent / "render" / "render.cpp"
    library = pathlib.Path(into) / "librender.so"
    if not library.exists() or library.stat().st_mtime < source.stat().st_mtime:
        new = library.with_suffix(f".{os.getpid()}")
        subprocess.run(
            [
                "g++",
                "-std=c++17",
                "-O3",
                "-ffp-contract=off",  # the same frames on every processor
                "-fno-math-errno",
                "-fno-trapping-math",
                "-fPIC",
                "-shared",
                str(source),
                "-o",
                str(new),
                "-lembree3",
            ],
            check=True,
        )
        new.rename(library)
    return library


def material(
    rgb=(1, 1, 1),
    texture=-1,
    scale=1.0,
    paint=UV,
    gloss=0.0,
    sharpness=20.0,
    detail=-1,
    detail_scale=1.0,
    detail_strength=0.0,
    flags=0,
):
    return np.array(
        [
            *rgb,
            texture,
            scale,
            paint,
            gloss,
            sharpness,
            detail,
            detail_scale,
            detail_strength,
            flags,
        ],
        FLOATS,
    )


def pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def vertex_normals(positions, triangles):
    p = positions[triangles]
    face = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    n = np.zeros_like(positions)
    for k in range(3):
        np.add.at(n, triangles[:, k], face)
    length = np.linalg.norm(n, axis=1, keepdims=True)
    return np.where(length > 0, n / np.maximum(length, 1e-20), [0, 0, 1]).astype(FLOATS)


class Renderer:
    def __init__(self, cache):
        self.lib = ctypes.CDLL(str(build(cache)))
        self.shared = {}

    def texture(self, rgba):
        if rgba.shape[2] == 3:
            rgba = np.dstack([rgba, np.full(rgba.shape[:2], 255, np.uint8)])
        rgba = np.ascontiguousarray(rgba, np.uint8)
        return self.lib.addTexture(pointer(rgba), rgba.shape[1], rgba.shape[0])

    def shared_texture(self, picture):
        """The texture of a picture that lives as long as the program."""
        if id(picture) not in self.shared:
            self.shared[id(picture)] = (self.texture(picture), picture)
        return self.shared[id(picture)][0]

    def panorama(self, rgb):
        rgb = np.ascontiguousarray(rgb, FLOATS)
        return self.lib.addPanorama(pointer(rgb), rgb.shape[1], rgb.shape[0])

    def model(self, positions, triangles, uv=None, normals=None, parts=None, transparent=False):
        """Positions n x 3, triangles m x 3, uv n x 2; parts: the material of each triangle."""
        positions = np.ascontiguousarray(positions, FLOATS)
        triangles = np.ascontiguousarray(triangles, INTS)
        normals = (
            vertex_normals(positions, triangles)
            if normals is None
            else np.ascontiguousarray(normals, FLOATS)
        )
        uv = (
            np.zeros((len(positions), 2), FLOATS)
            if uv is None
            else np.ascontiguousarray(uv, FLOATS)
        )
        parts = (
            np.zeros(len(triangles), INTS) if parts is None else np.ascontiguousarray(parts, INTS)
        )
        return self.lib.addModel(
            pointer(positions),
            pointer(normals),
            pointer(uv),
            len(positions),
            pointer(triangles),
            pointer(parts),
            len(triangles),
            int(transparent),
        )

    def drop_model(self, model):
        self.lib.dropModel(model)


class Scene:
    """What one frame shows. Things are models with a matrix and their materials."""

    def __init__(self, renderer):
        self.renderer, self.instances, self.materials, self.lamps = renderer, [], [], []
        self.own_models, self.tags = [], []

    def add(self, model, matrix, materials, tag=""):
        row = np.empty(14, FLOATS)
        row[0], row[1] = model, len(self.materials)
        row[2:] = np.asarray(matrix, FLOATS)[:3].reshape(-1)
        self.instances.append(row)
        self.materials.extend(materials)
        self.tags.append(tag)

    def add_mesh(self, mesh, matrix, materials, tag="", transparent=False):
        """A mesh (dict for Renderer.model) that only this frame has."""
        model = self.renderer.model(**mesh, transparent=transparent)
        self.own_models.append(model)
        self.add(model, matrix, materials, tag)

    def render(self, view, soft, last=True):
        """Colour, inverse depth and instance of each pixel. last: frees its own models."""
        pixels = (view.height, view.width)
        colour = np.zeros(pixels + (3,), FLOATS)
        inverse, which = np.zeros(pixels, FLOATS), np.zeros(pixels, INTS)
        instances = (
            np.ascontiguousarray(np.stack(self.instances))
            if self.instances
            else np.zeros((1, 14), FLOATS)
        )
        materials = (
            np.ascontiguousarray(np.stack(self.materials))
            if self.materials
            else np.zeros((1, 12), FLOATS)
        )
        lamps = np.ascontiguousarray(np.array(self.lamps, FLOATS).reshape(-1, 7))
        soft = np.ascontiguousarray(soft, FLOATS)
        self.renderer.lib.render(
            ctypes.byref(view),
            pointer(instances),
            len(self.instances),
            pointer(materials),
            len(self.materials),
            pointer(lamps),
            len(lamps),
            pointer(soft),
            soft.shape[1],
            soft.shape[0],
            pointer(colour),
            pointer(inverse),
            pointer(which),
        )
        if last:
            for m in self.own_models:
                self.renderer.drop_model(m)
        return colour, inverse, which


def camera_axes(yaw, pitch, roll):
    """Right, down and forward of a camera. Radians; yaw 0 looks along +x, pitch > 0 up."""
    forward = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
    right = np.array([np.sin(yaw), -np.cos(yaw), 0.0])
    down = np.cross(forward, right)
    c, s = np.cos(roll), np.sin(roll)
    return np.stack([right * c + down * s, down * c - right * s, forward])


def place(position=(0, 0, 0), turn=0.0, scale=1.0, tilt=0.0):
    """A 3 x 4 matrix: scale (number or three), tilt about x, turn about z, then move."""
    c, s = np.cos(turn), np.sin(turn)
    ct, st = np.cos(tilt), np.sin(tilt)
    m = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array(
        [[1, 0, 0], [0, ct, -st], [0, st, ct]]
    )
    return np.hstack([m * np.broadcast_to(scale, 3), np.reshape(position, (3, 1))])
