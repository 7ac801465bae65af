"""The centre of a marker from both rings at once, little moved by what disturbs a part of one, and its sigma.

The harmonics of `ring_fit` take each ring for itself, and the correction for perspective takes up, times 1.3,
whatever disturbs one of them: a cable across, a torn edge, a shadow's border. Here both rings share centre,
radius, ellipse and, as far as it is no more than noise, the difference of their centres.

Most limits are comparisons here: a call of min or max takes as many instructions as ten of them.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith import tables
from larics.kernels import robust as kernels

_LEAST = const(14)  # sectors of both rings
_ROUNDS = const(4)
_CAREFUL = const(2)  # of them, before outliers are left out
_NEARLY_ALL = const(28)  # sectors
_QUIET = const(40)  # mean deviation, 1/1024 px
_SETTLED = const(64)  # a later step moves a parameter by no more: 1/16384 px
_PRIOR_Q10 = const(31)  # of half the difference of the centres, at 30 px of radius; grows with its square
_RATIO_SQUARE = const(23716)  # of the inner radius: (154 / 1024 px) ** 2
_SHARE_MOST = const(4095)  # of a sector's variance
_MOST_Q10 = const(1024)  # that a fit may move the centre
_BIAS = const(1 << 24)  # items as in kernels.layouts
_FIT_X_Q8 = const(0)
_FIT_Y_Q8 = const(1)
_FIT_INNER_Q10 = const(16)
_FIT_BEYOND_Q8 = const(19)
_RING_DEVIATION = const(5)
_ROBUST_PARAMETERS = const(128)
_ROBUST_SCALE = const(236)
_ROBUST_SQUARE = const(238)


class RobustCentre:
    """Fits one candidate at a time.

    x_q10, y_q10      the marker's projected centre, 1/1024 px
    middle_x_q10, middle_y_q10   the mean of the rings' centres
    variance          of the centre along each axis, as far as the residuals tell: (1/1024 px) ** 2
    square            mean square of what the fit leaves of the sectors, likewise
    work              array of at least kernels.layouts: ROBUST items, scratch space
    """

    def __init__(self, work):
        self.work = work
        self.x_q10 = self.y_q10 = self.middle_x_q10 = self.middle_y_q10 = self.variance = self.square = 0

    @micropython.native
    def fit(self, rings):
        """Fits the sectors of a RingFit's last pass; False when they do not determine the centre.

        Then the variance is that of the harmonics."""
        deviation = (rings.outer[_RING_DEVIATION] + rings.inner[_RING_DEVIATION]) * 5 >> 3
        if deviation > 1024:
            deviation = 1024
        self.square = self.variance = deviation * deviation
        work = self.work
        pose = rings.fit
        ratio = pose[_FIT_INNER_Q10]
        seen = kernels.begin_robust(work, pose, rings.outer_means, rings.inner_means)
        if seen < _LEAST:
            return False
        radius_q4 = rings.radius_q8 >> 4
        prior = _PRIOR_Q10 * radius_q4 // 480 * radius_q4 // 960
        if not prior:
            prior = 1
        # where nearly all sectors lie close to the harmonics, one step from there will do before the last one
        quiet = seen >= _NEARLY_ALL and deviation <= _QUIET
        for turn in range(_CAREFUL if quiet else 0, _ROUNDS):
            kind = 0 if turn == 0 else 1 if turn < _CAREFUL else 2
            if kernels.weigh_sectors(0, 0, 0, work, tables.SECTOR_WAVES, ratio, kind) < 64 * _LEAST >> 1:
                return False
            scale = work[_ROBUST_SCALE]
            square = scale * scale << 8
            ratio_weight = square // _RATIO_SQUARE
            if ratio_weight > 4095:
                ratio_weight = 4095
            apart = 0
            if turn < _CAREFUL:
                # at first a difference of the centres is not to take up what disturbs one ring
                apart = min(8191, square // (prior * prior * 16))
            kernels.normal_equations(work, 0, 0, ratio, ratio_weight, apart)
            if not kernels.factor_matrix(0, 0, 0, work):
                return False
            moved = kernels.solve_step(0, 0, 0, work)
            if turn >= _CAREFUL and (quiet or moved <= _SETTLED):
                break
        return self._finish(work, pose, prior, ratio, ratio_weight)

    @micropython.native
    def _finish(self, work, pose, prior, ratio, ratio_weight):
        """Believes the difference of the centres as far as it exceeds its noise, and tells the variance."""
        weight = kernels.weigh_sectors(0, 0, 0, work, tables.SECTOR_WAVES, ratio, 2)
        # eight parameters are fitted
        weight -= 6 * 64
        square = work[_ROBUST_SQUARE] * 64 // (weight if weight > 64 else 64)
        if square > 1 << 17:
            square = 1 << 17
        elif square < 16:
            square = 16
        apart_x = (work[_ROBUST_PARAMETERS + 4] - _BIAS) >> 4
        apart_y = (work[_ROBUST_PARAMETERS + 5] - _BIAS) >> 4
        share = kernels.variance_of(0, 0, 0, work, 4, 0)
        noise = square * (share if share < _SHARE_MOST else _SHARE_MOST) >> 12
        signal = ((apart_x * apart_x + apart_y * apart_y) >> 1) - noise
        least = prior * prior
        apart_weight = (square << 8) // (signal if signal > least else least)
        if apart_weight > 8191:
            apart_weight = 8191
        kernels.normal_equations(work, 0, 0, ratio, ratio_weight, apart_weight)
        if not kernels.factor_matrix(0, 0, 0, work):
            return False
        kernels.solve_step(0, 0, 0, work)
        beyond = pose[_FIT_BEYOND_Q8]
        x = self._moved(work, 2, beyond)
        y = self._moved(work, 3, beyond)
        if x > _MOST_Q10 or x < -_MOST_Q10 or y > _MOST_Q10 or y < -_MOST_Q10:
            return False
        self.x_q10 = (pose[_FIT_X_Q8] << 2) + x
        self.y_q10 = (pose[_FIT_Y_Q8] << 2) + y
        self.middle_x_q10 = (pose[_FIT_X_Q8] << 2) + self._moved(work, 2, 0)
        self.middle_y_q10 = (pose[_FIT_Y_Q8] << 2) + self._moved(work, 3, 0)
        spread = kernels.variance_of(0, 0, 0, work, 2, beyond) + kernels.variance_of(0, 0, 0, work, 3, beyond)
        share = spread >> 3
        self.variance = square * (share if share < _SHARE_MOST else _SHARE_MOST) >> 10
        self.square = square
        return True

    @micropython.native
    def _moved(self, work, axis, beyond):
        """The centre along an axis: that of the rings, and what lies beyond it, 1/1024 px."""
        middle = work[_ROBUST_PARAMETERS + axis] - _BIAS
        apart = work[_ROBUST_PARAMETERS + axis + 2] - _BIAS
        return ((middle + (apart * beyond >> 7)) * 127 >> 7) >> 4
