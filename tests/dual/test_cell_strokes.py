"""What dark cells cost a plain marker, by what lies between and beside them."""

from array import array

from larics.coded.cell_reader import PLAIN, UNKNOWN, CellReader
from larics.marker.id_set import id_set
from shown_cells import BIAS, FRAME, RADIUS, SIDE, WHITE, crossed, look, mirror, reader, show

GREY = 50  # 438 log units darker than the paper
INK = 256  # of a cell


def cost(which, frame=FRAME, tones=(), depths=(), depth=200, mirrored=False):
    """What is told of a plain marker some of whose cells are dark, and what that costs it.

    tones: cell, how much lighter the white beside it is; depths: cell, how dark it is; depth: of ink."""
    cells = reader(mirrored=mirrored)
    look(cells, frame, depth=depth)
    show(cells, 3)
    for cell in which:
        cells.depths[cell] = BIAS + INK
    for cell, lighter in tones:
        cells.depths[48 + cell] = WHITE + lighter
    for cell, darkness in depths:
        cells.depths[cell] = BIAS + darkness
    if mirrored:
        mirror(cells)
    return cells.decide(6 if mirrored else 3), cells._weights[25]


def test_what_is_as_sharp_as_print_costs_more_than_it_weighs():
    for which, expected, costs in (
        ((), PLAIN, 0),
        ((1,), PLAIN, 64 + 32),
        ((0,), PLAIN, 64 + 32),
        ((5,), PLAIN, 64 + 32),
        ((3, 4), PLAIN, 128 + 32),
        ((0, 1, 2), UNKNOWN, 192 + 32),
        ((2, 3), PLAIN, 128 + 64),  # white lies between them
        ((23, 0), PLAIN, 128 + 64),
        ((1, 7), PLAIN, 128 + 64),
        ((1, 7, 13), UNKNOWN, 192 + 96),
    ):
        assert cost(which) == (expected, costs), which


def test_what_crosses_the_white_between_cells_is_no_print():
    for degrees, touched, apart in (
        (45, (2, 3), (1, 4)),
        (98, (6, 7), (5,)),
        (82, (4, 5), (6,)),
        (278, (18,), (17, 19)),
    ):
        frame = crossed(degrees, GREY)
        assert cost(touched, frame)[1] == 0, degrees
        for cell in apart:
            assert cost((cell,), frame)[1] in (64, 64 + 32), (degrees, cell)
    # in all cells that are dark side by side
    assert cost((0, 1, 2, 3, 4, 5), crossed(45, GREY)) == (PLAIN, 0)
    assert cost((0, 1, 2, 4, 5), crossed(45, GREY)) == (UNKNOWN, 128 + 32)
    assert cost((4, 5, 6, 7), crossed(98, GREY)) == (PLAIN, 0)
    assert cost((4, 5, 6, 7), crossed(82, GREY)) == (PLAIN, 0)


def test_how_dark_the_white_between_cells_must_be():
    frame = crossed(45, GREY)
    for depth, costs in ((966, 0), (975, 64)):  # 116 and 115 of 256
        assert cost((2,), frame, depth=depth) == (PLAIN, costs), depth
    for depth, costs in ((2198, 64 + 32), (2155, 64)):  # 51 and 52: no longer as white as beside print
        assert cost((2,), frame, depth=depth) == (PLAIN, costs), depth
    for depth, costs in ((2198, 128 + 64), (2155, 128 + 32)):  # nor what parts cells
        assert cost((2, 3), frame, depth=depth) == (PLAIN, costs), depth
    frame = crossed(45, 255)  # lighter by 84 log units
    for depth, costs in ((422, 64 + 32), (420, 64)):  # 51 and 52
        assert cost((2,), frame, depth=depth) == (PLAIN, costs), depth


