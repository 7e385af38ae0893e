"""Trains the depth network on a GPU for a given time. Usage: train_gpu.py --help

Frames and photos, packed by pack.py, lie in the GPU's memory. Crops and augmentation are those of frames.py, for whole
batches. Photos without depth have two losses: that of their maps (loss.py), and that of a teacher, who sees the clean
photo and its mirror image, while the network sees it recoloured and blurred. The teacher is

- the running mean of the weights so far; then pieces of photos lie on others; or
- exported networks (--teachers), the mean of what they say at several sizes about the whole photo.

With --prints, other pictures lie flat on planes of frames and photos. The depth remains that of the plane.
"""
import argparse
import concurrent.futures
import csv
import os
import queue
import sys
import threading
import time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--frames", nargs="+", required=True, help="packs of frames")
parser.add_argument("--photos", required=True, help="pack of photos without depth")
parser.add_argument("--stream", help="folder of stream.py, which makes more frames meanwhile")
parser.add_argument("--keep-stream", action="store_true", help="leave the files there, for another training")
parser.add_argument("--most", type=int, default=36000, help="frames of one size in memory")
parser.add_argument("--start", help="exported network or checkpoint to begin with")
parser.add_argument("--encoder", help="mobilenet_v2_1.0_224_quant.tflite, to begin with")
parser.add_argument("--out", required=True, help="folder of checkpoints and log")
parser.add_argument("--seconds", type=float, default=500, help="until the last checkpoint is written")
parser.add_argument("--batch", type=int, default=96, help="pictures of 224 x 224; more of smaller ones")
parser.add_argument("--rate", type=float, default=1e-3, help="of the decoder")
parser.add_argument("--encoder-rate", type=float, default=2.5e-4)
parser.add_argument("--last", type=float, default=0, help="share of the rates at the end")
parser.add_argument("--hold", type=float, default=0.3, help="pull of the encoder to where it began")
parser.add_argument("--edges", type=float, default=0.5, help="weight of the edges' loss")
parser.add_argument("--photo-share", type=float, default=0.22, help="of the pictures")
parser.add_argument("--photo-weight", type=float, default=0.5, help="weight of the maps' loss")
parser.add_argument("--mapped-share", type=float, default=0.6, help="of the photos: those with maps")
parser.add_argument("--teachers", nargs="*", help="exported networks, in place of the running mean")
parser.add_argument("--teacher-weight", type=float, default=0.7, help="weight of the teacher's loss")
parser.add_argument("--prints", type=float, default=0, help="share of the pictures that get a print, if they can")
parser.add_argument("--keep", type=float, default=0.998, help="of the averaged weights, per batch")
parser.add_argument("--snapshots", type=float, nargs="*", default=[0.7, 0.85], help="shares of the time")
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("--device", default="cuda")
if __name__ == "__main__":  # before what takes long to load or is missing
    args = parser.parse_args()

import cv2
import numpy as np
import torch
import torch.nn.functional as F

from loss import depth_loss, hiding_loss
from network import DepthNet, load_encoder, load_onnx

# height, width and likelihood of batches
SHAPES = [(160, 224, 1), (192, 192, 1), (224, 160, 0.6), (192, 256, 3), (256, 192, 2), (256, 256, 1.5),
          (224, 320, 1.5), (320, 256, 1), (288, 384, 2), (384, 288, 1), (384, 384, 0.7)]
PIXELS = 224 * 224  # of a picture that counts as one in a batch
WHOLE = (256, 320, 384)  # longer sides at which teachers see a whole photo


# --- pictures in the GPU's memory ----------------------------------------------------------------

def unpack(file, name, how=cv2.IMREAD_COLOR):
    """The pictures of a pack, as arrays."""
    data = np.load(file)
    code, ends = data[name], data[name + "_ends"]
    parts = np.split(code, ends[:-1]) if len(ends) else []
    with concurrent.futures.ThreadPoolExecutor() as pool:
        return list(pool.map(lambda part: cv2.imdecode(part, how), parts))


def padded(arrays, side):
    """[n, channels, side, side] of arrays that are no larger."""
    depth = 3 if arrays[0].ndim == 3 else 1
    out = np.zeros((len(arrays), depth, side, side), np.uint8)
    for own, array in zip(out, arrays):
        array = array[..., ::-1].transpose(2, 0, 1) if depth == 3 else array[None]
        own[:, :array.shape[1], :array.shape[2]] = array
    return torch.from_numpy(out)


def smoothed(codes):
    """Codes 0..255 without their steps: each is the mean of those beside it that differ by one at most."""
    x = codes.float()
    total, count = torch.zeros_like(x), torch.zeros_like(x)
    wide = F.pad(x, (3, 3, 3, 3), mode="replicate")
    for i in range(7):
        for j in range(7):
            other = wide[:, :, i:i + x.shape[2], j:j + x.shape[3]]
            like = ((other - x).abs() < 1.5).float()
            total += other * like
            count += like
    return (total / count / 255).half()


