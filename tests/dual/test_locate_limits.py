"""Each limit of which markers and places are believed, and of the route, at it and just beyond."""

from larics.locate.camera_model import Measurement
from larics.locate.localizer import Localizer
from larics.locate.marker_map import MarkerMap
from larics.locate.matching import Gate, Matching
from larics.locate.navigator import Navigator
from larics.locate.route import MISSED, SAME, Route, resolve_entries
from larics.locate.uncertainty import Systematic
from larics.marker.detection import NO_SIGMA
from larics.wire.messages import (
    CARRIED,
    COASTING,
    DIRECTION_NONE,
    FAULT_MARKER_HEIGHT,
    FAULT_MARKER_PLACE,
    FAULT_MARKER_UNKNOWN,
    FAULT_ROUTE,
    LOST,
    ROUTE_NONE,
    TRACKING,
)

ROWS = ((3, 0, 0, 0), (4, 4000, 0, 9000))
FRAME_US = 20000
EXACT = Systematic(0, 0, 0, 0, 0, 0, 0)  # camera and map


def measured(marker_id, x_mm10, y_mm10=0, heading_cdeg=0):
    out = Measurement()
    out.marker_id = marker_id
    out.offset_x_mm10, out.offset_y_mm10, out.heading_cdeg = x_mm10, y_mm10, heading_cdeg
    out.height_mm10 = out.ring_height_mm10 = 30000
    return out


def standing(frames):
    """A vehicle that has stood below marker 3 for that many frames, and the time."""
    found = Localizer(MarkerMap(ROWS), coast_us=1500000, systematic=EXACT)
    for k in range(frames):
        found.update([measured(3, 0)], 1, k * FRAME_US)
    assert found.state == TRACKING
    return found, (frames - 1) * FRAME_US


def is_near(
    x=0, y=0, heading=0, time_h=0, speed=0, sure=False, sigma=(0, 0), way=None, told=(NO_SIGMA, NO_SIGMA)
):
    """Whether the gate lets a place through that is so far off what was expected."""
    found, gate, measurement = Matching(MarkerMap(ROWS), 0, 20), Gate(), measured(3, 0)
    measurement.sigma_mm10, measurement.sigma_mdeg = told
    if way is None:
        gate.open_for_time(*sigma, time_h, speed)
    else:
        gate.open_for_way(*sigma, way)
    found.seen[0], found.seen[1], found.seen[2] = 7000 + x, -500 + y, (100 + heading) % 36000
    return found._is_near(0, (7000, -500, 100), gate, measurement, sure)


def test_the_gate_of_the_pose():
    for settings, place_mm10, turn_cdeg in (
        ({}, 500, 500),
        ({"time_h": 1000}, 500 + 249, 500 + 360),  # half of 5 m/s2 and of 720 degrees/s2, by 0.1 s squared
        ({"speed": 2000, "time_h": 100}, 500 + 200 + 2, 500 + 3),
        ({"sigma": (20, 30)}, 500 + 120, 500 + 180),  # six sigma,
        ({"sigma": (5000, 5000)}, 500 + 6000, 500 + 3000),  # of a bounded one
        ({"sigma": (5000, 5000), "sure": True}, 3000, 3000),
        ({"sure": True}, 500, 500),
        ({"told": (20, 300)}, 500 + 120, 500 + 180),  # and six of the measurement's
        ({"told": (5000, 50000)}, 500 + 6000, 500 + 3000),
        ({"way": 0}, 150, 200),
        ({"way": 1000, "sigma": (20, 30)}, 150 + 500 + 120, 200 + 300 + 180),  # with odometry by the way
        ({"way": 9000, "sigma": (9999, 600)}, 150 + 2000 + 30000, 200 + 1200 + 3000),
        ({"way": 9000, "sigma": (900, 0), "sure": True}, 3000, 1400),
        ({"way": 9000, "sigma": (1100, 0), "sure": True}, 3300, 1400),
    ):
        for sign in (1, -1):
            for distance, expected in ((0, True), (1, False)):
                assert is_near(x=sign * (place_mm10 + distance), **settings) == expected, settings
                assert is_near(y=sign * (place_mm10 + distance), **settings) == expected, settings
                assert is_near(heading=sign * (turn_cdeg + distance), **settings) == expected, settings


