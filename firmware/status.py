"""Counters and times of the loop, and the status message made of them once a second."""

import gc

import larics
from larics.wire import messages as m
from larics.wire.codec import fields

VERSION = tuple(int(part) for part in larics.__version__.split("."))

_HEAP_EVERY = 10  # statuses: looking for free memory walks the whole heap
_GREY_PIXELS = 256  # how many pixels the mean grey is taken from


class Status:
    """Counts; `fill` makes the values of a STATUS. `clock`: time's ticks_* functions."""

    def __init__(self, boot, faults, clock):
        self.frames = 0
        self.missed = 0
        self.detections = 0
        self.rejects = 0
        self.state = m.LOST
        self._boot = boot
        self._faults = faults
        self._clock = clock
        self._values = [0] * len(fields(m.STATUS))
        self._free_bytes = 0
        self._until_heap = 0
        self._begin_second()

    def _begin_second(self):
        self._second_us = self._clock.ticks_us()
        self._second_frames = 0
        self._detect_us = 0

    def frame_done(self, count, detect_us):
        """A frame was processed with `count` markers to report."""
        self.frames = (self.frames + 1) & m.COUNT_MAX
        self.detections = (self.detections + count) & m.COUNT_MAX
        self._second_frames += 1
        self._detect_us += detect_us

    def fill(self, camera, outbox, line):
        """The values of a STATUS, valid until the next call; begins the next second. `line`: counters of
        the decoder of what arrives."""
        values = self._values
        if not self._until_heap and hasattr(gc, "mem_free"):
            self._free_bytes = gc.mem_free() & m.COUNT_MAX
            self._until_heap = _HEAP_EVERY
        self._until_heap -= 1
        frames = self._second_frames
        second_us = max(1, self._clock.ticks_diff(self._clock.ticks_us(), self._second_us))
        faults = self._faults
        values[0] = VERSION[0]
        values[1] = VERSION[1]
        values[2] = VERSION[2]
        values[3] = self._boot
        values[4] = (outbox.uptime.s + (outbox.uptime.us >= 500000)) & m.COUNT_MAX  # rounded: no 1, 1, 3
        values[5] = self.frames
        values[6] = self.missed
        values[7] = self.detections
        values[8] = self.rejects
        values[9] = outbox.drops
        values[10] = line.crc
        values[11] = line.cobs + line.length + line.version + line.unknown
        values[11] += line.over_long + line.out_of_range
        values[12] = faults.total
        values[13] = faults.last
        values[14] = faults.active
        values[15] = self.state
        values[16] = camera.exposure()
        values[17] = camera.gain()
        values[18] = mean_grey(camera.frame)
        values[19] = frames * 100000 // max(1, second_us // 1000)
        values[20] = second_us // frames if frames else 0
        values[21] = self._detect_us // frames if frames else 0
        values[22] = outbox.worst_age_us
        values[23] = self._free_bytes
        outbox.worst_age_us = 0
        self._begin_second()
        return values


def mean_grey(frame):
    """Mean of evenly spread pixels, 0 without a frame."""
    if not frame:
        return 0
    step = max(1, len(frame) // _GREY_PIXELS) | 1  # odd, so that it meets every column
    total = count = place = 0
    while place < len(frame):
        total += frame[place]
        count += 1
        place += step
    return total // count
