"""The image sensor: from radiance to 8-bit grey levels."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def _expose(frame, image, noise, levels):
    """Radiance (plate's white = 1) -> grey levels with vignetting, shot and read noise, 8 bit.

    levels  float64 [8]: black level, contrast, read noise variance, shot variance per grey level, vignetting
            (loss at the corner), centre x, y, 1 / corner distance squared
    """
    height, width = image.shape
    for row in range(height):
        dy = row - levels[6]
        for column in range(width):
            dx = column - levels[5]
            corner = (dx * dx + dy * dy) * levels[7]
            light = levels[1] * image[row, column] * (1.0 - levels[4] * corner)
            grey = levels[0] + light
            grey += noise[row, column] * math.sqrt(levels[2] + levels[3] * max(grey, 0.0))
            frame[row, column] = int(min(max(grey + 0.5, 0.0), 255.0))


@dataclass(frozen=True)
class Sensor:
    """How light becomes grey levels.

    contrast      grey levels between the white plate and its black ink, in even light at the frame's middle
    black         grey level of no light
    read_noise    standard deviation in the dark, grey levels
    shot_noise    variance per grey level of signal
    vignetting    share of light lost in the corners, 0..1
    defocus_px    sigma of the optics' gaussian blur
    jpeg          JPEG quality 1..100 the frame has been through; 0: never compressed
    """

    contrast: float = 120.0
    black: float = 30.0
    read_noise: float = 0.0
    shot_noise: float = 0.0
    vignetting: float = 0.0
    defocus_px: float = 0.0
    jpeg: int = 0

    def frame(self, radiance: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """(H, W) float32 radiance, white plate = 1, already defocused -> (H, W) uint8."""
        height, width = radiance.shape
        noise = rng.standard_normal(radiance.shape, dtype=np.float32)
        x, y = (width - 1) / 2, (height - 1) / 2
        light = (self.black, self.contrast, self.read_noise**2, self.shot_noise, self.vignetting)
        levels = np.array([*light, x, y, 1 / max(x * x + y * y, 1.0)])
        frame = np.empty((height, width), np.uint8)
        _expose(frame, radiance, noise, levels)
        if self.jpeg:
            data = cv2.imencode(".jpg", frame, [cv2.IMWRITE_JPEG_QUALITY, self.jpeg])[1]
            return np.asarray(cv2.imdecode(data, cv2.IMREAD_GRAYSCALE))
        return frame
