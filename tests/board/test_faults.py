"""Each fault injected into the whole program: counted, reported with its code, and recovered from."""

import json
from binascii import crc32

from board_parts import Clock, Uart, make_app, marker, plain

from atomic_file import AtomicFile, unseal
from cameras import CameraError
from faults import Faults
from larics.settings import VERSION, Settings
from larics.wire import messages as m
from settings_store import SettingsStore
from wire_values import at, named

FAULTS = at(m.STATUS, "faults")
LAST = at(m.STATUS, "last_fault")
ACTIVE = at(m.STATUS, "active_faults")
STATE = at(m.STATUS, "state")


def sealed(text):
    """The bytes of a whole file with this text."""
    return text.encode() + b"\n#crc %08x\n" % (crc32(text.encode()) & 0xFFFFFFFF)


_noisy = {}


def noisy(picture, level):
    """The picture with pixels a little brighter: as a sensor, whose noise never comes again."""
    key = (picture, level)
    if key not in _noisy:
        _noisy[key] = bytes([min(255, pixel + level) for pixel in picture])
    return _noisy[key]


class Camera:
    """Delivers the same picture for ever, and fails as a test wants."""

    ended = False
    width, height = 160, 120

    def __init__(self, frame, clock):
        self.picture = frame
        self.clock = clock
        self.frozen = False
        self.exposed = 0
        self.frame = None
        self.frame_number = -1
        self.skipped = 0
        self.capture_us = 0
        self.started = 0
        self.silent = False
        self.error = None
        self.start_error = None

    def start(self):
        self.started += 1
        if self.start_error:
            raise self.start_error
        self.frame_number = -1

    def grab(self):
        if self.error:
            raise self.error
        if self.silent:
            return False
        if not self.frozen or not self.exposed:
            self.exposed += 1
            self.served = noisy(self.picture, self.exposed & 1)
        self.frame = self.served
        self.frame_number += 1
        self.capture_us = self.clock.ticks_us()
        return True

    def exposure(self, us=None):
        return 5000

    def gain(self, cdb=None):
        return 0

    def stop(self):
        self.frame = None


def program(settings=None, **options):
    """(app, camera, uart, clock) of a program that sees a marker."""
    clock = Clock(step_us=50)
    uart = Uart(collect=True)
    camera = Camera(PICTURE, clock)
    app = make_app((), uart, settings, clock=clock, camera=camera, **options)
    return app, camera, uart, clock


PICTURE = marker(5, 80, 60, 20)


def steps(app, clock, ms):
    end_us = clock.now_us + 1000 * ms
    while clock.now_us < end_us:
        app.loop.step()
        clock.now_us += 10000


def last_status(uart):
    return uart.of(m.STATUS)[-1]


def markers(uart):
    return len(uart.of(m.MARKER))


def test_no_fault_in_normal_operation():
    app, _, uart, clock = program()
    steps(app, clock, 2500)
    status = last_status(uart)
    assert status[FAULTS] == 0 and status[LAST] == 0 and status[ACTIVE] == 0 and status[STATE] == m.TRACKING
    assert markers(uart) > 50


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


MAP = {"method": "larics", "focal_q8": 200 * 256, "ceiling_mm10": 15000, "map": [[5, 0, 0, 0, 0, 0]]}


def state_of(app, clock):
    return app.parts.sensor.state(clock.ticks_ms(), clock.ticks_us())


class Lights:
    """Instead of LEDs: what they were told last."""

    def show(self, tracking, coasting, active_faults, elapsed_ms):
        self.shown = (tracking, coasting)


class Broken:
    """A detector that fails, whatever it is shown."""

    def detect(self, frame):
        raise ValueError("wrong")


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


def test_a_picture_that_freezes_ends_the_tracking_with_the_time():
    def freeze(app, camera):
        camera.frozen = True

    assert [state for _, state in states_by_time(MAP, freeze)] == [m.TRACKING, m.COASTING, m.LOST]
    assert [state for _, state in states_by_time(None, freeze)] == [m.TRACKING, m.LOST]


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


def test_a_driver_that_counts_backwards_is_not_followed():
    app, camera, uart, clock = program()
    steps(app, clock, 300)
    camera.frame_number = 3  # what some module does by itself
    steps(app, clock, 300)
    frames = [values[at(m.MARKER, "frame")] for values in uart.of(m.MARKER)]
    assert frames == list(range(len(frames)))


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


