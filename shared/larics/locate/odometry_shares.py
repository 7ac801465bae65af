"""What the vehicle's odometry leaves out, learned between two markers or under one, in integers.

Three shares: of the way (scale), of the turn (track) and of turn per way (drift). Each is the slope of a
regression, over what odometry told, of what it missed by the markers, with a prior from the settings. Beside
them: whether odometry and markers fit each other at all. A wrong unit, sign or axis does not; neither does a
vehicle that is lifted, but that is once. Nothing is allocated.
"""

from array import array

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith.fixed import cos_q14, sin_q14, turn16_from_cdeg, wrap_cdeg
from larics.kernels import shares as kernels
from larics.locate.motion import scaled_q14
from larics.locate.odometry import length
from larics.locate.uncertainty import times_q4

_WINDOW_MM10 = const(6000)  # compared under one marker, or this while the noise of the wheels is unknown, ...
_NEAR_MM10 = const(1000)
_LEAST_MM10 = const(3000)  # ... and from one to another
_LEAST_MM = const(80)  # less way, straight ahead, teaches nothing
_TURN_CDEG = const(6000)  # of a turn on the spot that is compared
_FURTHEST_MM10 = const(160000)  # a longer way is not, nor is so much in 0.01 degrees
_MOST_MM = const(16383)
_MOST_VARIANCE = const(1 << 24)
_FINE = const(6)  # bits behind the point of moment and weight: short ways in loud noise weigh less than 1
_APART_MM10 = const(600)  # wheels make no more than so much and a quarter of the way,
_APART_CDEG = const(1000)  # and so much, a quarter of the turn and 6 degrees a metre
_DOUBT = const(4)  # odometry is doubted after two legs that do not fit ...
_BELIEF = const(2)
_MOST_DOUBT = const(6)  # ... and believed after one or two that do

_TREND_VALUE_Q20 = const(6)  # items as in kernels.layouts
_SUMS_FORWARD = const(0)
_SUMS_DRIVEN = const(1)
_SUMS_WAY = const(2)
_SUMS_TURNED = const(3)
_SUMS_ITEMS = const(4)


def mrad_q4(cdeg):
    """Hundredths of a degree, up to half a turn, in mrad Q4."""
    return cdeg * 5719 >> 11