class Pool:
    """Pictures of one size of memory, with their own sizes, and roots of inverse depth. The oldest make room for new
    ones."""

    def __init__(self, most, side, device, depth):
        self.side, self.most, self.added = side, most, 0
        self.pictures = torch.zeros(most, 3, side, side, dtype=torch.uint8, device=device)
        self.rows, self.cols = torch.ones(most, device=device), torch.ones(most, device=device)
        self.roots = torch.zeros(most, 1, side, side, dtype=torch.half, device=device) if depth else None

    def add(self, pictures, sizes, roots=None):
        """`sizes`: [n, 2], rows and columns."""
        at = (self.added + torch.arange(len(pictures), device=pictures.device)) % self.most
        self.pictures[at] = pictures
        self.rows[at], self.cols[at] = sizes[:, 0].float(), sizes[:, 1].float()
        if roots is not None:
            self.roots[at] = roots
        self.added += len(pictures)

    def add_files(self, pictures, codes=None):
        device = self.pictures.device
        for i in range(0, len(pictures), 64):
            sizes = torch.tensor([p.shape[:2] for p in pictures[i:i + 64]], device=device)
            roots = smoothed(padded(codes[i:i + 64], self.side).to(device)) if codes else None
            self.add(padded(pictures[i:i + 64], self.side).to(device), sizes, roots)

    def __len__(self):
        return min(self.added, self.most)


class Stream(threading.Thread):
    """Reads what stream.py writes, while the training goes on."""

    def __init__(self, folder, pin, keep):
        super().__init__(daemon=True)
        self.folder, self.pin, self.keep, self.ready = folder, pin, keep, queue.Queue(12)

    def run(self):
        known = set()
        while True:
            names = [n for n in os.listdir(self.folder) if not n.startswith(".") and n not in known]
            for name in names:
                file = os.path.join(self.folder, name)
                data = np.load(file)
                parts = [torch.from_numpy(data[key]) for key in ("both", "sizes")]
                self.ready.put([p.pin_memory() for p in parts] if self.pin else parts)
                if self.keep:
                    known.add(name)
                else:
                    os.remove(file)
            if not names:
                time.sleep(0.5)

    def add_to(self, pools, device, most=3):
        for _ in range(most):
            try:
                both, sizes = (x.to(device, non_blocking=True) for x in self.ready.get_nowait())
            except queue.Empty:
                return
            roots = ((both[:, 3:4].float() * 256 + both[:, 4:].float()) / 65280).half()
            pools[both.shape[-1]].add(both[:, :3], sizes, roots)


def uniform(low, high, *shape, device):
    return torch.rand(shape, device=device) * (high - low) + low


class Crops:
    """Random parts of a pool's pictures: where they are, so that they can be seen in several shapes."""

    def __init__(self, pool, index, aspect):
        n, device = len(index), index.device
        self.pool, self.index = pool, index
        rows, cols = pool.rows[index], pool.cols[index]
        aspect = aspect * torch.exp(uniform(-0.14, 0.14, n, device=device))
        height = torch.minimum(rows, cols / aspect)
        part = torch.where(torch.rand(n, device=device) < 0.5, uniform(0.6, 1, n, device=device), torch.ones_like(rows))
        self.height = height * part
        self.width = torch.minimum(cols, self.height * aspect)
        self.y = torch.rand(n, device=device) * (rows - self.height) + self.height / 2
        self.x = torch.rand(n, device=device) * (cols - self.width) + self.width / 2
        self.sign = torch.where(torch.rand(n, device=device) < 0.5, 1.0, -1.0)
        self.turn = torch.randn(n, device=device) * 0.05 * (torch.rand(n, device=device) < 0.3)
        self.rows, self.cols = rows, cols

    def grid(self, height, width):
        device, side = self.index.device, self.pool.side

        def wide(x):
            return x[:, None, None]

        v = ((torch.arange(height, device=device) + 0.5) / height - 0.5)[None, :, None] * wide(self.height)
        u = ((torch.arange(width, device=device) + 0.5) / width - 0.5)[None, None, :] * wide(self.width * self.sign)
        c, s = wide(self.turn.cos()), wide(self.turn.sin())
        y = torch.minimum((wide(self.y) + c * v + s * u).clamp(min=0.5), wide(self.rows) - 0.5)
        x = torch.minimum((wide(self.x) + c * u - s * v).clamp(min=0.5), wide(self.cols) - 0.5)
        return torch.stack([2 * x / side - 1, 2 * y / side - 1], -1)

    def pictures(self, height, width):
        """RGB 0..1. Two points a pixel and direction, so that smaller pictures are means."""
        x = self.pool.pictures[self.index].float()
        x = F.grid_sample(x, self.grid(2 * height, 2 * width), "bilinear", "border", align_corners=False)
        return F.avg_pool2d(x, 2) / 255

    def values(self, source, height, width, how="nearest"):
        """The value of one point of each pixel, so that edges stay edges."""
        return F.grid_sample(source.float(), self.grid(height, width), how, "border", align_corners=False)


