"""Solves a map's graph until it agrees with itself: which readings and links count, how loud wheels are.

Readings that contradict all others are set aside, worst first, and taken back when they fit after all. A
wheel that slipped explains a contradiction as well: what is read where another marker hangs is misread, but
what is read beside its own place is first taken for slips, see slips. The noise of the wheels follows from
how well the drives close.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable

import numpy as np

from larics_host.mapping.association import GATE
from larics_host.mapping.graph import Graph
from larics_host.mapping.layout import Group
from larics_host.mapping.poses import after
from larics_host.mapping.slips import weigh

_NOISE_RANGE = (2e-4, 0.1)
_NOISE = 0.001  # that is expected, and counts as much as ...
_NOISE_FREEDOM = 12  # ... so many degrees of freedom, from which on the drives themselves tell the noise
_READ_FREEDOM, _READ_RANGE = 20, (0.3, 20.0)  # the same of readings, against what is expected of them
_LINK_GATE = 36.0  # squares of its sigma by which a link may be off
_ROUNDS = 25
_TAKEN_BACK = 12.0  # chi-squared of a reading that fits again
_TAKEN_BACK_LAST = 150.0  # that may fit if a wheel slipped
_GATE_FIRST, _GATE_CALM = 1000.0, 45.0  # of a reading at no other marker: while slips are sought, after that
_ELSEWHERE_MM = 700.0  # from another marker
_ALIKE_MM = 100.0  # readings that say the same
_FLIPS = 2  # how often a reading may come back
_CLOSE = 3  # passages beside one that is set aside, which it may have spoilt


def settle(
    graph: Graph, main: Group, progress: Callable[[float], object], done: float, is_last: bool = False
) -> None:
    """Solves until the same readings and links count as before, and the noise is that of the drives.

    main: the Group of which the graph is made; progress is told `done` and up to a quarter more; is_last:
    markers that were moved are known, so that slips have to explain what is still read beside its place."""
    back = _TAKEN_BACK_LAST if is_last else _TAKEN_BACK
    flips: Counter[int] = Counter()
    returned: set[int] = set()
    calm = False
    for turn in range(_ROUNDS):
        _drop_unread(graph)
        graph.solve()
        if not turn:
            _again_from_here(graph, main)
        changed = _set_links_aside(graph)
        marginals = graph.marginals()
        changed |= _set_aside(
            graph, graph.surprises(marginals), flips, returned, _GATE_CALM if calm else _GATE_FIRST, back
        )
        weighed = weigh(graph, marginals)
        read = graph.reading_fit(marginals)
        progress(done + 0.25 * (turn + 1) / _ROUNDS)
        # what is wrong strains the wheels as long as it counts
        if not changed and not weighed.changed and not _heed_noise(graph, weighed, read) and turn:
            if calm:
                break
            calm = True
    _drop_unread(graph)
    graph.solve()


def _drop_unread(graph):
    """Takes out what no reading or link ties any more."""
    tied = {one.place for one in graph.readings if one.used}
    tied |= {number for one in graph.links if one.used for number in (one.first, one.second)}
    if graph.anchor is not None:
        tied.add(graph.anchor)
    graph.places = {number: pose for number, pose in graph.places.items() if number in tied}
    graph.readings = [one for one in graph.readings if one.place in graph.places]
    graph.links = [one for one in graph.links if {one.first, one.second} <= set(graph.places)]
    graph.distances = [one for one in graph.distances if {one[0], one[1]} <= set(graph.places)]
    graph.given = [one for one in graph.given if one[0] in graph.places]


def _again_from_here(graph, main):
    """Legs for the shares that were found."""
    first = 0
    legs = []
    for part, _, _ in main.parts:
        if part.drive is not None:
            log = part.drive.log
            new = part.legs(graph.shares[log])
            legs += [(log, first + k, first + k + 1, leg) for k, leg in enumerate(new)]
            first += len(part.drive.passages)
    graph.legs = legs


def _heed_noise(graph, weighed, read):
    squares, freedom = graph.squares()
    if freedom < _NOISE_FREEDOM:
        return False
    if not graph.legs:
        before = graph.link_noise
        graph.link_noise = min(max(before * squares / freedom, 0.1), 100.0)
        return not 0.9 < graph.link_noise / before < 1.1
    squares, freedom = read
    was = graph.read_noise
    share = (squares + _READ_FREEDOM / was) / (freedom + _READ_FREEDOM)
    graph.read_noise = min(max(was * share, _READ_RANGE[0]), _READ_RANGE[1])
    before = graph.noise
    expected = _NOISE_FREEDOM * _NOISE / before
    share = (weighed.squares + expected) / (weighed.freedom + _NOISE_FREEDOM)
    graph.noise = min(max(before * min(max(share, 0.4), 2.5), _NOISE_RANGE[0]), _NOISE_RANGE[1])
    return not (0.9 < graph.noise / before < 1.1 and 0.85 < graph.read_noise / was < 1.15)


def _set_links_aside(graph):
    changed = False
    for one, squares in zip(graph.links, graph.link_squares(), strict=True):
        used = squares / graph.link_noise < _LINK_GATE
        changed |= used != one.used
        one.used = used
    return changed


def _set_aside(graph, surprises, flips, returned, gate, back):
    """Sets aside what contradicts all else, of neighbours the worst, with those that say the same of its
    place; takes back what fits. For readings of what is at no other marker, which slips may explain, hold
    gate and back. Of what was `returned` to in the round before, a slip that explains it is sought first."""
    changed = False
    before = set(returned)
    returned.clear()
    near: set[int] = set()
    places: set[int] = set()
    for k in np.argsort(-np.nan_to_num(surprises)):
        one, square = graph.readings[k], surprises[k]
        if one.used and square > GATE:
            free = one.passage not in near and one.place not in places
            if not free or (square < gate and not _elsewhere(graph, one)):
                continue
            if one.passage in before:
                changed = True
                continue
            for other in _alike(graph, one, surprises):
                other.used = False
                near.update(range(other.passage - _CLOSE, other.passage + _CLOSE + 1))
            places.add(one.place)
        elif not one.used and flips[one.passage] < _FLIPS and one.place not in places and square < back:
            if square > _TAKEN_BACK and _elsewhere(graph, one):
                continue
            one.used = True
            flips[one.passage] += 1
            returned.add(one.passage)
        else:
            continue
        changed = True
    return changed


def _alike(graph, one, surprises):
    """The readings of a place that contradict the others of it as one of them does, and are no majority."""
    here = _where(graph, one)
    mine = [
        (other, square)
        for other, square in zip(graph.readings, surprises, strict=True)
        if other.place == one.place and other.used
    ]
    alike = [
        other for other, square in mine if square > GATE and math.dist(_where(graph, other), here) < _ALIKE_MM
    ]
    return alike if 2 * len(alike) <= len(mine) else [one]


def _where(graph, one):
    return after(graph.poses[one.passage], one.pose)[:2]


def _elsewhere(graph, one):
    """Whether a reading is where another marker is."""
    here = _where(graph, one)
    others = (pose[:2] for number, pose in graph.places.items() if number != one.place)
    return any(math.dist(here, other) < _ELSEWHERE_MM for other in others)
