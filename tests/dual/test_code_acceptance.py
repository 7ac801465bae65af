"""The direct reader's decision on coding lines, made up at each limit and just beyond it."""

from larics.detect.detector import Detector
from larics.direct.acceptance import Acceptance
from larics.kernels import layouts
from larics.marker import verdicts
from larics.marker.id_set import id_set
from marker_drawing import draw
from shown_cells import reader, show
from test_direct_acceptance import BIAS, Lines, Rings, code_verdict


def test_every_id_is_told_from_its_positions():
    for marker_id in range(1, 8):
        assert code_verdict(Lines(marker_id)) == (verdicts.ACCEPTED, marker_id, 255)
    assert code_verdict(Lines(0))[0] == verdicts.NO_CODE
    assert code_verdict(Lines(0), ids=range(8))[:2] == (verdicts.ACCEPTED, 0)
    assert code_verdict(Lines(5), ids=(1, 4))[0] == verdicts.ID_UNCERTAIN


def test_positions_that_must_be_empty():
    for position in (0, 1, 3, 5, 7):
        for item in (layouts.POSITION_NEAR, layouts.POSITION_FAR):
            for area, margin in ((140, 0), (90, 127), (142, -1)):
                lines = Lines()
                lines.put(position, item, area)
                found = code_verdict(lines)
                assert found[0] == (verdicts.ACCEPTED if margin >= 0 else verdicts.NOT_EMPTY)
                assert found[2] == margin, (position, area)
    lines = Lines()
    for position in (2, 4, 6):
        lines.put(position, layouts.POSITION_NEAR, 900)
    assert code_verdict(lines) == (verdicts.ACCEPTED, 5, 255)


def test_limits_of_a_bit():
    told, doubt = verdicts.ACCEPTED, verdicts.ID_UNCERTAIN
    for radius_q8, depth, stray, expected, marker_id, margin in (
        (4096, 125, 0, told, 7, 0),
        (4096, 165, 0, told, 7, 127),
        (4096, 124, 0, doubt, -1, 255),
        # shallow and smooth it is a stain, where what must be empty strays little
        (4096, 37, 0, told, 5, 244),
        (4096, 38, 0, doubt, -1, 255),  # one half of it is deeper than halves stray
        (4096, 85, 32, told, 5, 0),
        (4096, 86, 32, doubt, -1, 255),
        (4096, 61, 33, doubt, -1, 255),
        (4096, 60, 33, told, 5, 127),
        (4096, 61, -33, doubt, -1, 255),
        (4096, 61, 60, doubt, -1, 255),
        (4096, 560, 0, told, 7, 255),
        (4096, 561, 0, verdicts.NOT_EMPTY, -1, -1),
        # something white on the plate, or a reflection
        (4096, -110, 0, told, 5, 255),
        (4096, -111, 0, verdicts.NOT_EMPTY, -1, -1),
        (4095, 150, 0, told, 7, 0),
        (4095, 149, 0, doubt, -1, 255),
        (4095, 61, 30, doubt, -1, 255),
        (4095, 30, 0, told, 5, 153),
        (4095, 60, 30, told, 5, 0),
    ):
        rings = Rings()
        rings.resize(radius_q8)
        lines = Lines(5)
        lines.stray(stray)
        if radius_q8 == 4096:  # half as deep as the others is too pale
            for bit in (2, 6):
                lines.deepen(bit, 215 if depth < 200 else 340)
        lines.deepen(4, depth)
        assert code_verdict(lines, rings) == (expected, marker_id, margin), (radius_q8, depth, stray)


def test_lines_beside_one_in_doubt_bind_the_cells():
    for bit in (1, 2, 3):
        for marker_id, expected in ((1261, verdicts.ACCEPTED), (1261 ^ 4 >> bit - 1, verdicts.ACCEPTED)):
            lines = Lines(5)
            lines.deepen(2 * bit, 100)  # neither a line nor none
            assert coded_verdict(lines, marker_id) == (expected, marker_id), (bit, marker_id)
        for other in (1, 2, 3):
            marker_id = 1261 ^ 4 >> other - 1
            if other != bit:
                assert coded_verdict(lines, marker_id)[0] == verdicts.ID_UNCERTAIN, (bit, other)
    lines = Lines(5)
    lines.stroke_q8 = 201  # what goes on beyond a coding line leaves none certain
    assert coded_verdict(lines, 1262) == (verdicts.ACCEPTED, 1262)


def coded_verdict(lines, marker_id):
    """The verdict and the ID where the cells are those of a coded marker."""
    acceptance = Acceptance(id_set(None, True, False), 0)
    cells = reader()
    show(cells, marker_id)
    verdict = acceptance.code(lines, Rings(), cells, False)
    return verdict, acceptance.marker_id


