"""How well a network orders the pixels of known scenes, and which depth edges it meets, during training.

altiro3D_depth_accuracy measures the exported network, and compares it.
"""
import glob
import os

import cv2
import numpy as np

import torch

from frames import list_frames, read_frame, to_input

LONG_SIDE = 256


def input_size(picture, long_side=LONG_SIDE):
    """Width and height for the network: the picture's shape, in multiples of 32."""
    rows, cols = picture.shape[:2]
    factor = long_side / max(rows, cols)
    return tuple(max(32, 32 * int(round(side * factor / 32))) for side in (cols, rows))


def spearman(a, b):
    """Rank correlation of two flat arrays. Equal values have the mean of their ranks."""
    def ranks(x):
        _, inverse, counts = np.unique(x, return_inverse=True, return_counts=True)
        ends = np.cumsum(counts)
        return (ends - (counts - 1) / 2)[inverse]
    a, b = ranks(a), ranks(b)
    a, b = a - a.mean(), b - b.mean()
    norm = np.sqrt((a * a).sum() * (b * b).sum())
    return float((a * b).sum() / norm) if norm > 0 else 0.0


def predict(net, picture, long_side=LONG_SIDE):
    """Depth of a BGR picture at the network's size."""
    size = input_size(picture, long_side)
    shrinks = size[0] < picture.shape[1] or size[1] < picture.shape[0]
    how = cv2.INTER_AREA if shrinks else cv2.INTER_CUBIC
    x = to_input(cv2.resize(picture, size, interpolation=how))[None]
    with torch.no_grad():
        return net(x)[0, 0].numpy()


def score(depth, truth, known):
    """Rank correlation at the truth's size."""
    if depth.shape != truth.shape:
        depth = cv2.resize(depth, truth.shape[::-1], interpolation=cv2.INTER_LINEAR)
    step = max(1, int(round(np.sqrt(truth.size / 100000))))
    sample = (slice(step // 2, None, step),) * 2
    mask = known[sample]
    return spearman(depth[sample][mask], truth[sample][mask])


def steps(depth):
    """Largest step to the right and lower neighbour."""
    result = np.zeros_like(depth)
    result[:, :-1] = np.abs(np.diff(depth, axis=1))
    result[:-1] = np.maximum(result[:-1], np.abs(np.diff(depth, axis=0)))
    return result


def edges_met(depth, truth, known, side=256):
    """Share of the true edges (steps above 4 % of the range, at 256 px) within 2 px of one of the
    strongest steps of `depth`, of which as many are taken. None if there are few true ones."""
    factor = side / max(truth.shape)
    size = tuple(int(round(s * factor)) for s in truth.shape[::-1])
    truth = cv2.resize(truth, size, interpolation=cv2.INTER_NEAREST)
    known = cv2.resize(known.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
    known = cv2.erode(known, np.ones((3, 3), np.uint8)) > 0
    depth = cv2.resize(depth, size, interpolation=cv2.INTER_AREA)
    edges = (steps(truth) > 0.04 * np.ptp(truth[known])) & known
    count = int(edges.sum())
    if count < 50:
        return None
    strength = np.where(known, steps(depth), -1)
    found = strength >= np.partition(strength.ravel(), -count)[-count]
    found = cv2.dilate(found.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    return (found & edges).sum() / count


# --- scenes: (name, picture, true inverse depth, known) ------------------------------------------

def scene_of_frame(frame):
    picture, depth = read_frame(frame)
    return os.path.basename(frame[0]), picture, depth, np.ones(depth.shape, bool)


def val_scenes(root, most):
    """A dictionary: name of the set -> scenes, evenly spread over it."""
    sets = {}
    for folder in sorted(glob.glob(os.path.join(root, "val-*"))):
        frames = list_frames([folder])
        if frames:
            step = max(1, len(frames) // most)
            sets[os.path.basename(folder)] = (scene_of_frame(f) for f in frames[::step][:most])
    return sets


def scene_of_files(name, picture, depth, metric=False):
    photo, raw = cv2.imread(picture), cv2.imread(depth, cv2.IMREAD_UNCHANGED)
    raw = raw.astype(np.float32)
    known = np.isfinite(raw) & (raw > 0)
    truth = np.where(known, raw, 1)
    truth = np.where(known, 1 / truth if metric else truth, 0).astype(np.float32)
    return name, photo, truth, known


def real_scenes(data, validation):
    """Real and foreign scenes by set: those to validate with, or those for the end."""
    if not data:
        return {}
    sets = {}
    with open(os.path.join(data, "middlebury", "scenes.csv"), encoding="utf-8") as stream:
        rows = [line.strip().split(",") for line in stream][1:]
    stereo = [scene_of_files(r[0], *(os.path.join(data, "middlebury", r[0], r[i]) for i in (2, 4)))
              for r in rows if len(r) > 4 and (r[0] in ("Teddy", "Cones")) == validation]
    sets["stereo"] = stereo
    folder = os.path.join(data, "rgbd", "slambook2",
                          "ch5_rgbd" if validation else "ch12_dense_rgbd")
    ending = "pgm" if validation else "png"
    sets["kinect" if validation else "rendered"] = [
        scene_of_files(str(i), f"{folder}/color/{i}.png", f"{folder}/depth/{i}.{ending}", True)
        for i in range(1, 6)]
    return sets


def scores_of(net, scenes):
    """Mean rank correlation, and mean share of the edges met, over scenes."""
    order, edges = [], []
    for _, picture, truth, known in scenes:
        depth = predict(net, picture)
        order.append(score(depth, truth, known))
        edges.append(edges_met(depth, truth, known))
    edges = [e for e in edges if e is not None]
    return tuple(float(np.mean(v)) if v else 0.0 for v in (order, edges))
