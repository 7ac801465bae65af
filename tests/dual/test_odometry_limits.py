"""Each limit of odometry, its clock, its shares and the carried pose, at it and just beyond."""

from array import array

from larics.arith.fixed import isqrt
from larics.arith.tables import QUARTER_SINE_Q14
from larics.kernels.covariance import grow
from larics.kernels.odometry import advance, settle
from larics.locate.carrier import Carrier, Fix
from larics.locate.odometry import KEPT, Odometry
from larics.locate.odometry_shares import OdometryShares, Share
from larics.locate.uncertainty import OdometryNoise
from larics.locate.vehicle_clock import VehicleClock
from larics.locate.wheel_noise import Loudness, Slope
from larics.wire import messages as m
from wire_values import message_values

LINE_US = 2604


class Bench:
    """An odometry and its clock; messages arrive as soon as they can."""

    def __init__(self):
        self.now_us = 0
        self.odometry = Odometry(lambda: self.now_us, LINE_US)

    def take(self, time_us, age_us=0, **given):
        self.now_us = time_us + age_us + LINE_US
        self.odometry.look()
        values = message_values(m.ODOMETRY, time_us=time_us, age_us=age_us, epoch=3, **given)
        self.odometry.take(array("i", values))
        return self.odometry


def test_what_a_message_tells_is_taken():
    bench = Bench()
    assert bench.take(5000000, y_mm10=7, flags=2).flags == 2 and bench.odometry.epoch == 3
    assert bench.take(5020000, flags=1).flags == 1


def test_a_message_may_have_waited_since_the_line_was_read_before():
    bench = Bench()
    bench.take(5000000)
    for passed_us in (3000, 41000):
        bench.take(bench.now_us - LINE_US + passed_us)
        assert bench.odometry.clock.items[20] == passed_us


def keep(odometry, time_us, x_mm10=0, heading_cdeg=0, known=1):
    """What `take` does behind the clock, which agrees with the vehicle's."""
    time_us &= m.COUNT_MAX
    values = array("i", (time_us, 0, x_mm10, 0, heading_cdeg, 0, 0))
    settle(0, 0, values, odometry._ring, odometry.clock.items, time_us, known)


def kept(*poses):
    """An odometry that was told (time_us, x_mm10, heading_cdeg)."""
    odometry = Bench().odometry
    for pose in poses:
        keep(odometry, *pose)
    return odometry


def count_and_jumps(odometry):
    return odometry._ring[385], odometry._ring[392]


def test_a_message_is_late_or_of_another_clock():
    for back_us, counts in ((1, (1, 0)), (999999, (1, 0)), (1000000, (0, 1))):
        bench = Bench()
        bench.take(5000000)
        found = bench.take(5000000 - back_us)
        assert (found.refused, found.jumps) == counts, back_us


def test_stale_is_what_no_frame_waits_for():
    for age_us, stale in ((1000000 - LINE_US, 0), (1000001 - LINE_US, 1)):
        assert Bench().take(5000000, age_us).stale == stale, age_us


def test_a_gap_and_a_jump():
    for passed_us, x_mm10, turned_cdeg, count, jumps in (
        (1000000, 0, 0, 2, 0),
        (1000001, 0, 0, 1, 0),
        (999, 500, 500, 2, 0),  # below a millisecond
        (999, 502, 0, 1, 1),
        (999, 0, 501, 1, 1),
        (100000, 20500, 0, 2, 0),  # 20 m/s and 50 mm
        (100000, 20502, 0, 1, 1),
        (40000, 0, 14900, 2, 0),  # ten turns a second and 5 degrees
        (40000, 0, 14901, 1, 1),
    ):
        found = kept((0, 0, 0), (passed_us, x_mm10, turned_cdeg))
        assert count_and_jumps(found) == (count, jumps), (passed_us, x_mm10, turned_cdeg)


def test_so_many_poses_are_kept():
    found = kept(*[(20000 * k, 0, 0) for k in range(2 * KEPT)])
    last_us = 20000 * (2 * KEPT - 1)
    assert KEPT == 64
    assert found.at(last_us - 63 * 20000) == m.MOTION_INTERPOLATED
    assert found.at(last_us - 63 * 20000 - 1) == m.MOTION_NONE


