"""Limits of the direct reader beside its acceptance: of its passes and of lines; and of the tracker."""

from array import array

from larics.arith import fixed
from larics.detect.tracker import Tracker
from larics.direct import line_reader
from larics.direct.line_reader import LineReader
from larics.direct.reader import DirectReader
from larics.direct.ring_fit import RingFit
from larics.kernels import code, directions, layouts, lines
from larics.marker import LARICS3, verdicts
from larics.marker.detection import Detection

BIAS = layouts.BIAS


class Scripted:
    """Stands for rings, lines and acceptance of a reader: passes move the rings as told, all is noted."""

    def __init__(self, radius_q8, moves):
        self.radius_q8 = radius_q8
        self.moves = list(moves)
        self.moved_q10 = 0
        self.passes = []
        self.looks = []
        self.code = self.angle_turn16 = 0
        self.line_q10 = 119
        self.area = 1

    def start(self, x_q10, y_q10, radius_q8):
        pass

    def coarse(self, edges, count, x_q8, y_q8, radii):
        return True

    def refine(self, frame, *rest):
        if not rest:
            return None
        self.passes.append(rest)
        self.moved_q10 = self.moves.pop(0) if self.moves else 0
        return True

    def first_look(self, rings, deviation_q10):
        self.looks.append(deviation_q10)
        return True

    def find_orientation(self, frame, rings):
        return 1

    def read_code(self, frame, rings):
        pass

    def skip_lines(self, lines):
        pass

    def rings(self, *measured):
        return verdicts.POOR_RINGS  # so far and no farther


class Scale:
    radii = None
    radius_min_q8 = radius_max_q8 = 0

    class edges:
        edges = None


def examined(radius_q8, moves, predicted=0):
    """The verdict on scripted rings, and the script."""
    reader = DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None)
    script = Scripted(radius_q8, moves)
    reader.rings = reader.lines = reader.acceptance = script
    return reader.examine(None, Scale, 1, 0, 0, predicted), script


def test_rings_too_small_or_too_faint_are_left_to_the_blur_model():
    reader = DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None)
    line_px256 = 7680 * reader.rings.line_q10 >> 10
    reader.rings.radius_q8, reader.rings.area = 7680, (56 * line_px256 + 255) // 256
    assert reader.decides()
    reader.rings.area -= 1
    assert not reader.decides()
    for radius_q8 in (2303, 2304):
        reader.rings.radius_q8, reader.rings.area = radius_q8, 100000
        assert reader.decides() == (radius_q8 == 2304)


def test_deviations_of_the_first_passes():
    assert examined(8000, (0,))[1].looks == [1300, 480]
    assert examined(8000, (0,), 8000)[1].looks == [1300, 480]  # a prediction may be off as a tilt is


def test_a_prediction_saves_crossings():
    for predicted, asked in ((0, [6, 6, 16, 16]), (7167, [4, 4, 12, 12]), (7168, [3, 3, 12, 12])):
        script = examined(8000, (626, 0, 121, 0), predicted)[1]
        assert [one[0] for one in script.passes] == asked


def test_rings_that_are_far_off_take_more_passes():
    for radius_q8, moves, passes in (
        (4096, (400,), 2),  # one more for the pose without the lines
        (4096, (401, 400), 3),
        (4096, (401, 401, 400), 4),
        (4096, (401, 401, 401, 400), 5),
        (8000, (625,), 2),  # 1/51 of the radius
        (8000, (626, 625), 3),
        (4095, (0, 0), 3),  # small rings take one more
    ):
        verdict, script = examined(radius_q8, moves)
        assert verdict == verdicts.POOR_RINGS and len(script.passes) == passes, (radius_q8, moves)
        lines_first = [one[0] for one in script.passes[1:-1]]
        assert lines_first == [12 if radius_q8 < 4096 else 6] * (passes - 2)
    verdict, script = examined(4096, (401, 401, 401, 401))
    assert verdict == verdicts.NO_FIT and len(script.passes) == 4


def test_the_last_pass_must_settle():
    for moves, verdict, passes in (
        ((0, 120), verdicts.POOR_RINGS, 2),
        ((0, 121, 120), verdicts.POOR_RINGS, 3),
        ((0, 121, 121), verdicts.NO_FIT, 3),
    ):
        found, script = examined(8000, moves)
        assert (found, len(script.passes)) == (verdict, passes), moves


