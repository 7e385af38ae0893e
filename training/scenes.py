"""What the frames show. Each function composes one scene from a random generator and the assets."""

import cv2
import numpy as np

import photos
import shapes
from render import (NO_SHADOW, PANORAMA, SKY, SOLID, TRANSPARENT, UNLIT, UV, Scene, View, camera_axes, material, place)

FORMATS = [(384, 384), (384, 288), (288, 384), (384, 256), (256, 384), (384, 216), (216, 384)]
FORMAT_SHARES = [0.15, 0.27, 0.15, 0.15, 0.08, 0.14, 0.06]


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(max(high, low)))))


def pick(rng, things):
    return things[int(rng.integers(len(things)))]


class Stage:
    """A scene with its camera, and what all kinds of scenes do."""

    def __init__(self, rng, assets):
        self.rng, self.assets, self.scene = rng, assets, Scene(assets.renderer)
        v = self.view = View()
        v.width, v.height = FORMATS[rng.choice(len(FORMATS), p=FORMAT_SHARES)]
        v.samples, v.seed = 2, int(rng.integers(1 << 31))
        v.centre[:] = [v.width / 2, v.height / 2]
        v.exposure, v.lightScale, v.ambientReach, v.sunSize = 1, 1, 1e6, 0.03
        v.sun[:] = [0, 0, 1]
        self.panorama = None

    def camera(self, position, yaw, pitch, roll=None, angle=None):
        """angle: of the longer side, radians."""
        rng, v = self.rng, self.view
        roll = rng.normal(0, np.radians(2.5)) if roll is None else roll
        if angle is None:
            angle = np.radians(rng.triangular(22, 60, 92))
        v.focal = 384 / 2 / np.tan(angle / 2)
        self.position, self.yaw = np.array(position, float), yaw
        self.axes = camera_axes(yaw, pitch, roll)
        v.position[:] = list(position)
        v.axes[:] = list(self.axes.ravel())

    def light(self, panorama, turn=0.0, sun=None):
        """Light from a panorama. sun: its strength, or None as the panorama has it."""
        rng, v = self.rng, self.view
        self.panorama = panorama
        v.background, v.turn = panorama.id, turn
        c, s = np.cos(turn), np.sin(turn)
        d = panorama.sun
        direction = np.array([c * d[0] - s * d[1], s * d[0] + c * d[1], d[2]])
        colour = panorama.sun_colour
        if sun is not None:
            direction[2] = max(direction[2], 0.15)
            if rng.random() < 0.4:
                direction = np.array([*rng.normal(0, 1, 2), rng.uniform(0.3, 1.5)])
            colour = sun * np.array([1.0, rng.uniform(0.82, 0.97), rng.uniform(0.6, 0.92)])
        v.sun[:] = list(direction / np.linalg.norm(direction))
        v.sunColour[:] = list(colour)
        v.sunSize = log_uniform(rng, 0.01, 0.2)

    def project(self, point):
        """Pixel and distance along the axis of a point."""
        p = self.axes @ (np.asarray(point) - self.position)
        v = self.view
        return v.centre[0] + v.focal * p[0] / p[2], v.centre[1] + v.focal * p[1] / p[2], p[2]

    def ray(self, x, y):
        v = self.view
        d = self.axes[0] * (x - v.centre[0]) / v.focal + self.axes[1] * (y - v.centre[1]) / v.focal + self.axes[2]
        return d / np.linalg.norm(d)

    def spot(self, near, far, ground=0.0, margin=0.0):
        """A random point on the ground that the camera sees in its width, between two distances."""
        rng, v = self.rng, self.view
        x = rng.uniform(-margin * v.width, (1 + margin) * v.width)
        d = self.ray(x, v.height / 2)[:2]
        d = d / np.linalg.norm(d)
        r = log_uniform(rng, near, far)
        return np.array([*(self.position[:2] + d * r), ground])

    def toward_camera(self, point):
        c = self.position[:2] - np.asarray(point)[:2]
        return np.arctan2(c[0], -c[1])

    def billboard(self, cutout, position, height, lean=0.0, gain=None):
        """A cut-out that stands at `position`, turned to the camera."""
        rng = self.rng
        if gain is None:
            gain = (0.2 / (cutout.brightness + 0.02)) ** rng.uniform(0, 0.6) * log_uniform(rng, 0.7, 1.5)
        flip = -1 if rng.random() < 0.5 else 1
        tint = gain * np.exp(rng.normal(0, 0.06, 3))
        self.scene.add(cutout.model, place(position, self.toward_camera(position), (height * flip, height, height), lean),
                       [material(tint, cutout.texture, paint=UNLIT, flags=TRANSPARENT)], "cutout")

    def surface(self, kind=None, scale=None, paint=SOLID, dull=False):
        """A random material: a photo of a surface, a whole photo, a pattern or plain colour."""
        rng, a = self.rng, self.assets
        gloss = rng.choice([0, 0.03, 0.15, 0.6], p=[0.55, 0.2, 0.15, 0.1])
        sharp = log_uniform(rng, 5, 120)
        colour = rng.uniform(0.15, 0.95, 3) ** 1.3
        if rng.random() < 0.5:
            colour = colour * 0.35 + colour.mean() * 0.65
        if kind is None:
            kind = rng.choice(["stuff", "photo", "pattern", "plain"], p=[0.42, 0.18, 0.22, 0.18])
        scale = log_uniform(rng, 0.4, 3) if scale is None else scale
        if kind == "plain" or (dull and rng.random() < 0.4):
            detail = pick(rng, a.stuff)
            return material(colour * 0.8, paint=paint, gloss=gloss, sharpness=sharp, detail=detail, detail_scale=scale * 2,
                            detail_strength=rng.uniform(0, 0.25))
        texture = {"stuff": a.stuff, "photo": a.whole, "pattern": a.patterns}[kind]
        tint = np.ones(3) * rng.uniform(0.7, 1.2) if rng.random() < 0.6 else colour * 1.6
        return material(np.minimum(tint, 1.6), pick(rng, texture), scale=scale, paint=paint, gloss=gloss, sharpness=sharp)

    def finish(self):
        colour, inverse, which = self.scene.render(self.view, self.panorama.soft)
        return colour, inverse, which


