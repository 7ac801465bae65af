"""The blur-model reader on the rings: centre, radius, ellipse and perspective by fitting blurred rings."""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import COSINE
from larics.kernels import polar as kernels
from larics.kernels import sectors as sector_kernels

SAMPLES = const(2048)
MEANS = const(544)

_BIAS = const(1 << 24)  # items as in kernels.layouts
_CIRCLE_X_Q8 = const(0)
_CIRCLE_Y_Q8 = const(1)
_CIRCLE_RADIUS_Q8 = const(2)
_CIRCLE_E1 = const(3)
_CIRCLE_E2 = const(4)
_CIRCLE_HX = const(5)
_CIRCLE_HY = const(6)
_CIRCLE_WIDTH = const(7)
_CIRCLE_HEIGHT = const(8)
_CIRCLE_ITEMS = const(9)
_FAN_ITEMS = const(5)
_SCAN_LEAST = const(3)
_SCAN_LAST = const(4)
_SCAN_ITEMS = const(6)

_DIRECTIONS = const(64)
_DIRECTIONS_FIRST = const(32)  # in the first step
_FIRST = const(13)  # units between which the rings are looked at
_COUNT = const(16)
_COARSE_SIGMA = const(10)  # entries of blur.SIGMAS
_COARSE_SIGMA_SMALL = const(12)
_SMALL_Q8 = const(3000)
# smallest squared correlation of a sector that counts, 1/1024: coarsely, in the first step, later, as a ring
_COARSE_MATCH = const(150)
# a coarse look goes on while the sectors seen agree: the first of these, from one to the next, which of eight
# directions they need, 64ths of the least score that they must reach
_LOOKS = ((0, 8, 0b10000011, 12), (4, 8, 0b00111000, 28), (2, 4, 0b01000100, 64))
_LOOKS_SHARE = const(6)  # bits of those 64ths
_FIRST_MATCH = const(300)
_MATCH = const(450)
_GOOD_MATCH = const(640)
_LEAST_GOOD = const(16)  # sectors of 32 that must look like rings in a step,
_LEAST_SECTORS = const(12)  # those of each ring that must agree, and
_LEAST_COARSE = const(6)  # of 16
_RATIO_LEAST_Q10 = const(651)  # of the radii; a marker's are within 24 of 683 from the first step on
_RATIO_MOST_Q10 = const(715)
_FAINT_POWER = const(60000)  # sum of squares of a sector's samples: with less, noise may have led astray
_NEAR_SCORE = const(8600)  # of BlurModel: less is far from rings
_LOOK_EFFORT = const(900)  # of all 32 sectors, thousands of instructions
_TURN_EFFORT = const(600)
_MOTION_EFFORT = const(300)  # more of a turn in which motion is found
LOST_FOR_GOOD = const(0)  # how a fit ended: these are no rings of a marker,
LOST_IN_NOISE = const(1)  # nothing was seen, but noise may be the reason,
LOST_ON_THE_WAY = const(2)  # or the fit went astray
_FLOOR_Q10 = const(96)  # a sector this close to the fit is never an outlier
_STRONGEST_Q14 = const(3500)  # strongest ellipse and perspective
_RADIUS_LEAST_Q8 = const(1024)
_RADIUS_MOST_Q8 = const(24000)
_APART_Q10 = const(10000)  # the rings' centres differ by less, or they are not one marker's
_NOISE = const(150)  # variance of that difference, in 128ths of the deviations' squares
_ZERO = const(1048576)  # bias of what the kernels return
_WIDE = const(4)  # sectors to each side whose light is taken together


def fan(directions, step, start, first, count):
    """kernels.layouts.FAN"""
    return array("i", (directions, step, start, first, count))