class Moved(Scripted):
    """A script whose robust fit moves the centre by so much; no orientation line is believed after that."""

    margin = 255

    def fit(self, rings):
        return True

    def take_centre(self, robust):
        return self.robust_q10

    def rings(self, *measured):
        return verdicts.ACCEPTED

    def orientation(self, lines, rings):
        return verdicts.NO_ORIENTATION


def test_a_centre_that_was_moved_lets_the_line_be_measured_twice():
    for moved_q10, times in ((40, 1), (41, 2)):
        reader = DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None)
        script = Moved(8000, (0,))
        script.robust_q10 = moved_q10
        reader.rings = reader.lines = reader.acceptance = reader.robust = script
        reader._turn_by_code = lambda frame: False
        assert reader.examine(None, Scale, 1, 0, 0, 0) == verdicts.NO_ORIENTATION
        assert script.passes[-1] == (script, times)


class Covered(Scripted):
    """... whose rings are poor in too many sectors, which are faint there or not; told: verdict and ID."""

    def __init__(self, faint, told):
        super().__init__(7680, ())
        self.faint = faint
        self.marker_id = told[1]
        self.margin = 0
        self.code = lambda *arguments: told[0]

    def rings(self, *measured):
        return verdicts.ACCEPTED if len(measured) > 3 else verdicts.POOR_RINGS

    def refine_faint(self, *arguments):
        return self.faint

    def uneven(self, rings):
        return True

    def fit(self, rings):
        return False

    def orientation(self, *arguments):
        return verdicts.ACCEPTED

    def measure_direct(self, frame, rings, lines, is_faint):
        assert is_faint == self.faint
        return True

    def follow_code(self, *arguments):
        pass


def covered(faint, told, marker_id, coded=True):
    """The verdict, and the last pass of the rings."""
    reader = DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None)
    script = Covered(faint, (told, marker_id))
    reader.rings = reader.lines = reader.acceptance = reader.robust = script
    reader.cells = script if coded else None
    verdict = reader.examine(None, Scale, 1, 0, 0, 0)
    return verdict, [rest for rest in script.passes if len(rest) == 3][-1]


def test_rings_much_of_which_is_covered_are_those_of_a_marker_whose_cells_tell():
    poor, good, unsure = verdicts.POOR_RINGS, verdicts.ACCEPTED, verdicts.ID_UNCERTAIN
    for faint, told, marker_id, coded, expected in (
        (False, good, 8, True, (good, (16, 4, 48))),
        (False, good, 7, True, (poor, (16, 4, 48))),  # the lines tell it, not the cells
        (False, unsure, -1, True, (poor, (16, 4, 48))),
        (False, good, 7, False, (poor, (16, 4, 48))),
        (True, good, 7, False, (good, (16, 4, 96))),  # a lens is dirty on that side
        (True, good, 7, True, (good, (16, 4, 96))),
        (True, unsure, -1, True, (poor, (16, 4, 96))),
    ):
        verdict, last = covered(faint, told, marker_id, coded)
        assert verdict == expected[0], (faint, told, marker_id, coded)
        assert not (coded or faint) or last == expected[1], (faint, last)


class Quarters:
    """Stands for lines and cells: an inner position in each of four directions, what the cells make of it."""

    def __init__(self, depths, outside=0, sides=(0, 0)):
        self.depths, self.is_outside, self.sides = depths, outside, sides
        self.angle_turn16 = 0

    def find_quarter(self, frame, rings):
        return True

    def measure_direct(self, frame, rings, lines, is_faint):
        return True

    def quarter_depth(self, turn):
        return self.depths[turn]

    def find_turn(self, seen, possible):
        self.seen, self.possible = list(seen), possible
        return 1

    def outside(self, turn):
        return self.is_outside

    def white(self):
        return 800

    def beside(self, turn, side):
        assert turn == 1
        return self.sides[0 if side else 1]


