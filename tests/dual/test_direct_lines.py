"""Limits of what the direct reader takes for lines."""

from array import array

from larics.arith import fixed
from larics.direct import line_reader
from larics.direct.line_reader import LineReader
from larics.direct.ring_fit import RingFit
from larics.kernels import code, directions, layouts, lines
from larics.marker import LARICS3

BIAS = layouts.BIAS


class Code:
    def __init__(self, angle_turn16, sum_of_means):
        self.angle_turn16 = angle_turn16
        self.code = array("i", [BIAS] * (8 * layouts.POSITION_ITEMS))
        for position in (2, 4, 6):
            self.code[position * layouts.POSITION_ITEMS + layouts.POSITION_NEAR_MEAN] += sum_of_means


def test_half_sectors_that_lines_cover():
    rings = RingFit(136, 128, 683, 119, 8000)
    for angle_turn16, means, outer, inner in (
        (407, 170, 2, 0),  # 9 degrees to either side, in sectors of 11.25
        (408, 170, 3, 0),
        (407, 171, 2, 6),
        (0, 171, 2, 6),
    ):
        rings.skip_lines(Code(angle_turn16, means))
        assert (rings.skipped_outer, rings.skipped_inner) == (outer, inner), (angle_turn16, means)


def test_what_passes_as_an_orientation_line():
    reader = LineReader(LARICS3, 175)
    for area, gap, slope, expected in (
        (96, 90, 99, True),
        (95, 90, 99, False),
        (96, 91, 99, False),
        (96, 90, 100, False),
    ):
        reader.line[layouts.CROSSING_AREA], reader.line[layouts.CROSSING_GAP] = area, gap
        reader.line[layouts.CROSSING_SLOPE], reader.line[layouts.CROSSING_SLOPE_MOST] = slope, 100
        assert reader._passes() == expected, (area, gap, slope)


class Around(LineReader):
    """Directions that are dark outside the rings, as (area, gap, slope, distance, end) measured of each."""

    def __init__(self, *measured):
        LineReader.__init__(self, LARICS3, 175)
        self.measured = measured

    def annulus_profile(self, *arguments):
        return 1

    def dark_directions(self, *arguments):
        for index in range(len(self.measured)):
            arguments[-1][2 * index] = index + 1
        return len(self.measured)

    def _measure(self, frame, rings, angle_turn16, rounds):
        area, gap, slope, distance, self._end = self.measured[(angle_turn16 >> 9) - 1]
        self.line[layouts.CROSSING_AREA], self.line[layouts.CROSSING_GAP] = area, gap
        self.line[layouts.CROSSING_SLOPE], self.line[layouts.CROSSING_SLOPE_MOST] = slope, 100
        self.line[layouts.CROSSING_DISTANCE] = distance
        self.angle_turn16 = angle_turn16

    def _measure_ends(self, frame, rings):
        self.end_q8 = self._end


class AtThirty:
    """Rings of 30 px."""

    radius_q8 = 7680
    fit = None


def test_shadows_and_pipes_are_no_rivals_of_an_orientation_line():
    line = (200, 0, 0, 0, 0)
    for others, rivals, where, second in (
        ((), 1, 0, 0),
        (((190, 90, 99, 420, 140),), 2, 0, 0),  # 300, and a 64th of the radius
        (((190, 0, 0, 0, 141),), 1, 0, 0),  # it goes on where a line ends
        (((190, 0, 100, 0, 0),), 1, 0, 0),  # it is not straight
        (((190, 0, 0, 421, 0),), 1, 0, 243),  # it may be a line that is partly hidden
        (((190, 91, 0, 0, 0),), 1, 0, 243),
        (((401, 0, 0, 0, 0),), 1, 1, 127),  # the first is as pale as none
        (((300, 0, 0, 0, 141), (95, 0, 0, 0, 0)), 1, 0, 121),
    ):
        reader = Around(line, *others)
        line_reader.directions = reader
        try:
            assert reader.find_orientation(None, AtThirty) == rivals, others
        finally:
            line_reader.directions = directions
        if rivals == 1:
            assert (reader.angle_turn16, reader.second_q8) == ((where + 1) << 9, second), others
    # alone, it is left to the rules on the orientation line
    reader = Around((200, 0, 99, 999, 999))
    line_reader.directions = reader
    try:
        assert reader.find_orientation(None, AtThirty) == 1
    finally:
        line_reader.directions = directions


def test_short_lines_may_be_less_straight():
    frame = fixed.frame_view(bytearray(100 * 100))
    fit = array("i", [0] * layouts.FIT_ITEMS)
    fit[layouts.FIT_TRUE_X_Q10] = fit[layouts.FIT_TRUE_Y_Q10] = BIAS + 50 * 1024
    fit[layouts.FIT_WIDTH] = fit[layouts.FIT_HEIGHT] = 100
    fit[layouts.FIT_AREA] = 100
    shape = array("i", [0] * layouts.SHAPE_ITEMS)
    shape[layouts.SHAPE_LINE] = 119
    line = array("i", [0] * layouts.CROSSING_ITEMS)
    for radius_q8, expected in ((7680, 103), (3840, 141), (20480, 79)):
        fit[layouts.FIT_RADIUS_Q8] = radius_q8
        lines.line_crossings(
            0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, fit, shape, 0, 1, array("i", [0] * 32), line
        )
        assert line[layouts.CROSSING_SLOPE_MOST] == expected, radius_q8


def stroke(row, seen):
    """How dark the stroke beyond a coding line is taken to be in rings of 100 px, two rows beside whose
    direction are dark; seen: of the position's halves together."""
    frame = bytearray([200] * (96 * 60))
    for y in (30 - row, 30 + row):
        for x in range(96):
            frame[y * 96 + x] = 50
    fit, shape = array("i", bytes(4 * layouts.FIT_ITEMS)), array("i", bytes(4 * layouts.SHAPE_ITEMS))
    fit[layouts.FIT_WIDTH], fit[layouts.FIT_HEIGHT] = 96, 60
    fit[layouts.FIT_TRUE_X_Q10], fit[layouts.FIT_TRUE_Y_Q10] = BIAS + (20 << 10), BIAS + (30 << 10)
    fit[layouts.FIT_RADIUS_Q8] = fit[layouts.FIT_AREA] = 25600
    shape[layouts.SHAPE_BEYOND], shape[layouts.SHAPE_LINE] = 512, 1024
    places = array("i", [0] * (8 * layouts.POSITION_ITEMS))
    for position in range(8):
        for item in (layouts.POSITION_NEAR_MEAN, layouts.POSITION_FAR_MEAN):
            places[position * layouts.POSITION_ITEMS + item] = BIAS
    places[2 * layouts.POSITION_ITEMS + layouts.POSITION_NEAR_MEAN] += seen
    return code.stroke_beyond(0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, fit, shape, 16384, places)


def test_where_a_stroke_beyond_a_line_is_looked_for():
    assert stroke(4, 250) == (961 - 523) * 256 // 257  # 4 of 100 px beside its middle
    assert stroke(4, 249) == 0  # there is no line
    assert stroke(2, 250) == stroke(8, 250) == stroke(12, 250) == 0
