"""Detection in the pictures of a mirrored sensor: left and right exchanged before, places put back after."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from larics.marker.detection import Detection
    from larics_host.annotations import AnyDetector


class MirroredDetector:
    """Reads what `detector` reads in the mirror: right IDs, places and headings of the picture as it is."""

    def __init__(self, detector: AnyDetector, width: int, height: int) -> None:
        self._detector = detector
        self._size = (height, width)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._detector, name)

    def detect(self, frame: np.ndarray) -> list[Detection]:
        """The Detections in a 2-D uint8 frame."""
        turned = np.ascontiguousarray(np.asarray(frame).reshape(self._size)[:, ::-1])
        found = []
        for one in self._detector.detect(turned):
            back = copy.copy(one)
            back.x_q8 = ((self._size[1] - 1) << 8) - one.x_q8
            back.heading_cdeg = (18000 - one.heading_cdeg) % 36000
            found.append(back)
        return found
