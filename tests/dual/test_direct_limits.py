"""Limits of the direct reader beside its acceptance: of passes, fit and lines; and of the tracker."""

from array import array

from larics.arith import fixed, tables
from larics.detect.tracker import Tracker
from larics.direct import line_reader, ring_fit, robust_centre, uncertainty
from larics.direct.line_reader import LineReader
from larics.direct.reader import DirectReader
from larics.direct.ring_fit import RingFit
from larics.direct.robust_centre import RobustCentre
from larics.kernels import coarse, code, directions, harmonics, layouts, lines, robust
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


class CoarseResult:
    """Stands for the kernels of the coarse fit: so many edges on the outer and the inner ring."""

    def __init__(self, outer, inner):
        self.found = outer, inner

    def edge_distances(self, *arguments):
        return 20

    def choose_radius(self, *arguments):
        result = arguments[-1]
        self.rounds = arguments[-2]
        result[0], result[1], result[2] = 480, 0, 0
        result[3], result[4] = self.found


def test_edges_that_must_agree_on_a_radius():
    rings = RingFit(136, 128, 683, 119, 8000)
    for radius_max_q8, outer, inner, expected in (
        (3072, 7, 4, True),
        (3072, 6, 4, False),
        (3072, 7, 3, False),
        (3071, 5, 3, True),
        (3071, 4, 3, False),
        (3071, 5, 2, False),
    ):
        ring_fit.coarse = stand_in = CoarseResult(outer, inner)
        try:
            found = rings.coarse(None, 30, 68 << 8, 64 << 8, rings.radii(2000, radius_max_q8, 300))
        finally:
            ring_fit.coarse = coarse
        assert found == expected, (radius_max_q8, outer, inner)
        assert stand_in.rounds == 2


class HarmonicsCall:
    """Stands for the kernels of the harmonics: notes how they are called."""

    def ring_harmonics(self, *arguments):
        self.rounds, self.floor = arguments[7], arguments[8]
        return False


def test_a_sector_within_a_tenth_of_a_pixel_is_never_an_outlier():
    rings = RingFit(136, 128, 683, 119, 8000)
    rings.start(68 << 10, 64 << 10, 6000)
    ring_fit.harmonics = stand_in = HarmonicsCall()
    try:
        assert not rings.refine(fixed.frame_view(bytearray(136 * 128)), 6, 3, 192)
    finally:
        ring_fit.harmonics = harmonics
    assert (stand_in.rounds, stand_in.floor) == (3, 96)


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


def harmonics_of(residuals, rounds=2, floor=1):
    """What is found in 16 sectors of the outer ring (None: nothing seen) with a flawless inner one."""
    sectors = array("i", [0] * 128)
    for ring in range(2):
        for k in range(16):
            residual = residuals[k] if ring == 0 else 0
            if residual is not None:
                slot = 64 * ring + 4 * k
                sectors[slot] = sectors[slot + 2] = 1
                sectors[slot + 3] = 32768 + residual
    outer = array("i", [0] * layouts.RING_ITEMS)
    inner = array("i", [0] * layouts.RING_ITEMS)
    means = array("i", [0] * 32), array("i", [0] * 32)
    holds = harmonics.ring_harmonics(
        0, 0, 0, sectors, means[0], means[1], tables.HARMONICS_4, rounds, floor, outer, inner
    )
    return holds, outer


def test_a_sector_four_mean_deviations_off_is_an_outlier():
    waves = [10 if k & 1 else -10 for k in range(16)]  # no harmonic that is looked for
    for off, used in ((50, 16), (150, 15)):
        residuals = list(waves)
        residuals[1] += off
        assert harmonics_of(residuals)[1][layouts.RING_USED] == used, off
    for floor, used in ((200, 16), (20, 15)):  # one close enough never is
        residuals = list(waves)
        residuals[1] += 150
        assert harmonics_of(residuals, 2, floor)[1][layouts.RING_USED] == used, floor


