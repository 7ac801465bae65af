"""How cells are measured, and how much each of them tells by its tone, light and shade."""

from array import array

from larics.arith import fixed
from larics.coded.cell_reader import UNKNOWN
from larics.kernels import cells as cells_kernels
from larics.kernels import layouts
from larics.marker import golay
from shown_cells import BIAS, FRAME, ID, WHITE, cover, look, reader, show


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


def test_where_print_is_patchy_what_is_less_dark_is_dark_all_the_same():
    for others, depth, weight in ((600, 180, 0), (600, 181, 17), (384, 181, 17), (600, 300, 61)):
        cells = reader()
        dark = [cell for cell in range(24) if show(cells, ID) >> cell & 1]
        for cell in dark:
            cells.depths[cell] = BIAS + others
        cells.depths[dark[0]] = BIAS + depth
        assert cells._weigh() and cells._weights[dark[0]] - BIAS == weight, (others, depth)


def test_how_much_darker_than_the_others_ink_may_be():
    for depth, weight in ((721, 64), (722, 0)):  # twice as dark
        cells = reader()
        dark = [cell for cell in range(24) if show(cells, ID) >> cell & 1]
        cells.depths[dark[0]] = BIAS + depth
        assert cells._weigh() and cells._weights[dark[0]] - BIAS == weight, depth


def test_what_nothing_covers_and_yet_tells_nothing_is_counted():
    for lighter, count in ((0, 2), (100, 2), (-100, 2), (101, 1), (-101, 1)):
        cells = reader()
        show(cells, 3)
        for cell in (4, 17):
            cells.depths[cell] = BIAS + 128  # neither dark nor white
        cells.depths[48 + 4] = WHITE + lighter
        cells.depths[9] = 0  # beyond the frame
        assert cells._weigh() and cells._weights[27] == count, lighter
        cells._hidden = 1 << 20  # white, behind a hidden ring, of the plate's tone
        assert cells._weigh() and cells._weights[27] == count + 1, lighter


def test_cells_that_tell_nothing_or_little_are_counted():
    for step in range(0, 129, 4):
        cells = reader()
        show(cells, 3)
        cells.depths[4] = BIAS + step
        cells.depths[9] = 0  # beyond the frame
        assert cells._weigh()
        little = abs(cells._weights[4] - BIAS) < 48
        assert cells._weights[28] == 1 + little, step


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
        look(cells, FRAME, noisy)
        dark = show(cells, ID)
        cell = [cell for cell in range(24) if dark >> cell & 1][0]
        cells.depths[cell] = BIAS + depth
        assert cells._weigh() and cells._weights[cell] - BIAS == weight, (noisy, depth)


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