# ---------------------------------------------------------------- things that many scenes share


def add_thin(stage, kind=None, distance=None, ground=0.0):
    """Fence, railing, branches, poles or cables between the camera and the rest."""
    rng = stage.rng
    kind = kind or pick(rng, ["fence", "pole", "branch", "branch", "grass", "wheel", "mesh"])
    distance = distance or log_uniform(rng, 0.6, 6)
    look = stage.surface("plain" if rng.random() < 0.5 else None)
    d = stage.axes[2] * [1, 1, 0]
    d = d / np.linalg.norm(d)
    centre = stage.position * [1, 1, 0] + d * distance
    turn = stage.toward_camera(centre) + rng.normal(0, 0.5)
    if kind in ("fence", "mesh"):
        height, length = stage.position[2] * rng.uniform(0.4, 1.25), distance * 3
        thick = rng.uniform(0.006, 0.03)
        step = log_uniform(rng, 0.06, 0.3)
        bars = [shapes.tube([(x, 0, 0), (x, 0, height)], thick, 5) for x in np.arange(-length / 2, length / 2, step)]
        levels = [0.12 * height, 0.95 * height] if kind == "fence" else np.arange(0.1, height, step)
        bars += [shapes.tube([(-length / 2, 0, z), (length / 2, 0, z)], thick * 1.3, 5) for z in levels]
        stage.scene.add_mesh(shapes.join(*bars), place([*centre[:2], ground], turn), [look], "thin")
    elif kind == "pole":
        for _ in range(rng.integers(1, 4)):
            p = stage.spot(distance, distance * 4, ground)
            mesh = shapes.tube([(0, 0, 0), (0, 0, rng.uniform(1, 7))], log_uniform(rng, 0.015, 0.1), 10)
            stage.scene.add_mesh(mesh, place(p, 0, 1, rng.normal(0, 0.03)), [look], "thin")
    elif kind == "wheel":
        r = rng.uniform(0.2, 0.4)
        a = np.linspace(0, 2 * np.pi, 33)
        parts = [shapes.tube(np.stack([np.cos(a) * r, a * 0, np.sin(a) * r + r], 1), 0.02, 6)]
        for t in np.linspace(0, 2 * np.pi, rng.integers(8, 24), endpoint=False):
            parts.append(shapes.tube([(0, 0, r), (np.cos(t) * r, 0, np.sin(t) * r + r)], 0.004, 4))
        for _ in range(rng.integers(1, 3)):
            stage.scene.add_mesh(shapes.join(*parts), place(stage.spot(distance, distance * 2, ground), rng.uniform(0, 6)),
                                 [look], "thin")
    elif kind == "grass":
        blades = []
        for _ in range(rng.integers(20, 120)):
            p = stage.spot(distance * 0.5, distance * 1.5, ground)
            bend, height = rng.normal(0, 0.1, 2), rng.uniform(0.15, 0.6) * min(1.0, stage.position[2])
            t = np.linspace(0, 1, 5)[:, None]
            line = p + t * [0, 0, height] + t ** 2 * [*bend, 0]
            blades.append(shapes.tube(line, 0.006 * (1.05 - t[:, 0]), 3))
        stage.scene.add_mesh(shapes.join(*blades), place(),
                             [material(np.array([0.12, 0.3, 0.06]) * rng.uniform(0.5, 1.6, 3), gloss=0.03)], "thin")
    else:
        add_branch(stage, centre + [0, 0, stage.position[2] + rng.uniform(-0.3, 0.5) * distance], distance, look)


