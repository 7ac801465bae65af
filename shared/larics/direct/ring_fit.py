"""Step 3: the two rings of a candidate, from a coarse radius to a sub-pixel, perspective-corrected centre.

The crossings of the rings with pixel rows and columns are averaged in 16 sectors; harmonics over the sectors
give centre, radius and ellipse of each ring without solving a matrix. Under perspective the centres of the
two rings' images differ, and the true centre lies on their line, farther by a factor of the rings' ratio.
"""

from array import array

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith import tables
from larics.arith.fixed import AXES, LOG_GREY, ROOT, words
from larics.kernels import coarse, harmonics
from larics.kernels import rings as kernels

SECTORS = const(16)
SKIP_OUTER = const(1)
SKIP_INNER = const(2)

_BIAS = const(1 << 24)  # items as in kernels.layouts
_FIT_RADIUS_Q8 = const(6)
_FIT_INNER_Q8 = const(7)
_FIT_BULGE_COS = const(8)
_FIT_BULGE_SIN = const(9)
_FIT_X_Q10 = const(10)
_FIT_Y_Q10 = const(11)
_FIT_TRUE_X_Q10 = const(12)
_FIT_TRUE_Y_Q10 = const(13)
_FIT_AREA = const(14)
_FIT_MOVED_Q10 = const(15)
_FIT_INNER_Q10 = const(16)
_FIT_LINE_Q10 = const(17)
_FIT_GAP_Q10 = const(18)
_FIT_BEYOND_Q8 = const(19)
_FIT_WIDTH = const(20)
_FIT_HEIGHT = const(21)
_FIT_ITEMS = const(22)
_RING_ITEMS = const(9)
_RADII_WIDTH = const(0)
_RADII_FIRST = const(1)
_RADII_LAST = const(2)
_RADII_BINS = const(3)
_RADII_REACH_Q4 = const(4)
_RADII_HALF_LINE_Q4 = const(5)
_RADII_SLACK_Q4 = const(6)
_RADII_INNER_Q10 = const(7)
_RADII_CAPACITY = const(8)
_RADII_ITEMS = const(9)

_SUPPORT_OUTER = const(7)  # edges that must agree on the coarse outer and inner radius
_SUPPORT_INNER = const(4)
_SUPPORT_LESS = const(2)  # by so many less, and one, where
_SMALL_Q8 = const(3072)  # the range of radii ends below
_DISTANCES = const(800)  # edges that may point to one candidate
_COARSE_ROUNDS = const(2)
_SECTOR_FLOOR_Q10 = const(96)  # a sector this close to the harmonics is never an outlier
_LINE_AREAS = const(170)  # both halves of a position that count as a line, 256 = as the rings'
_LINE_REACH_TURN16 = const(1640)  # 9 degrees


