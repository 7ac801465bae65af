"""Types that annotations of several modules name; nothing here is needed while the program runs."""

from __future__ import annotations

from os import PathLike
from typing import Any, Protocol, TypeAlias

import numpy as np

StrPath: TypeAlias = str | PathLike[str]
Numbers: TypeAlias = float | np.ndarray  # a number, or an array of them that is worked on as a whole
Row: TypeAlias = tuple[float, ...]  # of an object table, see larics_host.render.scene.item
MarkerPose: TypeAlias = tuple[float, float, float]  # x mm, y mm, heading deg


class Stream(Protocol):
    """What a Client talks over."""

    def read(self) -> bytes | None:
        """What has arrived, b"" after a short wait, None at the end."""

    def write(self, data: bytes) -> None:
        """Sends bytes."""


class AnyDetector(Protocol):
    """What finds markers: a Detector or PaperDetector of larics.detect, or a peer's with the same call."""

    def detect(self, frame: Any) -> list[Any]:
        """The Detections in a row-major frame of 8-bit pixels."""
