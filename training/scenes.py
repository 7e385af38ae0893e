"""What the frames show. Each function composes one scene from a random generator and the assets."""

import cv2
import numpy as np

import photos
import shapes
from render import (
    NO_SHADOW,
    PANORAMA,
    SKY,
    SOLID,
    TRANSPARENT,
    UNLIT,
    UV,
    Scene,
    View,
    camera_axes,
    material,
    place,
)

LONGER = 288  # px; training crops 160 to 256
FORMATS = [(1, 1), (1, 3 / 4), (3 / 4, 1), (1, 2 / 3), (2 / 3, 1), (1, 9 / 16), (9 / 16, 1)]
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
        v.width, v.height = (
            round(LONGER * side) for side in FORMATS[rng.choice(len(FORMATS), p=FORMAT_SHARES)]
        )
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
        v.focal = LONGER / 2 / np.tan(angle / 2)
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
        d = (
            self.axes[0] * (x - v.centre[0]) / v.focal
            + self.axes[1] * (y - v.centre[1]) / v.focal
            + self.axes[2]
        )
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
            gain = (0.2 / (cutout.brightness + 0.02)) ** rng.uniform(0, 0.6) * log_uniform(
                rng, 0.7, 1.5
            )
        flip = -1 if rng.random() < 0.5 else 1
        tint = gain * np.exp(rng.normal(0, 0.06, 3))
        self.scene.add(
            cutout.model,
            place(position, self.toward_camera(position), (height * flip, height, height), lean),
            [material(tint, cutout.texture, paint=UNLIT, flags=TRANSPARENT)],
            "cutout",
        )

    def surface(self, kind=None, scale=None, paint=SOLID, dull=False):
        """A random material: a photo of a surface, a whole photo, a pattern or plain colour."""
        rng, a = self.rng, self.assets
        gloss = rng.choice([0, 0.03, 0.15, 0.6], p=[0.55, 0.2, 0.15, 0.1])
        sharp = log_uniform(rng, 5, 120)
        colour = rng.uniform(0.15, 0.95, 3) ** 1.3
        if rng.random() < 0.5:
            colour = colour * 0.35 + colour.mean() * 0.65
        if kind is None:
            kind = rng.choice(["stuff", "photo", "pattern", "plain"], p=[0.45, 0.18, 0.15, 0.22])
        scale = log_uniform(rng, 0.4, 3) if scale is None else scale
        if kind == "plain" or (dull and rng.random() < 0.4):
            detail = pick(rng, a.stuff)
            return material(
                colour * 0.8,
                paint=paint,
                gloss=gloss,
                sharpness=sharp,
                detail=detail,
                detail_scale=scale * 2,
                detail_strength=rng.uniform(0, 0.25),
            )
        texture = {"stuff": a.stuff, "photo": a.whole, "pattern": a.patterns}[kind]
        tint = np.ones(3) * rng.uniform(0.7, 1.2) if rng.random() < 0.6 else colour * 1.6
        return material(
            np.minimum(tint, 1.6),
            pick(rng, texture),
            scale=scale,
            paint=paint,
            gloss=gloss,
            sharpness=sharp,
        )

    def probe(self):
        """A coarse look: inverse depth and what is seen, to refuse a bad view cheaply."""
        small = View.from_buffer_copy(self.view)
        small.width, small.height, small.samples = self.view.width // 12, self.view.height // 12, 1
        small.focal = self.view.focal / 12
        small.centre[:] = [small.width / 2, small.height / 2]
        _, inverse, which = self.scene.render(small, self.panorama.soft, last=False)
        return inverse, which

    def finish(self):
        seen, which = self.probe()
        if (which >= 0).all() and np.percentile(seen, 96) < 1.4 * np.percentile(seen, 4):
            raise ValueError("all is equally far")
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
        bars = [
            shapes.tube([(x, 0, 0), (x, 0, height)], thick, 5)
            for x in np.arange(-length / 2, length / 2, step)
        ]
        levels = [0.12 * height, 0.95 * height] if kind == "fence" else np.arange(0.1, height, step)
        bars += [
            shapes.tube([(-length / 2, 0, z), (length / 2, 0, z)], thick * 1.3, 5) for z in levels
        ]
        stage.scene.add_mesh(shapes.join(*bars), place([*centre[:2], ground], turn), [look], "thin")
    elif kind == "pole":
        for _ in range(rng.integers(1, 4)):
            p = stage.spot(distance, distance * 4, ground)
            mesh = shapes.tube(
                [(0, 0, 0), (0, 0, rng.uniform(1, 7))], log_uniform(rng, 0.015, 0.1), 10
            )
            stage.scene.add_mesh(mesh, place(p, 0, 1, rng.normal(0, 0.03)), [look], "thin")
    elif kind == "wheel":
        r = rng.uniform(0.2, 0.4)
        a = np.linspace(0, 2 * np.pi, 33)
        parts = [shapes.tube(np.stack([np.cos(a) * r, a * 0, np.sin(a) * r + r], 1), 0.02, 6)]
        for t in np.linspace(0, 2 * np.pi, rng.integers(8, 24), endpoint=False):
            parts.append(shapes.tube([(0, 0, r), (np.cos(t) * r, 0, np.sin(t) * r + r)], 0.004, 4))
        for _ in range(rng.integers(1, 3)):
            stage.scene.add_mesh(
                shapes.join(*parts),
                place(stage.spot(distance, distance * 2, ground), rng.uniform(0, 6)),
                [look],
                "thin",
            )
    elif kind == "grass":
        blades = []
        for _ in range(rng.integers(20, 120)):
            p = stage.spot(distance * 0.5, distance * 1.5, ground)
            bend, height = rng.normal(0, 0.1, 2), rng.uniform(0.15, 0.6) * min(
                1.0, stage.position[2]
            )
            t = np.linspace(0, 1, 5)[:, None]
            line = p + t * [0, 0, height] + t**2 * [*bend, 0]
            blades.append(shapes.tube(line, 0.006 * (1.05 - t[:, 0]), 3))
        stage.scene.add_mesh(
            shapes.join(*blades),
            place(),
            [material(np.array([0.12, 0.3, 0.06]) * rng.uniform(0.5, 1.6, 3), gloss=0.03)],
            "thin",
        )
    else:
        add_branch(
            stage,
            centre + [0, 0, stage.position[2] + rng.uniform(-0.3, 0.5) * distance],
            distance,
            look,
        )


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
    grow(
        np.zeros(3),
        d / np.linalg.norm(d),
        length,
        length * rng.uniform(0.01, 0.03),
        int(rng.integers(2, 4)),
    )
    meshes = wood
    if leaf:
        size = length * rng.uniform(0.04, 0.12)
        for q, a, b in leaf:
            a = a / np.linalg.norm(a)
            b = np.cross(a, b)
            b = b / max(np.linalg.norm(b), 1e-9)
            m = shapes.quad(
                q,
                q + a * size * 0.5 + b * size * 0.25,
                q + a * size * 0.5 - b * size * 0.25,
                q + a * size,
                1,
            )
            meshes.append(m)
    return shapes.join(*meshes)