# --- augmentation --------------------------------------------------------------------------------

LUMA = [[16, 11, 10, 16, 24, 40, 51, 61], [12, 12, 14, 19, 26, 58, 60, 55], [14, 13, 16, 24, 40, 57, 69, 56],
        [14, 17, 22, 29, 51, 87, 80, 62], [18, 22, 37, 56, 68, 109, 103, 77], [24, 35, 55, 64, 81, 104, 113, 92],
        [49, 64, 78, 87, 103, 121, 120, 101], [72, 92, 95, 98, 112, 100, 103, 99]]
CHROMA = [[17, 18, 24, 47], [18, 21, 26, 66], [24, 26, 56, 99], [47, 66, 99, 99]]
TO_YCC = [[0.299, 0.587, 0.114], [-0.1687, -0.3313, 0.5], [0.5, -0.4187, -0.0813]]


class Jpeg:
    """What JPEG does to pictures: the rounding of its cosine transform, and coarse colour."""

    def __init__(self, device):
        chroma = np.full((8, 8), 99)
        chroma[:4, :4] = CHROMA
        self.tables = torch.tensor(np.array([LUMA, chroma, chroma]), dtype=torch.float32, device=device)
        k, i = np.mgrid[0:8, 0:8]
        cosine = np.cos((2 * i + 1) * k * np.pi / 16) * np.where(k == 0, np.sqrt(1 / 8), 0.5)
        self.cosine = torch.tensor(cosine, dtype=torch.float32, device=device)
        self.to_ycc = torch.tensor(TO_YCC, device=device)
        self.to_rgb = torch.linalg.inv(self.to_ycc)

    def __call__(self, x, quality):
        n, _, h, w = x.shape
        y = torch.einsum("ij,njhw->nihw", self.to_ycc, x * 255 - 128)
        y = torch.cat([y[:, :1], F.interpolate(F.avg_pool2d(y[:, 1:], 2), scale_factor=2.0)], 1)
        y = y.reshape(n, 3, h // 8, 8, w // 8, 8).transpose(3, 4)
        factor = torch.where(quality < 50, 50 / quality, 2 - quality / 50)
        table = (self.tables[None] * factor[:, None, None, None]).clamp(min=1)[:, :, None, None]
        y = self.cosine @ y @ self.cosine.T
        y = torch.round(y / table) * table
        y = self.cosine.T @ y @ self.cosine
        y = y.transpose(3, 4).reshape(n, 3, h, w)
        return (torch.einsum("ij,njhw->nihw", self.to_rgb, y) + 128) / 255


def filters(n, device):
    """[n, 7, 7]: most are out of focus, the others shaken or sharpened."""
    at = torch.arange(-3.0, 4, device=device)

    def wide(x):
        return x[:, None, None]

    square = at[:, None] ** 2 + at[None] ** 2
    soft = torch.exp(-square[None] / (2 * wide(uniform(0.4, 1.6, n, device=device)) ** 2))
    angle, length = uniform(0, np.pi, n, device=device), uniform(1, 3, n, device=device)
    along = wide(angle.cos()) * at[None, None] + wide(angle.sin()) * at[None, :, None]
    across = wide(angle.cos()) * at[None, :, None] - wide(angle.sin()) * at[None, None]
    shaken = (1.2 - across.abs()).clamp(0, 1) * (wide(length) + 0.5 - along.abs()).clamp(0, 1)
    narrow = torch.exp(-square / 2)
    narrow = narrow / narrow.sum()
    point = (square == 0).float()
    sharp = point + wide(uniform(0.3, 1, n, device=device)) * (point - narrow)
    kind = wide(torch.rand(n, device=device))
    soft, shaken = (k / k.sum((1, 2), keepdim=True) for k in (soft, shaken))
    return torch.where(kind < 0.36, soft, torch.where(kind < 0.6, shaken, sharp))


def augment(x, jpeg, strength=1.0, looks=None):
    """What cameras, programs and compression do to pictures, RGB 0..1. `looks`: pictures whose colours they can get."""
    n, _, h, w = x.shape
    device = x.device

    def chance(p):
        return torch.rand(n, 1, 1, 1, device=device) < p

    def normal(deviation, channels=1):
        return torch.randn(n, channels, 1, 1, device=device) * deviation * strength

    which = torch.randperm(n, device=device)[:max(1, int(0.25 * n))]
    k = len(which)
    kernels = filters(k, device).repeat_interleave(3, 0)[:, None]
    part = F.pad(x[which], (3, 3, 3, 3), mode="reflect").reshape(1, 3 * k, h + 6, w + 6)
    x = x.index_copy(0, which, F.conv2d(part, kernels, groups=3 * k).reshape(k, 3, h, w))
    if looks is not None:  # colours of other pictures
        other = looks[torch.randint(len(looks), (n,), device=device)]
        mean, deviation = x.mean((2, 3), keepdim=True), x.std((2, 3), keepdim=True)
        like = (x - mean) / (deviation + 0.02) * other.std((2, 3), keepdim=True) + other.mean((2, 3), keepdim=True)
        x = torch.where(chance(0.2), torch.lerp(x, like, torch.rand(n, 1, 1, 1, device=device)), x)
    # exposure, white balance, contrast, tone
    y = x * torch.exp(normal(0.25) + normal(0.08, 3))
    mean = y.mean((1, 2, 3), keepdim=True)
    y = ((y - mean) * torch.exp(normal(0.2)) + mean).clamp(1e-4, 1) ** torch.exp(normal(0.25))
    x = torch.where(chance(0.8), y, x)
    # saturation, hue
    grey = (x * jpeg.to_ycc[0][:, None, None]).sum(1, keepdim=True)
    saturation = torch.where(chance(0.85), uniform(0, 1.8, n, 1, 1, 1, device=device), torch.zeros(1, device=device))
    y = grey + (x - grey) * saturation
    mix = torch.eye(3, device=device) + torch.randn(n, 3, 3, device=device) * 0.12 * chance(0.3)[:, 0] * strength
    y = torch.einsum("nij,njhw->nihw", mix / mix.sum(2, keepdim=True), y)
    x = torch.where(chance(0.6), y, x)
    # colours in another order
    x = torch.where(chance(0.05), x[:, torch.randperm(3, device=device)], x)
    # dark corners
    v, u = (torch.linspace(-1, 1, side, device=device) ** 2 for side in (h, w))
    corners = (v[:, None] + u[None])[None, None] / 2
    x = x * (1 - uniform(0, 0.5, n, 1, 1, 1, device=device) * chance(0.2) * corners)
    x = x + torch.randn_like(x) * uniform(0.005, 0.05, n, 1, 1, 1, device=device) * chance(0.4) * strength
    x = x.clamp(0, 1)
    x = torch.where(chance(0.4), jpeg(x, uniform(25, 95, n, device=device)).clamp(0, 1), x)
    return x


# --- photos without depth ------------------------------------------------------------------------

def pieces(n, h, w, share, device):
    """[n, 1, h, w]: 1 in a rectangle of some pictures, where another picture is to be seen."""
    area = uniform(0.2, 0.5, n, device=device)
    tall = torch.exp(uniform(-0.5, 0.5, n, device=device))
    rows, cols = (area.sqrt() * tall).clamp(max=1), (area.sqrt() / tall).clamp(max=1)
    top, left = torch.rand(n, device=device) * (1 - rows), torch.rand(n, device=device) * (1 - cols)
    y = ((torch.arange(h, device=device) + 0.5) / h)[None, :, None]
    x = ((torch.arange(w, device=device) + 0.5) / w)[None, None]
    inside = (y > top[:, None, None]) & (y < (top + rows)[:, None, None]) & \
        (x > left[:, None, None]) & (x < (left + cols)[:, None, None])
    some = torch.rand(n, 1, 1, device=device) < share
    return (inside & some).float()[:, None]


def planes(depth, tries=12, side=12, most=0.02):
    """A nearly plane place for each picture: its centre and half its size [n, 2] in -1..1, the slopes of `depth`
    [n, 1, h, w] in it over its middle depth [n, 2], and whether one was found [n]."""
    n, _, h, w = depth.shape
    device = depth.device
    half = uniform(0.15, 0.45, n, tries, 1, device=device) * torch.exp(uniform(-0.4, 0.4, n, tries, 2, device=device))
    middle = uniform(-1, 1, n, tries, 2, device=device) * (1 - half).clamp(min=0)
    at = torch.linspace(-1, 1, side, device=device)
    u, v = at[None, :].expand(side, side), at[:, None].expand(side, side)
    points = middle[:, :, None, None] + torch.stack([u, v], -1) * half[:, :, None, None]
    values = F.grid_sample(depth, points.view(n, tries * side, side, 2), "nearest", "border", align_corners=False)
    values = values.view(n, tries, side, side)
    mean = values.mean((2, 3), keepdim=True)
    slopes = [(values * x).mean((2, 3), keepdim=True) / x.square().mean() for x in (u, v)]
    error = (values - mean - slopes[0] * u - slopes[1] * v).abs().amax((2, 3))
    scale = (depth - depth.mean((2, 3), keepdim=True)).abs().mean((1, 2, 3))
    error, best = (error / (scale[:, None] + 1e-6)).min(1)
    own = torch.arange(n, device=device)
    slopes = torch.cat(slopes, 2)[own, best, :, 0] / mean[own, best, :, 0].clamp(min=1e-3)
    return middle[own, best], half[own, best], slopes, error < most


def printed(pictures, depth, others, share, most=0.02, inverse=True):
    """Lays `others` flat on planes of `share` of the pictures, if they have any. `inverse`: whether the slope of
    `depth` tells the perspective. Returns the pictures, and where prints are [n, 1, h, w]."""
    n, _, h, w = pictures.shape
    device = pictures.device
    middle, half, slopes, found = planes(depth, most=most)
    slopes = slopes.clamp(-0.6, 0.6) if inverse else 0.15 * torch.randn(n, 2, device=device)
    found &= torch.rand(n, device=device) < share
    y = ((torch.arange(h, device=device) + 0.5) / h * 2 - 1)[None, :, None]
    x = ((torch.arange(w, device=device) + 0.5) / w * 2 - 1)[None, None]
    u = (x - middle[:, 0, None, None]) / half[:, 0, None, None]
    v = (y - middle[:, 1, None, None]) / half[:, 1, None, None]
    inside = (u.abs() < 1) & (v.abs() < 1) & found[:, None, None]
    nearer = (1 + slopes[:, 0, None, None] * u + slopes[:, 1, None, None] * v).clamp(min=0.1)
    angle = 0.1 * torch.randn(n, 1, 1, device=device)
    size = uniform(0.6, 0.85, n, 1, 1, device=device)
    s = (angle.cos() * u + angle.sin() * v) / nearer / size
    t = (angle.cos() * v - angle.sin() * u) / nearer / size
    where = (inside & (s.abs() < 1) & (t.abs() < 1)).float()[:, None]
    content = F.grid_sample(F.avg_pool2d(others, 2), torch.stack([s, t], -1), "bilinear", "border", align_corners=False)
    border = torch.rand(n, 3, 1, 1, device=device) * (torch.rand(n, 1, 1, 1, device=device) < 0.7)
    edge = uniform(0.75, 1.1, n, 1, 1, device=device)
    content = torch.where((torch.maximum(s.abs(), t.abs()) > edge)[:, None], border, content)
    content = (content * uniform(0.55, 1.1, n, 1, 1, 1, device=device)).clamp(0, 1)
    return torch.where(where > 0, content, pictures), where


def standard(x, weight, least):
    """x without its weighted mean, per picture, over its mean deviation."""
    total = weight.sum((1, 2, 3), keepdim=True) + 1e-6
    x = x - (x * weight).sum((1, 2, 3), keepdim=True) / total
    deviation = (x.abs() * weight).sum((1, 2, 3), keepdim=True) / total
    return x / deviation.clamp(min=least), deviation.clamp(min=least)


def opinions(net, pictures, height, width):
    """What a network says of pictures and of their mirror images, [2, n, 1, height, width]."""
    n = len(pictures)
    with torch.autocast(pictures.device.type, torch.bfloat16):
        both = net(torch.cat([pictures, pictures.flip(3)]) * 2 - 1)
    both = torch.cat([both[:n], both[n:].flip(3)]).float()
    return F.interpolate(both, (height, width), mode="bilinear", align_corners=False).view(2, n, 1, height, width)


def teacher_loss(prediction, both, weight):
    """Difference from the teacher where `weight` is 1: the layout of 8 px, and edges of which its two opinions,
    `both` [2, n, 1, h, w], are sure. Returns the two."""
    lesson = both.mean(0)
    small = F.avg_pool2d(weight, 8)
    small = (small > 0.99).float()
    a, _ = standard(F.avg_pool2d(prediction, 8), small, 0.1)
    b, deviation = standard(F.avg_pool2d(lesson, 8), small, 0.1)
    doubt = F.avg_pool2d((both[0] - both[1]).abs(), 8) / deviation
    error = F.smooth_l1_loss(a, b, beta=0.1, reduction="none")
    known = small * (doubt < 0.6).float() * (small.mean((1, 2, 3), keepdim=True) > 0.1).float()
    layout = (error.clamp(max=2) * known).sum() / (known.sum() + 1)
    own, _ = standard(prediction, weight, 0.1)
    teachers = both / deviation
    edges = 0
    for d in (3, 8):
        for axis in (2, 3):
            def step(x):
                length = x.shape[axis] - d
                return x.narrow(axis, d, length) - x.narrow(axis, 0, length)

            first, second = step(teachers[0]), step(teachers[1])
            valid = weight.narrow(axis, d, weight.shape[axis] - d) * weight.narrow(axis, 0, weight.shape[axis] - d)
            sure = ((torch.minimum(first.abs(), second.abs()) > 0.2) & (first * second > 0)).float() * valid
            error = (step(own) - (first + second) / 2).abs()
            error = torch.where(error < 1, error, 1 + 0.1 * (error - 1))
            edges = edges + (error * sure).sum() / (sure.sum() + 100)
    return layout, edges / 4


def lessons_of(nets, photos, count=32):
    """What teachers say of whole photos: two opinions [n, 2, side, side], the second about the mirror images. Each is
    the mean of all teachers and sizes."""
    device, side = photos.pictures.device, photos.side
    lessons = torch.zeros(len(photos), 2, side, side, dtype=torch.half, device=device)
    shapes = {}
    for i, (rows, cols) in enumerate(zip(photos.rows[:len(photos)].tolist(), photos.cols[:len(photos)].tolist())):
        shapes.setdefault((int(rows), int(cols)), []).append(i)
    for (rows, cols), own in shapes.items():
        for k in range(0, len(own), count):
            index = torch.tensor(own[k:k + count], device=device)
            pictures = photos.pictures[index, :, :rows, :cols].float() / 127.5 - 1
            total = 0
            for longer in WHOLE:
                size = [max(32, 32 * round(x * longer / max(rows, cols) / 32)) for x in (rows, cols)]
                small = F.interpolate(pictures, size, mode="bilinear", antialias=True)
                for net in nets:
                    both = net(torch.cat([small, small.flip(3)]))
                    both = torch.stack([both[:len(index)], both[len(index):].flip(3)]).flatten(0, 1)
                    both = standard(both, torch.ones_like(both), 1e-3)[0]
                    total = total + F.interpolate(both, (rows, cols), mode="bilinear", align_corners=False)
            total = total / (len(nets) * len(WHOLE))
            lessons[index, :, :rows, :cols] = total.view(2, len(index), rows, cols).transpose(0, 1).half()
    return lessons


# --- training ------------------------------------------------------------------------------------

def read_packs(args, device):
    """Two pools of frames, by their size; the pool of photos with its maps."""
    small, large = ([], []), ([], [])
    for file in args.frames:
        for picture, code in zip(unpack(file, "pictures"), unpack(file, "depths", cv2.IMREAD_GRAYSCALE)):
            own = small if max(picture.shape) <= 288 else large
            own[0].append(picture)
            own[1].append(code)
    frames = {}
    for (pictures, codes), side, most in ((small, 288, 36000), (large, 416, 14000)):
        frames[side] = Pool(min(most, args.most) if args.stream else len(pictures), side, device, True)
        frames[side].add_files(pictures, codes)
    facts = np.load(args.photos)
    pictures = unpack(args.photos, "pictures")
    photos = Pool(len(pictures), 448, device, False)
    photos.add_files(pictures)
    maps = padded(unpack(args.photos, "maps", cv2.IMREAD_GRAYSCALE), 448).to(device)
    owners = torch.tensor(facts["owners"], device=device)
    return frames, photos, maps, owners


class Batches:
    """Draws batches: frames with roots of inverse depth, and photos with maps and lessons: two opinions of the
    teachers about them, or, without teachers, the photos at 256 px for the running mean."""

    def __init__(self, frames, photos, maps, owners, lessons, args, device):
        self.frames, self.photos, self.maps, self.owners = frames, photos, maps, owners
        self.lessons, self.device = lessons, device
        self.photo_share, self.mapped_share, self.prints = args.photo_share, args.mapped_share, args.prints
        self.jpeg = Jpeg(device)
        self.first = int(owners.max()) + 1  # of the photos without maps

    def draw(self, height, width, count):
        device = self.device
        n = max(2, int(round(count * self.photo_share)))
        # photos: some have maps, the others are drawn from all that have none
        mapped = max(1, int(self.mapped_share * n))
        which = torch.randint(len(self.maps), (mapped,), device=device)
        others = torch.randint(self.first, len(self.photos), (n - mapped,), device=device)
        index = torch.cat([self.owners[which], others])
        crops = Crops(self.photos, index, width / height)
        clean = crops.pictures(height, width)
        whole = torch.zeros(n, 1, self.photos.side, self.photos.side, device=device, dtype=torch.uint8)
        whole[:mapped] = self.maps[which]
        where = crops.values(whole, height, width)
        if self.lessons is None:
            factor = 256 / max(height, width)
            lesson = crops.pictures(*(max(32, 32 * round(side * factor / 32)) for side in (height, width)))
        else:
            lesson = crops.values(self.lessons[index], height, width, "bilinear")

        count -= n
        pictures, roots = [], []
        shares = (0.65, 0.35) if max(height, width) <= 288 else (0.3, 0.7)
        pools = [(pool, share) for pool, share in zip(self.frames.values(), shares) if len(pool)]
        total = sum(share for _, share in pools)
        for pool, share in pools:
            index = torch.randint(len(pool), (int(round(count * share / total)),), device=device)
            own = Crops(pool, index, width / height)
            pictures.append(own.pictures(height, width))
            roots.append(own.values(pool.roots[index], height, width))
        pictures, roots = torch.cat(pictures), torch.cat(roots)
        at = torch.arange(len(roots), device=device)
        flat = roots.square().std((1, 2, 3)) < 0.01  # nothing to order: another one in its place
        at = torch.where(flat, (at + 1) % len(roots), at)
        pictures, roots = pictures[at], roots[at]
        if self.prints > 0:
            both = torch.cat([pictures, clean])
            others = both[torch.randperm(len(both), device=device)]
            pictures = printed(pictures, roots.square(), others[:len(pictures)], self.prints)[0]
            if self.lessons is not None:
                mean = lesson.mean(1, keepdim=True)
                clean, print_at = printed(clean, mean, others[len(pictures):], self.prints, 0.12, False)
                where = where * (1 - print_at)
        pictures = augment(pictures, self.jpeg, 1.0, clean)
        return pictures, roots, clean, where, lesson


def share_of(time_share, last, warm=0.02):
    """Learning rate: a short rise, then half a cosine down to the last one."""
    fall = 0.5 * (1 + np.cos(np.pi * min(1, max(0, time_share - warm) / (1 - warm))))
    return min(1, time_share / warm) * (last + (1 - last) * fall)


def groups_of(net, args):
    """The decoder, its laterals, and the encoder: slower, and slowest where features are the most general."""
    blocks = list(net.encoder.blocks)
    groups = [{"params": [p for name, part in net.named_children() if name not in ("encoder", "lateral")
                          for p in part.parameters()], "share": 1.0, "weight_decay": 1e-4},
              {"params": list(net.lateral.parameters()), "share": 0.2, "weight_decay": 1e-4}]
    early = list(net.encoder.first.parameters()) + [p for b in blocks[:4] for p in b.parameters()]
    late = [p for b in blocks[4:] for p in b.parameters()]
    share = args.encoder_rate / args.rate
    return groups + [{"params": early, "share": 0.4 * share, "weight_decay": 0},
                     {"params": late, "share": share, "weight_decay": 0}]


def save(file, **state):
    torch.save(state, file + ".part")
    os.replace(file + ".part", file)


def state_of(net):
    return {name: value.detach().float().cpu().contiguous() for name, value in net.state_dict().items()}


def fill(net, file):
    """Weights from an exported network, or the mean ones of a checkpoint."""
    if file.endswith(".pt"):
        net.load_state_dict(torch.load(file, map_location="cpu")["mean"])
    else:
        load_onnx(net, file)
    return net


def main():

    begin = time.time()
    device = torch.device(args.device)
    on_gpu = device.type == "cuda"
    torch.manual_seed(args.seed)
    random = np.random.default_rng(args.seed)
    torch.backends.cuda.matmul.allow_tf32 = torch.backends.cudnn.allow_tf32 = True
    os.makedirs(args.out, exist_ok=True)
    log = csv.writer(open(os.path.join(args.out, "log.csv"), "w", buffering=1))
    log.writerow("seconds batch seen rate loss error order edges hidden slope layout steps".split())

    net, mean = DepthNet(), DepthNet()
    if args.start:
        fill(net, args.start)
    elif args.encoder:
        load_encoder(net.encoder, args.encoder)
    else:
        sys.exit("train_gpu.py: expected --start or --encoder")
    mean.load_state_dict(net.state_dict())
    # Channels last would take three quarters of the time, but cuDNN 9 first builds kernels for 12 s per shape.
    net, mean = net.to(device), mean.to(device)
    mean.requires_grad_(False)
    frames, photos, maps, owners = read_packs(args, device)
    lessons = None
    if args.teachers:
        with torch.no_grad():
            lessons = lessons_of([fill(DepthNet(), file).to(device) for file in args.teachers], photos)
    data = Batches(frames, photos, maps, owners, lessons, args, device)
    print(f"{time.time() - begin:.1f} s: {[len(f) for f in frames.values()]} frames, {len(photos)} photos, "
          f"{len(maps)} maps", flush=True)
    stream = None
    if args.stream:
        stream = Stream(args.stream, on_gpu, args.keep_stream)
        stream.start()

    optimizer = torch.optim.AdamW(groups_of(net, args), lr=args.rate, **({"fused": True} if on_gpu else {}))
    own, averaged = list(net.parameters()), list(mean.parameters())
    held = [p for p in net.encoder.parameters()]
    anchors = [p.detach().clone() for p in held]
    likely = np.array([s[2] for s in SHAPES]) / sum(s[2] for s in SHAPES)
    sums, count = torch.zeros(8, device=device), 0
    step = seen = 0
    snapshots = sorted(args.snapshots)
    first_step = saved = time.time()
    while True:
        part = (time.time() - begin) / (args.seconds - 3)
        if part >= 1:
            break
        height, width, _ = SHAPES[random.choice(len(SHAPES), p=likely)]
        number = max(4, int(round(args.batch * PIXELS / (height * width))))
        rate = share_of(part, args.last)
        for group in optimizer.param_groups:
            group["lr"] = args.rate * rate * group["share"]
        with torch.no_grad():
            if stream:
                stream.add_to(frames, device)
            pictures, roots, clean, where, lesson = data.draw(height, width, number)
            n, m = len(pictures), len(clean)
            other = torch.roll(torch.arange(m, device=device), 1)
            piece = pieces(m, height, width, 0.5 if lessons is None and part > 0.33 else 0.0, device)
            strong = augment(clean, data.jpeg, 1.5)
            mixed = torch.where(piece > 0, strong[other], strong)
            where = where * (piece.amax((1, 2, 3), keepdim=True) == 0)
            weight = args.teacher_weight
            if lessons is not None:
                both = lesson.transpose(0, 1)[:, :, None]
            else:  # the mean is worth something after a while
                weight *= min(1, max(0, (part - 0.33) / 0.2))
                both = opinions(mean, lesson, height, width) if weight > 0 else None
        with torch.autocast(device.type, torch.bfloat16):
            prediction = net(torch.cat([pictures, mixed]) * 2 - 1)
        prediction = prediction.float().contiguous()
        loss, error, order, edges = depth_loss(prediction[:n], roots.square(), args.edges)
        hidden, slope = hiding_loss(prediction[n:], where)
        loss = loss + args.photo_weight * (hidden + slope)
        general = steps = torch.zeros((), device=device)
        if weight > 0:
            whole = teacher_loss(prediction[n:], both, 1 - piece)
            inner = teacher_loss(prediction[n:], both[:, other], piece)
            general, steps = whole[0] + 0.5 * inner[0], whole[1] + 0.5 * inner[1]
            loss = loss + weight * (general + 0.5 * steps)
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        norm = torch.nn.utils.clip_grad_norm_(own, 1.0)
        if on_gpu:  # a batch that gives no numbers is left out
            optimizer.grad_scale = None
            optimizer.found_inf = (~torch.isfinite(norm)).float()
        optimizer.step()
        step, seen = step + 1, seen + n + m
        with torch.no_grad():
            keep = min(args.keep, (step + 1) / (step + 10))
            torch._foreach_mul_(averaged, keep)
            torch._foreach_add_(averaged, own, alpha=1 - keep)
            pull = args.hold * args.encoder_rate * rate
            torch._foreach_mul_(held, 1 - pull)
            torch._foreach_add_(held, anchors, alpha=pull)
            sums += torch.nan_to_num(torch.stack([loss.detach(), error, order, edges, hidden, slope, general, steps]))
        count += 1
        if step in (1, 10) or step % 100 == 0:
            means = (sums / count).tolist()
            now = time.time()
            log.writerow([f"{now - begin:.1f}", step, seen, f"{rate:.3f}"] + [f"{v:.4f}" for v in means])
            print(f"{now - begin:.1f} s, {step} batches, {seen} pictures, rate {rate:.2f}, "
                  f"{seen / (now - first_step):.0f} pictures/s, {[len(f) for f in frames.values()]} frames:",
                  " ".join(f"{v:.3f}" for v in means), flush=True)
            sums, count = sums * 0, 0
        if snapshots and part >= snapshots[0]:
            save(os.path.join(args.out, f"mean-{round(100 * snapshots.pop(0))}.pt"), mean=state_of(mean))
        if time.time() - saved > 60:
            save(os.path.join(args.out, "checkpoint.pt"), mean=state_of(mean), step=step)
            saved = time.time()
    save(os.path.join(args.out, "checkpoint.pt"), mean=state_of(mean), step=step, args=vars(args))
    if on_gpu:
        print(f"{torch.cuda.max_memory_allocated() / 2**30:.1f} GiB")
    print(f"{time.time() - begin:.1f} s, {step} batches, {seen} pictures", flush=True)


if __name__ == "__main__":
    main()
