"""Dirt on the lens: places of the picture that are blurred, dimmed and veiled, others that are not."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

_SIGMAS_PX = (1.2, 2.4, 4.8)  # of the blurred copies of which an uneven blur is mixed


@dataclass(frozen=True)
class Smear:
    """A soft-edged spot in the picture, sizes in shares of its height.

    x, y        middle, as shares of the frame's width and height
    long, wide  half axes; angle  of the longer one, rad
    blur        sigma of the blur in its middle, as a share of a frame of 300 px height: px there
    loss        share of the light that it swallows
    veil        stray light that it adds, in units of the white plate
    """

    x: float
    y: float
    long: float
    wide: float
    angle: float
    blur: float
    loss: float
    veil: float

    def cover(self, shape: tuple[int, ...]) -> np.ndarray:
        """(H, W) float32, 0 outside .. 1 in the middle."""
        height, width = shape
        y, x = np.mgrid[:height, :width].astype(np.float32)
        dx, dy = x / height - self.x * width / height, y / height - self.y
        cos, sin = np.float32(np.cos(self.angle)), np.float32(np.sin(self.angle))
        u, v = (cos * dx + sin * dy) / self.long, (cos * dy - sin * dx) / self.wide
        return np.exp(-((u * u + v * v) ** 2)).astype(np.float32)


def look_through(radiance: np.ndarray, smears: tuple[Smear, ...]) -> np.ndarray:
    """(H, W) float32 radiance behind dirty glass: blurred, dimmed and veiled where the smears are."""
    height = radiance.shape[0]
    variance = np.zeros(radiance.shape, np.float32)
    passed = np.ones(radiance.shape, np.float32)
    veil = np.zeros(radiance.shape, np.float32)
    for smear in smears:
        cover = smear.cover(radiance.shape)
        variance += cover * np.float32((smear.blur * height / 300) ** 2)
        passed *= 1 - cover * np.float32(smear.loss)
        veil += cover * np.float32(smear.veil)
    return _blurred(radiance, np.sqrt(variance)) * passed + veil


def _blurred(image, sigma):
    """The image with a gaussian blur whose sigma (px) differs from place to place."""
    levels = [image] + [
        cv2.GaussianBlur(image, (0, 0), s, borderType=cv2.BORDER_REPLICATE) for s in _SIGMAS_PX
    ]
    steps = (0.0, *_SIGMAS_PX)
    out = levels[-1].copy()
    for index in range(len(_SIGMAS_PX)):
        low, high = steps[index], steps[index + 1]
        inside = (sigma >= low) & (sigma < high)
        # variances of neighbouring levels are mixed, so the second moment is the one asked for
        share = np.clip((sigma**2 - low**2) / (high**2 - low**2), 0, 1)
        mixed = levels[index] * (1 - share) + levels[index + 1] * share
        out[inside] = mixed[inside]
    return out


def draw_smears(rng: np.random.Generator, count: int) -> tuple[Smear, ...]:
    """Finger marks, drops and dust: a tuple of Smear."""
    smears = []
    for _ in range(count):
        long = rng.uniform(0.08, 0.45)
        heavy = rng.uniform(0.2, 1.0)
        smears.append(
            Smear(
                x=rng.uniform(0.0, 1.0),
                y=rng.uniform(0.0, 1.0),
                long=long,
                wide=long * rng.uniform(0.3, 1.0),
                angle=rng.uniform(0, np.pi),
                blur=heavy * rng.uniform(1.0, 4.5),
                loss=heavy * rng.uniform(0.0, 0.45),
                veil=heavy * rng.uniform(0.0, 0.35),
            )
        )
    return tuple(smears)
