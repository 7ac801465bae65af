"""Weighing all evidence on a plain marker, where rules on each quantity alone refuse it."""

from array import array

from larics.arith.fixed import cos_q14, sin_q14
from larics.coded.cell_reader import PLAIN, UNKNOWN
from larics.detect.detector import Detector
from larics.direct.acceptance import Acceptance
from larics.direct.evidence import Evidence
from larics.direct.line_reader import LineReader
from larics.direct.reader import DirectReader
from larics.kernels import evidence as kernels
from larics.kernels import layouts
from larics.marker import LARICS3, verdicts
from larics.marker.id_set import id_set
from marker_drawing import draw
from test_detector import heap_lock, heap_unlock
from test_direct_acceptance import BIAS, Lines, Rings

ZERO = 1 << 15
IDS = id_set((1, 2, 3, 4, 5, 6, 7), False, False)
WIDTH, HEIGHT = 136, 128


def items_of(kernel_items):
    return [item - BIAS for item in kernel_items]


def test_a_stroke_differs_from_both_sides_alike():
    profile = array("H", [900] * 64)
    profile[10] = 800  # dark
    profile[30] = 950  # bright
    for place in range(45, 64):  # an edge
        profile[place] = 700
    depths = array("H", [0] * 64)
    kernels.stroke_depths(profile, 0, 0, 64, 5, 100, depths)
    assert depths[10] - ZERO == 256 and depths[30] - ZERO == -128
    assert [k for k in range(64) if depths[k] != ZERO] == [10, 30]
    profile[12] = 850  # the side that differs less counts
    profile[15] = 860
    kernels.stroke_depths(profile, 0, 0, 64, 5, 100, depths)
    assert depths[10] - ZERO == 153
    profile[5] = 0  # beyond the frame
    kernels.stroke_depths(profile, 0, 0, 64, 5, 100, depths)
    assert depths[10] == ZERO


def test_what_crosses_a_circle_is_seen_twice():
    depths = array("H", [ZERO] * 64)
    found = array("i", [0, 0])
    for place, depth in ((3, 200), (60, 190), (20, 120), (40, -80), (52, -60)):
        depths[place] = ZERO + depth
    kernels.second_strokes(depths, 0, 0, 64, 10, found)
    assert list(found) == [120, 60]  # 60 lies 7 directions from 3: the same one
    kernels.second_strokes(depths, 0, 0, 64, 6, found)
    assert list(found) == [190, 60]


def test_no_stroke_is_deeper_than_a_table_asks_about():
    for grey, expected in ((100, ZERO + 4095), (60000, ZERO - 4095)):
        profile = array("H", [30000] * 64)
        profile[10] = grey
        depths = array("H", [0] * 64)
        kernels.stroke_depths(profile, 0, 0, 64, 5, 1, depths)
        assert depths[10] == expected


SIDE = 280  # a frame in whose middle a ring of 100 px may lie


