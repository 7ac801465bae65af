"""Reference odometry for a vehicle controller: from what the wheels did to ODOMETRY messages, in integers.

Feed it the way and the turn since the last call, as the encoders tell them, and send `message` at 20 to 100
a second. The pose is cumulative and never jumps; `reset` says so when it must. Nothing is allocated.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import cos_q14, sin_q14, turn16_from_cdeg
from larics.wire.messages import COUNT_MAX

# generated: begin indices (tools/make_protocol.py)
_ODOMETRY_FIELDS = const(7)
_ODOMETRY_TIME_US = const(0)
_ODOMETRY_AGE_US = const(1)
_ODOMETRY_X_MM10 = const(2)
_ODOMETRY_Y_MM10 = const(3)
_ODOMETRY_HEADING_CDEG = const(4)
_ODOMETRY_EPOCH = const(5)
_ODOMETRY_FLAGS = const(6)
# generated: end indices

_CIRCLE_MCDEG = const(36000000)  # a turn in 1/1000 of 0.01 degrees
_LONGEST_UM = const(65000)  # of one call: products stay within 30 bits
_UM_PER_MM10 = const(100)


class Odometer:
    """x_mm10, y_mm10, heading_cdeg: pose in the odometry frame, which begins where the vehicle started."""

    def __init__(self, epoch=0):
        self.x_mm10 = self.y_mm10 = 0
        self.epoch = epoch
        self._x_um = self._y_um = 0  # what is left of a tenth of a millimetre
        self._heading_mcdeg = 0
        self._sampled_us = 0
        self._values = [0] * _ODOMETRY_FIELDS

    @property
    def heading_cdeg(self):
        return self._heading_mcdeg // 1000

    def move(self, forward_um, turn_mcdeg, now_us):
        """The vehicle drove so far (micrometres, at most 65 mm a call) and turned (1/1000 of 0.01 degrees,
        counterclockwise, at most half a turn) until now_us, microseconds of its clock modulo 2**30."""
        middle = turn16_from_cdeg((self._heading_mcdeg + turn_mcdeg // 2) // 1000)
        forward_um = max(-_LONGEST_UM, min(_LONGEST_UM, forward_um))
        x_um = self._x_um + (forward_um * cos_q14(middle) + 8192 >> 14)
        y_um = self._y_um + (forward_um * sin_q14(middle) + 8192 >> 14)
        self.x_mm10 += x_um // _UM_PER_MM10
        self.y_mm10 += y_um // _UM_PER_MM10
        self._x_um = x_um % _UM_PER_MM10
        self._y_um = y_um % _UM_PER_MM10
        self._heading_mcdeg = (self._heading_mcdeg + turn_mcdeg) % _CIRCLE_MCDEG
        self._sampled_us = now_us

    def reset(self):
        """The pose begins anew at 0: whoever listens must not take that for a way."""
        self.x_mm10 = self.y_mm10 = self._x_um = self._y_um = self._heading_mcdeg = 0
        self.epoch = (self.epoch + 1) & 255

    def message(self, now_us, flags=0):
        """The values of an ODOMETRY that begins to be sent at now_us; the list is reused."""
        values = self._values
        values[_ODOMETRY_TIME_US] = self._sampled_us
        values[_ODOMETRY_AGE_US] = (now_us - self._sampled_us) & COUNT_MAX
        values[_ODOMETRY_X_MM10] = self.x_mm10
        values[_ODOMETRY_Y_MM10] = self.y_mm10
        values[_ODOMETRY_HEADING_CDEG] = self.heading_cdeg
        values[_ODOMETRY_EPOCH] = self.epoch
        values[_ODOMETRY_FLAGS] = flags
        return values
