"""The published method on frames drawn with integers: the same detections on both interpreters."""

from larics.detect.paper import PaperDetector
from larics.marker.detection import FLAG_BORDER
from marker_drawing import draw

try:
    import micropython

    heap_lock, heap_unlock = micropython.heap_lock, micropython.heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

SIZE = 112

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
        assert found_in(detector, draw(SIZE, SIZE, *drawn)) == expected


def test_accumulator_and_sums_of_a_golden_marker():
    detector = PaperDetector(SIZE, SIZE, 20, 30, edge_threshold=100)
    detector.detect(draw(SIZE, SIZE, *GOLDEN[0][0]))
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
    assert found_in(detector, draw(SIZE, SIZE, 5, 30 * 16, 56 * 16, 25 * 16, 0))[6] == FLAG_BORDER


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
    frame, empty = draw(SIZE, SIZE, *GOLDEN[0][0]), bytearray(SIZE * SIZE)
    detector.detect(frame)
    heap_lock()
    try:
        found = detector.detect(frame)
        nothing = detector.detect(empty)
    finally:
        heap_unlock()
    assert len(found) == 1 and not nothing
