"""The supervision of a camera by itself: when it is started again, what is a fault, which frames are new."""

from camera_watch import CameraWatch
from faults import Faults
from larics.wire import messages as m

FRAME_MS = 20


class Clock:
    """Milliseconds that a test sets; they may wrap."""

    def __init__(self):
        self.now_ms = 1000

    def ticks_ms(self):
        return self.now_ms & m.COUNT_MAX

    def ticks_add(self, ticks, ms):
        return (ticks + ms) & m.COUNT_MAX

    def ticks_diff(self, later, earlier):
        difference = (later - earlier) & m.COUNT_MAX
        return difference - m.COUNT_MAX - 1 if difference > m.COUNT_MAX >> 1 else difference


class Camera:
    """A driver that does what a test tells it. grey: of all pixels; None: never the same twice."""

    ended = opening = False
    adjustable = True

    def __init__(self):
        self.frame = bytearray(300)
        self.frame_number = -1
        self.skipped = 0
        self.silent = False
        self.grey = None
        self.error = self.start_error = self.stop_error = None
        self.starts = self.stops = 0

    def start(self):
        self.starts += 1
        if self.start_error:
            raise self.start_error
        self.frame_number, self.skipped = -1, 0

    def stop(self):
        self.stops += 1
        if self.stop_error:
            raise self.stop_error

    def grab(self):
        if self.error:
            raise self.error
        if self.silent:
            return False
        self.frame_number += 1
        for k in range(300):
            if self.grey is None:
                self.frame[k] = (self.frame[k] + 1) % 50 + 100
            else:
                self.frame[k] = self.grey
        return True


def watched(started=True):
    camera, faults, clock = Camera(), Faults(), Clock()
    return CameraWatch(camera, faults, clock, started), camera, faults, clock


