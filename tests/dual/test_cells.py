"""Coded markers on frames drawn with integers: right, alike on both interpreters, and without allocation."""

from larics.arith.fixed import wrap_cdeg
from larics.detect.detector import Detector
from larics.marker import LARICS3, is_used
from larics.marker.detection import FLAG_BLUR_MODEL, FLAG_ID_UNCERTAIN, FLAG_UNCONFIRMED
from larics.marker.id_set import ends_of, holds, id_set
from marker_drawing import draw

try:
    import micropython

    heap_lock, heap_unlock = micropython.heap_lock, micropython.heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

WIDTH, HEIGHT = 128, 120
CENTRE = (1024, 960)
RADIUS_Q4 = 400


def drawn(marker_id, heading_cdeg=0):
    return draw(WIDTH, HEIGHT, marker_id, CENTRE[0], CENTRE[1], RADIUS_Q4, heading_cdeg)


def board(frame, edge, grey=110):
    """Covers everything right of a column."""
    for y in range(HEIGHT):
        for x in range(edge, WIDTH):
            frame[y * WIDTH + x] = grey
    return frame


def detector(**settings):
    return Detector(WIDTH, HEIGHT, 22, 30, **settings)


def test_coded_and_plain_markers_are_read_by_one_detector():
    finder = detector()
    for marker_id, heading_cdeg in ((9, 0), (1261, 12345), (5, 7000), (4094, 31111), (2222, 20055)):
        found = finder.detect(drawn(marker_id, heading_cdeg))
        assert [one.marker_id for one in found] == [marker_id]
        assert found[0].flags == 0 and found[0].margin > 128


def test_the_plain_family_reads_the_remainder():
    assert [one.marker_id for one in detector(family=LARICS3).detect(drawn(1261))] == [1261 % 8]