def test_cells_beside_a_place_beyond_the_frame_are_not_as_sharp_as_print():
    cells = reader()
    middle = SIDE * 128
    assert cells.measure(
        FRAME, middle, middle + (SIDE // 2 - RADIUS) * 256, RADIUS * 256, 0, 0, 0, 0, 0, 200, False
    )
    show(cells, 3)
    for cell in (2, 14, 21):  # 225 degrees: down to the left
        cells.depths[cell] = BIAS + INK
    assert cells._weigh()
    cells._weigh_strokes()
    assert cells._weights[25] == 64 + 32 + 64 + 64


def test_where_the_tone_beside_cells_changes_an_edge_is_likelier_than_print():
    for lighter, costs in ((50, 64 + 32), (-50, 64 + 32), (51, 62), (75, 32), (99, 1), (100, 0), (200, 0)):
        assert cost((1,), tones=((1, lighter),)) == (PLAIN, costs), lighter
    assert cost((1, 7), tones=((1, 75),)) == (PLAIN, 32 + 64 + 32)
    for cell in (0, 2):  # beside it
        for lighter, costs in ((50, 64 + 32), (51, 64), (100, 64), (101, 32), (-101, 32)):
            assert cost((1,), tones=((cell, lighter),)) == (PLAIN, costs), (cell, lighter)
    for cell, beside in ((2, 3), (6, 5), (0, 23)):  # beyond the white between them
        for lighter, costs in ((50, 64 + 32), (51, 64), (101, 32)):
            assert cost((cell,), tones=((beside, lighter),)) == (PLAIN, costs), (cell, lighter)


def test_cells_that_are_neither_dark_nor_white_are_not_beside_print():
    for darkness, costs in ((51, 64 + 32), (52, 64), (-51, 64 + 32), (-52, 64)):
        for beside in (0, 2):
            assert cost((1,), depths=((beside, darkness),)) == (PLAIN, costs), darkness


def test_what_is_darker_than_ink_costs_as_much():
    for darkness in (460, 461, 900):
        assert cost((1,), depths=((1, darkness),)) == (PLAIN, 64 + 32), darkness


def test_more_than_eight_cells_are_no_strokes():
    frame = crossed(45, GREY)
    assert cost(range(8), frame) == (PLAIN, 128 + 32)  # six of them crossed
    assert cost(range(9), frame) == (UNKNOWN, 9 * 64)


def test_strokes_are_found_in_a_mirror_too():
    for which in ((2, 3), (18,)):
        for degrees in (45, 278):
            frame = crossed(degrees, GREY)
            seen = bytearray(SIDE * SIDE)
            for row in range(SIDE):
                for column in range(SIDE):
                    seen[(SIDE - 1 - row) * SIDE + column] = frame[row * SIDE + column]
            plain, mirrored = cost(which, frame), cost(which, seen, mirrored=True)
            assert plain == mirrored, (which, degrees)


def test_samples_between_cells_lie_a_degree_to_both_sides():
    side = 192
    frame = bytearray([200] * (side * side))
    for row in (99, 102):  # 1.3 px beside the middle of a place that is 77 px away
        for column in range(170, side):
            frame[row * side + column] = GREY
    cells = CellReader(side, side, id_set(None, True, False), array("i", bytes(4 * 400)), False)
    assert cells.measure(frame, 100 << 8, (100 << 8) + 64, 50 << 8, 0, 0, 0, 0, 8192, 200, False)
    show(cells, 3)
    cells.depths[2] = BIAS + INK
    assert cells._weigh()
    cells._weigh_strokes()
    assert cells._weights[25] == 0


def test_a_word_that_is_certain_is_no_stroke():
    cells = reader()
    look(cells, crossed(45, GREY))
    show(cells, 10)  # cells 0, 1, 2, 3, 6, 8, 18, 19
    assert cells.decide(2) == 10 and cells._weights[25] == 8 * 64
    for cell in (6, 8, 18, 19):
        cells.depths[cell] = BIAS + 128  # neither dark nor white
    assert cells.decide(2) == UNKNOWN and cells._weights[25] == 0
