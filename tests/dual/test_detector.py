"""The detector on frames drawn with integers: right, alike on both interpreters, and without allocation."""

import sys

from larics.arith.fixed import wrap_cdeg
from larics.detect.centre_votes import CENTRES
from larics.detect.detector import MARKERS, Detector
from larics.marker.detection import FLAG_BORDER, FLAG_ID_UNCERTAIN, FLAG_TRACKED, FLAG_UNCONFIRMED
from marker_drawing import draw

try:
    import micropython

    heap_lock, heap_unlock = micropython.heap_lock, micropython.heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

WIDTH, HEIGHT = 128, 120

# ID, x, y and radius in 1/16 px, heading
DRAWN = (
    (3, 1000, 950, 400, 12345),
    (5, 1024, 960, 440, 0),
    (7, 1010, 930, 460, 9000),
    (1, 990, 975, 376, 20055),
    (6, 1030, 944, 420, 31111),
    (2, 1015, 955, 430, 4500),
)


def drawn(marker_id, x_q4, y_q4, radius_q4, heading_cdeg):
    return draw(WIDTH, HEIGHT, marker_id, x_q4, y_q4, radius_q4, heading_cdeg)


def detector(**settings):
    return Detector(WIDTH, HEIGHT, 22, 30, **settings)


def test_drawn_markers_are_read_to_a_hundredth():
    finder = detector()
    for marker_id, x_q4, y_q4, radius_q4, heading_cdeg in DRAWN:
        found = finder.detect(drawn(marker_id, x_q4, y_q4, radius_q4, heading_cdeg))
        assert len(found) == 1
        one = found[0]
        assert one.marker_id == marker_id
        assert one.flags == 0
        assert abs(one.x_q8 - 16 * x_q4) <= 20, (one, x_q4)
        assert abs(one.y_q8 - 16 * y_q4) <= 20, (one, y_q4)
        assert abs(wrap_cdeg(one.heading_cdeg - heading_cdeg)) <= 30, (one, heading_cdeg)
        assert abs(one.radius_q8 - 16 * radius_q4) <= 16


def test_nothing_is_allocated_after_the_first_frame():
    finder = detector(confirm=(2, 3))
    frames = [drawn(*marker) for marker in DRAWN[:2]]
    frames.append(bytearray(WIDTH * HEIGHT))
    frames.append(bytearray(k * k % 251 for k in range(WIDTH * HEIGHT)))
    finder.detect(frames[0])
    finder.track(frames[0])
    ids = 0
    heap_lock()
    try:
        for frame in frames:
            for one in finder.detect(frame):
                ids = ids * 8 + one.marker_id
            for one in finder.track(frame):
                ids = ids * 8 + one.marker_id
    finally:
        heap_unlock()
    assert ids == (DRAWN[0][0] * 9 * 64 + DRAWN[1][0] * 9)


def test_tracking_gives_what_the_search_gives():
    finder = detector()
    tracker = detector()
    for marker in DRAWN:
        frame = drawn(*marker)
        one = finder.detect(frame)[0]
        again = tracker.track(frame, one.x_q8 + 300, one.y_q8 - 600, one.radius_q8 + 100)
        assert len(again) == 1
        assert again[0].flags == FLAG_TRACKED
        assert again[0].marker_id == one.marker_id
        assert abs(again[0].x_q8 - one.x_q8) <= 12 and abs(again[0].y_q8 - one.y_q8) <= 12
        assert abs(wrap_cdeg(again[0].heading_cdeg - one.heading_cdeg)) <= 5
        assert tracker.statistics.edges == 0  # fitted at once


def test_tracking_follows_the_motion_and_falls_back():
    tracker = detector()
    assert len(tracker.track(drawn(3, 940, 960, 400, 0))) == 1  # nothing known yet: a search
    assert tracker.track(drawn(3, 1000, 960, 400, 100))[0].flags == FLAG_TRACKED
    assert tracker.track(drawn(3, 1060, 960, 400, 200))[0].flags == FLAG_TRACKED
    assert tracker.track(bytearray(WIDTH * HEIGHT)) == []
    assert tracker.track(drawn(3, 1120, 960, 400, 300))[0].flags == 0


