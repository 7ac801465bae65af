"""The pose carried on at the last speed and turn rate, and the scatter of what was measured, in integers.

Nothing is allocated.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import cos_q14, sin_q14, turn16_from_cdeg, wrap_cdeg
from larics.locate.motion import Motion, grown, times_q14
from larics.locate.noise import Residuals

_ACCELERATION_MM10_S2 = const(48)  # typical, not possible, for sigma while coasting: so much at least, and by
_CURVE_MM10 = const(160000)  # curves of 16 m radius that begin or end
_TURN_ACCELERATION_CDEG_S2 = const(304)
_MOST_MM10_S2 = const(30000)
_FLOOR_MM10 = const(3)
_FLOOR_CDEG = const(2)
_START_MM10 = const(20)  # sigma before there are residuals
_START_CDEG = const(15)


class Coasting:
    """`measured` with each pose by a marker, then `predict`.

    known          0: no measurement, 1: one, no speed yet, 2: place and speed
    scatter_mm10, scatter_cdeg   of the measurements, from how far they stray from going on as before
    """

    def __init__(self, speed_mm_s):
        self.speed_mm_s = speed_mm_s
        self.known = 0
        self.scatter_mm10, self.scatter_cdeg = _START_MM10, _START_CDEG
        self._motion = Motion()
        self._history = array("i", [0] * 7)  # the measurement before the last: x, y, heading, 100 us to the
        # next; the last: x, y, heading
        self._noise = (Residuals(_START_MM10), Residuals(_START_MM10), Residuals(_START_CDEG))

    def begin(self, before):
        """Nothing is known of speed and scatter; `before`: x, y, heading of the frame before, or None."""
        self.known = 0
        self._motion.stop()
        if before is not None:
            history = self._history
            history[4], history[5] = before[0], before[1]
            history[6] = before[2]
            self.known = 1

    def predict(self, pose, time_h):
        """The last measurement carried on for that time, into pose: x, y, heading, not wrapped."""
        history = self._history
        pose[0], pose[1] = history[4], history[5]
        pose[2] = history[6]
        self._motion.carry(pose, time_h)

    def measured(self, fix, passed_us, is_recent, is_told):
        """A pose by a marker, a carrier.Fix, passed_us after the last; is_recent: that is not too long for a
        speed; is_told: the scatter is known otherwise."""
        history = self._history
        x, y = fix.x_mm10, fix.y_mm10
        heading, last_h = fix.heading_cdeg, max(1, passed_us // 100)
        if self.known and is_recent:
            forward_h = history[3]
            turned = wrap_cdeg(heading - history[6])
            if self.known > 1 and not is_told:
                # what was driven before, turned as the vehicle has turned since: straight lines and arcs
                middle = turn16_from_cdeg(wrap_cdeg(heading - history[2]) // 2)
                sin, cos = sin_q14(middle), cos_q14(middle)
                dx, dy = history[4] - history[0], history[5] - history[1]
                before_x = times_q14(dy, sin) - times_q14(dx, cos)
                before_y = 0 - times_q14(dx, sin) - times_q14(dy, cos)
                self._noise[0].add(before_x, 0, x - history[4], forward_h, last_h)
                self._noise[1].add(before_y, 0, y - history[5], forward_h, last_h)
                self._noise[2].add(wrap_cdeg(history[2] - history[6]), 0, turned, forward_h, last_h)
            dx, dy = x - history[4], y - history[5]
            self._motion.learn(dx, dy, history[6], turned, last_h, self.known < 2)
            history[0], history[1] = history[4], history[5]
            history[2], history[3] = history[6], last_h
            self.known = 2
        else:
            for noise in self._noise:
                noise.reset()
            self.known = 1
        history[4], history[5] = x, y
        history[6] = heading
        if is_told:
            return
        self.scatter_mm10 = max(self._noise[0].sigma(_FLOOR_MM10), self._noise[1].sigma(_FLOOR_MM10))
        self.scatter_cdeg = self._noise[2].sigma(_FLOOR_CDEG)

    def grown_mm10(self, time_h):
        """What is unknown of the place after that time, beside sigma at its beginning."""
        # whether a turn ended or went on is not known, so what it takes to turn counts as unknown, too
        speed = min(50000, abs(self._motion.forward) + abs(self._motion.left)) // 10
        acceleration = _ACCELERATION_MM10_S2 + min(_MOST_MM10_S2, speed * speed // (_CURVE_MM10 // 100))
        acceleration += self._motion.sideways_mm10_s2() >> 1
        found_mm10 = grown(acceleration, time_h, 60000)
        if self.known < 2:
            found_mm10 = min(60000, found_mm10 + self.speed_mm_s * min(time_h, 10000) // 1000)
        return found_mm10

    def grown_cdeg(self, time_h):
        """The same of the heading."""
        speed = min(50000, abs(self._motion.forward) + abs(self._motion.left))
        return grown(_TURN_ACCELERATION_CDEG_S2 + speed // 4 + abs(self._motion.turn), time_h, 18000)