def halves(bit, near, far, near_mean, far_mean, stray=0, stray_half=7, ring=1000, brighter=0):
    """The verdict on an ID 5 one of whose bits is measured like this, beside a ring of that area."""
    lines = Lines(5)
    rings = Rings()
    for sector in range(16):
        rings.inner_means[16 + sector] = ring
    lines.brighten(2 * bit, 500, brighter)
    lines.stray(stray)
    lines.put(5, layouts.POSITION_NEAR_MEAN, BIAS + stray_half)
    lines.put(5, layouts.POSITION_FAR_MEAN, BIAS - stray_half)
    position = 2 * bit
    lines.put(position, layouts.POSITION_NEAR, near)
    lines.put(position, layouts.POSITION_FAR, far)
    lines.put(position, layouts.POSITION_NEAR_MEAN, BIAS + near_mean)
    lines.put(position, layouts.POSITION_FAR_MEAN, BIAS + far_mean)
    return code_verdict(lines, rings)[:2]


def test_an_edge_a_cable_or_a_stain_is_no_line():
    told, doubt = (verdicts.ACCEPTED, 5), (verdicts.ID_UNCERTAIN, -1)
    # darker than one side only, where there are edges elsewhere
    assert halves(1, 12, 12, 200, 200, stray_half=76) == told
    assert halves(1, 12, 11, 200, 200, stray_half=76) == doubt
    assert halves(1, 12, 11, 200, 200, stray_half=75) == told
    # than one side alone, where it is brighter than the mean by 15 or 16: the edge of a reflection
    for area, brighter, expected in ((0, 17, told), (0, 18, doubt), (1, 18, told)):
        lines = Lines(5)
        lines.put(2, layouts.POSITION_NEAR, area)
        lines.put(2, layouts.POSITION_FAR, 0)
        lines.brighten(2, 500, brighter)
        assert code_verdict(lines)[:2] == expected, (area, brighter)
    # one half of it
    assert halves(1, 0, 100, 60, 260, ring=780) == told
    assert halves(1, 0, 100, 59, 261, ring=780) == doubt
    assert halves(1, 24, 100, 20, 300, ring=780) == told
    # of which the ring beside it, or light, tells no reason
    assert halves(1, 60, 60, 250, 110) == halves(1, 60, 60, 110, 250) == told
    assert halves(1, 60, 60, 250, 109) == halves(1, 60, 60, 109, 250) == doubt
    assert halves(1, 60, 60, 250, 109, ring=780) == told
    assert halves(1, 60, 60, 250, 109, ring=781) == doubt
    assert halves(1, 60, 60, 250, 109, ring=0) == doubt  # where a line was expected
    assert halves(1, 60, 60, 250, 109, brighter=17) == told
    assert halves(1, 60, 60, 250, 109, brighter=16) == doubt
    assert halves(1, 0, 100, 150, 200, stray=75) == told
    assert halves(1, 0, 100, 150, 200, stray=76) == doubt
    # an empty bit one half of which is deep
    assert halves(2, 0, 0, 44, -44) == told  # 30, and twice the 7 that halves stray
    assert halves(2, 0, 0, 45, -45) == doubt
    assert halves(2, 0, 0, 50, -50, stray=10) == told
    assert halves(2, 0, 0, 51, -51, stray=10) == doubt


def test_what_crosses_an_empty_bit_may_hide_a_line():
    for rough, depth, elsewhere, expected in (
        (120, 1, (0, 0, 0, 900, 900), verdicts.ACCEPTED),
        (121, 1, (0, 0, 0, 900, 900), verdicts.ID_UNCERTAIN),
        (150, 1, (0, 10, 10, 10, 0), verdicts.ACCEPTED),  # 120, and three times the median of noise
        (151, 1, (0, 10, 10, 10, 0), verdicts.ID_UNCERTAIN),
        # beside it, where it is no darker than its sides
        (400, 0, (0, 0, 0, 900, 900), verdicts.ACCEPTED),
        (401, 0, (0, 0, 0, 900, 900), verdicts.ID_UNCERTAIN),
    ):
        lines = Lines(5)
        for position, noise in zip((0, 1, 3, 5, 7), elsewhere):
            lines.put(position, layouts.POSITION_ROUGH, noise)
        lines.put(2, layouts.POSITION_ROUGH, 7000)  # a line is rough, as seen
        lines.put(4, layouts.POSITION_ROUGH, rough)
        lines.deepen(4, depth)
        assert code_verdict(lines)[0] == expected, (rough, depth, elsewhere)


