"""Frames larger than the detector takes: alike with ulab, with numpy and with neither."""

from larics.detect import thinned
from larics.detect.detector import Detector
from larics.detect.thinned import ThinnedDetector
from larics.marker.detection import NO_SIGMA
from marker_drawing import draw

WIDTH, HEIGHT = 128, 120
MARKER = (3, 1000, 950, 400, 12345)  # ID, x, y and radius in 1/16 px, heading


def strewn(small, step, first):
    """A frame that is black but for one pixel of each step x step; a column and a row are left over."""
    width = WIDTH * step + 1
    frame = bytearray(width * (HEIGHT * step + 1))
    k = 0
    for y in range(HEIGHT):
        place = (y * step + first) * width + first
        for x in range(WIDTH):
            frame[place + x * step] = small[k]
            k += 1
    return frame


def fields(found):
    return [(one.marker_id, one.x_q8, one.y_q8, one.radius_q8, one.sigma_q12, one.flags) for one in found]


def finders(step, *arguments, **options):
    """With what is there of ulab and numpy, and without."""
    yield ThinnedDetector(WIDTH * step + 1, HEIGHT * step + 1, *arguments, **options)
    arrays, thinned.np = thinned.np, None
    try:
        yield ThinnedDetector(WIDTH * step + 1, HEIGHT * step + 1, *arguments, **options)
    finally:
        thinned.np = arrays


def test_every_nth_pixel_is_seen_and_places_are_those_of_the_whole_frame():
    small = draw(WIDTH, HEIGHT, *MARKER)
    ((marker_id, x_q8, y_q8, radius_q8, sigma_q12, flags),) = fields(
        Detector(WIDTH, HEIGHT, 22, 30).detect(small)
    )
    assert marker_id == 3 and sigma_q12 != NO_SIGMA
    for step, first in ((2, 0), (3, 1)):
        frame = strewn(small, step, first)
        place = x_q8 * step + (first << 8), y_q8 * step + (first << 8)
        for finder in finders(step, 22 * step, 30 * step, step):
            expected = [(3, place[0], place[1], radius_q8 * step, sigma_q12 * step, flags)]
            assert fields(finder.detect(frame)) == expected
            assert fields(finder.detector.detect(small))[0][1] == x_q8  # what is behind keeps its own
            assert len(finder.detect(bytes(len(frame)))) == 0
            found = finder.track(frame, place[0] + 500, place[1], radius_q8 * step)
            assert len(found) == 1 and abs(found[0].x_q8 - place[0]) < 9 and found[0].flags
            try:
                finder.detect(frame[:-1])
                raise AssertionError("too short")
            except ValueError:
                pass


def test_the_least_step_that_the_detector_takes_is_chosen():
    for size, radii, step in (
        ((320, 240), (25, 35), 1),
        ((1024, 768), (25, 72), 1),
        ((1025, 768), (25, 72), 2),
        ((640, 1025), (25, 72), 2),
        ((320, 240), (40, 73), 2),
    ):
        assert ThinnedDetector(*size, *radii, second_opinion=False).step == step, (size, radii)
    try:
        ThinnedDetector(320, 240, 10, 73)  # 5 px are left
        raise AssertionError("too small")
    except ValueError:
        pass