def run(watch, clock, ms, step_ms=FRAME_MS):
    """How many new frames there are in so long a time."""
    found = 0
    for _ in range(ms // step_ms):
        found += watch.grab()
        clock.now_ms += step_ms
    return found


def is_active(faults, code):
    return bool(faults.active >> code & 1)


def silent_since_ms(watch, camera, clock, ms):
    """Falls silent after a frame that is new, and looks once more so much later."""
    assert watch.grab()
    camera.silent = True
    clock.now_ms += ms
    assert not watch.grab()


def test_a_camera_that_is_silent_for_a_second_is_started_again_at_once():
    for ms, is_fault in ((999, False), (1000, True)):
        watch, camera, faults, clock = watched()
        silent_since_ms(watch, camera, clock, ms)
        assert is_active(faults, m.FAULT_CAMERA_TIMEOUT) == is_fault and not camera.starts
        clock.now_ms += 1
        watch.grab()
        assert camera.starts == camera.stops == is_fault
    camera.silent = False
    assert watch.grab() and not is_active(faults, m.FAULT_CAMERA_TIMEOUT)
    assert faults.total == 2 and faults.last == m.FAULT_CAMERA_RESET


def starts_ms(watch, camera, clock, ms):
    """When it is started within such a time."""
    found, begin_ms, before = [], clock.now_ms, camera.starts
    for _ in range(ms // FRAME_MS):
        watch.grab()
        if camera.starts > before:
            before = camera.starts
            found.append(clock.now_ms - begin_ms)
        clock.now_ms += FRAME_MS
    return found


def test_how_often_it_is_started_again():
    watch, camera, faults, clock = watched()
    camera.error = OSError("gone")
    camera.start_error = camera.stop_error = OSError("still gone")
    assert starts_ms(watch, camera, clock, 6100) == [20, 2020, 4020, 6020]  # where the start fails
    assert camera.stops == camera.starts
    assert not is_active(faults, m.FAULT_CAMERA_TIMEOUT) and faults.last == m.FAULT_CAMERA
    camera.start_error = camera.stop_error = None
    assert starts_ms(watch, camera, clock, 2000) == [1920, 1960]  # where it helps for a moment
    camera.error = None
    assert run(watch, clock, 200) == 9
    watch, camera, faults, clock = watched()
    camera.silent = True
    assert starts_ms(watch, camera, clock, 3100) == [1020, 2040, 3060]  # a second for the first frame
    assert is_active(faults, m.FAULT_CAMERA_TIMEOUT)


def test_a_camera_that_was_not_started_is():
    watch, camera, faults, clock = watched(False)
    clock.now_ms += 1999
    assert not watch.grab() and not camera.starts
    clock.now_ms += 1
    assert not watch.grab() and camera.starts == 1 and faults.last == m.FAULT_CAMERA_RESET
    assert watch.grab()


def test_an_opening_or_an_end_is_no_reason_for_a_start():
    for name in ("opening", "ended"):
        watch, camera, faults, clock = watched()
        setattr(camera, name, True)
        silent_since_ms(watch, camera, clock, 5000)
        run(watch, clock, 5000)
        assert not camera.starts
        assert is_active(faults, m.FAULT_CAMERA_TIMEOUT) == (name == "opening")
    camera.ended = False
    run(watch, clock, 3000)
    assert camera.starts


def test_a_silence_is_one_fault_even_when_the_clock_wraps():
    watch, camera, faults, clock = watched()
    camera.opening = True  # so that nothing starts it again
    silent_since_ms(watch, camera, clock, 5000)
    for _ in range(9):
        clock.now_ms += m.COUNT_MAX >> 3
        watch.grab()
        assert is_active(faults, m.FAULT_CAMERA_TIMEOUT) and faults.total == 1


def test_copies_in_a_row_are_a_fault_and_no_frames():
    watch, camera, faults, clock = watched()
    assert run(watch, clock, 5 * FRAME_MS) == 5
    camera.grey = 120
    assert watch.grab()
    for copies in range(1, 7):
        assert not watch.grab()
        assert is_active(faults, m.FAULT_CAMERA_FROZEN) == (copies >= 5), copies
    assert watch.frame_number == 11  # the camera made them
    camera.grey = None
    assert watch.grab() and not faults.active
    camera.grey = 90
    assert run(watch, clock, 3000) == 1 and camera.starts  # a start may help,
    assert not is_active(faults, m.FAULT_CAMERA_TIMEOUT)
    watch, camera, faults, clock = watched()
    camera.grey, camera.adjustable = 90, False
    assert run(watch, clock, 5000) == 1 and not camera.starts  # but not of a recording


def test_dark_and_white_frames_in_a_row_are_faults():
    for grey, code in ((10, m.FAULT_CAMERA_DARK), (255, m.FAULT_CAMERA_WHITE)):
        watch, camera, faults, clock = watched()
        camera.grey = grey
        assert run(watch, clock, 9 * FRAME_MS) == 9 and not faults.active
        assert run(watch, clock, 3 * FRAME_MS) == 3 and faults.active == 1 << code
        camera.grey = None
        assert watch.grab() and not faults.active
        camera.grey = grey
        run(watch, clock, 9 * FRAME_MS)
        assert not faults.active  # counted anew


class Sender:
    """A raw frame that is being sent."""

    is_busy = True
    forgotten = 0

    def busy(self):
        return self.is_busy

    def forget(self):
        self.forgotten += 1


def test_a_frame_that_is_sent_is_kept_for_chunks_that_are_asked_again():
    watch, camera, faults, clock = watched()
    assert run(watch, clock, 100) == 5
    raw = Sender()
    watch.hold(raw)
    assert run(watch, clock, 8000) == 0 and not raw.forgotten
    raw.is_busy = False
    assert run(watch, clock, 1480) == 0 and not raw.forgotten
    assert run(watch, clock, 40) >= 1 and raw.forgotten == 1
    assert not faults.total and not camera.starts  # the camera is not to blame
    camera.silent = True
    assert run(watch, clock, 960) == 0 and not faults.total


def test_numbers_go_up_whatever_the_driver_counts():
    watch, camera, _, _ = watched()
    for number, skipped, told, missed in (
        (0, 0, 0, 0),
        (3, 2, 3, 2),
        (3, 2, 4, 2),  # the same once more
        (1, 1, 5, 2),  # backwards
        (2, 4, 6, 5),
    ):
        camera.frame_number, camera.skipped = number - 1, skipped
        assert watch.grab()
        assert (watch.frame_number, watch.missed) == (told, missed), number
    watch.frame_number = watch.missed = m.COUNT_MAX
    camera.skipped += 1
    assert watch.grab() and watch.frame_number == watch.missed == 0


def test_memory_that_runs_out_does_not_stop_the_camera():
    watch, camera, faults, clock = watched()
    camera.error = MemoryError()
    assert not watch.grab() and faults.last == m.FAULT_MEMORY
    camera.error = None
    assert watch.grab() and not camera.starts
