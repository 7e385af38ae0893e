"""Everything the scenes are made of, loaded once."""

import cv2
import numpy as np

import photos
import shapes
from library import Library
from render import Renderer
from worlds import read_worlds

HELD_OUT_SHARE = 7  # one of so many photos and models is for validation only
GROUND = (
    "grass-merged",
    "dirt-merged",
    "road",
    "pavement-merged",
    "sand",
    "playingfield",
    "floor-wood",
    "gravel",
    "snow",
    "floor-other-merged",
    "railroad",
    "rock-merged",
    "platform",
)


def cutout_mesh(cutout, rng):
    """A standing sheet, 1 high, that bulges towards the viewer (-y) where the cut-out is wide."""
    alpha = (cutout.rgba[..., 3] > 127).astype(np.uint8)
    alpha = cv2.copyMakeBorder(alpha, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    inside = cv2.distanceTransform(alpha, cv2.DIST_L2, 5)[1:-1, 1:-1] / alpha.shape[0]
    n = 24
    bulge = cv2.resize(
        cv2.GaussianBlur(inside, (0, 0), max(1, alpha.shape[0] / 50)), (n + 1, n + 1)
    )
    bulge = np.sqrt(np.maximum(bulge, 0) * 0.25) * 0.5
    x, z = np.meshgrid(np.linspace(-0.5, 0.5, n + 1) * cutout.aspect, np.linspace(1, 0, n + 1))
    u, v = np.meshgrid(np.linspace(0.001, 0.999, n + 1), np.linspace(0.001, 0.999, n + 1))
    return {
        "positions": np.stack([x, -np.minimum(bulge, 0.12), z], -1).reshape(-1, 3),
        "triangles": shapes.grid(n, n),
        "uv": np.stack([u, v], -1).reshape(-1, 2),
    }


def patterns(rng, count):
    """Made-up surfaces: stripes, checks, dots, bricks, noise, gradients and writing."""
    out = []
    for _ in range(count):
        a, b = rng.integers(0, 256, 3).astype(float), rng.integers(0, 256, 3).astype(float)
        y, x = np.mgrid[0:256, 0:256] / 256.0
        n = int(rng.integers(2, 17))
        kind = rng.integers(7)
        if kind == 0:
            m = (x * n % 1 < rng.uniform(0.2, 0.8)).astype(float)
        elif kind == 1:
            m = ((np.floor(x * n) + np.floor(y * n)) % 2).astype(float)
        elif kind == 2:
            m = (np.hypot(x * n % 1 - 0.5, y * n % 1 - 0.5) < rng.uniform(0.15, 0.45)).astype(float)
        elif kind == 3:
            m = (
                (y * n % 1 > 0.08) & ((x * n / 2 + 0.5 * (np.floor(y * n) % 2)) % 1 > 0.05)
            ).astype(float)
        elif kind == 4:
            m = cv2.resize(rng.random((n, n)), (256, 256), interpolation=cv2.INTER_CUBIC)
        elif kind == 5:
            m = (np.abs(x * 2 - 1) + np.abs(y * 2 - 1)) / 2
        else:
            page = np.zeros((256, 256), np.uint8)
            for row in range(12, 256, int(rng.integers(14, 40))):
                text = "".join(
                    rng.choice(list("abcdefgh iklmnop rstuvwxyz ABCDEFG 0123456789"))
                    for _ in range(24)
                )
                cv2.putText(
                    page,
                    text,
                    (int(rng.integers(0, 12)), row),
                    int(rng.integers(0, 4)),
                    rng.uniform(0.3, 0.9),
                    255,
                    1,
                )
            m = page / 255.0
        noise = cv2.resize(rng.normal(0, 1, (64, 64)), (256, 256)) * 5 + rng.normal(
            0, 4, (256, 256)
        )
        p = a * m[..., None] + b * (1 - m[..., None]) + noise[..., None]
        out.append(np.clip(p, 0, 255).astype(np.uint8))
    return out


class Assets:
    def __init__(self, cache, held_out=False):
        rng = np.random.default_rng(1 + held_out)
        r = self.renderer = Renderer(cache)
        src = cache / "src"
        self.places, self.lights, self.skies = [], [], []
        for name, facts in photos.PANORAMAS.items():
            if bool(facts.get("val")) != held_out:
                continue
            source = "pmndrs+drei-assets" if "drei" in facts else "gkjohnson+3d-demo-data"
            pano = photos.Panorama(src / source / f"hdri/{name}_1k.hdr", name)
            pano.id = r.panorama(pano.rgb)
            pano.rgb = None
            self.lights.append(pano)
            if "floor" in facts:
                self.places.append(pano)
            if pano.sky.any():
                self.skies.append(pano)
        cutouts, stuff, whole = photos.read_photos(
            photos.panoptic_photos(src / "lightly-ai+coco128_yolo")
        )

        def mine(things, key):
            return [
                t for k, t in enumerate(things) if (key(k, t) % HELD_OUT_SHARE == 0) == held_out
            ]

        cutouts = mine(cutouts, lambda k, c: c.photo)
        whole = mine(whole, lambda k, w: k)
        more = [] if held_out else photos.more_photos(src)
        more_cutouts, more_stuff, more_whole = photos.read_photos(more)
        cutouts += more_cutouts
        whole += more_whole
        for c in cutouts:
            c.texture = r.texture(c.rgba)
            c.model = r.model(**cutout_mesh(c, rng), transparent=True)
            solid = c.rgba[c.rgba[..., 3] > 127][:, :3]
            c.brightness = float(((solid / 255.0) ** 2.2).mean())
            c.whole = not (c.cut_left or c.cut_right or c.cut_top or c.cut_bottom)
            if c.category == "person" and c.aspect > 0.53:
                c.whole = False
        self.standing = [
            c for c in cutouts if c.whole and photos.SIZES[c.category][2] in ("ground", "both")
        ]
        self.small = [
            c for c in cutouts if c.whole and photos.SIZES[c.category][2] in ("table", "both")
        ]
        self.busts = [
            c
            for c in cutouts
            if not (c.cut_left or c.cut_right)
            and c.rgba.shape[0] > 130
            and c.category
            in (
                "person",
                "dog",
                "cat",
                "bear",
                "giraffe",
                "zebra",
                "horse",
                "elephant",
                "sheep",
                "cow",
                "teddy bear",
                "bird",
                "potted plant",
            )
        ]
        tiles = {
            k: mine(v, lambda i, t: i + len(k))
            for k, v in stuff.items()
            if k not in ("sky-other-merged", "mirror-stuff")
        }
        upload = {k: [r.texture(photos.mirrored_tile(t)) for t in v] for k, v in tiles.items()}
        self.stuff_by_name = upload
        self.stuff = [t for v in upload.values() for t in v]
        self.stuff += [r.texture(photos.mirrored_tile(t)) for v in more_stuff.values() for t in v]
        self.ground = [t for k in GROUND for t in upload.get(k, [])]
        self.whole = [
            r.texture(cv2.resize(w, (512, 512), interpolation=cv2.INTER_AREA)) for w in whole
        ]
        for pano in self.lights:  # photos and surfaces from the panoramas
            for k in range(10):
                view = pano.picture(
                    rng.uniform(0, 6.28), rng.normal(-0.05, 0.2), rng.uniform(0.7, 1.7), 256
                )
                self.whole.append(
                    r.texture(cv2.resize(view, (512, 512), interpolation=cv2.INTER_CUBIC))
                )
                part = pano.picture(
                    rng.uniform(0, 6.28), rng.uniform(-1.2, 0.9), rng.uniform(0.2, 0.6), 160
                )
                self.stuff.append(r.texture(photos.mirrored_tile(part)))
            if "floor" in pano.facts:
                self.ground += [
                    r.texture(
                        photos.mirrored_tile(pano.picture(rng.uniform(0, 6.28), -np.pi / 2, a, 256))
                    )
                    for a in (0.8, 1.4)
                ]
        self.patterns = [r.texture(p) for p in patterns(rng, 120)]
        self.library = Library(r, cache, held_out)
        self.worlds = [] if held_out else read_worlds(self.library)

    def any_stuff(self, rng):
        return self.stuff[int(rng.integers(len(self.stuff)))]

    def any_texture(self, rng):
        choice = (self.stuff, self.stuff, self.patterns, self.whole)[int(rng.integers(4))]
        return choice[int(rng.integers(len(choice)))]
