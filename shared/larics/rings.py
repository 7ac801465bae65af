"""Step 3: the two rings of a candidate, from a coarse radius to a sub-pixel, perspective-corrected centre.

The crossings of the rings with pixel rows and columns are averaged in 16 sectors; harmonics over the sectors
give centre, radius and ellipse of each ring without solving a matrix. Under perspective the centres of the
two rings' images differ, and the true centre lies on their line, farther by a factor of the rings' ratio.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics import tables
from larics.fixed import AXES, LOG_GREY, ROOT
from larics.kernels import rings as kernels

SECTORS = const(16)
SKIP_OUTER = const(1)
SKIP_INNER = const(2)

_SUPPORT_OUTER = const(5)  # edges that must agree on the coarse outer and inner radius
_SUPPORT_INNER = const(3)
_DISTANCES = const(800)  # edges that may point to one candidate
_COARSE_ROUNDS = const(2)
_FIRST_CLIP = const(8)  # log units; later passes clip an eighth of the depth
_LEAST_DEPTH = const(12)  # log units: about 4 of 100 grey levels
_RADIUS_FLOOR_Q8 = const(1536)
_WINDOW_FLOOR_Q8 = const(300)
_WINDOW_SMALL_Q8 = const(640)
_WINDOW_CAP_Q8 = const(3584)
_SECTOR_FLOOR_Q10 = const(96)  # a sector this close to the harmonics is never an outlier
_PRIOR_Q10 = const(32)  # expected distance of the ring centres at a radius of 30 px
_LINE_AREAS = const(170)  # both halves of a position that count as a line, 256 = as the rings'
_LINE_REACH_TURN16 = const(1640)  # 9 degrees
_APART_Q10 = const(3000)  # the rings' centres differ by less, or they are not one marker's


class RingFit:
    """Fits one candidate at a time; its attributes are the pose of the last one.

    x_q8, y_q8             centre used for the last pass; x_q10, y_q10 the fitted one (1/1024 px), without,
    and true_x_q10, true_y_q10 with the correction for perspective radius_q8, inner_q8    the rings' radii,
    1/256 px bulge_cos, bulge_sin   second harmonic of the outer radius, 1/1024 px area
    darkness times width of the rings' line, log units * px: what a line must show outer_area, inner_area
    the same for each ring used_*, inside_*       sectors that agree, sectors inside the frame
    deviation_*_q10        their mean distance from the harmonics skip                   bytearray(32):
    SKIP_* bits of sectors that a line disturbs
    """

    def __init__(self, width, height, inner_q10, line_q10, radius_max_q8):
        self.width = width
        self.height = height
        self.inner_q10 = inner_q10
        self.line_q10 = line_q10
        self.crossings = 0
        self.skip = bytearray(2 * SECTORS)
        self.outer_means = array("i", bytes(SECTORS * 8))
        self.inner_means = array("i", bytes(SECTORS * 8))
        self.distances = array("i", bytes(_DISTANCES * 4))
        self.bins = bytearray((radius_max_q8 >> 7) + 32)
        self._sectors = array("i", bytes(SECTORS * 16))
        self._result = array("i", bytes(48))
        self._gap_q10 = (1024 - inner_q10) // 2
        # the true centre lies beyond the mean of the rings' centres by (1 + q^2) / (2 (1 - q^2)) of their
        # difference
        square = inner_q10 * inner_q10
        self._beyond_q8 = ((1 << 20) + square) * 128 // ((1 << 20) - square)
        self.skipped_outer = self.skipped_inner = self.moved_q10 = 0
        self._window_q8 = self._clip = self._least = self._limit_q10 = 0
        self.x_q8 = self.y_q8 = self.x_q10 = self.y_q10 = self.true_x_q10 = self.true_y_q10 = 0
        self.radius_q8 = self.inner_q8 = self.bulge_cos = self.bulge_sin = 0
        self.area = self.outer_area = self.inner_area = 0
        self.used_outer = self.used_inner = self.inside_outer = self.inside_inner = 0
        self.deviation_outer_q10 = self.deviation_inner_q10 = 0

    def memory(self):
        """Bytes of the buffers."""
        return 4 * len(self.distances) + len(self.bins) + SECTORS * (8 + 8 + 16 + 2) + 48

    def coarse(self, edges, count, x_q8, y_q8, radius_min_q8, radius_max_q8, half_line_q8):
        """Takes a candidate centre and finds its radius from the edges; False when too few agree."""
        result = self._result
        reach_q4 = (radius_max_q8 >> 4) + 96
        x_q4 = x_q8 >> 4
        y_q4 = y_q8 >> 4
        if x_q4 < 0 or y_q4 < 0:
            return False
        distances = kernels.edge_distances(
            edges, 0, 0, 0, count, self.width, x_q4, y_q4, reach_q4, half_line_q8 >> 4,
            (radius_max_q8 >> 4) // 5 + 8, AXES, self.distances, _DISTANCES,
        )  # fmt: skip
        kernels.choose_radius(
            self.bins, 0, 0, radius_min_q8 >> 7, radius_max_q8 >> 7, (reach_q4 >> 3) + 3, self.inner_q10,
            self.distances, distances, AXES, _COARSE_ROUNDS, result,
        )  # fmt: skip
        if result[3] < _SUPPORT_OUTER or result[4] < _SUPPORT_INNER:
            return False
        self.start((x_q4 + result[1]) << 6, (y_q4 + result[2]) << 6, result[0] << 4)
        return True

    def start(self, x_q10, y_q10, radius_q8):
        """Begins the fit of a candidate."""
        self.x_q10 = x_q10
        self.y_q10 = y_q10
        self.radius_q8 = radius_q8
        self.inner_q8 = radius_q8 * self.inner_q10 >> 10
        self.bulge_cos = self.bulge_sin = 0
        self.area = 0
        self.skip_lines(None)

    def skip_lines(self, lines):
        """Leaves out of the next passes what a line disturbs; None: nothing."""
        bits = 0
        angle_turn16 = 0
        if lines is not None:
            angle_turn16 = lines.angle_turn16
            bits = 1
            code = lines.code
            for line in range(1, 4):
                if code[10 * line + 2] + code[10 * line + 3] > _LINE_AREAS:
                    bits |= 1 << line
        marked = kernels.skip_half_sectors(
            self.skip, 0, bits, angle_turn16, _LINE_REACH_TURN16, SKIP_OUTER, SKIP_INNER
        )
        self.skipped_outer = marked & 63
        self.skipped_inner = marked >> 6

    def refine(self, frame, lines, rounds, limit_q8):
        """One pass over both rings with about `lines` crossings a quarter ring; False when they do not hold.

        rounds: of the robust harmonics; limit_q8: largest residual that counts, in 256ths of the window."""
        radius_q8 = self.radius_q8
        x_q8 = (self.x_q10 + 2) >> 2
        y_q8 = (self.y_q10 + 2) >> 2
        if radius_q8 < _RADIUS_FLOOR_Q8 or not (0 <= x_q8 >> 8 < self.width and 0 <= y_q8 >> 8 < self.height):
            return False
        # to the middle of the gap between the rings; with large rings, less of it will do
        window_q8 = max(radius_q8 * self._gap_q10 >> 10, _WINDOW_FLOOR_Q8)
        if window_q8 > _WINDOW_SMALL_Q8:
            window_q8 = min(max(window_q8 * 7 >> 3, _WINDOW_SMALL_Q8), _WINDOW_CAP_Q8)
        line_q8 = radius_q8 * self.line_q10 >> 10
        area = self.area
        self._window_q8 = window_q8
        self._clip = (area << 5) // line_q8 if area else _FIRST_CLIP
        self._least = area * 3 >> 3 if area else _LEAST_DEPTH * line_q8 >> 8
        self._limit_q10 = window_q8 * limit_q8 >> 6
        self.x_q8 = x_q8
        self.y_q8 = y_q8
        result = self._result
        if not self._measure(frame, radius_q8, 1024, lines, rounds, SKIP_OUTER, self.outer_means):
            return False
        self.used_outer = result[6]
        self.inside_outer = result[7]
        outer_r = result[0]
        outer_x = result[1]
        outer_y = result[2]
        bulge_cos = result[3]
        bulge_sin = result[4]
        self.deviation_outer_q10 = result[5]
        self.outer_area = result[8]
        inner_q8 = self.inner_q8
        ratio = self.inner_q10
        if not self._measure(frame, inner_q8, ratio, lines, rounds, SKIP_INNER, self.inner_means):
            return False
        self.used_inner = result[6]
        self.inside_inner = result[7]
        self.deviation_inner_q10 = result[5]
        self.inner_area = result[8]
        self.area = (self.outer_area + self.inner_area) >> 1
        self.x_q10 = (x_q8 << 2) + ((outer_x + result[1]) >> 1)
        self.y_q10 = (y_q8 << 2) + ((outer_y + result[2]) >> 1)
        self.moved_q10 = max(abs(outer_x + result[1]), abs(outer_y + result[2]), abs(outer_r << 1)) >> 1
        self.radius_q8 = radius_q8 + ((outer_r + 2) >> 2)
        self.inner_q8 = inner_q8 + ((result[0] + 2) >> 2)
        self.bulge_cos += (bulge_cos + (result[3] << 10) // ratio) >> 1
        self.bulge_sin += (bulge_sin + (result[4] << 10) // ratio) >> 1
        return self._correct_perspective(outer_x - result[1], outer_y - result[2])

    def _measure(self, frame, radius_q8, ratio_q10, lines, rounds, skip_bit, means):
        """One ring's crossings and their harmonics; False when fewer than half of its sectors agree."""
        self.crossings += kernels.ring_crossings(
            0, 0, 0, frame, LOG_GREY, self.width, self.height, self.x_q8, self.y_q8, radius_q8,
            self._window_q8, max(1, (radius_q8 * 362 >> 16) // lines), self._clip, ROOT,
            self.bulge_cos * ratio_q10 >> 10, self.bulge_sin * ratio_q10 >> 10, self._limit_q10, self._least,
            self.skip, skip_bit, self._sectors,
        )  # fmt: skip
        used = kernels.ring_harmonics(
            0, 0, 0, self._sectors, means, tables.HARMONICS_4, rounds, _SECTOR_FLOOR_Q10, self._result
        )
        return used >= 5 and used * 2 >= self._result[7]

    def outer_area_near(self, angle_turn16):
        """The outer ring's area on both sides of a clockwise angle: what a line there must show in this
        light."""
        beside = kernels.mean_area(self.outer_means, 0, 0, (angle_turn16 >> 12) + 14, 5)
        area = self.area
        return min(area, max(beside, area >> 1)) if beside else area

    def _correct_perspective(self, dx_q10, dy_q10):
        """The projected centre from the distance of the rings' centres, weighted by how sure it is.

        False when they are so far apart that they cannot be one marker's."""
        if not (-_APART_Q10 < dx_q10 < _APART_Q10 and -_APART_Q10 < dy_q10 < _APART_Q10):
            return False
        outer = self.deviation_outer_q10
        inner = self.deviation_inner_q10
        noise2 = ((outer * outer + inner * inner) * 50 >> 7) + 4
        prior = (self.radius_q8 >> 4) * (self.radius_q8 >> 4) * _PRIOR_Q10 // 230400
        signal2 = dx_q10 * dx_q10 + dy_q10 * dy_q10 - noise2
        if signal2 < prior * prior:
            signal2 = prior * prior + 1
        signal2 = (signal2 >> 4) + 1
        weight_q8 = (signal2 << 8) // (signal2 + (noise2 >> 4))
        factor = self._beyond_q8 * weight_q8
        self.true_x_q10 = self.x_q10 - ((dx_q10 * factor + 32768) >> 16)
        self.true_y_q10 = self.y_q10 - ((dy_q10 * factor + 32768) >> 16)
        return True
