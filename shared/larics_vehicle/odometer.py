"""Reference odometry for a vehicle controller: from what the wheels did to ODOMETRY messages, in integers.

Feed it the ways of both wheels, or the way and the turn, since the last call, as the encoders tell them, and
send `message` at 20 to 100 a second. The pose is cumulative and never jumps; `reset` says so when it must.
Nothing is allocated. `firmware/vehicle/src/larics_wheels.c` does the same in C, step by step.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import cos_q14, sin_q14
from larics.wire.messages import COUNT_MAX, ODOMETRY_SLIP, ODOMETRY_STANDING

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
_MOST_UM = const(200000)  # of one call
_MOST_APART_UM = const(140000)  # of both wheels in one call: products stay within 30 bits
_MOST_TURN_MCDEG = const(9000000)
_FURTHEST_MM10 = const(500000000)  # 50 km: the wire carries little more
_Q7_PER_MM10 = const(12800)  # 1/128 um in 0.1 mm


class Odometer:
    """x_mm10, y_mm10, heading_cdeg: pose in the odometry frame, which begins where the vehicle started.

    epoch         0..255, another one after each jump
    is_slipping   set it while slip is suspected; is_standing: nothing moved in the last call
    """

    def __init__(self, epoch=0):
        self.x_mm10 = self.y_mm10 = 0
        self.epoch = epoch
        self.is_slipping, self.is_standing = False, True
        self._x_q7 = self._y_q7 = 0  # what is left of a tenth of a millimetre
        self._heading_mcdeg = 0
        self._turn_rest = self._way_rest = 0
        self._sampled_us = 0
        self._values = [0] * _ODOMETRY_FIELDS

    @property
    def heading_cdeg(self):
        return self._heading_mcdeg // 1000

    def move(self, forward_um, turn_mcdeg, now_us):
        """The vehicle drove so far (micrometres, at most 200 mm a call) and turned (1/1000 of 0.01 degrees,
        counterclockwise, at most 90 degrees) until now_us, microseconds of its clock modulo 2**30. False when
        that is out of range: then nothing was added."""
        if abs(forward_um) > _MOST_UM or abs(turn_mcdeg) > _MOST_TURN_MCDEG:
            return False
        middle_mdeg = (self._heading_mcdeg + (turn_mcdeg >> 1)) % _CIRCLE_MCDEG // 100
        turn16 = (middle_mdeg // 10 * 2048 + middle_mdeg % 10 * 205 + 562) // 1125
        x_q7 = self._x_q7 + _along(forward_um, cos_q14(turn16))
        y_q7 = self._y_q7 + _along(forward_um, sin_q14(turn16))
        self.x_mm10 += x_q7 // _Q7_PER_MM10
        self.y_mm10 += y_q7 // _Q7_PER_MM10
        self._x_q7 = x_q7 % _Q7_PER_MM10
        self._y_q7 = y_q7 % _Q7_PER_MM10
        self._heading_mcdeg = (self._heading_mcdeg + turn_mcdeg) % _CIRCLE_MCDEG
        self.is_standing = forward_um == 0 and turn_mcdeg == 0
        self._sampled_us = now_us
        if max(abs(self.x_mm10), abs(self.y_mm10)) > _FURTHEST_MM10:
            self.reset()
        return True

    def roll(self, left_um, right_um, track_mm, now_us):
        """The same from the ways of both wheels, micrometres, forward positive, at most 200 mm each and 140
        mm apart, and the distance between the wheels, 10 to 5000 mm."""
        apart_um, unit = right_um - left_um, track_mm * 125
        if max(abs(left_um), abs(right_um)) > _MOST_UM or abs(apart_um) > _MOST_APART_UM:
            return False
        if not 10 <= track_mm <= 5000:
            return False
        both_um = left_um + right_um + self._way_rest
        # 57.296 mdeg for each um on a track of 1 mm; then hundredths of that
        product = apart_um * 7162
        turn_mdeg = product // unit
        rest = (product - turn_mdeg * unit) * 100 + self._turn_rest
        if not self.move(both_um >> 1, turn_mdeg * 100 + rest // unit, now_us):
            return False
        self._way_rest = both_um & 1
        self._turn_rest = rest % unit
        self.is_standing = left_um == 0 and right_um == 0
        return True

    def reset(self):
        """The pose begins anew at 0, in a new epoch: whoever listens must not take that for a way."""
        self.x_mm10 = self.y_mm10 = self._x_q7 = self._y_q7 = 0
        self._heading_mcdeg = self._turn_rest = self._way_rest = 0
        self.epoch = (self.epoch + 1) & 255

    def message(self, now_us, flags=0):
        """The values of an ODOMETRY that begins to be sent at now_us, with more flags; the list is reused."""
        if self.is_slipping:
            flags |= ODOMETRY_SLIP
        if self.is_standing:
            flags |= ODOMETRY_STANDING
        values = self._values
        values[_ODOMETRY_TIME_US] = self._sampled_us
        values[_ODOMETRY_AGE_US] = (now_us - self._sampled_us) & COUNT_MAX
        values[_ODOMETRY_X_MM10] = self.x_mm10
        values[_ODOMETRY_Y_MM10] = self.y_mm10
        values[_ODOMETRY_HEADING_CDEG] = self.heading_cdeg
        values[_ODOMETRY_EPOCH] = self.epoch
        values[_ODOMETRY_FLAGS] = flags
        return values


def _along(um, cosine_q14):
    """um * cosine in 1/128 um, in two parts to stay within 30 bits."""
    high = um >> 7
    return high * cosine_q14 + ((um - high * 128) * cosine_q14 + 64 >> 7)
