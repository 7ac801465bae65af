"""Counters and times of the loop, and the status message made of them once a second."""

import gc

import larics
from larics.wire import messages as m

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

# generated: begin indices (tools/make_protocol.py)
_STATUS_FIELDS = const(30)
_STATUS_VERSION_MAJOR = const(0)
_STATUS_VERSION_MINOR = const(1)
_STATUS_VERSION_PATCH = const(2)
_STATUS_BOOT = const(3)
_STATUS_UPTIME_S = const(4)
_STATUS_FRAMES = const(5)
_STATUS_MISSED = const(6)
_STATUS_DETECTIONS = const(7)
_STATUS_REJECTS = const(8)
_STATUS_DROPS = const(9)
_STATUS_CRC_ERRORS = const(10)
_STATUS_LINE_ERRORS = const(11)
_STATUS_FAULTS = const(12)
_STATUS_LAST_FAULT = const(13)
_STATUS_ACTIVE_FAULTS = const(14)
_STATUS_STATE = const(15)
_STATUS_EXPOSURE_US = const(16)
_STATUS_GAIN_CDB = const(17)
_STATUS_GREY_MEAN = const(18)
_STATUS_RATE_CHZ = const(19)
_STATUS_FRAME_US = const(20)
_STATUS_DETECT_US = const(21)
_STATUS_LATENCY_US = const(22)
_STATUS_FREE_BYTES = const(23)
_STATUS_UNANSWERED = const(24)
_STATUS_CLAMPED = const(25)
_STATUS_ODOMETRY_USED = const(26)
_STATUS_ODOMETRY_REFUSED = const(27)
_STATUS_ODOMETRY_STALE = const(28)
_STATUS_ODOMETRY_JUMPS = const(29)
# generated: end indices

VERSION = tuple(int(part) for part in larics.__version__.split("."))

_HEAP_EVERY = 30  # statuses: collecting and looking for free memory walks the whole heap
_MEASURED_US = 500000  # a rate of less would be that of the start, not of the camera


class Status:
    """Counts the frames; `fill` makes the values of a STATUS of what the parts of the program count.

    app     see loop.Loop, with the decoder and the encoder of the line beside
    clock   time's ticks_* functions
    """

    def __init__(self, boot, app, clock):
        self.frames = 0
        self._detections = 0
        self._rejects = 0
        self._boot = boot
        self._app = app
        self._clock = clock
        self._values = [0] * _STATUS_FIELDS
        self._free_bytes = 0
        self._until_heap = 0
        self._begin_second()

    def _begin_second(self):
        self._second_us = self._clock.ticks_us()
        self._second_frames = 0
        self._detect_us = 0

    def frame_done(self, count, rejected, detect_us):
        """A frame was processed with `count` markers to report and `rejected` others."""
        self.frames = (self.frames + 1) & m.COUNT_MAX
        self._detections = (self._detections + count) & m.COUNT_MAX
        self._rejects = (self._rejects + rejected) & m.COUNT_MAX
        self._second_frames += 1
        self._detect_us += detect_us

    def fill(self, now_ms):
        """The values of a STATUS, valid until the next call; begins the next second."""
        values, app = self._values, self._app
        if not self._until_heap and hasattr(gc, "mem_free"):
            gc.collect()  # what is free, and not what has not been collected yet
            self._free_bytes = gc.mem_free() & m.COUNT_MAX
            self._until_heap = _HEAP_EVERY
        self._until_heap -= 1
        frames = self._second_frames
        second_us = max(1, self._clock.ticks_diff(self._clock.ticks_us(), self._second_us))
        camera, outbox = app.watch.camera, app.outbox
        faults, received = app.faults, app.decoder.counters  # four at once would make a tuple
        values[_STATUS_VERSION_MAJOR] = VERSION[0]
        values[_STATUS_VERSION_MINOR] = VERSION[1]
        values[_STATUS_VERSION_PATCH] = VERSION[2]
        values[_STATUS_BOOT] = self._boot
        values[_STATUS_UPTIME_S] = (
            outbox.uptime.s + (outbox.uptime.us >= 500000)
        ) & m.COUNT_MAX  # rounded: no 1, 1, 3
        values[_STATUS_FRAMES] = self.frames
        values[_STATUS_MISSED] = app.watch.missed
        values[_STATUS_DETECTIONS] = self._detections
        values[_STATUS_REJECTS] = self._rejects
        values[_STATUS_DROPS] = outbox.drops
        values[_STATUS_CRC_ERRORS] = received.crc
        values[_STATUS_LINE_ERRORS] = received.cobs + received.length + received.version + received.unknown
        values[_STATUS_LINE_ERRORS] += received.over_long + received.out_of_range
        values[_STATUS_FAULTS] = faults.total
        values[_STATUS_LAST_FAULT] = faults.last
        values[_STATUS_ACTIVE_FAULTS] = faults.active
        values[_STATUS_STATE] = app.parts.sensor.state(now_ms, self._clock.ticks_us())
        values[_STATUS_EXPOSURE_US] = camera.exposure()
        values[_STATUS_GAIN_CDB] = camera.gain()
        values[_STATUS_GREY_MEAN] = app.watch.check.mean if camera.frame else m.GREY_UNKNOWN
        measured = second_us >= _MEASURED_US
        values[_STATUS_RATE_CHZ] = frames * 100000 // (second_us // 1000) if measured else m.RATE_UNKNOWN
        values[_STATUS_FRAME_US] = second_us // frames if frames and measured else m.TIME_UNKNOWN
        values[_STATUS_DETECT_US] = self._detect_us // frames if frames else m.TIME_UNKNOWN
        values[_STATUS_LATENCY_US] = outbox.worst_age_us or m.TIME_UNKNOWN
        values[_STATUS_FREE_BYTES] = self._free_bytes
        values[_STATUS_UNANSWERED] = app.commands.unanswered
        values[_STATUS_CLAMPED] = app.encoder.clamped
        odometry = app.odometry
        values[_STATUS_ODOMETRY_USED] = odometry.used
        values[_STATUS_ODOMETRY_REFUSED] = odometry.refused
        values[_STATUS_ODOMETRY_STALE] = odometry.stale
        values[_STATUS_ODOMETRY_JUMPS] = odometry.jumps
        outbox.worst_age_us = 0
        self._begin_second()
        return values
