"""The state of the camera by time: it is told alike on the line and by the LEDs, also when no frame comes."""

from board_parts import plain
from failing_camera import ACTIVE, MAP, STATE, Broken, last_status, program, state_of, steps

from larics.wire import messages as m
from wire_values import named


class Lights:
    """Instead of LEDs: what they were told last."""

    def show(self, tracking, coasting, active_faults, elapsed_ms):
        self.shown = (tracking, coasting)


def states_by_time(settings, trouble, seconds=4):
    """[(ms since the trouble began, state)] at each change; LEDs and STATUS must tell the same."""
    lights = Lights()
    app, camera, uart, clock = program(settings, leds=lights)
    steps(app, clock, 500)
    assert state_of(app, clock) == m.TRACKING
    trouble(app, camera)
    begin_us, changes, state = clock.now_us, [], m.TRACKING
    while clock.now_us < begin_us + 1000000 * seconds:
        app.loop.step()
        before, state = state, state_of(app, clock)  # it may change between the two
        assert lights.shown in [(one == m.TRACKING, one == m.COASTING) for one in (before, state)]
        if not changes or state != changes[-1][1]:
            changes.append(((clock.now_us - begin_us) // 1000, state))
        clock.now_us += 10000
    assert last_status(uart)[STATE] == changes[-1][1]
    return changes


def silence(app, camera):
    camera.silent = True


def break_detector(app, camera):
    app.parts.sensor.detector = Broken()


def take_detector(app, camera):
    app.parts.sensor.detector = None
    app.parts.restore = lambda parts: None  # there is no memory for one


def test_the_state_follows_the_time_when_no_frame_is_processed():
    for trouble in (silence, break_detector, take_detector):
        (_, first), (lost_ms, last) = states_by_time(None, trouble)
        assert (first, last) == (m.TRACKING, m.LOST) and 980 <= lost_ms <= 1050, (trouble, lost_ms)
        found = states_by_time(MAP, trouble)
        assert [state for _, state in found] == [m.TRACKING, m.COASTING, m.LOST]
        assert 960 <= found[1][0] <= 1050 and 2960 <= found[2][0] <= 3050, found


def test_a_camera_silent_for_a_minute_is_lost_with_a_fault_all_the_time():
    app, camera, uart, clock = program(MAP)
    steps(app, clock, 1000)
    camera.silent = True
    steps(app, clock, 60000)
    told = uart.of(m.STATUS)[-55:]
    assert {status[STATE] for status in told} == {m.LOST}
    assert {status[ACTIVE] for status in told} == {1 << m.FAULT_CAMERA_TIMEOUT}


def test_the_state_is_told_in_every_encoding():
    for output, tracking, lost in (
        ("nmea", b",T,", b",L,"),
        ("mavlink", b"\x12\x08\0\x04\x03", b"\x12\x08\0\x03\x03"),
    ):
        app, camera, uart, clock = program({"output": output})
        steps(app, clock, 1500)
        assert bytes(uart.sent).rfind(tracking) > bytes(uart.sent).rfind(lost)
        camera.silent = True
        steps(app, clock, 5000)
        assert bytes(uart.sent).rfind(lost) > bytes(uart.sent).rfind(tracking)


def test_a_pose_of_the_time_before_the_clock_went_round_is_not_taken_for_new():
    app, camera, uart, clock = program(MAP)
    steps(app, clock, 500)
    camera.silent = True
    for _ in range(110):  # 1100 s: more than 2**30 us
        steps(app, clock, 20)
        clock.now_us += 10000000
    camera.silent, camera.picture = False, plain(120)
    steps(app, clock, 4000)
    assert app.parts.sensor.navigator.pose.age_us == m.COUNT_MAX and state_of(app, clock) == m.LOST


def test_a_picture_that_freezes_ends_the_tracking_with_the_time():
    def freeze(app, camera):
        camera.frozen = True

    assert [state for _, state in states_by_time(MAP, freeze)] == [m.TRACKING, m.COASTING, m.LOST]
    assert [state for _, state in states_by_time(None, freeze)] == [m.TRACKING, m.LOST]


def test_what_is_not_yet_known_is_said_so():
    app, camera, uart, clock = program(MAP)
    camera.silent = True
    app.loop.step()
    clock.now_us += 100000
    app.loop.step()
    first = named(m.STATUS, uart.of(m.STATUS)[0])
    assert first["rate_chz"] == m.RATE_UNKNOWN and first["grey_mean"] == m.GREY_UNKNOWN
    assert first["frame_us"] == first["detect_us"] == first["latency_us"] == m.TIME_UNKNOWN
    steps(app, clock, 950)
    second = named(m.STATUS, last_status(uart))
    assert second["rate_chz"] == 0 and second["latency_us"] == m.TIME_UNKNOWN
    camera.silent, camera.picture = False, plain(120)
    steps(app, clock, 1500)
    told = named(m.STATUS, last_status(uart))
    assert 5000 < told["rate_chz"] < 10000 and told["grey_mean"] == 120 and told["detect_us"] < 1000000
    lost = named(m.POSE, uart.of(m.POSE)[-1])
    assert (lost["state"], lost["marker_age_ms"], lost["id"]) == (m.LOST, m.AGE_UNKNOWN, m.ID_NONE)
    assert lost["x_mm10"] == lost["y_mm10"] == m.PLACE_UNKNOWN and lost["heading_cdeg"] == m.HEADING_UNKNOWN
    assert app.encoder.clamped == 0


def test_an_unconfirmed_id_is_not_tracking():
    app, camera, uart, clock = program({"method": "larics", "confirm_needed": 3, "confirm_frames": 3})
    states = []
    while len(states) < 4:
        if app.loop.step():
            states.append(state_of(app, clock))
    assert states == [m.LOST, m.LOST, m.TRACKING, m.TRACKING]
