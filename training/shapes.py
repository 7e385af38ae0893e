"""Meshes made of numbers: dictionaries for Renderer.model."""

import numpy as np


def grid(columns, rows):
    """Triangles of a grid of (columns + 1) x (rows + 1) vertices, row by row."""
    at = np.arange((columns + 1) * (rows + 1)).reshape(rows + 1, columns + 1)
    a, b, c, d = at[:-1, :-1].ravel(), at[:-1, 1:].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel()
    return np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])


def join(*meshes):
    """One mesh; part numbers are kept."""
    out = {k: [] for k in ("positions", "triangles", "uv", "normals", "parts")}
    base = 0
    for m in meshes:
        out["triangles"].append(np.asarray(m["triangles"]) + base)
        base += len(m["positions"])
        for k in ("positions", "uv", "normals"):
            out[k].append(m[k])
        out["parts"].append(m.get("parts", np.zeros(len(m["triangles"]), np.int32)))
    return {k: np.concatenate(v) for k, v in out.items()}


def quad(a, b, c, d, part=0, repeat=(1, 1)):
    """Corners: top left, top right, bottom left, bottom right of the texture."""
    p = np.array([a, b, c, d], np.float32)
    n = np.cross(p[1] - p[0], p[2] - p[0])
    n = n / max(np.linalg.norm(n), 1e-12)
    uv = np.array([[0, 0], [1, 0], [0, 1], [1, 1]], np.float32) * repeat
    return {
        "positions": p,
        "triangles": np.array([[0, 1, 2], [1, 3, 2]]),
        "uv": uv,
        "normals": np.tile(n, (4, 1)).astype(np.float32),
        "parts": np.full(2, part, np.int32),
    }


def box(size=(1, 1, 1), parts=(0, 0, 0)):
    """Stands on z = 0, centred; parts: material of the four sides, the top and the bottom."""
    x, y, z = size[0] / 2, size[1] / 2, size[2]
    return join(
        quad((-x, -y, z), (x, -y, z), (-x, -y, 0), (x, -y, 0), parts[0]),
        quad((x, y, z), (-x, y, z), (x, y, 0), (-x, y, 0), parts[0]),
        quad((x, -y, z), (x, y, z), (x, -y, 0), (x, y, 0), parts[0]),
        quad((-x, y, z), (-x, -y, z), (-x, y, 0), (-x, -y, 0), parts[0]),
        quad((-x, y, z), (x, y, z), (-x, -y, z), (x, -y, z), parts[1]),
        quad((x, y, 0), (-x, y, 0), (x, -y, 0), (-x, -y, 0), parts[2]),
    )


def mesh(positions, triangles, uv, normals, part):
    """A surface of one part; the arrays may have any shape whose last axis is the vector."""
    return {
        "positions": positions.reshape(-1, 3).astype(np.float32),
        "triangles": triangles,
        "uv": uv.reshape(-1, 2).astype(np.float32),
        "normals": normals.reshape(-1, 3).astype(np.float32),
        "parts": np.full(len(triangles), part, np.int32),
    }


def tube(points, radii, sides=8, part=0):
    """A tube along points, for branches, poles, wheels and cables."""
    points = np.asarray(points, np.float64)
    radii = np.broadcast_to(radii, len(points))
    along = np.gradient(points, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    helper = np.where(np.abs(along[:, 2:3]) < 0.9, [[0, 0, 1.0]], [[1.0, 0, 0]])
    a = np.cross(along, helper)
    a /= np.maximum(np.linalg.norm(a, axis=1, keepdims=True), 1e-12)
    b = np.cross(along, a)
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    ring = a[:, None] * np.cos(angle)[None, :, None] + b[:, None] * np.sin(angle)[None, :, None]
    p = points[:, None] + ring * radii[:, None, None]
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    uv = np.stack(np.meshgrid(angle / (2 * np.pi), length), -1)
    triangles = grid(sides, len(points) - 1)
    return mesh(p, triangles, uv, ring, part)


def lathe(profile, sides=32, part=0):
    """Turns a profile of (radius, z) about the z axis: bottles, vases, bowls, balls, lamps."""
    profile = np.asarray(profile, np.float64)
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    p = np.stack(
        [
            profile[:, :1] * np.cos(angle),
            profile[:, :1] * np.sin(angle),
            np.broadcast_to(profile[:, 1:], (len(profile), sides + 1)),
        ],
        -1,
    )
    slope = np.gradient(profile, axis=0)
    n2 = np.stack([slope[:, 1], -slope[:, 0]], 1)
    n2 /= np.maximum(np.linalg.norm(n2, axis=1, keepdims=True), 1e-12)
    n = np.stack(
        [
            n2[:, :1] * np.cos(angle),
            n2[:, :1] * np.sin(angle),
            np.broadcast_to(n2[:, 1:], (len(profile), sides + 1)),
        ],
        -1,
    )
    v = np.linspace(1, 0, len(profile))
    uv = np.stack(np.meshgrid(angle / (2 * np.pi), v), -1)
    triangles = grid(sides, len(profile) - 1)
    return mesh(p, triangles, uv, n, part)


def ball(radius=1.0, sides=32):
    t = np.linspace(-np.pi / 2, np.pi / 2, sides // 2 + 1)
    return lathe(np.stack([np.cos(t) * radius, np.sin(t) * radius + radius], 1), sides)


def height_field(z, size):
    """A square of `size` metres around the origin with the heights z (n x n)."""
    n = z.shape[0]
    x, y = np.meshgrid(np.linspace(-size / 2, size / 2, n), np.linspace(-size / 2, size / 2, n))
    p = np.stack([x, y, z], -1).reshape(-1, 3).astype(np.float32)
    gy, gx = np.gradient(z, size / (n - 1))
    normal = np.stack([-gx, -gy, np.ones_like(z)], -1).reshape(-1, 3)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return {
        "positions": p,
        "triangles": grid(n - 1, n - 1),
        "uv": p[:, :2].copy(),
        "normals": normal.astype(np.float32),
        "parts": None,
    }
