"""What cells that were measured tell: weights, the likeliest words, and the limits of a decision."""

from array import array

from larics.arith import fixed
from larics.coded.cell_reader import PLAIN, UNKNOWN, CellReader
from larics.kernels import cell_search, cell_words, layouts
from larics.kernels import cells as cells_kernels
from larics.marker import golay, mirrored_lines
from larics.marker.id_set import id_set

BIAS = 1 << 24
WHITE = 900
ID = 1261  # lines of 5


def reader(allowed=None, mirrored=False):
    return CellReader(360, 296, id_set(allowed, True, False), array("i", bytes(4 * 400)), mirrored)


def show(cells, marker_id, turn=0):
    """As a sharp picture shows the cells of a marker; `turn` quarter turns clockwise."""
    dark = golay.cells(marker_id) if marker_id > 7 else 0
    for cell in range(24):
        is_dark = dark >> (cell + 6 * turn) % 24 & 1
        cells.depths[cell] = BIAS + (360 if is_dark else 0)
        cells.depths[24 + cell] = WHITE - (360 if is_dark else 0)
        cells.depths[48 + cell] = WHITE
    return dark


def mirror(cells):
    """Exchanges left and right of what is shown."""
    for cell in range(12):
        for row in range(3):
            a, b = 24 * row + cell, 24 * row + 23 - cell
            cells.depths[a], cells.depths[b] = cells.depths[b], cells.depths[a]


def cover(cells, which, tone):
    """Hides cells under something of another tone."""
    for cell in which:
        cells.depths[cell] = BIAS
        cells.depths[24 + cell] = cells.depths[48 + cell] = tone


def test_what_is_shown_is_told():
    cells = reader()
    for marker_id in (9, ID, 4094):
        show(cells, marker_id)
        assert cells.decide(marker_id & 7) == marker_id and cells.margin == 255
        assert cells.decide(0) == marker_id
    show(cells, 3)
    assert cells.decide(3) == PLAIN and cells.margin == 255


def test_lines_must_agree():
    cells = reader()
    show(cells, ID)
    assert cells.decide(4) == UNKNOWN
    mirrored = reader(mirrored=True)
    show(mirrored, ID)
    mirror(mirrored)
    assert mirrored.decide(5) == ID  # the lines of 5 are those of 5 in a mirror


def test_what_is_covered_is_left_out_by_its_tone():
    cells = reader()
    show(cells, ID)
    whole = cells.margin
    cover(cells, range(6), WHITE - 250)
    assert cells.decide(5) == ID
    # of the same tone as the plate it looks like white cells that contradict the word
    show(cells, ID)
    cover(cells, range(12), WHITE)
    assert cells.decide(5) == UNKNOWN
    show(cells, ID)
    cover(cells, range(16), WHITE - 250)
    assert cells.decide(5) == UNKNOWN and whole == 0


def test_fewer_rivals_let_more_be_covered():
    for marker_id in (122, 1261, 2222, 3973):
        told = []
        for allowed in (None, [122, 1261, 2222, 3973]):
            cells = reader(allowed)
            show(cells, marker_id)
            cover(cells, range(11), WHITE - 250)
            told.append(cells.decide(0))
        assert told[1] == marker_id and told[0] in (UNKNOWN, marker_id)


def test_ink_in_a_shadow_is_less_dark():
    cells = reader()
    dark = show(cells, ID)
    for cell in range(9):
        cells.depths[48 + cell] = WHITE - 220
        cells.depths[cell] = BIAS + (200 if dark >> cell & 1 else 0)
    assert cells.decide(5) == ID and cells.margin > 80


def test_three_contradictions_are_no_id():
    cells = reader()
    dark = show(cells, ID)
    wrong = [cell for cell in range(24) if dark >> cell & 1]
    cover(cells, wrong[:1], WHITE)
    assert cells.decide(5) == ID
    cover(cells, wrong[:3], WHITE)
    assert cells.decide(5) == UNKNOWN


def search(shown, shown_lines):
    """What `likeliest_words` finds for 24 weights of cells and three of lines: ID, cost, second's cost."""
    weights = array("i", [BIAS + weight for weight in shown] + [0, 0])
    lines = array("i", [BIAS + weight for weight in shown_lines] + [0])
    rows, found = array("i", bytes(4 * cell_search.SCRATCH)), array("i", bytes(20))
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


def test_too_few_cells_tell_nothing():
    cells = reader()
    show(cells, ID)
    for cell in range(13):
        cells.depths[cell] = 0  # outside the frame
    assert cells.decide(5) == UNKNOWN


