"""The blur-model reader on the lines: orientation line and code as blurred templates on the fitted rings."""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import COSINE, cos_q14, sin_q14
from larics.blurred.ring_fit import fan
from larics.kernels import blurred_code as code_kernels
from larics.kernels import blurred_lines as kernels

POSITIONS = const(8)  # every 45 degrees clockwise from the orientation line; 6, 4 and 2 carry the bits
BITS = (6, 4, 2)  # most significant first

_RELS = const(17)  # as in kernels.layouts
_ALONG = const(408)
_FAN_FIRST = const(3)
_FAN_ITEMS = const(5)
_ZONE_ITEMS = const(3)

# first items of zones: the orientation line, its halves, what is beyond it, the code's inner and outer half
_WHOLE = const(0)
_INNER_HALF = const(3)
_OUTER_HALF = const(6)
_BEYOND_END = const(9)
_CODE_ZONES = (12, 15)

_DEPTH_BIAS = const(32768)
_RING = const(24)  # units
_CODE_FROM = const(4)  # units, in two zones
_NEAR_COUNT = const(4)
_FAR_COUNT = const(5)
_ROUNDS = const(16)
_APART = const(10)  # directions between the line and its rival
_DIRECTIONS = const(128)  # where the line may be
_CODE_DIRECTIONS = const(64)
_BEYOND_COUNT = const(2)  # units
_AROUND = const(29)  # directions sampled around the line
_MIDDLE = const(14)
_REACH = const(13)