def test_where_tracking_fails_the_search_of_the_next_frame_pays():
    frame = drawn(3, 1000, 960, 400, 300)
    tracker = detector()
    tracker.detect(frame)
    searched = tracker.statistics.steep
    assert tracker.track(frame, 2000 * 16, 100 * 16, 400 * 16) == []
    # its own window was searched, and nothing else
    assert tracker.statistics.steep < searched // 2
    assert tracker.statistics.blur_verdict == -1
    # then the whole frame, and after that the window again
    assert tracker.track(frame, 2000 * 16, 100 * 16, 400 * 16)[0].flags == 0
    assert tracker.track(frame, 1003 * 16, 959 * 16, 400 * 16)[0].flags == FLAG_TRACKED
    # a search between the two counts as well
    assert tracker.track(frame, 2000 * 16, 100 * 16, 400 * 16) == []
    tracker.detect(frame)
    assert tracker.track(frame, 1003 * 16, 959 * 16, 400 * 16)[0].flags == FLAG_TRACKED


def test_an_id_is_confirmed_by_enough_frames():
    finder = detector(confirm=(2, 3))
    frame = drawn(*DRAWN[0])
    assert finder.detect(frame)[0].flags == FLAG_UNCONFIRMED
    assert finder.detect(frame)[0].flags == 0
    empty = bytearray(WIDTH * HEIGHT)
    finder.detect(empty)
    assert finder.detect(frame)[0].flags == 0
    finder.detect(empty)
    finder.detect(empty)
    assert finder.detect(frame)[0].flags == FLAG_UNCONFIRMED


def test_ids_can_be_limited():
    frame = drawn(*DRAWN[0])
    assert detector(allowed_ids=(3, 4)).detect(frame)[0].marker_id == 3
    other = detector(allowed_ids=(4,)).detect(frame)[0]
    assert other.marker_id == -1 and other.flags == FLAG_ID_UNCERTAIN


def test_a_cut_off_plate_is_flagged():
    finder = detector()
    found = finder.detect(drawn(5, 600, 960, 400, 0))
    assert [one.marker_id for one in found] == [5]
    assert found[0].flags == FLAG_BORDER
    for x_q4 in range(0, 560, 80):
        for one in finder.detect(drawn(5, x_q4, 960, 400, 0)):
            assert one.marker_id in (5, -1) and one.flags & FLAG_BORDER


