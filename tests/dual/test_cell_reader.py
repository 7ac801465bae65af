"""What cells that were measured tell: IDs, plain markers, the turn, and what is covered."""

from larics.coded.cell_reader import PLAIN, UNKNOWN
from larics.marker import golay, mirrored_lines
from shown_cells import BIAS, ID, WHITE, cover, mirror, reader, show


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