class Share:
    """A slope, Q20, and its standard deviation: value_q20, sigma_q20. items: TREND of kernels.layouts, with
    the sums over legs."""

    def __init__(self, prior_q20, sigma_q20):
        self.value_q20 = self._prior_q20 = prior_q20
        self.sigma_q20 = sigma_q20
        root_q4 = min(1 << 14, (1 << 22) // max(1, sigma_q20))
        # a sixteenth of the variance's inverse, as the weight
        self.items = array("i", (0, 0, _FINE, prior_q20, sigma_q20, root_q4 * root_q4 >> 8, 0, 0))

    def learn(self, told, missed_q4, variance_q8):
        """A window: what odometry told, what more there was by the markers (Q4, beyond the prior), and the
        variance of that at the usual noise (Q8)."""
        kernels.learn_slope(0, 0, self.items, told, missed_q4, variance_q8)

    def settle(self, loud_q4):
        """The slope by all windows, when the noise is 2**(loud_q4 / 16) times the usual."""
        items = self.items
        self.sigma_q20 = kernels.settle_slope(0, 0, items, loud_q4)
        self.value_q20 = items[_TREND_VALUE_Q20]

    def beyond_prior_q4(self, told):
        """What the slope makes of a told way or turn, Q4, and the prior does not."""
        return _product_q4(self.value_q20 - self._prior_q20, told)

    def in_all_q4(self, told):
        """What the slope makes of it in all, Q4."""
        return _product_q4(self.value_q20, told)

    def variance_q8(self, told):
        """Of what it makes of it."""
        sigma_q4 = min(32767, _product_q4(self.sigma_q20, abs(told)))
        return sigma_q4 * sigma_q4


@micropython.native
def _product_q4(slope_q20, told):
    return (slope_q20 >> 5) * max(-_MOST_MM, min(_MOST_MM, told)) >> 11


def apart_mm10(x, y, told_x, told_y, turn_cdeg):
    """How far a way by odometry, turned by turn_cdeg, ends from that by the markers."""
    turn16 = turn16_from_cdeg(turn_cdeg)
    sin, cos = sin_q14(turn16), cos_q14(turn16)
    x -= scaled_q14(told_x, cos) - scaled_q14(told_y, sin)
    y -= scaled_q14(told_x, sin) + scaled_q14(told_y, cos)
    return length(x, y)


class OdometryShares:
    """scale, turn, drift: Share; changed: whether they may be others than before. `sums` take each increment,
    `compare` at each marker; doubted: whether odometry
    contradicts the markers by more than wheels can, for as long as it does. model: OdometryNoise.

    After a `compare` that returned True: way_mm10, driven or turned; missed_q4, by how much the
    turn differed from what the shares make of it, mrad; off_mm10, by how much the way is longer by the
    markers; told_mm, of the way, or 0 after a turn on the spot, and told_mrad."""

    def __init__(self, model):
        self._model = model
        self.scale = Share(model.scale_q20, model.scale_sigma_q20)
        self.turn = Share(model.turn_q20, model.turn_sigma_q20)
        self.drift = Share(model.drift_q20, model.drift_sigma_q20)
        self.changed = True
        self.doubted = False
        self._doubt = 0
        self._noise_q4 = 0
        self._anchored = False
        self._x = self._y = self._heading = 0  # the anchor: by a marker ...
        self._odometry_x = self._odometry_y = self._odometry_heading = 0  # ... and by odometry
        self._entry = -1
        self._scatter_cdeg = 0
        self.sums = array("i", [0] * _SUMS_ITEMS)  # since then, by odometry: of kernels.odometry.advance
        self.way_mm10 = self.missed_q4 = self.off_mm10 = self.told_mm = self.told_mrad = 0

    def forget_anchor(self):
        """Nobody knows the way to the next marker."""
        self._anchored = False

    def settle(self, loud_q4, turn_loud_q4):
        """The noise of ways, and that of turns, is 2**(loud_q4 / 16) times that of the model."""
        self.changed = True
        self.scale.settle(loud_q4)
        self.turn.settle(turn_loud_q4)
        self.drift.settle(turn_loud_q4)

    @micropython.native
    def compare(self, fix, odometry, speed_mm_s, loud_q4, near=False):
        """A marker put the vehicle there, a carrier.Fix: learns when the way or the turn since an earlier one
        says something. loud_q4: binary logarithm of the noise of turns against that of the model at this
        speed; near: short ways say something, too. True when a way or a turn under one marker ended that
        wheels can make."""
        fits = False
        if self._anchored:
            dx, dy = fix.x_mm10 - self._x, fix.y_mm10 - self._y
            window_mm10 = _LEAST_MM10
            if fix.entry == self._entry:
                window_mm10 = _NEAR_MM10 if near else _WINDOW_MM10
                if self.sums[_SUMS_DRIVEN] < window_mm10 and abs(dx) + abs(dy) < window_mm10:
                    if abs(self.sums[_SUMS_TURNED]) < _TURN_CDEG:
                        return False  # as nearly always
            distance = length(dx, dy)
            self.way_mm10 = max(self.sums[_SUMS_WAY], distance)
            self._noise_q4 = self._model.at_speed_q4(speed_mm_s)
            if max(self.way_mm10, abs(self.sums[_SUMS_TURNED])) < _FURTHEST_MM10:
                if max(self.sums[_SUMS_DRIVEN], distance) >= window_mm10:
                    fits = self._compare_way(fix, odometry, loud_q4) and fix.entry == self._entry
                elif fix.entry == self._entry:
                    if abs(self.sums[_SUMS_TURNED]) < _TURN_CDEG:
                        return False
                    fits = self._compare_turn(fix, odometry, loud_q4)
        self._anchored = self.changed = True
        self._x, self._y = fix.x_mm10, fix.y_mm10
        self._heading, self._entry = fix.heading_cdeg, fix.entry
        self._odometry_x, self._odometry_y = odometry.x_mm10, odometry.y_mm10
        self._odometry_heading = odometry.heading_cdeg
        self._scatter_cdeg = fix.scatter_cdeg
        sums = self.sums
        sums[_SUMS_FORWARD] = sums[_SUMS_DRIVEN] = sums[_SUMS_WAY] = sums[_SUMS_TURNED] = 0
        return fits

    def _missed_cdeg(self, fix, odometry):
        turned_cdeg = wrap_cdeg(odometry.heading_cdeg - self._odometry_heading)
        return wrap_cdeg(fix.heading_cdeg - self._heading - turned_cdeg)

    def _judge(self, fits):
        """Counts legs that fit and that do not; returns whether this one does."""
        self._doubt = max(0, min(_MOST_DOUBT, self._doubt + (-2 if fits else 2)))
        if self._doubt >= _DOUBT:
            self.doubted = True
        elif self._doubt <= _BELIEF:
            self.doubted = False
        return fits

    def _heading_variance_q8(self, fix):
        """Of a turn, for other reasons than the odometry's shares."""
        one, other = mrad_q4(min(3000, self._scatter_cdeg)), mrad_q4(min(3000, fix.scatter_cdeg))
        variance = one * one + other * other
        if fix.entry != self._entry:
            certain = mrad_q4(min(3000, fix.certain_cdeg))
            variance += 2 * certain * certain
        noise_q4 = self._noise_q4 + self._model.track_q4
        return min(_MOST_VARIANCE, variance + times_q4(self.sums[_SUMS_WAY] * 91 >> 6, noise_q4))

    def _compare_turn(self, fix, odometry, loud_q4):
        missed_cdeg = self._missed_cdeg(fix, odometry)
        if not self._judge(abs(missed_cdeg) <= _APART_CDEG + (abs(self.sums[_SUMS_TURNED]) >> 2)):
            return False
        told = mrad_q4(max(-90000, min(90000, self.sums[_SUMS_TURNED]))) >> 4
        missed = mrad_q4(missed_cdeg) - self.drift.in_all_q4(self.sums[_SUMS_FORWARD] // 10)
        self.missed_q4 = missed - self.turn.in_all_q4(told)
        self.told_mm, self.told_mrad = 0, told
        variance = self._heading_variance_q8(fix)
        if self._is_usual(self.turn, told, missed, variance, loud_q4):
            prior = self.turn.in_all_q4(told) - self.turn.beyond_prior_q4(told)
            self.turn.learn(told, missed - prior, variance)
            self.turn.settle(loud_q4)
        return True

    @micropython.native
    def _compare_way(self, fix, odometry, loud_q4):
        way_mm10 = self.way_mm10
        missed_cdeg = self._missed_cdeg(fix, odometry)
        told_x, told_y = odometry.x_mm10 - self._odometry_x, odometry.y_mm10 - self._odometry_y
        apart_cdeg = _APART_CDEG + (abs(self.sums[_SUMS_TURNED]) >> 2) + way_mm10 * 6 // 100
        fits = abs(missed_cdeg) <= min(17000, apart_cdeg)
        x, y = fix.x_mm10 - self._x, fix.y_mm10 - self._y
        apart = apart_mm10(x, y, told_x, told_y, self._heading - self._odometry_heading)
        fits = fits and apart <= _APART_MM10 + (way_mm10 >> 2)
        if not self._judge(fits):
            return False
        turned = mrad_q4(max(-90000, min(90000, self.sums[_SUMS_TURNED]))) >> 4
        told = self.sums[_SUMS_FORWARD] // 10
        missed = mrad_q4(missed_cdeg) - self.turn.in_all_q4(turned)
        self.missed_q4 = missed - self.drift.in_all_q4(told)
        self.off_mm10 = length(x, y) - length(told_x, told_y)
        self.told_mm, self.told_mrad = told if abs(told) >= _LEAST_MM else 0, turned
        variance = min(_MOST_VARIANCE, self._heading_variance_q8(fix) + self.turn.variance_q8(turned))
        if abs(told) >= _LEAST_MM and self._is_usual(self.drift, told, missed, variance, loud_q4):
            prior = self.drift.in_all_q4(told) - self.drift.beyond_prior_q4(told)
            self.drift.learn(told, missed - prior, variance)
            self.drift.settle(loud_q4)
        return True

    def learn_scale(self, told, missed_q4, variance_q8, loud_q4):
        """From one marker to the next odometry told so many mm, corrected by all that is known, and missed so
        much of it (mm Q4). Along one marker the camera's own scale would decide."""
        if told >= _LEAST_MM and self._is_usual(
            self.scale, told, missed_q4 + self.scale.in_all_q4(told), variance_q8, loud_q4
        ):
            self.changed = True
            self.scale.learn(told, missed_q4 + self.scale.beyond_prior_q4(told), variance_q8)
            self.scale.settle(loud_q4)

    @micropython.native
    def _is_usual(self, share, told, missed_q4, variance_q8, loud_q4):
        """Whether that is no slip: within four standard deviations of what the share expects."""
        off = min(32767, abs(missed_q4 - share.in_all_q4(told)))
        return off * off >> 4 <= times_q4(variance_q8, loud_q4) + share.variance_q8(told)