def test_the_speed_that_is_possible_tells_less_after_a_second():
    for time_h, place_mm10 in ((10000, 500 + 25000 + 20000), (20000, 500 + 100000 + 20000)):
        gate = Gate()
        gate.open_for_time(0, 0, time_h, 2000)
        assert abs(gate.place_mm10 - place_mm10) <= 2, time_h


def at_place(*x_mm10):
    """A frame of markers 3 and 4 of ROWS, as seen by a vehicle at these places."""
    out = [measured(3, -x_mm10[0])]
    if len(x_mm10) > 1:
        out.append(measured(4, 40000 - x_mm10[1], 0, 9000))
    return out


def lost_at(*frames):
    """Matching without prediction, and how many markers were used, of (time_us, measurements)."""
    found = Matching(MarkerMap(ROWS), 2000, 20)
    used = []
    for time_us, markers in frames:
        found.begin(time_us, 1000000)
        used.append(found.relocate(markers, len(markers), time_us, True))
    return found, used


def test_what_agrees_on_a_new_place():
    here = at_place(0)
    for frames, expected in (
        ([(0, here), (1000000, here)], [0, 1]),
        ([(0, here), (1000001, here)], [0, 0]),  # forgotten
        ([(0, here), (900000, []), (1000001, here)], [0, 0, 0]),  # nothing seen reminds of nothing
        ([(0, here), (100000, at_place(600))], [0, 1]),  # it may have moved meanwhile,
        ([(0, here), (100000, at_place(6000))], [0, 0]),  # but not like this
        ([(0, at_place(0, 500))], [2]),  # two markers agree
        ([(0, at_place(0, 501))], [0]),
        ([(0, here), (100000, at_place(600, 1101))], [0, 1]),  # in a frame nothing moves
    ):
        found, used = lost_at(*frames)
        assert used == expected, (frames[-1][0], used)
    assert not lost_at((0, here))[0].has_before and lost_at((0, here), (20000, here))[0].has_before
    found, _ = lost_at((0, here))
    found.forget()
    assert found.relocate(here, 1, 20000, True) == 0 and not found.has_before


def test_a_marker_is_refused_once_and_for_one_reason():
    found = Matching(MarkerMap(ROWS), 2000, 20)
    unknown, low, far = measured(99, 0), measured(4, 0), measured(3, 9000)
    low.ring_height_mm10 = 40000
    gate = Gate()
    gate.open_for_time(0, 0, 0, 0)
    for markers, faults in (
        ([measured(-1, 0)], 0),  # of which no ID was read
        ([low], FAULT_MARKER_HEIGHT),
        ([unknown], FAULT_MARKER_UNKNOWN),
        ([unknown, low, far], FAULT_MARKER_PLACE),
    ):
        found.begin(0, 1000000)
        assert found.match(markers, len(markers), (0, 0, 0), gate) == 0
        assert found.relocate(markers, len(markers), 0, False) == 0  # says nothing once more
        assert found.fault == faults and found._refusals == (len(markers) if faults else 0)
        assert all([found.refused(one.marker_id) == bool(faults) for one in markers])
    found.begin(0, 1000000)
    for marker_id, count in ((100, 1), (100, 1), (101, 2)):
        found._refuse(FAULT_MARKER_UNKNOWN, marker_id)
        assert found._refusals == count
    for marker_id in range(102, 130):  # more than a frame can have
        found._refuse(FAULT_MARKER_UNKNOWN, marker_id)


def test_the_route_does_not_make_a_marker_usable():
    found = Matching(MarkerMap(ROWS), 2000, 20)
    found.hint = 0
    marker = measured(3, 0)
    marker.ring_height_mm10 = 40000
    assert found.relocate([marker, marker], 2, 0, True) == 0 and not found._agreed


def test_which_of_the_places_of_an_id_is_meant():
    twice = MarkerMap(((4, 8000, 0, 0), (3, 0, 0, 0), (3, 4000, 0, 0)))
    beside = measured(4, 40000)
    for hint, markers, expected in (
        (-1, [measured(3, 0)], None),  # either
        (1, [measured(3, 0)], 0),  # the route tells
        (0, [measured(3, 0)], None),  # of another marker
        (-1, [beside, measured(3, 0)], 40000),  # the marker beside it tells
    ):
        found = Matching(twice, 2000, 20)
        found.hint = hint
        found.relocate(markers, len(markers), 0, True)
        assert found._agreed == (0 if expected is None else len(markers)), hint
        assert expected is None or found._there[0] == expected