def branch_mesh(rng, length, leaves=True):
    """A branch that divides, with leaves: part 0 is wood, part 1 leaf."""
    wood, leaf = [], []

    def grow(p, d, l, r, depth):
        n = 5
        line = [p]
        for _ in range(n):
            d = d + rng.normal(0, 0.18, 3)
            d = d / np.linalg.norm(d)
            line.append(line[-1] + d * l / n)
        wood.append(shapes.tube(line, np.linspace(r, r * 0.6, n + 1), 5))
        if depth == 0:
            if leaves:
                for q in line[1:]:
                    for _ in range(2):
                        leaf.append((q, rng.normal(0, 1, 3), rng.normal(0, 1, 3)))
            return
        for _ in range(rng.integers(2, 4)):
            k = rng.integers(2, n + 1)
            e = d + rng.normal(0, 0.6, 3)
            grow(line[k], e / np.linalg.norm(e), l * rng.uniform(0.5, 0.8), r * 0.55, depth - 1)

    d = rng.normal(0, 1, 3) * [1, 1, 0.4]
    grow(np.zeros(3), d / np.linalg.norm(d), length, length * rng.uniform(0.01, 0.03), int(rng.integers(2, 4)))
    meshes = wood
    if leaf:
        size = length * rng.uniform(0.04, 0.12)
        for q, a, b in leaf:
            a = a / np.linalg.norm(a)
            b = np.cross(a, b)
            b = b / max(np.linalg.norm(b), 1e-9)
            m = shapes.quad(q, q + a * size * 0.5 + b * size * 0.25, q + a * size * 0.5 - b * size * 0.25, q + a * size, 1)
            meshes.append(m)
    return shapes.join(*meshes)


def add_branch(stage, point, distance, look):
    rng = stage.rng
    for _ in range(rng.integers(1, 4)):
        mesh = branch_mesh(rng, distance * rng.uniform(0.3, 0.9), rng.random() < 0.8)
        side = stage.axes[0] * rng.uniform(-0.6, 0.6) * distance + stage.axes[1] * rng.uniform(-0.5, 0.3) * distance
        green = np.array([rng.uniform(0.08, 0.4), rng.uniform(0.15, 0.45), rng.uniform(0.03, 0.12)])
        stage.scene.add_mesh(mesh, place(point + side),
                             [material(np.array([0.18, 0.12, 0.07]) * rng.uniform(0.4, 1.5)), material(green, gloss=0.05)], "thin")


