"""The vehicle's odometry as it comes over the wire, and where it was at the exposure of a frame.

The last poses are kept with their times on the clock of the exposures and interpolated, so that it does not
matter when a message is read. Poses are cumulative: a lost message costs nothing. Integers within 30 bits;
nothing is allocated.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import isqrt, wrap_cdeg
from larics.locate.vehicle_clock import VehicleClock, later_us, signed_us
from larics.wire.messages import COUNT_MAX, MOTION_EXTRAPOLATED, MOTION_INTERPOLATED, MOTION_NONE

# generated: begin indices (tools/make_protocol.py)
_ODOMETRY_TIME_US = const(0)
_ODOMETRY_AGE_US = const(1)
_ODOMETRY_X_MM10 = const(2)
_ODOMETRY_Y_MM10 = const(3)
_ODOMETRY_HEADING_CDEG = const(4)
_ODOMETRY_EPOCH = const(5)
_ODOMETRY_FLAGS = const(6)
# generated: end indices

KEPT = const(64)  # poses: 0.64 s at 100 a second, 1.3 s at 50
_STALE_US = const(1000000)  # no frame that is still processed was exposed so long ago
_LATE_US = const(1000000)  # a time that is further back is another clock's, not a message overtaken
_GAP_US = const(1000000)  # between two poses nobody knows the way
_FASTEST_MM10_S = const(200000)  # 20 m/s, and _TURN_CDEG_S (10 turns a second), is no drive but a jump
_TURN_CDEG_S = const(360000)
_SLACK_MM10 = const(500)
_AHEAD_US = const(200000)  # for so long the last motion is carried on ...
_JUMPY = const(4)  # a jump counts as much as so many good poses;
_WILD = const(8)  # beyond this odometry is wild,
_TAME = const(1)  # and below this no more
_WILDEST = const(16)
_BASE_US = const(10000)  # ... as it was over at least so long


class Odometry:
    """ticks_us: the clock of the exposures (any, modulo 2**30); line_us: time of an ODOMETRY on the line.

    `look` before the line is read, `take` each message, then `at` the exposure of a frame:

    state                           MOTION_NONE, MOTION_INTERPOLATED or MOTION_EXTRAPOLATED
    x_mm10, y_mm10, heading_cdeg    in the odometry frame
    way_mm10, turn_cdeg             driven and turned since the start, to and fro, modulo 2**30
    age_us                          from the newest pose to that time, 0 when there is a later one
    epoch, flags                    of the newest message
    heard                           whether there was any message yet
    is_wild                         whether it jumps again and again: a wrong unit, two vehicles on the line

    Counters, modulo 2**30: used, refused (twice, or out of order), stale, jumps.
    """

    def __init__(self, ticks_us, line_us=0):
        self.clock = VehicleClock()
        self.used = self.refused = self.stale = self.jumps = 0
        self.heard = self.is_wild = False
        self._jumpy = 0
        self.state = MOTION_NONE
        self.x_mm10 = self.y_mm10 = self.heading_cdeg = 0
        self.way_mm10 = self.turn_cdeg = self.age_us = 0
        self.epoch = self.flags = 0
        self._ticks_us = ticks_us
        self._line_us = line_us
        self._looked_us = self._before_us = ticks_us() & COUNT_MAX
        self._times = array("i", [0] * KEPT)
        self._xs = array("i", [0] * KEPT)
        self._ys = array("i", [0] * KEPT)
        self._headings = array("i", [0] * KEPT)
        self._ways = array("i", [0] * KEPT)
        self._turns = array("i", [0] * KEPT)
        self._newest = 0
        self._count = 0
        self._sampled_us = 0

    def look(self):
        """The line is about to be read: what comes was not there yet the last time."""
        self._before_us = self._looked_us
        self._looked_us = self._ticks_us() & COUNT_MAX

    def take(self, values):
        """Takes the values of an ODOMETRY message."""
        now_us = self._ticks_us() & COUNT_MAX
        sampled_us, age_us = values[_ODOMETRY_TIME_US], values[_ODOMETRY_AGE_US]
        if self.heard and values[_ODOMETRY_EPOCH] != self.epoch:
            self._begin_anew()
        elif self._count:
            step_us = signed_us(sampled_us - self._sampled_us)
            if -_LATE_US < step_us <= 0:
                self.refused = (self.refused + 1) & COUNT_MAX
                return
            if step_us <= 0:
                self._begin_anew()
                self.clock.forget()
        arrived_us = (now_us - self._line_us) & COUNT_MAX
        waited_us = max(0, signed_us(now_us - self._before_us))
        sent_us = later_us(sampled_us, age_us)
        if not self.clock.hear(arrived_us, sent_us, waited_us):
            self._begin_anew()
            self.clock.forget()
            self.clock.hear(arrived_us, sent_us, waited_us)
        self.heard = True
        self.epoch = values[_ODOMETRY_EPOCH]
        self.flags = values[_ODOMETRY_FLAGS]
        self._sampled_us = sampled_us
        time_us = self.clock.camera_us(sampled_us)
        if age_us > _STALE_US or signed_us(now_us - time_us) > _STALE_US:
            self.stale = (self.stale + 1) & COUNT_MAX
            return
        self.used = (self.used + 1) & COUNT_MAX
        x_mm10, y_mm10 = values[_ODOMETRY_X_MM10], values[_ODOMETRY_Y_MM10]
        self._keep(time_us, x_mm10, y_mm10, values[_ODOMETRY_HEADING_CDEG])

    def _begin_anew(self):
        """What comes now has nothing to do with what came before; way and turn go on."""
        if self._count:
            self.jumps = (self.jumps + 1) & COUNT_MAX
        self._count = 0
        self._jumpy = min(_WILDEST, self._jumpy + _JUMPY)
        if self._jumpy > _WILD:
            self.is_wild = True

    def _keep(self, time_us, x_mm10, y_mm10, heading_cdeg):
        newest = self._newest
        way_mm10, turn_cdeg = self._ways[newest], self._turns[newest]
        if self._count:
            passed_us = signed_us(time_us - self._times[newest])
            if passed_us <= 0:  # the clocks were set right meanwhile
                time_us = later_us(self._times[newest], 1)
                passed_us = 1
            driven_mm10 = length(x_mm10 - self._xs[newest], y_mm10 - self._ys[newest])
            turned_cdeg = abs(wrap_cdeg(heading_cdeg - self._headings[newest]))
            if passed_us > _GAP_US:
                self._count = 0
            elif driven_mm10 > _SLACK_MM10 + _FASTEST_MM10_S // 1000 * (
                passed_us // 1000
            ) or turned_cdeg > _SLACK_MM10 + _TURN_CDEG_S // 1000 * (passed_us // 1000):
                self._begin_anew()
                driven_mm10 = turned_cdeg = 0
            way_mm10, turn_cdeg = later_us(way_mm10, driven_mm10), later_us(turn_cdeg, turned_cdeg)
        self._jumpy = max(0, self._jumpy - 1)
        if self._jumpy < _TAME:
            self.is_wild = False
        newest = (newest + 1) % KEPT
        self._newest = newest
        self._count = min(KEPT, self._count + 1)
        self._times[newest] = time_us
        self._xs[newest] = x_mm10
        self._ys[newest] = y_mm10
        self._headings[newest] = heading_cdeg
        self._ways[newest] = way_mm10
        self._turns[newest] = turn_cdeg

    def at(self, time_us):
        """Sets the pose at a time; returns the state. With MOTION_NONE the pose stays that of before."""
        newest = self._newest
        self.state = MOTION_NONE
        self.age_us = 0
        if self._count < 2:
            return MOTION_NONE
        ahead_us = signed_us(time_us - self._times[newest])
        if ahead_us > 0:
            self.age_us = ahead_us
            if ahead_us > _AHEAD_US:
                return MOTION_NONE
            before = self._before(_BASE_US)
            if before < 0:
                return MOTION_NONE
            self._mix(before, newest, time_us)
            self.state = MOTION_EXTRAPOLATED
            return MOTION_EXTRAPOLATED
        after = newest
        for _ in range(self._count - 1):
            before = (after - 1) % KEPT
            if signed_us(time_us - self._times[before]) >= 0:
                self._mix(before, after, time_us)
                self.state = MOTION_INTERPOLATED
                return MOTION_INTERPOLATED
            after = before
        return MOTION_NONE

    def _before(self, apart_us):
        """The newest pose that is older than the newest one by so much; -1 when there is none."""
        for k in range(1, self._count):
            place = (self._newest - k) % KEPT
            if signed_us(self._times[self._newest] - self._times[place]) >= apart_us:
                return place
        return -1

    def _mix(self, before, after, time_us):
        """The pose on the line through two poses."""
        between_us = max(1, signed_us(self._times[after] - self._times[before]))
        share_q9 = (signed_us(time_us - self._times[before]) << 9) // between_us
        x, y, heading = self._xs[before], self._ys[before], self._headings[before]
        self.x_mm10 = x + ((self._xs[after] - x) * share_q9 >> 9)
        self.y_mm10 = y + ((self._ys[after] - y) * share_q9 >> 9)
        turned_cdeg = wrap_cdeg(self._headings[after] - heading)
        self.heading_cdeg = (heading + (turned_cdeg * share_q9 >> 9)) % 36000
        way, turn = self._ways[before], self._turns[before]
        self.way_mm10 = later_us(way, ((self._ways[after] - way) & COUNT_MAX) * share_q9 >> 9)
        self.turn_cdeg = later_us(turn, ((self._turns[after] - turn) & COUNT_MAX) * share_q9 >> 9)


def length(x, y):
    """Length of a vector of components within 2**30, to 1/1024 of it."""
    x, y = abs(x), abs(y)
    shift = 0
    while x > 16383 or y > 16383:
        x >>= 1
        y >>= 1
        shift += 1
    return isqrt(x * x + y * y) << shift