def turned_by_code(quarters, seen=(256, 256)):
    """Whether the code tells the turn; seen: area of the outer ring on both sides of the line's place."""
    reader = DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None)
    reader.rings.radius_q8 = 7680
    reader.rings.area = 256
    for sector in range(16):
        reader.rings.outer_means[16 + sector] = 256
    reader.rings.outer_means[16 + 11], reader.rings.outer_means[16 + 12] = seen  # about the turn's direction
    reader.lines = reader.cells = quarters
    return reader._turn_by_code(None)


def test_what_inner_positions_say_of_the_orientation():
    quarters = Quarters((125, 124, 40, 39))
    assert turned_by_code(quarters)
    assert quarters.seen == [64, 0, 0, -16]  # a line, neither, neither, and empty, which may be hidden
    assert quarters.possible == 0b1110
    assert quarters.angle_turn16 == 65536 - 16384


def test_no_line_is_hidden_where_the_plate_is_white():
    for outside, expected in ((0, True), (760, True), (761, False), (839, False), (840, True)):
        assert turned_by_code(Quarters((0, 0, 0, 0), outside)) == expected, outside


def test_there_are_signs_that_something_hides_the_orientation_line():
    """Darkness alone may be a shadow in which the plate is seen to be empty."""
    for sides, seen, expected in (
        ((700, 700), (256, 256), False),
        ((700, 700), (178, 256), True),  # something covers the ring, too: below 179/256 of its area
        ((700, 700), (256, 178), True),
        ((700, 700), (179, 179), False),
        ((700, 700), (0, 256), False),  # not looked at
        ((700, 0), (256, 256), True),  # the plate leaves the frame there
        ((0, 700), (256, 256), True),
        ((741, 741), (256, 256), True),  # darker than both sides
        ((740, 741), (256, 256), False),
        ((741, 700), (256, 256), False),  # the edge of a shadow
        ((659, 659), (256, 256), True),  # lighter
        ((659, 660), (256, 256), False),
        ((659, 741), (256, 256), False),
    ):
        assert turned_by_code(Quarters((0, 0, 0, 0), 700, sides), seen) == expected, (sides, seen)


class Told(LineReader):
    """A reader of lines that is told how deep each quarter is, and how far off its middle."""

    def find(self, depth, off_turn16):
        frame = fixed.frame_view(bytearray(200 for _ in range(136 * 128)))
        rings = RingFit(136, 128, 683, 119, 8000)
        rings.start(68 << 10, 64 << 10, 6000)
        for true, mean in (
            (layouts.FIT_TRUE_X_Q10, layouts.FIT_X_Q10),
            (layouts.FIT_TRUE_Y_Q10, layouts.FIT_Y_Q10),
        ):
            rings.fit[true] = rings.fit[mean]
        rings.fit[layouts.FIT_AREA] = 1000
        self.depth, self.off = depth, off_turn16
        return self.find_quarter(frame, rings)

    def quarter_depth(self, turn):
        return self.depth if turn == 2 else 0

    def _off_centre(self, angle_turn16):
        return self.off


def test_a_coding_line_that_tells_the_quarters_is_seen_and_lies_there():
    for depth, off_turn16, expected in (
        (125, 0, True),
        (124, 0, False),
        (125, 449, True),
        (125, 450, False),
        (125, -449, True),
        (125, -450, False),
    ):
        assert Told(LARICS3, 175).find(depth, off_turn16) == expected, (depth, off_turn16)


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


class Counting:
    """A detector that always sees one marker."""

    def __init__(self):
        self.calls = []
        self.found = [Detection()]
        self.found[0].marker_id = 3

    def detect(self, frame):
        self.calls.append("search")
        return self.found

    def track(self, frame):
        self.calls.append("track")
        return self.found


def test_every_eighth_frame_is_searched():
    counting = Counting()
    tracker = Tracker(counting)
    for _ in range(17):
        tracker.detect(None)
    assert counting.calls == (["search"] + ["track"] * 7) * 2 + ["search"]


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


def test_a_radius_is_told_beyond_what_oblique_rows_make_of_it():
    for radius_q8, told_q8 in ((7680, 7684), (15360, 15368)):
        reader = DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None)
        reader.rings.radius_q8 = radius_q8
        found = Detection()
        reader.tell(found)
        assert found.radius_q8 == told_q8
