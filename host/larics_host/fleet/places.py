"""Where vehicles see markers: off their places in the map, or too far apart."""

from __future__ import annotations

import math
import statistics
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from larics_host.fleet.tally import Tally
from larics_host.fleet.track import Landmark
from larics_host.fleet.trends import MARKERS
from larics_host.mapping.links import wrapped

_MOVED_MM, _MOVED_DEG = 50.0, 3.0
_SAMPLES = 3  # of a pair of markers, that a median rests on at least


class Moved(NamedTuple):
    """A marker off its place in the map: number, ID, median over those it was seen from, how many."""

    number: int
    id: int
    x_mm: float
    y_mm: float
    heading_deg: float
    partners: int


def moved_markers(tallies: Mapping[str, Tally], landmarks: Sequence[Landmark]) -> list[Moved]:
    """Markers that most of their neighbours see off their place; the farthest is set right first, since it
    makes its neighbours look wrong as well."""
    samples: dict[tuple[int, int], list[tuple[float, float, float]]] = defaultdict(list)
    for _, tally in sorted(tallies.items()):
        for (marker, partner, _), values in sorted(tally.offs.items()):
            samples[marker, partner] += values
    off: dict[int, dict[int, tuple[float, ...]]] = defaultdict(dict)
    for (marker, partner), values in sorted(samples.items()):
        if len(values) >= _SAMPLES:
            off[marker][partner] = tuple(statistics.median(value[k] for value in values) for k in range(3))
    moved = []
    ids = {landmark.number: landmark.id for landmark in landmarks}
    while off:
        found = []
        for marker, by_partner in off.items():
            x, y, heading = (statistics.median(value[k] for value in by_partner.values()) for k in range(3))
            size = max(math.hypot(x, y) / _MOVED_MM, abs(wrapped(heading)) / _MOVED_DEG)
            found.append(
                (size, len(by_partner), -marker, Moved(marker, ids[marker], x, y, heading, len(by_partner)))
            )
        size, _, _, worst = max(found)
        if size <= 1:
            break
        moved.append(worst)
        del off[worst.number]
        for by_partner in off.values():
            by_partner.pop(worst.number, None)
        off = defaultdict(dict, {marker: by_partner for marker, by_partner in off.items() if by_partner})
    return moved


def distance_errors(
    tallies: Mapping[str, Tally], landmarks: Sequence[Landmark]
) -> dict[str, tuple[float, str]]:
    """{vehicle: (share by which it sees pairs of markers too far apart, compared with what)}."""
    once = defaultdict(list)
    for landmark in landmarks:
        once[landmark.id].append(landmark)
    seen: dict[tuple[int, int], dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for vehicle, tally in sorted(tallies.items()):
        for (a, b, _), values in sorted(tally.pairs.items()):
            seen[a, b][vehicle] += values
    shares = defaultdict(list)
    for (a, b), by_vehicle in seen.items():
        known = len(once[a]) == len(once[b]) == 1
        if known:
            one, other = once[a][0], once[b][0]
            usual = math.hypot(one.x_mm - other.x_mm, one.y_mm - other.y_mm)
        elif len(by_vehicle) >= MARKERS:
            usual = statistics.median(statistics.median(values) for values in by_vehicle.values())
        else:
            continue
        for vehicle, values in by_vehicle.items():
            if len(values) >= _SAMPLES and usual:
                shares[vehicle].append(statistics.median(values) / usual - 1)
    what = "in the map" if landmarks else "for the other vehicles"
    return {
        vehicle: (statistics.median(values), what)
        for vehicle, values in shares.items()
        if len(values) >= MARKERS
    }
