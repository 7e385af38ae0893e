"""Panoramas, cut-outs and textures from photos."""

import json
import pathlib

import cv2
import numpy as np

# The floor of each panorama as seen from its camera: corners (azimuth and elevation of the foot of
# the wall, degrees), read off the pictures. `up`: height of the ceiling over the camera, in camera
# heights; without it the sky is open. `light`: only light and backdrop of other scenes.
# `avoid`: azimuths where a thing stands in the way that this model does not have.
PANORAMAS = {
    "adams_place_bridge": dict(floor=[(42, -1.5), (48, -1.5), (222, -1.5), (228, -1.5)], up=1.1),
    "aerodynamics_workshop": dict(
        floor=[(10, -25), (110, -22), (160, -26), (250, -26), (330, -28)],
        up=2.5,
        avoid=[(150, 310)],
        val=True,
    ),
    "aristea_wreck_puresky": dict(sky=True),
    "autoshop_01": dict(
        floor=[(0, -7), (60, -4), (120, -4), (180, -6), (240, -5), (300, -6)], up=1.5
    ),
    "blocky_photo_studio": dict(light=True),
    "brown_photostudio_01": dict(light=True),
    "brown_photostudio_02": dict(light=True),
    "brown_photostudio_06": dict(
        floor=[
            (0, -25),
            (50, -25),
            (62, -17),
            (150, -18),
            (170, -28),
            (195, -36),
            (235, -36),
            (250, -28),
            (330, -24),
        ],
        up=1.3,
    ),
    "brown_photostudio_07": dict(
        floor=[(0, -22), (45, -18), (60, -20), (150, -20), (165, -22), (240, -20), (320, -24)],
        up=1.6,
        val=True,
    ),
    "chinese_garden": dict(
        floor=[(0, -17), (60, -17), (90, -12), (120, -8), (260, -8), (300, -14)], avoid=[(170, 250)]
    ),
    "christmas_photo_studio_07": dict(
        floor=[(0, -28), (60, -26), (120, -26), (180, -25), (240, -26), (300, -27)], up=1.3
    ),
    "circus_arena": dict(light=True),
    "dancing_hall": dict(floor=[(az, -8) for az in range(0, 360, 45)], up=2.7),
    "drachenfels_cellar": dict(floor=[(az, -14) for az in range(0, 360, 40)], up=1.3),
    "hilly_terrain_01": dict(floor=[(az, -2.5) for az in range(0, 360, 30)]),
    "kloppenheim_05": dict(floor=[(az, -0.6) for az in range(0, 360, 30)], val=True),
    "leadenhall_market": dict(
        floor=[
            (0, -7),
            (20, -9),
            (50, -13),
            (80, -15),
            (92, -8),
            (112, -16),
            (150, -8),
            (175, -3),
            (190, -4),
            (200, -10),
            (290, -15),
            (330, -14),
            (350, -8),
        ],
        up=9,
        val=True,
    ),
    "modern_buildings_2": dict(light=True),
    "narrow_moonlit_road": dict(
        floor=[
            (0, -2.5),
            (35, -12),
            (60, -14),
            (150, -14),
            (205, -10),
            (215, -2.5),
            (222, -2.5),
            (230, -10),
            (250, -20),
            (330, -20),
            (345, -8),
        ]
    ),
    "noon_grass": dict(floor=[(az, -1.5) for az in range(0, 360, 30)]),
    "peppermint_powerplant": dict(
        floor=[(az, -20) for az in range(0, 360, 40)], up=4, avoid=[(150, 265)]
    ),
    "phalzer_forest_01": dict(
        floor=[(az, -9) for az in range(0, 360, 40)], up=12, avoid=[(195, 245)]
    ),
    "rainforest_trail": dict(floor=[(az, -14) for az in range(0, 360, 40)], up=12),
    "sepulchral_chapel_rotunda": dict(floor=[(az, -13.5) for az in range(0, 360, 30)], up=3),
    "st_peters_square_night": dict(floor=[(az, -1.5) for az in range(0, 360, 30)]),
    "studio_small_05": dict(light=True, val=True),
    "thatch_chapel": dict(
        floor=[
            (0, -20),
            (70, -25),
            (105, -30),
            (130, -28),
            (150, -22),
            (210, -22),
            (270, -30),
            (290, -32),
            (330, -25),
        ],
        up=2,
        avoid=[(160, 250)],
    ),
    "vestibule": dict(floor=[(az, -14) for az in range(0, 360, 30)], up=2.8, val=True),
    # of pmndrs/drei-assets
    "dikhololo_night": dict(floor=[(az, -1.5) for az in range(0, 360, 30)], drei=True),
    "empty_warehouse_01": dict(
        floor=[
            (0, -10),
            (60, -13),
            (95, -15),
            (130, -17),
            (150, -15),
            (185, -6),
            (240, -5),
            (270, -6),
            (300, -5),
            (335, -7),
        ],
        up=2.2,
        avoid=[(282, 348)],
        drei=True,
    ),
    "forest_slope": dict(
        floor=[(az, -15) for az in range(0, 360, 40)],
        up=12,
        avoid=[(200, 225), (300, 330)],
        drei=True,
    ),
    "immenstadter_horn": dict(
        floor=[(az, -2) for az in range(0, 240, 30)] + [(240, -6), (270, -8), (300, -8), (330, -3)],
        avoid=[(90, 110)],
        drei=True,
    ),
    "kiara_1_dawn": dict(sky=True, drei=True),
    "lebombo": dict(
        floor=[
            (0, -25),
            (45, -27),
            (57, -29),
            (60, -20),
            (95, -28),
            (113, -28),
            (140, -27),
            (170, -29),
            (200, -33),
            (230, -30),
            (262, -22),
            (300, -28),
            (340, -20),
        ],
        up=1.4,
        avoid=[(0, 60), (112, 136)],
        drei=True,
    ),
    "potsdamer_platz": dict(
        floor=[(az, -1.2) for az in range(0, 360, 30)], avoid=[(115, 130), (155, 215)], drei=True
    ),
    "rooitou_park": dict(
        floor=[(az, -1.2) for az in range(0, 360, 30)], avoid=[(36, 46)], drei=True
    ),
    "st_fagans_interior": dict(light=True, drei=True),
    "studio_small_03": dict(light=True, drei=True),
    "venice_sunset": dict(
        floor=[(az, -0.9) for az in range(0, 360, 30)], avoid=[(85, 110), (260, 290)], drei=True
    ),
}