def flower_mesh(rng, height):
    """A flower: stem and leaves are part 0, petals part 1, the middle part 2."""
    top = np.array([*rng.normal(0, 0.12 * height, 2), height])
    t = np.linspace(0, 1, 7)[:, None]
    meshes = [shapes.tube(t * [0, 0, height] + t**2 * [*top[:2], 0], height * 0.012, 5)]
    size = height * rng.uniform(0.12, 0.35)
    facing = rng.normal(0, 0.5, 3) + [0, 0, 0.7]
    facing = facing / np.linalg.norm(facing)
    a = np.cross(facing, [1.0, 0.2, 0.1])
    a = a / np.linalg.norm(a)
    b = np.cross(facing, a)
    count, cup = int(rng.integers(5, 22)), rng.uniform(-0.2, 0.9)
    for k in range(count):
        q = 2 * np.pi * k / count + rng.normal(0, 0.08)
        out, side = a * np.cos(q) + b * np.sin(q), b * np.cos(q) - a * np.sin(q)
        wide = size * rng.uniform(0.9, 1.6) * np.pi / count
        lift = facing * cup * size * (0.5 + 0.5 * (k % 2))
        tip = top + out * size + lift
        half = top + out * size * 0.6 + lift * 0.45
        meshes.append(shapes.quad(top, half + side * wide, half - side * wide, tip, 1))
    middle = shapes.ball(size * 0.2, 12)
    middle["positions"] = middle["positions"] + (top - [0, 0, size * 0.2]).astype(np.float32)
    meshes.append(dict(middle, parts=np.full(len(middle["triangles"]), 2)))
    for _ in range(rng.integers(0, 6)):
        p = np.array([*(top[:2] * 0.3), height * rng.uniform(0.1, 0.7)])
        d = rng.normal(0, 1, 3) * [1, 1, 0.4]
        d = d / np.linalg.norm(d) * height * rng.uniform(0.15, 0.4)
        side = np.cross(d, [0, 0, 1.0]) * rng.uniform(0.1, 0.25)
        meshes.append(shapes.quad(p, p + d * 0.5 + side, p + d * 0.5 - side, p + d, 0))
    return shapes.join(*meshes)


def add_flowers(stage, count, near, far):
    """Flowers of one kind or many, at heights where the camera sees them."""
    rng = stage.rng
    colours = rng.random((3, 3)) ** 0.7
    green = np.array([rng.uniform(0.05, 0.25), rng.uniform(0.15, 0.4), rng.uniform(0.02, 0.1)])
    for _ in range(count):
        r = log_uniform(rng, near, far)
        ray = stage.ray(rng.uniform(0, stage.view.width), rng.uniform(0.1, 1.0) * stage.view.height)
        head = stage.position + ray * r
        height = max(r * rng.uniform(0.3, 0.9), 0.05)
        looks = [
            material(
                green * rng.uniform(0.7, 1.4),
                detail=stage.assets.any_stuff(rng),
                detail_scale=3 / height,
                detail_strength=0.3,
            ),
            material(
                pick(rng, colours),
                detail=stage.assets.any_stuff(rng),
                detail_scale=3 / height,
                detail_strength=rng.uniform(0, 0.4),
            ),
            material([rng.uniform(0.3, 0.9), rng.uniform(0.2, 0.6), 0.05]),
        ]
        stage.scene.add_mesh(
            flower_mesh(rng, height),
            place(head - [0, 0, height], rng.uniform(0, 6.28)),
            looks,
            "flower",
        )


def add_branch(stage, point, distance, look):
    rng = stage.rng
    for _ in range(rng.integers(1, 4)):
        mesh = branch_mesh(rng, distance * rng.uniform(0.3, 0.9), rng.random() < 0.8)
        side = (
            stage.axes[0] * rng.uniform(-0.6, 0.6) * distance
            + stage.axes[1] * rng.uniform(-0.5, 0.3) * distance
        )
        green = np.array([rng.uniform(0.08, 0.4), rng.uniform(0.15, 0.45), rng.uniform(0.03, 0.12)])
        stage.scene.add_mesh(
            mesh,
            place(point + side),
            [
                material(np.array([0.18, 0.12, 0.07]) * rng.uniform(0.4, 1.5)),
                material(
                    green,
                    gloss=0.05,
                    detail=stage.assets.any_stuff(rng),
                    detail_scale=6 / distance,
                    detail_strength=0.4,
                ),
            ],
            "thin",
        )


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
        mesh = shapes.lathe(
            [(0.001, 0), (size[0] / 2, 0), (size[0] / 2, size[2]), (0.001, size[2])]
        )
    else:
        z = np.linspace(0, 1, 12)
        r = np.interp(z, np.linspace(0, 1, 5), rng.uniform(0.25, 1, 5)) * min(size[:2]) / 2
        mesh = shapes.lathe(
            np.concatenate([[(0.001, 0)], np.stack([r, z * size[2]], 1), [(0.001, size[2])]])
        )
    stage.scene.add_mesh(mesh, place(position, turn), looks, "block")


def add_board(stage, position, width, height, turn, look=None, tilt=0.0):
    """A thin upright board with a photo: a poster, a picture, a sign."""
    look = look or material(
        np.ones(3) * stage.rng.uniform(0.6, 1.1), pick(stage.rng, stage.assets.whole)
    )
    stage.scene.add_mesh(
        shapes.box((width, 0.03, height)), place(position, turn, 1, tilt), [look], "board"
    )


def add_cutouts(stage, count, near, far, ground=0.0, where="ground"):
    """Cut-outs that stand on the ground where the camera sees them."""
    rng, v = stage.rng, stage.view
    choice = stage.assets.standing if where == "ground" else stage.assets.small
    same = pick(rng, choice) if rng.random() < 0.2 else None  # a herd, a crowd
    for _ in range(count):
        if where == "ground" and rng.random() < 0.35:  # a model instead
            put(
                stage,
                pick(rng, ["person", "person", "animal", "chair", "low", "street"]),
                stage.spot(max(near, 2), max(far, 3), ground),
            )
            continue
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
    if rng.random() < 0.3:  # a model
        model = stage.assets.library.get(rng, pick(rng, ["person", "person", "animal"]))
        if model is None:
            return
        r = rng.uniform(0.7, 2.2)
        ray = stage.ray(rng.uniform(0.15, 0.85) * v.width, v.height * rng.uniform(0.05, 0.35))
        head = stage.position + ray * r / (ray @ stage.axes[2])
        p = [*head[:2], head[2] - model.size[2]]
        turn = stage.toward_camera(p) + rng.normal(0, 0.8)
        stage.scene.add(
            model.id, place(p, turn), model.materials(rng, stage.assets, 0.1, 0.1), "close"
        )
        return
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
    """A photo of a place with things: its floor is a plane, its backdrop stands on its foot."""
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
    detail = dict(
        detail=pick(rng, assets.ground),
        detail_scale=log_uniform(rng, 0.3, 2),
        detail_strength=rng.uniform(0, 0.6),
    )
    n = len(polygon)
    floor = {
        "positions": np.vstack([[[0, 0, 0]], np.column_stack([polygon, np.zeros(n)])]).astype(
            np.float32
        ),
        "triangles": np.array([[0, 1 + k, 1 + (k + 1) % n] for k in range(n)]),
        "normals": np.tile([0, 0, 1.0], (n + 1, 1)),
        "uv": None,
    }
    stage.scene.add_mesh(floor, place(), [material(paint=PANORAMA, **detail)], "floor")
    top = h0 * (1 + pano.facts["up"]) if indoor else reach.max() * 3
    walls = [
        shapes.quad(
            [*polygon[k], top],
            [*polygon[(k + 1) % n], top],
            [*polygon[k], 0],
            [*polygon[(k + 1) % n], 0],
        )
        for k in range(n)
    ]
    stage.scene.add_mesh(
        shapes.join(*walls), place(), [material(paint=PANORAMA, flags=NO_SHADOW)], "wall"
    )
    if indoor:
        lid = dict(floor, positions=floor["positions"] + [0, 0, top])
        stage.scene.add_mesh(lid, place(), [material(paint=PANORAMA, flags=NO_SHADOW)], "lid")
    far = float(np.clip(np.median(reach) * 0.8, 3, 40))
    if kind == "macro":
        roll = rng.random()
        if roll < 0.5:
            add_flowers(stage, int(rng.choice([1, 3, 8, 20])), 0.2, 1.2)
        elif roll < 0.75:
            add_branch(
                stage,
                stage.position + stage.axes[2] * rng.uniform(0.4, 1.2),
                rng.uniform(0.4, 1.0),
                stage.surface("stuff"),
            )
        else:
            p = (
                stage.position
                + stage.axes[2] * rng.uniform(0.4, 1.0)
                + stage.axes[1] * rng.uniform(0.05, 0.3)
            )
            small_thing(stage, p, 0.4)
    if close:
        for _ in range(rng.choice([1, 1, 2])):
            add_close_up(stage)
    count = (
        int(rng.choice([0, 0, 1, 3]))
        if kind == "macro"
        else int(rng.choice([0, 1, 2, 3, 5, 9, 25], p=[0.08, 0.24, 0.25, 0.19, 0.12, 0.07, 0.05]))
    )
    add_cutouts(stage, count, 1.5, far)
    for _ in range(rng.choice([0, 1, 3], p=[0.6, 0.3, 0.1])):
        add_block(stage, stage.spot(1.5, far * 0.6), rng.uniform(0.25, 1.4, 3))
    if rng.random() < 0.12:
        p = stage.spot(2, far * 0.6)
        w = rng.uniform(0.6, 2)
        add_board(
            stage, p, w, w * rng.uniform(0.6, 1.5), stage.toward_camera(p) + rng.normal(0, 0.6)
        )
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
    y, x = np.mgrid[0 : v.height, 0 : v.width] + 0.5
    d = (
        ((x - v.centre[0]) / v.focal)[..., None] * stage.axes[0]
        + ((y - v.centre[1]) / v.focal)[..., None] * stage.axes[1]
        + stage.axes[2]
    )
    p = stage.position + d / np.maximum(inverse, 1e-6)[..., None] - [0, 0, h0]
    p = p / np.linalg.norm(p, axis=-1, keepdims=True)
    u = (np.arctan2(-p[..., 1], p[..., 0]) / (2 * np.pi)) % 1
    t = np.arccos(np.clip(p[..., 2], -1, 1)) / np.pi
    sky = pano.sky[
        np.minimum((t * 1024).astype(int), 1023), np.minimum((u * 2048).astype(int), 2047)
    ]
    backdrop = np.array([tag == "wall" for tag in stage.scene.tags] + [True])
    inverse[sky & backdrop[which]] = 0


