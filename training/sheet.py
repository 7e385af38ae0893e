#!/usr/bin/env python3
"""A contact sheet of frames with their depth: sheet.py FOLDER OUT.png [COUNT [FIRST]]"""

import argparse
import pathlib

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("folder", type=pathlib.Path)
parser.add_argument("out", metavar="OUT.png")
parser.add_argument("count", type=int, nargs="?", default=100)
parser.add_argument("first", type=int, nargs="?", default=0)
if __name__ == "__main__":  # before what takes long to load or is missing
    args = parser.parse_args()

import cv2
import numpy as np


def main():
    folder, out, count, first = args.folder, args.out, args.count, args.first
    depths = sorted(folder.glob("*.d.png"))[first : first + count]
    tiles = []
    for path in depths:
        depth = cv2.imread(str(path), cv2.IMREAD_UNCHANGED) / 65535.0
        photo = next(
            p for p in (path.with_name(path.name[:6] + e) for e in (".jpg", ".png")) if p.exists()
        )
        pair = [
            cv2.imread(str(photo)),
            cv2.applyColorMap((np.sqrt(depth) * 255).astype(np.uint8), cv2.COLORMAP_INFERNO),
        ]
        tile = np.zeros((176, 2 * 176, 3), np.uint8)
        for k, p in enumerate(pair):
            f = 174 / max(p.shape[:2])
            p = cv2.resize(
                p, (int(p.shape[1] * f), int(p.shape[0] * f)), interpolation=cv2.INTER_AREA
            )
            tile[: p.shape[0], 176 * k : 176 * k + p.shape[1]] = p
        cv2.putText(tile, path.name[:6], (2, 172), 0, 0.35, (0, 255, 255), 1)
        tiles.append(tile)
    columns = 5
    while len(tiles) % columns:
        tiles.append(np.zeros_like(tiles[0]))
    cv2.imwrite(
        out, np.vstack([np.hstack(tiles[k : k + columns]) for k in range(0, len(tiles), columns)])
    )


if __name__ == "__main__":
    main()
