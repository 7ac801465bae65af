"""Each limit of motion, coasting and sigma between markers, at it and just beyond."""

from array import array

from larics.locate.carrier import Fix
from larics.locate.coasting import Coasting
from larics.locate.localizer import Localizer
from larics.locate.marker_map import MarkerMap
from larics.locate.motion import Motion, grown
from larics.locate.noise import Residuals
from larics.locate.uncertainty import OdometryNoise
from larics.marker.detection import NO_SIGMA
from larics.wire.messages import (
    CARRIED,
    COASTING,
    COUNT_MAX,
    LOST,
    MOTION_NONE,
    TRACKING,
    WAY_UNKNOWN,
)
from test_locate_limits import FRAME_US, ROWS, at_place, driven, measured, standing


def test_silence_and_the_longest_coasting():
    for passed_us, expected in (
        (1000000, TRACKING),  # a second without a frame
        (1000001, COASTING),
        (1500000, COASTING),
        (1500001, LOST),
    ):
        found, time_us = standing(5)
        assert found.pass_time(time_us + passed_us) == expected, passed_us
    for passed_us, expected in ((1500000, COASTING), (1500001, LOST)):
        found, time_us = standing(5)
        assert found.update([], 0, time_us + passed_us) == expected, passed_us


def test_sigma_begins_and_ends_with_what_is_typical():
    found, _ = standing(2)
    assert (found.sigma_mm10, found.sigma_cdeg) == (20, 15)
    found, time_us = standing(300)
    assert (found.sigma_mm10, found.sigma_cdeg) == (3, 2)
    found.update([], 0, time_us + 1000000)
    assert abs(found.sigma_mm10 - 3 - 24) <= 2, found.sigma_mm10  # half of 5 mm/s2 in a second
    assert abs(found.sigma_cdeg - 2 - 150) <= 2, found.sigma_cdeg  # half of 3 degrees/s2


def test_sigma_grows_with_the_speed_and_the_turn():
    for forward, turn, place_mm10, turned_cdeg in (
        (10000, 0, 20 + 312, 150 + 1250),  # 1 m/s: half of 62.5 mm/s2, and of 25 degrees/s2
        (100000, 0, 20 + 7812, 150 + 6250),  # 5 m/s at most
        (10000, 9000, 20 + 312 + 3900, 150 + 1250 + 4500),  # and half of what it takes to turn like this
    ):
        coasting = Coasting(0)
        coasting.known = 2
        coasting._motion.forward, coasting._motion.turn = forward, turn
        assert abs(coasting.grown_mm10(10000) - place_mm10) <= place_mm10 >> 6, coasting.grown_mm10(10000)
        assert abs(coasting.grown_cdeg(10000) - turned_cdeg) <= turned_cdeg >> 6


def seen_at(found, places, is_recent=True, is_told=False):
    """A Coasting that marker after marker puts there, 0.1 s apart."""
    for x_mm10, y_mm10 in places:
        fix = Fix()
        fix.x_mm10, fix.y_mm10 = x_mm10, y_mm10
        found.measured(fix, 100000, is_recent, is_told)
    return found


def test_what_coasting_knows():
    straight = [(1000 * k, 0) for k in range(4)]
    for settings, known, x_mm10 in (
        ({}, 2, 4000),
        ({"is_recent": False}, 1, 3000),  # too long ago for a speed
        ({"is_told": True}, 2, 4000),
    ):
        found, pose = seen_at(Coasting(2000), straight, **settings), array("i", [0] * 3)
        found.predict(pose, 1000)
        assert (found.known, abs(pose[0] - x_mm10) < 5) == (known, True), (settings, pose)
    assert seen_at(Coasting(2000), straight[:1]).known == 1
    shaken = [(0, 0), (90, 0), (0, 0), (90, 0), (0, 0), (90, 0)]
    along = seen_at(Coasting(2000), shaken).scatter_mm10
    across = seen_at(Coasting(2000), [(y, x) for x, y in shaken]).scatter_mm10
    assert along == across > 30  # the worse one of both axes
    assert seen_at(Coasting(2000), shaken, is_told=True).scatter_mm10 == Coasting(2000).scatter_mm10
    found = Coasting(2000)
    found.begin(None)
    assert found.known == 0
    found.begin((5000, 0, 0))
    seen_at(found, [(6000, 0)])
    assert found.known == 2


