"""What is known by hand and cannot be: a distance or a place that the drives, and all else that is known,
contradict.

A number with a digit too few bends a whole map, or tears it. So each is judged by all others. What is said is
for people, one line of the worst; empty where nothing is wrong.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from larics_host.mapping.covariance import Covariance
from larics_host.mapping.graph import DISTANCE_SIGMA_MM, PLACE_SIGMA, Graph, Reading
from larics_host.mapping.links import Place
from larics_host.mapping.poses import Pose, after, axes

_LAID_MM, _LAID_SHARE = 1500.0, 0.1  # by which a first layout may be off, and so much of the distance
_GATE = 16.0  # chi-squared
_LENS_SHARE = 0.005  # of a distance: a focal length that was not calibrated well, where no odometry tells
_LENGTH = (
    "markers %d and %d are %.0f mm apart by what is given, %s by the logs: measure again; are these the IDs?"
)
_PLACE = "marker %d is %.0f mm from the given place by all else: measure again; is this the ID?"
_TWICE = (
    "marker %d was read at two places %.1f m apart, and the map has %s of them: was it moved, or is a "
    "reading wrong? Drive by once more"
)
_MISREAD = (
    "marker %d may have been moved: another ID was read %.1f m from its place, where the map has none, and "
    "the map has %s of the two; drive by once more"
)
_NEAR_MM = 100.0, 1500.0  # by which a marker may have been moved; farther, one reading is of another marker
_MOVED_MM = 150.0, 700.0  # the same where its ID was misread there
_PLATE_MM = 450.0  # from another marker; nearer, it was that one which was read
_TOLD = 1e-4  # share of a variance that others have to leave


def by_layout(graph: Graph, lengths: Iterable[tuple[int, int, float]], places: dict[int, Place]) -> str:
    """What lengths [(place, place, mm)] a graph that is laid out only contradicts, beyond what that can be
    off."""
    worst, text = 0.0, ""
    for a, b, mm in lengths:
        laid = math.dist(graph.places[a][:2], graph.places[b][:2])
        off = abs(laid - mm) - _LAID_MM - _LAID_SHARE * max(laid, mm)
        if off > worst:
            ids = places[a].id, places[b].id
            worst, text = off, _apart(*ids, mm, "some %.1f m" % (laid / 1000))
    return text


def by_all_else(graph: Graph, marginals: Covariance, places: dict[int, Place]) -> str:
    """What distances or given places a solved graph contradicts, by what is left of each without it."""
    worst, text = _GATE, ""
    for square, a, b, mm, told in _distances(graph, marginals):
        if square > worst:
            worst, text = square, _apart(places[a].id, places[b].id, mm, "%.0f mm" % told)
    for square, place, mm in _given(graph, marginals):
        if square > worst:
            worst, text = square, _PLACE % (places[place].id, mm)
    return text


class Doubt(NamedTuple):
    """Of a place: its number; the other place (x mm, y mm, rad) where it may be; how probable that is;
    whether that was read later than this one, in part at least; whether another ID was read there."""

    place: int
    other: Pose
    share: float
    is_later: bool
    is_misread: bool


def of_two_places(graph: Graph) -> list[Doubt]:
    """Doubts about places that a solved graph has, while a reading that does not count, of the same ID or of
    one that hangs far away, is of where nothing hangs: a marker was moved there, or the reading is wrong, and
    nothing tells which. What was read nearby before all that counts leaves the place that it has last."""
    others: dict[int, list[Reading]] = {}
    misread = set()
    used: dict[int, list[int]] = {}
    for one in graph.readings:
        if one.used and not one.is_misread:
            used.setdefault(one.place, []).append(one.passage)
    for one in graph.readings:
        place = None if one.used else _doubted(graph, one, len(used.get(one.place, ())))
        if place is not None:
            others.setdefault(place, []).append(one)
            if place != one.place or one.is_misread:
                misread.add(place)
    found = []
    for number, readings in others.items():
        pose, counted = _where(graph, readings[-1]), used.get(number, [])
        share = len(readings) / (len(readings) + len(counted))
        is_later = readings[-1].passage > min(counted, default=0)
        if math.dist(pose[:2], graph.places[number][:2]) < _NEAR_MM[1]:
            last = readings[-1].passage > max(counted, default=0)
            share = max(share, 0.5) if last else share if is_later else 0.0
        found.append(Doubt(number, pose, share, is_later, number in misread))
    return found


def _where(graph, one):
    return after(graph.poses[one.passage], one.pose)


def _doubted(graph, one, used):
    """The number of the place that a reading that does not count leaves in doubt, or None; used: the readings
    of its own place that count."""
    here = _where(graph, one)[:2]
    away = {number: math.dist(here, pose[:2]) for number, pose in graph.places.items()}
    own = away.pop(one.place)
    nearest = min(away, key=lambda number: away[number], default=None)
    free = away[nearest] if nearest is not None else math.inf
    if own < _NEAR_MM[1]:
        return one.place if own > _NEAR_MM[0] and free > _PLATE_MM else None
    if free > _NEAR_MM[1]:
        return one.place if used == 1 else None
    return nearest if _MOVED_MM[0] < free < _MOVED_MM[1] else None


def told(doubts: Iterable[Doubt], graph: Graph, places: dict[int, Place]) -> list[str]:
    """Lines about doubts."""
    lines = []
    for one in doubts:
        away = math.dist(one.other[:2], graph.places[one.place][:2]) / 1000
        text = _MISREAD if one.is_misread else _TWICE
        lines.append(text % (places[one.place].id, away, "the first" if one.is_later else "the last"))
    return lines


def _apart(first, second, mm, told):
    return _LENGTH % (first, second, mm, told)


def _distances(graph, marginals):
    """[(chi-squared, place, place, mm as known, mm as all else has it)] of distances."""
    found = []
    for a, b, mm in graph.distances:
        apart, slope = graph.distance(a, b)
        left = 1 - (slope @ marginals.places([a, b]) @ slope.T).item() / DISTANCE_SIGMA_MM**2
        if left > _TOLD:
            alone = (apart - mm) / left
            spread = DISTANCE_SIGMA_MM**2 / left + (0.0 if graph.legs else _LENS_SHARE * mm) ** 2
            found.append((alone**2 / spread, a, b, mm, abs(mm + alone)))
    return found


def _given(graph, marginals):
    """[(chi-squared, place, mm that it is off by all else)] of given places."""
    found = []
    for place, known in graph.given:
        x, y, heading = graph.places[place]
        # in the axes of the place, as its covariance is
        off = (axes(heading).T @ [x - known[0], y - known[1], 0.0])[:2] / PLACE_SIGMA[:2]
        fitted = marginals.places([place])[:2, :2] / np.outer(PLACE_SIGMA[:2], PLACE_SIGMA[:2])
        shares, sides = np.linalg.eigh(np.eye(2) - fitted)
        told = shares > _TOLD
        alone = (sides.T @ off)[told]
        away = PLACE_SIGMA[0] * np.linalg.norm(alone / shares[told])
        found.append((float(np.sum(alone**2 / shares[told])), place, float(away)))
    return found