def close_scene(rng, assets):
    return panorama_scene(rng, assets, "close")


def put(stage, kind, position, turn=None, scale=1.0, wild=0.25, tag=""):
    """A random model of a kind. Returns it, or None."""
    rng = stage.rng
    model = stage.assets.library.get(rng, kind)
    if model is None:
        return None
    turn = rng.uniform(0, 2 * np.pi) if turn is None else turn
    s = scale * (
        rng.uniform(0.88, 1.08) if kind in ("person", "animal", "car") else rng.uniform(0.75, 1.3)
    )
    natural = kind in ("tree", "bush", "rock", "animal", "person")
    looks = model.materials(
        rng, stage.assets, wild * 0.5 if natural else wild, 0.06 if natural else 0.35
    )
    stage.scene.add(model.id, place(position, turn, s), looks, tag or kind)
    return model


def lamps(stage, low, high, count, power):
    """Lamps in a box of space."""
    rng = stage.rng
    for _ in range(count):
        colour = (
            np.array([1.0, rng.uniform(0.75, 1.0), rng.uniform(0.5, 1.0)])
            * power
            * log_uniform(rng, 0.4, 1.6)
        )
        stage.scene.lamps.append([*rng.uniform(low, high), rng.uniform(0.03, 0.4), *colour])


def small_thing(stage, position, limit=0.35):
    """Something that stands on a table."""
    rng = stage.rng
    roll = rng.random()
    if roll < 0.45:
        model = put(stage, "small", position)
        if model is not None:
            return
    if roll < 0.6 and stage.assets.small:
        c = pick(rng, stage.assets.small)
        low, high, _ = photos.SIZES[c.category]
        stage.billboard(c, position, min(rng.uniform(low, high), limit))
        return
    if roll < 0.7:  # books
        z = position[2]
        for _ in range(rng.integers(1, 5)):
            size = rng.uniform([0.1, 0.14, 0.01], [0.2, 0.28, 0.05])
            stage.scene.add_mesh(
                shapes.box(size, (0, 1, 1)),
                place([position[0], position[1], z], rng.uniform(0, 6.28)),
                [stage.surface("plain"), stage.surface("photo", 1.0, UV)],
                "book",
            )
            z += size[2]
        return
    add_block(stage, position, log_uniform(rng, 0.04, limit) * rng.uniform(0.5, 1.2, 3))


def dress_table(stage, model, position, turn, count):
    """Small things on top of a table that stands at `position`."""
    rng = stage.rng
    for _ in range(count):
        x, y = rng.uniform(-0.4, 0.4, 2) * model.size[:2]
        c, s = np.cos(turn), np.sin(turn)
        small_thing(
            stage,
            [position[0] + c * x - s * y, position[1] + s * x + c * y, position[2] + model.size[2]],
        )


def room_pitch(rng):
    """Tilt of a camera in a room: mostly slightly down, at times anything."""
    if rng.random() < 0.2:
        return np.radians(rng.uniform(-65, 40))
    return np.radians(np.clip(rng.normal(-9, 10), -45, 15))


