"""Packs frames and photos for train_gpu.py, small enough to send them to another machine.

Usage: pack.py --help

A picture becomes WebP, the square root of inverse depth WebP without loss, of 8 bits: train_gpu.py smooths its steps.
"""
import argparse
import glob
import os
import pathlib

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
kinds = parser.add_subparsers(dest="kind", required=True)
frames = kinds.add_parser("frames", help="frames of generate.py")
frames.add_argument("out")
frames.add_argument("folders", nargs="+")
frames.add_argument("--first", type=int, default=0, help="number of the first frame in their list")
frames.add_argument("--frames", type=int, help="how many of them; all by default")
frames.add_argument("--step", type=int, default=1, help="every how many")
pack = kinds.add_parser("photos", help="photos without depth, with the maps of masks.py")
pack.add_argument("out")
pack.add_argument("cache", help="folder where generate.py extracted the sources")
pack.add_argument("masks", help="folder of masks.py")
if __name__ == "__main__":  # before what takes long to load or is missing
    args = parser.parse_args()

import cv2
import numpy as np

import photos
from assets import HELD_OUT_SHARE

LOSSLESS = 101  # above the qualities of WebP


class Pack:
    """Files in one array of bytes, with their ends."""

    def __init__(self):
        self.parts, self.ends, self.size = [], [], 0

    def add(self, data):
        self.parts.append(np.frombuffer(data, np.uint8))
        self.size += len(data)
        self.ends.append(self.size)

    def arrays(self, name):
        return {name: np.concatenate(self.parts) if self.parts else np.zeros(0, np.uint8),
                name + "_ends": np.array(self.ends, np.int64)}


def webp(picture, quality):
    return cv2.imencode(".webp", picture, [cv2.IMWRITE_WEBP_QUALITY, quality])[1].tobytes()


def save(out, **packs):
    arrays = {}
    for name, pack in packs.items():
        arrays.update(pack.arrays(name))
    np.savez(out, **arrays)
    print(f"{out}: {os.path.getsize(out) / 2**20:.1f} MiB,", *(f"{len(p.ends)} {n}" for n, p in packs.items()))


def pack_frames(out, files):
    pictures, depths = Pack(), Pack()
    for file in files:
        depth = cv2.imread(file, cv2.IMREAD_UNCHANGED)
        picture = cv2.imread(file[:-6] + ".jpg")
        if depth is None or picture is None:
            continue
        pictures.add(webp(picture, 80))
        depths.add(webp(np.round(np.sqrt(depth / 65535) * 255).astype(np.uint8), LOSSLESS))
    save(out, pictures=pictures, depths=depths)


def pack_photos(out, cache, masks, longer=448):
    """Unique photos, maps with their photo's number, and what is seen from the middle of panoramas."""
    pictures, maps, owners, numbers = Pack(), Pack(), [], {}
    source = pathlib.Path(cache) / "src"
    for file in sorted(glob.glob(os.path.join(masks, "*.m.png"))):
        number = int(os.path.basename(file)[:12])
        if number not in numbers:
            numbers[number] = len(numbers)
            pictures.add(webp(cv2.imread(file[:-6] + ".jpg"), 90))
        owners.append(numbers[number])
        maps.add(webp(cv2.imread(file, cv2.IMREAD_GRAYSCALE), LOSSLESS))
    mapped = len(numbers)
    found = [p for p in photos.panoptic_photos(source / "lightly-ai+coco128_yolo") if p[0] % HELD_OUT_SHARE]
    for number, photo, _ in found + list(photos.more_photos(source)):
        if number not in numbers:
            numbers[number] = len(numbers)
            size = [round(side * longer / max(photo.shape[:2])) for side in photo.shape[1::-1]]
            pictures.add(webp(cv2.resize(photo[..., ::-1], size, interpolation=cv2.INTER_AREA), 90))
    rng = np.random.default_rng(7)
    views = 0
    for name, facts in photos.PANORAMAS.items():
        if facts.get("val") or "sky" in facts:
            continue
        folder = "pmndrs+drei-assets" if "drei" in facts else "gkjohnson+3d-demo-data"
        pano = photos.Panorama(source / folder / f"hdri/{name}_1k.hdr", name)
        for k in range(12):
            azimuth = 2 * np.pi * (k + rng.random()) / 12
            view = pano.picture(azimuth, rng.normal(-0.08, 0.15), rng.uniform(0.9, 1.7), 320)
            pictures.add(webp(np.ascontiguousarray(view[..., ::-1]), 90))
            views += 1
    pictures_pack = pictures.arrays("pictures")
    np.savez(out, **pictures_pack, **maps.arrays("maps"), owners=np.array(owners), mapped=mapped, views=views)
    print(f"{out}: {os.path.getsize(out) / 2**20:.1f} MiB, {len(owners)} maps of {mapped} photos, "
          f"{len(numbers) - mapped} other photos, {views} views")


def main():
    cv2.setNumThreads(1)
    if args.kind == "photos":
        pack_photos(args.out, args.cache, args.masks)
        return
    files = [f for folder in args.folders for f in sorted(glob.glob(os.path.join(folder, "*.d.png")))]
    last = None if args.frames is None else args.first + args.frames * args.step
    pack_frames(args.out, files[args.first:last:args.step])


if __name__ == "__main__":
    main()