class RingFit:
    """Fits one candidate at a time; its attributes are the pose of the last one.

    radius_q8                 of the outer ring, centre of its line, 1/256 px
    true_x_q10, true_y_q10    projected centre of the marker, 1/1024 px
    moved_q10                 how far the last pass moved the rings, 1/1024 px
    area                      darkness times width of the rings' line, log units * px: what a line must show
    fit                       the whole pose, items as in kernels.layouts: FIT
    outer, inner              kernels.layouts: RING of each ring in the last pass
    outer_means, inner_means  kernels.harmonics.ring_harmonics: residual and area of each sector
    skip                      bytearray(32): SKIP_* bits of the half sectors that a line disturbs;
    skipped_outer, skipped_inner    their numbers
    """

    def __init__(self, width, height, inner_q10, line_q10, radius_max_q8):
        self.width = width
        self.inner_q10 = inner_q10
        self.line_q10 = line_q10
        self.crossings = 0
        self.skip = bytearray(2 * SECTORS)
        self.outer_means = array("i", bytes(SECTORS * 8))
        self.inner_means = array("i", bytes(SECTORS * 8))
        self.distances = words(_DISTANCES, "distances")
        self.bins = bytearray((radius_max_q8 >> 7) + 32)
        self.outer = array("i", bytes(4 * _RING_ITEMS))
        self.inner = array("i", bytes(4 * _RING_ITEMS))
        self.fit = array("i", bytes(4 * _FIT_ITEMS))
        self.fit[_FIT_WIDTH] = width
        self.fit[_FIT_HEIGHT] = height
        self.fit[_FIT_INNER_Q10] = inner_q10
        self.fit[_FIT_LINE_Q10] = line_q10
        self.fit[_FIT_GAP_Q10] = (1024 - inner_q10) // 2
        # the true centre lies beyond the mean of the rings' centres by (1 + q^2) / (2 (1 - q^2)) of their
        # difference
        square = inner_q10 * inner_q10
        self.fit[_FIT_BEYOND_Q8] = ((1 << 20) + square) * 128 // ((1 << 20) - square)
        self._sectors = array("i", bytes(SECTORS * 32))
        self._result = array("i", bytes(20))
        self.skipped_outer = self.skipped_inner = self.moved_q10 = 0
        self.radius_q8 = self.true_x_q10 = self.true_y_q10 = self.area = 0

    def memory(self):
        """Bytes of the buffers."""
        return 4 * (len(self.distances) + len(self.fit)) + len(self.bins) + SECTORS * (8 + 8 + 32 + 2) + 92

    def radii(self, radius_min_q8, radius_max_q8, half_line_q8):
        """What `coarse` takes of a range of radii, whose lines are that wide: kernels.layouts.RADII."""
        radii = array("i", bytes(4 * _RADII_ITEMS))
        radii[_RADII_WIDTH] = self.width
        radii[_RADII_FIRST] = radius_min_q8 >> 7
        radii[_RADII_LAST] = radius_max_q8 >> 7
        radii[_RADII_REACH_Q4] = (radius_max_q8 >> 4) + 96
        radii[_RADII_BINS] = (radii[_RADII_REACH_Q4] >> 3) + 3
        radii[_RADII_HALF_LINE_Q4] = half_line_q8 >> 4
        radii[_RADII_SLACK_Q4] = (radius_max_q8 >> 4) // 5 + 8
        radii[_RADII_INNER_Q10] = self.inner_q10
        radii[_RADII_CAPACITY] = _DISTANCES
        return radii

    @micropython.native
    def coarse(self, edges, count, x_q8, y_q8, radii):
        """Takes a candidate centre and finds its radius from the edges; False when too few agree."""
        result = self._result
        x_q4 = x_q8 >> 4
        y_q4 = y_q8 >> 4
        if x_q4 < 0 or y_q4 < 0:
            return False
        distances = coarse.edge_distances(
            0, 0, edges, 0, count, radii, x_q4, y_q4, AXES, self.distances
        )  # fmt: skip
        coarse.choose_radius(0, 0, self.bins, radii, self.distances, distances, AXES, _COARSE_ROUNDS, result)
        less = _SUPPORT_LESS if radii[_RADII_LAST] < _SMALL_Q8 >> 7 else 0
        if result[3] < _SUPPORT_OUTER - less or result[4] < _SUPPORT_INNER - (less >> 1):
            return False
        self.start((x_q4 + result[1]) << 6, (y_q4 + result[2]) << 6, result[0] << 4)
        return True

    @micropython.native
    def start(self, x_q10, y_q10, radius_q8):
        """Begins the fit of a candidate."""
        fit = self.fit
        fit[_FIT_X_Q10] = x_q10 + _BIAS
        fit[_FIT_Y_Q10] = y_q10 + _BIAS
        fit[_FIT_RADIUS_Q8] = radius_q8
        fit[_FIT_INNER_Q8] = radius_q8 * self.inner_q10 >> 10
        fit[_FIT_BULGE_COS] = fit[_FIT_BULGE_SIN] = _BIAS
        fit[_FIT_AREA] = 0
        self.skip_lines(None)

    @micropython.native
    def skip_lines(self, lines):
        """Leaves out of the next passes what a line disturbs; None: nothing."""
        if lines is None:
            marked = kernels.skip_half_sectors(self.skip, 0, 0, self.fit, 0, 0, 0, SKIP_OUTER, SKIP_INNER)
        else:
            marked = kernels.skip_half_sectors(
                self.skip, 0, 1, lines.code, _LINE_AREAS, lines.angle_turn16, _LINE_REACH_TURN16, SKIP_OUTER,
                SKIP_INNER,
            )  # fmt: skip
        self.skipped_outer = marked & 63
        self.skipped_inner = marked >> 6

    @micropython.native
    def refine(self, frame, lines, rounds, limit_q8):
        """One pass over both rings with about `lines` crossings a quarter ring; False when they do not hold.

        rounds: of the robust harmonics; limit_q8: largest residual that counts, in 256ths of the window."""
        fit = self.fit
        outer = self.outer
        inner = self.inner
        sectors = self._sectors
        if not kernels.begin_pass(fit, limit_q8):
            return False
        self.crossings += kernels.ring_crossings(
            0, 0, 0, frame, LOG_GREY, fit, lines, ROOT, self.skip, sectors
        )
        if not harmonics.ring_harmonics(
            0, 0, 0, sectors, self.outer_means, self.inner_means, tables.HARMONICS_4, rounds,
            _SECTOR_FLOOR_Q10, outer, inner,
        ):  # fmt: skip
            return False
        holds = harmonics.end_pass(fit, outer, inner)
        self.radius_q8 = fit[_FIT_RADIUS_Q8]
        self.true_x_q10 = fit[_FIT_TRUE_X_Q10] - _BIAS
        self.true_y_q10 = fit[_FIT_TRUE_Y_Q10] - _BIAS
        self.moved_q10 = fit[_FIT_MOVED_Q10]
        self.area = fit[_FIT_AREA]
        return holds

    def refine_faint(self, frame, lines, rounds, limit_q8):
        """A pass as `refine`, in which crossings count however faint they are."""
        self.fit[_FIT_AREA] = 0
        return self.refine(frame, lines, rounds, limit_q8)

    def take_centre(self, robust):
        """Takes the centres of a `RobustCentre`; returns how far the projected one moves, 1/1024 px."""
        fit = self.fit
        moved = max(abs(robust.x_q10 - self.true_x_q10), abs(robust.y_q10 - self.true_y_q10))
        self.true_x_q10 = robust.x_q10
        self.true_y_q10 = robust.y_q10
        fit[_FIT_TRUE_X_Q10] = robust.x_q10 + _BIAS
        fit[_FIT_TRUE_Y_Q10] = robust.y_q10 + _BIAS
        fit[_FIT_X_Q10] = robust.middle_x_q10 + _BIAS
        fit[_FIT_Y_Q10] = robust.middle_y_q10 + _BIAS
        return moved