def test_motion_is_carried_on_by_ten_milliseconds_of_it():
    for first_us, x_mm10 in ((-10000, 400), (-10001, 300)):
        found = kept((first_us, 0, 0), (first_us + 1, 100, 0), (0, 200, 0))
        assert found.at(10000) == m.MOTION_EXTRAPOLATED and abs(found.x_mm10 - x_mm10) <= 1, first_us
    assert kept((-9999, 0, 0), (0, 200, 0)).at(10000) == m.MOTION_NONE


def test_odometry_is_tame_again_after_sixteen_good_poses():
    found = Bench().odometry
    for k in range(10):  # the last one is good, too
        keep(found, 20000 * k, known=0)
    for k in range(10, 25):
        assert found._ring[394]
        keep(found, 20000 * k)
    assert not found._ring[394]


def heard(*messages):
    """A clock that heard (arrived_us, offset_us), and whether it believes the last one."""
    clock = VehicleClock()
    for arrived_us, offset_us in messages:
        believed = clock.hear(arrived_us, (arrived_us - offset_us) & m.COUNT_MAX, 0)
    return clock, believed


def test_the_least_delay_is_forgotten_slowly():
    for passed_ms, offset_us in ((1000, 400), (8000, 3200), (8001, 3200)):
        clock, _ = heard((0, 0), (1000 * passed_ms, 900000))
        assert clock.camera_us(0) == offset_us, passed_ms


def test_clocks_that_leap_apart():
    for offset_us, believed in ((1000400, True), (1000401, False)):  # 0.4 ms were forgotten in the second
        assert heard((0, 0), (1000000, offset_us))[1] == believed
        assert heard((0, 0), (1000000, 800 - offset_us))[1] == believed


def test_spans_of_messages():
    eighth = [(250000 * k, 0) for k in range(7)]
    for last, spans_ms, left in ((1999000, 2000, 8), (2000000, 4000, 0)):
        clock, _ = heard(*eighth, (last, 0))
        assert (clock.items[9], clock.items[12]) == (spans_ms, left), last
    assert heard(*eighth[1:], (2250000, 0))[0].items[12] == 7
    clock, _ = heard(*[(250000 * k, 0) for k in range(200)])
    assert clock.items[9] == 8000
    for silence_us, left in ((32000000, 2), (32001000, 0)):
        assert heard((0, 0), (silence_us, 0))[0].items[12] == left
    assert heard((0, 0), (20000, 0), (40000, 2000000))[0].items[12] == 1  # another clock: all is forgotten


def learned(between_ms, grown_us, waited_us=0, late_us=0):
    clock, _ = heard((0, 0))
    items, now_us = clock.items, 1000 * between_ms
    items[5], items[6], items[7] = 1, 0, 0
    items[13], items[14], items[15] = now_us, grown_us & m.COUNT_MAX, waited_us
    items[9], items[17] = 8000, late_us
    items[10] = items[18] = items[19] = now_us
    clock.learn()
    return clock


def test_a_drift_is_learned_beyond_doubt_and_within_reason():
    for between_ms, grown_us, waited_us, drift_ppm in (
        (1000, 6000, 0, 0),
        (1000, 6001, 0, 6001),
        (1000, -6001, 0, -6001),
        (1000, 6500, 500, 0),
        (1000, 6501, 500, 6501),
        (1000, 19999, 0, 19999),
        (1000, 20001, 0, 20000),
        (1000, -20001, 0, -20000),
        (40000, 40000, 0, 1000),
        (40000, 900000, 0, 20000),
        (40001, 40000, 0, 0),
    ):
        clock = learned(between_ms, grown_us, waited_us)
        assert clock.drift_ppm() == drift_ppm, (between_ms, grown_us)
        assert clock.items[9] == (2000 if drift_ppm else 8000)  # a new one is soon looked at again


def test_an_estimate_that_no_message_reaches_is_put_right():
    for waited_us, late_us, offset_us in ((0, 3000, 0), (0, 3001, 3001), (700, 3700, 0), (700, 3701, 3701)):
        assert learned(1000, 0, waited_us, late_us).camera_us(0) == offset_us, late_us