def room_scene(rng, assets):
    """A room with furniture along its walls and in the middle, seen from inside."""
    stage = Stage(rng, assets)
    w, d = rng.uniform(2.6, 9, 2)
    h = rng.uniform(2.2, 3.4)
    stage.light(pick(rng, assets.lights), rng.uniform(0, 2 * np.pi))
    v = stage.view
    v.ambientReach = rng.uniform(0.5, 1.6)
    v.lightScale = rng.uniform(0.15, 0.7)
    # A camera that stands near a wall or corner and looks across.
    q = rng.uniform(0, 2 * np.pi)
    r = rng.uniform(0.55, 0.93)
    at = np.array(
        [np.clip(np.cos(q) * 1.3, -1, 1) * w / 2 * r, np.clip(np.sin(q) * 1.3, -1, 1) * d / 2 * r]
    )
    goal = rng.uniform(-0.3, 0.3, 2) * [w, d]
    yaw = np.arctan2(*(goal - at)[::-1])
    stage.camera(
        [*at, rng.uniform(0.7, min(h - 0.3, 2.0))],
        yaw,
        room_pitch(rng),
        angle=np.radians(rng.triangular(38, 68, 95)),
        roll=rng.normal(0, 0.2) if rng.random() < 0.15 else None,
    )
    lamps(
        stage,
        [-w / 2 + 0.4, -d / 2 + 0.4, h * 0.6],
        [w / 2 - 0.4, d / 2 - 0.4, h - 0.15],
        rng.integers(1, 4),
        3.0,
    )
    wall = stage.surface("plain" if rng.random() < 0.55 else None, 1.0 / rng.uniform(0.8, 4), UV)
    looks = [wall, stage.surface(None, log_uniform(rng, 0.3, 1.2)), stage.surface("plain", 0.5)]
    # Walls as four boards; one may have a window to the panorama outside.
    corners = np.array([[-w, -d], [w, -d], [w, d], [-w, d]]) / 2
    window = rng.integers(8)
    for k in range(4):
        a, b = corners[k], corners[(k + 1) % 4]
        length = np.linalg.norm(b - a)
        turn = np.arctan2(b[1] - a[1], b[0] - a[0])
        one = wall if rng.random() < 0.8 else stage.surface(None, 0.4, UV)

        def board(x0, x1, z0, z1):
            mesh = shapes.quad(
                (x0, 0, z1), (x1, 0, z1), (x0, 0, z0), (x1, 0, z0), 0, (x1 - x0, z1 - z0)
            )
            stage.scene.add_mesh(mesh, place([*a, 0], turn), [one], "wall")

        if window == k:
            x0 = rng.uniform(0.1, 0.5) * length
            x1 = min(x0 + rng.uniform(0.7, 2.5), length - 0.1)
            z0, z1 = rng.uniform(0.0, 1.1), rng.uniform(1.7, h - 0.1)
            board(0, x0, 0, h), board(x1, length, 0, h), board(x0, x1, 0, z0), board(x0, x1, z1, h)
            frame = [shapes.box((0.05, 0.06, z1 - z0)) for _ in range(3)]
            for m, x in zip(frame, (x0, (x0 + x1) / 2, x1)):
                m["positions"] = m["positions"] + np.array([x, 0, z0], np.float32)
            stage.scene.add_mesh(
                shapes.join(*frame), place([*a, 0], turn), [stage.surface("plain")] * 3, "frame"
            )
        else:
            board(0, length, 0, h)
        inward = np.array([-np.sin(turn), np.cos(turn)])
        along = (b - a) / length
        for _ in range(rng.integers(0, 4)):  # pictures
            pw, ph = rng.uniform(0.25, 1.3), rng.uniform(0.25, 1.0)
            p = a + along * rng.uniform(0.1, 0.9) * length + inward * 0.02
            add_board(stage, [*p, rng.uniform(1.0, max(h - ph - 0.1, 1.1))], pw, ph, turn)
        x = rng.uniform(0, 0.6)
        while x < length - 0.8 and rng.random() < 0.85:  # furniture along the wall
            kind = pick(
                rng,
                ["cabinet", "tall", "couch", "low", "table", "plant", "lamp", "cabinet", "curtain"],
            )
            model = assets.library.get(rng, kind)
            if model is None or model.size[:2].max() > 2.8:
                continue
            half = model.size[0] / 2
            p = a + along * (x + half) + inward * (model.size[1] / 2 + 0.03)
            t = turn + (np.pi if rng.random() < 0.5 else 0)
            stage.scene.add(model.id, place([*p, 0], t), model.materials(rng, assets), kind)
            if kind in ("cabinet", "table", "low"):
                dress_table(stage, model, [*p, 0], t, int(rng.integers(0, 4)))
            x += model.size[0] + rng.uniform(0.0, 1.2)
    floor = shapes.quad(
        (-w / 2, d / 2, 0), (w / 2, d / 2, 0), (-w / 2, -d / 2, 0), (w / 2, -d / 2, 0)
    )
    stage.scene.add_mesh(floor, place(), [looks[1]], "floor")
    lid = shapes.quad(
        (-w / 2, d / 2, h), (w / 2, d / 2, h), (-w / 2, -d / 2, h), (w / 2, -d / 2, h)
    )
    stage.scene.add_mesh(lid, place(), [looks[2]], "lid")
    for _ in range(rng.choice([0, 1, 2, 4])):  # the middle
        p = [*(rng.uniform(-0.3, 0.3, 2) * [w, d]), 0]
        kind = pick(rng, ["table", "couch", "chair", "low", "plant", "chair"])
        t = rng.uniform(0, 2 * np.pi)
        model = put(stage, kind, p, t)
        if model is not None and kind == "table":
            dress_table(stage, model, p, t, int(rng.integers(0, 7)))
            for _ in range(rng.integers(0, 5)):
                q = rng.uniform(0, 2 * np.pi)
                r = model.size[:2].max() / 2 + rng.uniform(0.1, 0.4)
                put(stage, "chair", [p[0] + r * np.cos(q), p[1] + r * np.sin(q), 0], q + np.pi / 2)
    if rng.random() < 0.3:
        put(stage, "hanging", [*(rng.uniform(-0.3, 0.3, 2) * [w, d]), h - 0.7])
    if rng.random() < 0.35:
        add_cutouts(stage, int(rng.integers(1, 4)), 1.2, max(w, d) * 0.6)
    if rng.random() < 0.06:
        add_thin(stage, distance=rng.uniform(0.5, 1.5))
    colour, inverse, _ = stage.finish()
    return clear_camera(colour, inverse, 0.15)


def clear_camera(colour, inverse, nearest):
    """Refuses frames that something right before the camera fills."""
    if (inverse > 1 / nearest).mean() > 0.12:
        raise ValueError("something stands before the camera")
    return colour, np.minimum(inverse, 1 / (0.5 * nearest))


def tabletop_scene(rng, assets):
    """A cluttered table before a backdrop, from close by."""
    stage = Stage(rng, assets)
    stage.light(
        pick(rng, assets.lights),
        rng.uniform(0, 2 * np.pi),
        sun=None if rng.random() < 0.6 else log_uniform(rng, 0.3, 2),
    )
    v = stage.view
    v.ambientReach = rng.uniform(0.2, 1.0)
    v.lightScale = rng.uniform(0.3, 1)
    lamps(stage, [-1, -1.5, 0.7], [1, 0.5, 2], int(rng.integers(0, 3)), 1.2)
    w, d = rng.uniform(0.6, 2.2), rng.uniform(0.5, 1.6)
    away = rng.uniform(0.55, 1.5) + d / 2
    pitch = -np.radians(rng.triangular(2, 18, 55) if rng.random() < 0.9 else rng.uniform(55, 85))
    goal = np.array([rng.normal(0, 0.12) * w, rng.normal(0, 0.15) * d, rng.uniform(0.02, 0.3)])
    yaw = np.pi / 2 + rng.normal(0, 0.3)
    back = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), np.sin(pitch)])
    stage.camera(goal - back * away, yaw, pitch, angle=np.radians(rng.triangular(25, 45, 75)))
    top = stage.surface(None, log_uniform(rng, 0.5, 2.5))
    front = (
        rng.uniform(0.8, 2.5) if rng.random() < 0.8 else 0.0
    )  # mostly the table reaches below the frame
    stage.scene.add_mesh(
        shapes.box((w * 3, d + front, 0.05)), place([0, -front / 2, -0.05]), [top], "table"
    )
    rise = (
        rng.uniform(0.2, 0.9) if rng.random() < 0.35 else 0.0
    )  # things stand higher towards the back
    if rng.random() < 0.75:  # what stands behind: walls, boards, a curtain
        for k in range(rng.integers(1, 4)):
            back = d / 2 + rng.uniform(0.0, 0.7) * (1 + k)
            look = stage.surface(
                None, log_uniform(rng, 0.4, 2), SOLID if rng.random() < 0.5 else UV
            )
            x = 0 if k == 0 else rng.uniform(-1, 1)
            width = 8 if k == 0 else rng.uniform(0.4, 1.5)
            height = 4 if k == 0 else rng.uniform(0.3, 1.5)
            turn = rng.normal(0, 0.25) if k else rng.normal(0, 0.12)
            stage.scene.add_mesh(
                shapes.box((width, 0.03, height)),
                place([x, back, -0.6 if k == 0 else 0], turn),
                [look],
                "back",
            )
            if rng.random() < 0.5:
                add_board(
                    stage,
                    [rng.uniform(-0.6, 0.6), back - 0.03, rng.uniform(0.1, 0.6)],
                    rng.uniform(0.2, 0.7),
                    rng.uniform(0.2, 0.7),
                    turn,
                )
        if rng.random() < 0.3:  # a side wall
            side = pick(rng, [-1, 1])
            stage.scene.add_mesh(
                shapes.box((0.03, 4, 3)),
                place([side * w * rng.uniform(0.5, 0.9), 0, -0.5], rng.normal(0, 0.2)),
                [stage.surface(None, 0.6)],
                "side",
            )
    n = int(rng.choice([4, 8, 14, 22, 32]))
    for _ in range(n):
        x, y = rng.uniform(-0.55, 0.55) * w, rng.uniform(-0.48, 0.48) * d
        z = 0.0
        if rng.random() < (0.8 if rise else 0.2):
            base = rng.uniform([0.1, 0.1, 0.05], [0.4, 0.3, 0.3])
            base[2] += rise * (y / d + 0.5) * d
            stage.scene.add_mesh(
                shapes.box(base, (0, 1, 2)),
                place([x, y, 0], rng.uniform(0, 6.28)),
                [stage.surface(paint=UV, scale=1.0) for _ in range(3)],
                "block",
            )
            z = base[2]
        small_thing(stage, [x, y, z], rng.uniform(0.15, 0.5))
    if rng.random() < 0.3:
        put(stage, "plant", [rng.uniform(-0.4, 0.4) * w, rng.uniform(0, 0.4) * d, 0], scale=0.5)
    if rng.random() < 0.35:  # boards that lean, cones, sticks
        for _ in range(rng.integers(1, 5)):
            p = [rng.uniform(-0.5, 0.5) * w, rng.uniform(-0.3, 0.5) * d, 0]
            if rng.random() < 0.5:
                add_board(
                    stage,
                    p,
                    rng.uniform(0.15, 0.6),
                    rng.uniform(0.15, 0.6),
                    rng.normal(0, 0.5),
                    tilt=-rng.uniform(0, 0.5),
                )
            else:
                look = stage.surface(paint=UV, scale=1)
                stage.scene.add_mesh(
                    shapes.lathe([(rng.uniform(0.04, 0.12), 0), (0.002, rng.uniform(0.2, 0.5))]),
                    place(p),
                    [look],
                    "cone",
                )
    if rng.random() < 0.25:
        sticks = [
            shapes.tube(
                [
                    rng.uniform([-w / 2, -d / 2, 0], [w / 2, d / 2, 0.1]),
                    rng.uniform([-w / 2, -d / 2, 0.2], [w / 2, d / 2, 0.8]),
                ],
                rng.uniform(0.003, 0.012),
                6,
            )
            for _ in range(rng.integers(1, 12))
        ]
        stage.scene.add_mesh(shapes.join(*sticks), place(), [stage.surface()], "thin")
    if rng.random() < 0.08:
        add_branch(stage, goal - back * away * 0.4, away * 0.4, stage.surface("plain"))
    colour, inverse, which = stage.finish()
    inverse = np.where(which < 0, backdrop_inverse(rng, inverse), inverse)
    return clear_camera(colour, inverse, 0.12)


