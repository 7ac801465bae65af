"""What a camera's image processor makes of the sensor's values, from denoising to the last enlargement.

Every step takes and gives (H, W) float32 grey levels 0..255 and shifts nothing: its filters are symmetric.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np


@dataclass(frozen=True)
class Processing:
    """An image processor; the defaults change nothing. Applied in this order:

    temporal    weight of the previous frame where the picture hardly changed; temporal_grey  how much is
                "hardly", grey levels
    median_px   size of a median filter: 0, 3 or 5
    bilateral   (sigma in px, in grey levels) of a bilateral filter; (0, 0): none
    gamma       grey ** (1 / gamma): above 1 lifts the shadows
    curve       strength of an S-shaped tone curve, 0..1 (negative: flattens)
    lift        grey level that black becomes, white staying white
    sharpen     strength of unsharp masking; sharpen_px  its sigma
    """

    temporal: float = 0.0
    temporal_grey: float = 12.0
    median_px: int = 0
    bilateral: tuple = (0.0, 0.0)
    gamma: float = 1.0
    curve: float = 0.0
    lift: float = 0.0
    sharpen: float = 0.0
    sharpen_px: float = 1.0

    def run(self, grey: np.ndarray, previous: np.ndarray | None = None) -> np.ndarray:
        """(H, W) float32 -> (H, W) float32, both 0..255. `previous`: the frame before, for `temporal`."""
        if self.temporal and previous is not None:
            grey = recursive(grey, previous, self.temporal, self.temporal_grey)
        if self.median_px:
            grey = cv2.medianBlur(grey, self.median_px)
        if self.bilateral[0]:
            grey = cv2.bilateralFilter(
                grey, -1, self.bilateral[1], self.bilateral[0], borderType=cv2.BORDER_REPLICATE
            )
        grey = self.tone(grey)
        if self.sharpen:
            soft = cv2.GaussianBlur(grey, (0, 0), self.sharpen_px, borderType=cv2.BORDER_REPLICATE)
            grey = grey + np.float32(self.sharpen) * (grey - soft)
        return np.clip(grey, 0, 255)

    def tone(self, grey: np.ndarray) -> np.ndarray:
        """The tone curve alone; it never falls."""
        if self.gamma == 1.0 and not self.curve and not self.lift:
            return grey
        share = np.clip(grey / 255, 0, 1) ** (1 / self.gamma)
        share = share + self.curve * (share * share * (3 - 2 * share) - share)
        return (self.lift + share * (255 - self.lift)).astype(np.float32)


def recursive(grey: np.ndarray, previous: np.ndarray, weight: float, limit: float) -> np.ndarray:
    """Temporal noise reduction: the previous frame shines through where the difference is below a limit."""
    difference = previous - grey
    still = np.clip(2 - np.abs(cv2.blur(difference, (3, 3))) / np.float32(limit), 0, 1)
    return (grey + np.float32(weight) * still * difference).astype(np.float32)
