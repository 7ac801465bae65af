"""What the lens and the open shutter do to the picture: blur of motion, defocus, sampling of pixels."""

from __future__ import annotations

import math

import cv2
import numpy as np

# a picture that moves by less than this during the exposure is taken as standing still
STILL_PX = 0.2


def motion_kernel(shift_x_px: float, shift_y_px: float) -> np.ndarray:
    """Odd square float32 kernel, sum 1: a line of this length and direction through its centre."""
    length = math.hypot(shift_x_px, shift_y_px)
    half = int(math.ceil(length / 2 + 0.5))
    kernel = np.zeros((2 * half + 1, 2 * half + 1))
    steps = np.linspace(-0.5, 0.5, 8 * half + 1)
    x, y = half + steps * shift_x_px, half + steps * shift_y_px
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    share_x, share_y = x - column, y - row
    for down in (0, 1):
        for right in (0, 1):
            weight = (share_x if right else 1 - share_x) * (share_y if down else 1 - share_y)
            inside = weight > 0
            np.add.at(kernel, (row[inside] + down, column[inside] + right), weight[inside])
    return (kernel / kernel.sum()).astype(np.float32)


def smear(layer: np.ndarray, shift_px: tuple[float, float]) -> np.ndarray:
    """The layer (float32) blurred by the image shift (x, y px) during the exposure."""
    if math.hypot(*shift_px) < STILL_PX:
        return layer
    return cv2.filter2D(layer, -1, motion_kernel(*shift_px), borderType=cv2.BORDER_REPLICATE)


def defocus(image: np.ndarray, sigma_px: float) -> np.ndarray:
    """Gaussian blur of the optics; below 0.1 px nothing is left to do after the sampling of the pixels."""
    if sigma_px < 0.1:
        return image
    size = 2 * int(math.ceil(4 * sigma_px)) + 1
    return cv2.GaussianBlur(image, (size, size), sigma_px, borderType=cv2.BORDER_REPLICATE)


def pixel_samples(count: int, exposure_s: float) -> np.ndarray:
    """(count, 3) sample offsets x, y (px, -0.5..0.5) and time (s, -exposure/2..exposure/2).

    A low-discrepancy set (the additive recurrence of the generalised golden ratio) made of point-mirrored
    pairs: the point spread it stands for is centred on the pixel and on the middle of the exposure.
    """
    golden = 1.2207440846057596  # root of x^4 = x + 1
    steps = golden ** -np.arange(1.0, 4.0)
    points = (0.5 + np.outer(np.arange(1, count // 2 + 1), steps)) % 1.0 - 0.5
    # every half second point and its mirror image, spread evenly in time
    order = np.argsort(points[:, 2], kind="stable")
    points[order, 2] = (np.arange(len(points)) + 0.5) / (2 * len(points))
    samples = np.concatenate([points, -points])
    samples[:, 2] *= exposure_s
    return samples