def add_block(stage, position, size, turn=None):
    """A box with different surfaces, or another simple body, standing at `position`."""
    rng = stage.rng
    turn = rng.uniform(0, 2 * np.pi) if turn is None else turn
    kind = rng.choice(["box", "ball", "lathe", "tube"], p=[0.5, 0.12, 0.25, 0.13])
    paint = UV if rng.random() < 0.6 else SOLID
    scale = 1.0 if paint == UV else log_uniform(rng, 0.5, 2) / max(size)
    looks = [stage.surface(paint=paint, scale=scale) for _ in range(3)]
    if kind == "box":
        mesh = shapes.box(size, (0, 1, 2))
    elif kind == "ball":
        mesh = shapes.ball(min(size) / 2)
    elif kind == "tube":
        mesh = shapes.lathe([(0.001, 0), (size[0] / 2, 0), (size[0] / 2, size[2]), (0.001, size[2])])
    else:
        z = np.linspace(0, 1, 12)
        r = np.interp(z, np.linspace(0, 1, 5), rng.uniform(0.25, 1, 5)) * min(size[:2]) / 2
        mesh = shapes.lathe(np.concatenate([[(0.001, 0)], np.stack([r, z * size[2]], 1), [(0.001, size[2])]]))
    stage.scene.add_mesh(mesh, place(position, turn), looks, "block")


def add_board(stage, position, width, height, turn, look=None, tilt=0.0):
    """A thin upright board with a photo: a poster, a picture, a sign."""
    look = look or material(np.ones(3) * stage.rng.uniform(0.6, 1.1), pick(stage.rng, stage.assets.whole))
    stage.scene.add_mesh(shapes.box((width, 0.03, height)), place(position, turn, 1, tilt), [look], "board")


def add_cutouts(stage, count, near, far, ground=0.0, where="ground"):
    """Cut-outs that stand on the ground where the camera sees them."""
    rng, v = stage.rng, stage.view
    choice = stage.assets.standing if where == "ground" else stage.assets.small
    same = pick(rng, choice) if rng.random() < 0.2 else None  # a herd, a crowd
    for _ in range(count):
        c = pick(rng, choice)
        if same is not None:
            alike = [x for x in choice if x.category == same.category]
            c = pick(rng, alike)
        low, high, _ = photos.SIZES[c.category]
        size = rng.uniform(low, high)
        p = stage.spot(max(near, size * v.focal / (v.height * 1.6)), max(far, near * 1.5), ground)
        stage.billboard(c, p, size, rng.normal(0, 0.02))


def add_close_up(stage, distance=None):
    """A person, animal or thing close to the camera, cut by the lower edge of the frame."""
    rng, v = stage.rng, stage.view
    c = pick(rng, stage.assets.busts if rng.random() < 0.75 else stage.assets.standing)
    low, high, _ = photos.SIZES[c.category]
    size = rng.uniform(0.55, 0.9) if c.category == "person" else rng.uniform(low, high) * 0.7
    wide = rng.uniform(0.3, 0.9) * v.width
    r = distance or max(0.25, v.focal * size * max(c.aspect, 0.4) / wide)
    tall = size * v.focal / r
    top = rng.uniform(0.02, 0.45) * v.height
    bottom = max(top + tall, v.height * rng.uniform(1.0, 1.15))
    x = v.width * (rng.uniform(0.2, 0.8) if rng.random() < 0.75 else rng.choice([0.05, 0.95]))
    ray = stage.ray(x, bottom)
    p = stage.position + ray * r / (ray @ stage.axes[2])
    stage.billboard(c, p, size, 0.0)


# ---------------------------------------------------------------- families


