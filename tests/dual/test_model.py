"""The blur-model reader on frames drawn and blurred with integers: alike on both interpreters, frugal."""

import sys
from array import array

from larics.arith.fixed import Parts, wrap_cdeg
from larics.blurred.blur_model import MOTIONS, BlurModel
from larics.blurred.candidates import X_Q8
from larics.blurred.reader import BlurModelReader
from larics.detect.centre_votes import LEAST_WORDS
from larics.detect.detector import Detector
from larics.detect.scales import cut
from larics.kernels.layouts import BIAS, CANDIDATE_ITEMS
from larics.marker import LARICS3, Family
from larics.marker import verdicts as verdict
from larics.marker.detection import FLAG_BLUR_MODEL
from marker_drawing import draw

try:
    import micropython

    heap_lock, heap_unlock = micropython.heap_lock, micropython.heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

WIDTH, HEIGHT = 136, 128
X_Q4, Y_Q4, RADIUS_Q4 = 1085, 1022, 430


def smeared(frame, length):
    """The frame as seen during a motion to the right by `length` (odd) px."""
    half = length // 2
    out = bytearray(frame)
    for y in range(HEIGHT):
        row = y * WIDTH
        total = sum(frame[row : row + length])
        for x in range(half, WIDTH - half - 1):
            out[row + x] = total // length
            total += frame[row + x + half + 1] - frame[row + x - half]
    return out


def moved(marker_id, heading_cdeg, length=9):
    return smeared(draw(WIDTH, HEIGHT, marker_id, X_Q4, Y_Q4, RADIUS_Q4, heading_cdeg), length)


def detector(**settings):
    return Detector(WIDTH, HEIGHT, 23, 30, **settings)


def test_what_motion_blurs_is_read_by_the_second_opinion_alone():
    asked = detector()
    alone = detector(second_opinion=False)
    for marker_id, heading_cdeg in ((3, 12345), (5, 700), (6, 29000)):
        frame = moved(marker_id, heading_cdeg)
        assert [one for one in alone.detect(frame) if one.marker_id >= 0] == []
        found = asked.detect(frame)
        assert len(found) == 1 and asked.statistics.blur_verdict == verdict.ACCEPTED
        one = found[0]
        assert one.marker_id == marker_id and one.flags == FLAG_BLUR_MODEL and one.margin > 0
        assert abs(one.x_q8 - 16 * X_Q4) <= 32, one
        assert abs(one.y_q8 - 16 * Y_Q4) <= 32, one
        assert abs(one.radius_q8 - 16 * RADIUS_Q4) <= 160, one
        assert abs(wrap_cdeg(one.heading_cdeg - heading_cdeg)) <= 100, (one, heading_cdeg)
    assert MOTIONS[asked.blur_reader.blur.motion] > 1280 and asked.blur_reader.blur.motion_axis in (0, 2, 30)


def two_moved():
    """A frame of two blurred markers side by side, with the IDs 3 and 5."""
    left, right = moved(3, 12345), moved(5, 700)
    frame = bytearray()
    for y in range(HEIGHT):
        frame += left[y * WIDTH : (y + 1) * WIDTH] + right[y * WIDTH : (y + 1) * WIDTH]
    return frame


def test_several_blurred_markers_are_read_in_turns():
    finder = Detector(2 * WIDTH, HEIGHT, 23, 30)
    frame = two_moved()
    seen = [[one.marker_id for one in finder.detect(frame)] for _ in range(6)]
    assert sorted(seen[0] + seen[1]) == [3, 5] and seen[::2] == 3 * [seen[0]] and seen[1::2] == 3 * [seen[1]]


def test_a_thorough_detector_reads_all_in_every_frame():
    finder = Detector(2 * WIDTH, HEIGHT, 23, 30, thorough=True)
    frame = two_moved()
    empty = bytearray(2 * WIDTH * HEIGHT)
    for _ in range(8):
        finder.detect(empty)
        assert not finder._blurred_search.is_sparing()
    for _ in range(2):
        assert sorted([one.marker_id for one in finder.detect(frame)]) == [3, 5]


def test_a_single_blurred_marker_is_read_in_every_frame():
    finder = detector()
    frame = moved(3, 12345)
    for _ in range(4):
        assert [one.marker_id for one in finder.detect(frame)] == [3]


def test_a_sharp_marker_needs_no_second_opinion():
    finder = detector()
    found = finder.detect(draw(WIDTH, HEIGHT, 3, X_Q4, Y_Q4, RADIUS_Q4, 4000))
    assert len(found) == 1 and found[0].flags == 0
    assert finder.statistics.blur_verdict == -1


def test_nothing_is_allocated():
    finder = detector()
    frames = [moved(5, 700), moved(2, 20000, 3), bytearray(WIDTH * HEIGHT)]
    frames.append(bytearray(k * k % 251 for k in range(WIDTH * HEIGHT)))
    frames.append(smeared(draw(WIDTH, HEIGHT, 4, X_Q4, Y_Q4, RADIUS_Q4, 3, 190, 100), 15))
    finder.detect(frames[0])
    ids = asked = 0
    heap_lock()
    try:
        for frame in frames:
            for one in finder.detect(frame):
                ids = ids * 8 + one.marker_id
            if finder.statistics.blur_verdict >= 0:
                asked += 1
    finally:
        heap_unlock()
    assert asked >= 2 and ids >= 5