class Panorama:
    def __init__(self, path, name):
        self.name, self.facts = name, PANORAMAS[name]
        rgb = cv2.imread(str(path), cv2.IMREAD_ANYDEPTH | cv2.IMREAD_COLOR)[..., ::-1].astype(
            np.float32
        )
        rgb = rgb / (np.percentile(rgb.mean(2)[200:400], 60) + 1e-6) * 0.2
        sky = self.sky_of(rgb)
        rgb = np.minimum(rgb, 4000)
        lat = (0.5 - (np.arange(512) + 0.5) / 512) * np.pi
        luma = rgb.mean(2) * np.cos(lat)[:, None]
        y, x = np.unravel_index(np.argmax(cv2.GaussianBlur(luma, (0, 0), 2)), luma.shape)
        az = (x + 0.5) / 1024 * 2 * np.pi
        self.sun = np.array(
            [np.cos(lat[y]) * np.cos(-az), np.cos(lat[y]) * np.sin(-az), np.sin(lat[y])]
        )
        capped = np.minimum(rgb, 12.0)
        rest = (rgb - capped) * np.cos(lat)[:, None, None]
        self.sun_colour = rest.sum((0, 1)) * (2 * np.pi / 1024) * (np.pi / 512) / np.pi
        if self.sun[2] < 0.1:
            self.sun_colour = self.sun_colour * 0
        self.sun_colour = np.minimum(self.sun_colour, 4.0)
        small = cv2.resize(capped, (64, 32), interpolation=cv2.INTER_AREA)
        wide = np.hstack([small, small, small])
        self.soft = cv2.GaussianBlur(wide, (0, 0), 2.0)[:, 64:128].copy()
        self.rgb = cv2.resize(np.log(rgb + 1e-3), (2048, 1024), interpolation=cv2.INTER_CUBIC)
        self.rgb = np.exp(self.rgb) - 1e-3
        self.rgb = np.maximum(self.rgb, 0).astype(np.float32)
        self.ldr = (
            np.clip(rgb / (np.percentile(rgb.mean(2)[128:400], 85) + 1e-6), 0, 1) ** (1 / 2.2) * 255
        ).astype(np.uint8)
        self.sky = (
            cv2.resize(sky.astype(np.float32), (2048, 1024), interpolation=cv2.INTER_LINEAR) > 0.5
        )

    def sky_of(self, rgb):
        """The sky: grown from the zenith over similar neighbours, above the horizon."""
        if "up" in self.facts or "light" in self.facts:
            return np.zeros(rgb.shape[:2], bool)
        if "sky" in self.facts:
            return np.arange(512)[:, None].repeat(1024, 1) < 256
        ldr = (
            np.clip(rgb / (np.percentile(rgb.mean(2)[100:300], 80) + 1e-6), 0, 1) ** (1 / 2.2) * 255
        ).astype(np.uint8)
        mask = np.zeros((514, 1026), np.uint8)
        for x in range(0, 1024, 16):
            for y in (1, 60, 120, 170):
                if not mask[y + 1, x + 1] and (
                    y == 1 or np.ptp(ldr[y - 1 : y + 2, max(x - 1, 0) : x + 2].astype(int)) < 12
                ):
                    cv2.floodFill(
                        np.ascontiguousarray(ldr),
                        mask,
                        (x, y),
                        (0, 0, 0),
                        (4, 4, 4),
                        (4, 4, 4),
                        cv2.FLOODFILL_MASK_ONLY | (255 << 8) | 4,
                    )
        sky = cv2.morphologyEx(mask[1:-1, 1:-1], cv2.MORPH_CLOSE, np.ones((9, 9), np.uint8)) > 0
        sky[258:] = False
        return sky

    def picture(self, azimuth, elevation, angle, size):
        """An ordinary photo, 8-bit RGB, of a camera at the centre; angles in radians."""
        a = np.tan(angle / 2)
        y, x = np.mgrid[1 : -1 : size * 1j, -1 : 1 : size * 1j] * a
        ce, se = np.cos(elevation), np.sin(elevation)
        d = np.stack([ce - y * se, x, se + y * ce], -1)  # forward, right, up
        turn = np.arctan2(d[..., 1], d[..., 0]) + azimuth
        up = np.arcsin(d[..., 2] / np.linalg.norm(d, axis=-1))
        u, v = turn / (2 * np.pi) % 1 * 1024 - 0.5, (0.5 - up / np.pi) * 512 - 0.5
        return cv2.remap(
            self.ldr,
            u.astype(np.float32),
            v.astype(np.float32),
            cv2.INTER_CUBIC,
            borderMode=cv2.BORDER_REPLICATE,
        )

    def floor_polygon(self, height):
        """Corners of the floor for a camera `height` metres above it, counter-clockwise."""
        corners = [(az, height / np.tan(np.radians(-el))) for az, el in self.facts["floor"]]
        return np.array(
            [(r * np.cos(-np.radians(az)), r * np.sin(-np.radians(az))) for az, r in corners]
        )[::-1]

    def azimuth(self, rng):
        """A direction to look, radians, that shows nothing this model lacks."""
        while True:
            az = rng.uniform(0, 360)
            if not any(a - 12 < az < b + 12 for a, b in self.facts.get("avoid", [])):
                return -np.radians(az)