def test_a_speed_that_is_not_known_makes_sigma_grow_for_a_second():
    found = Coasting(2000)
    for known, time_h, place_mm10 in (
        (2, 5000, 6),  # half of 4.8 mm/s2 ...
        (1, 5000, 6 + 10000),  # ... and 2 m/s
        (1, 10000, 24 + 20000),
        (1, 20000, 96 + 20000),
    ):
        found.known = known
        assert abs(found.grown_mm10(time_h) - place_mm10) <= 2, (known, time_h)
    found = Coasting(7000)
    found.known = 1
    assert found.grown_mm10(10000) == 60000


class Carrier:
    """What odometry has carried on, with these sigmas; and an odometry that has moved."""

    state = MOTION_NONE + 1
    doubted = False
    shares = None
    x_mm10, y_mm10, heading_cdeg = 31, 37, 41

    def __init__(self, x_mm10, y_mm10, cdeg):
        self.sigma_x_mm10, self.sigma_y_mm10, self.sigma_cdeg = x_mm10, y_mm10, cdeg

    def move(self, odometry, time_us):
        self.shares = self
        return True


def test_odometry_carries_the_pose_on_up_to_a_sigma():
    for sigmas, expected in (
        ((10000, 10000, 3500), True),
        ((10001, 0, 0), False),
        ((0, 10001, 0), False),
        ((0, 0, 3501), False),
    ):
        found, _ = standing(5)
        found.carrier = Carrier(*sigmas)
        assert found._is_carried(found.carrier, 0) == expected, sigmas
        assert found.state == (TRACKING if expected else LOST)


def test_what_markers_say_of_their_own_scatter_is_bounded():
    for told, scatter in (
        ((5, 14), (5, 1)),
        ((5, 15), (5, 2)),  # hundredths of a degree: what is rounded off would be most of it
        ((19999, 179990), (19999, 17999)),
        ((20001, 180010), (20000, 18000)),
        ((60000, 600000), (20000, 18000)),
    ):
        found, time_us = standing(2)
        measurement = measured(3, 0)
        measurement.sigma_mm10, measurement.sigma_mdeg = told
        found.update([measurement], 1, time_us + FRAME_US)
        assert (found._last.scatter_mm10, found._last.scatter_cdeg) == scatter, told


def test_an_age_of_half_the_clock_stays_unknown():
    half_us = COUNT_MAX >> 1
    for passed_us, age_us in ((half_us, half_us), (half_us + 1, COUNT_MAX)):
        found, time_us = standing(5)
        found.update([], 0, time_us + passed_us)
        assert found.age_us == age_us
        found, time_us = standing(5)
        found.pass_time(time_us + passed_us)
        assert found.age_us == (age_us if age_us == COUNT_MAX else 0)
    found.update([], 0, (time_us + COUNT_MAX + 20000) & COUNT_MAX)  # the clock has gone round
    assert found.age_us == COUNT_MAX


def test_the_time_between_frames_loses_no_more_than_it_must():
    found = driven((0, at_place(0)), (20000, at_place(0)), (1500000, []))
    assert found.state == COASTING
    assert found.pass_time(1520000) == COASTING and found.pass_time(1520001) == LOST  # frames came or not
    found.update(at_place(0), 1, 1600000)
    assert found.pass_time(1610000) == LOST
    assert found.update(at_place(0), 1, 1620000) == TRACKING  # the frame before was not forgotten
    found, time_us = standing(5)
    found.state, found._fix_us = CARRIED, time_us - 5000000
    assert found.pass_time(time_us + 1000000) == CARRIED
    assert found.pass_time(time_us + 1000001) == LOST


def test_when_odometry_does_not_carry_the_pose_on():
    for name, value in (("state", MOTION_NONE), ("doubted", True)):
        found, _ = standing(5)
        found.carrier = Carrier(0, 0, 0)
        setattr(found.carrier, name, value)
        odometry = found.carrier
        found.carrier.shares = found.carrier
        assert not found._is_carried(odometry, 0) and found.state == TRACKING, name
    found = driven((0, at_place(0)))
    found.carrier = Carrier(10001, 0, 0)
    assert found.state == LOST and not found._is_carried(found.carrier, 0)
    assert found.matching._agreed == 1  # what was seen of a new place is not forgotten
    for sigmas in ((3, 5), (5, 3)):
        found.carrier = Carrier(*sigmas, 7)
        found.carrier.correlation_q14, found.carrier.way_mm = 11, 13
        found._tell_carried()
        assert (found.sigma_mm10, found.sigma_cdeg, found.correlation_q14, found.way_mm) == (5, 7, 11, 13)
        assert (found.x_mm10, found.y_mm10, found.heading_cdeg) == (31, 37, 41)
        found._expect_carried()
        assert list(found._guess) == [31, 37, 41]
        assert found._gate.place_mm10 == 150 + 6 * 5 + 6 and found._gate.turn_cdeg == 200 + 6 * 7 + 3


