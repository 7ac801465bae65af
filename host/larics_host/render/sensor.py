"""The image sensor: from radiance to 8-bit grey levels."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import cv2
import numpy as np

from larics_host.compilation import njit
from larics_host.render.defects import Defects
from larics_host.render.flicker import Flicker
from larics_host.render.lens_dirt import look_through
from larics_host.render.processing import Processing

if TYPE_CHECKING:
    from larics_host.render.camera import Camera


@njit(cache=True, nogil=True)
def _expose(grey_levels, image, noise, levels):
    """Radiance (plate's white = 1) -> grey levels with vignetting and noise, neither cut nor rounded.

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
            grey_levels[row, column] = grey


def _eight_bits(grey):
    return np.clip(grey + 0.5, 0.0, 255.0).astype(np.uint8)


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

    and of cameras that do more than that:

    lens          of Smear: dirt on the lens
    exposure      factor on all light: above 1 over-exposed
    flicker       of the lamps, seen by a rolling shutter
    field_us      interlaced: time between the fields of even and of odd rows; 0: all rows are of one picture
    scale         sensor's pixels per pixel of the frame, in x and in y; below 1 the frame is an enlargement
    defects, processing   of the sensor and of the image processor
    frame_us      time between pictures, for what the processor takes over from the last one
    """

    contrast: float = 120.0
    black: float = 30.0
    read_noise: float = 0.0
    shot_noise: float = 0.0
    vignetting: float = 0.0
    defocus_px: float = 0.0
    jpeg: int = 0
    lens: tuple = ()
    exposure: float = 1.0
    flicker: Flicker = Flicker()
    field_us: float = 0.0
    scale: float = 1.0
    defects: Defects = Defects()
    processing: Processing = Processing()
    frame_us: float = 33333.0

    def frame(self, radiance: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """(H, W) float32 radiance, white plate = 1, already defocused -> (H, W) uint8."""
        return self._packed(_eight_bits(self._exposed(radiance, rng)))

    def develop(
        self, radiance_at: Callable[[float], np.ndarray], camera: Camera, rng: np.random.Generator
    ) -> np.ndarray:
        """The frame of a camera that does more than count light: (H, W) uint8.

        radiance_at   function of seconds from the exposure's middle -> radiance as for `frame`
        camera        the Camera, whose rows see the flicker
        """
        if self.field_us:
            half = self.field_us * 0.5e-6
            radiance = radiance_at(-half).copy()
            radiance[1::2] = radiance_at(half)[1::2]
        else:
            radiance = radiance_at(0.0)
        grey = self._linear(radiance, camera, rng)
        previous = None
        if self.processing.temporal:
            previous = self._linear(radiance_at(-self.frame_us * 1e-6), camera, rng)
        grey = self.processing.run(grey, previous)
        if grey.shape != radiance.shape:
            grey = cv2.resize(grey, radiance.shape[::-1], interpolation=cv2.INTER_CUBIC)
        return self._packed(_eight_bits(grey))

    def _linear(self, radiance, camera, rng):
        """What the sensor reads, (H, W) float32 of its own size, 0..255."""
        if self.lens:
            radiance = look_through(radiance, self.lens)
        if self.flicker.depth:
            radiance = radiance * self.flicker.gain(camera)
        if self.scale != 1.0:
            size = [max(2, int(round(side * self.scale))) for side in radiance.shape[::-1]]
            radiance = cv2.resize(radiance, size, interpolation=cv2.INTER_AREA)
        light = np.ascontiguousarray(radiance * np.float32(self.exposure), np.float32)
        grey = np.clip(self._exposed(light, rng), 0.0, 255.0).astype(np.float32)
        return self.defects.apply(grey, rng)

    def _exposed(self, radiance, rng):
        """Grey levels with noise, (H, W) float64, neither cut nor rounded."""
        height, width = radiance.shape
        noise = rng.standard_normal(radiance.shape, dtype=np.float32)
        x, y = (width - 1) / 2, (height - 1) / 2
        light = (self.black, self.contrast, self.read_noise**2, self.shot_noise, self.vignetting)
        levels = np.array([*light, x, y, 1 / max(x * x + y * y, 1.0)])
        grey = np.empty((height, width))
        _expose(grey, radiance, noise, levels)
        return grey

    def _packed(self, frame):
        """The frame after JPEG, if it went through that."""
        if self.jpeg:
            data = cv2.imencode(".jpg", frame, [cv2.IMWRITE_JPEG_QUALITY, self.jpeg])[1]
            return np.asarray(cv2.imdecode(data, cv2.IMREAD_GRAYSCALE))
        return frame

    @property
    def plain(self) -> bool:
        """Whether it does no more than count light."""
        return not (self.lens or self.field_us or self.flicker.depth) and (
            (self.exposure, self.scale, self.defects, self.processing) == (1.0, 1.0, Defects(), Processing())
        )