def backdrop_inverse(rng, inverse):
    """A place without geometry lies far behind everything that has some."""
    seen = inverse[inverse > 0]
    return np.float32(0.0 if seen.size == 0 else min(seen.min() * rng.uniform(0.2, 0.6), 0.2))


def noise_field(rng, n, octaves, rough):
    """Smooth random heights, -1 to 1 roughly."""
    z = np.zeros((n, n))
    for k in range(octaves):
        m = 2 ** (k + 1) + 1
        z += (
            cv2.resize(rng.normal(0, 1, (m, m)), (n, n), interpolation=cv2.INTER_CUBIC) * rough**k
        )
    return z / np.abs(z).max()


def height_at(z, size, x, y):
    n = z.shape[0]
    fx, fy = np.clip((np.array([x, y]) / size + 0.5) * (n - 1), 0, n - 1.001)
    i, j = int(fx), int(fy)
    a, b = fx - i, fy - j
    return (
        z[j, i] * (1 - a) * (1 - b)
        + z[j, i + 1] * a * (1 - b)
        + z[j + 1, i] * (1 - a) * b
        + z[j + 1, i + 1] * a * b
    )


def outdoor_light(stage):
    """Sun and sky outside; returns nothing. The horizon of the sky is at the camera's height."""
    rng = stage.rng
    sky = pick(rng, stage.assets.skies)
    stage.light(
        sky, rng.uniform(0, 2 * np.pi), sun=0.0 if rng.random() < 0.3 else log_uniform(rng, 0.5, 4)
    )
    v = stage.view
    v.ambientReach = rng.uniform(1, 5)
    v.lightScale = rng.uniform(0.5, 1.1)
    v.exposure = rng.uniform(0.6, 1.8)
    if rng.random() < 0.3:
        v.fog = log_uniform(rng, 0.001, 0.03)
        v.fogColour[:] = list(np.array([0.75, 0.8, 0.88]) * rng.uniform(0.3, 0.9))


def add_tower(stage, position):
    """A tower, lighthouse, chimney, column or high-rise against the sky."""
    rng = stage.rng
    high = log_uniform(rng, 6, 45)
    wide = high * rng.uniform(0.06, 0.25)
    body = stage.surface(pick(rng, ["plain", "stuff", "pattern"]), 1.0 / rng.uniform(2, 6), SOLID)
    if rng.random() < 0.4:
        stage.scene.add_mesh(
            shapes.box((wide, wide * rng.uniform(0.6, 1.5), high)),
            place(position, rng.uniform(0, 6.28)),
            [body] * 3,
            "tower",
        )
        return
    waist, head = rng.uniform(0.5, 1.0), rng.uniform(0.4, 1.1)
    profile = [
        (wide / 2, 0),
        (wide / 2 * waist, high * 0.8),
        (wide / 2 * head, high * 0.82),
        (wide / 2 * head, high * 0.92),
        (wide / 2 * head * rng.uniform(0.2, 1), high * 0.93),
        (0.01, high),
    ]
    stage.scene.add_mesh(shapes.lathe(profile), place(position), [body], "tower")


def landscape_scene(rng, assets):
    """Hills, trees, rocks, animals, people and the sky."""
    stage = Stage(rng, assets)
    outdoor_light(stage)
    size = log_uniform(rng, 60, 600)
    z = (
        noise_field(rng, 129, int(rng.integers(3, 7)), rng.uniform(0.35, 0.6))
        * size
        * rng.uniform(0.0, 0.09)
    )
    z -= height_at(z, size, 0, 0)
    far = noise_field(rng, 65, 5, 0.55)
    ground = pick(rng, assets.ground)
    look = material(
        np.ones(3) * rng.uniform(0.7, 1.3),
        ground,
        scale=log_uniform(rng, 0.08, 0.6),
        paint=SOLID,
        detail=assets.any_stuff(rng),
        detail_scale=log_uniform(rng, 0.01, 0.06),
        detail_strength=rng.uniform(0.1, 0.6),
    )
    stage.scene.add_mesh(shapes.height_field(z, size), place(), [look], "ground")
    if rng.random() < 0.6:  # mountains behind
        y, x = np.mgrid[0:65, 0:65] / 32.0 - 1
        ring = np.clip((np.hypot(x, y) - 0.35) * 2, 0, 1)
        hills = (np.abs(far) * ring * size * rng.uniform(0.15, 0.8)) - size * 0.03
        green = material(
            np.array([0.3, 0.36, 0.3]) * rng.uniform(0.5, 2, 3),
            assets.any_stuff(rng),
            scale=4 / size,
            paint=SOLID,
        )
        stage.scene.add_mesh(shapes.height_field(hills, size * 4), place(), [green], "hills")
    else:
        stage.scene.add_mesh(
            shapes.height_field(np.full((9, 9), z.min() - 0.5), size * 20), place(), [look], "plain"
        )
    height = rng.choice(
        [rng.uniform(0.25, 1.0), rng.uniform(1.2, 2.0), rng.uniform(2, 15)], p=[0.25, 0.6, 0.15]
    )
    stage.camera(
        [0, 0, height],
        rng.uniform(0, 2 * np.pi),
        np.radians(np.clip(rng.normal(-4 - height, 8), -40, 18)),
    )

    def spot(near, far_):
        p = stage.spot(near, far_, margin=0.15)
        p[2] = height_at(z, size, p[0], p[1]) - 0.03
        return p

    kinds = pick(
        rng,
        [["tree"], ["tree", "bush", "rock"], ["bush", "rock"], ["rock"], ["tree", "tree", "bush"]],
    )
    limit = min(size / 2.2, 220)
    for _ in range(int(rng.choice([0, 6, 20, 60, 140], p=[0.1, 0.2, 0.3, 0.25, 0.15]))):
        kind = pick(rng, kinds)
        put(
            stage,
            kind,
            spot(5 if kind == "tree" else 2.5, limit),
            scale=rng.uniform(0.7, 1.5),
            wild=0.3,
        )
    for _ in range(rng.choice([0, 2, 5])):
        put(stage, pick(rng, ["animal", "animal", "person"]), spot(2.5, 40), wild=0.3)
    if rng.random() < 0.4:
        put(stage, pick(rng, ["house", "tower", "house"]), spot(25, limit), wild=0.3)
    if rng.random() < 0.3:
        for _ in range(rng.integers(1, 4)):
            add_tower(stage, spot(12, limit))
    if rng.random() < 0.5:
        for _ in range(rng.integers(1, 5)):
            c = pick(rng, assets.standing)
            low, high, _ = photos.SIZES[c.category]
            s = rng.uniform(low, high)
            stage.billboard(c, spot(max(2, s * stage.view.focal / (1.3 * LONGER)), 35), s)
    if rng.random() < 0.25:
        add_close_up(stage)
    if rng.random() < 0.3:
        add_thin(stage, pick(rng, ["grass", "grass", "branch", "fence", "pole"]), ground=0.0)
    colour, inverse, _ = stage.finish()
    return clear_camera(colour, inverse, 0.3)


