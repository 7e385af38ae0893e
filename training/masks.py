#!/usr/bin/env python3
"""Writes photos without depth, each with a map of a thing in it, for train.py --photos.

Usage: masks.py CACHE OUT [LONGER] [--held-out], with the folder where generate.py extracted the sources, and the
px of the longer side
"""

import argparse
import pathlib

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("cache", type=pathlib.Path)
parser.add_argument("out", type=pathlib.Path)
parser.add_argument("longer", type=int, nargs="?", default=320)
parser.add_argument("--held-out", action="store_true")
if __name__ == "__main__":  # before what takes long to load or is missing
    args = parser.parse_args()

import cv2

import photos
from assets import HELD_OUT_SHARE


def main():
    held_out, source, out, longer = args.held_out, args.cache / "src", args.out, args.longer
    out.mkdir(parents=True, exist_ok=True)
    found = [
        photo
        for photo in photos.panoptic_photos(source / "lightly-ai+coco128_yolo")
        if (photo[0] % HELD_OUT_SHARE == 0) == held_out
    ]
    if not held_out:
        found += photos.more_photos(source)
    count = 0
    for number, photo, segments in found:
        size = [round(side * longer / max(photo.shape[:2])) for side in photo.shape[1::-1]]
        small = cv2.resize(photo[..., ::-1], size, interpolation=cv2.INTER_AREA)
        for k, where in enumerate(photos.hiding_maps(photo, segments)):
            name = str(out / f"{number:012d}-{k}")
            cv2.imwrite(name + ".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 95])
            where = cv2.resize(where, size, interpolation=cv2.INTER_NEAREST_EXACT)
            cv2.imwrite(name + ".m.png", where)
            count += 1
    print(f"{count} photos with maps")


if __name__ == "__main__":
    main()
