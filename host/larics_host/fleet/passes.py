"""One visit under a marker: readings that stay in one place are of one plate, whatever IDs they have.

The ID of most of them is taken for the plate's; the others were misread. No map is needed.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

_NEAR_MM = 120.0  # plates are farther apart than this and what a vehicle drives meanwhile
_NEAR_DEG = 15.0
_SPEED_MM_S = 2000.0
_GAP_S = 0.25  # longer without a reading, and the visit is over


class Reading(NamedTuple):
    """A marker in a frame, in the vehicle frame: ID, place in mm, heading in degrees, margin."""

    id: int
    x_mm: float
    y_mm: float
    heading_deg: float
    margin: int


class _Visit:
    def __init__(self):
        self.ids = Counter()
        self.last = None
        self.time_s = 0.0


class Passes:
    """Feed it with `add`; `end` at the end. They yield the Counter of IDs of each visit that is over."""

    def __init__(self) -> None:
        self._open: list[_Visit] = []

    def add(self, time_s: float, readings: list[Reading]) -> Iterator[Counter[int]]:
        """The readings of one frame, with when it was received."""
        still = []
        for visit in self._open:
            if 0 <= time_s - visit.time_s <= _GAP_S:
                still.append(visit)
            else:
                yield visit.ids
        self._open = still
        free = list(still)
        for reading in readings:
            near = sorted(free, key=lambda one: _apart(one.last, reading))
            if near and _same(near[0], reading, time_s):
                visit = near[0]
                free.remove(visit)
            else:
                visit = _Visit()
                self._open.append(visit)
            visit.ids[reading.id] += 1
            visit.last, visit.time_s = reading, time_s

    def end(self) -> Iterator[Counter[int]]:
        """Those that are not over yet."""
        for visit in self._open:
            yield visit.ids
        self._open = []


def _apart(a, b):
    return math.hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm)


def _same(visit, reading, time_s):
    last = visit.last
    reach_mm = _NEAR_MM + _SPEED_MM_S * (time_s - visit.time_s)
    turned = abs((last.heading_deg - reading.heading_deg + 180) % 360 - 180)
    return _apart(last, reading) <= reach_mm and turned <= _NEAR_DEG


def judged(ids: Counter[int]) -> tuple[int, dict[int, int]]:
    """(ID of the plate, {other ID: how often it was read instead}) of a visit; the most frequent is right."""
    right = min(ids, key=lambda one: (-ids[one], one))
    return right, {one: count for one, count in ids.items() if one != right}