def street_scene(rng, assets):
    """A street between houses, with cars, people, trees and poles."""
    stage = Stage(rng, assets)
    outdoor_light(stage)
    half, walk = rng.uniform(2.5, 7), rng.uniform(1, 4)
    length = 180
    stage.scene.add_mesh(
        shapes.box((1200, 1200, 0.1)),
        place([0, 0, -0.25]),
        [material(np.ones(3), pick(rng, assets.ground), scale=0.3, paint=SOLID)],
        "plain",
    )
    road = material(
        np.ones(3) * rng.uniform(0.4, 1),
        pick(rng, assets.ground),
        scale=log_uniform(rng, 0.15, 0.5),
        paint=SOLID,
    )
    stage.scene.add_mesh(
        shapes.box((length, 2 * half, 0.15)), place([length / 2 - 30, 0, -0.15]), [road], "road"
    )
    side = stage.surface("stuff", log_uniform(rng, 0.2, 1))
    for s in (-1, 1):
        stage.scene.add_mesh(
            shapes.box((length, walk, 0.15)),
            place([length / 2 - 30, s * (half + walk / 2), -0.02]),
            [side],
            "walk",
        )
    if rng.random() < 0.5:
        for x in np.arange(-20, 120, 6):
            stage.scene.add_mesh(
                shapes.box((2.5, 0.12, 0.01)),
                place([x, 0, 0.0]),
                [material(np.ones(3) * 0.8)],
                "line",
            )
    gap = rng.uniform(0, 5)
    for s in (-1, 1):
        if rng.random() < 0.12:
            continue
        x = rng.uniform(-12, 0)
        while x < 110:
            if rng.random() < 0.55:
                model = assets.library.get(rng, "house")
            else:
                model = None
            if model is not None and model.size[:2].max() < 32:
                turn = rng.integers(4) * np.pi / 2
                along, deep = (
                    model.size[:2] if int(round(turn / (np.pi / 2))) % 2 == 0 else model.size[1::-1]
                )
                p = [x + along / 2, s * (half + walk + deep / 2 + rng.uniform(0, 1.5)), 0]
                stage.scene.add(
                    model.id, place(p, turn), model.materials(rng, assets, 0.3), "house"
                )
            else:  # a plain block with a facade of a photo or a pattern
                along, deep, high = rng.uniform(5, 18), rng.uniform(6, 12), rng.uniform(3, 22)
                facade = stage.surface(
                    pick(rng, ["photo", "pattern", "stuff"]), 1.0 / rng.uniform(2, 6), SOLID
                )
                stage.scene.add_mesh(
                    shapes.box((along, deep, high)),
                    place([x + along / 2, s * (half + walk + deep / 2), 0]),
                    [facade] * 3,
                    "house",
                )
            x += along + rng.uniform(0, gap)
    yaw = rng.normal(0, 0.35) if rng.random() < 0.5 else rng.choice([-1, 1]) * rng.uniform(0.3, 1.5)
    pos = [
        rng.uniform(-3, 5),
        rng.uniform(-0.9, 0.9) * (half + walk),
        rng.choice(
            [rng.uniform(1.2, 1.9), rng.uniform(0.4, 1.2), rng.uniform(2, 7)], p=[0.65, 0.2, 0.15]
        ),
    ]
    stage.camera(pos, yaw, np.radians(np.clip(rng.normal(-3, 7), -25, 20)))
    for _ in range(rng.choice([0, 2, 5, 9])):  # parked and driving cars
        s = rng.choice([-1, 1])
        x = rng.uniform(6, 80)
        if rng.random() < 0.4:
            cars = [
                c
                for c in assets.standing
                if c.category in ("car", "bus", "truck", "motorcycle", "train")
            ]
            if cars:
                c = pick(rng, cars)
                low, high, _ = photos.SIZES[c.category]
                stage.billboard(c, [x, s * rng.uniform(0.3, 0.9) * half, 0], rng.uniform(low, high))
        else:
            put(
                stage,
                "car",
                [x, s * rng.uniform(0.4, 0.85) * half, 0],
                rng.integers(2) * np.pi + np.pi / 2 + rng.normal(0, 0.05),
                wild=0.1,
            )
    for kind, count, y in (
        ("post", rng.integers(0, 6), half + 0.4),
        ("tree", rng.integers(0, 8), half + walk * 0.7),
        ("street", rng.integers(0, 4), half + walk * 0.5),
        ("person", rng.integers(0, 3), half + walk * 0.5),
    ):
        for _ in range(count):
            put(stage, kind, [rng.uniform(4, 70), rng.choice([-1, 1]) * y, 0.13], wild=0.2)
    people = [
        c for c in assets.standing if c.category in ("person", "dog", "bicycle", "motorcycle")
    ]
    for _ in range(rng.choice([0, 1, 3, 7])):
        c = pick(rng, people)
        low, high, _ = photos.SIZES[c.category]
        p = [pos[0] + log_uniform(rng, 3, 40), rng.uniform(-1, 1) * (half + walk), 0.0]
        if abs(p[1]) > half:
            p[2] = 0.13
        stage.billboard(c, p, rng.uniform(low, high))
    if rng.random() < 0.2:
        add_close_up(stage)
    if rng.random() < 0.2:
        add_thin(stage, pick(rng, ["pole", "fence", "wheel", "branch"]))
    if rng.random() < 0.25:  # cables
        wires = []
        for _ in range(rng.integers(1, 5)):
            y, h0 = rng.uniform(-1, 1, 2) * (half + walk), rng.uniform(4, 9)
            t = np.linspace(0, 1, 20)[:, None]
            wires.append(
                shapes.tube(
                    np.hstack([t * 100 - 5, y[0] + (y[1] - y[0]) * t, h0 - 3 * t * (1 - t)]),
                    0.02,
                    4,
                )
            )
        stage.scene.add_mesh(shapes.join(*wires), place(), [material(np.ones(3) * 0.03)], "wire")
    colour, inverse, _ = stage.finish()
    return clear_camera(colour, inverse, 0.3)


