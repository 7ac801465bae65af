"""Odometry from the wire: poses at exposures, what is refused, what begins anew, and no allocation."""

from array import array

from larics.locate.odometry import KEPT, Odometry, length
from larics.wire import messages as m
from wire_values import changed, message_values

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

LINE_US = 2604
AHEAD_US = 700000000  # the vehicle's clock is ahead of the camera's by so much: it wraps soon


class Bench:
    """A vehicle that drives 1 m/s in x and turns by 90 degrees/s, and tells it every 20 ms."""

    def __init__(self, now_us=1000000, period_us=20000):
        self.now_us = now_us
        self.period_us = period_us
        self.told = 0
        self.epoch = 3
        self.odometry = Odometry(lambda: self.now_us & m.COUNT_MAX, LINE_US)
        self.start_us = now_us

    def pose(self, time_us):
        ms = (time_us - self.start_us) // 1000
        return 10 * ms - 500, -3 * ms, (35000 + 9 * ms) % 36000

    def message(self, driven_us, age_us=1000, **given):
        x, y, heading = self.pose(driven_us)
        values = message_values(
            m.ODOMETRY, time_us=(driven_us + AHEAD_US) & m.COUNT_MAX, age_us=age_us, x_mm10=x, y_mm10=y,
            heading_cdeg=heading, epoch=self.epoch,
        )  # fmt: skip
        return array("i", changed(m.ODOMETRY, values, **given))

    def take(self, values, sampled_us, age_us=1000, waited_us=0):
        """The message is read when it has come over the line, and waited."""
        self.now_us = sampled_us + age_us + LINE_US + waited_us
        self.odometry.look()
        self.odometry.take(values)

    def drive(self, count, waits=(0,)):
        for _ in range(count):
            time_us = self.start_us + self.told * self.period_us
            self.told += 1
            self.take(self.message(time_us), time_us, waited_us=waits[self.told % len(waits)])
        return self.start_us + (self.told - 1) * self.period_us

    def counts(self):
        odometry = self.odometry
        return odometry.used, odometry.refused, odometry.stale, odometry.jumps


def test_the_pose_at_an_exposure_lies_between_two_messages():
    for now_us in (0, 123456789, m.COUNT_MAX - 500000):
        bench = Bench(now_us)
        assert not bench.odometry.heard and bench.odometry.at(now_us) == m.MOTION_NONE
        last_us = bench.drive(50, waits=(0, 9000, 15000))
        for back_us in (0, 5000, 13000, 20000, 123000, 700000):
            time_us = last_us - back_us
            assert bench.odometry.at(time_us & m.COUNT_MAX) == m.MOTION_INTERPOLATED
            x, y, heading = bench.pose(time_us)
            found = bench.odometry
            assert abs(found.x_mm10 - x) <= 6 and abs(found.y_mm10 - y) <= 3, (found.x_mm10, x)
            assert (found.heading_cdeg - heading + 20) % 36000 <= 40 and found.age_us == 0
        assert bench.odometry.heard and bench.counts() == (50, 0, 0, 0)


def test_the_last_motion_is_carried_on_for_a_while():
    bench = Bench()
    last_us = bench.drive(20)
    for ahead_us, state in ((15000, m.MOTION_EXTRAPOLATED), (190000, m.MOTION_EXTRAPOLATED), (210000, 0)):
        assert bench.odometry.at(last_us + ahead_us) == state
        assert abs(bench.odometry.age_us - ahead_us) < 500
        if state:
            assert abs(bench.odometry.x_mm10 - bench.pose(last_us + ahead_us)[0]) <= 8
    assert bench.odometry.at(last_us - KEPT * 20000 - 20000) == m.MOTION_NONE  # before all that is kept


def test_way_and_turn_are_sums_over_all_that_was_driven():
    bench = Bench()
    last_us = bench.drive(101)
    bench.odometry.at(last_us)
    assert abs(bench.odometry.way_mm10 - 20880) < 120  # 2 s at 1.044 m/s; each step is rounded
    assert bench.odometry.turn_cdeg == 18000
    back = [bench.pose(last_us)]
    for k in range(1, 51):  # back the same way: the sums go on
        time_us = last_us + k * 20000
        x, y, heading = bench.pose(last_us - k * 20000)
        bench.take(bench.message(time_us, x_mm10=x, y_mm10=y, heading_cdeg=heading), time_us)
        back.append((x, y))
    bench.odometry.at(time_us)
    assert abs(bench.odometry.way_mm10 - 31320) < 180 and bench.odometry.turn_cdeg == 27000
    assert bench.counts()[3] == 0


def test_twice_and_out_of_order_is_refused():
    bench = Bench()
    last_us = bench.drive(10)
    again = bench.message(last_us)
    bench.take(again, last_us, waited_us=3000)
    older = bench.message(last_us - 20000)
    bench.take(older, last_us - 20000, waited_us=40000)
    assert bench.counts() == (10, 2, 0, 0)
    bench.drive(5)
    assert bench.counts() == (15, 2, 0, 0)


