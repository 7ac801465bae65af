"""Step 4: the orientation line and the bits of a marker whose rings are known.

A line is measured like a ring: its darkness times width in the pixel rows or columns it crosses, in units of
the rings' own, so that blur, light and contrast cancel. The orientation line is looked for outside the outer
ring only, the coding lines inside the inner ring only.
"""

from array import array

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith.fixed import COSINE, LOG_GREY, atan2_turn16
from larics.kernels import code, directions
from larics.kernels import lines as kernels

POSITIONS = const(8)  # every 45 degrees from the orientation line; 2, 4 and 6 carry the bits

_BIAS = const(1 << 24)
_CROSSING_SLOPE = const(5)  # items as in kernels.layouts
_CROSSING_DISTANCE = const(6)
_CROSSING_AREA = const(7)
_CROSSING_GAP = const(8)
_CROSSING_SLOPE_MOST = const(9)
_CROSSING_ANGLE = const(10)
_CROSSING_ITEMS = const(11)
_POSITION_NEAR_MEAN = const(2)
_POSITION_FAR_MEAN = const(3)
_POSITION_ITEMS = const(6)
_SHAPE_LINE_FIRST = const(0)
_SHAPE_LINE_LAST = const(1)
_SHAPE_WINDOW = const(2)
_SHAPE_LINE = const(3)
_SHAPE_IN_LINE = const(4)
_SHAPE_BEYOND = const(5)
_SHAPE_BESIDE = const(6)
_SHAPE_AROUND_FIRST = const(7)
_SHAPE_AROUND_LAST = const(8)
_SHAPE_AROUND_SAMPLES = const(9)
_SHAPE_AROUND_STRIDE = const(10)
_SHAPE_CODE_FIRST = const(11)
_SHAPE_CODE_LAST = const(12)
_SHAPE_CODE_RADII = const(13)
_SHAPE_CODE_OPENING = const(14)
_SHAPE_ITEMS = const(15)

_HYPOTHESES = const(3)
DIRECTIONS = const(4)  # that are weighed, where rules on each alone find no line
_SAMPLES = const(3)  # in each direction of the annulus
_INNER_SAMPLES = const(4)
_INNER_REACH = const(18)  # 25 degrees, 1/256 turn
_SEEN_LEAST = const(125)  # depth of a coding line that is surely seen, 256 = as the rings'
_OFF_MOST = const(450)  # 2.5 degrees: a cell is 9 wide
_LINE_LEAST = const(96)  # area of what may be an orientation line, 256 = as the rings',
_GAP_MOST = const(90)  # and how much of it may be missing, 256 = all
_DISTANCE_MOST = const(300)  # of centroids from it, 1/1024 px, and 1/64 of the radius's 1/256 px
_END_MOST = const(140)  # beyond its ends, 256 = as dark as the line, where there is another
_CODE_OPENING = const(104)  # half the angle between two positions, as a slope / 256
_CODE_RADII = const(4)