# Plausible heights of whole things, metres: (smallest, largest, where it stands)
SIZES = {
    "person": (1.5, 1.9, "ground"),
    "bicycle": (0.9, 1.1, "ground"),
    "car": (1.4, 1.7, "ground"),
    "motorcycle": (1.0, 1.3, "ground"),
    "bus": (2.8, 3.4, "ground"),
    "train": (3.2, 4.2, "ground"),
    "truck": (2.2, 3.2, "ground"),
    "boat": (1, 3, "ground"),
    "airplane": (4, 8, "ground"),
    "fire hydrant": (0.7, 0.9, "ground"),
    "parking meter": (1.3, 1.5, "ground"),
    "bench": (0.8, 1.0, "ground"),
    "bird": (0.15, 0.4, "both"),
    "cat": (0.3, 0.45, "both"),
    "dog": (0.4, 0.8, "ground"),
    "horse": (1.6, 2.0, "ground"),
    "sheep": (0.7, 1.0, "ground"),
    "cow": (1.3, 1.6, "ground"),
    "elephant": (2.3, 3.3, "ground"),
    "bear": (0.9, 1.5, "ground"),
    "zebra": (1.3, 1.6, "ground"),
    "giraffe": (3.8, 5, "ground"),
    "chair": (0.8, 1.0, "ground"),
    "couch": (0.8, 1.0, "ground"),
    "potted plant": (0.3, 1.0, "both"),
    "bed": (0.7, 1.0, "ground"),
    "dining table": (0.75, 0.8, "ground"),
    "toilet": (0.7, 0.85, "ground"),
    "refrigerator": (1.6, 1.9, "ground"),
    "teddy bear": (0.25, 0.6, "both"),
    "suitcase": (0.5, 0.8, "ground"),
    "umbrella": (0.7, 1.0, "ground"),
    "tv": (0.4, 0.7, "table"),
    "laptop": (0.22, 0.3, "table"),
    "microwave": (0.3, 0.35, "table"),
    "oven": (0.6, 0.9, "ground"),
    "vase": (0.2, 0.4, "table"),
    "bottle": (0.22, 0.32, "table"),
    "cup": (0.08, 0.14, "table"),
    "wine glass": (0.15, 0.22, "table"),
    "bowl": (0.07, 0.13, "table"),
    "clock": (0.2, 0.35, "table"),
    "book": (0.2, 0.28, "table"),
    "cake": (0.08, 0.2, "table"),
    "pizza": (0.08, 0.12, "table"),
    "sandwich": (0.06, 0.12, "table"),
    "donut": (0.04, 0.07, "table"),
    "apple": (0.07, 0.09, "table"),
    "orange": (0.07, 0.09, "table"),
    "banana": (0.08, 0.15, "table"),
    "broccoli": (0.08, 0.16, "table"),
    "carrot": (0.04, 0.1, "table"),
    "hot dog": (0.06, 0.1, "table"),
    "cell phone": (0.12, 0.16, "table"),
    "backpack": (0.4, 0.55, "both"),
    "handbag": (0.25, 0.4, "both"),
    "sports ball": (0.1, 0.25, "both"),
}