def test_half_of_the_cells_are_enough():
    for outside, are_enough in ((12, True), (13, False)):
        cells = reader()
        show(cells, ID)
        for cell in range(outside):
            cells.depths[cell] = 0
        assert bool(cells._weigh()) == are_enough


def test_where_twenty_cells_are_white_one_of_another_tone_is_believed_by_half():
    for outside, weight in ((4, -32), (5, 0)):
        cells = reader()
        show(cells, 3)
        for cell in range(outside):
            cells.depths[cell] = 0
        cover(cells, [23], WHITE - 250)
        assert cells._weigh() and cells._weights[23] - BIAS == weight, outside


def test_a_cell_in_which_a_lamp_is_mirrored_tells_nothing():
    for level, weight in ((1023, -64), (1024, 0)):
        cells = reader()
        dark = show(cells, ID)
        white = [cell for cell in range(24) if not dark >> cell & 1][0]
        cells.depths[24 + white] = level
        assert cells._weigh() and cells._weights[white] - BIAS == weight, level


def test_a_cell_much_lighter_than_the_white_beside_it_tells_nothing():
    for depth, weight in ((-128, -64), (-129, 0)):
        cells = reader()
        dark = show(cells, ID)
        white = [cell for cell in range(24) if not dark >> cell & 1][0]
        cells.depths[white] = BIAS + depth
        assert cells._weigh() and cells._weights[white] - BIAS == weight, depth


def test_how_dark_the_fourth_cell_of_a_coded_marker_is():
    for depth, weight in ((154, 64), (153, 20)):  # else levels are those of a plain one, 0 to 256
        cells = reader()
        show(cells, 3)
        for cell in (1, 8, 13, 20):
            cells.depths[cell] = BIAS + depth
        assert cells._weigh() and cells._weights[8] - BIAS == weight, depth


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
            0, 0, array("i", bytes(36)), array("i", weights), fixed.CELL_ROWS, lines, array("i", bytes(20))
        )
        assert found == is_certain, least


def test_cells_are_believed_less_the_more_light_is_on_them():
    dark = golay.cells(ID)
    white_cell = [cell for cell in range(24) if not dark >> cell & 1][0]
    dark_cell = [cell for cell in range(24) if dark >> cell & 1][0]
    for cell, lighter, weight in (
        (white_cell, 50, -64),  # log units
        (white_cell, 51, -64),
        (white_cell, 54, -62),
        (white_cell, 100, -32),
        (white_cell, 149, -1),
        (white_cell, 150, 0),
        (dark_cell, 200, 64),
        (dark_cell, 204, 61),
        (dark_cell, 250, 32),
        (dark_cell, 300, 0),
    ):
        cells = reader()
        show(cells, ID)
        cells.depths[48 + cell] = WHITE + lighter
        assert cells._weigh() and cells._weights[cell] - BIAS == weight, (cell == dark_cell, lighter)


def test_from_which_shade_ink_counts_as_less_dark():
    for shade, weight in ((60, 0), (61, 20)):
        cells = reader()
        cell = [cell for cell in range(24) if show(cells, ID) >> cell & 1][0]
        cells.depths[cell] = BIAS + 168
        cells.depths[48 + cell] = WHITE - shade
        assert cells._weigh() and cells._weights[cell] - BIAS == weight, shade


def test_ink_fades_and_white_stays_unless_noise_strays_as_far():
    frame = bytearray(b"\xc8" * (360 * 296))
    for noisy, depth, weight in (
        (False, 95, -17),
        (False, 96, 0),
        (False, 168, 0),
        (False, 169, 17),
        (False, 0, -64),
        (True, 145, -17),
        (True, 146, 0),
        (True, 217, 0),
        (True, 218, 17),
    ):
        cells = reader()
        assert cells.measure(frame, 180 << 8, 148 << 8, 30 << 8, 0, 0, 0, 0, 0, 200, noisy)
        dark = show(cells, ID)
        cell = [cell for cell in range(24) if dark >> cell & 1][0]
        cells.depths[cell] = BIAS + depth
        assert cells._weigh() and cells._weights[cell] - BIAS == weight, (noisy, depth)


def test_lines_that_are_read_count_beside_one_in_doubt():
    for lines_id, told in ((5, ID), (8 + 4, ID), (16 + 5, ID), (56, ID), (8 + 6, UNKNOWN), (16 + 4, UNKNOWN)):
        cells = reader()
        show(cells, ID)
        assert cells.decide(lines_id) == told, lines_id
        cells = reader(mirrored=True)
        show(cells, ID)
        mirror(cells)
        lines_id = mirrored_lines(lines_id & 7) | mirrored_lines(lines_id >> 3) << 3
        assert cells.decide(lines_id) == told, lines_id
    # seven of the eight cells hidden in which a rival differs, and its lines
    cells = reader()
    show(cells, ID)
    differ = [cell for cell in range(24) if (golay.cells(ID) ^ golay.cells(ID ^ 2)) >> cell & 1]
    assert len(differ) == 8
    cover(cells, differ[:7], WHITE - 250)
    assert cells.decide(56) == UNKNOWN
    assert cells.decide(8 + 4) == ID
    assert cells.decide(16 + 5) == UNKNOWN  # the line that tells them apart is the one in doubt


