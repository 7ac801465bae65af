"""larics.locate.route and larics.locate.marker_map on both interpreters."""

from larics.locate import route as r
from larics.locate.marker_map import MarkerMap, map_reason
from larics.locate.route import Route, resolve_entries, route_reason

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

THERE_AND_BACK = (1, 2, 3, 4, 5, 6, 7, 6, 5, 4, 3, 2, 1)


def drive(route, ids):
    return [route.see(marker_id) for marker_id in ids]


def test_the_published_route_is_followed_round_after_round():
    route = Route(THERE_AND_BACK, start=0)
    for lap in range(3):
        for k in range(12):
            assert route.see(THERE_AND_BACK[k]) == r.ON_ROUTE, (lap, k)
            assert route.see(THERE_AND_BACK[k]) == r.SAME
            assert route.position == k and route.next_position() == (k + 1) % 12


def test_direction_is_known_from_two_markers():
    route = Route(THERE_AND_BACK)
    assert route.see(4) == r.AMBIGUOUS and route.position == -1 and route.next_position() == -1
    assert route.see(3) == r.ON_ROUTE and route.position == 10
    assert route.see(2) == r.ON_ROUTE and route.position == 11


def test_a_missing_marker_is_told_and_passed_over():
    route = Route(THERE_AND_BACK, start=0)
    assert drive(route, (1, 2, 4)) == [r.ON_ROUTE, r.ON_ROUTE, r.MISSED]
    assert route.missed == 1 and route.position == 3
    assert drive(route, (5, 7, 4)) == [r.ON_ROUTE, r.MISSED, r.MISSED]
    assert route.missed == 2 and route.position == 9


def test_one_wrong_marker_does_not_move_the_vehicle():
    route = Route(THERE_AND_BACK, start=0)
    assert drive(route, (1, 2, 3, 7)) == [r.ON_ROUTE, r.ON_ROUTE, r.ON_ROUTE, r.UNEXPECTED]
    assert route.position == 2
    assert route.see(4) == r.ON_ROUTE and route.position == 3


def test_a_misread_marker_is_recovered_from():
    route = Route(THERE_AND_BACK, start=0)
    drive(route, (1, 2, 3, 7))  # the 7 was a 4
    assert route.see(5) == r.MISSED and route.position == 4


def test_a_vehicle_put_elsewhere_is_found_again():
    route = Route((1, 2, 3, 4, 5, 6, 7), start=0)
    assert drive(route, (1, 2)) == [r.ON_ROUTE, r.ON_ROUTE]
    meanings = drive(route, (6, 7))
    assert meanings[0] in (r.UNEXPECTED, r.MOVED) and route.position == 6
    assert route.next_position() == -1


def test_ids_that_repeat_in_the_route():
    route = Route((1, 2, 3, 1, 2, 4))
    assert drive(route, (1, 2)) == [r.AMBIGUOUS, r.AMBIGUOUS]
    assert route.see(4) == r.ON_ROUTE and route.position == 5


def test_a_marker_read_again_after_it_was_out_of_view():
    route = Route(THERE_AND_BACK, start=0)
    drive(route, (1, 2))
    route.lose_sight()
    assert route.see(2) == r.ON_ROUTE and route.position == 1


def test_seeing_allocates_nothing():
    route = Route(THERE_AND_BACK, start=0)
    route.see(1)
    heap_lock()
    try:
        for k in range(40):
            route.see(k % 7 + 1)
            route.lose_sight()
    finally:
        heap_unlock()


def test_routes_that_cannot_be():
    rows = ((3, 0, 0, 0), (4, 2000, 0, 0))
    assert route_reason((3, 4, 3), rows) is None
    assert route_reason(()) is None
    assert route_reason((3, 4, 5), rows) == "route step 3: marker 5 is not in the map"
    assert route_reason((3, 4, 4)) == "route step 3: impossible step from marker 4 to itself"
    assert route_reason((3,)) == "route has one marker only: at least two are needed"
    for ids, start in (((), -1), ((3, 3), -1), ((3, 4), 2)):
        try:
            Route(ids, None, start)
        except ValueError:
            continue
        assert False, ids


def test_maps_that_cannot_be():
    good = [(3, 0, 0, 0), (4, 2000, 0, 9000, 28000, 1000), (3, 2000, 2000, 0)]
    assert map_reason(good, (3, 4, 7)) is None
    for change, words in (
        ((5, 9000, 0, 0), "marker 5, which is none of the allowed IDs"),
        ((3, 1500, 0, 0), "marker 3 twice within 2000 mm"),
        ((4, 9000, 0, 0), "marker 4 twice, with different"),
        ((7, 300, 0, 0), "markers 3 and 7 at impossible places"),
        ((7, 9000, 0, 0, 200), "marker 7 at the impossible height 200"),
    ):
        reason = map_reason(good + [change], (3, 4, 7), 1500, 250)
        assert reason and words in reason, reason
        assert "\n" not in reason
    try:
        MarkerMap([(3, 0, 0, 0), (3, 0, 1, 0)])
        assert False
    except ValueError:
        pass


def test_entries_of_a_route_take_the_shortest_way():
    rows = [(1, 0, 0, 0), (2, 3000, 0, 0), (1, 9000, 0, 0), (3, 12000, 0, 0)]
    marker_map = MarkerMap(rows)
    assert resolve_entries((2, 3, 1), marker_map) == [1, 3, 2]
    assert resolve_entries((3, 1), marker_map) == [3, 2]
    assert resolve_entries((2, 1, 2), marker_map) == [1, 0, 1]
    route = Route((2, 1, 2), marker_map)
    assert route.entry(1) == 0 and route.entry(-1) == -1
    assert marker_map.repeats(1) and not marker_map.repeats(3)


def test_a_marker_that_is_not_there_is_passed_by():
    route = Route((3, 4, 7, 3))
    assert route.pass_by() == r.SAME  # nobody knows where the vehicle is
    route.see(3)
    assert route.pass_by() == r.MISSED and (route.position, route.missed) == (1, 1)
    assert route.see(7) == r.ON_ROUTE and route.next_position() == 0
    assert route.see(3) == r.ON_ROUTE and route.see(4) == r.ON_ROUTE
    end = Route((3, 4, 7), start=2)
    assert end.pass_by() == r.SAME and end.position == 2
