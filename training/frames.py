"""Frames: a picture NNNNNN.jpg or .png and its 16-bit inverse depth NNNNNN.d.png.

Training batches are random crops of one shape, augmented. The i-th batch of a seed depends on the
seed, i, and the list of frames.
"""
import glob
import os

import cv2
import numpy as np
import torch

# height, width of batches: multiples of 32, mostly about the area of 200 x 200
SHAPES = [(192, 192), (160, 224), (224, 160), (160, 256), (256, 160), (192, 256), (256, 192),
          (224, 224), (160, 192), (192, 160), (256, 256), (256, 320), (320, 256)]
LIKELY = np.array([3, 3, 2, 3, 2, 4, 3, 2, 1, 1, 1, 0.3, 0.3])
PIXELS = 200 * 200  # of a picture that counts as one in a batch of mixed sizes
ASPECTS = [1, 3 / 4, 3 / 4, 2 / 3, 9 / 16]


def shape_between(random, least, most):
    """A height and width whose longer side is between two multiples of 32."""
    longer = 32 * int(random.integers(least // 32, most // 32 + 1))
    shorter = 32 * int(round(longer * ASPECTS[random.integers(len(ASPECTS))] / 32))
    return (longer, shorter) if random.random() < 0.4 else (shorter, longer)


def list_frames(folders):
    """The (picture, depth) files of complete frames, sorted."""
    frames = []
    for folder in sorted(folders):
        names = set(os.listdir(folder))
        for name in sorted(names):
            if not name.endswith(".d.png"):
                continue
            for ending in (".jpg", ".png"):
                if name[:-6] + ending in names:
                    frames.append((os.path.join(folder, name[:-6] + ending),
                                   os.path.join(folder, name)))
    return frames


def list_photos(folder):
    """Photos without depth: the picture NAME.jpg and the map NAME.m.png of masks.py."""
    photos = []
    for name in sorted(glob.glob(os.path.join(folder, "*.m.png"))):
        picture = cv2.imread(name[:-6] + ".jpg", cv2.IMREAD_COLOR)
        photos.append((picture, cv2.imread(name, cv2.IMREAD_GRAYSCALE).astype(np.float32)))
    return photos


def read_frame(frame):
    """BGR 8 bit, and inverse depth as float 0..1."""
    picture = cv2.imread(frame[0], cv2.IMREAD_COLOR)
    depth = cv2.imread(frame[1], cv2.IMREAD_UNCHANGED)
    if picture is None or depth is None or depth.dtype != np.uint16 or \
            depth.shape != picture.shape[:2]:
        raise ValueError(f"{frame[1]}: is no frame")
    return picture, depth.astype(np.float32) / 65535


def crop(random, picture, depth, shape):
    """A random part, picture and depth in `shape`. Keeps the aspect to 15 %."""
    rows, cols = depth.shape
    aspect = shape[1] / shape[0] * np.exp(random.uniform(-0.14, 0.14))
    height = min(rows, cols / aspect)
    height *= random.uniform(0.6, 1) if random.random() < 0.5 else 1
    h, w = max(16, int(height)), max(16, int(min(cols, height * aspect)))
    y, x = random.integers(0, rows - h + 1), random.integers(0, cols - w + 1)
    size = (shape[1], shape[0])
    area, linear = cv2.INTER_AREA, cv2.INTER_LINEAR
    how = area if w >= shape[1] else (cv2.INTER_CUBIC if random.random() < 0.5 else linear)
    picture = cv2.resize(picture[y:y + h, x:x + w], size, interpolation=how)
    # the depth of one point of each pixel, so that its edges stay edges
    depth = cv2.resize(depth[y:y + h, x:x + w], size, interpolation=cv2.INTER_NEAREST_EXACT)
    if random.random() < 0.5:
        picture, depth = picture[:, ::-1], depth[:, ::-1]
    return np.ascontiguousarray(picture), np.ascontiguousarray(depth)


def augment(random, picture):
    """What cameras, programs and compression do to a picture. BGR 8 bit to BGR 8 bit."""
    x = picture.astype(np.float32) / 255
    if random.random() < 0.15:  # out of focus, or shaken
        if random.random() < 0.6:
            x = cv2.GaussianBlur(x, (0, 0), random.uniform(0.4, 1.6))
        else:
            kernel = np.zeros((7, 7), np.float32)
            angle, length = random.uniform(0, np.pi), random.uniform(1, 3)
            offset = (length * np.cos(angle), length * np.sin(angle))
            cv2.line(kernel, tuple(int(round(3 - o)) for o in offset),
                     tuple(int(round(3 + o)) for o in offset), 1)
            x = cv2.filter2D(x, -1, kernel / kernel.sum(), borderType=cv2.BORDER_REFLECT)
    if random.random() < 0.8:  # exposure, white balance, contrast, tone
        x = x * np.exp(random.normal(0, 0.25)) * np.exp(random.normal(0, 0.08, 3)).astype(np.float32)
        mean = x.mean()
        x = (x - mean) * np.exp(random.normal(0, 0.2)) + mean
        x = np.clip(x, 0, 1) ** np.exp(random.normal(0, 0.25))
    if random.random() < 0.6:  # saturation, hue
        grey = x @ np.array([0.114, 0.587, 0.299], np.float32)
        saturation = random.choice([0, random.uniform(0, 1.8)], p=[0.15, 0.85])
        x = grey[..., None] + (x - grey[..., None]) * np.float32(saturation)
        if random.random() < 0.3:
            mix = np.eye(3) + random.normal(0, 0.12, (3, 3))
            x = x @ (mix / mix.sum(1, keepdims=True)).T.astype(np.float32)
    if random.random() < 0.05:  # colours in another order
        x = x[:, :, random.permutation(3)]
    if random.random() < 0.2:  # dark corners
        rows, cols = x.shape[:2]
        v, u = np.mgrid[-1:1:rows * 1j, -1:1:cols * 1j].astype(np.float32)
        x = x * (1 - random.uniform(0, 0.5) * (u * u + v * v)[..., None] / 2)
    if random.random() < 0.4:  # noise
        x = x + np.float32(random.uniform(0.005, 0.05)) * random.standard_normal(x.shape, np.float32)
    if random.random() < 0.1:  # sharpened
        x = x + random.uniform(0.3, 1) * (x - cv2.GaussianBlur(x, (0, 0), 1))
    picture = (np.clip(x, 0, 1) * 255 + 0.5).astype(np.uint8)
    if random.random() < 0.4:
        quality = int(random.integers(25, 95))
        code = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
        picture = cv2.imdecode(code, cv2.IMREAD_COLOR)
    return picture


def to_input(picture):
    """BGR 8 bit or float 0..255 to the network's input, [3, height, width]."""
    x = picture[:, :, ::-1].astype(np.float32) / 127.5 - 1
    return torch.from_numpy(np.ascontiguousarray(x.transpose(2, 0, 1)))


class Batches(torch.utils.data.IterableDataset):
    """Endless batches: pictures, inverse depths of the first ones, maps of the others or None. Lists the
    folders again every 100 batches."""

    def __init__(self, root, sets, batch, seed, first=0, only=0, photos=None, photo_share=0,
                 sizes=None):
        self.root, self.sets, self.batch, self.seed = root, sets, batch, seed
        self.first, self.only = first, only
        self.photos, self.photo_share, self.sizes = photos, photo_share, sizes

    def folders(self):
        return sorted(f for s in self.sets for f in glob.glob(os.path.join(self.root, s)))

    def __iter__(self):
        cv2.setNumThreads(1)
        torch.set_num_threads(1)
        index, sets = self.first, []
        photos = list_photos(self.photos) if self.photo_share else []
        while True:
            if index % 100 == 0 or not sets:
                sets = [f for f in (list_frames([s]) for s in self.folders()) if f]
                if self.only:
                    sets = [sets[0][:self.only]]
                weights = np.sqrt([len(s) for s in sets])  # small sets are seen more often
            random = np.random.default_rng((self.seed, index))
            shape = SHAPES[random.choice(len(SHAPES), p=LIKELY / LIKELY.sum())]
            batch, photo_share = self.batch, self.photo_share
            if self.sizes:  # as many pixels in each batch
                shape = shape_between(random, *self.sizes)
                part = PIXELS / (shape[0] * shape[1])
                batch = max(2, int(round(batch * part)))
                photo_share = max(1, int(round(photo_share * part))) if photos else 0
            pictures, depths = [], []
            while len(pictures) < batch:
                try:
                    frames = sets[random.choice(len(sets), p=weights / weights.sum())]
                    frame = read_frame(frames[random.integers(len(frames))])
                except ValueError:
                    continue
                picture, depth = crop(random, *frame, shape)
                if depth.std() < 0.01:
                    continue
                pictures.append(to_input(augment(random, picture)))
                depths.append(torch.from_numpy(depth)[None])
            maps = []
            while photos and len(maps) < photo_share:
                picture, where = crop(random, *photos[random.integers(len(photos))], shape)
                if min((where == 255).mean(), (where == 128).mean()) < 0.03:
                    continue
                pictures.append(to_input(augment(random, picture)))
                maps.append(torch.from_numpy(where)[None])
            yield torch.stack(pictures), torch.stack(depths), torch.stack(maps) if maps else None
            index += 1