def test_what_comes_too_late_is_stale_but_200_ms_are_not():
    bench = Bench()
    bench.drive(50)
    time_us = bench.start_us + bench.told * 20000
    bench.take(bench.message(time_us), time_us, waited_us=200000)
    assert bench.counts() == (51, 0, 0, 0)
    assert bench.odometry.at(time_us - 10000) == m.MOTION_INTERPOLATED
    assert abs(bench.odometry.x_mm10 - bench.pose(time_us - 10000)[0]) <= 6
    time_us += 300000
    bench.take(bench.message(time_us, age_us=1100000), time_us, age_us=1100000)
    assert bench.counts() == (51, 0, 1, 0)


def test_odometry_that_jumps_again_and_again_is_wild_until_it_goes_on():
    bench = Bench()
    bench.drive(30)
    for k in range(4):  # micrometres for tenths of a millimetre
        time_us = bench.start_us + (bench.told + k) * 20000
        x, y, _ = bench.pose(time_us)
        assert bench.odometry.is_wild == (k > 2)
        bench.take(bench.message(time_us, x_mm10=100 * x + 9000 * k, y_mm10=100 * y), time_us)
        assert bench.odometry.at(time_us - 5000) == m.MOTION_NONE
    bench.told += 4
    bench.drive(3)
    assert bench.odometry.is_wild
    bench.drive(20)
    assert not bench.odometry.is_wild and bench.counts()[3] >= 4
    bench.epoch = 9  # once is a reset
    bench.drive(2)
    assert not bench.odometry.is_wild


def test_a_new_epoch_begins_anew():
    bench = Bench()
    last_us = bench.drive(30)
    bench.odometry.at(last_us)
    way = bench.odometry.way_mm10
    bench.epoch = 4
    time_us = last_us + 20000
    bench.take(bench.message(time_us, x_mm10=900000, y_mm10=0, heading_cdeg=0), time_us)
    assert bench.odometry.at(time_us) == m.MOTION_NONE and bench.counts() == (31, 0, 0, 1)
    for k in range(1, 5):
        time_us += 20000
        bench.take(bench.message(time_us, x_mm10=900000 + 200 * k, y_mm10=0, heading_cdeg=0), time_us)
    assert bench.odometry.at(time_us - 10000) == m.MOTION_INTERPOLATED
    assert bench.odometry.x_mm10 == 900700 and bench.odometry.epoch == 4
    assert 0 <= bench.odometry.way_mm10 - way < 1000  # the jump is no way


def test_jumps_without_a_new_epoch_are_noticed():
    for change in ({"x_mm10": 90000}, {"y_mm10": -90000}, {"heading_cdeg": 17000}):
        bench = Bench()
        last_us = bench.drive(30)
        bench.take(bench.message(last_us + 20000, **change), last_us + 20000)
        assert bench.counts() == (31, 0, 0, 1), change
        assert bench.odometry.at(last_us + 10000) == m.MOTION_NONE


def test_a_vehicle_that_restarts_is_heard_again():
    """Its clock and its odometry begin at 0, and it forgot the epoch."""
    bench = Bench()
    bench.drive(200)
    base_us = bench.now_us
    for k in range(10):
        time_us = base_us + 500000 + k * 20000
        values = bench.message(time_us, time_us=k * 20000, x_mm10=200 * k, y_mm10=0, heading_cdeg=0)
        bench.take(values, time_us)
    assert bench.counts() == (210, 0, 0, 1)
    assert bench.odometry.at(time_us - 10000) == m.MOTION_INTERPOLATED
    assert abs(bench.odometry.x_mm10 - 1700) <= 2


def test_a_clock_that_leaps_forward_is_another_clock():
    bench = Bench()
    bench.drive(50)
    for k in range(50):
        time_us = bench.start_us + (bench.told + k) * 20000
        values = bench.message(time_us, time_us=(time_us + AHEAD_US + 5000000) & m.COUNT_MAX)
        bench.take(values, time_us)
    assert bench.counts() == (100, 0, 0, 1)
    bench.odometry.at(time_us - 10000)
    assert abs(bench.odometry.x_mm10 - bench.pose(time_us - 10000)[0]) <= 6


def test_nobody_knows_the_way_across_a_long_silence():
    bench = Bench()
    last_us = bench.drive(30)
    bench.told += 100
    bench.drive(1)
    assert bench.odometry.at(last_us + 1000000) == m.MOTION_NONE
    bench.drive(3)
    assert bench.odometry.at(bench.start_us + (bench.told - 2) * 20000) == m.MOTION_INTERPOLATED
    assert bench.counts() == (34, 0, 0, 0)  # a silence is no jump: odometry is cumulative


def test_lengths():
    for x, y, expected in ((0, 0, 0), (3, -4, 5), (-300000, 400000, 500000), (m.COUNT_MAX, 0, m.COUNT_MAX)):
        assert abs(length(x, y) - expected) <= expected >> 10


def test_nothing_is_allocated():
    bench = Bench()
    bench.drive(80)
    messages = [bench.message(bench.start_us + (bench.told + k) * 20000) for k in range(80)]
    times = [0]
    odometry = Odometry(lambda: times[0], LINE_US)
    for values in messages[:8]:
        odometry.look()
        odometry.take(values)
        times[0] += 20000
    found = 0
    heap_lock()
    try:
        for k in range(8, 80):
            times[0] += 20000
            odometry.look()
            odometry.take(messages[k])
            found += odometry.at(times[0] - 30000) == m.MOTION_INTERPOLATED
            odometry.at(times[0] + 5000)
    finally:
        heap_unlock()
    assert found > 60 and odometry.used == 80
