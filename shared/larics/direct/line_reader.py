"""Step 4: the orientation line and the bits of a marker whose rings are known.

A line is measured like a ring: its darkness times width in the pixel rows or columns it crosses, in units of
the rings' own, so that blur, light and contrast cancel. The orientation line is looked for outside the outer
ring only, the coding lines inside the inner ring only.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import COSINE, LOG_GREY
from larics.kernels import code, directions
from larics.kernels import lines as kernels

POSITIONS = const(8)  # every 45 degrees from the orientation line; 2, 4 and 6 carry the bits

# result items of the kernel line_crossings
_SLOPE = const(5)
_AREA = const(7)
_GAP = const(8)
_SLOPE_MOST = const(9)
_ANGLE = const(10)

_HYPOTHESES = const(3)
_SAMPLES = const(3)  # in each direction of the annulus
_CODE_OPENING = const(104)  # half the angle between two positions, as a slope / 256
_CODE_RADII = const(4)


class LineReader:
    """Reads the lines of one candidate at a time; its attributes hold the last one's.

    angle_turn16       clockwise angle of the orientation line, 1/65536 turn
    rivals             directions outside the rings that pass as an orientation line: 1 for a marker
    line               what the kernel line_crossings measured of it
    second_q8          depth of the second darkest direction, 256 = as deep as the line
    end_q8             darkness beyond the line's end, where the plate must be white, 256 = as dark as it
    code_inside        whether all eight positions lie inside the frame
    code               array of 8 * (area of the inner half of a position, of its outer half, below the darker
                       of both sides; both again, below the mean of the sides, + kernels.rings.BIAS;
                       brightness beside it in log units); areas: 256 = as the rings'
    """

    def __init__(self, width, height, family, line_mm10):
        self.width = width
        self.height = height
        outer = family.outer_mm10
        half_mm10 = line_mm10 // 2
        self._gap_q10 = ((outer - family.inner_mm10) << 10) // (2 * outer)
        self._line_q10 = (line_mm10 << 10) // outer
        self._annulus_first_q10 = ((outer + half_mm10 + 130) << 10) // outer
        self._annulus_last_q10 = ((family.orientation_end_mm10 * 17 // 20) << 10) // outer
        first_q10 = ((outer + half_mm10 + 50) << 10) // outer
        last_q10 = ((family.orientation_end_mm10 - 50) << 10) // outer
        end = family.orientation_end_mm10
        in_line_q10 = (((outer + end) >> 1) << 10) // outer
        beyond_q10 = (((end + family.plate_mm10) >> 1) << 10) // outer
        self._shape = array(
            "i",
            (
                first_q10,
                last_q10,
                self._gap_q10,
                self._line_q10,
                in_line_q10,
                beyond_q10,
                self._line_q10 + 10,
            ),  # fmt: skip
        )
        code_first_mm10 = max(family.code_start_mm10 + 50, line_mm10 * 21 // 10)
        self._code_first_q10 = (code_first_mm10 << 10) // outer
        self._code_last_q10 = ((family.code_end_mm10 - 20) << 10) // outer
        self._stride = 2 if line_mm10 * 12 >= outer else 1
        self._profile = array("H", bytes(512))
        self._depths = array("H", bytes(512))
        self._picks = array("i", bytes(8 * _HYPOTHESES))
        self.line = array("i", bytes(44))
        self.code = array("i", bytes(20 * POSITIONS))
        self.code_inside = 1
        self.angle_turn16 = self.rivals = self.second_q8 = self.end_q8 = 0

    def memory(self):
        """Bytes of the buffers."""
        return 1024 + 8 * _HYPOTHESES + 72 + 20 * POSITIONS

    def find_orientation(self, frame, rings):
        """Looks for the one dark line outside the outer ring; returns the number of lines that pass."""
        radius_q8 = rings.radius_q8
        x_q8 = (rings.true_x_q10 + 2) >> 2
        y_q8 = (rings.true_y_q10 + 2) >> 2
        self.rivals = 0
        if not (0 <= x_q8 >> 8 < self.width and 0 <= y_q8 >> 8 < self.height):
            return 0
        first_q8 = radius_q8 * self._annulus_first_q10 >> 10
        last_q8 = radius_q8 * self._annulus_last_q10 >> 10
        stride = self._stride
        directions.annulus_profile(
            frame, 0, 0, 0, LOG_GREY, COSINE, self.width, self.height, x_q8, y_q8, first_q8,
            (last_q8 - first_q8) // (_SAMPLES - 1), _SAMPLES, stride, self._profile,
        )  # fmt: skip
        picks = self._picks
        found = directions.dark_directions(
            self._profile,
            0,
            0,
            256 // stride,
            10 // stride,
            14 // stride,
            12 // stride,
            self._depths,
            _HYPOTHESES,
            picks,
        )
        best_turn16 = best_q8 = 0
        for index in range(found):
            self._measure(frame, rings, picks[2 * index] * stride * 256, 2)
            line_q8 = self.line[_AREA]
            if self._passes() and line_q8 * 2 > best_q8:
                if line_q8 > best_q8 * 2:
                    self.rivals = 0
                self.rivals += 1
                if self.rivals == 1:
                    best_q8 = line_q8
                    best_turn16 = self.angle_turn16
                    if found > index + 1:
                        self.second_q8 = (picks[2 * index + 3] << 8) // picks[2 * index + 1]
                    else:
                        self.second_q8 = 0
        if self.rivals == 1 and best_turn16 != self.angle_turn16:
            self._measure(frame, rings, best_turn16, 1)
        return self.rivals

    def _passes(self):
        """Whether what was measured last is a straight, radial, uninterrupted line."""
        line = self.line
        return line[_AREA] >= 96 and line[_GAP] <= 90 and line[_SLOPE] < line[_SLOPE_MOST]

    def refine(self, frame, rings):
        """Measures the orientation line once more, from its last angle and the present centre."""
        self._measure(frame, rings, self.angle_turn16, 1)
        self.end_q8 = kernels.line_end(
            0, 0, 0, frame, LOG_GREY, COSINE, self.width, self.height, rings.fit, self._shape,
            self.angle_turn16,
        )  # fmt: skip

    def _measure(self, frame, rings, angle_turn16, rounds):
        line = self.line
        kernels.line_crossings(
            0, 0, 0, frame, LOG_GREY, COSINE, self.width, self.height, rings.fit, self._shape, angle_turn16,
            rounds, rings.outer_means, line,
        )  # fmt: skip
        self.angle_turn16 = line[_ANGLE]

    def read_code(self, frame, rings):
        """Measures the eight positions inside the inner ring."""
        radius_q8 = rings.radius_q8
        line_q8 = radius_q8 * self._line_q10 >> 10
        area = rings.area
        first_q8 = radius_q8 * self._code_first_q10 >> 10
        pitch_q8 = ((radius_q8 * self._code_last_q10 >> 10) - first_q8) // (_CODE_RADII - 1)
        self.code_inside = code.code_positions(
            0, 0, 0, frame, LOG_GREY, COSINE, self.width, self.height, (rings.true_x_q10 + 2) >> 2,
            (rings.true_y_q10 + 2) >> 2, self.angle_turn16, first_q8, pitch_q8, _CODE_RADII,
            line_q8 // 2 + (radius_q8 * self._gap_q10 >> 11), _CODE_OPENING, (area << 5) // line_q8, area + 1,
            self.code,
        )  # fmt: skip
