"""The published method on frames drawn with integers: the same detections on both interpreters."""

from larics.detection import FLAG_BORDER
from larics.fixed import cos_q14, isqrt, sin_q14, turn16_from_cdeg
from larics.marker import CODE_ANGLES_CDEG, LARICS3
from larics.paper import PaperDetector

try:
    import micropython

    heap_lock, heap_unlock = micropython.heap_lock, micropython.heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

SIZE = 112


def near(value, centre, half):
    return -half <= value - centre <= half


def is_dark(u, v, marker_id, unit):
    """Whether the point u along and v across the orientation line is black; `unit`: that many make 150 mm."""

    def mm(length_mm10):
        return length_mm10 * unit // LARICS3.outer_mm10

    radius = isqrt(u * u + v * v)
    half = mm(LARICS3.line_mm10) // 2
    if near(radius, mm(LARICS3.outer_mm10), half) or near(radius, mm(LARICS3.inner_mm10), half):
        return True
    if mm(LARICS3.outer_mm10) <= u <= mm(LARICS3.orientation_end_mm10) and near(v, 0, half):
        return True
    start, end = mm(LARICS3.code_start_mm10), mm(LARICS3.code_end_mm10)
    for bit, (along, across) in zip(LARICS3.bits(marker_id), ((v, u), (-u, v), (-v, u))):
        if bit and start <= along <= end and near(across, 0, half):
            return True
    return False


def draw(marker_id, x_q4, y_q4, radius_q4, heading_cdeg, seed=1):
    """A frame of SIZE x SIZE with one marker, two by two samples a pixel, and noise of a few grey levels."""
    assert CODE_ANGLES_CDEG == (9000, 18000, 27000)
    turn16 = turn16_from_cdeg(heading_cdeg)
    cosine, sine = cos_q14(turn16), sin_q14(turn16)
    frame = bytearray(SIZE * SIZE)
    state = seed
    reach = radius_q4 * 26 // 15
    for y in range(SIZE):
        for x in range(SIZE):
            state = (state * 1103515245 + 12345) & 0x7FFFFFFF
            grey = 190 + (state >> 20) % 11
            if abs(16 * x - x_q4) < reach and abs(16 * y - y_q4) < reach:
                for sample in range(4):
                    dx = 16 * x - 4 + 8 * (sample & 1) - x_q4
                    dy = y_q4 - (16 * y - 4 + 8 * (sample >> 1))  # upwards
                    u = (dx * cosine + dy * sine) >> 14
                    v = (dy * cosine - dx * sine) >> 14
                    if is_dark(u, v, marker_id, radius_q4):
                        grey -= 40
            frame[y * SIZE + x] = grey
    return frame


# ID, x, y and radius in 1/16 px, heading -> what PaperDetector(SIZE, SIZE, 20, 30) reports
GOLDEN = (
    ((3, 900, 870, 400, 12345), (3, 14336, 13824, 12200, 6421, 231, 0)),
    ((5, 896, 896, 440, 0), (5, 14336, 14336, 0, 7048, 195, 0)),
    ((7, 880, 905, 460, 9000), (7, 14080, 14592, 9000, 7365, 178, 0)),
    ((1, 903, 899, 376, 20055), (1, 14336, 14336, 20300, 6001, 130, 0)),
    ((6, 884, 890, 420, 31111), (6, 14080, 14080, 31200, 6727, 232, 0)),
)
# of the votes and H(alpha) of the first one
CHECKSUM = 9380271


def found_in(detector, frame):
    found = detector.detect(frame)
    assert len(found) == 1
    one = found[0]
    return (one.marker_id, one.x_q8, one.y_q8, one.heading_cdeg, one.radius_q8, one.margin, one.flags)


def test_golden_markers():
    detector = PaperDetector(SIZE, SIZE, 20, 30)
    for drawn, expected in GOLDEN:
        assert found_in(detector, draw(*drawn)) == expected


def test_accumulator_and_sums_of_a_golden_marker():
    detector = PaperDetector(SIZE, SIZE, 20, 30, edge_threshold=100)
    detector.detect(draw(*GOLDEN[0][0]))
    checksum = 0
    for value in detector.accumulator:
        checksum = (checksum * 31 + value) & 0xFFFFFF
    for value in detector.radial_sums:
        checksum = (checksum * 31 + value) & 0xFFFFFF
    assert checksum == CHECKSUM


def test_nothing_is_found_in_empty_frames():
    detector = PaperDetector(80, 60, 10, 20)
    for grey in (0, 1, 255):
        assert detector.detect(bytearray([grey] * 4800)) == []


def test_border_is_flagged():
    detector = PaperDetector(SIZE, SIZE, 20, 30)
    assert found_in(detector, draw(5, 30 * 16, 56 * 16, 25 * 16, 0))[6] == FLAG_BORDER


def test_wrong_sizes_are_refused():
    detector = PaperDetector(80, 60, 10, 20)
    for length in (0, 4799, 4801):
        try:
            detector.detect(bytearray(length))
        except ValueError as error:
            assert "is not 80x60" in str(error)
        else:
            raise AssertionError("no ValueError")


def test_a_frame_allocates_nothing():
    detector = PaperDetector(SIZE, SIZE, 20, 30)
    frame, empty = draw(*GOLDEN[0][0]), bytearray(SIZE * SIZE)
    detector.detect(frame)
    heap_lock()
    try:
        found = detector.detect(frame)
        nothing = detector.detect(empty)
    finally:
        heap_unlock()
    assert len(found) == 1 and not nothing