# Licences of the photos that are used, by COCO's numbers (models/ATTRIBUTIONS.md): commercial use and
# changes are allowed.
LICENCES = {4, 5, 7, 8}


# More photos of COCO with masks: folder, annotations, folder of the photos. All are for training.
MORE_PHOTOS = [
    ("Obmutescence+COCO-MINI", "annotations/instances_train2017.json", "train2017"),
    ("Obmutescence+COCO-MINI", "annotations/instances_val2017.json", "val2017"),
    ("zzowenzz+COCO_Tiny", "annotations/instances_train2017.json", "train2017"),
    ("zzowenzz+COCO_Tiny", "annotations/instances_val2017.json", "val2017"),
    ("enginbozaba+tiny_coco", "annotations/instances_train2017.json", "images/train2017"),
    ("enginbozaba+tiny_coco", "annotations/instances_val2017.json", "images/val2017"),
    ("developer0hye+COCO128", "annotations/instances_train2017.json", "train2017"),
    ("minto5z+coco_yolo", "annotations/instances_val2017.json", "coco/images/val2017"),
]


class Cutout:
    def __init__(self, rgba, category, photo, cut):
        self.rgba, self.category, self.photo = rgba, category, photo
        self.cut_left, self.cut_right, self.cut_top, self.cut_bottom = cut
        self.aspect = rgba.shape[1] / rgba.shape[0]


class Segment:
    """What one part of a photo shows. `thing`: one thing, and not stuff like grass; a `crowd` is many."""

    def __init__(self, name, thing, crowd, mask):
        self.name, self.thing, self.crowd, self.mask = name, thing, crowd, mask


def panoptic_photos(folder):
    """The photos of lightly-ai/coco128_yolo: yields number, photo and segments."""
    folder = pathlib.Path(folder)
    for split in ("train", "val"):
        marks = folder / f"panoptic_segmentation/annotations/panoptic_{split}2017"
        facts = json.loads(marks.with_suffix(".json").read_text())
        names = {c["id"]: (c["name"], c["isthing"]) for c in facts["categories"]}
        licences = {i["id"]: i["license"] for i in facts["images"]}
        for a in facts["annotations"]:
            number = a["image_id"]
            if licences[number] not in LICENCES:
                continue
            photo = cv2.imread(str(folder / f"images/{split}2017/{number:012d}.jpg"))[..., ::-1]
            ids = cv2.imread(str(marks / a["file_name"])).astype(int)
            ids = ids[..., 2] + 256 * ids[..., 1] + 65536 * ids[..., 0]
            yield number, photo, [
                Segment(*names[s["category_id"]], s["iscrowd"], (ids == s["id"]).astype(np.uint8))
                for s in a["segments_info"]
            ]


def panoptic_numbers(folder):
    """The numbers of all photos of lightly-ai/coco128_yolo, whatever their licences."""
    files = pathlib.Path(folder).glob("panoptic_segmentation/annotations/panoptic_*2017.json")
    return {i["id"] for f in files for i in json.loads(f.read_text())["images"]}