def test_a_fix_ends_the_way_by_odometry():
    found, time_us = standing(5)
    assert found.way_mm == WAY_UNKNOWN
    found._is_carried, found._expect_carried = lambda odometry, time_us: True, lambda: None
    found.update([measured(3, 0)], 1, time_us + FRAME_US)
    assert found.state == TRACKING and found.way_mm == 0


def test_the_least_sure_of_several_markers_counts():
    found = Localizer(MarkerMap(ROWS))
    view = at_place(0, 0)
    for index, marker in enumerate(view):
        marker.sigma_mm10, marker.sigma_mdeg = 30 - 20 * index, 100 + 200 * index
    found.map.sigma_cdeg[0], found.map.sigma_cdeg[1] = 100, 10
    told = []
    for markers in (view, view[::-1]):
        found._lose()
        assert found.update(markers, 2, 0) == TRACKING
        last = found._last
        told.append((last.scatter_mm10, last.scatter_cdeg, last.certain_mm10, last.certain_cdeg))
    assert told[0] == told[1] and told[0][:2] == (30, 30)
    marker = measured(3, 0)
    for sigmas, is_told in (
        ((5, 5), True),
        ((NO_SIGMA, 5), False),
        ((5, NO_SIGMA), False),
        ((NO_SIGMA, NO_SIGMA), False),
    ):
        marker.sigma_mm10, marker.sigma_mdeg = sigmas
        assert found._is_told(marker) == is_told
    noise = OdometryNoise()
    assert Localizer(MarkerMap(ROWS), odometry_noise=noise).carrier._model is noise


def test_residuals_are_averaged_over_sixteen_frames():
    noise = Residuals(20)
    for _ in range(100):
        noise.add(0, 0, 0, 200, 200)
    assert noise.weight == 16
    noise.square = 16000
    noise.add(0, 0, 0, 200, 200)
    assert noise.square == 15000
    noise.add(0, 0, 0, 100, 401)  # the last two frames are four times as far apart as those before
    assert noise.square == 15000
    noise.add(0, 0, 0, 100, 400)
    assert noise.square == 15000 - 15000 // 16


def learned(dx=0, turned=0, time_h=1000, first=True):
    motion = Motion()
    motion.learn(dx, 0, -turned // 2, turned, time_h, first)
    return motion


def test_speeds_and_turn_rates_are_bounded_and_smoothed():
    assert abs(learned(9000).forward - 90000) <= 10
    assert learned(11000).forward == learned(50000).forward == 100000  # 10 m/s
    assert learned(-50000).forward == -100000
    assert learned(turned=6000).turn == 60000
    assert learned(turned=9000).turn == 72000
    assert learned(turned=-9000).turn == -72000
    assert learned(1000, first=False).forward == learned(1000).forward // 2  # a time constant of 0.1 s


def test_a_motion_is_carried_on_for_so_long():
    motion = Motion()
    motion.forward = 10000
    for time_h, expected in ((20000, 20000), (30000, 30000), (50000, 30000)):
        pose = array("i", [0] * 3)
        motion.carry(pose, time_h)
        assert abs(pose[0] - expected) <= 4, (time_h, pose)
    motion.turn = 9000
    for time_h, expected in ((2500, 2250), (5000, 4500), (10000, 4500)):
        pose = array("i", [0] * 3)
        motion.carry(pose, time_h)
        assert pose[2] == expected, (time_h, pose)


def test_growth_is_half_the_acceleration_times_the_time_squared():
    for acceleration, time_h in ((3000, 10000), (72000, 1000), (50000, 3000), (200000, 500)):
        expected = acceleration * time_h * time_h // 200000000
        assert abs(grown(acceleration, time_h, 1 << 20) - expected) <= 2 + expected // 100
    assert grown(50000, 10000, 600) == 600 and grown(1, 30001, 77) == 77
