"""Each limit of how loud wheels are believed to be, at it and just beyond."""

from larics.locate.carrier import Carrier
from larics.locate.uncertainty import OdometryNoise
from larics.locate.wheel_noise import Loudness, Slope
from odometry_parts import Told, carrier, placed

LEAST_Q4 = -176  # that a short way shows


def louder_by(*squares_q4, moved=False, least_q4=LEAST_Q4):
    """How loud wheels are believed to be after each of such squares."""
    noise, told = Loudness(), []
    for square_q4 in squares_q4:
        noise.hear(square_q4, moved, least_q4)
        told.append(noise.q4)
    return told


def test_noise_is_heard_as_a_mean_within_limits():
    assert louder_by(*[1 << 18] * 9, moved=True) == [24, 48, 72, 96, 120, 144, 168, 176, 176]
    assert louder_by(16, moved=True) == louder_by(0, moved=True) == [0]  # a push tells of no quiet wheels
    assert louder_by(16, 16) == [40, 20 + 28]  # what was expected was more than was found
    assert louder_by(0) == [-96 + 40]  # by one square no more
    assert louder_by(0, 0, 0) == [-56, -92, -110]
    assert louder_by(*[0] * 90)[-1] == LEAST_Q4 - 32 + 40 // 10
    assert louder_by(*[0] * 60, least_q4=-50)[-1] == -50 - 32 + 40 // 10
    assert louder_by(512) == louder_by(1 << 18) == [5 * 16 + 40]  # a slip
    assert louder_by(*[1 << 18] * 60)[-1] == 176
    noise = Loudness()
    for square_q4 in [16] * 10:
        noise.hear(square_q4, False, LEAST_Q4)
    last_q4 = noise._found_q4
    noise.hear(512, False, LEAST_Q4)
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
    noise.hear(16, False, LEAST_Q4)  # fits: as it was, but now by one square
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
        assert (made.shares.scale.items[1] > 0) == (made.way_noise._known == 1) == learns, distance
        made, fix = carrier()
        made._path[1], fix.x_mm10, fix.moved = distance << 4, distance, True
        made._hear_noise(fix)
        assert made.shares.scale.items[1] == made._legs == 0


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


def test_no_wheels_are_quieter_than_slips_let_them_be():
    noise = Loudness()
    for _ in range(9):
        noise.look(0, 100, 1000, -60)
    assert noise._is_unseen and noise.q4 == -60 - 32
    noise.follow(-300)
    assert noise.q4 == -60 - 32
    told = {}
    for speed in (0, 200, 2000):  # mm/s
        made, fix = carrier()
        made._path[1], made._path[9], fix.x_mm10 = 5000 << 4, speed, 5000
        made.way_noise, made.turn_noise = Heard(), Heard()
        made._hear_noise(fix)
        assert made.way_noise.least_q4 == made.turn_noise.least_q4
        told[speed] = made.way_noise.least_q4
    assert told == {0: -48, 200: -48 - 67, 2000: -48 - 120}, told


def test_what_is_not_seen_of_the_way_is_as_loud_as_in_turns():
    for times, other_q4, expected_q4 in (
        (2, -300, -96 + 20 - 48),  # as before
        (2, -100, -100),
        (2, 0, -96 + 20),  # no more than stays unseen
        (1, 0, 0),  # one way tells nothing
    ):
        noise = seen(*[(399, 100, 6400)] * (times - 1), noise=Loudness())
        noise._found_q4 = -96
        noise.look(0, 400, 6400, -200)
        assert noise._is_unseen and noise._known == times
        noise.follow(other_q4)
        assert noise.q4 == expected_q4, (times, other_q4)
    noise = seen(*[(1000, 0, 4000)] * 2)
    noise.follow(500)  # what is seen needs nobody to tell
    assert noise.q4 == -32 + 40 // 2


class Heard(Loudness):
    scatter = -1

    def look(self, square, scatter, expected, least_q4):
        self.scatter, self.expected, self.least_q4 = scatter, expected, least_q4

    def hear(self, square_q4, moved, least_q4):
        self.least_q4 = least_q4

    def follow(self, other_q4):
        self.other_q4 = other_q4


def beside_noise(told_mm=100, told_mrad=0, way_ms=100, scatter_mm10=0, scatter_cdeg=0, certain_mm10=0):
    """What of 100 mm may be missed beside the noise of wheels, along the way and in turns: mm2 Q8."""
    made, fix = carrier()
    made.turn_noise, made.way_noise = Heard(), Heard()
    fix.scatter_mm10, fix.scatter_cdeg, fix.certain_mm10 = scatter_mm10, scatter_cdeg, certain_mm10
    for _ in range(2):
        made._near_ms, made.shares.way_mm10, made.shares.missed_q4 = way_ms, 1000, 0
        made.shares.told_mm, made.shares.told_mrad = told_mm, told_mrad
        made.turn_noise.q4 -= 7
        made._look_closely(fix)
        assert made.way_noise.other_q4 == made.turn_noise.q4
    return made.way_noise.scatter, made.turn_noise.scatter


def test_what_else_than_noise_is_missed_on_a_short_way():
    assert beside_noise(way_ms=2047) == (1, 0)  # at 48 mm/s
    # the scatter of the detection, twice: 0.2 mm are 20.5, and 0.02 degrees 0.05 mm
    assert beside_noise(way_ms=2047, scatter_mm10=2, scatter_cdeg=2) == (21, 2)
    assert beside_noise(way_ms=2047, scatter_cdeg=1)[1] == 1
    # 0.4 ms, twice: at 1 m/s, and while it turns by 1.5 rad/s
    assert beside_noise() == ((40 * 40 + 19) // 20, 0)
    assert beside_noise(told_mrad=-1500, way_ms=1000) == ((4 * 4 + 19) // 20, (9 * 9 + 19) // 20)
    assert beside_noise(0, 1500, 1000)[0] == -1  # of a turn on the spot
    # what calibration puts the place off by turns with the vehicle
    assert beside_noise(told_mrad=1000, way_ms=2047, certain_mm10=30)[0] == (150 * 300 + 2 + 19) // 20
    for mrad, swept in ((1980, 1960), (2000, 1980), (2015, 1980), (-9000, 1980)):
        assert (
            beside_noise(told_mrad=mrad, way_ms=2047, certain_mm10=99)[0] == (swept * swept // 2 + 20) // 20
        )
    for certain_mm10 in (99, 100, 101, 20000):
        swept = min(2000, 20 * certain_mm10)
        found = beside_noise(told_mrad=2000, way_ms=2047, certain_mm10=certain_mm10)[0]
        assert found == (swept * swept // 2 + 20) // 20, certain_mm10
    most = (2000 * 2000 + 19) // 20
    assert beside_noise(way_ms=2047, scatter_mm10=5000, scatter_cdeg=3000) == (most + 1, most)
    assert beside_noise(told_mrad=2000, way_ms=1)[1] == most


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