class BlurredLines:
    """The lines of one candidate.

    angle_turn16     clockwise angle of the orientation line in the plane of the marker, 1/65536 turn
    depth, rival     of the deepest direction and of the deepest one elsewhere, 256 = as deep as the rings
    near, far        depth of the line's inner and outer half
    residual         mean of what the line leaves of the ink around it, 1024 = as deep as the rings
    beyond           depth of what goes on beyond the line's end, when that was measured
    amounts          array of 8: depth of the line at each position, less what all empty ones share
    common           what the empty ones share (median)
    noise            between neighbouring directions outside the rings, 1024 = twice as deep as the rings
    residuals        array of 8: largest mean residual around each position, 1024 = as deep as the rings
    """

    def __init__(self, family, blur, parts):
        """parts: as of BlurredRings."""
        outer = family.outer_mm10

        def units_q8(length_mm10):
            return length_mm10 * _RING * 256 // outer

        self.blur = blur
        self._orientation_q8 = units_q8(family.orientation_end_mm10 - outer)
        self._orientation_middle_q8 = units_q8(family.orientation_end_mm10 + outer) >> 1
        self._code_q8 = units_q8(family.code_end_mm10 - family.code_start_mm10)
        self._code_middle_q8 = units_q8(family.code_end_mm10 + family.code_start_mm10) >> 1
        first = _RING + (self._orientation_q8 * 84 >> 16)
        count = 6  # to 206 mm: cells begin at 220
        # between the line's end and that of the plate
        beyond = units_q8(family.orientation_end_mm10) + 384 >> 8
        start = 256 - 2 * _MIDDLE
        self._turn = fan(_DIRECTIONS, 2, 0, first, count)
        self._around = fan(_AROUND, 2, start, first, count)
        self._beyond = None
        if (beyond + _BEYOND_COUNT) << 8 <= units_q8(family.plate_mm10):
            self._beyond = fan(_AROUND, 2, start, beyond, _BEYOND_COUNT)
        self._code = fan(_CODE_DIRECTIONS, 4, 0, _CODE_FROM, _NEAR_COUNT + _FAR_COUNT)
        # kernels.layouts.ZONE: first unit, number of units, slot; in the order of their names above
        self._zones = array(
            "i",
            (
                0, count, 0, 0, count >> 1, 0, count >> 1, count >> 1, 0, 0, _BEYOND_COUNT, 0,
                0, _NEAR_COUNT, 0, _NEAR_COUNT, _FAR_COUNT, _CODE_DIRECTIONS,
            ),
        )  # fmt: skip
        self._templates = parts.of16(15 * (_RELS + 1 >> 1))
        self._code_templates = parts.of16(33 * 8)
        self._ink = parts.of16(_DIRECTIONS)
        self._depths = array("H", bytes(256))
        self._gram = parts.of32(81)
        self._side = array("i", bytes(36))
        self._solution = array("i", bytes(40))
        self._skirts = array("H", bytes(34))
        self._code_reach = 0
        self._code_rels = -1  # directions for which the code's templates have been made
        self._result = array("i", bytes(16))
        self.amounts = array("i", bytes(4 * POSITIONS))
        self.residuals = array("i", bytes(36))
        self.angle_turn16 = self.depth = self.rival = self.near = self.far = self.common = 0
        self.noise = self.residual = self.beyond = 0

    def memory(self):
        """Bytes of the buffers but the scratch space."""
        items = 4 * _FAN_ITEMS + 6 * _ZONE_ITEMS + 9 * 3 + 4 + 1 + POSITIONS
        return 256 + 34 + 4 * items

    def prepare(self):
        """Makes the orientation line's templates for the blur that has been found."""
        blur = self.blur
        self._code_rels = -1
        if not blur.still:  # the other rels' bars are there since the search
            blur.prepare(blur.sigma, blur.motion, 0, 2, False)
        # every other rel: a line's profile changes slowly with its direction
        for rel in range(0, 1 if blur.still else _RELS, 2):
            blur.put_along(self._orientation_q8, rel)
            kernels.line_template(
                blur.bars, 0, 0, blur.across(rel), self._orientation_middle_q8, COSINE, self._around,
                self._zones, _WHOLE, self._templates, 15 * (rel >> 1),
            )  # fmt: skip

    def find_orientation(self, frame, rings):
        """Finds the orientation line; False when its place lies outside the frame."""
        if not rings.sample(frame, self._turn, 16384, 0):
            return False
        self._read_ink(rings, self._turn, _WHOLE, 0)
        # directions that share pixels have noise in common
        apart = 1 if rings.radius_q8 > 5120 else 2 if rings.radius_q8 > 2560 else 4
        self.noise = kernels.ink_noise(self._ink, 0, 0, _DIRECTIONS, apart)
        self._read_depths(self._turn, 0, 0, _DIRECTIONS - 1)
        kernels.deepest(self._depths, 0, 0, _DIRECTIONS, _APART, self._result)
        self.angle_turn16 = self._result[0] << 9
        self.depth = self._result[1] - _DEPTH_BIAS
        self.rival = self._result[2] - _DEPTH_BIAS
        return True

    def refine_orientation(self, frame, rings, turns):
        """Turns the line to where it is to a fraction of a direction; False when it leaves the frame."""
        template = self._template()
        for _ in range(turns):
            if not self._sample_around(frame, rings):
                return False
            self._read_ink(rings, self._around, _WHOLE, self._start_turn16())
            kernels.line_turn(self._ink, 0, 0, self._templates, template, _REACH, _MIDDLE, self._result)
            self.angle_turn16 = (self.angle_turn16 + (self._result[0] - 1048576) * 2) & 65535
        return True

    def measure_residual(self, frame, rings):
        """Measures what the line as it lies leaves of the ink around it; False when it leaves the frame."""
        if not self._sample_around(frame, rings):
            return False
        self._leave(self._measure(rings, _WHOLE))
        return True

    def measure_orientation(self, rings):
        """Measures the line and its halves in the last samples of `refine_orientation`."""
        self.beyond = 0
        self.depth = self._measure(rings, _WHOLE)
        self._leave(self.depth)
        self.near = self._measure(rings, _INNER_HALF)
        self.far = self._measure(rings, _OUTER_HALF)

    def _leave(self, depth):
        self.residual = kernels.line_residual(
            self._ink, 0, 0, self._templates, self._template(), _REACH, _MIDDLE, depth
        )

    def _measure(self, rings, zone):
        """Reads the ink of a zone of the line and returns the depth."""
        self._read_ink(rings, self._around, zone, self._start_turn16())
        return self._depth_at_middle()

    def _depth_at_middle(self):
        self._read_depths(self._around, self._start_turn16(), _MIDDLE, _MIDDLE)
        return self._depths[_MIDDLE] - _DEPTH_BIAS

    def measure_beyond(self, frame, rings):
        """Measures how much more than its skirt of the line lies beyond its end, as far as that is seen."""
        blur = self.blur
        angle = self.angle_turn16
        beyond = self._beyond
        if beyond and rings.sample(frame, beyond, cos_q14(angle), sin_q14(angle)):
            self._read_ink(rings, beyond, _BEYOND_END, self._start_turn16())
            blur.put_along(self._orientation_q8, blur.rel(angle))
            skirt = blur.bars[_ALONG + beyond[_FAN_FIRST] - (self._orientation_middle_q8 >> 8)]
            self.beyond = self._depth_at_middle() - (skirt * self.depth >> 10)

    def _template(self):
        """The first item of the template for the line's direction."""
        return 15 * (self.blur.rel(self.angle_turn16) >> 1)

    def _start_turn16(self):
        return self.angle_turn16 - _MIDDLE * 512

    def _sample_around(self, frame, rings):
        angle = self.angle_turn16
        return rings.sample(frame, self._around, cos_q14(angle), sin_q14(angle))

    def _read_ink(self, rings, fan, zone, angle_turn16):
        blur = self.blur
        kernels.ink_profile(
            rings.samples, 0, 0, fan, self._zones, zone, rings.levels, angle_turn16 >> 7, blur.bars,
            blur.motion_axis, self._ink, self._skirts,
        )  # fmt: skip

    def _read_depths(self, fan, angle_turn16, first, last):
        kernels.line_depths(
            0, 0, self._ink, fan, self._templates, angle_turn16 >> 7, self.blur.motion_axis, first, last,
            self._depths,
        )  # fmt: skip

    def read_code(self, frame, rings):
        """Fits the eight positions; False when they lie outside the frame."""
        angle = self.angle_turn16
        axes = 1 if self.blur.still else 4
        self._prepare_code(axes)
        if not rings.sample(frame, self._code, cos_q14(angle), sin_q14(angle)):
            return False
        for zone in _CODE_ZONES:
            self._read_ink(rings, self._code, zone, angle)
        solution = self._solution
        templates = self._code_templates
        reach = self._code_reach
        code_kernels.fit_code(
            self._ink, 0, 0, templates, axes, reach, self._gram, self._side, _ROUNDS, solution
        )
        code_kernels.code_residuals(self._ink, 0, 0, templates, axes, reach, solution, self.residuals)
        # what the five empty positions have in common is the skirt of the inner ring
        common = solution[9]
        self.common = common - 65536
        for position in range(POSITIONS):
            self.amounts[position] = solution[position] - common
        return True

    def _prepare_code(self, axes):
        """Makes the code's templates for the present angle, unless they have been made."""
        blur = self.blur
        rels = blur.rel(self.angle_turn16) << 5 | blur.rel(self.angle_turn16 + 8192)
        if rels == self._code_rels:
            return
        self._code_rels = rels
        self._code_reach = 1
        for axis in range(axes):
            rel = blur.rel(self.angle_turn16 + axis * 8192)
            blur.put_along(self._code_q8, rel)
            for half in range(2):
                reach = kernels.line_template(
                    blur.bars, 0, 0, blur.across(rel), self._code_middle_q8, COSINE, self._code, self._zones,
                    _CODE_ZONES[half], self._code_templates, 33 * (2 * axis + half),
                )  # fmt: skip
                self._code_reach = max(self._code_reach, min(31, reach))

    def erase(self, rings, fan):
        """Takes the lines found out of the rings' samples of a fan."""
        blur = self.blur
        for position in range(0, POSITIONS, 2):
            if position and self.amounts[position] <= 128:
                continue
            angle = self.angle_turn16 + position * 8192
            rel = blur.rel(angle)
            middle = self._code_middle_q8 if position else self._orientation_middle_q8
            blur.put_along(self._code_q8 if position else self._orientation_q8, rel)
            kernels.erase_line(
                rings.samples, 0, 0, blur.across(rel), middle, blur.bars, COSINE, fan, cos_q14(angle),
                sin_q14(angle), rings.amplitude, blur.reach(),
            )  # fmt: skip
