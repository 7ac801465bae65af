"""Frames from another program, one at a time, each with the time at which it was taken, and the line.

For closed loops: a simulator writes a frame, the firmware processes it and reports, the simulator moves
the vehicle by what was reported and writes the next one. The clock goes by the times in the stream, so a
slow PC changes nothing in the result.

The stream has records with a header of 16 bytes, little-endian: magic, width u16, height u16, number u32,
time_us u32 below 2**30. "LPF1" is a frame, taken at that time, width * height pixels follow. "LPB1" are width
bytes that the line has brought by that time; they come before the first frame that is still processed then.
The end of the stream ends the camera.

With a second pipe the program answers each frame, before it waits for the next one: CONTROLS, little-endian,
exposure_us u32 and gain_cdb u32 as the driver has them now, for a simulator whose light and blur follow them.
"""

import struct

from cameras import CameraError

try:
    from time import ticks_ms
except ImportError:
    from pc.host_clock import ticks_ms

HEADER = "<4sHHII"
CONTROLS = "<II"
MAGIC = b"LPF1"
LINE_MAGIC = b"LPB1"
_PERIOD = 1 << 30
_TURN_US = 1000  # while it waits for a frame, the loop looks at the line about so often
_RECEIVED_MOST = 1024  # what the receive buffer of a board holds


class FrameClock:
    """The ticks_* functions of time, standing where the stream is: where bytes of the line arrive, or at the
    newest frame's time plus `latency_us`, which stands for what capture and detection take on the board.
    After the end of the stream time passes as on the computer."""

    def __init__(self, latency_us):
        self._latency_us = latency_us
        self._ended_ms = None
        self._now_us = 0
        self._now_ms = 0
        self._rest_us = 0

    def frame_at(self, capture_us):
        self.stand_at(capture_us + self._latency_us)

    def stand_at(self, now_us):
        now_us &= _PERIOD - 1
        elapsed = (now_us - self._now_us) & (_PERIOD - 1)
        self._now_us = now_us
        elapsed += self._rest_us
        self._now_ms = (self._now_ms + elapsed // 1000) & (_PERIOD - 1)
        self._rest_us = elapsed % 1000

    def end(self):
        """No frame comes any more: whoever waits for the line waits no longer than it may."""
        self._ended_ms = ticks_ms()

    def _passed_ms(self):
        return 0 if self._ended_ms is None else (ticks_ms() - self._ended_ms) & (_PERIOD - 1)

    def ticks_us(self):
        return (self._now_us + 1000 * self._passed_ms()) & (_PERIOD - 1)

    def ticks_ms(self):
        return (self._now_ms + self._passed_ms()) & (_PERIOD - 1)

    def ticks_add(self, ticks, delta):
        return (ticks + delta) & (_PERIOD - 1)

    def ticks_diff(self, new, old):
        return ((new - old + _PERIOD // 2) & (_PERIOD - 1)) - _PERIOD // 2


class Line:
    """machine.UART as serial_line.SerialLine calls it: what the stream brought is read, what is written goes
    to another UART."""

    def __init__(self, uart):
        self._uart = uart
        self._received = b""

    def bring(self, data):
        """The line brought these bytes; what the receive buffer has no room for is lost."""
        self._received = (self._received + data)[:_RECEIVED_MOST]

    def any(self):
        return len(self._received)

    def readinto(self, buffer, count):
        count = min(count, len(self._received))
        buffer[:count] = self._received[:count]
        self._received = self._received[count:]
        return count

    def write(self, buffer, offset, count):
        return self._uart.write(buffer, offset, count)


class Pipe:
    """A camera driver; `path` of a named pipe or another stream. grab() waits for the next frame, but for a
    Line, when there is one, it returns without a frame each time that bytes arrived before it. `controls`:
    path of the pipe that is told exposure and gain; without one they change nothing."""

    def __init__(self, path, latency_us=15000, line=None, controls=None):
        self._path, self._controls_path = path, controls
        self.adjustable = controls is not None
        self._line = line
        self.clock = FrameClock(latency_us)
        self._exposure_us, self._gain_cdb = 1000, 0

    def start(self):
        self._file = open(self._path, "rb", buffering=0)
        self._controls = open(self._controls_path, "wb", buffering=0) if self.adjustable else None
        self._header = bytearray(struct.calcsize(HEADER))
        self._arriving = []  # (time_us, bytes) of the line, before the next frame has been processed
        self.skipped = 0
        self.ended = False
        self.frame = None
        self.frame_number = -1
        if not self._read_header():
            raise CameraError("%s ended before the first frame" % self._path)
        self.width, self.height = self._next[1], self._next[2]
        self._pixels = bytearray(self.width * self.height)
        self._pending = True
        self._begun = False

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
        """The header of the next frame; what the line brings before it is kept."""
        while self._fill(self._header):
            self._next = struct.unpack(HEADER, self._header)
            if self._next[0] == MAGIC:
                return True
            if self._next[0] != LINE_MAGIC:
                raise CameraError("no header in %s" % self._path)
            data = bytearray(self._next[1])
            if not self._fill(data):
                return False
            self._arriving.append((self._next[4], bytes(data)))
        return False

    def _serve(self, until_us):
        """Lets time go on to what the line brings next; False when that is after until_us."""
        clock = self.clock
        if not self._arriving or clock.ticks_diff(self._arriving[0][0], until_us) > 0:
            return False
        at_us = self._arriving[0][0]
        now_us = clock.ticks_us()
        if not self._begun or clock.ticks_diff(at_us, now_us) > _TURN_US:
            self._begun = True
            clock.stand_at(at_us - _TURN_US)  # it looked and there was nothing yet
            return True
        if clock.ticks_diff(at_us, now_us) > 0:
            clock.stand_at(at_us)
        self._bring()
        return True

    def _bring(self):
        data = self._arriving.pop(0)[1]
        if self._line is not None:
            self._line.bring(data)

    def grab(self):
        if self.ended:
            return False
        if not self._pending:
            if self._controls:
                self._controls.write(struct.pack(CONTROLS, self._exposure_us, self._gain_cdb))
            if not self._read_header():
                return self._end()
        self._pending = True
        if self._serve(self._next[4]):
            return False
        self._pending = False
        if (self._next[1], self._next[2]) != (self.width, self.height):
            raise CameraError("a frame of %dx%d, not as the first" % (self._next[1], self._next[2]))
        if not self._fill(self._pixels):
            return self._end()
        self.frame = self._pixels
        self.skipped += max(0, self._next[3] - self.frame_number - 1)
        self.frame_number = self._next[3]
        self.capture_us = self._next[4]
        self.clock.frame_at(self.capture_us)
        self._begun = True
        while self._arriving:  # nobody read the line meanwhile
            self._bring()
        return True

    def _end(self):
        self.ended = True
        self.clock.end()
        return False

    def exposure(self, us=None):
        if us is not None:
            self._exposure_us = us
        return self._exposure_us

    def gain(self, cdb=None):
        if cdb is not None:
            self._gain_cdb = cdb
        return self._gain_cdb

    def stop(self):
        self._end()
