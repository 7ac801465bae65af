"""Measurements as MAVLink 2, for vehicles that run ArduPilot or PX4.

POSE becomes VISION_POSITION_ESTIMATE (102), STATUS becomes HEARTBEAT (0), which is due once a second, and
for a camera that looks down MARKER becomes LANDING_TARGET (149), one a frame. What MAVLink has no word for is
not sent: frames without a marker, markers with an uncertain or unconfirmed ID or without an offset, and poses
that are not TRACKING (an estimator that fuses them must not be fed predictions).

What the autopilots make of it is in docs/autopilots.md, with the sources read. The map's x, y go out as the
local frame's x, -y. Field layouts, message IDs and CRC_EXTRA are those of common.xml.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import atan2_turn16, cos_q14, isqrt, sin_q14, wrap_cdeg
from larics.arith.float32 import put_float32, put_nan32
from larics.kernels.crc import x25
from larics.wire import messages as m

# generated: begin indices (tools/make_protocol.py)
_MARKER_FRAME = const(0)
_MARKER_AGE_US = const(1)
_MARKER_FLAGS = const(2)
_MARKER_ID = const(3)
_MARKER_X_MM10 = const(6)
_MARKER_Y_MM10 = const(7)
_MARKER_Z_MM10 = const(8)
_MARKER_HEADING_CDEG = const(9)
_POSE_AGE_US = const(1)
_POSE_STATE = const(3)
_POSE_X_MM10 = const(5)
_POSE_Y_MM10 = const(6)
_POSE_HEADING_CDEG = const(7)
_POSE_SIGMA_X_MM10 = const(8)
_POSE_SIGMA_Y_MM10 = const(9)
_POSE_CORRELATION_Q14 = const(10)
_POSE_SIGMA_CDEG = const(11)
_STATUS_STATE = const(15)
# generated: end indices

_HEADER = const(10)
_LONGEST = const(117)

_HEARTBEAT = const(0)
_LANDING_TARGET = const(149)
_VISION_POSITION_ESTIMATE = const(102)

_UNUSABLE = const(99)  # NONE, NO_OFFSET, ID_UNCERTAIN, UNCONFIRMED
_TYPE_ONBOARD_CONTROLLER = const(18)
_AUTOPILOT_INVALID = const(8)
_STATE_STANDBY = const(3)
_STATE_ACTIVE = const(4)
_FRAME_BODY_FRD = const(12)
_TARGET_VISION_FIDUCIAL = const(2)

_COVARIANCE = const(42)  # place of the upper triangle, row by row
_RESET_COUNTER = const(126)

_JUMP_MM10 = const(2000)  # a pose that is found again further away than a vehicle can have come has jumped
_JUMP_CDEG = const(3000)
_TURN_CDEG_PER_MS = const(36)


class MavlinkEncoder:
    """Encodes like larics.wire.codec.Encoder: n = encode(type, values), then send buffer[:n].

    n is 0 for what is not sent. `uptime` is the Outbox's, for the time stamps: messages of one frame get the
    same, whenever they are sent. target: "none", or the autopilot that LANDING_TARGET is for, "ardupilot" or
    "px4". max_speed_mm_s: of the vehicle; a pose that leaps further counts in the reset counter.
    """

    def __init__(self, uptime, system=1, component=197, target="none", max_speed_mm_s=500):
        self.buffer = bytearray(_HEADER + _LONGEST + 2)
        self.sequence = 0
        self._uptime = uptime
        self._system = system
        self._component = component
        self._is_target_sent = target != "none"
        self._is_position_sent = target == "ardupilot"
        self._target_frame = -1
        self._max_speed_mm_s = max_speed_mm_s
        self._resets = 0  # times that the pose was found again, 0..255
        self._is_lost = False
        self._is_sent = False  # where, and when, the last pose was sent
        self._x_mm10 = self._y_mm10 = self._heading_cdeg = 0
        self._sent_s = self._sent_us = 0

    def encode(self, number, values):
        buffer = self.buffer
        if number == m.MARKER:
            frame = values[_MARKER_FRAME]
            if not self._is_target_sent or values[_MARKER_FLAGS] & _UNUSABLE or frame == self._target_frame:
                return 0
            self._target_frame = frame
            self._clear(60)
            self._landing_target(values)
            return self._finish(_LANDING_TARGET, 60, 200)
        if number == m.POSE:
            if values[_POSE_STATE] != m.TRACKING:
                self._is_lost = self._is_lost or values[_POSE_STATE] == m.LOST
                return 0
            if self._is_lost or self._has_jumped(values):
                self._resets = (self._resets + 1) & 0xFF
                self._is_lost = False
            self._remember(values)
            self._clear(117)
            self._vision_position(values)
            return self._finish(_VISION_POSITION_ESTIMATE, 117, 158)
        if number == m.STATUS:
            self._clear(9)
            buffer[_HEADER + 4] = _TYPE_ONBOARD_CONTROLLER
            buffer[_HEADER + 5] = _AUTOPILOT_INVALID
            active = values[_STATUS_STATE] != m.LOST
            buffer[_HEADER + 7] = _STATE_ACTIVE if active else _STATE_STANDBY
            buffer[_HEADER + 8] = 3  # MAVLink version
            return self._finish(_HEARTBEAT, 9, 50)
        return 0

    def _remember(self, values):
        self._is_sent = True
        self._x_mm10, self._y_mm10 = values[_POSE_X_MM10], values[_POSE_Y_MM10]
        self._heading_cdeg = values[_POSE_HEADING_CDEG]
        self._sent_s, self._sent_us = self._uptime.s, self._uptime.us

    def _has_jumped(self, values):
        """Whether the vehicle cannot have come there: it was moved, or the markers before were misread."""
        if not self._is_sent:
            return False
        uptime = self._uptime
        passed_s = uptime.s - self._sent_s
        if not 0 <= passed_s <= 100:
            passed_s = 100  # and any way is possible
        passed_ms = passed_s * 1000 + (uptime.us - self._sent_us) // 1000
        reach_q2 = _JUMP_MM10 + self._max_speed_mm_s * passed_ms // 50 >> 2  # twice the speed
        if abs((values[_POSE_X_MM10] >> 2) - (self._x_mm10 >> 2)) > reach_q2:  # within 30 bits
            return True
        if abs((values[_POSE_Y_MM10] >> 2) - (self._y_mm10 >> 2)) > reach_q2:
            return True
        turned_cdeg = abs(wrap_cdeg(values[_POSE_HEADING_CDEG] - self._heading_cdeg))
        return turned_cdeg > _JUMP_CDEG + _TURN_CDEG_PER_MS * passed_ms

    def _clear(self, size):
        for k in range(_HEADER + size):
            self.buffer[k] = 0

    def _landing_target(self, values):
        buffer = self.buffer
        # x, y, z are said as of a camera that looks up: left is right for one that looks down, up is down
        x, y, z = values[_MARKER_X_MM10], values[_MARKER_Y_MM10], abs(values[_MARKER_Z_MM10])
        self._put_time(values[_MARKER_AGE_US])
        _put_angle(buffer, 18, atan2_turn16(y >> 2, z >> 2))  # image x: to the right; atan2 takes 22 bits
        _put_angle(buffer, 22, atan2_turn16(-x >> 2, z >> 2))  # image y: backwards
        put_float32(buffer, 26, _length(x, y, z), 10000)
        # size_x, size_y: 0, not told
        buffer[38] = min(255, values[_MARKER_ID])  # target_num has 8 bits
        buffer[39] = _FRAME_BODY_FRD
        put_float32(buffer, 40, x, 10000)
        put_float32(buffer, 44, y, 10000)
        put_float32(buffer, 48, z, 10000)
        heading = values[_MARKER_HEADING_CDEG]
        half_turn16 = (heading * 4096 + 2250) // 4500  # half of the heading, clockwise as z points down
        put_float32(buffer, 52, cos_q14(half_turn16), 16384)
        put_float32(buffer, 64, sin_q14(half_turn16), 16384)
        buffer[68] = _TARGET_VISION_FIDUCIAL
        buffer[69] = self._is_position_sent  # position_valid; PX4 reads the angles, and BODY_FRD never

    def _vision_position(self, values):
        buffer = self.buffer
        self._put_time(values[_POSE_AGE_US])
        put_float32(buffer, 18, values[_POSE_X_MM10], 10000)
        put_float32(buffer, 22, -values[_POSE_Y_MM10], 10000)
        heading = values[_POSE_HEADING_CDEG]
        if heading > 18000:
            heading -= 36000
        # 0.01 degrees are 174.5329 millionths of a radian
        put_float32(buffer, 38, -heading * 174 - heading * 5329 // 10000, 1000000)
        sigma_x, sigma_y = values[_POSE_SIGMA_X_MM10], values[_POSE_SIGMA_Y_MM10]
        sigma_cdeg = values[_POSE_SIGMA_CDEG]
        buffer[_RESET_COUNTER] = self._resets
        if max(sigma_x, sigma_y, sigma_cdeg) == m.SIGMA_UNKNOWN:
            put_nan32(buffer, _COVARIANCE)
            return
        _put_variance(buffer, 0, sigma_x)
        _put_covariance(buffer, 1, sigma_x, sigma_y, -values[_POSE_CORRELATION_Q14])
        _put_variance(buffer, 6, sigma_y)
        # z, roll and pitch are 0 on a level floor; ArduPilot adds their variances to those of x, y and yaw
        _put_variance(buffer, 11, max(sigma_x, sigma_y))
        sigma = min(31416, sigma_cdeg * 1745 // 1000)
        for index in (15, 18, 20):
            _put_variance(buffer, index, sigma)

    def _put_time(self, age_us):
        """The time of the exposure, microseconds since start: 64 bits, byte by byte to stay within 30.

        The age is that at the start of sending, which lies ahead of the uptime."""
        seconds = self._uptime.s - age_us // 1000000
        micros = self._uptime.us + self._uptime.ahead_us - age_us % 1000000
        while micros < 0:
            micros += 1000000
            seconds -= 1
        while micros >= 1000000:
            micros -= 1000000
            seconds += 1
        if seconds < 0:
            seconds = micros = 0
        buffer = self.buffer
        for k in range(8):
            micros += (seconds & 0xFF) * 1000000
            buffer[_HEADER + k] = micros & 0xFF
            micros >>= 8
            seconds >>= 8

    def _finish(self, message_id, size, extra):
        buffer = self.buffer
        while size > 1 and buffer[_HEADER + size - 1] == 0:
            size -= 1  # MAVLink 2 leaves out the zeros at the end
        buffer[0] = 0xFD
        buffer[1] = size
        buffer[4] = self.sequence
        buffer[5] = self._system
        buffer[6] = self._component
        buffer[7] = message_id
        self.sequence = (self.sequence + 1) & 0xFF
        end = _HEADER + size
        crc = x25(buffer, 1, end, extra)
        buffer[end] = crc & 0xFF
        buffer[end + 1] = crc >> 8
        return end + 2


def _put_angle(buffer, place, turn16):
    """An angle in 1/65536 turn as radians, -pi..pi."""
    if turn16 >= 32768:
        turn16 -= 65536
    # 2 pi / 65536 is 95.87380 millionths
    put_float32(buffer, place, turn16 * 95 + turn16 * 8738 // 10000, 1000000)


def _put_variance(buffer, index, sigma_e4):
    """The square of a standard deviation in 1/10000 m or rad as a diagonal item; never 0."""
    place = _COVARIANCE + 4 * index
    if sigma_e4 < 16384:
        put_float32(buffer, place, max(1, sigma_e4 * sigma_e4 >> 3), 12500000)
    else:
        put_float32(buffer, place, (sigma_e4 >> 3) * (sigma_e4 >> 3), 1562500)


def _put_covariance(buffer, index, a_e4, b_e4, correlation_q14):
    """The covariance of two errors of standard deviations in 1/10000 m as an item off the diagonal."""
    denominator = 12500000
    if max(a_e4, b_e4) < 16384:
        product = a_e4 * b_e4 >> 3
    else:
        product = (a_e4 >> 3) * (b_e4 >> 3)
        denominator = 1562500
    shift = 14
    while product > 32767:
        product >>= 1
        shift -= 1
    size = product * abs(correlation_q14) >> shift
    put_float32(buffer, _COVARIANCE + 4 * index, -size if correlation_q14 < 0 else size, denominator)


def _length(x, y, z):
    """Length of a vector of up to 2**20 each, to 1/2048 of its size, within 30 bits."""
    shift = 0
    while abs(x) > 16383 or abs(y) > 16383 or abs(z) > 16383:
        x >>= 1
        y >>= 1
        z >>= 1
        shift += 1
    return isqrt(x * x + y * y + z * z) << shift