class Shares(OdometryShares):
    """Tells how legs were judged."""

    def __init__(self):
        super().__init__(OdometryNoise())
        self.judged = []

    def _judge(self, fits):
        self.judged.append(bool(fits))
        return super()._judge(fits)


class Told:
    def __init__(self, x_mm10=0, heading_cdeg=0):
        self.x_mm10, self.y_mm10, self.heading_cdeg = x_mm10, 0, heading_cdeg


def placed(x_mm10=0, heading_cdeg=0, entry=0):
    fix = Fix()
    fix.x_mm10, fix.heading_cdeg, fix.entry = x_mm10, heading_cdeg, entry
    return fix


def told_so(shares, forward_mm10, way_mm10, turn_cdeg):
    """Odometry told that."""
    shares.sums[0] = shares.sums[1] = forward_mm10
    shares.sums[2], shares.sums[3] = way_mm10, turn_cdeg


def judged(way_mm10, turn_cdeg=0, entry=1, x_mm10=None, heading_cdeg=None, near=False):
    """How the leg from a first marker is judged: odometry told so much, the markers the rest."""
    shares = Shares()
    shares.compare(placed(), Told(), 0, 0)
    told_so(shares, way_mm10, way_mm10, turn_cdeg)
    x_mm10 = way_mm10 if x_mm10 is None else x_mm10
    heading_cdeg = turn_cdeg if heading_cdeg is None else heading_cdeg
    told = Told(way_mm10, turn_cdeg % 36000)
    shares.compare(placed(x_mm10, heading_cdeg % 36000, entry), told, 0, 0, near)
    return shares.judged


def test_which_legs_are_compared():
    for way_mm10, turn_cdeg, entry, count in (
        (2999, 0, 1, 0),
        (3000, 0, 1, 1),
        (5999, 0, 0, 0),
        (6000, 0, 0, 1),
        (0, 5999, 0, 0),
        (0, 6000, 0, 1),
        (0, 159999, 0, 1),
        (0, 160000, 0, 0),
        (159000, 0, 1, 1),
        (160000, 0, 1, 0),
    ):
        assert len(judged(way_mm10, turn_cdeg, entry)) == count, (way_mm10, turn_cdeg, entry)
    for way_mm10, count in ((999, 0), (1000, 1)):
        assert len(judged(way_mm10, entry=0, near=True)) == count, way_mm10


def test_what_wheels_may_make():
    for settings, fits in (
        ({"way_mm10": 4000, "x_mm10": 4000 - 600 - 1000}, True),  # and a quarter of the way
        ({"way_mm10": 4000, "x_mm10": 4000 - 600 - 1001}, False),
        ({"way_mm10": 4000, "heading_cdeg": 1000 + 240}, True),  # and 6 degrees a metre
        ({"way_mm10": 4000, "heading_cdeg": 1000 + 241}, False),
        ({"way_mm10": 0, "turn_cdeg": 8000, "entry": 0, "heading_cdeg": 8000 - 3000}, True),
        ({"way_mm10": 0, "turn_cdeg": 8000, "entry": 0, "heading_cdeg": 8000 - 3001}, False),
    ):
        assert judged(**settings) == [fits], settings


def test_doubt_and_belief():
    for legs, doubted in (
        ((False,), False),
        ((False, False), True),
        ((False, False, True), False),
        ((False, False, False, True), True),
        ((False, False, False, True, True), False),
        ((False, False, False, False, True, True), False),
    ):
        shares = Shares()
        for fits in legs:
            shares._judge(fits)
        assert shares.doubted == doubted, legs


def test_a_short_way_teaches_no_share():
    for told_mm, learns in ((79, False), (80, True)):
        shares = Shares()
        shares.learn_scale(told_mm, 0, 1 << 8, 0)
        assert (shares.scale._weight > 0) == learns
        shares = Shares()
        shares.compare(placed(), Told(), 0, 0)
        told_so(shares, 10 * told_mm, 3000, 0)
        shares.compare(placed(3000, 0, 1), Told(3000), 0, 0)
        assert (shares.drift._weight > 0) == learns
    shares = Share(0, 1000)
    shares.learn(16384, 0, 1 << 24)
    assert shares._weight == 16383 * 16383 >> 14  # with six bits behind the point
    shares = Share(0, 1000)
    for missed_q4 in (-3, 3, 2):  # little in loud noise: no floor makes a slope of it
        shares.learn(200, missed_q4, 1 << 24)
    assert shares._moment == 0 and shares._weight == 3 * (200 * 200 >> 14)


