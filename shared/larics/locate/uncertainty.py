"""What calibration, map and odometry may be wrong by: the numbers that sigma is made of, in integers.

Errors of calibration and map are the same in every frame under a marker, so that no scatter shows them and no
mean removes them; those of odometry grow with the way. All are standard deviations that settings tell.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith.fixed import isqrt

_FAR_MM10 = const(100000)  # 10 m: products stay within 30 bits
_MOST_MM10 = const(10000)  # of each part: the sum of the squares does, too
_CDEG_PER_RAD = const(5730)
_USUAL_NOISE = const(2500)  # mm2/km, the unit of OdometryNoise.noise_q4
_USUAL_TRACK_MM = const(300)
_NO_NOISE_Q4 = const(-192)
_MOST = const(1 << 24)  # of what is multiplied


class Systematic:
    """Standard deviations of what does not scatter, in the units of their names; lens_mm10: how high the lens
    is in the vehicle frame."""

    def __init__(
        self, map_mm10=10, map_cdeg=10, focal_ppm=1000, height_mm10=30, tilt_cdeg=5, mount_cdeg=5,
        camera_mm10=10, lens_mm10=0,
    ):  # fmt: skip
        self._map_mm10 = map_mm10
        self._map_cdeg = map_cdeg
        self._focal_ppm = focal_ppm
        self._height_mm10 = height_mm10
        self._tilt_cdeg = tilt_cdeg
        self._mount_cdeg = mount_cdeg
        self._camera_mm10 = camera_mm10
        self._lens_mm10 = lens_mm10
        self._known_height_mm10 = self._known_map_mm10 = self._known_map_cdeg = -1
        self._square_here = self._slope_q16 = (
            0  # of an entry: the square of what does not depend on the distance
        )
        # to the marker, and what does, per distance

    def of_place(self, measurement, map_mm10=0, map_cdeg=0):
        """Of the place that a Measurement of an entry gives, along x and along y, 0.1 mm. map_mm10, map_cdeg:
        of this entry, 0 for the usual ones."""
        if (
            measurement.height_mm10 != self._known_height_mm10
            or map_mm10 != self._known_map_mm10
            or map_cdeg != self._known_map_cdeg
        ):
            self._know(measurement.height_mm10, map_mm10, map_cdeg)
        x, y = abs(measurement.offset_x_mm10), abs(measurement.offset_y_mm10)
        away = min(_FAR_MM10, max(x, y) + (min(x, y) >> 1))
        return isqrt(self._square_here + self._square((away >> 2) * self._slope_q16 + 8192 >> 14))

    def _know(self, height_mm10, map_mm10, map_cdeg):
        """Works out what holds for this height and entry."""
        self._known_height_mm10, self._known_map_mm10 = height_mm10, map_mm10
        self._known_map_cdeg = map_cdeg
        above = min(2 * _FAR_MM10, max(1, height_mm10 - self._lens_mm10))
        here = self._square(map_mm10 or self._map_mm10) + self._square(self._camera_mm10)
        self._square_here = here + self._square(above * self._tilt_cdeg // _CDEG_PER_RAD)
        focal_q16 = self._focal_ppm * 64 // 977
        height_q16 = min(1 << 14, (self._height_mm10 << 16) // above)
        turn_q16 = min(1 << 14, (max(map_cdeg or self._map_cdeg, self._mount_cdeg) << 16) // _CDEG_PER_RAD)
        slope = focal_q16 * focal_q16 + height_q16 * height_q16 + turn_q16 * turn_q16
        self._slope_q16 = isqrt(slope)

    def of_heading(self, map_cdeg=0):
        """Of the heading, 0.01 degrees."""
        map_cdeg = map_cdeg or self._map_cdeg
        return root_of_squares(map_cdeg, self._mount_cdeg)

    def _square(self, part_mm10):
        part_mm10 = min(_MOST_MM10, part_mm10)
        return part_mm10 * part_mm10


def root_of_squares(one, other):
    """The standard deviation of a sum of two errors, each at most 20,000; rounded, since a hundredth of a
    degree is a tenth of the usual one."""
    square = one * one + other * other
    root = isqrt(square)
    return root + 1 if square - root * root > root else root


@micropython.native
def log2_q4(value, unit):
    """16 times the binary logarithm of value / unit, to 1.4; both below 2**20. Of 0: _NO_NOISE_Q4."""
    if value <= 0:
        return _NO_NOISE_Q4
    whole = 0
    while value >= 2 * unit:
        unit <<= 1
        whole += 16
    while value < unit:
        value <<= 1
        whole -= 16
    return max(_NO_NOISE_Q4, whole + ((value - unit) << 4) // unit)


def _share_q20(ppm):
    return ppm * 4295 // 4096


@micropython.native
def times_q4(value, log2_q4):
    """value (below 2**25) times 2**(log2_q4 / 16), to 1.06, at most _MOST."""
    value = value * (16 + (log2_q4 & 15)) >> 4
    whole = log2_q4 >> 4
    if whole <= 0:
        return min(_MOST, value >> min(30, -whole))
    while whole and value < _MOST:
        value <<= 1
        whole -= 1
    return min(_MOST, value)


class OdometryNoise:
    """The model of two wheels: what is known to be wrong with the odometry, how well, and how it scatters.

    scale_ppm, turn_ppm, drift_mdeg_m   the way, the turn and the turn a way that it leaves out
    *_sigma_*                           their standard deviations
    noise_mm2_km, speed_noise_us        variance of a wheel's way per way, and per way and speed
    track_mm                            between the wheels
    """

    def __init__(
        self, scale_ppm=0, turn_ppm=0, drift_mdeg_m=0, scale_sigma_ppm=7000, turn_sigma_ppm=7000,
        drift_sigma_mdeg_m=2700, noise_mm2_km=2500, speed_noise_us=240, track_mm=300,
    ):  # fmt: skip
        self.scale_q20 = _share_q20(scale_ppm)
        self.turn_q20 = _share_q20(turn_ppm)
        self.drift_q20 = drift_mdeg_m * 1830 // 100  # mrad/mm: 0.001 deg/m is 18.3 of them
        self.scale_sigma_q20 = _share_q20(scale_sigma_ppm)
        self.turn_sigma_q20 = _share_q20(turn_sigma_ppm)
        self.drift_sigma_q20 = drift_sigma_mdeg_m * 1830 // 100
        self.noise_q4 = log2_q4(noise_mm2_km, _USUAL_NOISE)
        self.speed_noise_us = speed_noise_us
        self.half_track_mm = max(1, track_mm // 2)
        self.track_q4 = 2 * log2_q4(_USUAL_TRACK_MM, track_mm)

    def at_speed_q4(self, speed_mm_s):
        """Binary logarithm of the noise at a speed, up to 8 m/s, against the usual one."""
        if not self.speed_noise_us:
            return self.noise_q4
        hasty_q4 = log2_q4(self.speed_noise_us * speed_mm_s >> 7, _USUAL_NOISE >> 7)
        return max(self.noise_q4, hasty_q4) + (16 if abs(self.noise_q4 - hasty_q4) < 8 else 0)
