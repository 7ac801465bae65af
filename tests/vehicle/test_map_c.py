"""Which markers of a map a route means, in C as in Python."""

import random

import pytest

from c_parts import Parts
from larics.locate.marker_map import MarkerMap
from larics.locate.route import resolve_entries


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    return Parts(tmp_path_factory.mktemp("map"))


def draw_map(draw):
    """Rows of markers on a grid, so that many ways are equally long; IDs repeat."""
    places = [(x * 2000, y * 2000) for x in range(-4, 4) for y in range(-3, 4)]
    draw.shuffle(places)
    if draw.random() < 0.3:
        places = [(draw.randint(-1_000_000, 1_000_000), draw.randint(-1_000_000, 1_000_000)) for _ in places]
    ids = draw.choice(((1, 2, 3), (1, 2, 3, 4, 5, 6), range(1, 40)))
    return [(draw.choice(ids), *place) for place in places[: draw.randint(2, 40)]]


def test_the_same_entries_as_in_python(parts):
    draw = random.Random(5004)
    repeated = closed = refused = 0
    for _ in range(600):
        rows = draw_map(draw)
        try:
            marker_map = MarkerMap([(*row, 0) for row in rows])
        except ValueError:
            continue  # two of an ID too close to each other
        known = sorted({row[0] for row in rows})
        ids = [draw.choice(known) for _ in range(draw.choice((1, 2, 3, 5, 12, 30)))]
        if draw.random() < 0.9:
            ids = [a for a, b in zip(ids, [*ids[1:], None], strict=True) if a != b]
        if draw.random() < 0.4 and len(ids) > 2 and ids[-2] != ids[0]:
            ids[-1] = ids[0]
        if draw.random() < 0.05:
            ids[draw.randrange(len(ids))] = 77  # in no map
        try:
            expected = resolve_entries(ids, marker_map)
        except ValueError:
            expected = None
            refused += 1
        assert parts.resolve(rows, ids) == expected, (rows, ids)
        if expected:
            repeated += len(set(map(lambda row: row[0], rows))) < len(rows)
            closed += len(ids) > 2 and ids[0] == ids[-1]
    assert repeated > 150 and closed > 50 and refused > 20


def test_a_long_route_through_a_building_where_every_marker_repeats(parts):
    rows = [(1 + k % 8, 2500 * (k % 8), 30_000 * (k // 8)) for k in range(64)]
    there = [1 + k % 8 for k in range(8)] + [7, 6, 5, 4, 3, 2]
    ids = there * 70 + [1]
    marker_map = MarkerMap([(*row, 0) for row in rows])
    assert parts.resolve(rows, ids) == resolve_entries(ids, marker_map)
    assert parts.resolve(rows, [1, 2] * 501) is None  # more than a route may have
