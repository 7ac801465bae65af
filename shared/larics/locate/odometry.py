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

from larics.arith.fixed import isqrt
from larics.kernels.odometry import admit, hear, pose_at, settle
from larics.locate.vehicle_clock import SPAN_OVER, VehicleClock
from larics.wire.messages import COUNT_MAX, MOTION_NONE

KEPT = const(64)  # poses: 0.64 s at 100 a second, 1.3 s at 50
_ITEMS = const(395)  # ... and as in kernels.odometry
_EPOCH = const(387)
_FLAGS = const(388)
_BEFORE_US = const(390)
_LINE_US = const(391)
_JUMPS = const(392)
_WILD = const(394)
_DIFFERS = const(1)  # of what settle() gives
_KEPT = const(2)
_X_MM10 = const(1)  # of a pose
_Y_MM10 = const(2)
_HEADING_CDEG = const(3)
_WAY_MM10 = const(4)
_TURN_CDEG = const(5)
_AGE_US = const(6)


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
        self.state = MOTION_NONE
        self.x_mm10 = self.y_mm10 = self.heading_cdeg = 0
        self.way_mm10 = self.turn_cdeg = self.age_us = 0
        self.epoch = self.flags = 0
        self._ticks_us = ticks_us
        self._looked_us = ticks_us() & COUNT_MAX
        self._ring = array("i", [0] * _ITEMS)
        self._ring[_LINE_US] = line_us
        self._ring[_BEFORE_US] = self._looked_us
        self._pose = array("i", [0] * 7)

    def look(self):
        """The line is about to be read: what comes was not there yet the last time."""
        self._ring[_BEFORE_US] = self._looked_us
        self._looked_us = self._ticks_us() & COUNT_MAX

    def take(self, values):
        """Takes the values of an ODOMETRY message, array('i')."""
        now_us, ring, clock = self._ticks_us() & COUNT_MAX, self._ring, self.clock.items
        if not admit(0, 0, values, ring, clock, now_us):
            self.refused = (self.refused + 1) & COUNT_MAX
            return
        known = hear(0, 0, clock)
        if known == SPAN_OVER:
            self.clock.learn()
        found = settle(0, 0, values, ring, clock, now_us, known)
        if found & _KEPT:
            self.used = (self.used + 1) & COUNT_MAX
        else:
            self.stale = (self.stale + 1) & COUNT_MAX
        if found & _DIFFERS:
            self.epoch, self.flags = ring[_EPOCH], ring[_FLAGS]
            self.jumps = ring[_JUMPS]
            self.heard, self.is_wild = True, bool(ring[_WILD])

    def at(self, time_us):
        """Sets the pose at a time; returns the state. With MOTION_NONE the pose stays that of before."""
        pose = self._pose
        self.state = pose_at(0, 0, self._ring, time_us, pose)
        self.age_us = pose[_AGE_US]
        if self.state != MOTION_NONE:
            self.x_mm10, self.y_mm10 = pose[_X_MM10], pose[_Y_MM10]
            self.heading_cdeg = pose[_HEADING_CDEG]
            self.way_mm10, self.turn_cdeg = pose[_WAY_MM10], pose[_TURN_CDEG]
        return self.state


def length(x, y):
    """Length of a vector of components within 2**30, to 1/1024 of it."""
    x, y = abs(x), abs(y)
    shift = 0
    while x > 16383 or y > 16383:
        x >>= 1
        y >>= 1
        shift += 1
    return isqrt(x * x + y * y) << shift