def test_two_signs_that_each_may_mean_nothing_put_an_empty_bit_in_doubt():
    told, doubt = verdicts.ACCEPTED, verdicts.ID_UNCERTAIN
    for bump, rough, ring, expected in (
        (26, 0, 258, told),
        (25, 121, 723, told),  # 185/256 of the rings' area, as a cable hides some of it
        (25, 121, 722, doubt),
        (26, 121, 723, doubt),
        (26, 120, 257, doubt),
        (25, 120, 257, told),
    ):
        lines = Lines(5)
        lines.put(4, layouts.POSITION_LEVEL, 500 + bump)
        lines.put(4, layouts.POSITION_ROUGH, rough)
        rings = Rings()
        rings.inner_means[16 + 8] = ring
        assert code_verdict(lines, rings)[0] == expected, (bump, rough, ring)


def test_a_scratch_is_paler_than_the_other_lines():
    for deepest, depth, brighter, stray, expected in (
        (256, 148, 0, 51, verdicts.ACCEPTED),
        (256, 147, 0, 51, verdicts.ID_UNCERTAIN),
        (256, 147, 0, 50, verdicts.ACCEPTED),  # where the light is even it may be worn
        (256, 147, 18, 51, verdicts.ACCEPTED),  # 15 above the mean of all
        (256, 147, 16, 51, verdicts.ID_UNCERTAIN),
        (230, 133, 0, 51, verdicts.ACCEPTED),
        (230, 131, 0, 51, verdicts.ID_UNCERTAIN),
    ):
        lines = Lines(7)
        lines.stray(stray)
        lines.deepen(2, depth)
        lines.deepen(4, deepest)
        lines.deepen(6, deepest)
        lines.put(2, layouts.POSITION_LEVEL, 500 + brighter)
        assert code_verdict(lines)[0] == expected, (deepest, depth, brighter, stray)


def test_a_line_both_pale_and_darker_than_one_side_only_is_in_doubt():
    for depth, area, expected in (
        (147, 48, verdicts.ACCEPTED),  # 60 below the darker sides
        (148, 47, verdicts.ACCEPTED),
        (147, 47, verdicts.ID_UNCERTAIN),
    ):
        lines = Lines(7)
        lines.deepen(2, depth)
        lines.put(2, layouts.POSITION_NEAR, 12)
        lines.put(2, layouts.POSITION_FAR, area)
        assert code_verdict(lines)[0] == expected, (depth, area)


def test_a_patch_on_an_empty_bit_may_hide_a_line():
    for beside, brighter, expected in (
        ((0, 0), 45, verdicts.ACCEPTED),
        ((0, 0), 46, verdicts.ID_UNCERTAIN),
        ((1, 0), 46, verdicts.ACCEPTED),
        ((0, 1), 46, verdicts.ACCEPTED),
    ):
        lines = Lines(5)
        lines.put(3, layouts.POSITION_LEVEL, 500 + beside[0])
        lines.put(5, layouts.POSITION_LEVEL, 500 + beside[1])
        lines.put(4, layouts.POSITION_LEVEL, 500 + brighter)
        assert code_verdict(lines)[0] == expected, (beside, brighter)
    # a lesser one, if it is that much brighter than the mean of all
    for brighter, bump, expected in (
        (101, 26, verdicts.ID_UNCERTAIN),
        (100, 26, verdicts.ACCEPTED),
        (101, 25, verdicts.ACCEPTED),
    ):
        lines = Lines(5)
        lines.put(4, layouts.POSITION_LEVEL, 500 + brighter)
        for position in (3, 5):
            lines.put(position, layouts.POSITION_LEVEL, 500 + brighter - bump)
        lines.put(0, layouts.POSITION_LEVEL, 500 - 3 * brighter + 2 * bump)
        assert code_verdict(lines)[0] == expected, (brighter, bump)


def test_glare_takes_the_belief_from_an_empty_bit():
    told, doubt = verdicts.ACCEPTED, verdicts.ID_UNCERTAIN
    for light, brighter, depth, expected in (
        (820, 102, 10, told),  # 90 above the mean of all: half as much depth may be left of a line
        (820, 102, 11, doubt),
        (890, 46, 10, told),
        (890, 34, 15, told),  # 30 above: 30 of twice the depth
        (890, 34, 16, doubt),
        (860, 34, 16, told),  # where it is not bright, half of what is left may be a stain
        (500, 148, 0, told),  # 130 above
        (500, 149, 0, doubt),
        (931, 50, 0, told),  # a spot, where tone curves flatten it
        (931, 51, 0, doubt),
        (920, 60, 0, told),
    ):
        lines = Lines(5)
        lines.light(light)
        lines.brighten(4, light, brighter)
        lines.deepen(4, depth)
        assert code_verdict(lines)[0] == expected, (light, brighter, depth)
    lines = Lines(5)  # a line that is seen may glare
    lines.put(2, layouts.POSITION_LEVEL, 900)
    assert code_verdict(lines)[:2] == (told, 5)