class BlurredRings:
    """The pose of one candidate.

    x_q10, y_q10          projected centre, 1/1024 px; radius_q8: outer ring, 1/256 px
    e1, e2, hx, hy        ellipse and perspective, * 2**14
    ratio_q10             of the rings' radii
    deviation_q10         mean distance of the sectors from the fit, both rings, 1/1024 px
    used_outer, used_inner   sectors that count, of 32
    good                  sectors that look like rings; amplitude, background: their medians, 1/16 grey level
    match                 median of the squared correlations, 1/1024
    levels                the same in each of 32 sectors
    samples               scratch space of whoever samples, for kernels
    dark_around           directions of 64 in which it is darker between the rings than beside both, as where
                          blur has melted them into one band, when `line_shade` was asked last
    lost                  why the last `fit` failed: LOST_*
    effort                what the frame took so far, thousands of instructions on a Cortex-M7: looks and fits
                          add to it
    """

    def __init__(self, width, height, blur, parts):
        """parts: fixed.Parts of words that nobody else looks at during a fit and what follows it."""
        self.width = width
        self.height = height
        self.blur = blur
        self._pose = array("i", bytes(4 * _CIRCLE_ITEMS))
        self._pose[_CIRCLE_WIDTH] = width
        self._pose[_CIRCLE_HEIGHT] = height
        self._scan = array("i", bytes(4 * _SCAN_ITEMS))
        # one direction in the middle of each sector, and two
        self._fan_first = fan(_DIRECTIONS_FIRST, 8, 4, _FIRST, _COUNT)
        self._fan = fan(_DIRECTIONS, 4, 2, _FIRST, _COUNT)
        self._shades = parts.of32(2 * _DIRECTIONS)
        self.samples = parts.of16(SAMPLES)
        self.levels = array("H", bytes(128))
        self._means = parts.of16(MEANS)
        self._sectors = array("H", bytes(192))
        self._outer = array("i", bytes(128))
        self._inner = array("i", bytes(128))
        self._result = array("i", bytes(32))
        self.x_q10 = self.y_q10 = self.radius_q8 = self.e1 = self.e2 = self.hx = self.hy = 0
        self.ratio_q10 = self.deviation_q10 = self.used_outer = self.used_inner = 0
        self._local = 1
        self.good = self.amplitude = self.background = self.match = 0
        self.dark_around = 0
        self.lost = LOST_ON_THE_WAY
        self.effort = 0

    def memory(self):
        """Bytes of the buffers but the scratch space."""
        items = _CIRCLE_ITEMS + _SCAN_ITEMS + 2 * _FAN_ITEMS
        return 2 * (64 + 96) + 128 + 128 + 32 + 4 * items

    def sample(self, frame, fan, cosine, sine):
        """Samples a fan, turned by (cosine, sine) * 2**14; False when some lie outside the frame."""
        return kernels.polar_samples(
            0, 0, frame, 0, self._pose, fan, COSINE, cosine, sine, self.samples
        )  # fmt: skip

    def coarse(self, frame, x_q8, y_q8, radius_min_q8, radius_max_q8, least):
        """A first pose near a centre, from the radii at which 16 directions show two rings.

        Returns how well they agree (at most 16384), 0 when they do not lie on one ellipse, or as soon as they
        will hardly reach `least`."""
        blur = self.blur
        low_q8 = radius_min_q8 * 13 >> 4
        room_q8 = min(min(x_q8, (self.width << 8) - x_q8), min(y_q8, (self.height << 8) - y_q8))
        high_q8 = min(radius_max_q8 * 19 >> 4, (room_q8 - 768) * 24 // 29)
        if high_q8 <= low_q8:
            return 0
        result = self._result
        self.x_q10 = x_q8 << 2
        self.y_q10 = y_q8 << 2
        self.e1 = self.e2 = self.hx = self.hy = 0
        self.radius_q8 = (low_q8 + high_q8) >> 1
        blur.prepare(_COARSE_SIGMA_SMALL if radius_min_q8 < _SMALL_Q8 else _COARSE_SIGMA, 0, 0, 1)
        scan = self._scan
        scan[_SCAN_LEAST] = low_q8
        scan[_SCAN_LAST] = high_q8
        score = 0
        for sector, hop, wanted, share in _LOOKS:
            self.effort += _LOOK_EFFORT // hop
            kernels.circle_samples(
                0, 0, frame, self.width, x_q8, y_q8, COSINE, 32, wanted, scan, self.samples
            )  # fmt: skip
            score = kernels.sector_radii(
                0, 0, self._means, self.samples, scan, blur.templates, blur.sums, _COARSE_MATCH, self._outer,
                sector, hop, score,
            )  # fmt: skip
            if score << _LOOKS_SHARE < least * share:
                return 0
        used = sector_kernels.shift_harmonics(0, 0, self._outer, COSINE, 8, self.radius_q8 // 6, result)
        self.x_q10 += result[1] - _ZERO
        self.y_q10 += result[2] - _ZERO
        self.radius_q8 += (result[0] - _ZERO) >> 2
        radius_q8 = self.radius_q8
        if used < _LEAST_COARSE or not low_q8 <= radius_q8 <= high_q8:
            return 0
        self.e1 = ((result[3] - _ZERO) << 12) // radius_q8
        self.e2 = ((result[4] - _ZERO) << 12) // radius_q8
        if max(abs(self.e1), abs(self.e2)) > _STRONGEST_Q14:
            return 0
        return score

    def line_shade(self, frame):
        """How dark the darkest direction outside the rings is at the present pose, 256ths of their depth.

        More than that of any line where it may lie outside the frame. Counts in `dark_around`."""
        self._put_pose()
        shade = kernels.line_shade(frame, 0, 0, self._pose, COSINE, self._shades)
        self.dark_around = self._shades[0]
        return shade

    def start(self, x_q10, y_q10, radius_q8, e1, e2):
        """Begins a fit with this pose."""
        self.x_q10 = x_q10
        self.y_q10 = y_q10
        self.radius_q8 = radius_q8
        self.e1 = e1
        self.e2 = e2
        self.hx = self.hy = 0
        self._local = 1
        self._put_pose()

    def _put_pose(self):
        """Writes the pose where the kernels find it."""
        pose = self._pose
        pose[_CIRCLE_X_Q8] = ((self.x_q10 + 2) >> 2) + _BIAS
        pose[_CIRCLE_Y_Q8] = ((self.y_q10 + 2) >> 2) + _BIAS
        pose[_CIRCLE_RADIUS_Q8] = self.radius_q8
        pose[_CIRCLE_E1] = self.e1 + _BIAS
        pose[_CIRCLE_E2] = self.e2 + _BIAS
        pose[_CIRCLE_HX] = self.hx + _BIAS
        pose[_CIRCLE_HY] = self.hy + _BIAS

    def fit(self, frame, turns, lines):
        """Gauss-Newton steps from the present pose; `lines`, once they are known, are taken out.

        Without lines the blur is searched for, too. False when the rings do not hold."""
        self.lost = LOST_ON_THE_WAY
        for turn in range(turns):
            self.effort += _TURN_EFFORT
            # at first one direction in each of 32 sectors will do
            first = lines is None and turn == 0
            if not self.sample(frame, self._fan_first if first else self._fan, 16384, 0):
                return False
            if lines is not None:
                lines.erase(self, self._fan)
            kernels.mean_samples(0, 0, self.samples, 0 if first else _COUNT, 32, _COUNT, self._means)
            if lines is None and turn < 2 and not self._search_blur(turn):
                if first and self.blur.score < _NEAR_SCORE:
                    self.lost = LOST_IN_NOISE if self.is_faint() else LOST_FOR_GOOD
                return False
            limit = 3072 if first else 2048 if lines is None and turn == 1 else 1536
            if not self._step(limit, _FIRST_MATCH if first else _MATCH, not first):
                return False
        self._measure_sectors()
        self.measure_light(self._local)
        return True

    def _search_blur(self, turn):
        found = self.blur.search(self._means, turn)
        if not self.blur.still:
            self.effort += _MOTION_EFFORT
        return found

    def is_faint(self):
        """Whether noise may have led the last search for a blur astray."""
        return self.blur.is_faint(_FAINT_POWER)

    def _step(self, limit, least_match, perspective):
        """One step; with `perspective` the distance of the rings' centres counts, as far as it is sure."""
        blur = self.blur
        result = self._result
        radius_q8 = self.radius_q8
        good = sector_kernels.ring_shifts(
            0, 0, self._means, blur.templates, blur.sums, blur.motion_axis, radius_q8, limit, least_match,
            self._outer, self._inner, self._sectors,
        )  # fmt: skip
        if good < _LEAST_GOOD:
            return False
        self.used_outer = sector_kernels.shift_harmonics(0, 0, self._outer, COSINE, 5, _FLOOR_Q10, result)
        outer_r = result[0] - _ZERO
        outer_x = result[1] - _ZERO
        outer_y = result[2] - _ZERO
        outer_cos = result[3] - _ZERO
        outer_sin = result[4] - _ZERO
        outer_deviation = result[5]
        self.used_inner = sector_kernels.shift_harmonics(0, 0, self._inner, COSINE, 5, _FLOOR_Q10, result)
        if self.used_outer < _LEAST_SECTORS or self.used_inner < _LEAST_SECTORS:
            return False
        inner_r = result[0] - _ZERO
        inner_x = result[1] - _ZERO
        inner_y = result[2] - _ZERO
        self.deviation_q10 = outer_deviation + result[5]
        # the middle of the rings' centres lies beyond the projected one by 13/18 of what a radius is bent
        bent_x = self.hx * radius_q8 >> 12
        bent_y = self.hy * radius_q8 >> 12
        middle_x = self.x_q10 + bent_x * 13 // 18 + ((outer_x + inner_x) >> 1)
        middle_y = self.y_q10 + bent_y * 13 // 18 + ((outer_y + inner_y) >> 1)
        if perspective:
            apart_x = bent_x * 5 // 9 + outer_x - inner_x
            apart_y = bent_y * 5 // 9 + outer_y - inner_y
            if max(abs(apart_x), abs(apart_y)) > _APART_Q10:
                return False
            weight = self._perspective_weight(apart_x, apart_y, outer_deviation, result[5])
            bent_x = apart_x * weight * 9 // 1280
            bent_y = apart_y * weight * 9 // 1280
        self.x_q10 = middle_x - bent_x * 13 // 18
        self.y_q10 = middle_y - bent_y * 13 // 18
        self.hx = (bent_x << 12) // radius_q8
        self.hy = (bent_y << 12) // radius_q8
        self.e1 += ((outer_cos + (result[3] - _ZERO) * 3 // 2) << 11) // radius_q8
        self.e2 += ((outer_sin + (result[4] - _ZERO) * 3 // 2) << 11) // radius_q8
        self.ratio_q10 = ((radius_q8 * 8 // 3 + inner_r) << 10) // max(1, (radius_q8 << 2) + outer_r)
        if not _RATIO_LEAST_Q10 < self.ratio_q10 < _RATIO_MOST_Q10:
            self.lost = LOST_FOR_GOOD
            return False
        self.radius_q8 += ((outer_r * 3 + inner_r * 2) // 5 + 2) >> 2
        shape = max(max(abs(self.hx), abs(self.hy)), max(abs(self.e1), abs(self.e2)))
        if shape > _STRONGEST_Q14 or not _RADIUS_LEAST_Q8 <= self.radius_q8 <= _RADIUS_MOST_Q8:
            return False
        self._put_pose()
        return True

    def _perspective_weight(self, x_q10, y_q10, outer, inner):
        """How much of the distance of the rings' centres is believed, 0..256, given their deviations."""
        noise2 = ((outer * outer >> 7) + (inner * inner >> 7)) * _NOISE + 4
        prior = self.radius_q8 // 30 + 1
        signal2 = max(x_q10 * x_q10 + y_q10 * y_q10 - noise2, prior * prior)
        return min(256, signal2 // (((signal2 + noise2) >> 8) + 1))

    def _measure_sectors(self):
        """Medians of the sectors in the last step."""
        sectors = self._sectors
        scratch = self._means
        self.amplitude = sector_kernels.median(sectors, 0, 0, 0, 32, scratch)
        self.background = sector_kernels.median(sectors, 0, 0, 32, 32, scratch)
        self.match = sector_kernels.median(sectors, 0, 0, 64, 32, scratch)

    def measure_light(self, local):
        """Levels from each sector's neighbours, or if not `local` the medians of all."""
        self._local = local
        self.good = sector_kernels.sector_levels(
            self._sectors, 0, 0, self.amplitude, self.background, _GOOD_MATCH, _WIDE, local, self.levels
        )

    def local_depths(self):
        """How deep the rings are in 16 sectors, as kernels.cells.local_depths takes it; in scratch space."""
        depths = self._outer
        for sector in range(16):
            depths[16 + sector] = self.levels[2 * sector] + self.levels[2 * sector + 1] >> 1
        return depths
