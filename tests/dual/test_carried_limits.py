"""Each limit of a pose that odometry carries and of its covariance, at it and just beyond."""

from array import array

from larics.arith.fixed import isqrt
from larics.arith.tables import QUARTER_SINE_Q14
from larics.kernels.covariance import grow
from larics.kernels.odometry import advance
from larics.locate.carrier import Carrier
from larics.locate.uncertainty import OdometryNoise
from odometry_parts import Told


def grown(heading_q8, px, py, steps=1):
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
