"""Frames and rings larger than the detectors take: reduced by whole factors, results in original pixels.

A board's limits are those of `larics.detect.detector.Detector`: frames up to 1024 px, rings up to 72 px.
Here the mean of factor x factor pixels becomes one. Where the radius is unknown, further reductions follow
until one shows a marker or no ring could be larger.
"""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from larics.marker.detection import NO_ID

if TYPE_CHECKING:
    from larics.marker.detection import Detection
    from larics_host.annotations import AnyDetector

FRAME_MOST_PX = 1024
FRAME_LEAST_PX = (64, 48)
RADIUS_LEAST_PX, RADIUS_MOST_PX = 6, 72  # in the reduced frame
_STEP = 10  # from one reduction to the next; the ranges of radii, 1:12, overlap
_UNKNOWN_STEP = 5  # those of an unknown radius are 1:6
_LENGTH = re.compile(r"_q(\d+)$")  # fields in fractions of a pixel


class Level(NamedTuple):
    """A reduction: its factor, and the range of radii in the reduced frame."""

    factor: int
    low_px: int
    high_px: int


def _least_factor(width, height):
    return max(1, -(-max(width, height) // FRAME_MOST_PX))


def levels_of(
    width: int, height: int, low_px: int, high_px: int, most_px: int = RADIUS_MOST_PX
) -> list[Level]:
    """The Levels, finest first, that look for radii from low_px to high_px of the original frame.

    most_px: the largest radius that the method takes. What is below 6 px when reduced is not looked for.
    """
    least = _least_factor(width, height)
    if least == 1 and high_px <= most_px:
        return [Level(1, low_px, high_px)]
    high_px = max(low_px + 1, min(high_px, min(width, height)))
    coarsest = max(least, -(-high_px // most_px))
    factor = max(least, min(coarsest, low_px // RADIUS_LEAST_PX))
    levels = []
    while True:
        low = max(RADIUS_LEAST_PX, low_px // factor)
        high = min(most_px, max(low + 1, -(-high_px // factor)))
        levels.append(Level(factor, low, high))
        if factor * most_px >= high_px:
            return levels
        factor = min(_STEP * factor, coarsest)


def unknown_levels(width: int, height: int, low_px: int, high_px: int) -> list[Level]:
    """The Levels for any radius: low_px to high_px in the finest, more in those after it."""
    least = _least_factor(width, height)
    largest = max(least, -(-min(width, height) // 2 // high_px))
    steps = math.ceil(math.log(largest / least) / math.log(_UNKNOWN_STEP) - 1e-9)
    levels = []
    for step in range(steps + 1):
        factor = round(least * (largest / least) ** (step / max(1, steps)))
        half_px = min(width, height) // factor // 2
        if step and (width // factor < FRAME_LEAST_PX[0] or height // factor < FRAME_LEAST_PX[1]):
            break
        levels.append(Level(factor, low_px, max(low_px + 1, min(high_px, half_px))))
    return levels


def shrunk(frame: np.ndarray, factor: int) -> np.ndarray:
    """The frame with the mean of factor x factor pixels as one; a rest at right and bottom is cut."""
    if factor == 1:
        return frame
    import cv2

    height, width = (size // factor for size in frame.shape)
    whole = np.ascontiguousarray(frame[: height * factor, : width * factor])
    return cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA)


def _enlarged(detection, factor):
    """A copy in original pixels: lengths grow, and a reduced pixel's centre is that of its block."""
    found = copy.copy(detection)
    if factor > 1:
        for name in detection.__slots__:
            match = _LENGTH.search(name)
            if match:
                value = getattr(detection, name) * factor
                if name[0] in "xy":
                    value += (factor - 1 << int(match.group(1))) // 2
                setattr(found, name, value)
    return found


class ReducedDetector:
    """Looks for markers level by level until one shows an ID; detections in pixels of the frame as it came.

    make: a detector of (width, height, low_px, high_px); ValueError from it at once for the first level."""

    def __init__(
        self, width: int, height: int, levels: list[Level], make: Callable[[int, int, int, int], AnyDetector]
    ) -> None:
        self.levels = levels
        self._size = (width, height)
        self._make = make
        self._made: list[Any] = [self._detector(levels[0])]

    def _detector(self, level):
        width, height = (size // level.factor for size in self._size)
        return self._make(width, height, level.low_px, level.high_px)

    @property
    def factor(self) -> int:
        """Of the finest reduction."""
        return self.levels[0].factor

    def detect(self, frame: np.ndarray) -> list[Detection]:
        """The Detections in a 2-D uint8 frame; those of coarser levels only where finer ones show no ID."""
        frame = np.asarray(frame).reshape(self._size[1], self._size[0])
        found: list[Any] = []
        for index, level in enumerate(self.levels):
            if index == len(self._made):
                self._made.append(self._detector(level))
            small = shrunk(frame, level.factor)
            here = [_enlarged(one, level.factor) for one in self._made[index].detect(small)]
            certain = [one for one in here if one.marker_id != NO_ID]
            # a coarse look that reads an ID knows better what a fine one saw there
            found = [one for one in found if not any(_meet(one, other) for other in certain)]
            found += [one for one in here if not any(_meet(one, other) for other in found)]
            if certain:
                break
        return found


def _meet(one, other):
    return one.covers(other.x_q8, other.y_q8) or other.covers(one.x_q8, one.y_q8)
