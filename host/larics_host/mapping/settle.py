"""Solves a map's graph until it agrees with itself: which readings and links count, how loud wheels are.

Readings that contradict all others are set aside, worst first, and taken back when they fit after all; the
noise of the wheels follows from how well the drives close.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from larics_host.mapping.association import GATE
from larics_host.mapping.graph import Graph
from larics_host.mapping.layout import Group

_NOISE_RANGE = (2e-4, 0.1)
_SLIP = 25.0  # squares of its sigma that a leg counts at most
_NOISE_FREEDOM = 12  # degrees of freedom from which on the noise is told by the drives themselves
_LINK_GATE = 36.0  # squares of its sigma by which a link may be off
_ROUNDS = 15
_TAKEN_BACK = 12.0  # chi-squared of a reading that fits again
_CLOSE = 3  # passages beside one that is set aside, which it may have spoilt


def settle(graph: Graph, main: Group, progress: Callable[[float], object], done: float) -> None:
    """Solves until the same readings and links count as before, and the noise is that of the drives.

    main: the Group of which the graph is made; progress is told `done` and up to a quarter more."""
    flips: Counter[int] = Counter()
    for turn in range(_ROUNDS):
        _drop_unread(graph)
        graph.solve()
        if not turn:
            _again_from_here(graph, main)
        changed = _set_links_aside(graph)
        changed |= _set_aside(graph, graph.surprises(graph.marginals()), flips)
        progress(done + 0.25 * (turn + 1) / _ROUNDS)
        # what is wrong strains the wheels as long as it counts
        if not changed and not _heed_noise(graph) and turn:
            break
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


def _heed_noise(graph):
    legs, other, freedom = graph.squares(_SLIP)
    if freedom < _NOISE_FREEDOM:
        return False
    if not graph.legs:
        before = graph.link_noise
        graph.link_noise = min(max(before * other / freedom, 0.1), 100.0)
        return not 0.9 < graph.link_noise / before < 1.1
    share = legs / max(freedom - other, 0.1 * freedom)
    before = graph.noise
    graph.noise = min(max(before * min(max(share, 0.4), 2.5), _NOISE_RANGE[0]), _NOISE_RANGE[1])
    return not 0.9 < graph.noise / before < 1.1


def _set_links_aside(graph):
    changed = False
    for one, squares in zip(graph.links, graph.link_squares(), strict=True):
        used = squares / graph.link_noise < _LINK_GATE
        changed |= used != one.used
        one.used = used
    return changed


def _set_aside(graph, surprises, flips):
    """Sets aside what contradicts all else, of neighbours the worst; takes back what fits."""
    changed = False
    near: set[int] = set()
    places: set[int] = set()
    for k in np.argsort(-np.nan_to_num(surprises)):
        one, square = graph.readings[k], surprises[k]
        if one.used and square > GATE and one.passage not in near and one.place not in places:
            one.used = False
            near.update(range(one.passage - _CLOSE, one.passage + _CLOSE + 1))
            places.add(one.place)
        elif not one.used and square < _TAKEN_BACK and flips[one.passage] < 2 and one.place not in places:
            one.used = True
            flips[one.passage] += 1
        else:
            continue
        changed = True
    return changed
