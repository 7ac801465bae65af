"""Each limit of the poses that odometry keeps, at it and just beyond."""

from array import array

from larics.kernels.odometry import settle
from larics.locate.odometry import KEPT, Odometry
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
