"""What the tests of the firmware share: a UART in memory, a clock to turn, a picture of a marker."""

import time

from app import App
from cameras.replay import Replay
from larics.arith.fixed import atan2_turn16, isqrt
from larics.locate.vehicle_clock import later_us
from larics.settings import Settings
from larics.wire import codec as protocol
from larics.wire.messages import COUNT_MAX


class Uart:
    """Keeps nothing by default, so that it needs no memory; `sent` collects when it is a bytearray.

    room: bytes taken by a call, 0: None as machine.UART; broken: OSError."""

    def __init__(self, collect=False):
        self.sent = bytearray() if collect else None
        self.room = 1000
        self.broken = False
        self.incoming = b""
        self.count = 0

    def write(self, buffer, offset, count):
        if self.broken:
            raise OSError(5)
        if not self.room:
            return None
        count = min(count, self.room)
        if self.sent is not None:
            self.sent.extend(bytes(buffer[offset : offset + count]))
        self.count += count
        return count

    def any(self):
        return len(self.incoming)

    def readinto(self, buffer, count):
        buffer[:count] = self.incoming[:count]
        self.incoming = self.incoming[count:]
        return count

    def messages(self):
        """All that was sent so far, as (type, values)."""
        found = []
        decoder = protocol.Decoder(lambda number, sequence, values: found.append((number, list(values))))
        decoder.feed(self.sent, len(self.sent))
        assert decoder.counters.crc == decoder.counters.cobs == decoder.counters.length == 0
        return found

    def of(self, number):
        return [values for kind, values in self.messages() if kind == number]


class Clock:
    """Goes on by `step_us` with each reading, and by hand; wraps as a board's does."""

    def __init__(self, step_us=0):
        self.now_us = -2000000  # short of the wrap; a sum beyond 30 bits would take memory
        self.step_us = step_us

    def ticks_us(self):
        self.now_us += self.step_us
        return self.now_us & COUNT_MAX

    def ticks_ms(self):
        return self.now_us // 1000 + 1073741 & COUNT_MAX

    def ticks_add(self, ticks, delta):
        return later_us(ticks, delta)

    def ticks_diff(self, end, start):
        passed = (end - start) & COUNT_MAX
        return passed - COUNT_MAX - 1 if passed > COUNT_MAX >> 1 else passed

    def sleep_ms(self, ms):
        self.now_us += 1000 * ms


def plain(grey, width=160, height=120):
    return bytes([grey]) * (width * height)


def marker(marker_id, x, y, radius, width=160, height=120):
    """A picture of a LARICS-3 marker whose orientation line points up."""
    picture = bytearray(plain(120, width, height))
    line = radius * 20 // 150 // 2 + 1
    for row in range(height):
        for column in range(width):
            dx, dy = column - x, y - row
            r = isqrt(dx * dx + dy * dy)
            if r > radius * 250 // 150:
                continue
            ink = abs(r - radius) < line or abs(r - radius * 100 // 150) < line
            turn = (atan2_turn16(dy, dx) - 16384) % 65536  # counterclockwise from the orientation line
            quarter = (turn + 8192) // 16384 % 4
            across = abs(dx) if quarter in (0, 2) else abs(dy)
            if across < line:
                if quarter == 0:
                    ink = ink or radius <= r <= radius * 230 // 150
                elif marker_id >> (3 - quarter) & 1:
                    ink = ink or radius * 25 // 150 <= r <= radius * 80 // 150
            picture[row * width + column] = 30 if ink else 220
    return smoothed(picture, width, height)


def smoothed(picture, width, height):
    """The mean of 3x3 pixels, since no lens draws steps."""
    result = bytearray(picture)
    for row in range(1, height - 1):
        for place in range(row * width + 1, (row + 1) * width - 1):
            total = 0
            for line in (place - width, place, place + width):
                total += picture[line - 1] + picture[line] + picture[line + 1]
            result[place] = total // 9
    return bytes(result)


def make_app(frames, uart=None, settings=None, width=160, height=120, clock=time, camera=None, **options):
    """An App that replays these pictures without end, or takes those of `camera`."""
    values = {"method": "paper", "radius_min_px": 15, "radius_max_px": 25, "baud": 921600}
    values.update(settings or {})
    if camera is None:
        camera = Replay(frames, rounds=0, width=width, height=height, clock=clock)
    return App(Settings(values), camera, uart or Uart(), "test", clock=clock, **options)