def carrier():
    """At the origin, with an odometry that has not moved yet."""
    made = Carrier(OdometryNoise())
    odometry = Told()
    odometry.epoch = odometry.jumps = 0
    made.move(odometry, 0)
    fix = placed()
    fix.scatter_mm10, fix.scatter_cdeg = 10, 10
    made.fix(fix)
    return made, fix


def louder_by(*squares_q4, moved=False):
    """How loud wheels are believed to be after each of such squares."""
    noise, told = Loudness(), []
    for square_q4 in squares_q4:
        noise.hear(square_q4, moved)
        told.append(noise.q4)
    return told


def test_noise_is_heard_as_a_mean_within_limits():
    assert louder_by(*[1 << 18] * 9, moved=True) == [24, 48, 72, 96, 120, 144, 168, 176, 176]
    assert louder_by(16, moved=True) == louder_by(0, moved=True) == [0]  # a push tells of no quiet wheels
    assert louder_by(16, 16) == [
        40,
        20 + 28,
    ]  # what was expected was more than was found
    assert louder_by(0) == [-96 + 40]  # by one square no more
    assert louder_by(0, 0, 0) == [-56, -92, -110]
    assert louder_by(*[0] * 60)[-1] == -176 + 40 // 10
    assert louder_by(512) == louder_by(1 << 18) == [5 * 16 + 40]  # a slip
    assert louder_by(*[1 << 18] * 60)[-1] == 176
    noise = Loudness()
    for square_q4 in [16] * 10:
        noise.hear(square_q4)
    last_q4 = noise._found_q4
    noise.hear(512)
    assert noise._known == 10 and noise._found_q4 - last_q4 == 16 + 14  # (10 + 32) / 11


def seen(*ways, noise=None):
    """... after ways of such (square, scatter, expected)."""
    noise = noise or Loudness()
    for way in ways:
        noise.look(*way, -200)
    return noise


def test_short_ways_tell_that_wheels_are_quiet_but_not_that_they_are_loud():
    assert seen((1000, 0, 4000)).q4 == 0  # one of them tells nothing
    assert seen(*[(1000, 0, 4000)] * 2).q4 == -32 + 40 // 2
    assert seen(*[(40000, 0, 4000)] * 8).q4 == 0
    noise = seen(*[(1000, 0, 4000)] * 9)
    assert noise.q4 == -32 + 40 // 9
    assert seen(*[(40000, 0, 4000)] * 8, noise=noise).q4 == 0  # no louder than the model
    noise = Loudness()
    for _ in range(9):
        noise.look(0, 0, 4000, -50)
    assert noise.q4 == -50 + 4  # so short a way shows no more
    noise = seen(*[(1000, 0, 4000)] * 9)
    noise._found_q4 = -150
    noise.look(0, 0, 4000, -50)
    assert noise._found_q4 <= -150  # what longer ones showed stays


def test_what_the_camera_cannot_see_is_likely_to_be_less_still():
    noise = seen((100, 100, 6400))
    assert not noise._is_unseen and noise._found_q4 == -96
    noise.look(399, 100, 6399, -200)  # noise of 99 is less than the scatter
    assert noise._is_unseen and noise._known == 2 and noise.q4 == -96 + 40 // 2 - 48
    noise = seen((100, 100, 6400))
    noise.look(399, 100, 6400, -200)
    assert not noise._is_unseen
    noise = seen((100, 100, 6400))
    noise.look(400, 100, 6399, -200)  # more than scatter makes
    assert not noise._is_unseen
    noise = seen(*[(0, 100, 6400)] * 9)
    assert noise._found_q4 == -128 + 16  # a quarter of the scatter's square is the least
    was_q4 = noise.q4
    noise.hear(16)  # fits: as it was, but now by one square
    assert not noise._is_unseen and noise._known == 1 and -8 < noise.q4 - was_q4 - 40 <= 0


