"""The geometry table of the marker."""

from larics import marker
from larics.marker import CODED, LARICS3, Family, golay


def refused(function, *arguments):
    try:
        function(*arguments)
    except ValueError:
        return True
    return False


def test_default_is_the_marker_of_the_paper():
    assert LARICS3.outer_mm10 == 1500 and LARICS3.inner_mm10 == 1000 and LARICS3.line_mm10 == 200
    assert LARICS3.orientation_end_mm10 == 2300 and LARICS3.plate_mm10 == 2500
    assert LARICS3.code_start_mm10 == 250 and LARICS3.code_end_mm10 == 800
    assert marker.CODE_ANGLES_CDEG == (9000, 18000, 27000)


def test_id_0_is_off_unless_enabled():
    assert LARICS3.ids() == (1, 2, 3, 4, 5, 6, 7)
    assert refused(LARICS3.bits, 0) and refused(LARICS3.strokes, 0)
    enabled = Family(allow_id0=True)
    assert enabled.ids() == (0, 1, 2, 3, 4, 5, 6, 7)
    assert enabled.bits(0) == (0, 0, 0) and len(enabled.strokes(0)) == 3


def test_bits_run_from_the_most_significant():
    assert LARICS3.bits(4) == (1, 0, 0)
    assert LARICS3.bits(2) == (0, 1, 0)
    assert LARICS3.bits(1) == (0, 0, 1)
    assert LARICS3.bits(6) == (1, 1, 0)
    for bad in (-1, 8, 99):
        assert refused(LARICS3.bits, bad)


def test_strokes_of_id_5():
    assert LARICS3.strokes(5) == (
        ("ring", 1500, 200),
        ("ring", 1000, 200),
        ("line", 0, 1500, 2300, 200),
        ("line", 9000, 250, 800, 200),
        ("line", 27000, 250, 800, 200),
    )


def test_each_id_has_its_own_strokes():
    for one in LARICS3.ids():
        for other in LARICS3.ids():
            assert (LARICS3.strokes(one) == LARICS3.strokes(other)) == (one == other)


def test_scaled_keeps_the_proportions():
    small = LARICS3.scaled(750)
    assert (small.inner_mm10, small.line_mm10, small.orientation_end_mm10) == (500, 100, 1150)
    assert (small.code_start_mm10, small.code_end_mm10, small.plate_mm10) == (125, 400, 1250)
    for outer_mm10 in (60, 333, 1501, 9999):
        family = LARICS3.scaled(outer_mm10)
        assert family.outer_mm10 == outer_mm10
        assert abs(family.plate_mm10 * 3 - outer_mm10 * 5) <= 2
        assert abs(family.inner_mm10 * 3 - outer_mm10 * 2) <= 2
    assert LARICS3.scaled(1500, 150).line_mm10 == 150
    assert LARICS3.scaled(900, 0, True).allow_id0 and not LARICS3.scaled(900).allow_id0


def test_every_line_width_that_can_be_read_is_allowed():
    for line_mm10 in range(50, 301, 10):
        assert Family(line_mm10=line_mm10).line_mm10 == line_mm10


def test_impossible_geometry_is_refused():
    assert refused(LARICS3.scaled, 0) and refused(LARICS3.scaled, -5)
    assert refused(Family, 1000, 1000)
    assert refused(Family, 1500, 1000, 0)
    assert refused(Family, 1500, 1000, 600)
    assert refused(Family, 1500, 1000, 200, 1500)
    assert refused(Family, 1500, 1000, 200, 2300, 250, 800, 2200)


def test_coded_family_has_3583_ids_of_which_7_are_plain():
    ids = CODED.ids()
    assert len(ids) == 3583 and ids[:8] == (1, 2, 3, 4, 5, 6, 7, 9) and ids[-1] == 4094
    assert CODED.name == "coded" and LARICS3.name == "plain"
    for bad in (-1, 0, 8, 16, 4088, 4095, 4096):
        assert not CODED.has(bad) and refused(CODED.cells, bad) and refused(CODED.bits, bad)
    assert not LARICS3.has(9) and refused(LARICS3.strokes, 9)


def test_lines_of_a_coded_id_are_those_of_its_remainder():
    assert CODED.bits(8 * 100 + 5) == LARICS3.bits(5)
    for plain in LARICS3.ids():
        assert CODED.cells(plain) == 0 and CODED.strokes(plain) == LARICS3.strokes(plain)


def test_words_are_those_that_hang_already():
    # of an independent encoder: the remainder of a division by x^11+x^10+x^6+x^5+x^4+x^2+1, and parity
    assert [golay.word(i) for i in (1, 9, 1261, 4094)] == [6379, 38189, 5165327, 16770836]
    assert [golay.cells(i) for i in (1, 9, 1261, 4094)] == [13107610, 6160409, 5952689, 3669605]
    assert sorted(golay.ORDER) == list(range(24))


def test_dark_cells_beside_each_other_are_one_stroke():
    dark = CODED.cells(1261)
    arcs = [stroke for stroke in CODED.strokes(1261) if stroke[0] == "arc"]
    covered = 0
    for _, first, last, start, end in arcs:
        assert (start, end) == (2200, 2440)
        for cell in range(24):
            quarter, index = cell // 6, cell % 6
            middle = 9000 * quarter + (1850, 2750, 3650, 5350, 6250, 7150)[index]
            if first < middle < last:
                covered |= 1 << cell
                assert first <= middle - 450 and middle + 450 <= last
    assert covered == dark
    assert sum([(last - first) // 900 for _, first, last, _, _ in arcs]) == bin(dark).count("1")


def test_cells_scale_and_keep_within_the_plate():
    small = CODED.scaled(750)
    assert small.coded and (small.cell_start_mm10, small.cell_end_mm10) == (1100, 1220)
    assert not CODED.scaled(750, coded=False).coded
    assert refused(lambda: Family(coded=True, cell_end_mm10=2600))
    assert refused(lambda: Family(coded=True, cell_start_mm10=1550))
    # the line stays the narrowest thing printed
    assert CODED.smallest_mm10(1261) == 200 and CODED.scaled(500).smallest_mm10(1261) == 67
