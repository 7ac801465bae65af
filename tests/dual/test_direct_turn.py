"""Limits of telling the turn of a marker by its code, where its orientation line is hidden."""

from larics.arith import fixed
from larics.direct.line_reader import LineReader
from larics.direct.reader import DirectReader
from larics.direct.ring_fit import RingFit
from larics.kernels import layouts
from larics.marker import LARICS3


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