def test_one_of_the_places_of_an_id_may_be_possible():
    found = Matching(MarkerMap(((3, 0, 0, 0), (3, 4000, 0, 0))), 2000, 20)
    gate = Gate()
    gate.open_for_time(5000, 0, 0, 0)
    assert found.match([measured(3, -4000)], 1, (0, 0, 0), gate) == 0
    assert found._doubtful and not found.fault


def test_a_far_place_is_believed_with_a_second_frame():
    for off_mm10, frames in ((3000, 1), (3001, 2)):
        found, time_us = standing(60)
        states = []
        for k in range(frames):
            found._last.sigma_mm10 = 5000  # so that the gate itself is wider
            found.update([measured(3, -off_mm10)], 1, time_us + (k + 1) * FRAME_US)
            states.append((found.state, abs(found.x_mm10 - off_mm10) < 2))
        assert states[-1] == (TRACKING, True), (off_mm10, states)
        assert frames == 1 or not states[0][1], states


def carried_to(x_mm10, sigma_mm10):
    """A route's vehicle that odometry has carried on to that place, on its way to marker 4 at 40000."""
    navigator = Navigator(ROWS, (3, 4), start=0)
    navigator.route.see(3)
    navigator.pose.state = CARRIED
    navigator.pose.x_mm10, navigator.pose.sigma_mm10 = x_mm10, sigma_mm10
    return navigator


def test_how_near_a_marker_is_seen_if_it_is_there():
    for sigma_mm10, near_mm10 in ((0, 2500), (1250, 2500), (2000, 4000), (5000, 10000), (9000, 10000)):
        for x_mm10, expected in ((40000 - near_mm10 + 1, True), (40000 - near_mm10, False)):
            assert carried_to(x_mm10, sigma_mm10)._is_at_next() == expected, (sigma_mm10, x_mm10)
    navigator = carried_to(40000, 0)
    for state, expected in ((CARRIED, True), (TRACKING, False), (COASTING, False), (LOST, False)):
        navigator.pose.state = state
        assert navigator._is_at_next() == expected, state


def test_a_marker_is_passed_after_two_frames_at_its_place_without_it():
    navigator = carried_to(40000, 0)
    told = []
    for x_mm10 in (40000, 20000, 40000, 40000):  # frames in a row
        navigator.pose.x_mm10 = x_mm10
        navigator._follow([], 0)
        told.append((navigator.event, navigator.fault))
    assert told[:3] == [(SAME, 0)] * 3 and told[3] == (MISSED, FAULT_ROUTE), told


def test_a_passed_marker_hides_no_other_fault():
    navigator = carried_to(40000, 0)
    navigator.fault = FAULT_MARKER_PLACE
    for _ in range(2):
        navigator._follow([], 0)
    assert (navigator.event, navigator.fault) == (MISSED, FAULT_MARKER_PLACE)
    ended = Navigator(ROWS, (4, 3), start=1)
    ended.route.see(3)
    ended.pose.state, ended.pose.x_mm10 = CARRIED, 40000
    assert not ended._is_at_next()  # where a route ends, nothing is missed


def test_what_a_lost_vehicle_forgets_of_its_route():
    for ids in ((3, 4), ()):  # with a route, and without one
        navigator, forgotten = Navigator(ROWS, ids), []
        if ids:
            navigator.route.lose_sight = lambda forgotten=forgotten: forgotten.append(1)
        for k in range(5):
            navigator.update([measured(3, 0)], 1, k * FRAME_US)
        known = navigator.next_cdeg
        assert (known != DIRECTION_NONE) == bool(ids)
        for passed_us, state, times in ((1000001, COASTING, 0), (9000000, LOST, 1), (9000001, LOST, 1)):
            assert navigator.pass_time(4 * FRAME_US + passed_us) == state
            assert len(forgotten) == (times if ids else 0), (ids, passed_us)
            assert navigator.next_cdeg == (DIRECTION_NONE if times else known)
    navigator, forgotten = Navigator(ROWS, (3, 4)), []
    navigator.route.lose_sight = lambda: forgotten.append(1)
    assert navigator.pose.state == LOST
    navigator._follow([measured(-1, 0)], 1)  # something is seen
    assert not forgotten
    navigator._follow([], 0)
    assert forgotten


