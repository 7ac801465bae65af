"""Frames from another program, one at a time, each with the time at which it was taken.

For closed loops: a simulator writes a frame, the firmware processes it and reports, the simulator moves
the vehicle by what was reported and writes the next one. The clock goes by the frames' own times, so a
slow PC changes nothing in the result.

A frame is a header of 16 bytes, little-endian (magic "LPF1", width u16, height u16, number u32,
capture_us u32 below 2**30) and width * height pixels. The end of the stream ends the camera.
"""

import struct

from cameras import CameraError

HEADER = "<4sHHII"
MAGIC = b"LPF1"
_PERIOD = 1 << 30


class FrameClock:
    """The ticks_* functions of time, standing at the newest frame's time plus `latency_us`, which stands
    for what capture and detection take on the board."""

    def __init__(self, latency_us):
        self._latency_us = latency_us
        self._now_us = 0
        self._now_ms = 0
        self._rest_us = 0

    def frame_at(self, capture_us):
        now_us = (capture_us + self._latency_us) & (_PERIOD - 1)
        elapsed = (now_us - self._now_us) & (_PERIOD - 1)
        self._now_us = now_us
        elapsed += self._rest_us
        self._now_ms = (self._now_ms + elapsed // 1000) & (_PERIOD - 1)
        self._rest_us = elapsed % 1000

    def ticks_us(self):
        return self._now_us

    def ticks_ms(self):
        return self._now_ms

    def ticks_add(self, ticks, delta):
        return (ticks + delta) & (_PERIOD - 1)

    def ticks_diff(self, new, old):
        return ((new - old + _PERIOD // 2) & (_PERIOD - 1)) - _PERIOD // 2


class Pipe:
    """A camera driver; `path` of a named pipe or another stream of frames. grab() waits for the next one."""

    adjustable = False

    def __init__(self, path, latency_us=15000):
        self._path = path
        self.clock = FrameClock(latency_us)
        self._exposure_us, self._gain_cdb = 1000, 0

    def start(self):
        self._file = open(self._path, "rb", buffering=0)
        self._header = bytearray(struct.calcsize(HEADER))
        self.skipped = 0
        self.ended = False
        self.frame = None
        self.frame_number = -1
        if not self._read_header():
            raise CameraError("%s ended before the first frame" % self._path)
        self.width, self.height = self._next[1], self._next[2]
        self._pixels = bytearray(self.width * self.height)
        self._pending = True

    def _fill(self, buffer):
        """Reads until the buffer is full; False at the end of the stream."""
        view = memoryview(buffer)
        done = 0
        while done < len(buffer):
            count = self._file.readinto(view[done:])
            if not count:
                return False
            done += count
        return True

    def _read_header(self):
        if not self._fill(self._header):
            return False
        self._next = struct.unpack(HEADER, self._header)
        if self._next[0] != MAGIC:
            raise CameraError("no frame header in %s" % self._path)
        return True

    def grab(self):
        if self.ended:
            return False
        if not self._pending and not self._read_header():
            self.ended = True
            return False
        self._pending = False
        if (self._next[1], self._next[2]) != (self.width, self.height):
            raise CameraError("a frame of %dx%d, not as the first" % (self._next[1], self._next[2]))
        if not self._fill(self._pixels):
            self.ended = True
            return False
        self.frame = self._pixels
        self.skipped += max(0, self._next[3] - self.frame_number - 1)
        self.frame_number = self._next[3]
        self.capture_us = self._next[4]
        self.clock.frame_at(self.capture_us)
        return True

    def exposure(self, us=None):
        if us is not None:
            self._exposure_us = us
        return self._exposure_us

    def gain(self, cdb=None):
        if cdb is not None:
            self._gain_cdb = cdb
        return self._gain_cdb

    def stop(self):
        self.ended = True