class LineReader:
    """Reads the lines of one candidate at a time; its attributes hold the last one's.

    angle_turn16       clockwise angle of the orientation line, 1/65536 turn
    rivals             directions outside the rings that pass as an orientation line: 1 for a marker
    line               array of kernels.layouts: CROSSING, what was measured of it
    second_q8          area of another direction that is straight and ends as a line, 256 = as the line's
    end_q8             darkness beyond the line's ends, outside and between the rings, where the plate must be
                       white, 256 = as dark as it
    stroke_q8          darkness of what goes on between the rings beyond a coding line that is seen, as cables
                       and scratches do, 256 = as the rings
    profile            array of the log greys around the rings, where `list_directions` looked for dark ones
    shape              array of kernels.layouts: SHAPE
    code_inside        whether all eight positions lie inside the frame
    code               array of 8 * kernels.layouts: POSITION
    """

    def __init__(self, family, line_mm10):
        outer = family.outer_mm10
        end = family.orientation_end_mm10
        half_mm10 = line_mm10 // 2
        self.stride = 2 if line_mm10 * 12 >= outer else 1
        self.shape = shape = array("i", bytes(4 * _SHAPE_ITEMS))
        shape[_SHAPE_LINE_FIRST] = ((outer + half_mm10 + 50) << 10) // outer
        shape[_SHAPE_LINE_LAST] = ((end - 50) << 10) // outer
        shape[_SHAPE_WINDOW] = ((outer - family.inner_mm10) << 10) // (2 * outer)
        shape[_SHAPE_LINE] = (line_mm10 << 10) // outer
        shape[_SHAPE_IN_LINE] = (((outer + end) >> 1) << 10) // outer
        shape[_SHAPE_BEYOND] = (((end + family.plate_mm10) >> 1) << 10) // outer
        shape[_SHAPE_BESIDE] = shape[_SHAPE_LINE] + 10
        shape[_SHAPE_AROUND_FIRST] = ((outer + half_mm10 + 130) << 10) // outer
        shape[_SHAPE_AROUND_LAST] = ((end * 17 // 20) << 10) // outer
        shape[_SHAPE_AROUND_SAMPLES] = _SAMPLES
        shape[_SHAPE_AROUND_STRIDE] = self.stride
        code_first_mm10 = max(family.code_start_mm10 + 50, line_mm10 * 21 // 10)
        shape[_SHAPE_CODE_FIRST] = (code_first_mm10 << 10) // outer
        shape[_SHAPE_CODE_LAST] = ((family.code_end_mm10 - 20) << 10) // outer
        shape[_SHAPE_CODE_RADII] = _CODE_RADII
        shape[_SHAPE_CODE_OPENING] = _CODE_OPENING
        # as beyond the line's end, the plate must be white where the line would go on between the rings
        gap_shape = array("i", shape)
        gap_shape[_SHAPE_BEYOND] = ((outer + family.inner_mm10) << 9) // outer
        self._end_shapes = (shape, gap_shape)  # made once: it would be allocated with each marker
        self._inner_shape = array("i", shape)
        self._inner_shape[_SHAPE_AROUND_FIRST] = shape[_SHAPE_CODE_FIRST]
        self._inner_shape[_SHAPE_AROUND_LAST] = shape[_SHAPE_CODE_LAST]
        self._inner_shape[_SHAPE_AROUND_SAMPLES] = _INNER_SAMPLES
        self.profile = array("H", bytes(512 // self.stride))
        self._depths = array("H", bytes(512 // self.stride))
        self._picks = array("i", bytes(8 * DIRECTIONS))
        self.line = array("i", bytes(4 * _CROSSING_ITEMS))
        self.code = array("i", bytes(4 * _POSITION_ITEMS * POSITIONS))
        self.code_inside = 1
        self.angle_turn16 = self.rivals = self.second_q8 = self.end_q8 = self.stroke_q8 = 0

    def memory(self):
        """Bytes of the buffers."""
        return (
            4 * len(self.profile)
            + 8 * DIRECTIONS
            + 4 * (_SHAPE_ITEMS + _CROSSING_ITEMS + _POSITION_ITEMS * POSITIONS)
        )

    @micropython.native
    def find_orientation(self, frame, rings):
        """Looks for the one dark line outside the outer ring; returns the number of lines that pass."""
        self.rivals = 0
        found = self.list_directions(frame, rings, _HYPOTHESES)
        best_turn16 = best_q8 = second_q8 = 0
        distance_q10 = (rings.radius_q8 >> 6) + _DISTANCE_MOST
        for index in range(found):
            self._measure(frame, rings, self._pick_turn16(index), 2)
            if found > 1 and not self._ends(frame, rings):
                continue
            line_q8 = self.line[_CROSSING_AREA]
            is_near = found == 1 or self.line[_CROSSING_DISTANCE] <= distance_q10
            if self._passes() and is_near and line_q8 * 2 > best_q8:
                if line_q8 > best_q8 * 2:
                    self.rivals = 0
                    second_q8 = max(second_q8, best_q8)
                self.rivals += 1
                if self.rivals == 1:
                    best_q8 = line_q8
                    best_turn16 = self.angle_turn16
            else:
                second_q8 = max(second_q8, line_q8)
        self.second_q8 = (second_q8 << 8) // max(1, best_q8)
        if self.rivals == 1 and best_turn16 != self.angle_turn16:
            self._measure(frame, rings, best_turn16, 1)
        return self.rivals

    @micropython.native
    def list_directions(self, frame, rings, most):
        """The number of directions outside the outer ring that are darker than their sides, or `most`."""
        if not directions.annulus_profile(
            0, 0, frame, 0, LOG_GREY, COSINE, rings.fit, self.shape, self.profile
        ):
            return 0
        stride = self.stride
        return directions.dark_directions(
            self.profile,
            0,
            0,
            256 // stride,
            10 // stride,
            14 // stride,
            12 // stride,
            self._depths,
            most,
            self._picks,
        )

    def _pick_turn16(self, index):
        return self._picks[2 * index] * self.stride * 256

    @micropython.native
    def measure_direction(self, frame, rings, index):
        """Measures one of `list_directions` as if it were the orientation line's; returns its area."""
        self._measure(frame, rings, self._pick_turn16(index), 2)
        return self.line[_CROSSING_AREA]

    @micropython.native
    def measure_around(self, frame, rings):
        """Measures what belongs to the line measured last; False where that reaches beyond the frame."""
        self._measure_ends(frame, rings)
        self.read_code(frame, rings)
        return self.code_inside

    def find_quarter(self, frame, rings):
        """Turns to a direction in which, or at right angles to which, coding lines lie; False without any.

        Whether one of the four is that of the orientation line's is left open."""
        stride = self.stride
        profile = self._depths  # what the outer profile holds is still needed
        wave = self._picks
        count = 256 // stride
        inside = directions.annulus_profile(
            0, 0, frame, 0, LOG_GREY, COSINE, rings.fit, self._inner_shape, profile
        )
        if inside < count:
            return False
        directions.quarter_phase(profile, 0, 0, COSINE, count, wave)
        self.angle_turn16 = (atan2_turn16(-(wave[1] - _BIAS), -(wave[0] - _BIAS)) + 2) >> 2
        self.read_code(frame, rings)
        if not self.code_inside:
            return False
        darkest = 0
        for turn in range(1, 4):
            if self.quarter_depth(turn) > self.quarter_depth(darkest):
                darkest = turn
        if self.quarter_depth(darkest) < _SEEN_LEAST:
            return False
        # dirt and shadows of other directions are in the wave, too: the line itself must lie there
        off_turn16 = self._off_centre(self.angle_turn16 - darkest * 16384 & 65535)
        self.angle_turn16 = self.angle_turn16 + off_turn16 & 65535
        return -_OFF_MOST < off_turn16 < _OFF_MOST

    def _off_centre(self, angle_turn16):
        """How far the middle of what is dark inside lies beyond a direction, clockwise, 1/65536 turn."""
        profile = self._depths
        count = 256 // self.stride
        reach = _INNER_REACH // self.stride
        first = (angle_turn16 >> 8) // self.stride - reach
        light = min(profile[first % count], profile[(first + 2 * reach) % count])
        total = moment = 0
        for step in range(2 * reach + 1):
            dark = light - profile[(first + step) % count]
            if dark > 0:
                total += dark
                moment += dark * step
        if not total:
            return _OFF_MOST
        middle_turn16 = (first * self.stride << 8) + (moment * self.stride << 8) // total
        return (middle_turn16 - angle_turn16 + 32768 & 65535) - 32768

    def refine_quarter(self, frame, rings):
        """Looks for the direction of the coding lines once more, near the last angle."""
        before_turn16 = self.angle_turn16
        if self.find_quarter(frame, rings):
            turns = (before_turn16 - self.angle_turn16 + 8192 & 65535) >> 14
            self.angle_turn16 = self.angle_turn16 + turns * 16384 & 65535
            self.read_code(frame, rings)

    def quarter_depth(self, turn):
        """Depth of the inner position that many quarter turns counterclockwise, 256 = as the rings'."""
        slot = 2 * turn * _POSITION_ITEMS
        depth = self.code[slot + _POSITION_NEAR_MEAN] + self.code[slot + _POSITION_FAR_MEAN]
        return (depth - 2 * _BIAS) >> 1

    def outside(self, turn):
        """The darkest log grey where the orientation line would be that many quarter turns counterclockwise.

        As `find_orientation` saw it; 0 outside the frame."""
        index = ((self.angle_turn16 - turn * 16384 & 65535) >> 8) // self.stride
        count = 256 // self.stride
        profile = self.profile
        before = profile[index - 1 if index else count - 1]
        darkest = min(profile[index], min(profile[(index + 1) % count], before))
        return max(0, darkest - 1) // _SAMPLES

    @micropython.native
    def _passes(self):
        """Whether what was measured last is a straight, radial, uninterrupted line."""
        line = self.line
        return (
            line[_CROSSING_AREA] >= _LINE_LEAST
            and line[_CROSSING_GAP] <= _GAP_MOST
            and line[_CROSSING_SLOPE] < line[_CROSSING_SLOPE_MOST]
        )

    @micropython.native
    def _ends(self, frame, rings):
        """Whether what was measured last is straight, and ends where a line ends: no shadow, no pipe."""
        line = self.line
        if line[_CROSSING_SLOPE] >= line[_CROSSING_SLOPE_MOST]:
            return False
        self._measure_ends(frame, rings)
        return self.end_q8 <= _END_MOST

    @micropython.native
    def refine(self, frame, rings, rounds):
        """Measures the orientation line once more, from its last angle and the present centre.

        rounds: two where the centre has moved, which turns the line."""
        self._measure(frame, rings, self.angle_turn16, rounds)
        self._measure_ends(frame, rings)

    @micropython.native
    def _measure_ends(self, frame, rings):
        self.end_q8 = 0
        for shape in self._end_shapes:
            dark_q8 = kernels.line_end(0, 0, 0, frame, LOG_GREY, COSINE, rings.fit, shape, self.angle_turn16)
            self.end_q8 = max(self.end_q8, dark_q8)

    @micropython.native
    def _measure(self, frame, rings, angle_turn16, rounds):
        line = self.line
        kernels.line_crossings(
            0, 0, 0, frame, LOG_GREY, COSINE, rings.fit, self.shape, angle_turn16, rounds, rings.outer_means,
            line,
        )  # fmt: skip
        self.angle_turn16 = line[_CROSSING_ANGLE]

    @micropython.native
    def read_code(self, frame, rings):
        """Measures the eight positions inside the inner ring."""
        self.code_inside = code.code_positions(
            0, 0, 0, frame, LOG_GREY, COSINE, rings.fit, self.shape, self.angle_turn16, self.code
        )

    @micropython.native
    def follow_code(self, frame, rings):
        """Looks between the rings for what goes on there beyond the coding lines that `read_code` saw."""
        self.stroke_q8 = code.stroke_beyond(
            0, 0, 0, frame, LOG_GREY, COSINE, rings.fit, self._end_shapes[1], self.angle_turn16, self.code
        )  # fmt: skip
