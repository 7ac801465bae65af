"""Sightings along a stretch with odometry -> passages: one reading for each time that a marker was passed.

What is seen again and again at one place of the odometry frame is one marker: misread frames are outvoted,
and the readings of a passage are brought to one frame, that in which the marker is nearest to the lens. Only
passages enter the map's graph, so that an hour of frames becomes a thousand poses. How the vehicle went while
the marker was in view, the marker itself tells: odometry is needed from where one was seen last to where the
next one was seen first, and a wheel that slips in between, as in a turn below a marker, does no harm. Where a
marker in view goes farther than slips explain, it was hung elsewhere just then, or the vehicle was carried:
one passage ends and another begins, and all other markers tell which it was.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from dataclasses import dataclass, field

import numpy as np

from larics_host.mapping.poses import after, inverse, wrapped
from larics_host.mapping.sightings import Seen, Sighting, Stretch
from larics_host.mapping.wheels import View, wheels_mm

_PLATE_GATE_MM = 300.0  # no other plate has room so near
_WENT_MM, _WENT_RAD = 120.0, 0.15  # by which slips make a marker in view seem to go, at most
_GONE_MM = 1000.0  # of way without the marker: it is out of view
_NEAR_MM = 200.0  # of a wheel's way from the frame of a passage: farther, odometry adds more than a reading
_EDGE_MM, _EDGE_LEAST = 100.0, 3  # of a wheel's way, and readings, that tell where a marker came into view
_MOST = 400  # readings of a passage that are kept
_LEAST_TOGETHER = 3  # frames that show two markers


@dataclass
class Passage:
    """frame: index in the stretch; the marker in the vehicle frame there, mm and radians; votes: how often
    each ID was read; seen: readings that agree; entry, leaving: Views of the vehicle where the marker came
    into view and went out of it, in the axes of the vehicle in the frame; None where few readings tell."""

    frame: int
    x_mm: float
    y_mm: float
    heading: float
    height_mm: float
    votes: Counter
    seen: int
    entry: View | None = None
    leaving: View | None = None

    @property
    def id(self) -> int:
        return self.votes.most_common(1)[0][0]


@dataclass
class Drive:
    """A stretch and its passages, by frame; together: [(index, index, (x mm, y mm, rad))] of two passages and
    how the second marker lay in the axes of the first in frames that show both; log: number of its log."""

    stretch: Stretch
    passages: list = field(default_factory=list)
    together: list = field(default_factory=list)
    log: int = 0


class _Open:
    """A passage that still goes on."""

    def __init__(self, x, y, heading, beside):
        self.x, self.y, self.heading = x, y, heading  # in the odometry frame
        self.beside = beside  # whether it began where another marker was in view
        self.readings = []  # (frame, Sighting)
        self.votes = Counter()
        self.way = 0.0

    def apart(self, x, y):
        return math.hypot(x - self.x, y - self.y)

    def goes_on(self, x, y, heading):
        """Whether a reading may be of the same marker, which hangs still, under a vehicle that goes as its
        odometry says."""
        return self.apart(x, y) < _WENT_MM and abs(wrapped(heading - self.heading)) < _WENT_RAD


def drives(seen: Seen, log: int = 0) -> tuple[list[Drive], np.ndarray]:
    """(the Drive of each stretch of a log, for each sighting whether it belongs to none)."""
    alone = np.ones(len(seen.sightings), bool)
    found = []
    for stretch in seen.stretches:
        begin, end = np.searchsorted(seen.frames, [stretch.frames[0], stretch.frames[-1] + 1])
        place = np.searchsorted(stretch.frames, seen.frames[begin:end])
        inside = stretch.frames[place] == seen.frames[begin:end]
        alone[begin:end] &= ~inside
        rows = [
            (int(k), s) for k, s, here in zip(place, seen.sightings[begin:end], inside, strict=True) if here
        ]
        found.append(_drive(stretch, rows, log))
    return found, alone


def _drive(stretch, rows, log):
    way = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(stretch.x_mm), np.diff(stretch.y_mm)))]).tolist()
    wheels = np.concatenate([[0.0], np.cumsum(wheels_mm(stretch.x_mm, stretch.y_mm, stretch.heading))])
    xs, ys, headings = stretch.x_mm.tolist(), stretch.y_mm.tolist(), stretch.heading.tolist()
    cos, sin = np.cos(stretch.heading).tolist(), np.sin(stretch.heading).tolist()
    running, done = [], []
    shared = defaultdict(list)  # (one, other) -> readings of both in one frame
    frame, here = -1, []
    for k, sighting in rows:
        if k != frame:
            frame, here = k, []
            done += [one for one in running if way[k] - one.way > _GONE_MM]
            running = [one for one in running if way[k] - one.way <= _GONE_MM]
        x = xs[k] + cos[k] * sighting.x_mm - sin[k] * sighting.y_mm
        y = ys[k] + sin[k] * sighting.x_mm + cos[k] * sighting.y_mm
        turned = headings[k] + math.radians(sighting.heading_deg)
        near = [one for one in running if one not in here and one.goes_on(x, y, turned)]
        if near:
            one = min(near, key=lambda one: one.apart(x, y))
        else:
            one = _Open(x, y, turned, any(one.apart(x, y) < _PLATE_GATE_MM for one in running))
            running.append(one)
        one.x, one.y, one.heading, one.way = x, y, turned, way[k]
        one.votes[sighting.id] += 1
        one.readings.append((k, sighting))
        for other in here:
            shared[id(other), id(one)].append((other.readings[-1][1], sighting))
        here.append(one)
    done = [one for one in done + running if len(one.readings) >= _EDGE_LEAST or not one.beside]
    done.sort(key=lambda one: one.readings[0][0])
    passages = {id(one): _passage(one, stretch, wheels) for one in done}
    order = sorted(passages, key=lambda key: passages[key].frame)
    index = {key: k for k, key in enumerate(order)}
    result = Drive(stretch, [passages[key] for key in order], [], log)
    for (a, b), readings in shared.items():
        if a not in passages or b not in passages:
            continue
        read = [(p, q) for p, q in readings if p.id == passages[a].id and q.id == passages[b].id]
        if len(read) >= _LEAST_TOGETHER:
            result.together.append((index[a], index[b], _median([_between(p, q) for p, q in read])))
    return result


def _passage(one, stretch, wheels):
    marker_id = one.votes.most_common(1)[0][0]
    agreeing = [(k, s) for k, s in one.readings if s.id == marker_id]
    key = min(agreeing, key=lambda reading: reading[1].x_mm ** 2 + reading[1].y_mm ** 2)[0]
    near = [(k, s) for k, s in agreeing if abs(wheels[k] - wheels[key]) < _NEAR_MM]
    near = near[:: -(-len(near) // _MOST)]
    place = _brought(near, key, stretch)
    height = float(np.median([s.height_mm for _, s in near]))
    views = (_view(side, key, place, stretch, wheels) for side in (agreeing, agreeing[::-1]))
    return Passage(key, *place, height, one.votes, len(agreeing), *views)


def _brought(readings, key, stretch):
    """Readings (frame, Sighting) brought to one frame by odometry: what is in their middle."""
    frames = np.array([k for k, _ in readings])
    values = np.array([(s.x_mm, s.y_mm, np.radians(s.heading_deg)) for _, s in readings])
    turned = stretch.heading[frames] - stretch.heading[key]
    dx, dy = stretch.x_mm[frames] - stretch.x_mm[key], stretch.y_mm[frames] - stretch.y_mm[key]
    cos, sin = np.cos(stretch.heading[key]), np.sin(stretch.heading[key])
    x = cos * dx + sin * dy + np.cos(turned) * values[:, 0] - np.sin(turned) * values[:, 1]
    y = cos * dy - sin * dx + np.sin(turned) * values[:, 0] + np.cos(turned) * values[:, 1]
    return _median(np.column_stack([x, y, values[:, 2] + turned]))


def _view(readings, key, place, stretch, wheels):
    """The View that readings begin with, of a passage that has the marker at a place in its frame key."""
    edge = wheels[readings[0][0]]
    first = [(k, s) for k, s in readings if abs(wheels[k] - edge) < _EDGE_MM]
    if len(first) < _EDGE_LEAST or abs(wheels[first[-1][0]] - wheels[key]) < _NEAR_MM:
        return None
    at = first[len(first) // 2][0]
    return View(at, after(place, inverse(_brought(first, at, stretch))))


def _median(readings):
    """The middle of readings (x, y, rad), headings around the first one's."""
    values = np.array(readings, float)
    turned = values[:, 2] - values[0, 2]
    values[:, 2] = values[0, 2] + (turned + np.pi) % (2 * np.pi) - np.pi
    return tuple(float(v) for v in np.median(values, axis=0))


def _between(a: Sighting, b: Sighting):
    """b in the axes of a, both seen in one frame: mm, mm, radians."""
    heading = np.radians(a.heading_deg)
    dx, dy = b.x_mm - a.x_mm, b.y_mm - a.y_mm
    cos, sin = np.cos(heading), np.sin(heading)
    return cos * dx + sin * dy, cos * dy - sin * dx, np.radians(b.heading_deg) - heading
