"""Cameras that deliver nothing, fail, freeze or see nothing: counted, reported and started again."""

from board_parts import Clock, Uart, plain
from failing_camera import ACTIVE, LAST, MAP, PICTURE, STATE, Camera, last_status, markers, program, steps

from cameras import CameraError
from larics.settings import Settings
from larics.wire import messages as m
from wire_values import at


def test_camera_that_delivers_nothing_is_started_again():
    app, camera, uart, clock = program()
    steps(app, clock, 1000)
    camera.silent = True
    steps(app, clock, 1500)
    assert app.faults.active == 1 << m.FAULT_CAMERA_TIMEOUT and camera.started == 2
    assert app.faults.last == m.FAULT_CAMERA_RESET
    steps(app, clock, 1500)
    assert last_status(uart)[ACTIVE] == 1 << m.FAULT_CAMERA_TIMEOUT
    camera.silent = False
    before = markers(uart)
    steps(app, clock, 2500)
    assert markers(uart) > before + 100 and last_status(uart)[ACTIVE] == 0


def test_an_opening_that_takes_long_is_not_begun_anew():
    app, camera, uart, clock = program()
    steps(app, clock, 500)
    camera.silent = camera.opening = True
    steps(app, clock, 10000)
    assert camera.started == 1
    assert last_status(uart)[ACTIVE] == 1 << m.FAULT_CAMERA_TIMEOUT and last_status(uart)[STATE] == m.LOST
    camera.opening = False
    steps(app, clock, 500)
    assert camera.started == 1  # its patience begins when the opening is over
    camera.silent = False
    steps(app, clock, 1500)
    assert camera.started == 1 and last_status(uart)[ACTIVE] == 0


def test_a_silence_of_days_stays_one():
    app, camera, uart, clock = program()
    steps(app, clock, 500)
    camera.silent = camera.opening = True
    for _ in range(120):  # more than half the period of the clock's milliseconds
        clock.now_us += 5000000000
        app.loop.step()
    assert app.faults.active == 1 << m.FAULT_CAMERA_TIMEOUT
    camera.opening = False
    steps(app, clock, 1500)
    assert camera.started == 2


def test_camera_that_raises_is_started_again_and_the_status_goes_on():
    app, camera, uart, clock = program()
    steps(app, clock, 500)
    camera.error = CameraError("csi: Frame capture has timed out.")
    camera.start_error = RuntimeError("Failed to detect the image sensor")
    before = len(uart.of(m.STATUS))
    steps(app, clock, 6000)
    assert len(uart.of(m.STATUS)) >= before + 5 and last_status(uart)[LAST] == m.FAULT_CAMERA
    assert 3 <= camera.started <= 5  # not in every round
    camera.error = camera.start_error = None
    before = markers(uart)
    steps(app, clock, 4000)
    assert markers(uart) > before + 100 and app.faults.last == m.FAULT_CAMERA_RESET


def test_a_camera_that_is_missing_at_the_start_may_come_later():
    from app import App

    clock, uart = Clock(step_us=50), Uart(collect=True)
    camera = Camera(PICTURE, clock)
    camera.start_error = OSError(19)
    values = {"method": "paper", "radius_min_px": 15, "radius_max_px": 25, "width": 160, "height": 120}
    app = App(Settings(values), camera, uart, "test", clock=clock)
    steps(app, clock, 3000)
    assert last_status(uart)[LAST] == m.FAULT_CAMERA and markers(uart) == 0
    camera.start_error = None
    steps(app, clock, 4000)
    assert markers(uart) > 50


def test_frame_numbers_go_on_when_the_camera_is_started_again():
    app, camera, uart, clock = program()
    steps(app, clock, 1000)
    camera.silent = True
    steps(app, clock, 3500)
    camera.silent = False
    steps(app, clock, 2000)
    assert camera.started > 1 and camera.frame_number < app.watch.frame_number
    frames = [values[at(m.MARKER, "frame")] for values in uart.of(m.MARKER)]
    assert frames == list(range(len(frames))) and app.watch.missed == 0


def test_a_frozen_picture_is_neither_tracked_nor_confirmed():
    confirming = {"method": "larics", "confirm_needed": 3, "confirm_frames": 4}
    app, camera, uart, clock = program(dict(MAP, **confirming))
    app.loop.step()
    camera.frozen = True
    steps(app, clock, 3500)
    told = uart.of(m.MARKER)
    assert len(told) == 1 and told[0][at(m.MARKER, "flags")] & m.MARKER_UNCONFIRMED  # no copy was reported
    status = last_status(uart)
    assert status[STATE] == m.LOST and status[ACTIVE] >> m.FAULT_CAMERA_FROZEN & 1
    assert not status[ACTIVE] >> m.FAULT_CAMERA_TIMEOUT & 1 and camera.started > 1  # it may help
    camera.frozen = False
    steps(app, clock, 3500)
    assert last_status(uart)[STATE] == m.TRACKING and last_status(uart)[ACTIVE] == 0


def test_single_copies_cost_nothing_and_are_no_fault():
    app, camera, uart, clock = program(MAP)
    for k in range(300):
        camera.frozen = k & 1 == 1
        app.loop.step()
        clock.now_us += 10000
    assert app.faults.total == 0 and markers(uart) <= 151 and last_status(uart)[STATE] == m.TRACKING
    assert app.watch.missed == 0


def test_darkness_and_glare_are_not_taken_for_a_frozen_camera():
    for grey, fault in ((0, m.FAULT_CAMERA_DARK), (12, m.FAULT_CAMERA_DARK), (255, m.FAULT_CAMERA_WHITE)):
        app, camera, uart, clock = program()
        camera.picture, camera.frozen = plain(grey), True
        steps(app, clock, 2500)
        assert app.faults.active == 1 << fault, (grey, app.faults.active)
        assert app.status.frames > 100 and markers(uart) > 100  # frames without a marker, and exposed anew
        camera.picture, camera.frozen = PICTURE, False
        steps(app, clock, 2500)
        assert app.faults.active == 0 and last_status(uart)[STATE] == m.TRACKING
    app, camera, uart, clock = program()
    camera.picture, camera.frozen = plain(128), True  # what a dead sensor may look like
    steps(app, clock, 2500)
    assert app.faults.active == 1 << m.FAULT_CAMERA_FROZEN


def test_a_driver_that_counts_backwards_is_not_followed():
    app, camera, uart, clock = program()
    steps(app, clock, 300)
    camera.frame_number = 3  # what some module does by itself
    steps(app, clock, 300)
    frames = [values[at(m.MARKER, "frame")] for values in uart.of(m.MARKER)]
    assert frames == list(range(len(frames)))