def woods_scene(rng, assets):
    """Between trees, bushes and branches."""
    stage = Stage(rng, assets)
    outdoor_light(stage)
    z = noise_field(rng, 97, 5, 0.5) * rng.uniform(0.1, 3)
    size = 70.0
    z -= height_at(z, size, 0, 0)
    look = material(
        np.ones(3) * rng.uniform(0.5, 1.1),
        pick(rng, assets.ground),
        scale=log_uniform(rng, 0.15, 0.6),
        paint=SOLID,
    )
    stage.scene.add_mesh(shapes.height_field(z, size), place(), [look], "ground")
    stage.scene.add_mesh(
        shapes.height_field(np.full((5, 5), z.min() - 0.5), 1500), place(), [look], "plain"
    )
    stage.camera(
        [0, 0, rng.uniform(0.5, 1.9)],
        rng.uniform(0, 2 * np.pi),
        np.radians(np.clip(rng.normal(0, 9), -30, 30)),
    )
    bark = [stage.surface("stuff", log_uniform(rng, 0.5, 3)) for _ in range(3)]
    for _ in range(rng.integers(15, 90)):
        p = stage.spot(2.2, 33, margin=0.2)
        p[2] = height_at(z, size, p[0], p[1]) - 0.05
        if rng.random() < 0.45:
            put(stage, "tree", p, scale=rng.uniform(0.8, 1.6), wild=0.4)
        elif rng.random() < 0.6:  # a trunk
            h = rng.uniform(4, 14)
            line = np.cumsum(
                np.vstack(
                    [
                        [0, 0, 0],
                        np.column_stack([rng.normal(0, 0.06 * h / 8, (8, 2)), np.full(8, h / 8)]),
                    ]
                ),
                0,
            )
            stage.scene.add_mesh(
                shapes.tube(line, np.linspace(1, 0.5, 9) * log_uniform(rng, 0.03, 0.25), 9),
                place(p),
                [pick(rng, bark)],
                "trunk",
            )
        else:
            put(stage, pick(rng, ["bush", "rock", "bush"]), p, wild=0.3)
    for _ in range(rng.integers(0, 5)):
        add_branch(
            stage,
            stage.position + stage.axes[2] * rng.uniform(1.5, 6),
            rng.uniform(1, 4),
            pick(rng, bark),
        )
    if rng.random() < 0.5:
        add_thin(stage, "grass", ground=0.0)
    for _ in range(rng.choice([0, 1, 2])):
        c = pick(rng, assets.standing)
        low, high, _ = photos.SIZES[c.category]
        s = rng.uniform(low, high)
        p = stage.spot(max(2, s * stage.view.focal / (1.3 * LONGER)), 15)
        p[2] = height_at(z, size, p[0], p[1])
        stage.billboard(c, p, s)
    if rng.random() < 0.15:
        add_close_up(stage)
    colour, inverse, _ = stage.finish()
    return clear_camera(colour, inverse, 0.3)


def world_scene(rng, assets):
    """A furnished world: a house, a bookstore or a warehouse."""
    stage = Stage(rng, assets)
    shares = np.array([w.share for w in assets.worlds], float)
    world = assets.worlds[rng.choice(len(shares), p=shares / shares.sum())]
    stage.light(pick(rng, assets.lights), rng.uniform(0, 2 * np.pi))
    v = stage.view
    v.ambientReach = rng.uniform(0.6, 2)
    v.lightScale = rng.uniform(0.3, 1.0)
    shuffle = rng.random() < 0.5
    for model, matrix, fixed in world.placements:
        m = matrix.copy()
        if shuffle and not fixed:
            if rng.random() < 0.25:
                continue
            m[:2, 3] += rng.normal(0, 0.25, 2)
            a = rng.normal(0, 0.4)
            turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
            m[:3, :3] = turn @ m[:3, :3]
        stage.scene.add(
            model.id, m, model.materials(rng, assets, 0.1), "fixed" if fixed else "thing"
        )
    (x0, x1), (y0, y1), top = world.x, world.y, world.ceiling
    lid = shapes.quad(
        (x0 - 1, y1 + 1, top), (x1 + 1, y1 + 1, top), (x0 - 1, y0 - 1, top), (x1 + 1, y0 - 1, top)
    )
    stage.scene.add_mesh(lid, place(), [stage.surface("plain", 0.5)], "lid")
    for _ in range(12):
        at, yaw = world.camera(rng)
        stage.camera(at, yaw, room_pitch(rng), angle=np.radians(rng.triangular(40, 68, 95)))
        inverse, which = stage.probe()
        seen = inverse[which >= 0]
        if (
            (which < 0).mean() < 0.25
            and (inverse > 2).mean() < 0.08
            and np.percentile(seen, 90) > 2 * np.percentile(seen, 10)
        ):
            break
    else:
        raise ValueError("no view found")
    d = np.array([np.cos(yaw), np.sin(yaw)])
    for _ in range(rng.integers(1, 4)):
        p = [*(at[:2] + d * rng.uniform(0, 4) + rng.normal(0, 1.2, 2)), rng.uniform(2.0, 2.5)]
        stage.scene.lamps.append(
            [
                *p,
                rng.uniform(0.03, 0.15),
                *(np.array([1, rng.uniform(0.8, 1), rng.uniform(0.6, 1)]) * rng.uniform(1, 5)),
            ]
        )
    if rng.random() < 0.3:
        add_cutouts(stage, int(rng.integers(1, 3)), 1.2, 4)
    colour, inverse, _ = stage.finish()
    return clear_camera(colour, inverse, 0.3)


def house_front(stage, position, size, turn=0.0):
    """A house whose front has windows, a door and perhaps a roof. The front is the side at -y."""
    rng = stage.rng
    along, deep, high = size
    looks = [
        stage.surface(
            pick(rng, ["plain", "stuff", "pattern", "plain"]), 1.0 / rng.uniform(0.7, 4), SOLID
        )
        for _ in range(2)
    ]
    stage.scene.add_mesh(
        shapes.box(size, (0, 1, 1)), place([position[0], position[1] + deep / 2, 0], turn), looks
    )
    columns, rows = max(1, int(along / rng.uniform(1.6, 3.2))), max(1, int(high / 2.9))
    w, h = along / columns * rng.uniform(0.3, 0.7), high / rows * rng.uniform(0.35, 0.7)
    glass = material(np.ones(3) * rng.uniform(0.02, 0.5), gloss=0.15, sharpness=60)
    if rng.random() < 0.3:
        glass = material(np.ones(3) * rng.uniform(0.4, 1), pick(rng, stage.assets.whole), paint=UV)
    frame = material(rng.uniform(0.1, 0.95) * rng.uniform(0.7, 1.1, 3))
    panes, frames = [], []
    for i in range(columns):
        for k in range(rows):
            x = position[0] + ((i + 0.5) / columns - 0.5) * along
            door = k == 0 and rng.random() < 0.3
            z0 = 0.0 if door else (k + 0.3) * high / rows
            z1 = 2.1 if door else z0 + h
            for into, grow, front in ((frames, 0.08, 0.04), (panes, 0.0, 0.06)):
                board = shapes.box((w + 2 * grow, 0.05, z1 - z0 + 2 * grow))
                move = [x, position[1] - front, max(z0 - grow, 0)]
                into.append(dict(board, positions=board["positions"] + np.float32(move)))
    stage.scene.add_mesh(shapes.join(*frames), place(), [frame], "frame")
    stage.scene.add_mesh(shapes.join(*panes), place(), [glass], "window")
    if rng.random() < 0.6:  # a roof that slopes to the front
        over, rise = rng.uniform(0.1, 0.6), deep / 2 * rng.uniform(0.3, 1.2)
        x0, x1 = position[0] - along / 2, position[0] + along / 2
        y0, y1 = position[1] - over, position[1] + deep / 2
        roof = shapes.quad(
            (x0, y1, high + rise), (x1, y1, high + rise), (x0, y0, high), (x1, y0, high)
        )
        tiles = stage.surface(pick(rng, ["pattern", "stuff", "plain"]), 1.0 / rng.uniform(0.5, 3))
        stage.scene.add_mesh(roof, place(), [tiles], "roof")


