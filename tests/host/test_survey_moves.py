"""Readings that do not fit a map: of markers that were moved, misread, or seen behind a slip."""

import math
import re
from collections import Counter

import numpy as np
import pytest

from larics_host.mapping import build, contradicted, moves, settle
from larics_host.mapping.graph import Graph, Link, Reading
from larics_host.mapping.links import Place
from larics_host.mapping.mapfile import read_map
from larics_host.mapping.wheels import Way
from tests.host.surveys import built_from, reading
from tools.simulated_drives import World


def test_what_goes_before_a_slip_at_the_end_of_a_drive_is_no_move():
    """A single reading, and nothing behind it: one slip may have done it. Else two had to."""
    way = Way(np.arange(0, 9001.0, 10), np.zeros(901), np.zeros(901))
    graph = Graph(
        noise=0.0005, places={0: (6000.0, 100.0, 0.0), 1: (3000.0, 0.0, 0.0), 2: (9000.0, 0.0, 0.0)}
    )
    graph.poses = {k: (3000.0 * k, 0.0, 0.0) for k in range(4)}
    graph.legs = [(0, k, k + 1, leg) for k, leg in enumerate(way.legs(np.arange(0, 901, 300), np.zeros(6)))]
    graph.readings = [Reading(k, place, (0.0, 0.0, 0.0)) for k, place in ((1, 1), (3, 2), (3, 1))]
    one = Reading(2, 0, (0.0, -150.0, 0.0))
    assert moves._surely(graph, one, 0, 250.0, {3})
    less = Reading(2, 0, (0.0, -60.0, 0.0))  # two slips would explain it, but that they cancelled each other
    assert moves._surely(graph, less, 0, 160.0, {3})
    graph.slipped[2] = 0.5
    assert not moves._surely(graph, less, 0, 160.0, {3})
    assert moves._surely(graph, one, 0, 250.0, {3})
    graph.readings.pop()
    assert not moves._surely(graph, one, 0, 250.0, {3})  # what goes before hangs on it
    assert moves._surely(graph, one, 0, 250.0, {0, 3})  # the other place, too
    graph.links = [Link(1, 2, (6000.0, 0.0, 0.0))]
    assert moves._surely(graph, one, 0, 250.0, {3})  # but not where it is known from elsewhere
    graph.links, graph.given = [], [(1, (3000.0, 0.0, None))]
    assert moves._surely(graph, one, 0, 250.0, {3})
    graph.legs.pop()
    assert not moves._surely(graph, one, 0, 250.0, {3})


@pytest.mark.parametrize(
    "seed",
    [
        20170,  # the first two markers hang on one leg, and a wheel slipped on it
        20154,  # the first four do; the next one of them is no second way to any
        20428,  # another marker was misread as the one that was moved, meanwhile
        20444,  # a wheel slipped behind a reading that did not count before
    ],
)
def test_the_marker_that_was_moved_is_named_alone(tmp_path, seed):
    one, result = built_from(tmp_path, World(), seed)
    assert result.moved == [one.hall[one.moved][0]] and result.errors.max() < 25


def test_a_reading_of_another_marker_far_away_is_a_stray():
    graph = Graph(poses={k: (0.0, 0.0, 0.0) for k in range(3)}, places={0: (0.0, 0.0, 0.0)})
    readings = [reading(0, True), reading(1, False, 4000.0), reading(2, False, 300.0)]
    assert [moves._is_stray(graph, one, 0, readings) for one in readings] == [False, True, False]
    readings[2] = reading(2, False, 4100.0)  # twice: it was moved there
    assert not any(moves._is_stray(graph, one, 0, readings) for one in readings)


def test_a_marker_that_was_moved_may_be_misread_after_that(tmp_path):
    one, result = built_from(tmp_path, World(), 17703)
    assert result.moved == [one.hall[one.moved][0]] and result.errors.max() < 20


