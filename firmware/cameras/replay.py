"""Recorded frames, delivered as a camera would: into one reused buffer, on time or as fast as possible.

A recording is a folder of .pgm files (in the order of their names), one file of PGM pictures one after
the other, or a list of buffers. All frames of a recording have one size.
"""

import io
import os
import time

from cameras import CameraError
from cameras.pgm import HEADER_MAX, parse_header


class _Folder:
    """Checks all files at once: a bad one must not look like a camera that fails and comes back."""

    def __init__(self, path):
        self._names = [path + "/" + name for name in sorted(os.listdir(path)) if name.endswith(".pgm")]
        if not self._names:
            raise CameraError("no .pgm frame in the folder %s" % path)
        self.count = len(self._names)
        self._header = bytearray(HEADER_MAX)
        self.width = self.height = 0
        for name in self._names:
            self._check(name)

    def _check(self, name):
        with open(name, "rb") as file:
            count = file.readinto(self._header)
        try:
            width, height, offset = parse_header(memoryview(self._header)[:count])
        except ValueError as error:
            raise CameraError("%s: %s" % (name, error))
        if os.stat(name)[6] < offset + width * height:
            raise CameraError("%s is cut off" % name)
        if not self.width:
            self.width, self.height = width, height
        if (width, height) != (self.width, self.height):
            raise CameraError("%s is %dx%d, not as the first" % (name, width, height))

    def read(self, index, frame):
        with open(self._names[index], "rb") as file:
            count = file.readinto(self._header)
            file.seek(parse_header(memoryview(self._header)[:count])[2])
            if file.readinto(frame) != len(frame):
                raise CameraError("%s is cut off" % self._names[index])


class _Pictures:
    """One file of equally long pictures; reading one allocates nothing."""

    def __init__(self, path):
        self._file = open(path, "rb")
        header = bytearray(HEADER_MAX)
        count = self._file.readinto(header)
        self.width, self.height, self._offset = parse_header(memoryview(header)[:count])
        self._stride = self._offset + self.width * self.height
        size = os.stat(path)[6]
        self.count = size // self._stride
        if size % self._stride or not self.count:
            raise CameraError("%s does not hold whole frames of %dx%d" % (path, self.width, self.height))

    def read(self, index, frame):
        self._file.seek(index * self._stride + self._offset)
        if self._file.readinto(frame) != len(frame):
            raise CameraError("recording is cut off at frame %d" % index)


class _Buffers:
    def __init__(self, frames, width, height):
        self._streams = [io.BytesIO(frame) for frame in frames]  # copying a slice would allocate
        if not self._streams:
            raise CameraError("the list of frames is empty")
        self.count = len(self._streams)
        self.width, self.height = width, height

    def read(self, index, frame):
        stream = self._streams[index]
        stream.seek(0)
        if stream.readinto(frame) != len(frame):
            raise CameraError("frame %d is too short" % index)


class Replay:
    """`frames`: path or list (then `width`, `height` tell the size). `fps` 0 delivers without waiting.

    `rounds` repeats the recording, 0 for ever. At a frame rate, frames that were not fetched in time are
    skipped and counted, as with a camera. Raises CameraError or OSError when nothing can be read.
    """

    adjustable = False  # a recording cannot be exposed again

    def __init__(self, frames, fps=0, rounds=1, width=0, height=0, clock=time):
        self._frames = frames
        self._period_us = 1000000 // fps if fps else 0
        self._rounds = rounds
        self.width, self.height = width, height
        self._clock = clock
        self._exposure_us, self._gain_cdb = 1000, 0
        self._source = None
        self.frame = None

    def start(self):
        if not isinstance(self._frames, str):
            self._source = _Buffers(self._frames, self.width, self.height)
        elif os.stat(self._frames)[0] & 0x4000:
            self._source = _Folder(self._frames)
        else:
            self._source = _Pictures(self._frames)
        self.width, self.height = self._source.width, self._source.height
        if self.frame is None or len(self.frame) != self.width * self.height:
            self.frame = bytearray(self.width * self.height)
        self.frame_number = -1
        self.skipped = 0
        self.ended = False
        self._round = 0
        self._index = -1  # in the recording; frame_number goes on counting over the rounds
        self._begun = False  # the first frame is taken when it is first asked for
        self.capture_us = self._due_us = 0

    def grab(self):
        if self.ended:
            return False
        now_us = self._clock.ticks_us()
        if not self._begun:
            self._begun = True
            self._due_us = now_us
        steps = 1
        if self._period_us:
            late_us = self._clock.ticks_diff(now_us, self._due_us)
            if late_us < 0:
                return False
            steps += late_us // self._period_us
            self.capture_us = self._clock.ticks_add(self._due_us, (steps - 1) * self._period_us)
            self._due_us = self._clock.ticks_add(self._due_us, steps * self._period_us)
        else:
            self.capture_us = now_us
        return self._advance(steps)

    def _advance(self, steps):
        count = self._source.count
        index = self._index + steps
        while index >= count:
            if self._rounds and self._round == self._rounds - 1:
                if self._index == count - 1:
                    self.ended = True
                    return False
                steps -= index - count + 1  # late, but the last frame is the newest there is
                index = count - 1
                break
            self._round += 1
            self._index -= count
            index -= count
        self._index = index
        self.frame_number += steps
        self.skipped += steps - 1
        self._source.read(index, self.frame)
        return True

    def exposure(self, us=None):
        if us is not None:
            self._exposure_us = us  # only reported
        return self._exposure_us

    def gain(self, cdb=None):
        if cdb is not None:
            self._gain_cdb = cdb
        return self._gain_cdb

    def stop(self):
        self._source = None
        self.ended = True