def row_scene(rng, assets):
    """Houses, vehicles, people or things side by side, in rows that recede to one side."""
    stage = Stage(rng, assets)
    outdoor_light(stage)
    ground = material(
        np.ones(3) * rng.uniform(0.5, 1.2), pick(rng, assets.ground), scale=0.4, paint=SOLID
    )
    stage.scene.add_mesh(shapes.box((1200, 1200, 0.1)), place([0, 0, -0.1]), [ground], "ground")
    kind = pick(rng, ["house", "house", "vehicle", "vehicle", "people", "posts", "wall"])
    side = pick(rng, [-1, 1])
    away = rng.uniform(1.5, 5) if kind != "house" else rng.uniform(2.5, 11)
    slant = np.radians(rng.uniform(3, 75))  # between the row and the view
    height = rng.choice(
        [rng.uniform(0.4, 1.2), rng.uniform(1.3, 1.9), rng.uniform(2, 5)], p=[0.2, 0.6, 0.2]
    )
    # The row runs along x; the camera stands at y < 0.
    yaw = slant if side > 0 else np.pi - slant
    stage.camera([0, -away, height], yaw, np.radians(np.clip(rng.normal(0, 7), -25, 20)))
    reach = side * np.arange(-12, 70)
    back = 0.0
    if kind == "vehicle":
        alike = [
            c for c in assets.standing if c.category in ("motorcycle", "bicycle", "car", "bus")
        ]
        step, rows = rng.uniform(0.9, 3), int(rng.integers(1, 4))
        if alike:
            chosen = pick(rng, alike)
            alike = [c for c in alike if c.category == chosen.category]
        model = not alike or rng.random() < 0.4
        for row in range(rows):
            for k in range(-3, int(rng.integers(4, 16))):
                p = [
                    side * k * step * (1.6 if model else 1) + rng.normal(0, 0.15),
                    row * rng.uniform(1.2, 3),
                    0.0,
                ]
                if model:
                    put(stage, "car", p, rng.normal(0, 0.06) + np.pi / 2 * (row % 2), wild=0.2)
                else:
                    c = pick(rng, alike)
                    low, high, _ = photos.SIZES[c.category]
                    stage.billboard(c, p, rng.uniform(low, high))
        back = rows * 3.0 + rng.uniform(0, 4)
    elif kind == "people":
        step, rows = rng.uniform(0.5, 1.2), int(rng.integers(2, 7))
        people = [c for c in assets.standing if c.category == "person"]
        for row in range(rows):
            for k in range(-4, int(rng.integers(4, 20))):
                if rng.random() < 0.25:
                    continue
                p = [
                    side * k * step + rng.normal(0, 0.2),
                    row * step * 1.3 + rng.normal(0, 0.2),
                    0.0,
                ]
                stage.billboard(pick(rng, people), p, rng.uniform(1.45, 1.9))
        back = rows * step * 1.3 + rng.uniform(0.5, 8)
    elif kind == "posts":
        step, thick, high = log_uniform(rng, 0.8, 5), log_uniform(rng, 0.04, 0.4), rng.uniform(1, 6)
        look = stage.surface(None, 1.0)
        round_ = rng.random() < 0.6
        for x in np.arange(-3, 30) * step * side:
            mesh = (
                shapes.tube([(0, 0, 0), (0, 0, high)], thick, 12)
                if round_
                else shapes.box((2 * thick, 2 * thick, high))
            )
            stage.scene.add_mesh(mesh, place([x, 0, 0]), [look] * 3, "post")
        for z in rng.uniform(0.2, 1, int(rng.integers(0, 4))) * high:
            beam = shapes.box(
                (step * 60, thick * rng.uniform(0.5, 2.5), thick * rng.uniform(0.5, 2))
            )
            stage.scene.add_mesh(beam, place([0, 0, z]), [look] * 3, "beam")
        back = rng.uniform(0.5, 8)
    if kind == "house" or rng.random() < 0.6:
        x = reach[0]
        level = rng.uniform(3, 12)
        while abs(x) < 75:
            along = rng.uniform(3.5, 11)
            high = level * rng.uniform(0.75, 1.3)
            jut = rng.uniform(0, 0.8) * (rng.random() < 0.5)
            house_front(
                stage, [x + side * along / 2, back + jut, 0], (along, rng.uniform(5, 9), high)
            )
            x += side * (along + rng.uniform(0, 3) * (rng.random() < 0.15))
    elif kind == "wall" or rng.random() < 0.6:
        look = stage.surface(
            pick(rng, ["photo", "stuff", "pattern"]), 1.0 / rng.uniform(1, 4), SOLID
        )
        stage.scene.add_mesh(
            shapes.box((200, 0.3, rng.uniform(1.2, 7))), place([0, back, 0]), [look] * 3, "wall"
        )
        for x in np.arange(-2, 12) * rng.uniform(1.5, 5) * side:
            if rng.random() < 0.5:
                w = rng.uniform(0.5, 1.6)
                add_board(
                    stage,
                    [x, back - 0.17, rng.uniform(0.3, 1.5)],
                    w,
                    w * rng.uniform(0.5, 1.4),
                    0.0,
                )
    for _ in range(rng.choice([0, 1, 3, 6])):
        what = pick(rng, ["person", "bush", "post", "street", "tree", "cutout", "cutout"])
        p = [side * rng.uniform(1, 25), back - rng.uniform(0.4, max(0.5, away * 0.7)), 0.0]
        if what == "cutout":
            c = pick(rng, assets.standing)
            low, high, _ = photos.SIZES[c.category]
            stage.billboard(c, p, rng.uniform(low, high))
        else:
            put(stage, what, p, wild=0.2)
    if rng.random() < 0.12:
        add_close_up(stage)
    colour, inverse, _ = stage.finish()
    return clear_camera(colour, inverse, 0.3)


def portrait_scene(rng, assets):
    """One person, animal or group before a wall, a curtain or a blurred place."""
    stage = Stage(rng, assets)
    stage.light(pick(rng, assets.lights), rng.uniform(0, 2 * np.pi))
    stage.view.ambientReach = rng.uniform(1, 4)
    stage.camera(
        [0, 0, rng.uniform(0.9, 1.7)],
        np.pi / 2,
        np.radians(rng.normal(-2, 6)),
        angle=np.radians(rng.triangular(22, 45, 75)),
    )
    behind = rng.uniform(1.2, 6)
    look = stage.surface(
        rng.choice(["plain", "stuff", "pattern", "photo"], p=[0.5, 0.2, 0.1, 0.2]),
        1.0 / rng.uniform(0.8, 4),
        SOLID,
    )
    turn = rng.normal(0, 0.3) if rng.random() < 0.7 else rng.normal(0, 0.9)
    stage.scene.add_mesh(
        shapes.box((60, 0.1, 30)), place([0, behind, -12], turn), [look] * 3, "back"
    )
    floor = stage.surface(None, log_uniform(rng, 0.3, 1.2), SOLID)
    stage.scene.add_mesh(shapes.box((60, 60, 0.1)), place([0, 0, -0.1]), [floor] * 3, "floor")
    lamps(stage, [-2, -1, 1], [2, 1, 3], int(rng.integers(0, 3)), 2.0)
    if rng.random() < 0.3:
        put(
            stage,
            pick(rng, ["plant", "cabinet", "tall", "lamp", "chair"]),
            [rng.normal(0, 0.8), behind * 0.8, 0],
        )
    count = int(rng.choice([1, 2, 4, 8], p=[0.5, 0.2, 0.15, 0.15]))
    if count >= 4:  # a group: rows of people at several distances
        people = [c for c in assets.standing if c.category == "person"]
        for _ in range(count * 2):
            r = log_uniform(rng, 1.3, max(behind * 0.9, 1.5))
            x = rng.uniform(-0.6, 0.6) * r
            stage.billboard(pick(rng, people), [x, r, 0.0], rng.uniform(1.45, 1.9))
    for _ in range(min(count, 3)):
        add_close_up(stage)
    if rng.random() < 0.1:
        add_thin(stage, distance=rng.uniform(0.5, 1.5))
    colour, inverse, _ = stage.finish()
    return colour, np.minimum(inverse, 8)


def macro_scene(rng, assets):
    return panorama_scene(rng, assets, "macro")


NEAR_FOCUS = ("close", "macro", "portrait")  # often with a blurred background
FAMILIES = {
    "macro": macro_scene,
    "panorama": panorama_scene,
    "close": close_scene,
    "room": room_scene,
    "tabletop": tabletop_scene,
    "landscape": landscape_scene,
    "street": street_scene,
    "woods": woods_scene,
    "world": world_scene,
    "row": row_scene,
    "portrait": portrait_scene,
}
MIX = {
    "panorama": 2.5,
    "close": 3,
    "macro": 2,
    "room": 2,
    "world": 3,
    "tabletop": 4,
    "landscape": 2.5,
    "street": 3,
    "woods": 1.5,
    "row": 2.5,
    "portrait": 2,
}
