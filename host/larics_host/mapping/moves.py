"""Markers that were hung elsewhere while the log was written.

A slip of the wheels looks much the same, and so does a misread marker; and where a marker was moved, its ID
may be misread. A move is believed where the readings
of an ID, in their order, are of two places at neither of which another marker hangs, and all other readings
then agree: by two readings on each side, or by one that no slip explains, and not so far off that it may be
of a marker that is not known.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from larics_host.mapping.association import GATE, READING_SIGMA
from larics_host.mapping.graph import Graph, Reading
from larics_host.mapping.links import Place
from larics_host.mapping.poses import after, axes, between, wrapped
from larics_host.mapping.slips import weigh

_ENOUGH = 2  # readings of a side
_PLATE_MM = 450.0  # plates have no room nearer to each other
_ODD_SHARE = 0.15  # of its readings, or one of at least four, may not go with the others of their side
_NEIGHBOUR = 2.0  # gates that a reading of another marker may be off: two slips in a row, not the move
_NEAR = 2  # passages beside one, whose readings have to agree
_SOUGHT = 6  # times that slips are sought for a trial
_SINGLE_MM = 1500.0  # the farthest move that a side may tell by one reading
_STANDS_OUT = 2.0  # times as large as any other that a single reading tells of: no slip, as the others are
_RIVALS = 4  # single readings that tell of moves, of which each may be the one that is true
_SLIP_MM, _SLIP_MOST_MM = 10.0, 30.0  # of a wheel
_CANCELLED = 26.4  # chi-squared, six degrees of freedom: one in 5,000, as a map has some fifty such readings
_NO_SLIP = 0.1  # how likely a slip is on a leg that shows none
_AGREE_MM = 400.0  # readings of a side
_MISREAD_MM, _FAR_MM = (150.0, 700.0), 1500.0  # from a place that was moved, and from that of the ID read


class Move(NamedTuple):
    """Of a marker: its ID, by how much, the number of its place before."""

    id: int
    mm: float
    former: int


def find_moves(
    graph: Graph, places: dict[int, Place], settled: Callable[[Graph], object] = lambda graph: None
) -> list[Move]:
    """Gives places that were moved a second number for where they were before, which graph and places get,
    and returns the Moves; the graph is solved. settled: lets a graph agree with itself, see settle.

    Somebody moves one marker; where several single readings tell of moves, there were slips, unless one is by
    far the largest, or one alone leaves nothing that tells of others, once slips have explained the rest."""
    before = [(one, one.place, one.used) for one in graph.readings]
    known = dict(graph.places), dict(graph.poses), dict(graph.shares)
    found, singles = _found(graph, places, set(graph.places))
    if len(singles) > 1:
        for one, place, used in before:
            one.place, one.used = place, used
        graph.places, graph.poses, graph.shares = known
        for move in found:
            del places[move.former]
        ranked = sorted(singles, reverse=True)
        (mm, likely), (next_mm, _), *_ = ranked
        if mm <= _STANDS_OUT * next_mm:
            enough = [one for _, one in ranked[:_RIVALS] if _explains_all(graph, places, one, settled)]
            likely = enough[0] if len(enough) == 1 else None
        found, _ = _found(graph, places, {likely})
    return found


def _explains_all(graph, places, number, settled):
    """Whether no single reading tells of a move any more where this place was moved."""
    trial, known = graph.copy(), dict(places)
    if not _found(trial, known, {number})[0]:
        return False
    settled(trial)
    return not _found(trial, known, set(trial.places))[1]


def _found(graph, places, may_be_single):
    """(Moves, [(mm, place)] of those that a single reading tells of, which only some places may have)."""
    found: list[Move] = []
    singles: list[tuple[float, int]] = []
    for number in list(graph.places):
        mine = [one for one in graph.readings if _may_be_of(graph, one, number)]
        mine = [one for one in mine if one.used or not _is_stray(graph, one, number, mine)]
        apart = _split(graph, sorted(mine, key=lambda one: one.passage))
        if apart is None:
            continue
        former = max(places) + 1
        for earlier, later in _variants(*apart):
            is_single = min(len(earlier), len(later)) < _ENOUGH
            if is_single and number not in may_be_single:
                continue
            mm = _tried(graph, number, earlier, later, former)
            if mm is not None:
                places[former] = places[number]
                found.append(Move(places[number].id, mm, former))
                singles += [(mm, number)] * is_single
                break
    return found, singles


def _is_stray(graph, one, number, mine):
    """Whether a reading is far from a place, and no other one of it agrees: another marker was misread."""
    here = _where(graph, one)[:2]
    others = (other for other in mine if other is not one)
    return math.dist(here, graph.places[number][:2]) > _SINGLE_MM and all(
        math.dist(here, _where(graph, other)[:2]) > _AGREE_MM for other in others
    )


def _may_be_of(graph, one, number):
    """Whether a reading may be of a place, or of where it was moved: of its ID, or misread beside it,
    far from the place of the ID read, where no other marker is."""
    if one.place == number:
        return one.used or _alone(graph, one)
    here = _where(graph, one)[:2]
    away = math.dist(here, graph.places[number][:2])
    if one.used or not _MISREAD_MM[0] < away < _MISREAD_MM[1]:
        return False
    others = (pose[:2] for other, pose in graph.places.items() if other not in (number, one.place))
    return math.dist(here, graph.places[one.place][:2]) > _FAR_MM and all(
        math.dist(here, other) > max(_PLATE_MM, away) for other in others
    )


def _variants(earlier, later):
    """Both sides, and both with one reading left out of a side of two, which a slip may have put off."""
    yield earlier, later
    if len(later) == _ENOUGH:
        yield from ((earlier, [one]) for one in later)
    if len(earlier) == _ENOUGH:
        yield from (([one], later) for one in earlier)


def _split(graph, readings):
    """(earlier, later) readings of a place, of which those of one side count and the others do not; a few
    that do not go with their side are left out."""
    best = None
    for k in range(1, len(readings)):
        for first in (True, False):
            earlier = [one for one in readings[:k] if one.used == first]
            later = [one for one in readings[k:] if one.used != first]
            odd = len(readings) - len(earlier) - len(later)
            most = max(_ODD_SHARE * len(readings), 1.0 if len(readings) > _ENOUGH + 1 else 0.0)
            few = odd <= most and (best is None or odd < best[0])
            if earlier and later and few:
                best = odd, earlier, later
    if best is None or not all(_agree(graph, side) for side in best[1:]):
        return None
    return best[1], best[2]


def _where(graph, one):
    return after(graph.poses[one.passage], one.pose)


def _agree(graph, readings):
    first = _where(graph, readings[0])
    return all(math.dist(first[:2], _where(graph, one)[:2]) < _AGREE_MM for one in readings)


def _alone(graph, one):
    """Whether a reading is where no other marker is."""
    here = _where(graph, one)[:2]
    others = (pose[:2] for number, pose in graph.places.items() if number != one.place)
    return all(math.dist(here, other) > _PLATE_MM for other in others)


def _tried(graph, number, earlier: list[Reading], later: list[Reading], former: int):
    """By how many mm the place was moved, after a split that all agree with; else all is as before, and
    None."""
    mine = earlier + later
    was = [(one.place, one.used) for one in mine]
    before = dict(graph.places), dict(graph.poses), dict(graph.shares)
    noises = dict(graph.noises), dict(graph.slipped), dict(graph.expected)
    graph.places[former], graph.places[number] = _where(graph, earlier[0]), _where(graph, later[0])
    for one in mine:
        one.place, one.used = former if any(one is other for other in earlier) else number, True
    graph.solve()
    odd = _surprised(graph, mine)
    if odd and min(len(earlier), len(later)) >= _ENOUGH:
        _seek_slips(graph)  # as these did not count before, no slip beside them was looked for
        odd = _surprised(graph, mine)
    if 0 < len(odd) <= _ODD_SHARE * len(mine):
        for one in odd:
            one.used = False
        earlier, later = ([one for one in side if one.used] for side in (earlier, later))
        graph.solve()
    mm = math.dist(graph.places[former][:2], graph.places[number][:2])
    sides = (earlier, number, later), (later, former, earlier)
    slack = _NEIGHBOUR if min(len(earlier), len(later)) >= _ENOUGH else 1.0
    if _agreed(graph, earlier + later, slack) and all(
        len(side) >= _ENOUGH or _surely(graph, side[0], other, mm, {one.passage for one in rest})
        for side, other, rest in sides
    ):
        return mm
    for one, (place, is_used) in zip(mine, was, strict=True):
        one.place, one.used = place, is_used
    graph.places, graph.poses, graph.shares = before
    graph.noises, graph.slipped, graph.expected = noises
    return None


def _seek_slips(graph):
    for _ in range(_SOUGHT):
        changed = weigh(graph, graph.marginals()).changed
        graph.solve()
        if not changed:
            return


def _surprised(graph, mine):
    """Those of some readings of a solved graph that contradict all else."""
    squares = zip(graph.readings, graph.surprises(graph.marginals()), strict=True)
    own = {one.passage for one in mine}
    return [one for one, square in squares if one.used and one.passage in own and square > GATE]


def _agreed(graph, mine, slack):
    """Whether none of the readings is surprised, nor, `slack` times as much, one of another marker nearby."""
    near = {one.passage + k for one in mine for k in range(-_NEAR, _NEAR + 1)}
    own = {one.passage for one in mine}
    surprises = zip(graph.readings, graph.surprises(graph.marginals()), strict=True)
    return not any(
        one.used and one.passage in near and square > GATE * (1.0 if one.passage in own else slack)
        for one, square in surprises
    )


def _surely(graph, one, number, mm, rest):
    """Whether a single reading tells of a move from or to another place, which passages `rest` read. Were it
    of that place, wheels would have slipped both on the way there and on the way on: it is enough that one of
    the two is not explained by a slip. Where both ways together show none, two slips cancelled each other:
    that is believed of smaller ones only."""
    if not mm < _SINGLE_MM:
        return False
    legs = {a: leg for _, a, _, leg in graph.legs}
    ways = [way for step in (-1, 1) if (way := _way(graph, one, step, legs, rest))]
    slip_mm = _SLIP_MM if len(ways) > 1 else _SLIP_MOST_MM  # at the end of a drive, one slip is enough
    squares = [_contradiction(graph, one, graph.places[number], way, legs, slip_mm) for way in ways]
    if len(ways) > 1:
        is_still = all(graph.slipped.get(k, 0.0) < _NO_SLIP for k in itertools.chain(*ways))
        if is_still and sum(squares) > _CANCELLED:
            return True
    return any(square > GATE for square in squares)


def _way(graph, one, step, legs, rest):
    """The legs, by the passage that each begins with, from a reading's passage back or on to the next one
    that is known without them: one of `rest`, or one whose place is known from elsewhere, too. Others hang on
    this one, and one slip moves them all. None where the drive ends before that."""
    known, way, walked = one.passage, [], {one.passage}
    tied = {place for link in graph.links if link.used for place in (link.first, link.second)}
    tied |= {place for place, _ in graph.given}
    places: dict[int, set[int]] = {}
    for other in graph.readings:
        if other.used:
            places.setdefault(other.place, set()).add(other.passage)
    read = {passage: place for place, passages in places.items() for passage in passages}
    while (first := min(known, known + step)) in legs:
        known += step
        way.append(first)
        walked.add(known)
        place = read.get(known)
        if known in rest or place in tied or (place is not None and not places[place] <= walked):
            return way
    return None


def _contradiction(graph, one, other, way, legs, slip_mm):
    """Chi-squared by which a reading is not of the other place, if its passage lies as a way of legs says and
    a wheel slipped once on it, wherever that explains most."""
    passage = graph.poses[one.passage]
    seen = between(passage, other)
    off = np.subtract(seen, one.pose)
    off[2] = wrapped(off[2])
    swing = np.eye(3)
    swing[:2, 2] = -seen[1], seen[0]
    turns = []
    for k in way:  # what is turned at its end moves the passage
        turn = axes(graph.poses[k][2])
        end = graph.poses[k + 1]
        turn[:2, 2] = end[1] - passage[1], passage[0] - end[0]
        turns.append(swing @ axes(passage[2]).T @ turn)
    still = [turn @ legs[k].covariance(graph.noise) @ turn.T for k, turn in zip(way, turns, strict=True)]
    slips = [
        slip_mm**2 / max(legs[k].way_mm, 1.0) * turn @ legs[k].by_noise @ turn.T
        for k, turn in zip(way, turns, strict=True)
    ]
    spread = sum(still) + np.diag(np.square(READING_SIGMA)) * 3
    return min(float(off @ np.linalg.solve(spread + slip, off)) for slip in slips)
