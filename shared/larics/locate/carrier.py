"""The pose carried from marker to marker by the vehicle's odometry, with its covariance, in integers.

A marker sets pose and covariance; each way and turn since moves the pose and lets the covariance grow by a
model of two wheels: noise in proportion to the way, and two systematic shares, of the scale and of drift in
turn per way. All three are learned from how far the next marker lies off: encoders that do not see what the
wheels do make the noise a hundred times larger. What is known beforehand is larics.locate.uncertainty's.

Way is in 0.1 mm Q4, heading in 0.01 degrees Q6, covariance in mm2 Q4, mm mrad Q5 and mrad2 Q8, shares in Q20;
every intermediate stays within 30 bits. Nothing is allocated.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import cos_q14, isqrt, sin_q14, turn16_from_cdeg, wrap_cdeg
from larics.locate.odometry import length
from larics.locate.uncertainty import log2_q4
from larics.wire.messages import WAY_UNKNOWN

_STEP_MM10 = const(640)  # of way, after which the covariance grows
_WAY_NOISE_Q20 = const(2097)  # 0.0025 mm2 of variance a mm of way and wheel, OdometryNoise's unit
_TURN_NOISE_Q16 = const(93207)  # ... with a track of 300 mm
_LOUDEST_Q4 = const(160)  # the noise at most 2**10 times that
_DOUBTED_Q4 = const(144)  # more than any wheels make: a wrong unit, sign or axis
_MOST_ADDED = const(1 << 24)  # to a variance at once
_ABSURD_Q4 = const(112)  # eleven sigma are no slip
_MOST = const(1 << 25)  # 1.4 m ...
_MOST_TURN = const(1 << 27)  # ... and 41 degrees: products stay within 30 bits
_LEARN_MM10 = const(3000)  # a shorter way teaches nothing
_MOST_MM10 = const(7000)  # of one increment


def scaled_q14(value, factor_q14):
    """value * factor / 2**14 for |value| < 2**30, |factor| <= 2**14."""
    return (value >> 14) * factor_q14 + ((value & 16383) * factor_q14 >> 14)


def _mrad_q4(cdeg):
    return (cdeg << 4) * 2860 >> 14


def _times_q4(value, log2_q4):
    """value (below 2**24) times 2**(log2_q4 / 16), to 1.06, at most _MOST_ADDED."""
    value = value * (16 + (log2_q4 & 15)) >> 4
    whole = log2_q4 >> 4
    if whole <= 0:
        return min(_MOST_ADDED, value >> min(30, -whole))
    while whole and value < _MOST_ADDED:
        value <<= 1
        whole -= 1
    return min(_MOST_ADDED, value)


class Carrier:
    """`fix` with each marker, `move` with the odometry of each frame. noise: uncertainty.OdometryNoise.

    begun                           whether there was any odometry
    known                           whether there is a pose to carry
    x_mm10, y_mm10, heading_cdeg    after `move`
    sigma_x_mm10, sigma_y_mm10, sigma_cdeg, correlation_q14
    doubted                         whether the odometry contradicts the markers by more than any noise
    way_mm                          since the marker, at most WAY_UNKNOWN
    """

    def __init__(self, noise):
        self._model = noise
        self.known = False
        self.x_mm10 = self.y_mm10 = self.heading_cdeg = 0
        self.sigma_x_mm10 = self.sigma_y_mm10 = self.sigma_cdeg = self.correlation_q14 = 0
        self.way_mm = 0
        self.doubted = False
        self._scale_q20, self._scale_sigma_q20 = noise.scale_q20, noise.scale_sigma_q20
        self._drift_q20, self._drift_sigma_q20 = noise.drift_q20, noise.drift_sigma_q20
        self._noise_q4 = noise.noise_q4
        self._certain_mm10 = self._certain_cdeg = 0  # systematic, of the marker's place and heading
        self._epoch = self._jumps = -1
        self.begun = False
        self._last_x = self._last_y = self._last_heading = 0
        self._x0 = self._y0 = self._heading_q6 = 0
        self._rx = self._ry = self._px = self._py = 0
        self._way = self._since = 0
        self._xx = self._xy = self._yy = self._xt = self._yt = self._tt = 0
        self._a = self._b = 0

    def fix(self, x_mm10, y_mm10, heading_cdeg, sigma_mm10, sigma_cdeg, systematic_mm10, systematic_cdeg):
        """A marker put the vehicle there, with that scatter, and with what does not scatter."""
        self._certain_mm10 = min(systematic_mm10, 10000)
        self._certain_cdeg = min(systematic_cdeg, 3000)
        if self.known and self._way > _LEARN_MM10:
            self._learn(x_mm10, y_mm10, heading_cdeg)
        self._x0, self._y0 = x_mm10, y_mm10
        self._heading_q6 = heading_cdeg << 6
        self._rx = self._ry = self._px = self._py = 0
        self._way = self._since = 0
        sigma_mm10, sigma_cdeg = min(sigma_mm10, 10000), min(sigma_cdeg, 3000)
        variance = self._certain_mm10 * self._certain_mm10 + sigma_mm10 * sigma_mm10
        self._xx = self._yy = variance // 100 << 4 if variance > 1 << 25 else (variance << 4) // 100
        self._xy = self._xt = self._yt = 0
        one, other = _mrad_q4(self._certain_cdeg), _mrad_q4(sigma_cdeg)
        self._tt = one * one + other * other
        self._a = self._b = 0
        self.known = True
        self._tell()

    def move(self, odometry):
        """Carries the pose on to the odometry's; False when that has jumped, so that nothing is known."""
        if odometry.epoch != self._epoch or odometry.jumps != self._jumps or not self.begun:
            self._epoch, self._jumps = odometry.epoch, odometry.jumps
            self.begun = True
            self.known = False
        else:
            self._carry(odometry)
        self._last_x, self._last_y = odometry.x_mm10, odometry.y_mm10
        self._last_heading = odometry.heading_cdeg
        if self.known:
            self._tell()
        return self.known

    def _carry(self, odometry):
        dx, dy = odometry.x_mm10 - self._last_x, odometry.y_mm10 - self._last_y
        turn_cdeg = wrap_cdeg(odometry.heading_cdeg - self._last_heading)
        if abs(dx) > 100000 or abs(dy) > 100000:  # 10 m between two frames: no way for a covariance
            self.known = False
            return
        middle = turn16_from_cdeg(self._last_heading + turn_cdeg // 2)
        sin, cos = sin_q14(middle), cos_q14(middle)
        forward = scaled_q14(dx << 4, cos) + scaled_q14(dy << 4, sin)
        left = scaled_q14(dy << 4, cos) - scaled_q14(dx << 4, sin)
        parts = 1 + (abs(forward) + abs(left)) // (_MOST_MM10 << 4)
        for k in range(parts):  # long increments in pieces, so that the covariance follows the way
            self._advance(
                forward * (k + 1) // parts - forward * k // parts,
                left * (k + 1) // parts - left * k // parts,
                turn_cdeg * (k + 1) // parts - turn_cdeg * k // parts,
            )

    def _advance(self, forward, left, turn_cdeg):
        """An increment in the vehicle frame: 0.1 mm Q4, 0.01 degrees."""
        forward_mm10 = forward >> 4
        forward += scaled_q14(forward, self._scale_q20 >> 6)
        left += scaled_q14(left, self._scale_q20 >> 6)
        turn_q6 = turn_cdeg << 6
        turn_q6 += scaled_q14(turn_q6, self._model.turn_q20 >> 6)
        turn_q6 += ((self._drift_q20 >> 4) * forward_mm10 >> 10) * 37 >> 6
        middle = turn16_from_cdeg(self._heading_q6 + turn_q6 // 2 >> 6)
        sin, cos = sin_q14(middle), cos_q14(middle)
        dx = scaled_q14(forward, cos) - scaled_q14(left, sin)
        dy = scaled_q14(forward, sin) + scaled_q14(left, cos)
        self._rx += dx
        self._ry += dy
        self._px += dx
        self._py += dy
        self._heading_q6 = (self._heading_q6 + turn_q6) % 2304000
        way = max(abs(forward_mm10), abs(turn_cdeg) * self._model.half_track_mm // 573)
        self._way = min(1 << 24, self._way + way)
        self._since += way
        if self._since >= _STEP_MM10:
            self._grow()

    def _grow(self):
        if max(self._xx, self._yy) > _MOST or self._tt > _MOST_TURN:
            self._since = self._px = self._py = 0
            return  # it is of no use any more
        mx = max(-16384, min(16384, (max(-160000, min(160000, self._px)) >> 4) * 26843 >> 14))
        my = max(-16384, min(16384, (max(-160000, min(160000, self._py)) >> 4) * 26843 >> 14))
        since = min(self._since, 11000)
        added = _times_q4(since * _WAY_NOISE_Q20 >> 10, self._noise_q4) >> 10
        turned = _times_q4(since * _TURN_NOISE_Q16 >> 14, self._noise_q4 + self._model.track_q4) >> 2
        way_mm = min(self._way // 10, 20000)  # further, the systematic shares grow no more: it is lost before
        a = self._scale_sigma_q20 * way_mm >> 16
        b = self._drift_sigma_q20 * way_mm >> 16
        a, b = min(a, 32767), min(b, 32767)
        added += (a * a >> 4) - (self._a * self._a >> 4)
        turned += b * b - self._b * self._b
        self._a, self._b = a, b
        self._tt += turned >> 1
        xt, yt = self._xt, self._yt
        self._xt = xt - (scaled_q14(self._tt, my) >> 3)
        self._yt = yt + (scaled_q14(self._tt, mx) >> 3)
        self._xx += added - (scaled_q14(xt + self._xt, my) >> 1)
        self._yy += added + (scaled_q14(yt + self._yt, mx) >> 1)
        self._xy += (scaled_q14(self._xt, mx) >> 1) - (scaled_q14(yt, my) >> 1)
        self._tt += turned - (turned >> 1)
        self._since = 0
        self._px = self._py = 0

    def _tell(self):
        self.x_mm10 = self._x0 + (self._rx >> 4)
        self.y_mm10 = self._y0 + (self._ry >> 4)
        self.heading_cdeg = (self._heading_q6 >> 6) % 36000
        root_x, root_y = isqrt(max(1, self._xx) << 2), isqrt(max(1, self._yy) << 2)  # mm Q3
        self.sigma_x_mm10 = root_x * 10 + 15 >> 3
        self.sigma_y_mm10 = root_y * 10 + 15 >> 3
        self.sigma_cdeg = (isqrt(max(1, self._tt)) * 358 + 999) // 1000  # 1 mrad Q4 is 0.358 of 0.01 degrees
        xy, both = self._xy, root_x * root_y >> 2
        while abs(xy) > 65535:
            xy >>= 1
            both >>= 1
        self.correlation_q14 = max(-16384, min(16384, (xy << 14) // max(1, both)))
        self.way_mm = min(WAY_UNKNOWN, self._way // 10)

    def _hear_noise(self, dx, dy, turn_q4):
        """How far the marker is off, in squares of the sigma: the noise follows, slowly, so that a single
        slip or a moved marker changes little."""
        dx, dy = min(20000, abs(dx)), min(20000, abs(dy))
        marker = self._certain_mm10 * self._certain_mm10 // 25 << 2
        square_q4 = dx * dx // 25 * 64 // (self._xx + marker) + dy * dy // 25 * 64 // (self._yy + marker)
        # the mean logarithm of such a square is -0.5
        surprise_q4 = max(-64, log2_q4(min(1 << 19, (square_q4 + turn_q4) // 3), 16)) + 8
        step_q4 = max(-4, min(48 if surprise_q4 > _ABSURD_Q4 else 20, surprise_q4 // 3))
        self._noise_q4 = max(self._model.noise_q4, min(_LOUDEST_Q4, self._noise_q4 + step_q4))
        self.doubted = self._noise_q4 >= _DOUBTED_Q4

    def _learn(self, x_mm10, y_mm10, heading_cdeg):
        """The shares of scale and drift, from how far the marker is off."""
        self._grow()
        self._tell()
        off_cdeg = max(-6000, min(6000, wrap_cdeg(heading_cdeg - self.heading_cdeg)))
        off = (off_cdeg << 4) * 2860 >> 14  # mrad Q4
        way_mm = min(self._way // 10, 20000)
        one = _mrad_q4(self._certain_cdeg)
        total = self._tt + one * one
        self._hear_noise(x_mm10 - self.x_mm10, y_mm10 - self.y_mm10, off * off // max(1, total >> 4))
        if off * (off >> 3) < 9 * (total >> 3):
            variance = (self._drift_sigma_q20 >> 4) * (self._drift_sigma_q20 >> 4) >> 16
            gain = 1 << 14
            if variance * way_mm < 1 << 28:
                gain = min(gain, (variance * way_mm << 2) // max(1, total >> 6))
            self._drift_q20 = max(-(1 << 18), min(1 << 18, self._drift_q20 + gain * off))
            share = min(4096, gain * way_mm >> 4)
            square = (self._drift_sigma_q20 >> 2) * (self._drift_sigma_q20 >> 2)
            self._drift_sigma_q20 = max(64, isqrt(max(0, square - scaled_q14(square, share << 2))) << 2)
        ahead, aside = self._rx >> 4, self._ry >> 4
        if abs(ahead) > 120000 or abs(aside) > 120000:
            return
        distance = length(ahead, aside)
        if distance <= _LEARN_MM10:
            return
        ux, uy = (ahead << 12) // distance, (aside << 12) // distance
        dx, dy = x_mm10 - self.x_mm10, y_mm10 - self.y_mm10
        if abs(dx) > 20000 or abs(dy) > 20000:
            return
        along = dx * ux + dy * uy >> 12
        cc, ss, cs = ux * ux >> 10, uy * uy >> 10, ux * uy >> 10
        total = scaled_q14(self._xx, cc) + 2 * scaled_q14(self._xy, cs) + scaled_q14(self._yy, ss)
        total = max(1, total + (self._certain_mm10 * self._certain_mm10 // 25 << 2))
        if along * along // 100 < 9 * (total >> 4):
            spread = self._scale_sigma_q20 * (distance // 10) >> 14  # mm Q6
            share = min(256, spread * spread // total)
            moved = self._scale_q20 + share * ((along << 12) // distance)
            self._scale_q20 = max(-(1 << 16), min(1 << 16, moved))
            square = self._scale_sigma_q20 * self._scale_sigma_q20
            self._scale_sigma_q20 = max(64, isqrt(square // 256 * (256 - share)))
