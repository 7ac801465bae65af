"""Which markers were seen together where there is no odometry: each such frame says how they lie to each
other.

The vehicle's place drops out. Where an ID stands at one place only, it names the
marker. With repeated IDs, markers are told apart by following the vehicle from marker to marker: what is
seen where a known marker is expected is that marker; what is seen elsewhere, beside a known one, is new.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from larics_host.mapping.sightings import Seen, Sighting


# how far a marker may be seen from where it is expected: any, because no other plate has room there; and
# one with the expected ID, because no other of that ID is as near (larics.locate.marker_map.REPEAT_APART_MM)
_PLATE_GATE_MM = 300.0
_ID_GATE_MM = 900.0
_GAP_FRAMES = 10  # without any marker; longer, and the vehicle may be anywhere
_SAME_MM, _SAME_DEG = 40.0, 3.0  # readings of one link that agree
_LEAST = 3  # readings that a link needs
_MOST = 40  # readings kept of a link


class Place:
    """A marker of the building: number, votes of its ID, heights, readings."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.votes: Counter[int] = Counter()
        self.heights_mm: list[float] = []

    @property
    def id(self) -> int:
        return self.votes.most_common(1)[0][0]

    @property
    def seen(self) -> int:
        return sum(self.votes.values())

    def note(self, sighting: Sighting) -> None:
        self.votes[sighting.id] += 1
        if len(self.heights_mm) < 1000:
            self.heights_mm.append(sighting.height_mm)


def turn(x: float, y: float, angle_deg: float) -> tuple[float, float]:
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    return c * x - s * y, s * x + c * y


def wrapped(angle_deg: float) -> float:
    return (angle_deg + 180) % 360 - 180


def _between(a, b):
    """b in the axes of a, both seen in one frame."""
    x, y = turn(b.x_mm - a.x_mm, b.y_mm - a.y_mm, -a.heading_deg)
    return x, y, wrapped(b.heading_deg - a.heading_deg)


class _ById:
    """Names markers by their ID."""

    def __init__(self):
        self.places = {}

    def begin(self):
        """A new log begins."""

    def name(self, frame, sightings):
        """[(Place, Sighting)] of those that can be used."""
        if len({s.id for s in sightings}) < len(sightings):
            return []  # an ID twice in one frame: one of them is misread, and nobody knows which
        named = []
        for sighting in sightings:
            place = self.places.setdefault(sighting.id, Place(len(self.places)))
            place.note(sighting)
            named.append((place, sighting))
        return named

    def all(self):
        return list(self.places.values())


class _ByPlace:
    """Follows the vehicle through each stretch of markers that overlap; see the module."""

    def __init__(self):
        self._found = []  # (Place, x, y, heading, stretch)
        self._stretch = -1
        self._pose = None
        self._frame = None

    def begin(self):
        self._pose = None

    def all(self):
        return [entry[0] for entry in self._found]

    def name(self, frame, sightings):
        if not sightings:
            return []
        if self._pose is None or abs(frame - self._frame) > _GAP_FRAMES:
            self._start()
        self._frame = frame
        matched, rest = self._match(sightings)
        sure = [(entry, s) for entry, s in matched if entry[0].id == s.id]
        if sure:
            self._pose = self._locate(sure)
        elif not matched:
            if self._found and self._found[-1][4] == self._stretch:
                self._start()  # only markers that nothing ties to those before
            rest = sightings
        for entry, sighting in matched:
            entry[0].note(sighting)
        # a new place counts only beside a known one, or as the first of a stretch
        if sure or not matched:
            sure += [(self._add(sighting), sighting) for sighting in rest]
        return [(entry[0], sighting) for entry, sighting in sure]

    def _start(self):
        self._stretch += 1
        self._pose = (0.0, 0.0, 0.0)

    def _expected(self, sighting):
        x, y, heading = self._pose
        dx, dy = turn(sighting.x_mm, sighting.y_mm, heading)
        return x + dx, y + dy, wrapped(heading + sighting.heading_deg)

    def _match(self, sightings):
        matched, rest, used = [], [], set()
        for sighting in sightings:
            x, y, _ = self._expected(sighting)
            here = [
                (math.hypot(entry[1] - x, entry[2] - y), k, entry[0].id == sighting.id)
                for k, entry in enumerate(self._found)
                if entry[4] == self._stretch and k not in used
            ]
            near = [(not same, away, k) for away, k, same in here if away < _PLATE_GATE_MM]
            near = near or [(False, away, k) for away, k, same in here if same and away < _ID_GATE_MM]
            if near:
                k = min(near)[2]
                used.add(k)
                matched.append((self._found[k], sighting))
            else:
                rest.append(sighting)
        return matched, rest

    def _locate(self, sure):
        """The vehicle by the mean of what its markers say."""
        headings = np.radians([entry[3] - s.heading_deg for entry, s in sure])
        heading = math.degrees(math.atan2(np.sin(headings).mean(), np.cos(headings).mean()))
        places = [np.subtract(entry[1:3], turn(s.x_mm, s.y_mm, heading)) for entry, s in sure]
        return (*np.mean(places, axis=0), heading)

    def _add(self, sighting):
        entry = (Place(len(self._found)), *self._expected(sighting), self._stretch)
        entry[0].note(sighting)
        self._found.append(entry)
        return entry


class Readings:
    """Collects what frames show together; repeats: whether IDs stand at several places."""

    def __init__(self, repeats: bool) -> None:
        self._naming: Any = _ByPlace() if repeats else _ById()
        self._readings: dict[tuple[int, int], list] = defaultdict(list)

    def add(self, seen: Seen, wanted: np.ndarray) -> None:
        """Takes the frames of a log; wanted: which of its sightings count here."""
        self._naming.begin()
        frames, which = seen.frames[wanted], np.flatnonzero(wanted)
        if not len(which):
            return
        cuts = np.flatnonzero(np.diff(frames)) + 1
        for part in np.split(which, cuts):
            frame = int(seen.numbers[seen.frames[part[0]]])
            self._take(frame, [seen.sightings[k] for k in part])

    def _take(self, frame, sightings):
        named = self._naming.name(frame, sightings)
        for k, (a, one) in enumerate(named):
            for b, other in named[k + 1 :]:
                if a.number < b.number:
                    self._readings[a.number, b.number].append(_between(one, other))
                elif b.number < a.number:
                    self._readings[b.number, a.number].append(_between(other, one))

    def links(self) -> tuple[list[Place], dict[tuple[int, int], np.ndarray], int]:
        """(places, {(number, number): array (N, 3) of x mm, y mm, heading deg of the second in the axes of
        the first}, readings that agree with no others)."""
        links, refused = {}, 0
        for pair, found in self._readings.items():
            kept = _agreeing(np.array(found))
            refused += len(found) - len(kept)
            if len(kept) >= _LEAST:
                links[pair] = kept[:: -(-len(kept) // _MOST)]
        return self._naming.all(), links, refused


def _agreeing(readings):
    """The largest group of readings that agree with one of them."""
    sample = readings[:: -(-len(readings) // 200)]
    best = None
    for one in sample:
        apart = np.hypot(readings[:, 0] - one[0], readings[:, 1] - one[1])
        turned = np.abs(wrapped(readings[:, 2] - one[2]))
        keep = (apart < _SAME_MM) & (turned < _SAME_DEG)
        if best is None or keep.sum() > best.sum():
            best = keep
    return readings[best]