def panorama_scene(rng, assets, kind=None):
    """A photo of a place: the floor is a plane, the backdrop stands where its foot is. Things stand on it."""
    stage = Stage(rng, assets)
    pano = pick(rng, assets.places)
    h0 = rng.uniform(1.2, 1.8)
    polygon = pano.floor_polygon(h0)
    reach = np.linalg.norm(polygon, axis=1)
    indoor = "up" in pano.facts
    stage.light(pano)
    if pano.sun_colour.sum() < 0.3 and not indoor and rng.random() < 0.6:
        stage.view.sunColour[:] = [0.5, 0.45, 0.4]
    stage.view.ambientReach = 2.0
    offset = rng.normal(0, 0.12, 2) * min(reach.min(), 6)
    close = kind == "close"
    yaw = pano.azimuth(rng)
    angle = np.radians(rng.triangular(35, 70, 95))
    pitch = np.radians(np.clip(rng.normal(-8, 11), -45, 18))
    height = h0 * (rng.uniform(0.5, 1.15) if rng.random() < 0.8 else rng.uniform(0.2, 0.5))
    stage.camera([*offset, height], yaw, pitch, angle=angle)
    stage.view.projector[:] = [0, 0, h0]
    gain = stage.view.exposure = rng.uniform(0.6, 1.6)
    stage.view.lightScale = gain
    detail = dict(detail=pick(rng, assets.ground), detail_scale=log_uniform(rng, 0.3, 2), detail_strength=rng.uniform(0, 0.6))
    n = len(polygon)
    floor = {"positions": np.vstack([[[0, 0, 0]], np.column_stack([polygon, np.zeros(n)])]).astype(np.float32),
             "triangles": np.array([[0, 1 + k, 1 + (k + 1) % n] for k in range(n)]),
             "normals": np.tile([0, 0, 1.0], (n + 1, 1)), "uv": None}
    stage.scene.add_mesh(floor, place(), [material(paint=PANORAMA, **detail)], "floor")
    top = h0 * (1 + pano.facts["up"]) if indoor else reach.max() * 3
    walls = [shapes.quad([*polygon[k], top], [*polygon[(k + 1) % n], top], [*polygon[k], 0], [*polygon[(k + 1) % n], 0])
             for k in range(n)]
    stage.scene.add_mesh(shapes.join(*walls), place(), [material(paint=PANORAMA, flags=NO_SHADOW)], "wall")
    if indoor:
        lid = dict(floor, positions=floor["positions"] + [0, 0, top])
        stage.scene.add_mesh(lid, place(), [material(paint=PANORAMA, flags=NO_SHADOW)], "lid")
    far = float(np.clip(np.median(reach) * 0.8, 3, 40))
    if close:
        for _ in range(rng.choice([1, 1, 2])):
            add_close_up(stage)
    count = int(rng.choice([0, 1, 2, 3, 5, 9], p=[0.08, 0.24, 0.26, 0.2, 0.14, 0.08]))
    add_cutouts(stage, count, 1.5, far)
    for _ in range(rng.choice([0, 1, 3], p=[0.6, 0.3, 0.1])):
        add_block(stage, stage.spot(1.5, far * 0.6), rng.uniform(0.25, 1.4, 3))
    if rng.random() < 0.12:
        p = stage.spot(2, far * 0.6)
        w = rng.uniform(0.6, 2)
        add_board(stage, p, w, w * rng.uniform(0.6, 1.5), stage.toward_camera(p) + rng.normal(0, 0.6))
    if rng.random() < 0.15:
        add_thin(stage)
    colour, inverse, which = stage.finish()
    sky_from_panorama(stage, pano, h0, inverse, which)
    return colour, inverse


def sky_from_panorama(stage, pano, h0, inverse, which):
    """Where the backdrop shows the sky of the panorama, depth is infinite."""
    if not pano.sky.any():
        return
    v = stage.view
    y, x = np.mgrid[0:v.height, 0:v.width] + 0.5
    d = (((x - v.centre[0]) / v.focal)[..., None] * stage.axes[0] + ((y - v.centre[1]) / v.focal)[..., None] * stage.axes[1]
         + stage.axes[2])
    p = stage.position + d / np.maximum(inverse, 1e-6)[..., None] - [0, 0, h0]
    p = p / np.linalg.norm(p, axis=-1, keepdims=True)
    u = (np.arctan2(-p[..., 1], p[..., 0]) / (2 * np.pi)) % 1
    t = np.arccos(np.clip(p[..., 2], -1, 1)) / np.pi
    sky = pano.sky[np.minimum((t * 1024).astype(int), 1023), np.minimum((u * 2048).astype(int), 2047)]
    backdrop = np.array([tag == "wall" for tag in stage.scene.tags] + [True])
    inverse[sky & backdrop[which]] = 0


def close_scene(rng, assets):
    return panorama_scene(rng, assets, "close")


FAMILIES = {"panorama": panorama_scene, "close": close_scene}
MIX = {"panorama": 3, "close": 1}