def test_an_unconfirmed_id_is_not_tracking():
    app, camera, uart, clock = program({"method": "larics", "confirm_needed": 3, "confirm_frames": 3})
    states = []
    while len(states) < 4:
        if app.loop.step():
            states.append(state_of(app, clock))
    assert states == [m.LOST, m.LOST, m.TRACKING, m.TRACKING]


class Files:
    """Files in memory; full: OSError when written."""

    def __init__(self):
        self.data = {}
        self.full = False
        self.longest = 0  # piece read or written

    def open(self, path, mode):
        if mode == "rb" and path not in self.data:
            raise OSError(2)
        if mode == "wb":
            if self.full:
                raise OSError(28)
            self.data[path] = b""
        return File(self, path)

    def rename(self, source, target):
        self.data[target] = self.data.pop(source)

    def remove(self, path):
        if path not in self.data:
            raise OSError(2)
        del self.data[path]


class File:
    def __init__(self, files, path):
        self.files, self.path, self.at = files, path, 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def read(self, count=1 << 20):
        self.at += count
        self.files.longest = max(self.files.longest, count)
        return self.files.data[self.path][self.at - count : self.at]

    def write(self, data):
        self.files.longest = max(self.files.longest, len(data))
        self.files.data[self.path] += bytes(data)


def kept(files):
    faults = Faults()
    return SettingsStore(AtomicFile("s.json", files, files.open), faults), faults


def test_settings_missing_saved_and_found_again():
    files = Files()
    keeper, faults = kept(files)
    settings = keeper.load()
    assert faults.active == 1 << m.FAULT_SETTINGS_MISSING
    settings.update({"baud": 57600, "map": [[1, 2, 3, 4, 0, 0]], "output": "nmea"})
    assert keeper.save(settings) and faults.active == 0
    keeper, faults = kept(files)
    again = keeper.load()
    assert again.as_dict() == settings.as_dict() and faults.total == 0


def test_settings_are_saved_in_short_pieces():
    files = Files()
    keeper, _ = kept(files)
    settings = Settings({"map": [[k, 0, 20000 * k, 0, 0, 0] for k in range(1, 8)], "route": [1, 2, 3]})
    for _ in range(3):
        assert keeper.save(settings)
    assert files.longest == 256 and len(files.data["s.json"]) > 1500
    assert json.loads(unseal(files.data["s.json"])) == settings.as_dict()


def test_settings_corrupt_from_another_version_and_out_of_range():
    for content, fault, baud in (
        (b"\x00\xff", m.FAULT_SETTINGS_CORRUPT, 115200),
        (sealed("[1, 2"), m.FAULT_SETTINGS_CORRUPT, 115200),
        (sealed("[1, 2]"), m.FAULT_SETTINGS_CORRUPT, 115200),
        (sealed('{"baud": 57600, "width": 5}'), m.FAULT_SETTINGS_CORRUPT, 57600),
        (sealed('{"baud": 57600, "version": %d, "new": 1}' % (VERSION + 1)), m.FAULT_SETTINGS_VERSION, 57600),
    ):
        files = Files()
        files.data["s.json"] = content
        keeper, faults = kept(files)
        assert keeper.load().baud == baud, content
        assert faults.active == 1 << fault and faults.last == fault, (content, faults.last)


def test_power_lost_while_saving_is_told():
    files = Files()
    keeper, _ = kept(files)
    keeper.save(Settings({"baud": 9600}))
    keeper.save(Settings({"baud": 57600}))
    files.data["s.json"] = files.data["s.json"][:-20]
    keeper, faults = kept(files)
    assert keeper.load().baud == 9600 and faults.last == m.FAULT_SAVE_INTERRUPTED and faults.active == 0


def test_a_full_flash_is_told_and_the_old_settings_stay():
    files = Files()
    keeper, faults = kept(files)
    keeper.save(Settings({"baud": 9600}))
    files.full = True
    assert not keeper.save(Settings({"baud": 57600})) and faults.active == 1 << m.FAULT_STORAGE
    assert kept(files)[0].load().baud == 9600
    files.full = False
    assert keeper.save(Settings({"baud": 57600})) and faults.active == 0