@pytest.mark.parametrize(
    ("x_mm", "used", "other_mm", "may_be"),
    [
        (300.0, False, 6000.0, True),
        (100.0, False, 6000.0, False),  # its place, misread
        (800.0, False, 6000.0, False),
        (300.0, True, 6000.0, False),
        (300.0, False, 1700.0, False),  # the marker that was read is near enough
    ],
)
def test_what_another_id_may_tell_of_a_move(x_mm, used, other_mm, may_be):
    graph = Graph(poses={0: (0.0, 0.0, 0.0)}, places={0: (0.0, 0.0, 0.0), 1: (other_mm, 0.0, 0.0)})
    one = Reading(0, 1, (x_mm, 0.0, 0.0), used)
    assert moves._may_be_of(graph, one, 0) is may_be
    graph.places[2] = (x_mm, 250.0, 0.0)  # hangs there
    assert not moves._may_be_of(graph, one, 0)


def test_a_split_may_leave_out_one_reading_of_four():
    graph = Graph(poses={k: (0.0, 0.0, 0.0) for k in range(4)}, places={0: (0.0, 0.0, 0.0)})
    readings = [reading(0, False, 60.0), reading(1, True), reading(2, False, 300.0), reading(3, False, 300.0)]
    assert moves._split(graph, readings) == ([readings[1]], readings[2:])
    assert moves._split(graph, [reading(0, False, 60.0), reading(1, True), reading(2, False, 300.0)]) is None
    graph.poses[4] = (0.0, 0.0, 0.0)
    assert moves._split(graph, [reading(k, k % 2 == 1, 300.0) for k in range(5)]) is None


def test_what_is_taken_back_stays_until_slips_were_sought():
    """The slip that explains a reading is found only with it; it is surprising until then."""
    graph = Graph(poses={k: (0.0, 0.0, 0.0) for k in range(4)}, places={0: (0.0, 0.0, 0.0)})
    graph.readings = [reading(0, True), reading(1, True), reading(2, True), reading(3, False, 80.0)]
    flips, returned = Counter(), set()
    for square, used in ((70.0, True), (2400.0, True), (2400.0, False), (7.0, True), (3.0, True)):
        surprises = np.array([1.0, 1.0, 1.0, square])
        changed = settle._set_aside(graph, surprises, flips, returned, 1000.0, 150.0)
        assert changed == (square != 3.0) and [one.used for one in graph.readings] == [True] * 3 + [used]


@pytest.mark.parametrize(
    "used, x_mm, share, words",
    [
        ((True, False), 9000.0, 0.5, "9.0 m apart, and the map has the first"),
        ((False, True), 9000.0, 0.5, "9.0 m apart, and the map has the last"),
        ((True, True, False), 9000.0, None, ""),  # one of another marker
        ((True, False), 1200.0, 0.5, "1.2 m apart, and the map has the first"),  # it may have been moved
        ((True, True, False), 1200.0, 0.5, "has the first"),
        ((True, True, False, True), 1200.0, 0.25, "has the first"),
        ((False, True), 1200.0, 0.0, "has the last"),  # where it is now
        ((True, False), 60.0, None, ""),
        ((True, False), 5600.0, None, ""),  # where marker 6 is, which was misread
        ((True, False), 5900.0, 1.0, "marker 6 may have been moved: another ID was read 0.4 m"),
        ((True, True), 1200.0, None, ""),
    ],
)
def test_an_id_that_was_read_at_two_places_is_told(used, x_mm, share, words):
    graph = Graph(
        poses={k: (0.0, 0.0, 0.0) for k in range(4)}, places={0: (0.0, 0.0, 0.0), 1: (5500.0, 0, 0)}
    )
    graph.readings = [reading(k, one, 0.0 if one else x_mm) for k, one in enumerate(used)]
    places = {number: Place(number) for number in graph.places}
    for number, place in places.items():
        place.votes[5 + number] += 1
    doubts = contradicted.of_two_places(graph)
    assert [one.share for one in doubts] == ([] if share is None else [share])
    (line,) = contradicted.told(doubts, graph, places) or [""]
    assert words in line and ("marker 5" in line or x_mm == 5900.0 or not words)
    covariance = np.eye(6)
    build._add_doubts(covariance, doubts, graph, [1, 0])
    own = 0 if x_mm == 5900.0 else 3
    off = 400.0 if x_mm == 5900.0 else x_mm
    assert covariance[own, own] == pytest.approx(1 + min(900.0, off * math.sqrt(share or 0)) ** 2)
    assert np.delete(np.diag(covariance), own) == pytest.approx(1)


