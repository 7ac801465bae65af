"""Passages whose ID was misread: at another marker's place, beside a moved one, where none is known."""

import math
from collections import Counter

import cv2
import numpy as np
import pytest

from larics_host import cli
from larics_host.mapping import misread
from larics_host.mapping.contradicted import of_two_places, told
from larics_host.mapping.draw import draw_map
from larics_host.mapping.graph import Graph, Reading
from larics_host.mapping.layout import Part
from larics_host.mapping.links import Place
from larics_host.mapping.mapfile import Map, Marker
from larics_host.mapping.passages import Drive, Passage
from larics_host.plots import COLOURS
from tests.host.surveys import built_from
from tools.simulated_drives import World, drive, write_log


def passages_of(*drives):
    """[(number, ID, Part)] of drives, each [(x mm, y mm, rad) of a marker that was read as 7]."""
    found = []
    for poses in drives:
        part = Part([], drive=Drive(None, [Passage(0, *pose, 2750.0, Counter({7: 9}), 9) for pose in poses]))
        found += [(len(found) + k, 7, part) for k in range(len(poses))]
    return found


def graph_of(*places, count=1):
    graph = Graph(places=dict(enumerate(places)))
    graph.poses = {k: (1000.0, 0.0, 0.0) for k in range(count)}
    return graph


@pytest.mark.parametrize(
    ("pose", "place", "used"),
    [
        ((20.0, -30.0, 0.5), 0, True),
        ((20.0, -30.0, 0.5 + 2 * math.pi), 0, True),
        ((20.0, -30.0, 0.8), 0, False),  # turned otherwise
        ((0.0, 300.0, 0.5), 0, False),  # beside it
        ((0.0, 800.0, 0.5), None, False),
        ((2800.0, 0.0, 0.5), None, False),  # between two
    ],
)
def test_what_is_read_where_a_marker_hangs_is_that_one(pose, place, used):
    graph = graph_of((1000.0, 0.0, 0.5), (4000.0, 0.0, 0.5), (3600.0, 0.0, 0.5))
    assert misread.recognize(graph, passages_of([pose])) is used
    assert [(one.place, one.used, one.is_misread) for one in graph.readings] == [(place, used, True)] * (
        place is not None
    )


def test_a_reading_that_contradicts_its_own_place_is_given_to_the_other():
    graph = graph_of((1000.0, 0.0, 0.5), (4000.0, 0.0, 0.5), count=3)
    pose = (0.0, 0.0, 0.5)
    graph.readings = [Reading(0, 1, pose, False), Reading(2, 1, pose, True)]
    assert misread.recognize(graph, passages_of([(9000.0, 0.0, 0.0)], [pose, pose]))  # the second drive's
    assert [(one.passage, one.place, one.used, one.is_misread) for one in graph.readings] == [
        (0, 1, False, False),
        (2, 1, True, False),
        (1, 0, True, True),
    ]


def test_where_the_own_place_is_near_a_marker_may_have_been_moved():
    graph = graph_of((1000.0, 0.0, 0.5), (2000.0, 0.0, 0.5))
    graph.readings = [Reading(0, 1, (0.0, 0.0, 0.5), False)]
    assert not misread.recognize(graph, passages_of([(0.0, 0.0, 0.5)]))
    assert not graph.readings[0].used


def test_what_is_misread_beside_a_marker_leaves_it_in_doubt():
    graph = graph_of((1000.0, 0.0, 0.5), (6000.0, 0.0, 0.5), count=3)
    graph.readings = [Reading(0, 0, (0.0, 0.0, 0.5))]
    assert not misread.recognize(
        graph, passages_of([(0.0, 0.0, 0.5), (0.0, 300.0, 0.5), (5000.0, 5.0, 0.5)])[:2]
    )
    (doubt,) = of_two_places(graph)
    assert (doubt.place, doubt.share, doubt.is_misread) == (0, 0.5, True)
    places = {number: Place(number) for number in graph.places}
    for place in places.values():
        place.votes[5] += 1
    (line,) = told([doubt], graph, places)
    assert "marker 5 may have been moved" in line and "0.3 m" in line


