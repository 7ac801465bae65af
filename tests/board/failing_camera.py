"""A program with a camera that fails as a test wants, and what it tells of that on the line."""

from board_parts import Clock, Uart, make_app, marker

from larics.wire import messages as m
from wire_values import at

FAULTS = at(m.STATUS, "faults")
LAST = at(m.STATUS, "last_fault")
ACTIVE = at(m.STATUS, "active_faults")
STATE = at(m.STATUS, "state")
_noisy = {}  # pictures made so far


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
    """Runs the loop for so long, a round each 10 ms."""
    end_us = clock.now_us + 1000 * ms
    while clock.now_us < end_us:
        app.loop.step()
        clock.now_us += 10000


def last_status(uart):
    return uart.of(m.STATUS)[-1]


def markers(uart):
    """How many MARKERs came."""
    return len(uart.of(m.MARKER))


MAP = {"method": "larics", "focal_q8": 200 * 256, "ceiling_mm10": 15000, "map": [[5, 0, 0, 0, 0, 0]]}


def state_of(app, clock):
    """The state that the LEDs and STATUS are to tell now."""
    return app.parts.sensor.state(clock.ticks_ms(), clock.ticks_us())


class Broken:
    """A detector that fails, whatever it is shown."""

    def detect(self, frame):
        raise ValueError("wrong")