def test_cells_are_made_up_for_where_something_covers_them():
    # everything beyond 170 mm to the right of the centre: the orientation line points up
    frame = board(drawn(1261, 9000), (CENTRE[0] + RADIUS_Q4 * 17 // 15) // 16)
    found = detector().detect(frame)
    assert [one.marker_id for one in found] == [1261]
    whole = detector().detect(drawn(1261, 9000))
    assert found[0].margin < whole[0].margin


def faint_on_the_right(marker_id, tenths):
    """As behind dirt on the lens: there the contrast is so many tenths."""
    frame = drawn(marker_id, 5000)
    for y in range(HEIGHT):
        for x in range(CENTRE[0] // 16 + 4, WIDTH):
            frame[y * WIDTH + x] = 195 - (195 - frame[y * WIDTH + x]) * tenths // 10
    return frame


def test_cells_are_as_faint_as_the_ring_before_them():
    for marker_id in (1261, 3513):
        found = detector(second_opinion=False).detect(faint_on_the_right(marker_id, 6))
        assert [one.marker_id for one in found] == [marker_id]
    for marker_id in (1261, 2222):
        found = detector().detect(faint_on_the_right(marker_id, 5))
        assert [one.marker_id for one in found] == [marker_id]
        assert found[0].flags & FLAG_BLUR_MODEL


def hide(frame, u_q4, v_q4, half_px):
    """Paints a square of the plate's grey over a place relative to the centre, orientation line up."""
    x0, y0 = (CENTRE[0] - v_q4) // 16, (CENTRE[1] - u_q4) // 16
    for y in range(y0 - half_px, y0 + half_px + 1):
        for x in range(x0 - half_px, x0 + half_px + 1):
            frame[y * WIDTH + x] = 195
    return frame


def test_a_line_that_contradicts_the_cells_takes_the_id():
    # ID 1261 has the lines of 5, at both sides; without the right one they are those of 4
    frame = hide(drawn(1261, 9000), 0, -RADIUS_Q4 * 52 // 150, 5)
    assert [one.marker_id for one in detector(family=LARICS3).detect(frame)] == [4]
    for one in detector().detect(frame):
        assert one.marker_id == -1 and one.flags & FLAG_ID_UNCERTAIN


def test_the_code_tells_the_orientation_where_the_line_is_hidden():
    # everything beyond 155 mm to the right is covered, and the orientation line points there
    edge = (CENTRE[0] + RADIUS_Q4 * 155 // 150) // 16
    for marker_id, heading_cdeg in ((1261, 0), (4094, 500), (2222, 35700)):
        found = detector(second_opinion=False).detect(board(drawn(marker_id, heading_cdeg), edge))
        assert [one.marker_id for one in found] == [marker_id]
        assert abs(wrap_cdeg(found[0].heading_cdeg - heading_cdeg)) < 150
    # three lines alone cannot tell that
    assert not detector(family=LARICS3, second_opinion=False).detect(board(drawn(1261), edge))


def test_no_orientation_line_is_guessed_where_the_plate_is_seen_to_be_white():
    frame = hide(drawn(1261, 9000), RADIUS_Q4 * 192 // 150, 0, 7)
    found = detector(second_opinion=False).detect(frame)
    assert not [one for one in found if one.marker_id >= 0]


def test_only_allowed_ids_are_told():
    assert [one.marker_id for one in detector(allowed_ids=[(1000, 2000)]).detect(drawn(1261))] == [1261]
    assert [one.marker_id for one in detector(allowed_ids=[(9, 1260), 5]).detect(drawn(1261))] == [-1]
    assert [one.marker_id for one in detector(allowed_ids=[(9, 4094)]).detect(drawn(5))] == [-1]


def test_an_id_set_holds_what_the_family_uses():
    for coded, zero, ranges in (
        (True, False, None),
        (False, True, None),
        (True, True, [(3, 9), (16, 16), 17, (30, 5000)]),
        (False, False, [(6, 4000)]),
        (True, False, [(12, 11), 4095]),
    ):
        bits = id_set(ranges, coded, zero)
        assert len(bits) == 512
        for marker_id in range(0, 4096):
            inside = [first <= marker_id <= last for first, last in map(ends_of, ranges or [(0, 4095)])]
            assert holds(bits, marker_id) == (any(inside) and is_used(marker_id, coded, zero)), marker_id
    bits = id_set([(1, 20), 4094, (4095, 9999)], True, False)
    held = [i for i in range(4096) if holds(bits, i)]
    assert held == [i for i in range(1, 21) if i not in (8, 16)] + [4094]
    assert sum([holds(id_set(None, True, False), i) for i in range(4096)]) == 3583
    assert [i for i in range(4096) if holds(id_set(None, False, True), i)] == [0, 1, 2, 3, 4, 5, 6, 7]


def mirrored(frame):
    """The frame with left and right exchanged."""
    rows = [bytearray(frame[y * WIDTH : (y + 1) * WIDTH]) for y in range(HEIGHT)]
    return bytearray([row[WIDTH - 1 - x] for row in rows for x in range(WIDTH)])


def test_a_mirrored_sensor_reads_coded_markers():
    for marker_id, heading_cdeg in ((1261, 12345), (4094, 0)):
        frame = mirrored(drawn(marker_id, heading_cdeg))
        assert [one.marker_id for one in detector(mirrored=True).detect(frame)] == [marker_id]
        assert [one.marker_id for one in detector().detect(frame)] != [marker_id]
    # of a plain one the lines are seen in the opposite order
    assert [one.marker_id for one in detector(mirrored=True).detect(mirrored(drawn(3)))] == [6]


def test_ids_of_any_size_are_confirmed():
    finder = detector(confirm=(2, 3))
    flags = [finder.detect(drawn(marker_id))[0].flags for marker_id in (4094, 1261, 4094, 1261, 9)]
    assert flags == [FLAG_UNCONFIRMED, FLAG_UNCONFIRMED, 0, 0, FLAG_UNCONFIRMED]


def test_nothing_is_allocated():
    finder = detector(confirm=(2, 3))
    frames = [drawn(9), board(drawn(1261, 9000), 90), drawn(3)]
    finder.detect(frames[0])
    for frame in frames:
        heap_lock()
        found = finder.detect(frame)
        heap_unlock()
        assert len(found) == 1