def test_another_id_at_a_place_does_not_vouch_for_its_own():
    """Read once as itself and once as another one, it may be the other; its ID stands elsewhere, too."""
    graph = graph_of((1000.0, 0.0, 0.0), count=3)
    graph.readings = [Reading(0, 0, (0.0, 0.0, 0.0)), Reading(1, 0, (5000.0, 0.0, 0.0), False)]
    graph.readings.append(Reading(2, 0, (0.0, 0.0, 0.0), is_misread=True))
    assert [doubt.share for doubt in of_two_places(graph)] == [0.5]
    graph.readings[2].is_misread = False
    assert not of_two_places(graph)


def test_a_place_that_was_read_as_often_as_another_id_is_told():
    graph = graph_of((0.0, 0.0, 0.0), (4000.0, 0.0, 0.0), count=6)
    pose = (0.0, 0.0, 0.0)
    ids = (5, 7, 5, 7, 5, 5)
    graph.readings = [
        Reading(k, k // 2 % 2, pose, is_misread=marker_id == 7) for k, marker_id in enumerate(ids)
    ]
    passages = [(k, marker_id, None) for k, marker_id in enumerate(ids)]
    assert misread.rival_ids(graph, passages) == {1: 7}
    graph.readings[3].used = False
    assert not misread.rival_ids(graph, passages)


def test_markers_that_a_map_lacks():
    graph = graph_of((1000.0, 0.0, 0.0), count=4)
    graph.readings = [Reading(0, 0, (0.0, 0.0, 0.0))]
    far = [(4000.0, 10.0 * k, 0.0) for k in range(2)]
    (one,) = misread.unknown(graph, passages_of([(0.0, 0.0, 0.0), *far, (1400.0, 0.0, 0.0)]))
    assert one.ids == (7, 7) and np.allclose(one[1:], (5000.0, 10.0))


def test_a_marker_that_was_moved_is_named_though_misread_among_repeated_ids(tmp_path):
    """What was read there belongs to no place of its own ID."""
    one, result = built_from(tmp_path, World(ids=7), 99, "--repeats", distance=False)
    assert result.moved == [one.hall[one.moved][0]] and result.errors.max() < 20
    assert result.surplus == result.missing == 0


@pytest.mark.parametrize(
    ("seed", "line"),
    [
        (
            7,
            "the map lacks a marker near x 4148 y -8223 mm, read as marker 782: drive by it once more",
        ),
        (12, "drive by once more: marker 1011 (passed once, +- 15 mm)"),
    ],
)
def test_where_to_drive_by_once_more_is_told(tmp_path, capsys, seed, line):
    one = drive(World(markers=9, length_m=50.0, wrong=0.12, moved=False), seed)
    log = write_log(tmp_path / "drive.bin", one)
    first, second = one.hall[0], one.hall[5]
    taped = "%d,%d,%.1f" % (first[0], second[0], math.dist(first[1:3], second[1:3]))
    picture = str(tmp_path / "m.png")
    words = ["-o", str(tmp_path / "m.json"), "--distance", taped, "--png", picture]
    assert cli.main(["map", "build", str(log), *words]) == 0
    assert line in capsys.readouterr().out
    assert remarked(cv2.imread(picture)) > 10
    assert cli.main(["map", "draw", str(tmp_path / "m.json"), "-o", picture]) == 0
    assert not remarked(cv2.imread(picture))


def remarked(picture):
    """Pixels in the colour of remarks."""
    colour = [int(COLOURS[1][k : k + 2], 16) for k in (5, 3, 1)]
    return int(np.sum(np.abs(picture.astype(int) - colour).max(axis=2) < 30))


def test_a_marker_that_was_moved_has_an_arrow():
    hall = Map([Marker(3, 0.0, 0.0, 0.0), Marker(5, 3000.0, 0.0, 0.0)])
    picture = draw_map(hall, moves=[((0.0, 400.0), (0.0, 0.0))])
    assert remarked(cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR)) > 10