def strokes_seen(patches):
    """Evidence that has looked around rings of 100 px on even white, where patches [(first angle, last one,
    1/256 turn, least distance from the middle between the rings, px)] are dark."""
    rings = Rings()
    rings.resize(100 << 8)
    rings.area, rings.line_q10 = 2000, 117
    for item in (layouts.FIT_TRUE_X_Q10, layouts.FIT_TRUE_Y_Q10):
        rings.fit[item] = BIAS + (SIDE // 2 << 10)
    rings.fit[layouts.FIT_WIDTH] = rings.fit[layouts.FIT_HEIGHT] = SIDE
    frame = bytearray([200] * SIDE * SIDE)
    for first, last, least_px in patches:
        for step in range(first * 8, last * 8 + 1):
            angle_turn16 = step * 32
            for radius in range(8333 + round(100 * least_px), 9500, 30):  # px / 100
                x = SIDE // 2 + (radius * cos_q14(angle_turn16) // 100 + 8192 >> 14)
                y = SIDE // 2 + (radius * sin_q14(angle_turn16) // 100 + 8192 >> 14)
                frame[y * SIDE + x] = 60
    reader = LineReader(LARICS3, 175)
    evidence = Evidence(LARICS3, reader)
    assert evidence.look_around(frame, rings, reader)
    return evidence


def test_where_strokes_between_the_rings_are_looked_for():
    # two samples, 1.95 px inside and outside the middle
    for least_px, seen in ((-5, True), (1.7, True), (2.7, False)):
        evidence = strokes_seen([(62, 66, least_px)])
        assert (evidence._gap[64 // 2] > ZERO + 100) == seen, least_px


def test_strokes_are_held_against_what_lies_a_little_beside_them():
    evidence = strokes_seen([(30, 34, -5), (50, 54, -5)])
    assert evidence._gap[32 // 2] > ZERO + 100 and evidence._gap[52 // 2] > ZERO + 100


def test_a_second_stroke_lies_some_way_from_the_first():
    for apart, second in ((14, 0), (20, 564), (28, 564)):  # 1/256 of a turn
        evidence = strokes_seen([(30, 34, -5), (30 + apart, 34 + apart, -5)])
        assert list(evidence._crossing) == [second, 0], apart


def bit_items(lines, rings, bit=2, gap=(), inside=(), crossing=(0, 0)):
    light = array("i", [500, 500, 0, 31, 17, 5])
    circles = [array("H", [ZERO] * 64) for _ in range(2)]
    for circle, strokes in zip(circles, (gap, inside)):
        for place, depth in strokes:
            circle[place] = ZERO + depth
    items = array("i", [0] * 20)
    kernels.bit_items(
        items, lines.code, light, rings.fit, rings.inner_means, circles[0], circles[1],
        array("i", crossing), 64, lines.angle_turn16, bit,
    )  # fmt: skip
    return items_of(items)


def test_what_is_weighed_of_a_bit():
    rings = Rings()
    lines = Lines(5)  # lines of 256 at the positions 2 and 6
    lines.deepen(4, 40)
    lines.put(4, layouts.POSITION_NEAR, 9)
    lines.put(4, layouts.POSITION_FAR, 4)
    lines.put(4, layouts.POSITION_ROUGH, 77)
    lines.put(4, layouts.POSITION_LEVEL, 530)
    lines.put(0, layouts.POSITION_LEVEL, 510)
    # the second bit lies half a turn from the orientation line: directions 32 of 64, sectors 7 and 8
    rings.inner_means[16 + 7] = 500
    rings.inner_means[16 + 8] = 700
    found = bit_items(
        lines, rings, 2, gap=((31, 50), (34, -60), (35, 99)), inside=((30, 70), (33, -80), (29, 99)),
        crossing=(11, 12),
    )  # fmt: skip
    area = 1000 + 1
    near, far = 500 * 256 // area, 700 * 256 // area
    assert found[:10] == [40, 33, 47, 13, 4, 77, 530, 30, -20, 256]
    assert found[10:14] == [40 * 256 // ((near + far) // 2), near, far, area * 16 // (7680 // 64)]
    assert found[14:] == [11, 12, 50, 60, 70, 80]
    # where a line was expected the other sector alone says how dark it should be
    rings.inner_means[16 + 8] = 0
    found = bit_items(lines, rings)
    assert found[10:13] == [40 * 256 // near, 0, near]
    rings.inner_means[16 + 7] = 30  # a ring that is hidden says nothing
    assert bit_items(lines, rings)[10] == 40 * 256 // 64


def test_what_is_weighed_of_a_direction():
    rings = Rings()
    rings.outer_means = array("i", [1000] * 32)
    rings.outer_means[16 + 15] = 300
    rings.inner_means[16] = 600
    lines = Lines(6)
    lines.deepen(0, 5)
    lines.deepen(2, 200)
    lines.deepen(6, -30)
    for item, value in (
        (layouts.CROSSING_AREA, 210),
        (layouts.CROSSING_GAP, 20),
        (layouts.CROSSING_DISTANCE, 130),
        (layouts.CROSSING_SLOPE, 14),
    ):
        lines.line[item] = value
    items = array("i", [0] * 20)
    light = array("i", [500, 500, 0, 31, 17, 5])
    kernels.line_items(
        items, lines.line, lines.code, light, rings.fit, rings.outer_means, rings.inner_means, 0, 66
    )
    area = 1000 + 1
    assert items_of(items)[:15] == [
        210,
        20,
        130,
        14,
        66,
        5,
        256,
        200,
        31,
        17,
        5,
        300 * 256 // area,
        1000 * 256 // area,
        (1000 * 256 // area + 600 * 256 // area) // 2,
        area * 16 // (7680 // 64),
    ]


def test_a_pair_of_comparisons_adds_one_of_four_numbers():
    table = array("H", (3 | 5 << 8, 4096 + 10, 4096 - 7, ZERO - 400, ZERO + 1, ZERO + 20, ZERO + 300))
    for first, second, expected in ((10, -7, -400), (10, -6, 1), (11, -7, 20), (11, -6, 300)):
        items = array("i", [BIAS] * 20)
        items[3] += first
        items[5] += second
        assert kernels.weigh(items, table, 1) == expected
    assert kernels.weigh(items, table, 0) == 0
    twice = array("H", list(table) * 2)
    assert kernels.weigh(items, twice, 2) == 600


class Weighed(Evidence):
    """Evidence with given weights; shallower: of each position's halves."""

    def __init__(self, lines=(), bits=(0, 0, 0), shallower=0, stray_half=0):
        super().__init__(LARICS3, LineReader(LARICS3, 175))
        self.of_lines, self.of_bits, self.shallower = lines, bits, shallower
        self._light[4] = stray_half
        self.measured = []

    def weigh_line(self, lines, rings):
        return self.of_lines[self.measured[-1]]

    def weigh_bit(self, lines, rings, bit):
        self.items[1] = BIAS + self.shallower
        return self.of_bits[bit - 1]

    def look_around(self, frame, rings, lines):
        return lines.code_inside

    # as lines
    def list_directions(self, frame, rings, most):
        assert most == 4
        return len(self.of_lines)

    def measure_direction(self, frame, rings, index):
        self.measured.append(index)
        return 95 if self.of_lines[index] == 5000 else 96

    def measure_around(self, frame, rings):
        return self.measured[-1] < 9


def test_one_direction_must_surely_be_the_lines_and_no_other():
    for weights, expected in (
        ((768,), 0),
        ((767,), None),
        ((-300, 768, -1), 1),
        ((0, 900), 1),
        ((1, 900), None),
        ((900, 1), None),
        ((900, 0, 0, 2000), None),
        ((900, 5000), 0),  # too pale to be looked at
        ((), None),
    ):
        evidence = Weighed(weights)
        assert evidence.find_line(None, None, evidence) == (expected is not None), weights
        if expected is not None:
            assert evidence.measured[-1] == expected
    evidence = Weighed((900,) + (-900,) * 9)
    assert not evidence.find_line(None, None, evidence)  # the tenth lies beyond the frame


def weighed_bits(bits, shallower=0, stray_half=0):
    evidence = Weighed((), bits, shallower, stray_half)
    lines = Lines()
    lines.read_code = lambda frame, rings: None
    assert evidence.weigh_bits(None, None, lines)
    lines.code_inside = 0
    assert not evidence.weigh_bits(None, None, lines)
    return evidence


def test_every_bit_must_be_sure():
    for bits, expected, margin in (
        ((900, -900, 900), 5, 0),
        ((899, -900, 900), 0, 0),
        ((1000, -950, 906), 5, 1),
        ((-1000, -1000, 1600), 1, 16),
        ((-1000, -899, 1600), 0, 0),
        ((2429, -2430, 2430), 5, 254),
        ((3000, 3000, 3000), 7, 255),
        ((-3000, -3000, -3000), 0, 255),
    ):
        evidence = weighed_bits(bits)
        assert (evidence.told(), evidence.margin) == (expected, margin), bits


def test_a_line_that_has_nearly_faded_is_no_0():
    assert weighed_bits((2000, -2000, 2000), 15).told() == 5
    assert weighed_bits((2000, -2000, 2000), 16).told() == 0
    assert weighed_bits((2000, -2000, 2000), 46, 31).told() == 5
    assert weighed_bits((2000, -2000, 2000), 47, 31).told() == 0
    assert weighed_bits((2000, 2000, 2000), 300).told() == 7


def test_a_bit_that_the_rules_tell_must_be_believed():
    for bits, expected in (
        ((400, -400, 400), False),
        ((399, -400, 400), True),
        ((400, -399, 400), True),
        ((400, 900, 400), True),
        ((400, -400, -900), True),
    ):
        assert weighed_bits(bits).denies(5) == expected, bits


class Cells:
    """Cells that say whether a marker is plain, with a margin."""

    def __init__(self, told, margin):
        self.told, self.margin = told, margin

    def decide(self, lines_id, is_turned=False):
        assert lines_id == 5
        return self.told


def weighed_verdict(
    lines_id=5, margin=90, cells=None, stroke_q8=0, pose_margin=255, verdict=verdicts.NOT_EMPTY
):
    acceptance = Acceptance(IDS, 16)
    acceptance.pose_margin = pose_margin
    acceptance.margin = 77
    lines = Lines()
    lines.stroke_q8 = stroke_q8
    return (
        acceptance.weighed(lines_id, margin, lines, cells, verdict),
        acceptance.marker_id,
        acceptance.margin,
    )


def test_what_the_evidence_tells_is_accepted_of_plain_markers():
    told, refused = (verdicts.ACCEPTED, 5), (verdicts.NOT_EMPTY, -1, 77)
    assert weighed_verdict() == told + (90,)
    assert weighed_verdict(0) == refused
    assert weighed_verdict(margin=16) == told + (16,)
    assert weighed_verdict(margin=15) == refused
    assert weighed_verdict(pose_margin=40) == told + (40,)
    assert weighed_verdict(pose_margin=15) == refused
    assert weighed_verdict(cells=Cells(PLAIN, 60)) == told + (60,)
    assert weighed_verdict(cells=Cells(PLAIN, 15)) == refused
    assert weighed_verdict(cells=Cells(UNKNOWN, 60)) == refused
    assert weighed_verdict(cells=Cells(1261, 60)) == refused
    assert weighed_verdict(stroke_q8=200) == told + (90,)
    assert weighed_verdict(stroke_q8=201) == refused  # a cable goes on beyond a coding line
    assert weighed_verdict(0, verdict=verdicts.ID_UNCERTAIN) == (verdicts.ID_UNCERTAIN, -1, 77)
    assert weighed_verdict(0, verdict=verdicts.ACCEPTED) == refused  # of a line that the rules refuse


def test_an_id_that_is_denied_leaves_the_place():
    acceptance = Acceptance(IDS, 16)
    for margin, expected in ((112, verdicts.ID_UNCERTAIN), (111, verdicts.NOT_EMPTY)):
        acceptance.margin = margin
        acceptance.marker_id = 3
        assert acceptance.deny() == expected
        assert acceptance.marker_id == -1


class Judged:
    """Stands for evidence that denies everything, or tells the ID 6."""

    def __init__(self, measured=True):
        self.measured, self.margin, self.calls = measured, 90, 0

    def weigh_bits(self, frame, rings, lines):
        self.calls += 1
        return self.measured

    def denies(self, marker_id):
        return True

    def told(self):
        return 6


def reader_verdict(verdict, marker_id=5, margin=127, is_weighed=False, measured=True):
    reader = DirectReader(WIDTH, HEIGHT, LARICS3, 175, 7680, IDS, 16, None)
    reader.evidence = Judged(measured)
    reader.is_weighed = is_weighed
    reader.acceptance.marker_id, reader.acceptance.margin = marker_id, margin
    found = reader._weigh_bits(None, verdict)
    return found, reader.acceptance.marker_id, reader.evidence.calls


def test_a_board_with_little_memory_does_without():
    assert Detector(WIDTH, HEIGHT, 24, 30, second_opinion=False).direct.evidence is None


def test_when_the_evidence_is_asked():
    accepted = verdicts.ACCEPTED
    assert reader_verdict(accepted) == (verdicts.ID_UNCERTAIN, -1, 1)
    assert reader_verdict(accepted, margin=128) == (accepted, 5, 0)  # the rules are kept by far
    assert reader_verdict(accepted, 8, 20) == (accepted, 8, 0)  # the cells told it
    # a coded marker whose line the rules refuse
    assert reader_verdict(accepted, 8, 64, is_weighed=True) == (accepted, 8, 0)
    assert reader_verdict(accepted, 8, 63, is_weighed=True)[0] == verdicts.NOT_EMPTY
    assert reader_verdict(accepted, measured=False) == (accepted, 5, 1)
    assert reader_verdict(verdicts.NOT_EMPTY, -1) == (accepted, 6, 1)
    assert reader_verdict(verdicts.ID_UNCERTAIN, -1) == (accepted, 6, 1)
    assert reader_verdict(verdicts.ID_UNCERTAIN, -1, measured=False) == (verdicts.ID_UNCERTAIN, -1, 1)
    assert reader_verdict(accepted, margin=200, is_weighed=True) == (accepted, 6, 1)
    assert reader_verdict(accepted, is_weighed=True, measured=False)[0] == verdicts.NOT_EMPTY


def paint(frame, x, y, half, grey):
    for row in range(y - half, y + half + 1):
        for column in range(x - half, x + half + 1):
            frame[row * WIDTH + column] = grey(frame[row * WIDTH + column])


def found(frame):
    finder = Detector(WIDTH, HEIGHT, 24, 30, family=LARICS3)
    return [(marker.marker_id, marker.flags) for marker in finder.detect(frame)], finder.direct


def test_a_stain_beside_the_coding_lines_is_no_line():
    frame = draw(WIDTH, HEIGHT, 5, 1085, 1022, 430, 0)
    paint(frame, 68 + 6, 64 - 7, 2, lambda grey: 40)  # halfway between two positions of lines
    markers, reader = found(frame)
    assert markers == [(5, 0)]
    reader.evidence.told = lambda: 0
    assert reader_is_silent(reader, frame)


def test_weighing_allocates_nothing():
    stained = draw(WIDTH, HEIGHT, 5, 1085, 1022, 430, 0)
    paint(stained, 68 + 6, 64 - 7, 2, lambda grey: 40)
    beyond = draw(WIDTH, HEIGHT, 6, 1085, 1022, 430, 0)
    paint(beyond, 113, 64, 2, lambda grey: 70)
    finder = Detector(WIDTH, HEIGHT, 24, 30, family=LARICS3)
    finder.detect(stained)
    finder.detect(beyond)
    ids = 0
    heap_lock()
    try:
        for one in finder.detect(stained):
            ids = ids * 8 + one.marker_id
        for one in finder.detect(beyond):
            ids = ids * 8 + one.marker_id
    finally:
        heap_unlock()
    assert ids == 5 * 8 + 6


def reader_is_silent(reader, frame):
    """Whether the rules alone tell no ID."""
    finder = Detector(WIDTH, HEIGHT, 24, 30, family=LARICS3)
    finder.direct.evidence = reader.evidence
    finder.blur_reader = None
    return all([marker.marker_id < 0 for marker in finder.detect(frame)])


def test_a_line_beyond_whose_end_a_stain_lies_and_one_with_a_rival():
    for columns, rows in ((range(111, 116), range(62, 66)), (range(66, 70), range(22, 34))):
        frame = draw(WIDTH, HEIGHT, 6, 1085, 1022, 430, 0)
        for x in columns:
            for y in rows:
                frame[y * WIDTH + x] = 70
        markers, reader = found(frame)
        assert markers == [(6, 0)], columns
        reader.evidence.find_line = lambda frame, rings, lines: False
        assert reader_is_silent(reader, frame), columns


class Counted:
    """Stands for evidence that finds what it is told to find."""

    def __init__(self, finds):
        self.finds, self.calls = finds, 0

    def find_line(self, frame, rings, lines):
        self.calls += 1
        return self.finds


def test_one_place_of_a_frame_is_weighed_in_vain():
    reader = DirectReader(WIDTH, HEIGHT, LARICS3, 175, 7680, IDS, 16, None)
    reader.evidence = Counted(False)
    reader._examine = lambda *place: verdicts.NOT_EMPTY
    assert [reader._weigh_lines(None) for _ in range(3)] == [False] * 3 and reader.evidence.calls == 1
    reader.begin()
    reader.evidence.finds = True
    assert [reader._weigh_lines(None) for _ in range(3)] == [True] * 3  # markers are all weighed
    reader.is_weighed = True
    assert reader.examine(None, None, 1, 0, 0, 0) == verdicts.NO_ORIENTATION
    assert not reader._weigh_lines(None) and reader.evidence.calls == 4  # but what is none in the end
    reader.begin()
    assert reader._weigh_lines(None)


def test_each_frame_is_weighed_anew():
    frame = draw(WIDTH, HEIGHT, 6, 1085, 1022, 430, 0)
    paint(frame, 113, 64, 2, lambda grey: 70)
    finder = Detector(WIDTH, HEIGHT, 24, 30, family=LARICS3)
    finder.direct._in_vain = 1
    assert [marker.marker_id for marker in finder.detect(frame)] == [6]
