"""Makes frames of new scenes for some time, for train_gpu.py --stream, which uses and deletes them.

Usage: stream.py CACHE OUT SEED PROCESS SECONDS      CACHE as generate.py leaves it
A file OUT/PROCESS-NUMBER.npz holds some frames of one size: what they show, the root of inverse depth in two bytes,
and their rows and columns.
"""
import argparse
import os
import pathlib
import time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("cache")
parser.add_argument("out")
parser.add_argument("seed", type=int)
parser.add_argument("process", type=int)
parser.add_argument("seconds", type=float)
if __name__ == "__main__":  # before what takes long to load or is missing
    args = parser.parse_args()

import cv2
import numpy as np

import generate
import scenes
from assets import Assets

EACH = 16  # frames in a file
MOST = 2500  # files that wait for their use


def main():
    cache, out, seed, process, seconds = args.cache, args.out, args.seed, args.process, args.seconds
    begin = time.time()
    cv2.setNumThreads(1)
    assets = Assets(pathlib.Path(cache))
    print(f"assets in {time.time() - begin:.1f} s", flush=True)
    names = sorted(scenes.MIX)
    weights = np.array([scenes.MIX[n] for n in names])
    number = files = made = failed = 0
    while time.time() - begin < float(seconds):
        while len(os.listdir(out)) >= MOST:
            time.sleep(1)
        scenes.LONGER = side = 416 if files % 4 == 3 else 288
        both = np.zeros((EACH, 5, side, side), np.uint8)  # picture, root of inverse depth in two bytes
        sizes, k = np.zeros((EACH, 2), np.int32), 0
        while k < EACH and time.time() - begin < float(seconds):
            rng = np.random.default_rng([seed, process, number])
            number += 1
            try:
                picture, inverse = generate.frame(rng, assets, names[rng.choice(len(names), p=weights / weights.sum())])
            except Exception as error:  # a scene that cannot be made
                failed += 1
                if failed <= 5:
                    print(f"{number - 1}: {error!r}", flush=True)
                continue
            top = inverse.max()
            if not np.isfinite(top) or top <= 0:
                continue
            inverse = inverse / top
            if np.ptp(inverse) < 3000 / 65535 or picture.std() < 6:
                continue
            rows, cols = inverse.shape
            root = np.round(np.sqrt(inverse) * 65280).astype(np.uint16)
            both[k, :3, :rows, :cols] = picture.transpose(2, 0, 1)
            both[k, 3, :rows, :cols], both[k, 4, :rows, :cols] = root >> 8, root & 255
            sizes[k] = rows, cols
            k += 1
        if k < EACH:
            break
        part = os.path.join(out, f".{process}-{files}.npz")
        with open(part, "wb") as stream:
            np.savez(stream, both=both, sizes=sizes)
        os.rename(part, os.path.join(out, f"{process}-{files}.npz"))
        files, made = files + 1, made + k
        if files in (1, 10) or files % 50 == 0:
            print(f"{made} frames in {time.time() - begin:.1f} s", flush=True)
    print(f"{made} frames in {time.time() - begin:.1f} s", flush=True)


if __name__ == "__main__":
    main()
