"""Pixels of a sensor that do not do as the others do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Defects:
    """A sensor's faults; the same in each frame that it takes.

    hot, dead     share of pixels that read much too high, and nothing
    columns       standard deviation of the columns' offsets, grey levels; rows  likewise, new in each frame
    stuck_columns columns that read one level throughout
    seed          which pixels these are
    """

    hot: float = 0.0
    dead: float = 0.0
    columns: float = 0.0
    rows: float = 0.0
    stuck_columns: int = 0
    seed: int = 0

    def apply(self, grey: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """(H, W) float32 grey levels with the faults; `rng` draws what is new in each frame."""
        fixed = np.random.Generator(np.random.PCG64(self.seed))
        height, width = grey.shape
        grey = grey + fixed.normal(0, 1, (1, width)).astype(np.float32) * np.float32(self.columns)
        grey += rng.normal(0, 1, (height, 1)).astype(np.float32) * np.float32(self.rows)
        chance = fixed.random(grey.shape)
        levels = fixed.uniform(60, 255, grey.shape).astype(np.float32)
        hot = chance < self.hot
        grey[hot] = np.minimum(grey[hot] + levels[hot], 255)
        grey[chance > 1 - self.dead] = 0
        for column in fixed.integers(0, width, self.stuck_columns):
            grey[:, column] = fixed.uniform(0, 255)
        return np.clip(grey, 0, 255)