def test_a_share_that_is_the_same_for_all_ways_is_no_noise():
    slope = Slope()
    assert slope.rest(100, 1000) == -1  # of the first nobody knows
    assert slope.rest(100, 1000) == slope.rest(50, 500) == 0
    slope = Slope()
    slope.rest(100, 0)
    assert slope.rest(100, 390) == 390 * 390 // 39 >> 1  # half of it by the first way's own error
    slope = Slope()
    for _ in range(9):
        slope.rest(100, 0)
    assert abs(slope.rest(100, -390) - 390 * 390 // 39 * 9 // 10) < 20
    assert Slope().rest(256, 0) == -1
    for told, other in ((255, 256), (-255, -256)):
        one, two = Slope(), Slope()
        one.rest(told, 4000)
        two.rest(other, 4000)
        assert one._square == two._square == 255 * 255 and one._cross == two._cross
    slope = Slope()
    for _ in range(2):
        slope.rest(255, 4000)
    assert slope._cross == 2 * 255 * 4000
    for _ in range(99):
        slope.rest(255, 4000)
        assert max(slope._square, slope._cross) <= 1 << 21
    slope = Slope()
    slope.rest(1, 4000)
    assert slope.rest(-1, 4000) == (4000 * 4000 // 39) >> 1  # no more than that


def test_a_short_way_tells_nothing_of_the_noise():
    for way, entry, legs in ((3000, 1, 0), (3001, 1, 1), (15000, 0, 0), (15001, 0, 1)):
        made, fix = carrier()
        made._path[5], fix.entry = way, entry  # to another marker, and below the same one
        made.fix(fix)
        assert made._legs == legs and made.turn_noise._known == legs
    for distance, learns in ((3000, False), (3001, True), (120000, True), (120001, False)):
        made, fix = carrier()
        made._path[1], fix.x_mm10 = distance << 4, distance
        made._hear_noise(fix)
        assert (made.shares.scale._weight > 0) == (made.way_noise._known == 1) == learns, distance
        made, fix = carrier()
        made._path[1], fix.x_mm10, fix.moved = distance << 4, distance, True
        made._hear_noise(fix)
        assert made.shares.scale._weight == made._legs == 0


def test_a_leg_tells_of_the_noise_along_the_way_and_of_that_of_turns():
    for off, way_louder, turn_louder in (
        ({"x_mm10": 1000}, True, False),
        ({"y_mm10": 1000}, False, True),
        ({"heading_cdeg": 2000}, False, True),
    ):
        made, fix = carrier()
        made._path[1] = 5000 << 4
        fix.x_mm10 = 5000
        for name, value in off.items():
            setattr(fix, name, getattr(fix, name) + value)
        made._hear_noise(fix)
        assert (made.way_noise.q4 > 40) == way_louder and (made.turn_noise.q4 > 40) == turn_louder, off


def grown(heading_q8, px, py, steps=1, **given):
    """Items of a covariance after ways of (px, py), 0.1 mm Q4, of which nothing but the heading is wrong."""
    items = array("i", [0] * 20)
    items[5], items[13] = heading_q8, -192
    for _ in range(steps):
        grow(0, 0, items, px, py, 1, 0, -176, -176, 0, 0)
        items[5] = heading_q8
    return items


def bent(mrad, px, py, steps):
    """By how much shorter the way may be, mm."""
    items = grown(mrad * mrad << 8, px, py, steps)
    return items[8] >> 8, items[9] >> 8


def test_a_heading_that_may_be_wrong_to_either_side_makes_the_way_shorter():
    # 0.8 * 0.2**2 of 3 m, and 0.8 * 0.7**2 of 2 m
    assert bent(200, 16000, 0, 30) == (95, 0) and bent(200, 0, -16000, 30) == (0, -96)
    assert bent(200, 160000, 0, 3)[0] == 95
    assert bent(700, 160000, 0, 2)[0] == 777 and bent(700, 160000, 0, 9)[0] == 1024  # no more than a metre
    assert bent(700, -160000, 0, 9)[0] == bent(700, 0, -160000, 9)[1] == -1024
    assert grown(230400, 16000, 0)[8] == 0 and grown(230401, 16000, 0)[8] > 0
    one, other = grown(40000 << 8, 16000, 0, 30), grown(230400, 16000, 0, 30)
    assert isqrt(one[0] >> 4) == 95 and one[2] > 40 * other[2] > 0 == other[0]  # along the way, and across it
    one = grown(40000 << 8, 16000, 16000, 30)
    assert -one[0] < one[1] < 0  # what is across the way outweighs it


def covered(since=1, speed=0, way_q4=-176, way_mm=0, turned=0, noise_q4=-192, haste=0, drift=0, turn=0):
    """Items of a covariance of 0 after a way of such length; drift, turn: sigmas, of which 2**16 are one."""
    items = array("i", [0] * 20)
    items[11], items[12], items[13], items[14] = drift, turn, noise_q4, haste
    grow(0, 0, items, 0, 0, since, speed, way_q4, -176, way_mm, turned)
    return items


def test_what_shares_of_a_way_and_of_turns_may_be_wrong_by_at_most():
    for turned, expected in ((16382, 16382), (16383, 16383), (16384, 16383), (30000, 16383)):
        assert covered(turned=turned, turn=65536)[7] == expected * expected, turned
    for length, expected in ((11499, 22998), (11500, 23000), (11501, 23000), (16383, 23000)):
        assert covered(way_mm=length, drift=2 * 65536)[7] == expected * expected, length
        assert covered(turned=length, turn=2 * 65536)[7] == expected * expected, length
    both = covered(way_mm=16383, turned=16383, drift=2 * 65536, turn=2 * 65536)
    assert both[7] == 2 * 23000 * 23000 and both[5] == 1 << 28


def test_how_much_a_way_of_loud_wheels_adds_at_most():
    # 2097/2**20 of the way times 2**9
    for since, added in ((10999, 11262), (11000, 11263), (11001, 11263), (30000, 11263)):
        assert covered(since, way_q4=144, noise_q4=0)[0] == added, since
    assert covered(11000, way_q4=160, noise_q4=0)[0] == 1 << 14  # no more than a metre's square


def test_haste_that_is_none_adds_no_noise():
    for noise_q4, as_q4 in (
        (-192, -176),
        (-185, -169),
        (-184, -184),
        (-199, -176),
        (-200, -192),
        (-300, -192),
    ):
        standing = covered(11000, way_q4=320, noise_q4=noise_q4, haste=2500)
        assert standing[0] == covered(11000, way_q4=320, noise_q4=as_q4)[0] > 0, noise_q4
    assert covered(11000, 127, 320, noise_q4=-192, haste=1)[0] == covered(11000, way_q4=320, noise_q4=-176)[0]


def advanced(dx=0, turn=0, passed_ms=20, known=1, path=(), sums=()):
    """Path and sums after an increment of the odometry; path, sums: items that are not 0 before it."""
    items, told = array("i", [0] * 14), array("i", [0] * 4)
    items[13] = 150
    for at, value in path:
        items[at] = value
    for at, value in sums:
        told[at] = value
    advance(0, 0, items, told, QUARTER_SINE_Q14, dx, 0, turn, 0, passed_ms, known)
    return items, told


def test_how_far_a_path_and_its_sums_go():
    for path, at, value in (
        (((5, (1 << 24) - 100),), 5, 1 << 24),  # way
        (((7, 179950),), 7, 180000),  # turned
        (((7, -180000),), 8, 179900),  # and to either side, at most
    ):
        assert advanced(100, 100, path=path)[0][at] == value, at
    assert advanced(0, -100, path=((7, -179950),))[0][7] == -180000
    assert advanced(1599)[0][9] == 7995 and advanced(1601)[0][9] == 8000  # mm/s
    for summed in (True, False):
        for at, last in ((2, 159999), (3, 159999), (3, -159999)):
            last += (0 if summed else 1) * (1 if last > 0 else -1)
            told = advanced(100, 50, sums=((at, last),))[1]
            assert (told[0] == told[1] == 100) == summed, (at, last)
            assert (told[at] != last) == summed
    path, told = advanced(100, 50, known=0)
    assert told[0] == 100 and list(path) == [0] * 9 + [500] + [0] * 3 + [150]
    path, told = advanced(-100, 1719)  # 300 mm between the wheels: 45 mm each
    assert list(told) == [-99, 99, 450, 1719] and path[5] == path[6] == 450


class Pieces(Carrier):
    count = 0

    def _advance(self, *increment):
        self.count += 1


def test_long_increments_come_in_pieces():
    for driven_mm10, count in ((6999, 1), (7000, 2), (14000, 3)):
        made = Pieces(OdometryNoise())
        odometry = Told()
        odometry.epoch = odometry.jumps = 0
        made.move(odometry, 0)
        odometry.x_mm10 = driven_mm10
        made.move(odometry, 20000)
        assert made.count == count, driven_mm10


def test_a_way_below_a_marker_takes_two_seconds_at_most():
    for before_ms, after_ms in ((2026, 2046), (2027, 2047), (2028, 2047)):
        made, _ = carrier()
        made._near_ms = before_ms
        made._odometry.x_mm10 += 100
        made.move(made._odometry, 20000)
        assert made._near_ms == after_ms, before_ms


def looked(way_mm10, times, turn_cdeg=0):
    """How loud the wheels are believed to be along the way, and in turns, when odometry told such a way or
    turn below a marker so often."""
    made, fix = carrier()
    odometry = made._odometry
    for k in range(times):
        odometry.x_mm10 += way_mm10
        odometry.heading_cdeg = (odometry.heading_cdeg + turn_cdeg) % 36000
        made.move(odometry, 200000 * (k + 1))
        fix.x_mm10, fix.heading_cdeg = odometry.x_mm10, odometry.heading_cdeg
        made.fix(fix)
    return made.way_noise.q4, made.turn_noise.q4


def test_which_ways_below_a_marker_tell_that_wheels_are_quiet():
    # the first one shows what share of it odometry leaves out
    for way_mm10, times, tells in ((1000, 3, True), (7000, 3, True), (1000, 2, False), (7001, 9, False)):
        way_q4, turn_q4 = looked(way_mm10, times)
        assert (way_q4 < -20 and turn_q4 < -20) == tells, (way_mm10, times)
        assert tells or way_q4 == turn_q4 == 0
    for turn_cdeg, times, tells in ((6000, 3, True), (6000, 2, False), (1490, 12, False)):
        way_q4, turn_q4 = looked(0, times, turn_cdeg)
        assert way_q4 == 0 and (turn_q4 < -20) == tells, (turn_cdeg, times)


class Heard(Loudness):
    def look(self, square, scatter, expected, least_q4):
        self.expected, self.least_q4 = expected, least_q4


def expected(way_ms):
    """What the model expects of turns at 0.2 m/s that take so long, and how little is believed."""
    made, fix = carrier()
    made.turn_noise = Heard()
    for _ in range(2):
        made._near_ms, made.shares.way_mm10 = way_ms, 2 * way_ms
        made.shares.missed_q4, made.shares.told_mrad = 0, 1000
        made._look_closely(fix)
    return made.turn_noise.expected, made.turn_noise.least_q4


def test_wheels_that_go_wrong_for_a_while_show_less_on_short_ways():
    # of twice as long a way not half as much, but two thirds, and two ways that follow are less alike
    one, two = expected(900), expected(1800)
    assert 440 < one[0] < 460  # of 180 mm
    assert abs(two[0] - one[0] * 8 // 3 * 11 // 10) < one[0] >> 3
    assert one[1] == two[1] and -120 < one[1] < -110  # 200 mm/s is 4.2 octaves above standing


class Near(Carrier):
    looks = 0

    def _look_closely(self, fix):
        self.looks += 1


def test_legs_tell_more_of_the_noise_than_ways_below_a_marker():
    made = Near(OdometryNoise())
    odometry = Told()
    odometry.epoch = odometry.jumps = 0
    made.move(odometry, 0)
    for legs, way_mm10, ended, looks in (
        (2, 7000, True, 1),
        (3, 7000, True, 0),
        (2, 7001, True, 0),
        (2, 7000, False, 0),
    ):
        made.shares.compare = lambda *rest, ended=ended: ended
        made.shares.way_mm10 = way_mm10
        made._legs, made.looks = legs, 0
        made.fix(placed())
        assert made.looks == looks, (legs, way_mm10, ended)