def test_a_marker_that_was_moved_or_not_is_told_with_its_sigma(tmp_path, capsys, monkeypatch):
    """Where nothing tells of a move, its place in the map may be the one before."""
    monkeypatch.setattr(build, "find_moves", lambda graph, places, settled: [])
    one, result = built_from(tmp_path, World(markers=9, length_m=100.0, wrong=0.0), 5016)
    assert not result.moved
    doubted = [marker for marker in read_map(tmp_path / "drive.map.json").markers if marker.sigma_mm > 50]
    assert [marker.id for marker in doubted] == [one.hall[one.moved][0]]


def test_places_that_coincide_contradict_a_distance():
    """And divide nothing by nothing."""
    graph = Graph(places={0: (0.0, 0.0, 0.0), 1: (0.0, 0.0, 0.3)}, anchor=0)
    graph.links = [Link(0, 1, (0.0, 0.0, 0.3)) for _ in range(3)]
    graph.distances = [(0, 1, 700.0)]
    places = {number: Place(number) for number in graph.places}
    for number, place in places.items():
        place.votes[5 + number] += 1
    line = contradicted.by_all_else(graph, graph.marginals(), places)
    assert re.match(r"markers 5 and 6 are 700 mm apart by what is given, \d+ mm by the logs", line)


def test_a_neighbour_may_have_slipped_where_a_marker_was_moved():
    class Surprised:
        readings = (reading(5, True), reading(6, True), reading(9, True))

        def marginals(self):
            return None

        def surprises(self, _):
            return self.squares

    graph = Surprised()
    for squares, slack, agreed in (
        ((20.0, 30.0, 99.0), 2.0, True),
        ((20.0, 43.0, 99.0), 2.0, False),
        ((20.0, 30.0, 99.0), 1.0, False),
        ((22.0, 3.0, 99.0), 2.0, False),
    ):
        graph.squares = squares
        assert moves._agreed(graph, [graph.readings[0]], slack) == agreed, squares


def test_of_several_moves_the_one_that_leaves_no_other_is_believed(tmp_path):
    """The other one is told by a reading that a slip beside the moved marker has put off."""
    one, result = built_from(tmp_path, World(), 17710)
    assert result.moved == [one.hall[one.moved][0]] and result.errors.max() < 40


def test_sides_of_two_readings_may_do_without_one():
    a, b, c, d = (reading(k, True) for k in range(4))
    assert list(moves._variants([a], [b, c, d])) == [([a], [b, c, d])]
    assert list(moves._variants([a, b], [c, d])) == [
        ([a, b], [c, d]), ([a, b], [c]), ([a, b], [d]), ([a], [c, d]), ([b], [c, d]),
    ]  # fmt: skip


def test_several_moves_told_by_single_readings_are_slips(monkeypatch):
    places = {number: Place(number) for number in range(3)}
    for number, place in places.items():
        place.votes[number + 1] += 1
    graph = Graph(places={number: (1000.0 * number, 0.0, 0.0) for number in places})
    graph.readings = [Reading(k, k // 4, (0.0, 0.0, 0.0), k % 4 == 0) for k in range(8)]
    graph.poses = {k: (1000.0 * (k // 4) + 500 * (k % 4 > 0), 0.0, 0.0) for k in range(8)}

    def tried(graph, number, earlier, later, former):
        graph.places[former] = graph.places[number]
        earlier[0].place = former
        return moved_mm[number]

    moved_mm = {0: 300.0, 1: 500.0}
    monkeypatch.setattr(moves, "_tried", tried)
    assert moves.find_moves(graph, places) == [] and sorted(places) == [0, 1, 2]
    assert sorted(graph.places) == [0, 1, 2] and [one.place for one in graph.readings] == [0] * 4 + [1] * 4
    moved_mm[0] = 200.0  # one that stands out is no slip
    assert [move.id for move in moves.find_moves(graph, places)] == [2]
    assert [one.place for one in graph.readings] == [0] * 4 + [3] + [1] * 3
    graph.readings, graph.places = graph.readings[:4], {0: (0.0, 0.0, 0.0)}
    assert [move.id for move in moves.find_moves(graph, places)] == [1]
