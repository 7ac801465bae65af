"""When the picture was taken that a message is about: one time for all messages of a frame."""

from __future__ import annotations

from typing import Any

_KEPT = 256  # frames
_SAME_NS = 500_000_000  # messages of one frame leave together, and take longer on no line


class FrameTimes:
    """Remembers the time of each frame: when the first message about it was received, minus the age it
    tells."""

    def __init__(self) -> None:
        self._times: dict[int, int] = {}

    def of(self, fields: Any, received_ns: int) -> int:
        """The middle of the exposure that a record is about, ns on the clock of `received_ns`; that itself
        for a record that is about no frame, or about one whose age nobody told."""
        number = getattr(fields, "frame", None)
        if number is None:
            return received_ns
        known_ns = self._times.get(number)
        if not hasattr(fields, "age_us"):
            return received_ns if known_ns is None else known_ns
        told_ns = max(0, received_ns - 1000 * fields.age_us)
        if known_ns is not None and abs(told_ns - known_ns) < _SAME_NS:
            return known_ns
        self._times.pop(number, None)  # of an earlier start of the camera, whose frames count from 0 again
        self._times[number] = told_ns
        while len(self._times) > _KEPT:
            del self._times[next(iter(self._times))]
        return told_ns

    def get(self, number: int) -> int | None:
        """The time of a frame by its number; None when it is not known (any more)."""
        return self._times.get(number)
