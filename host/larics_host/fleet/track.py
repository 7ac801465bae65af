"""A vehicle by the map: each reading says where the vehicle is, and the readings before say where it can be.

What contradicts them is an ID read wrong, when another marker of the map hangs where it was seen, or a marker
that is not where the map says. How far markers are off is told by the passage from one to another.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from larics_host.fleet.passes import Reading
from larics_host.mapping.links import turn, wrapped

_GAP_S = 1.0  # longer without a marker, and the vehicle may be anywhere
_BLIND_S = 0.3  # up to here it is known well enough to say that a marker has moved
_GATE_MM = 600.0  # what a marker that was moved may be off; a wrong ID is farther
_OTHER_MM, _OTHER_DEG = 200.0, 15.0  # how near another marker must be to have been taken for this one
_LOST_AFTER = 10  # contradictions in a row: then it was the vehicle's place that was wrong


class Landmark(NamedTuple):
    """A marker of the map: number in it, ID, place in mm, heading in degrees."""

    number: int
    id: int
    x_mm: float
    y_mm: float
    heading_deg: float


class Off(NamedTuple):
    """By how much a marker is off its place as seen from another one, map frame."""

    marker: int
    partner: int
    x_mm: float
    y_mm: float
    heading_deg: float


class Wrong(NamedTuple):
    """A reading that contradicts the vehicle's place: the ID read, and which marker hangs there, if any."""

    read: int
    there: int | None


class Track:
    """Feed it with `add` for each frame, in their order; landmarks of the whole map."""

    def __init__(self, landmarks: Sequence[Landmark]) -> None:
        self._all = landmarks
        self._by_id: dict[int, list[Landmark]] = {}
        for landmark in landmarks:
            self._by_id.setdefault(landmark.id, []).append(landmark)
        self._pose: tuple[float, float, float] | None = None
        self._speed = 0.0, 0.0, 0.0  # mm/s, mm/s, deg/s
        self._time_s = 0.0
        self._marker: int | None = None  # on which the pose rests
        self._against = 0

    def add(self, time_s: float, readings: Sequence[Reading]) -> Iterator[Off | Wrong]:
        """What the readings of a frame tell beside the vehicle's place."""
        passed_s = time_s - self._time_s
        if self._pose is not None and not 0 <= passed_s <= _GAP_S:
            self._pose = None
        expected = self._ahead(passed_s)
        good, against = [], 0
        for reading in readings:
            if reading.id not in self._by_id:
                continue
            found = self._placed(reading, expected)
            if found is None:
                continue
            landmark, pose, away_mm = found
            if expected is not None and away_mm > _GATE_MM + 2000 * max(0.0, passed_s - _BLIND_S):
                against += 1
                yield Wrong(reading.id, self._there(reading, expected))
                continue
            good.append((landmark, pose))
        yield from self._offs(good, expected, passed_s)
        if good:
            self._take(good, time_s, passed_s)
        elif against:
            self._against += 1
            if self._against >= _LOST_AFTER:
                self._pose, self._against = None, 0

    def _ahead(self, passed_s):
        if self._pose is None:
            return None
        x, y, heading = self._pose
        vx, vy, turning = self._speed
        return x + vx * passed_s, y + vy * passed_s, heading + turning * passed_s

    def _placed(self, reading, expected):
        """(Landmark, the vehicle's place by it, mm from where it is expected) of the nearest of that ID; None
        where several have it and nothing is expected."""
        landmarks = self._by_id[reading.id]
        if expected is None:
            return (landmarks[0], _vehicle(landmarks[0], reading), 0.0) if len(landmarks) == 1 else None
        best = None
        for landmark in landmarks:
            pose = _vehicle(landmark, reading)
            away_mm = math.hypot(pose[0] - expected[0], pose[1] - expected[1])
            if best is None or away_mm < best[2]:
                best = landmark, pose, away_mm
        return best

    def _there(self, reading, expected):
        """The ID of the landmark that hangs where this reading shows a marker."""
        dx, dy = turn(reading.x_mm, reading.y_mm, expected[2])
        x, y, heading = expected[0] + dx, expected[1] + dy, expected[2] + reading.heading_deg
        for landmark in self._all:
            near = math.hypot(landmark.x_mm - x, landmark.y_mm - y) <= _OTHER_MM
            if near and abs(wrapped(landmark.heading_deg - heading)) <= _OTHER_DEG:
                return landmark.id
        return None

    def _offs(self, good, expected, passed_s):
        for k, (landmark, pose) in enumerate(good):
            for other, by_other in good[k + 1 :]:
                yield _off(landmark, pose, other.number, by_other)
                yield _off(other, by_other, landmark.number, pose)
        fresh = self._marker is not None and expected is not None and passed_s <= _BLIND_S
        if fresh and len(good) == 1 and good[0][0].number != self._marker:
            yield _off(*good[0], self._marker, expected)

    def _take(self, good, time_s, passed_s):
        """The vehicle's place by the marker of before if it is in sight, else by the first."""
        landmark, pose = next((one for one in good if one[0].number == self._marker), good[0])
        same = self._pose is not None and landmark.number == self._marker and 0 < passed_s <= _BLIND_S
        if same:
            step = [pose[0] - self._pose[0], pose[1] - self._pose[1], wrapped(pose[2] - self._pose[2])]
            share = min(1.0, passed_s / 0.1)
            self._speed = tuple(
                v + share * (d / passed_s - v) for v, d in zip(self._speed, step, strict=True)
            )
        elif self._pose is None:
            self._speed = 0.0, 0.0, 0.0
        self._pose, self._time_s, self._marker, self._against = pose, time_s, landmark.number, 0


def _vehicle(landmark, reading):
    """The vehicle's place in the map when this reading is of this landmark."""
    heading = landmark.heading_deg - reading.heading_deg
    dx, dy = turn(reading.x_mm, reading.y_mm, heading)
    return landmark.x_mm - dx, landmark.y_mm - dy, heading


def _off(landmark, pose, partner, by_partner):
    """Where the marker hangs if the vehicle is where the partner says, minus where the map has it."""
    heading = wrapped(by_partner[2] - pose[2])
    dx, dy = turn(landmark.x_mm - pose[0], landmark.y_mm - pose[1], heading)  # as it was seen, turned
    x, y = by_partner[0] + dx - landmark.x_mm, by_partner[1] + dy - landmark.y_mm
    return Off(landmark.number, partner, x, y, heading)
