"""The sensor that settings describe: from a frame to measurements, poses and a state.

Board, monitor, validation and figures all use this class, so that what a tool shows of a frame is what the
board makes of it.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.device.factory import make_detector, make_locator, make_navigator, make_rolling
from larics.device.measurements import Measuring
from larics.device.tracking import Sighting
from larics.settings.fields import DETECTOR, LOCATOR, NAVIGATOR
from larics.wire.messages import COUNT_MAX

_BESIDE_PX = const(8)  # beside the plate, whose radius is 5/3 of the outer ring's
EVERY_PART = DETECTOR | LOCATOR | NAVIGATOR


class Sensor:
    """`rebuild` first, and again with what the changed setting declares (Field.rebuilds).

    settings     larics.settings.Settings; size: (width, height) of the frames, None for that of the settings;
                 weigh_all: as of Detector
    detector     its detect(frame) gives a list of Detection; None before it is built
    locator      larics.locate.camera_model.Camera
    navigator    larics.locate.navigator.Navigator; None without a map or a calibration
    calibrated   whether millimetres mean anything
    found        the detections of the newest frame, empty while none of it is known
    measurements, rejected   after `place`: those of the frame, and how many detections were not reported
    """

    def __init__(self, settings, size=None, weigh_all=True):
        self.settings = settings
        self._weigh_all = weigh_all
        self.size = size
        self.detector = self.locator = self.navigator = None
        self.calibrated = False
        self._rolling = None
        self.found = ()
        self._measuring = Measuring()
        self.measurements = self._measuring.measurements
        self._sighting = Sighting()

    def rebuild(self, parts=EVERY_PART, settings=None):
        """Makes those of its parts anew that are among `parts`, by other `settings` when its own do not do.

        ValueError when the settings do not suit the frames, MemoryError; the part that failed is then as it
        was. Where there is no memory for two detectors, set `detector` to None before."""
        settings = settings or self.settings
        if parts & DETECTOR:
            self.detector = make_detector(settings, self.size, weigh_all=self._weigh_all)
        if parts & LOCATOR:
            self.locator = make_locator(settings, self.size)
            self.calibrated = settings.focal_q8 > 0
            self._rolling = make_rolling(settings)
        if parts & NAVIGATOR:
            self.navigator = make_navigator(settings)

    @property
    def rejected(self):
        return self._measuring.rejected

    def window(self, width, height):
        """(left, top, columns, rows) of a frame of that size around all that was `found` in it, each with its
        plate and what is beside it; None when nothing was found."""
        left, top, right, bottom = width, height, 0, 0
        for one in self.found:
            x, y = one.x_q8 >> 8, one.y_q8 >> 8
            around = (one.radius_q8 >> 8) * 2 + _BESIDE_PX
            left, top = min(left, x - around), min(top, y - around)
            right, bottom = max(right, x + around + 1), max(bottom, y + around + 1)
        left, top = max(0, left), max(0, top)
        columns, rows = min(width, right) - left, min(height, bottom) - top
        return (left, top, columns, rows) if columns > 0 and rows > 0 else None

    def place(self, found):
        """Puts the detections of a frame in place; returns how many `measurements` may be reported."""
        return self._measuring.locate(found, self.settings, self.locator, self.navigator)

    def follow(self, count, capture_us, now_ms, odometry=None):
        """Takes the first `count` measurements of a processed frame for pose, route and state; with odometry
        puts right what a rolling shutter made of them.

        capture_us, now_ms: of any clocks modulo 2**30; odometry: as for Localizer.update. Returns the
        fault of the navigator, 0 for none."""
        if self._rolling is not None:
            self._rolling.follow(self.measurements, count, capture_us, odometry)
        self._sighting.update(self.measurements, count, now_ms)
        if self.navigator is None:
            return 0
        self.navigator.update(self.measurements, count, capture_us & COUNT_MAX, odometry)
        return self.navigator.fault

    def state(self, now_ms, now_us):
        """TRACKING, COASTING or LOST: of the pose or, without a map, of the markers. It follows the time, by
        the clocks of `follow`, not only the frames: ask often."""
        state = self._sighting.state(now_ms)
        return state if self.navigator is None else self.navigator.pass_time(now_us & COUNT_MAX)