def test_by_how_much_a_word_must_cost_less_than_the_second():
    for lines_id, told, turned, gap in (
        (5, ID, 0, 48),
        (0, ID, 0, 110),  # without lines that agree
        (56, ID, 0, 110),
        (16 + 5, ID, 0, 78),  # with one in doubt
        (5, 0, 0, 80),
        (5, ID, 1, 78),
    ):
        for short, believed in ((0, 1 + told), (1, 0)):
            weights, result = array("i", bytes(4 * 26)), array("i", (told, 0, gap - short, 0, 0))
            weights[25] = 0 if told == 0 else 500
            found = cell_words.believed_word(lines_id, 0, turned, weights, result)
            assert found & 4095 == believed, (lines_id, told, turned, gap - short)


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
        (5, 0, 0, 200, 100, 200, 17),  # of the empty word a half
        (5, 0, 0, 200, 99, 200, None),
        (0, ID, 0, 0, 110 + 144, 0, 127),
        (0, ID, 0, 0, 110 + 288, 0, 255),
        (0, ID, 0, 0, 110 + 287, 0, 254),
    ):
        weights, result = array("i", bytes(4 * 26)), array("i", (told, cost, cost + gap, 0, 0))
        weights[25] = plain
        found = cell_words.believed_word(lines_id, 0, turned, weights, result)
        assert found == (0 if margin is None else 1 + told + (margin << 12)), (told, turned, cost, gap)


def test_white_cells_behind_a_hidden_ring_tell_nothing():
    """Something of the plate's own tone: only the ring shows that it is there."""
    cells = reader()
    dark = show(cells, ID)
    wrong = [cell for cell in range(24) if dark >> cell & 1][:3]
    cover(cells, wrong, WHITE)
    assert cells.decide(5) == UNKNOWN
    cells._hidden = 1 << wrong[0] | 1 << wrong[1] | 1 << wrong[2]
    assert cells.decide(5) == ID
    cells._hidden = (1 << 24) - 1  # what looks dark is ink all the same
    assert cells.decide(5) == UNKNOWN and [w - BIAS for w in cells._weights[:24] if w != BIAS] == [64] * 9


def test_a_shadow_in_which_two_cells_are_dark_hides_none():
    cells = reader()
    dark = show(cells, ID)
    shaded = [cell for cell in range(24) if dark >> cell & 1][:2]
    white = [cell for cell in range(24) if not dark >> cell & 1]
    for seen, weight in ((2, -49), (1, 0)):
        show(cells, ID)
        for cell in shaded[:seen] + white[:4]:
            cells.depths[48 + cell] -= 200
            cells.depths[24 + cell] -= 200
        assert cells.decide(5) == ID
        assert [cells._weights[cell] - BIAS for cell in white[:5]] == [weight] * 4 + [-64], seen


def darkened(which, marker_id=3):
    """What a plain marker tells some of whose cells look dark, and what that costs it."""
    cells = reader()
    show(cells, marker_id)
    for cell in which:
        cells.depths[cell] = BIAS + 256
        cells.depths[24 + cell] = WHITE - 256
    return cells.decide(marker_id), cells._weights[25]


def test_one_stroke_across_a_plain_marker_is_counted_once():
    for which, expected, cost in (
        ((5,), PLAIN, 64),
        ((22, 23, 0, 1), PLAIN, 160),  # 64, and half of what is beyond
        ((8, 9, 10, 11, 12), PLAIN, 192),
        # or as one that crosses at two places, when they are few: 64, and a quarter of what is beyond
        ((5, 6), PLAIN, 80),
        ((2, 9), PLAIN, 80),
        ((2, 3, 9), PLAIN, 96),
        ((2, 3, 9, 10), UNKNOWN, 256),
        ((2, 9, 16), PLAIN, 192),
        ((2, 3, 9, 16), UNKNOWN, 256),
        ((8, 9, 10, 11, 12, 13), UNKNOWN, 384),  # too many for one
    ):
        assert darkened(which) == (expected, cost), which


def test_the_turn_is_found_and_the_empty_word_has_none():
    cells = reader()
    for turn in range(4):
        show(cells, ID, turn)
        seen = [0, 0, 0, 0]
        assert cells.find_turn(seen, 15) == (4 - turn) % 4
        assert cells.find_turn(seen, 15 & ~(1 << (4 - turn) % 4)) == -1
    show(cells, 3)
    assert cells.find_turn([0, 64, 0, 64], 15) == -1