def test_candidates_are_kept_by_promise_and_once():
    second = BlurModelReader(WIDTH, HEIGHT, LARICS3, 175, bytearray(512), 16, None, cut(25, 35))
    candidates = second.candidates
    for x, said in ((10, verdict.NO_RADIUS), (30, verdict.NO_ORIENTATION), (11, verdict.NO_RADIUS)):
        candidates.remember(x << 8, 60 << 8, 20 << 8, 30 << 8, said, 0, False)
    for x in range(50, 120, 10):
        candidates.remember(x << 8, 60 << 8, 20 << 8, 30 << 8, verdict.NO_FIT, 200 - x, False)
    kept = [candidates.items[CANDIDATE_ITEMS * index + X_Q8] - BIAS >> 8 for index in range(8)]
    assert sorted(kept) == [30, 50, 60, 70, 80, 90, 100, 110]
    candidates.forget()
    second.begin()
    assert second.examine(bytearray(WIDTH * HEIGHT), False) == verdict.NO_RADIUS


def test_blur_spreads_a_line_and_keeps_its_ink():
    model = BlurModel(LARICS3, 175, Parts())
    before = 0
    for sigma in (0, 8, 14):
        model.prepare(sigma, 0, 0, 1, 0)
        bar = model.bars[:24]
        ink = 2 * sum(bar) - bar[0]
        assert abs(ink - 1024 * 175 * 24 // 1500) <= 40, ink
        assert bar[4] >= before
        assert [one for one, other in zip(bar, bar[1:]) if one < other] == []
        before = bar[4]


def test_templates_are_those_of_the_blur_asked_for():
    model = BlurModel(LARICS3, 175, Parts())
    fresh = {}
    for sigma in (10, 12):
        alone = BlurModel(LARICS3, 175, Parts())
        alone.prepare(sigma, 0, 0, 1)
        fresh[sigma] = bytes(alone.templates[:48]), bytes(alone.bars[:24])
    assert fresh[10] != fresh[12]
    for sigma, then in (
        (10, None),
        (10, None),
        (12, None),
        (10, "motion"),
        (10, "try"),
        (10, "bars"),
        (10, None),
    ):
        model.prepare(sigma, 0, 0, 1)
        assert (bytes(model.templates[:48]), bytes(model.bars[:24])) == fresh[sigma], (sigma, then)
        if then == "motion":
            model.prepare(5, 3, 0, 1)
        elif then == "try":
            model._try(3, 0, 0)
        elif then == "bars":
            model.prepare(5, 3, 0, 2, False)


def test_it_knows_the_families_with_rings_of_two_to_three():
    assert BlurModelReader.knows(LARICS3) and BlurModelReader.knows(LARICS3.scaled(800))
    other = Family(inner_mm10=1150, code_end_mm10=900)
    assert not BlurModelReader.knows(other)
    assert Detector(WIDTH, HEIGHT, 23, 30, family=other).blur_reader is None
    assert detector(second_opinion=False).blur_reader is None
    assert 2000 < detector().memory() - detector(second_opinion=False).memory() < 12288


def test_the_reader_works_where_the_votes_of_the_smallest_frame_were():
    smallest = Detector(64, 48, 40, 50)
    assert smallest.blur_reader.scratch <= LEAST_WORDS and not LEAST_WORDS % 4  # cleared four at a time
    assert len(smallest._votes.cells) >= LEAST_WORDS
    if sys.implementation.name == "micropython":
        assert smallest.blur_reader.scratch > LEAST_WORDS - 4


def test_templates_are_made_again_where_something_else_was_meanwhile():
    model = BlurModel(LARICS3, 175, Parts())
    model.prepare(10, 0, 0, 1)
    made = bytes(model.templates[:48])
    model.templates[:48] = array("H", bytes(96))
    model.forget()
    model.prepare(10, 0, 0, 1)
    assert bytes(model.templates[:48]) == made
    reader = detector().blur_reader
    reader.blur.prepare(10, 0, 0, 1)
    reader.examine(bytearray(WIDTH * HEIGHT), False)
    assert reader.blur._prepared == -1


def test_tilt_widens_the_range():
    level = Detector(WIDTH, HEIGHT, 23, 30)
    tilted = Detector(WIDTH, HEIGHT, 23, 30, max_tilt_deg=35)
    small = draw(WIDTH, HEIGHT, 6, X_Q4, Y_Q4, 17 * 16, 9000)
    assert level.detect(small) == []
    assert tilted.detect(small)[0].marker_id == 6
    for wrong in (-1, 41):
        try:
            detector(max_tilt_deg=wrong)
        except ValueError:
            continue
        raise AssertionError("%d was accepted" % wrong)