def test_sectors_that_a_ring_needs():
    for seen, expected in ((5, 1), (4, 0)):
        residuals = [0 if k % 3 == 0 and k // 3 < seen else None for k in range(16)]
        assert residuals.count(0) == seen
        assert harmonics_of(residuals)[0] == expected, seen


def end_of_pass(apart_x, deviation, radius_q8=7680):
    """Whether rings whose centres are so far apart hold, and how far beyond their mean the true one lies."""
    fit = array("i", [0] * layouts.FIT_ITEMS)
    fit[layouts.FIT_RADIUS_Q8], fit[layouts.FIT_INNER_Q8] = radius_q8, radius_q8 * 2 // 3
    fit[layouts.FIT_INNER_Q10], fit[layouts.FIT_BEYOND_Q8] = 683, 333
    fit[layouts.FIT_BULGE_COS] = fit[layouts.FIT_BULGE_SIN] = BIAS
    rings = []
    for sign in (1, -1):
        ring = array("i", [BIAS] * 5 + [deviation, 16, 16, 1000])
        ring[layouts.RING_COS] += sign * apart_x // 2
        rings.append(ring)
    holds = harmonics.end_pass(fit, rings[0], rings[1])
    return holds, fit[layouts.FIT_X_Q10] - fit[layouts.FIT_TRUE_X_Q10]


def test_centres_of_the_rings_that_are_too_far_apart():
    assert end_of_pass(2998, 0)[0] == 1
    assert end_of_pass(3000, 0)[0] == 0
    assert end_of_pass(-2998, 0)[0] == 1
    assert end_of_pass(-3000, 0)[0] == 0


def test_perspective_is_believed_as_far_as_it_is_sure():
    for apart, deviation, radius_q8 in (
        (600, 100, 7680),
        (600, 300, 7680),
        (40, 100, 7680),
        (40, 100, 18000),
    ):
        noise = 2 * deviation * deviation * 50 // 128 + 4
        prior = (radius_q8 // 16) * (radius_q8 // 16) * 32 // 230400
        signal = max(apart * apart - noise, prior * prior)
        expected = apart * 333 * signal // ((signal + noise) * 256)
        found = end_of_pass(apart, deviation, radius_q8)[1]
        assert abs(found - expected) <= 2 + expected // 50, (apart, deviation, radius_q8, found, expected)


def counted(on_rings, extra):
    """Edges counted on the outer and inner ring when `extra` (1/16 px) joins those that lie exactly there."""
    scale = array("i", [0] * layouts.RADII_ITEMS)
    scale[layouts.RADII_FIRST], scale[layouts.RADII_LAST], scale[layouts.RADII_BINS] = 25, 35, 60
    scale[layouts.RADII_INNER_Q10] = 683
    distances = array("i", [radius | direction << 16 for radius in on_rings for direction in range(0, 48, 2)])
    distances.append(extra | 1 << 16)
    result = array("i", [0] * 5)
    coarse.choose_radius(0, 0, bytearray(60), scale, distances, len(distances), fixed.AXES, 1, result)
    return result[3], result[4]


def test_how_near_an_edge_lies_to_a_ring():
    outer = 30 * 8 + 4
    inner = (outer * 683 + 512) >> 10
    for extra, expected in (
        (outer, (25, 24)),
        (outer + 40, (25, 24)),
        (outer + 41, (24, 24)),
        (outer - 40, (25, 24)),
        (inner + 31, (24, 25)),
        (inner + 32, (24, 24)),
        (inner - 31, (24, 25)),
        (inner - 32, (24, 24)),
    ):
        assert counted((outer, inner), extra) == expected, extra


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


def test_small_rings_and_uneven_light_are_told_as_less_sure():
    for radius_px, expected in ((40, 1085), (30, 1155), (20, 1350), (10, 2400), (6, 4886)):
        assert abs(uncertainty.with_few_pixels(1000, radius_px << 8) - expected) <= 5, radius_px
    assert uncertainty.with_few_pixels(1 << 21, 1300) == 1 << 20

    class Lines:
        line = array("i", [0] * layouts.CROSSING_ITEMS)

    def turned(area):
        Lines.line[layouts.CROSSING_AREA] = area
        return uncertainty.sigma_mdeg(400, Lines, 7680)

    assert turned(276) == turned(236) == turned(256) < turned(290) < turned(336) < turned(400)
    # the square of what is darker counts five times that of what is paler: 60 * 60 * 5 = 134.2 * 134.2
    assert turned(236 - 134) < turned(276 + 60) < turned(236 - 135)


def sectors(left_q10, other_q10=0, depth=400, turn=2):
    """The work of a robust fit that has not moved yet: one sector is so far off, all others so far."""
    work, fit = array("i", bytes(4 * layouts.ROBUST_ITEMS)), array("i", bytes(4 * layouts.FIT_ITEMS))
    fit[layouts.FIT_AREA] = 400
    outer, inner = [array("i", [32768 + other_q10] * 16 + [depth] * 16) for _ in range(2)]
    outer[3] = 32768 + left_q10
    assert robust.begin_robust(work, fit, outer, inner) == 32
    robust.weigh_sectors(0, 0, 0, work, tables.SECTOR_WAVES, 683, turn)
    return work


def test_sectors_of_the_common_centre_count_by_their_distance():
    for other_q10, left_q10, scale, weight in (
        (0, 30, 8, 12),  # the least spread, five of them
        (0, 20, 8, 36),
        (0, 40, 8, 0),
        (20, 85, 34, 36),  # the spread is 1.7 medians
    ):
        work = sectors(left_q10, other_q10)
        assert (work[layouts.ROBUST_SCALE], work[layouts.ROBUST_WEIGHTS + 3]) == (scale, weight), left_q10
    for left_q10, believed in ((511, 511), (600, 511), (-600, -511)):
        assert sectors(left_q10)[layouts.ROBUST_LEFT + 3] - BIAS == believed
    for depth, weight in ((400, 64), (200, 16), (80, 2), (40, 1), (1, 1)):
        assert sectors(0, depth=depth)[layouts.ROBUST_BASES + 3] == weight, depth


def test_what_rings_cost_that_are_unevenly_deep():
    """With the square of their first harmonic, and of what jumps from sector to sector."""

    def variance(depths):
        means = array("i", bytes(64)) + array("i", depths)
        return robust.uneven_depths(0, 0, 0, tables.WAVES, 256, means, means)

    assert variance([256] * 16) == 0
    assert variance([256, 208] * 8) == 48 * 48 // 24
    waved = variance([256 + (100 * fixed.cos_q14(4096 * sector + 2048) >> 14) for sector in range(16)])
    assert abs(waved - 296) < 12, waved  # 870/16384 of twice 800 * 800 / 256, and 31 of steps


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


def test_sectors_that_determine_the_common_centre():
    class Seen:
        radius_q8 = 7680
        fit = array("i", bytes(4 * layouts.FIT_ITEMS))
        outer = inner = array("i", bytes(4 * layouts.RING_ITEMS))

    for outer, inner, is_determined in ((8, 6, True), (7, 7, True), (7, 6, False), (8, 5, False)):
        Seen.fit[layouts.FIT_AREA], Seen.fit[layouts.FIT_INNER_Q10] = 400, 682
        Seen.outer_means, Seen.inner_means = [array("i", [0] * 16 + [400] * 16) for _ in range(2)]
        for means, count in ((Seen.outer_means, outer), (Seen.inner_means, inner)):
            for k in range(count):
                means[16 * k // count] = 32768
        centre = RobustCentre(array("i", bytes(4 * layouts.ROBUST_ITEMS)))
        assert centre.fit(Seen) == is_determined, (outer, inner)


def test_a_radius_is_told_beyond_what_oblique_rows_make_of_it():
    for radius_q8, told_q8 in ((7680, 7684), (15360, 15368)):
        reader = DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None)
        reader.rings.radius_q8 = radius_q8
        found = Detection()
        reader.tell(found)
        assert found.radius_q8 == told_q8


def matrix(slope):
    """Eight parameters, of which the first two are determined together by so much."""
    work = array("i", [BIAS] * 240)
    for row in range(8):
        work[layouts.ROBUST_MATRIX + row * 9] = BIAS + 2400
    work[layouts.ROBUST_MATRIX + 8] = BIAS + slope
    return work


def test_sectors_that_do_not_determine_the_robust_centre():
    # 102 and 100 of 2400 are left of the second parameter
    assert robust.factor_matrix(0, 0, 0, matrix(2349)) == 1
    assert robust.factor_matrix(0, 0, 0, matrix(2350)) == 0


def test_shares_of_a_variance_have_a_limit():
    def variance(beyond):
        return robust.variance_of(0, 0, 0, matrix(0), 0, beyond)

    own, most = 4096 * 256 // 2400, (30000 * 30000 >> 12) * 256 // 2400
    assert variance(937) == own + (29984 * 29984 >> 12) * 256 // 2400
    assert variance(938) == variance(1000) == variance(-1000) == own + most


class Moves:
    """Stands for the kernels of the robust centre: how far each step moves; kinds of weights are noted."""

    def __init__(self, *moves):
        self.moves = list(moves)
        self.kinds = []

    def begin_robust(self, *arguments):
        return 32

    def weigh_sectors(self, a, b, c, work, waves, ratio, kind):
        self.kinds.append(kind)
        work[layouts.ROBUST_SCALE], work[layouts.ROBUST_SQUARE] = 8, 64
        return 2048

    def normal_equations(self, *arguments):
        return 1

    factor_matrix = normal_equations

    def solve_step(self, *arguments):
        return self.moves.pop(0)

    def variance_of(self, *arguments):
        return 0


def test_how_many_steps_lead_to_the_robust_centre():
    class Seen:
        radius_q8 = 7680
        fit = array("i", bytes(4 * layouts.FIT_ITEMS))
        outer = inner = array("i", [100] * layouts.RING_ITEMS)
        outer_means = inner_means = None

    kept = robust_centre.kernels
    try:
        # two from which no outlier is left out, one or two from which they are, and what ends it
        for moves, kinds in (((0, 0, 64), [0, 1, 2, 2]), ((0, 0, 65, 9999), [0, 1, 2, 2, 2])):
            robust_centre.kernels = told = Moves(*moves, 0)
            centre = RobustCentre(array("i", [BIAS] * layouts.ROBUST_ITEMS))
            assert centre.fit(Seen)
            assert told.kinds == kinds and told.moves == [], moves
    finally:
        robust_centre.kernels = kept
