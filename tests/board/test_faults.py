"""Faults of line, memory and program: counted, reported with their codes, and recovered from."""

from failing_camera import ACTIVE, FAULTS, LAST, STATE, Broken, last_status, markers, program, steps

from larics.wire import messages as m
from wire_values import at


def test_no_fault_in_normal_operation():
    app, _, uart, clock = program()
    steps(app, clock, 2500)
    status = last_status(uart)
    assert status[FAULTS] == 0 and status[LAST] == 0 and status[ACTIVE] == 0 and status[STATE] == m.TRACKING
    assert markers(uart) > 50


def test_line_that_takes_nothing_or_fails():
    app, _, uart, clock = program()
    steps(app, clock, 500)
    for trouble in ("room", "broken"):
        uart.room, uart.broken = (0, False) if trouble == "room" else (1000, True)
        total = app.faults.total
        steps(app, clock, 1500)
        assert app.faults.active == 1 << m.FAULT_UART_WRITE and app.faults.total == total + 1
        uart.room, uart.broken = 1000, False
        steps(app, clock, 1500)
        assert app.faults.active == 0
        assert last_status(uart)[FAULTS] == total + 1 and last_status(uart)[LAST] == m.FAULT_UART_WRITE
    frames = [values[at(m.MARKER, "frame")] for values in uart.of(m.MARKER)]
    assert frames == sorted(frames)  # what waited too long was replaced by newer ones
    assert frames[-1] - frames[0] > len(frames) + 100


def test_an_exception_in_the_detection_costs_its_frame():
    app, _, uart, clock = program()
    real = app.parts.sensor.detector
    steps(app, clock, 300)
    app.parts.sensor.detector = Broken()
    before = markers(uart)
    steps(app, clock, 1200)
    assert app.faults.active == 1 << m.FAULT_DETECT and markers(uart) <= before + 1
    app.parts.sensor.detector = real
    steps(app, clock, 1000)
    assert markers(uart) > before + 20 and last_status(uart)[LAST] == m.FAULT_DETECT
    assert last_status(uart)[ACTIVE] == 0


def test_memory_that_runs_out_is_collected():
    app, _, uart, clock = program()
    steps(app, clock, 300)
    real = app.parts.sensor.detector

    class Hungry:
        calls = 0

        def detect(self, frame):
            Hungry.calls += 1
            if Hungry.calls < 3:
                bytearray(1 << 29)
            return real.detect(frame)

    app.parts.sensor.detector = Hungry()
    before = markers(uart)
    steps(app, clock, 1500)
    assert app.faults.total == 2 and app.faults.last == m.FAULT_MEMORY and markers(uart) > before + 50


def test_an_exception_anywhere_else_does_not_stop_the_loop():
    app, _, uart, clock = program()
    real = app.status.fill

    def broken(*arguments):
        raise KeyError("oops")

    app.status.fill = broken
    steps(app, clock, 1500)
    assert app.faults.last == m.FAULT_LOOP and markers(uart) > 50
    app.status.fill = real
    steps(app, clock, 1500)
    assert last_status(uart)[LAST] == m.FAULT_LOOP


def test_a_command_that_raises_does_not_stop_the_loop():
    from larics.wire import codec as protocol

    app, _, uart, clock = program()
    encoder = protocol.Encoder()
    app.actions.info = None  # not callable
    count = encoder.encode(m.PING, (7,))
    ping = bytes(encoder.buffer[:count])
    count = encoder.encode(m.GET_RAW, (8, m.RAW_WHOLE))
    app.actions.raw_frame = None
    uart.incoming = bytes(encoder.buffer[:count])
    steps(app, clock, 300)
    assert app.faults.last == m.FAULT_COMMAND
    uart.incoming = ping
    steps(app, clock, 300)
    assert [7, m.PING] in uart.of(m.ACK) and markers(uart) > 20


def test_settings_that_do_not_suit_the_camera_that_is_there_fall_back():
    values = {"width": 80, "height": 60, "focal_q8": 40 * 256, "map": [[5, 0, 0, 0, 0, 0]], "rate_divider": 2}
    app, _, _, _ = program(values)
    assert app.faults.active == 1 << m.FAULT_SETTINGS_CORRUPT and not app.parts.sensor.calibrated
    assert app.settings.focal_q8 == 0 and app.settings.rate_divider == 2 and len(app.settings.map) == 1
    app.loop.step()
    assert app.parts.sensor.navigator is None and app.status.frames == 1


def test_a_frame_size_that_was_set_waits_for_a_restart():
    app, _, uart, clock = program({"method": "larics"})
    steps(app, clock, 300)
    for name, value in (("width", 640), ("height", 480), ("radius_max_px", 30), ("tracking", False)):
        app.settings.set(name, value)
        app.actions.settings_changed(name)
    steps(app, clock, 1500)
    assert app.faults.total == 0 and last_status(uart)[STATE] == m.TRACKING
