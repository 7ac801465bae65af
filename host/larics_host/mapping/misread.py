"""Passages whose ID was misread: the marker tells itself by where it hangs and how it is turned.

Plates have no room nearer to each other than their width. What was read where another marker hangs, turned as
that one, is that marker; what it tells of the vehicle counts, which the ID does not. What was read a little
beside one, where nothing else hangs, may be that one after it was moved: it is kept, to be looked into.
"""

from __future__ import annotations

import math
from collections import Counter
from typing import NamedTuple

from larics_host.mapping.graph import Graph, Reading
from larics_host.mapping.layout import Part
from larics_host.mapping.poses import Pose, after, wrapped

_NEAR_MM, _NEAR_RAD = 150.0, 0.12  # a wheel that slipped once since the last marker
_FREE_MM = 450.0  # from the next marker
_AWAY_MM = 1500.0  # from the place of the ID that was read; nearer, that marker may have been moved
_MOVED_MM = 700.0  # as far as a misread marker is taken to be moved
_SAME_MM = 300.0  # what was read so near is of one marker


class Unknown(NamedTuple):
    """A marker that a map lacks: IDs that were read there, where (x mm, y mm)."""

    ids: tuple[int, ...]
    x_mm: float
    y_mm: float


def recognize(graph: Graph, passages: list[tuple[int, int, Part]]) -> bool:
    """Gives what was read at the place of another marker to that one; returns whether there was any.

    passages: [(number in the graph, ID read, Part)], the drives' one after the other."""
    given = {one.passage: one for one in graph.readings}
    found = False
    for number, _, pose in _poses(passages):
        one = given.get(number)
        if one is not None and one.used:
            continue
        place, mm, turn = _nearest(graph, number, pose, None if one is None else one.place)
        if mm < _NEAR_MM and abs(turn) < _NEAR_RAD:
            if one is None:
                graph.readings.append(Reading(number, place, pose, is_misread=True))
            else:
                one.place, one.used, one.is_misread = place, True, True
            found = True
        elif one is None and mm < _MOVED_MM:
            graph.readings.append(Reading(number, place, pose, used=False, is_misread=True))
    return found


def unknown(graph: Graph, passages: list[tuple[int, int, Part]]) -> list[Unknown]:
    """The markers that a solved graph lacks, as they were passed with another one's ID."""
    used = {one.passage for one in graph.readings if one.used}
    found: list[Unknown] = []
    for number, marker_id, pose in _poses(passages):
        if number in used:
            continue
        here = after(graph.poses[number], pose)[:2]
        if all(math.dist(here, place[:2]) > _AWAY_MM for place in graph.places.values()):
            near = [k for k, one in enumerate(found) if math.dist(here, one[1:]) < _SAME_MM]
            if near:
                found[near[0]] = Unknown((*found[near[0]].ids, marker_id), *here)
            else:
                found.append(Unknown((marker_id,), *here))
    return found


def rival_ids(graph: Graph, passages: list[tuple[int, int, Part]]) -> dict[int, int]:
    """{place: another ID that was read there at least as often as its own}: where IDs stand at several
    places, nothing else tells which of them was misread."""
    read = {number: marker_id for number, marker_id, _ in passages}
    own: Counter[int] = Counter()
    others: dict[int, Counter[int]] = {}
    for one in graph.readings:
        if one.used and one.is_misread:
            others.setdefault(one.place, Counter())[read[one.passage]] += 1
        elif one.used:
            own[one.place] += 1
    most = {place: ids.most_common(1)[0] for place, ids in others.items()}
    return {place: marker_id for place, (marker_id, count) in most.items() if count >= own[place]}


def _poses(passages):
    """Yields (number, ID read, pose of the marker in the vehicle frame) of passages."""
    begin = 0
    for k, (number, marker_id, part) in enumerate(passages):
        if k and part is not passages[k - 1][2]:
            begin = k
        passage = part.drive.passages[k - begin]
        yield number, marker_id, (passage.x_mm, passage.y_mm, passage.heading)


def _nearest(graph, passage, pose: Pose, own):
    """(place, mm, rad) of the marker nearest to a reading, other than its own; mm is infinite where its own
    is near, or another one is near as well."""
    x, y, heading = after(graph.poses[passage], pose)
    away = {number: math.dist((x, y), place[:2]) for number, place in graph.places.items()}
    if away.pop(own, math.inf) < _AWAY_MM or not away:
        return None, math.inf, 0.0
    place, *others = sorted(away, key=lambda number: away[number])[:2]
    if any(away[other] < max(_FREE_MM, away[place] + _FREE_MM) for other in others):
        return None, math.inf, 0.0
    return place, away[place], wrapped(graph.places[place][2] - heading)
