"""Which words cells and lines may stand for: the search for the likeliest, and when one is believed."""

from array import array

from larics.arith import fixed
from larics.kernels import cell_search, cell_words
from larics.marker import golay
from larics.marker.id_set import id_set
from shown_cells import BIAS, ID


def search(shown, shown_lines):
    """What `likeliest_words` finds for 24 weights of cells and three of lines: ID, cost, second's cost."""
    weights = array("i", [BIAS + weight for weight in shown] + [0, 0])
    lines = array("i", [BIAS + weight for weight in shown_lines] + [0])
    rows, found = array("i", bytes(4 * cell_search.SCRATCH)), array("i", bytes(12))
    allowed = id_set(None, True, False)
    cell_search.likeliest_words(rows, 0, 0, weights, fixed.CELL_ROWS, lines, allowed, found)
    return list(found[:3])


def test_a_search_that_takes_long_is_ended_with_what_is_known():
    """As a harsh frame had it; of the words that are left none costs less than 180 in all."""
    shown = (0, 0, 0, 0, 0, 17, 41, 41, 43, 64, 64, 64, -64, 64, 64, 64, 64, 64, 52, 26, -64, -18, -64, -64)
    assert search(shown, (64, -32, 64)) == [4021, 18, 180]  # all words of three changes show 210


def test_a_search_is_ended_after_a_hundred_words():
    """After two hundred it would be known that no second costs less than 160."""
    shown = (
        0, -64, 55, -64, -52, 0, -26, 0, 0, 0, -18, 0, 64, -64, -30, -23, -64, 55, 0, 64, 0, 64, -64, 64
    )  # fmt: skip
    assert search(shown, (64, -32, 64)) == [357, 156, 149]


def test_a_search_goes_on_while_it_takes_little():
    """As a marker at the border had it: of words that are left none costs less than 191."""
    shown = [-61, -57, -59, -64, -64, -64, -26] + 8 * [0] + [-63] + 8 * [-64]
    assert search(shown, (64, -32, 64)) == [0, 0, 192]


def test_a_search_goes_on_while_the_second_may_leave_the_first_to_be_told():
    """As a covered marker had it: words of three changes tell that the second costs 96, and not 90."""
    shown = (0, 0, 0, 64, 0, 64, 64, 64, 0, 0, 64, 64, 25, 0, 26, 23, -43, -42, 19, -42, -43, 20, 20, -13)
    assert search(shown, (-32, 64, 64)) == [4078, 0, 96]


def test_what_leaves_no_doubt_of_a_word():
    """Of the eight cells that tell the least; more where one of them tells nothing."""
    dark = golay.cells(ID)
    lines = array("i", (BIAS, BIAS, BIAS, 0))
    for least, is_certain in (
        ([24] * 8, 1),
        ([23] + [24] * 7, 0),
        ([0] + [57] * 6 + [58], 1),
        ([0] + [57] * 7, 0),
    ):
        shown = least + [64] * 16
        weights = [BIAS + (shown[cell] if dark >> cell & 1 else -shown[cell]) for cell in range(24)]
        found = cell_search.certain_word(
            0, 0, array("i", bytes(36)), array("i", weights), fixed.CELL_ROWS, lines, array("i", bytes(12))
        )
        assert found == is_certain, least


def test_by_how_much_a_word_must_cost_less_than_the_second():
    for lines_id, told, turned, gap in (
        (5, ID, 0, 48),
        (0, ID, 0, 110),  # without lines that agree
        (56, ID, 0, 110),
        (16 + 5, ID, 0, 78),  # with one in doubt
        (5, 0, 0, 45),
        (5, ID, 1, 78),
    ):
        for short, believed in ((0, 1 + told), (1, 0)):
            weights, result = (
                array("i", bytes(4 * cell_words.WEIGHTS)),
                array("i", (told, 0, gap - short)),
            )
            weights[25] = 0 if told == 0 else 500
            found = cell_words.believed_word(lines_id, 0, turned, weights, result)
            assert found & 4095 == believed, (lines_id, told, turned, gap - short)


def test_the_more_cells_tell_nothing_the_more_a_second_word_must_cost():
    for lines_id, blank, gap, believed in (
        (5, 4, 48, True),
        (5, 5, 55, False),
        (5, 5, 56, True),
        (5, 9, 87, False),
        (5, 9, 88, True),
        (0, 9, 110, True),  # without lines it must anyway
        (16 + 5, 9, 78, True),
    ):
        weights, result = array("i", bytes(4 * cell_words.WEIGHTS)), array("i", (ID, 0, gap))
        weights[25], weights[27] = 500, blank
        found = cell_words.believed_word(lines_id, 0, 0, weights, result)
        assert (found & 4095) == (1 + ID if believed else 0), (lines_id, blank, gap)


def test_the_more_cells_tell_little_the_more_a_second_word_must_cost_too():
    for lines_id, blank, little, gap, believed in (
        (5, 0, 10, 48, True),
        (5, 0, 11, 63, False),
        (5, 0, 11, 64, True),
        (5, 3, 12, 79, False),
        (5, 3, 12, 80, True),
        (5, 9, 12, 87, False),  # what demands more counts
        (5, 9, 12, 88, True),
        (0, 3, 14, 110, True),
    ):
        weights = array("i", bytes(4 * cell_words.WEIGHTS))
        weights[25], weights[27], weights[28] = 500, blank, little
        found = cell_words.believed_word(lines_id, 0, 0, weights, array("i", (ID, 0, gap)))
        assert (found & 4095) == (1 + ID if believed else 0), (lines_id, blank, little, gap)


def test_what_a_word_may_cost_and_what_makes_it_sure():
    for lines_id, told, turned, cost, gap, plain, margin in (
        (5, ID, 1, 80, 140, 500, 54),  # where the orientation line is not seen, a word may cost no more
        (5, ID, 1, 81, 142, 500, None),
        (5, ID, 0, 81, 142, 500, 56),
        (5, ID, 0, 29, 78, 500, 0),  # with lines, 48 and what it contradicts, or 78
        (5, ID, 0, 29, 76, 500, None),
        (5, ID, 0, 30, 78, 500, 0),
        (5, ID, 0, 44, 78, 500, 0),
        (16 + 5, ID, 0, 30, 138, 0, 0),  # with one in doubt, 78 and twice that
        (16 + 5, ID, 0, 30, 137, 0, None),
        (16 + 1, ID, 0, 0, 400, 0, None),  # the others must agree
        (32 + 1, ID, 0, 0, 400, 0, 255),
        (5, ID, 0, 100, 175, 500, 85),  # seven quarters of what it contradicts
        (5, ID, 0, 100, 174, 500, None),
        (5, 0, 0, 200, 100, 200, 48),  # of the empty word a half
        (5, 0, 0, 200, 99, 200, None),
        (0, ID, 0, 0, 110 + 144, 0, 127),
        (0, ID, 0, 0, 110 + 288, 0, 255),
        (0, ID, 0, 0, 110 + 287, 0, 254),
    ):
        weights, result = (
            array("i", bytes(4 * cell_words.WEIGHTS)),
            array("i", (told, cost, cost + gap)),
        )
        weights[25] = plain
        found = cell_words.believed_word(lines_id, 0, turned, weights, result)
        assert found == (0 if margin is None else 1 + told + (margin << 12)), (told, turned, cost, gap)