def test_an_empty_bit_on_clipped_white_needs_a_strong_ring_and_is_never_sure():
    lines = Lines(5)
    for grey, area, margin in ((1035, 258, 255), (1036, 626, 91), (1036, 625, None)):
        lines.light(grey)
        rings = Rings()
        rings.inner_means[16 + 8] = area
        found = code_verdict(lines, rings)
        assert found[0] == (verdicts.ID_UNCERTAIN if margin is None else verdicts.ACCEPTED), (grey, area)
        assert margin is None or found[2] == margin
    # likewise where it is bright, brighter than the mean and not quite empty
    for grey, brighter, depth, area, expected in (
        (880, 30, 6, 625, verdicts.ID_UNCERTAIN),
        (880, 30, 6, 626, verdicts.ACCEPTED),
        (880, 30, 5, 625, verdicts.ACCEPTED),
        (880, 28, 6, 625, verdicts.ACCEPTED),  # 25 above the mean of all
        (870, 30, 6, 625, verdicts.ACCEPTED),
        # whatever the ring shows where little of a line would be left
        (989, 31, 6, 1000, verdicts.ACCEPTED),
        (990, 31, 6, 1000, verdicts.ID_UNCERTAIN),
        (990, 31, 5, 1000, verdicts.ACCEPTED),
        (993, 28, 6, 1000, verdicts.ACCEPTED),  # 25 above the mean of all
    ):
        lines = Lines(5)
        lines.light(grey)
        lines.brighten(4, grey, brighter)
        lines.deepen(4, depth)
        rings = Rings()
        rings.inner_means[16 + 8] = area
        assert code_verdict(lines, rings)[0] == expected, (grey, brighter, depth, area)


def test_an_empty_bit_beside_a_weak_ring_is_not_believed():
    # the empty position is half a turn from the line: sector 8 and its neighbours
    for depth, grey, stray, least in (
        (21, 500, 0, 1),
        (20, 901, 0, 1),
        (0, 500, 51, 1),
        (20, 900, 50, 3),  # flat and plainly lit, one of them must be seen
    ):
        lines = Lines(5)
        lines.light(grey)
        lines.stray(stray)
        lines.deepen(4, depth)
        for first in range(16):
            for count in (1, 2, 3):
                for area in (257, 258):  # 66/256 of the rings' area is 257
                    rings = Rings()
                    weak = 0
                    for sector in range(first, first + count):
                        rings.inner_means[16 + sector % 16] = area
                        weak += area == 257 and sector % 16 in (7, 8, 9)
                    expected = verdicts.ID_UNCERTAIN if weak >= least else verdicts.ACCEPTED
                    assert code_verdict(lines, rings)[0] == expected, (depth, grey, stray, first, count, area)


def test_an_empty_bit_beside_a_hidden_ring_is_doubted_where_a_bar_hides_the_other_side_as_well():
    for area, expected in (
        (625, verdicts.ID_UNCERTAIN),  # 160/256 of the rings' area
        (626, verdicts.ACCEPTED),
        (0, verdicts.ACCEPTED),  # a line lies there
    ):
        for sector in (15, 0, 1, 2, 14):
            rings = Rings()
            rings.inner_means[16 + 8] = 257
            rings.inner_means[16 + sector] = area
            found = code_verdict(Lines(5), rings)[0]
            assert found == (verdicts.ACCEPTED if sector in (2, 14) else expected), (area, sector)
            rings.inner_means[16 + 8] = 258
            assert code_verdict(Lines(5), rings)[0] == verdicts.ACCEPTED


def test_a_stroke_that_goes_on_between_the_rings_is_no_coding_line():
    lines = Lines(5)
    lines.stroke_q8 = 200
    assert code_verdict(lines)[:2] == (verdicts.ACCEPTED, 5)
    lines.stroke_q8 = 201
    assert code_verdict(lines)[:2] == (verdicts.ID_UNCERTAIN, -1)
    # in a frame: a stroke where a marker 1 has no coding line, as long as one, and longer
    finder = Detector(136, 128, 23, 30)
    for end, expected in ((14, 5), (25, -1)):
        frame = draw(136, 128, 1, 1085, 1022, 430, 1000)
        for y in range(64 - end, 60):
            for x in range(60, 70):
                along = -178 * (x - 68) - 1008 * (y - 64)
                across = 1008 * (x - 68) - 178 * (y - 64)
                if 5120 < along < end << 10 and -2048 < across < 2048:
                    frame[y * 136 + x] = 40
        assert [found.marker_id for found in finder.detect(frame)] == [expected], end