def test_what_is_not_known_of_map_and_route():
    navigator = Navigator(((3, 0, 0, 0, 150, 2500), (4, 4000, 0, 0, 200, 3000)), (3, 4))
    navigator.update([], 0, 0)
    assert navigator.route_position == ROUTE_NONE
    assert navigator.outer_mm10(4) != navigator.outer_mm10(9) == 1500 and navigator.z_mm10(
        9
    ) == 0 < navigator.z_mm10(4)


def driven(*frames, **settings):
    """A localizer after frames of (time_us, measurements)."""
    found = Localizer(MarkerMap(ROWS), coast_us=1500000, systematic=EXACT, **settings)
    for time_us, markers in frames:
        found.update(markers, len(markers), time_us)
    return found


def test_a_place_found_again_has_the_speed_of_the_frame_before():
    found = driven((0, at_place(0)), (20000, at_place(200)), (120000, []))
    assert found.state == COASTING and abs(found.x_mm10 - 1200) <= 10, found.x_mm10
    found = driven((0, at_place(1000, 1000)), (100000, []))  # of one frame nobody knows
    assert found.state == COASTING and found.x_mm10 == 1000
    for lost, moved in ((True, False), (False, True)):  # a lost vehicle was not moved
        found = driven((0, at_place(0)), (20000, at_place(0)))
        if lost:
            found._lose()
        for k in range(3):
            found.update(at_place(20000), 1, 40000 + 20000 * k)
        assert (found.state, found.x_mm10) == (TRACKING, 20000)
        assert found._last.moved == moved or lost  # the third frame after being lost is a usual one
    found = driven((0, at_place(0)), (20000, at_place(0)))
    assert not found._last.moved


def test_a_lost_pose_stays_where_it_was_seen():
    found = driven((0, at_place(0)), (20000, at_place(0)), (40000, at_place(100)), (2000000, []))
    assert found.state == LOST and found.x_mm10 == 100


def test_more_markers_than_are_used_do_no_harm():
    assert driven((0, 9 * at_place(0)), (20000, 9 * at_place(0))).state == TRACKING


def test_the_gate_allows_for_a_speed_that_is_not_known():
    places = []
    for known in (1, 2):
        found, _ = standing(5)
        found._coasting.known = known
        found._coast(1000)
        places.append(found._gate.place_mm10)
    assert places[0] - places[1] == 2000  # 2 m/s for 0.1 s


def test_the_shortest_way_decides_where_an_id_repeats():
    places = MarkerMap(((1, 0, 0, 0), (2, 0, 9000, 0), (2, 4000, 6000, 0), (3, 5000, 0, 0), (1, 9000, 0, 0)))
    for ids, entries in (
        ((1, 2), [0, 2]),
        ((2, 1), [2, 0]),
        ((3, 1), [3, 4]),
        ((3, 1, 2), [3, 4, 2]),
        ((1, 2, 3), [0, 2, 3]),
        ((1, 2, 3, 1), [4, 2, 3, 4]),  # a round ends where it began
    ):
        assert resolve_entries(ids, places) == entries, ids
    for ids in ((), (1,), (1, 1), (1, 7)):
        try:
            Route(ids, places)
            raise AssertionError(ids)
        except ValueError as error:
            assert "route" in str(error)


def test_another_marker_is_reached_when_it_is_twice_as_near():
    for x_mm10, expected in ((500, 4), (501, 3)):
        navigator = Navigator(ROWS, (3, 4))
        navigator._last_id = 3
        view = [measured(3, 600, 400), measured(4, -x_mm10, 0)]
        assert navigator._reached(view, 2) == expected, x_mm10
    navigator = Navigator(ROWS, (3, 4))
    assert navigator._reached([measured(3, 1000), measured(4, 900)], 2) == 4  # at none before


def test_what_each_story_of_a_route_costs():
    for marker_id, expected in (
        (2, [5, 0, 8, 10, 12, 12, 12]),  # the next one: the others have read it wrongly or do not belong
        (3, [3, 4, 0, 8, 10, 10, 10]),  # one was missed: 2
        (4, [1, 2, 4, 0, 8, 8, 8]),  # two: 4
        (5, [0, 1, 3, 5, 2, 7, 7]),  # three are too many: it does not belong (5) or the vehicle was moved (7)
    ):
        route = Route(range(1, 8), None, 0)
        route.see(marker_id)
        assert list(route._cost) == expected, (marker_id, list(route._cost))