def test_work_is_capped_on_any_content():
    finder = detector()
    for period in (1, 2, 3, 5, 8):
        frame = bytearray(WIDTH * HEIGHT)
        for k in range(len(frame)):
            frame[k] = 255 if (k % WIDTH // period + k // WIDTH // period) & 1 else 0
        assert finder.detect(frame) == []
        counts = finder.statistics
        assert counts.candidates <= CENTRES
        assert counts.edges <= counts.steep <= WIDTH * HEIGHT // 16
        assert sum(counts.verdicts) == counts.candidates


def test_wrong_arguments_are_refused():
    finder = detector()
    for settings in ((32, 120, 22, 30), (128, 120, 30, 30), (128, 120, 2, 30), (128, 120, 20, 90)):
        assert raises(Detector, *settings)
    assert raises(finder.detect, bytearray(WIDTH * HEIGHT - 1))
    assert raises(Detector, WIDTH, HEIGHT, 22, 30, None, finder.family, None, False, (3, 2))
    assert len(finder.detect(bytearray(WIDTH * HEIGHT))) == 0
    for margin in (-1, 256):
        try:
            detector(margin_min=margin)
            raise AssertionError(margin)
        except ValueError:
            pass


def test_what_is_less_certain_than_asked_for_is_not_reported():
    picture = drawn(*DRAWN[0])
    margin = detector().detect(picture)[0].margin
    assert detector(margin_min=margin).detect(picture)[0].margin == margin
    assert len(detector(margin_min=margin + 1).detect(picture)) == 0


def raises(function, *arguments):
    try:
        function(*arguments)
    except ValueError:
        return True
    return False


class Image:
    """As an OpenMV image gives its pixels."""

    def __init__(self, pixels):
        self.pixels = pixels

    def bytearray(self):
        return self.pixels


def arrays():
    """numpy, ulab's where that is built in, else None: the unix port of PyPI has neither."""
    for name in ("ulab.numpy", "numpy"):
        try:
            return __import__(name, None, None, ("array",))
        except ImportError:
            pass
    return None


def test_images_and_dense_arrays_are_frames_as_they_lie():
    frame = drawn(*DRAWN[0])
    finder = detector()

    def seen(frame):
        return [(one.marker_id, one.x_q8, one.y_q8, one.heading_cdeg) for one in finder.detect(frame)]

    expected = seen(frame)
    assert len(expected) == 1 and expected[0][0] == 3
    if not hasattr(memoryview, "cast"):  # MicroPython
        assert seen(Image(frame)) == expected
    np = arrays()
    if np is not None:
        pixels = np.frombuffer(frame, dtype=np.uint8)
        assert seen(pixels) == expected
        rows = pixels.reshape((HEIGHT, WIDTH))
        assert seen(rows) == expected
        taller = np.zeros((HEIGHT + 2, WIDTH), dtype=np.uint8)
        taller[1 : HEIGHT + 1, :] = rows
        assert seen(taller[1 : HEIGHT + 1]) == expected, "a dense view"
        wider = np.zeros((HEIGHT, 2 * WIDTH), dtype=np.uint8)
        assert raises(finder.detect, wider[:, ::2]), "a view with gaps"
        assert raises(finder.detect, np.zeros(WIDTH * HEIGHT, dtype=np.uint16))


def test_memory_is_stated_and_bounded():
    known = Detector(360, 296, 25, 35)
    assert 16 * 1024 < known.memory() <= 96 * 1024
    unknown = Detector(360, 296, 10, 66)
    assert known.memory() < unknown.memory() <= 129 * 1024
    assert len(known.detect(bytes(360 * 296))) < MARKERS


def test_edges_of_coarse_scales_lie_behind_their_cells():
    for low, high in ((10, 60), (6, 72), (15, 60), (22, 60), (25, 35)):
        finder = Detector(WIDTH, HEIGHT, low, high)
        votes = finder._votes
        behind = [scale for scale in finder._scales if scale.edges.edges is votes.beside]
        assert bool(behind) == (len(finder._groups) < len(finder._scales))
        for k in range(len(votes.beside)):
            votes.beside[k] = -1
        for scale in behind:  # clears all of its cells
            assert scale.votes.find(votes.beside, 0, 0, 1, 0, WIDTH, 0, HEIGHT) == 0
        assert all([item == -1 for item in votes.beside])
        if behind and sys.implementation.name == "micropython":
            assert -1 in list(votes.cells)


def test_rings_partly_covered_are_those_of_a_marker_that_its_cells_tell():
    """A lamp in the plate hides as much of both rings as makes look-alikes."""
    finder = detector(second_opinion=False)
    for marker_id, told in ((1261, [1261]), (5, [])):
        frame = drawn(marker_id, 1000, 950, 400, 1234)
        for y in range(14, 60):
            for x in range(38, 84):
                if (2 * x - 120) ** 2 + (2 * y - 72) ** 2 < 44 * 44:
                    frame[y * WIDTH + x] = 250
        assert [found.marker_id for found in finder.detect(frame)] == told


def test_noise_like_faded_ink_makes_no_cell_dark():
    """The blur-model reader reads both; where white strays far, a cell is dark from halfway on."""
    for dark, noise, neutral_q8 in ((88, 1, 90), (88, 9, 128)):
        finder = detector()
        found = finder.detect(draw(WIDTH, HEIGHT, 1261, 1000, 950, 400, 1234, 100, dark, noise))
        assert [one.marker_id for one in found] == [1261]
        assert finder.direct.cells._neutral_q8 == neutral_q8, noise
