"""A map from what logs tell and what is known by hand: first laid out, then solved as one pose graph.

What the map says of a marker's place comes with its standard deviation: against the anchor and the given
places, or without any against the map as a whole.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from larics_host.errors import UserError
from larics_host.mapping import contradicted
from larics_host.mapping import graph as graphs
from larics_host.mapping.collect import Collected
from larics_host.mapping.graph import Graph, Link, Reading
from larics_host.mapping.layout import Group, Layout, Part, layout
from larics_host.mapping.links import Place
from larics_host.mapping.lost import refuse_lost
from larics_host.mapping.misread import Unknown, recognize, rival_ids, unknown
from larics_host.mapping.moves import Move, find_moves
from larics_host.mapping.poses import Pose, after, inverse, rigid_fit, wrapped
from larics_host.mapping.settle import settle
from larics_host.mapping.ties import tie
from larics_host.wording import counted

_NOISE = 0.001  # of the wheels, to begin with: a slip in 50 m
_LAYOUTS = 2  # the second where the noise turned out to be ...
_LAID_OUT_ANEW = 2.5  # ... so many times what was thought
_PARTS = 6  # that the readings of two markers seen together are cut into, in their order
_FOCAL_SHARE = 0.001  # standard deviation
_WORST_MM = 500.0  # standard deviation of a place that still is one
_DOUBT_MOST_MM, _DOUBT_MOST_RAD = 900.0, 1.4  # rows of a map have up to 1,000 mm and 90 degrees


@dataclass
class Request:
    """What is known by hand: anchor (ID, x mm, y mm, heading deg); given [(ID, x, y, heading or None)];
    distances [(ID, ID, mm)]."""

    anchor: tuple[int, float, float, float] | None = None
    given: list[tuple[int, float, float, float | None]] = field(default_factory=list)
    distances: list[tuple[int, int, float]] = field(default_factory=list)

    def lengths(self) -> list[tuple[int, int, float]]:
        """[(ID, ID, mm)]: the distances, and those of anchor and given places from each other."""
        known = [one[:3] for one in self.given] + ([self.anchor[:3]] if self.anchor else [])
        between = itertools.combinations(known, 2)
        return self.distances + [(a[0], b[0], math.dist(a[1:], b[1:])) for a, b in between]


class Sigmas(NamedTuple):
    """Standard deviations: of x or y, the larger; of the heading."""

    place_mm: float
    heading_deg: float


@dataclass
class Built:
    """places {number: Place} and, of those tied together, poses {number: (x mm, y mm, heading deg)} and
    covariances {number: (3, 3) of x mm, y mm, rad}; untied: groups of numbers that are not.

    lines [((x, y), (x, y))] of what was seen together or one after the other; passages, and aside: Counter of
    the IDs of those that were misread or set aside; unknown: markers that the map lacks; passed {number: how
    often}; moves; before {number of a former place: (x mm, y mm)}; rms of the readings in mm; shares
    {log: of the odometry} and noise of the wheels; notes for the user; is_scaled: whether a length
    that is known by hand holds the map."""

    places: dict[int, Place]
    poses: dict[int, Pose]
    covariances: dict[int, np.ndarray]
    untied: list[list[int]]
    lines: list = field(default_factory=list)
    links: int = 0
    passages: int = 0
    aside: Counter = field(default_factory=Counter)
    unknown: list[Unknown] = field(default_factory=list)
    passed: Counter = field(default_factory=Counter)
    moves: list[Move] = field(default_factory=list)
    before: dict[int, tuple[float, float]] = field(default_factory=dict)
    rms_mm: float = 0.0
    shares: dict = field(default_factory=dict)
    noise: float = 0.0
    notes: list[str] = field(default_factory=list)
    is_scaled: bool = False

    def sigmas(self, number: int) -> Sigmas:
        spread = np.sqrt(np.diag(self.covariances[number]))
        return Sigmas(float(spread[:2].max()), math.degrees(spread[2]))


_CONTRADICTED = (
    "what is given is so far from what the logs tell that no map can be made of both: are distances and "
    "places in millimetres, and of these IDs?"
)
_RIVAL = "marker %d at x %.0f y %.0f mm was read as marker %d, too, as often: drive by it once more"
_UNDETERMINED = "these logs do not determine one map: drive by the markers once more"


def build(
    collected: Collected, request: Request, progress: Callable[[float], object] = lambda done: None
) -> Built:
    """The Built of what was collected. UserError when no two markers are tied, when what is known by hand is
    not of one marker each, and when the drives do not make one map. progress is told the share that is
    done."""
    try:
        return _build(collected, request, progress)
    except (np.linalg.LinAlgError, RuntimeError):  # gtsam's of a system that nothing determines
        raise UserError(_CONTRADICTED if request.lengths() else _UNDETERMINED) from None


def _build(collected, request, progress):
    graphs.needed()
    noise = _NOISE
    for attempt in range(_LAYOUTS):
        laid = layout(collected, noise, request.lengths())
        if not laid.groups:
            raise UserError("no marker was read in these logs: a map needs two or more")
        notes: list[str] = []
        main, untied = _tied(laid, request, notes)
        if len(main.poses) < 2:
            raise UserError(_untied(collected))
        done = (1 + 3 * attempt) / (4 * _LAYOUTS)
        progress(done)
        graph, passages = _graph(main, laid, collected, request, noise)
        inside = _lengths(laid, request.lengths(), set(graph.places))
        wrong = contradicted.by_layout(graph, inside, laid.places)
        if wrong:
            raise _not_of_this_hall(wrong, collected, request, passages)
        settle(graph, main, progress, done)
        if recognize(graph, passages):
            settle(graph, main, progress, done)
        if not passages or graph.loudness() < _LAID_OUT_ANEW * noise:
            break
        noise = graph.loudness()  # much worse than thought: other passages may be of one marker then
    moves = find_moves(
        graph, laid.places, lambda trial: settle(trial, main, lambda _: None, 0.7, is_last=True)
    )
    settle(graph, main, progress, 0.7, is_last=True)
    doubtful = replace(graph, noises=graph.expected)  # a leg on which a wheel may have slipped is less known
    marginals = doubtful.marginals()
    wrong = contradicted.by_all_else(graph, marginals, laid.places)
    try:
        unread = refuse_lost(graph, passages)
    except UserError:
        if wrong:
            raise _not_of_this_hall(wrong, collected, request, passages) from None
        raise
    notes += [wrong] if wrong else []
    doubts = contradicted.of_two_places(graph)
    notes += contradicted.told(doubts, graph, laid.places)
    if collected.repeats:
        for number, marker_id in rival_ids(graph, passages).items():
            ids = laid.places[number].id, *graph.places[number][:2], marker_id
            notes.append(_RIVAL % ids)
    progress(0.95)
    former = {move.former for move in moves}
    numbers = [number for number in graph.places if number not in former]
    covariance = graph.place_covariance(marginals, numbers)
    if request.anchor is None and not request.given:
        covariance = _free(covariance, [graph.places[number] for number in numbers])
    is_scaled = bool(graph.distances) or len(graph.given) + (request.anchor is not None) > 1
    if not is_scaled:
        covariance = covariance + _unscaled(graph, numbers, request.anchor is not None)
    worst = math.sqrt(max(float(covariance[k, k]) for k in range(len(covariance)) if k % 3 < 2))
    if worst > _WORST_MM:
        raise UserError(
            "the drives do not make one map: a marker's place is known to %.1f m only; drive loops that "
            "pass each marker several times" % (worst / 1000)
        )
    _add_doubts(covariance, doubts, graph, numbers)
    built = Built(
        laid.places, {}, {}, untied, notes=notes, moves=moves, noise=graph.noise, shares=graph.shares
    )
    built.is_scaled = is_scaled
    built.before = {number: graph.places[number][:2] for number in former if number in graph.places}
    for k, number in enumerate(numbers):
        x, y, heading = graph.places[number]
        built.poses[number] = (float(x), float(y), round(math.degrees(heading), 2) % 360)
        built.covariances[number] = covariance[3 * k : 3 * k + 3, 3 * k : 3 * k + 3]
    built.passages = len(passages)
    built.aside, built.unknown = unread, unknown(graph, passages)
    built.passed = Counter(one.place for one in graph.readings if one.used)
    _tell_fit(built, graph)
    return built


def _untied(collected):
    """Why there is no map of two markers."""
    ids = collected.ids()
    if len(ids) == 1 and not collected.repeats:
        return "marker %d is the only one that was read: a map needs two or more" % next(iter(ids))
    text = "no two markers were seen in one frame often enough, and no odometry ties them: drive so that "
    return text + "neighbours are in view together, let the vehicle send ODOMETRY, or give distances"


def _tied(laid: Layout, request, notes):
    """(the main group with all that distances tie to it, groups of numbers that are not)."""
    anchor = request.anchor[0] if request.anchor else None
    most = len(laid.groups[0].poses)
    main = max(
        (group for group in laid.groups if len(group.poses) == most),
        key=lambda group: any(laid.places[number].id == anchor for number in group.poses),
    )
    waiting = [group for group in laid.groups if group is not main]
    numbers = {number for group in laid.groups for number in group.poses}
    distances = [(_number(laid, a, numbers), _number(laid, b, numbers), mm) for a, b, mm in request.distances]
    tied = True
    while tied:
        tied = False
        for group in waiting:
            between = [
                one
                for one in distances
                if (one[0] in main.poses) != (one[1] in main.poses)
                and {one[0], one[1]} <= {*main.poses, *group.poses}
            ]
            names = ", ".join(str(laid.places[k].id) for k in group.poses)
            poses = {**main.poses, **group.poses}
            moved = tie(list(group.poses), list(main.poses), poses, between, names, notes)
            if moved:
                first = next(iter(group.poses))
                motion = after(moved[first], inverse(group.poses[first]))
                main.poses.update(moved)
                main.parts += [(part, after(motion, own), same) for part, own, same in group.parts]
                waiting.remove(group)
                tied = True
                break
    return main, [list(group.poses) for group in waiting]


def _number(laid, marker_id, among):
    """The number of the only place with this ID."""
    found = [number for number in among if laid.places[number].id == marker_id]
    if len(found) != 1:
        count = counted(len(found), "place") if found else "no place"
        raise UserError("marker %d: %s in the logs with this ID, one is needed" % (marker_id, count))
    return found[0]


def _graph(main: Group, laid, collected, request, noise):
    """(the Graph of a group, [(passage's number in the graph, ID read, Part)])."""
    graph = Graph(noise=noise, places=dict(main.poses))
    by_id = {laid.places[number].id: number for number in main.poses} if not collected.repeats else {}
    passages: list[tuple[int, int, Part]] = []
    for part, motion, numbers in main.parts:
        if part.drive is None:
            graph.links += _links_of(part, numbers, collected)
        else:
            _add_drive(graph, part, motion, numbers, by_id, passages)
    graph.distances = _lengths(laid, request.distances, set(graph.places))
    _place(graph, laid, request)
    return graph, passages


def _lengths(laid, lengths, inside):
    """[(number, number, mm)] of the lengths that are known of places in there."""
    known = [(*(_number(laid, one, laid.places) for one in pair), mm) for *pair, mm in lengths]
    return [one for one in known if inside >= {one[0], one[1]}]


def _links_of(part, numbers, collected):
    index = {own: numbers[k] for k, own in enumerate(part.numbers)}
    links = []
    for (a, b), readings in collected.links.items():
        if a in index and b in index and index[a] != index[b]:
            for some in np.array_split(readings, min(_PARTS, len(readings))):
                x, y, heading = np.median(some, axis=0)
                links.append(Link(index[a], index[b], (x, y, math.radians(heading))))
    return links


def _add_drive(graph, part, motion, numbers, by_id, passages):
    first = len(passages)
    log = part.drive.log
    graph.shares.setdefault(log, part.shares)
    legs = part.legs(part.shares)
    place_of = {}
    for index, found in enumerate(part.founds):
        for k in found.passages:
            place_of[k] = numbers[index], k in found.sure
    known: dict[int, Pose] = {}
    for k, passage in enumerate(part.drive.passages):
        number, sure = place_of.get(k, (by_id.get(passage.id), False))
        reading = (passage.x_mm, passage.y_mm, passage.heading)
        if sure:
            known[k] = after(graph.places[number], inverse(reading))
        if number is not None:
            graph.readings.append(Reading(first + k, number, reading, sure))
        passages.append((first + k, passage.id, part))
    start = min(known)
    for k in range(start, len(part.drive.passages)):
        known.setdefault(k, after(known[k - 1], legs[k - 1].pose) if k > start else known[start])
    for k in range(start - 1, -1, -1):
        known[k] = after(known[k + 1], inverse(legs[k].pose))
    graph.poses.update({first + k: pose for k, pose in known.items()})
    graph.legs += [(log, first + k, first + k + 1, leg) for k, leg in enumerate(legs)]
    for a, b, pose in part.drive.together:
        if place_of.get(a, (0, False))[1] and place_of.get(b, (0, False))[1]:
            graph.links.append(Link(place_of[a][0], place_of[b][0], pose))


def _place(graph, laid, request):
    """Moves all to where anchor and given places say, and holds it there."""
    inside = set(graph.places)
    graph.given = [
        (_number(laid, marker_id, inside), (x, y, None if turned is None else math.radians(turned)))
        for marker_id, x, y, turned in request.given
    ]
    if request.anchor is not None:
        graph.anchor = _number(laid, int(request.anchor[0]), inside)
        target = *request.anchor[1:3], math.radians(request.anchor[3])
        motion = after(target, inverse(graph.places[graph.anchor]))
    elif graph.given:
        own = np.array([graph.places[number][:2] for number, _ in graph.given])
        motion = rigid_fit(own, np.array([pose[:2] for _, pose in graph.given]))
    else:
        read = {one.place for one in graph.readings if one.used}
        graph.anchor = min(read | {number for one in graph.links for number in (one.first, one.second)})
        motion = inverse(graph.places[graph.anchor])
    for kept in (graph.poses, graph.places):
        for number, pose in kept.items():
            kept[number] = after(motion, pose)


def _not_of_this_hall(text, collected, request, has_drives):
    """The UserError that what is known by hand cannot be; but where drives do not make one map without that
    either, that is raised."""
    if has_drives:
        build(collected, Request(request.anchor))
    return UserError(text)


def _free(covariance, poses):
    """Covariance after the rigid motion that fits the whole map best, in place of that against the anchor."""
    places = np.array(poses)
    off = places[:, :2] - places[:, :2].mean(axis=0)
    motion = np.zeros((3 * len(places), 3))
    motion[0::3, 0] = motion[1::3, 1] = motion[2::3, 2] = 1.0
    motion[0::3, 2], motion[1::3, 2] = -off[:, 1], off[:, 0]
    fitted = motion.copy()
    fitted[2::3] = 0.0  # by places alone
    still = np.eye(len(motion)) - motion @ np.linalg.solve(fitted.T @ fitted, fitted.T)
    return still @ covariance @ still.T


def _unscaled(graph, numbers, is_anchored):
    """Covariance by a scale that no measured length holds: what a calibration leaves of the focal length."""
    places = np.array([graph.places[number] for number in numbers])
    off = places[:, :2] - (graph.places[graph.anchor][:2] if is_anchored else places[:, :2].mean(axis=0))
    slope = np.zeros(3 * len(places))
    slope[0::3], slope[1::3] = off.T
    return _FOCAL_SHARE**2 * np.outer(slope, slope)


def _add_doubts(covariance, doubts, graph, numbers):
    """Adds to the covariance of places what they are off by where they are the other one of two, as far as a
    camera's map can hold that."""
    for doubt in doubts:
        if doubt.place in numbers:
            off = np.subtract(doubt.other, graph.places[doubt.place])
            off[2] = wrapped(off[2])
            off *= math.sqrt(doubt.share)
            off[:2] *= _DOUBT_MOST_MM / max(_DOUBT_MOST_MM, math.hypot(*off[:2]))
            off[2] = min(max(off[2], -_DOUBT_MOST_RAD), _DOUBT_MOST_RAD)
            own = slice(3 * numbers.index(doubt.place), 3 * numbers.index(doubt.place) + 3)
            covariance[own, own] += np.outer(off, off)


def _tell_fit(built, graph):
    """lines, links and rms of a Built."""
    built.links = len({(one.first, one.second) for one in graph.links if one.used})
    seen = {(one.first, one.second) for one in graph.links if one.used}
    place = {one.passage: one.place for one in graph.readings if one.used}
    seen |= {(place[a], place[b]) for _, a, b, _ in graph.legs if a in place and b in place}
    built.lines = [
        (built.poses[a][:2], built.poses[b][:2])
        for a, b in sorted(seen)
        if a != b and a in built.poses and b in built.poses
    ]
    errors = [off for one in graph.readings if one.used for off in graph.reading_error(one)[:2]]
    errors += [off for one in graph.links if one.used for off in graph.link_error(one)[:2]]
    built.rms_mm = float(np.sqrt(np.mean(np.square(errors))))