def test_the_limits_of_a_turn_that_the_code_alone_tells():
    for line, turn in ((80, 0), (81, -1)):  # what a coding line may contradict
        cells = reader()
        show(cells, ID)
        assert cells.find_turn([0, 0, line, 0], 1) == turn, line
    for lines, turn in ((14, 0), (13, -1)):  # by which the second word, 64 away, must cost more
        cells = reader()
        show(cells, ID)
        cover(cells, range(11), WHITE - 250)
        assert cells.find_turn([0, lines, 0, lines], 1) == turn, lines


def test_a_line_that_is_not_seen_weighs_half_as_much_as_one_that_is():
    assert [weight - BIAS for weight in reader()._lines_of[5][:3]] == [64, -32, 64]


def test_shapes_that_no_camera_under_a_ceiling_sees():
    """A quarter of ellipse, or of perspective, along each axis."""
    place = array("i", [0] * layouts.PLACE_ITEMS)
    for item, least, most in (
        (layouts.FIT_BULGE_COS, -4096, 4096),
        (layouts.FIT_BULGE_SIN, -4096, 4096),
        (layouts.FIT_X_Q10, -2958, 2959),  # 13/18 of it, rounded down
        (layouts.FIT_Y_Q10, -2958, 2959),
    ):
        for bent, expected in ((least, 1), (least - 1, 0), (most, 1), (most + 1, 0), (0, 1)):
            fit = array("i", [BIAS] * layouts.FIT_ITEMS)
            fit[layouts.FIT_RADIUS_Q8], fit[layouts.FIT_AREA] = 4096, 400
            fit[item] += bent
            found = cells_kernels.direct_place(fit, 0, 0, fixed.COSINE, 0, place)
            assert found == expected, (item, bent)


def made_up(depth, share, is_faint=1, count=24):
    """How dark the first cell is taken to be, all rings showing so much of an area of 200."""
    depths = array("i", [BIAS + 200] * count + [BIAS] * (24 - count))
    depths[0] = BIAS + depth
    cells_kernels.local_depths(200, 0, 0, is_faint, array("i", [share] * 32), depths)
    return depths[0] - BIAS


def test_how_much_darkness_is_made_up_for():
    for share, is_faint, expected in (
        (87, 1, 461),  # 111/256 of the area
        (86, 1, 465),  # 110
        (80, 1, 465),
        (100, 0, 400),
        (99, 0, 269),  # something hides the cells: 190 at least
        (187, 1, 214),
        (188, 1, 200),  # less than a sixteenth is missing
    ):
        assert made_up(200, share, is_faint) == expected, (share, is_faint)
    assert made_up(155, 100, count=4) == 310
    assert made_up(154, 100, count=4) == 154  # three are dark: a plain marker's are left as they are
    assert made_up(1 - (1 << 20), 100) == 2 - (1 << 21)
    assert made_up(-(1 << 20), 100) == -(1 << 20)  # outside the frame


def test_samples_of_a_cell_lie_two_degrees_apart():
    side = 210
    frame = bytearray([200] * (side * side))
    for row in (97, 103):  # 2.7 px beside the middle of a cell that is 77 px away
        for column in range(side):
            frame[row * side + column] = 50
    place = array("i", [0] * layouts.PLACE_ITEMS)
    for item, value in (
        (layouts.PLACE_X_Q8, 100 << 8),
        (layouts.PLACE_Y_Q8, 100 << 8),
        (layouts.PLACE_RADIUS_Q8, 50 << 8),
        (layouts.PLACE_COSINE_Q14, 15537),  # turned so that the first cell lies along x
        (layouts.PLACE_SINE_Q14, 5199),
        (layouts.PLACE_DEPTH, 360),
        (layouts.PLACE_WIDTH, side),
        (layouts.PLACE_HEIGHT, side),
    ):
        place[item] = value
    for item in range(layouts.PLACE_E1_Q14, layouts.PLACE_SINE_Q14 + 1):
        place[item] += BIAS
    for ring in range(4):
        place[layouts.PLACE_RADII_Q10 + ring] = (190, 205, 228, 236)[ring] * 1024 // 150
    result = array("i", bytes(4 * 72))
    assert cells_kernels.cell_depths(0, 0, 0, frame, fixed.LOG_GREY, fixed.CELL_AXES, place, result) == 24
    dark, white = 523, 961  # logarithms of 50 and 200
    assert result[24] == (4 * dark + 2 * white) // 6  # of six samples in it the middle ones are white
