"""From linear light to a photo: focus, exposure, colour, noise, sharpening, JPEG."""

import cv2
import numpy as np


def defocus(colour, inverse, focus, strength):
    """Blurs what is out of focus, by `strength` px per unit of inverse depth from the focus."""
    blur = np.clip(strength * np.abs(inverse - focus), 0, 14)
    if blur.max() < 0.6:
        return colour
    edges = np.quantile(inverse, np.linspace(0, 1, 8))
    out = np.zeros_like(colour)
    cover = np.zeros(inverse.shape, np.float32)
    for low, high in zip(
        edges[:-1], edges[1:]
    ):  # far to near: nearer layers go over what lies behind
        inside = (inverse >= low) & ((inverse < high) | (high == edges[-1]))
        if not inside.any():
            continue
        radius = float(blur[inside].mean())
        mask = inside.astype(np.float32)
        if radius > 0.4:
            size = 2 * int(np.ceil(radius)) + 1
            at = np.arange(size) - size // 2
            kernel = np.clip(radius + 0.5 - np.hypot(at[:, None], at[None]), 0, 1).astype(
                np.float32
            )
            kernel /= kernel.sum()
            layer = cv2.filter2D(
                colour * mask[..., None], -1, kernel, borderType=cv2.BORDER_REPLICATE
            )
            mask = cv2.filter2D(mask, -1, kernel, borderType=cv2.BORDER_REPLICATE)
        else:
            layer = colour * mask[..., None]
        out = out * (1 - mask[..., None]) + layer
        cover = cover * (1 - mask) + mask
    return out / np.maximum(cover, 1e-3)[..., None]


def develop(rng, colour, inverse, near_focus=False):
    """The photo, 8-bit RGB, of a camera with random habits."""
    colour = np.maximum(np.nan_to_num(colour), 0)
    if near_focus and rng.random() < 0.65:  # a subject before a blurred background
        focus = np.quantile(inverse, rng.uniform(0.75, 0.97))
        colour = defocus(colour, inverse, focus, rng.uniform(2, 9) / max(focus, 1e-9))
    elif rng.random() < 0.4:
        centre = inverse[
            inverse.shape[0] // 4 : -inverse.shape[0] // 4,
            inverse.shape[1] // 4 : -inverse.shape[1] // 4,
        ]
        focus = (
            np.quantile(centre, rng.uniform(0.3, 1))
            if rng.random() < 0.8
            else rng.choice(inverse.ravel())
        )
        spread = np.abs(inverse - focus).max() + 1e-9
        colour = defocus(colour, inverse, focus, rng.uniform(1, 9) ** rng.uniform(0.3, 1) / spread)
    if rng.random() < 0.06:  # the camera moved
        n = rng.integers(3, 9)
        kernel = np.zeros((n, n), np.float32)
        cv2.line(kernel, (0, int(rng.integers(n))), (n - 1, int(rng.integers(n))), 1.0)
        colour = cv2.filter2D(colour, -1, kernel / kernel.sum(), borderType=cv2.BORDER_REPLICATE)
    luma = colour.mean(2)
    middle = np.exp(np.log(luma + 1e-3).mean())
    bright = np.percentile(luma, 95)
    gain = np.exp(rng.normal(0, 0.3)) * min(
        0.19 / max(middle, 1e-3), rng.uniform(0.8, 2.2) / max(bright, 1e-3)
    )
    tint = np.exp(rng.normal(0, 0.09, 3))
    colour = colour * gain * (tint / tint.mean()).astype(np.float32)
    h, w = luma.shape
    if rng.random() < 0.3:  # darker corners
        y, x = np.mgrid[0:h, 0:w]
        r2 = ((x / w - 0.5) ** 2 + (y / h - 0.5) ** 2) * 2
        colour = colour / (1 + rng.uniform(0, 0.6) * r2[..., None]) ** 2
    noise = rng.choice([0, 0.002, 0.005, 0.012, 0.03], p=[0.2, 0.3, 0.3, 0.15, 0.05])
    grain = rng.normal(0, 1, colour.shape).astype(np.float32)
    if rng.random() < 0.5:
        grain = cv2.GaussianBlur(grain, (0, 0), 0.7) * 1.8
    colour = np.maximum(colour + grain * noise * np.sqrt(np.maximum(colour, 0) + 0.02), 0)
    if rng.random() < 0.7:  # a shoulder for bright parts
        knee = rng.uniform(0.5, 0.8)
        over = colour > knee
        colour = np.where(over, knee + (1 - knee) * np.tanh((colour - knee) / (1 - knee)), colour)
    picture = np.clip(colour, 0, 1) ** (1 / rng.uniform(1.9, 2.5))
    grey = picture.mean(2, keepdims=True)
    picture = grey + (picture - grey) * rng.uniform(0.6, 1.35)
    if rng.random() < 0.04:
        picture = np.repeat(grey, 3, 2)
    contrast = rng.normal(1, 0.12)
    picture = np.clip(0.45 + (picture - 0.45) * contrast + rng.normal(0, 0.03), 0, 1)
    picture = (picture * 255 + 0.5).astype(np.uint8)
    if rng.random() < 0.4:
        soft = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.7, 1.5))
        picture = cv2.addWeighted(picture, 1.6, soft, -0.6, 0)
    if rng.random() < 0.7:
        _, jpeg = cv2.imencode(
            ".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, int(rng.integers(55, 96))]
        )
        picture = cv2.imdecode(jpeg, cv2.IMREAD_COLOR)[..., ::-1]
    return picture