def more_photos(source):
    """The photos of MORE_PHOTOS: yields number, photo and segments. What is not marked is stuff."""
    known = panoptic_numbers(source / "lightly-ai+coco128_yolo")
    for folder, annotations, pictures in MORE_PHOTOS:
        facts = json.loads((source / folder / annotations).read_text())
        names = {c["id"]: c["name"] for c in facts["categories"]}
        marks = {}
        for a in facts["annotations"]:
            marks.setdefault(a["image_id"], []).append(a)
        for image in facts["images"]:
            number, file = image["id"], source / folder / pictures / image["file_name"]
            if image["license"] not in LICENCES or number in known or not file.exists():
                continue
            known.add(number)
            photo = cv2.imread(str(file))[..., ::-1]
            rest = np.ones(photo.shape[:2], np.uint8)
            segments = []
            for a in marks.get(number, []):
                mask = np.zeros(photo.shape[:2], np.uint8)
                if a.get("iscrowd"):  # all of its box
                    x, y, w, h = (int(v) for v in a["bbox"])
                    mask[y : y + h, x : x + w] = 1
                else:
                    outlines = [np.array(p).reshape(-1, 2) for p in a["segmentation"]]
                    cv2.fillPoly(mask, [np.round(p).astype(np.int32) for p in outlines], 1)
                    rest[mask > 0] = 0
                segments.append(Segment(names[a["category_id"]], True, a.get("iscrowd", 0), mask))
            yield number, photo, segments + [Segment("rest", False, 0, rest)]


def read_photos(found):
    """Cut-outs of things, squares of stuff by its name, and whole photos."""
    cutouts, stuff, whole = [], {}, []
    for number, photo, segments in found:
        whole.append(photo)
        for s in segments:
            if s.thing and s.name in SIZES and not s.crowd:
                cutout = cut_out(photo, s.mask, s.name, number)
                if cutout:
                    cutouts.append(cutout)
            elif not s.thing:
                square = largest_square(s.mask)
                if square and square[2] >= 72:
                    x, y, size = square
                    stuff.setdefault(s.name, []).append(photo[y : y + size, x : x + size])
    return cutouts, stuff, whole


def cut_out(photo, mask, name, number):
    """A thing cut out of a photo, or None if it is small or in pieces."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    if count < 2:
        return None
    keep = 1 + np.argmax(stats[1:, 4])
    x, y, w, h, area = stats[keep]
    if area < 2500 or area < 0.8 * mask.sum() or min(w, h) < 30 or area < 0.25 * w * h:
        return None
    one = (labels[y : y + h, x : x + w] == keep).astype(np.uint8) * 255
    if name == "person":  # what a person wears or holds is a thing of its own
        outlines, _ = cv2.findContours(one, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(one, outlines, -1, 255, cv2.FILLED)
    one = cv2.GaussianBlur(cv2.erode(one, np.ones((3, 3), np.uint8)), (0, 0), 0.8)
    rgba = np.dstack([photo[y : y + h, x : x + w], one])
    cut = (x <= 1, x + w >= photo.shape[1] - 1, y <= 1, y + h >= photo.shape[0] - 1)
    return Cutout(rgba, name, number, cut)


# What mostly hides what is behind it, from its sides and its top
HIDING = {
    "person", "bicycle", "car", "motorcycle", "bus", "train", "truck", "boat", "fire hydrant",
    "parking meter", "bird", "cat", "dog", "horse", "sheep", "cow", "elephant", "bear", "zebra",
    "giraffe", "potted plant", "teddy bear", "suitcase", "umbrella", "vase", "bottle", "cup",
    "wine glass", "backpack", "handbag", "laptop", "chair",
}  # fmt: skip


def hiding_maps(photo, segments):
    """A map for each large thing that hides its background: 255 in it, 128 around it where nothing
    else is marked, 0 where nothing is known: inside other things and around its foot."""
    marked = np.zeros(photo.shape[:2], np.uint8)
    for s in segments:
        if s.thing:
            marked |= s.mask
    for s in segments:
        if s.crowd or s.name not in HIDING or s.mask.sum() < 0.02 * s.mask.size:
            continue
        rows = np.flatnonzero(s.mask.any(1))
        around = 1 - marked
        around[int(rows[-1] - 0.25 * (rows[-1] - rows[0])) :] = 0
        yield s.mask * 255 + around * (1 - s.mask) * 128


def largest_square(mask):
    """Where the largest square that a mask holds is: x, y, size."""
    padded = cv2.copyMakeBorder(mask, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    reach = cv2.distanceTransform(padded, cv2.DIST_C, 3)
    y, x = np.unravel_index(np.argmax(reach), reach.shape)
    r = int(reach[y, x]) - 1
    return (x - 1 - r, y - 1 - r, 2 * r) if r > 0 else None


def mirrored_tile(picture, size=512):
    """A texture without seams: the picture and its mirror images."""
    p = cv2.resize(picture, (size // 2, size // 2), interpolation=cv2.INTER_AREA)
    top = np.hstack([p, p[:, ::-1]])
    return np.ascontiguousarray(np.vstack([top, top[::-1]]))
