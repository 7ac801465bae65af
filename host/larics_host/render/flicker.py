"""Lamps on the mains: their light swings twice a period, and a rolling shutter shows it as bands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from larics_host.render.camera import Camera


@dataclass(frozen=True)
class Flicker:
    """depth: share of the light that swings, 0..1; mains_hz 50 or 60; phase of the light, rad."""

    depth: float = 0.0
    mains_hz: float = 50.0
    phase: float = 0.0

    def gain(self, camera: Camera) -> np.ndarray:
        """(H, 1) float32: light of each row, integrated over its exposure; its mean over time is 1."""
        swings = 2 * self.mains_hz
        seconds = camera.row_seconds(np.arange(camera.height))
        # a whole number of swings in the exposure leaves nothing of them
        left = self.depth * np.sinc(swings * camera.exposure_us * 1e-6)
        return (1 + left * np.cos(2 * math.pi * swings * seconds + self.phase)).astype(np.float32)[:, None]
