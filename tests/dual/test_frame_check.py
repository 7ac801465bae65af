"""Copies of frames are noticed by a sample of pixels; darkness and glare are told apart from them."""

from larics.device.frame_check import SAMPLE, FrameCheck

WIDTH, HEIGHT = 320, 240


def picture(seed, low=60, spread=100, size=WIDTH * HEIGHT):
    """Grey levels that repeat in no pattern of the sample."""
    state, data = seed, bytearray(size)
    for k in range(size):
        state = (state * 1103 + 12345) % 65521
        data[k] = low + state % spread
    return data


def told(check, frame):
    check.update(frame)
    return check.is_copy, check.is_dark, check.is_white


def test_a_copy_is_a_frame_whose_sample_is_that_of_the_frame_before():
    check, first, second = FrameCheck(), picture(1), picture(2)
    assert told(check, first) == (False, False, False)  # nothing to compare it with
    assert told(check, first) == told(check, bytearray(first)) == (True, False, False)
    assert told(check, second) == (False, False, False) and told(check, second)[0]
    assert told(check, first)[0] is False


def test_one_pixel_of_the_sample_is_enough_and_others_do_not_count():
    check, frame = FrameCheck(), picture(3)
    assert SAMPLE == 251
    step = 305
    check.update(frame)
    for place, is_copy in (
        (0, False),
        (step, False),
        (1, True),
        (step * (SAMPLE - 1), False),
        (step + 2, True),
    ):
        frame[place] ^= 1
        assert told(check, frame)[0] is is_copy, place


def test_darkness_and_glare_are_no_copies():
    check = FrameCheck()
    for grey, expected in (
        (0, (False, True, False)),
        (24, (False, True, False)),
        (250, (False, False, True)),
    ):
        for _ in range(3):
            assert told(check, bytes([grey]) * 5000) == expected
    for grey in (25, 128, 249):
        check.update(bytes([grey]) * 5000)
        assert told(check, bytes([grey]) * 5000) == (True, False, False)


def test_another_size_is_another_frame():
    check = FrameCheck()
    check.update(bytes([90]) * 5000)
    assert not told(check, bytes([90]) * 5001)[0] and told(check, bytes([90]) * 5001)[0]


def test_the_mean_is_that_of_the_frame_and_small_frames_are_read_to_their_end():
    check = FrameCheck()
    for size in (1, 7, SAMPLE - 1, SAMPLE, SAMPLE + 1, 64 * 48, WIDTH * HEIGHT):
        frame = picture(5, size=size)
        check.update(frame)
        assert abs(check.mean - sum(frame) // size) <= (12 if size < 60000 else 8), size
        assert told(check, frame)[0]
        frame[0] ^= 1
        assert not told(check, frame)[0]


def test_nothing_is_allocated():
    try:
        from micropython import heap_lock, heap_unlock
    except ImportError:
        return
    check, frame = FrameCheck(), picture(1, size=5000)
    check.update(frame)
    heap_lock()
    try:
        for _ in range(3):
            check.update(frame)
            mean = check.mean
    finally:
        heap_unlock()
    assert check.is_copy and mean > 60
