"""A raw frame on its way to the host, in packed chunks whose pixels can be asked for again.

Its pixels, or those of a window of it, are numbered strip by strip, RAW_STRIP columns wide each, from top to
bottom and row by row, so that the pixels of a chunk are neighbours. A chunk ends where its strip ends.
"""

from binascii import crc32

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.wire.messages import (
    RAW_CHUNK,
    RAW_CHUNK_BYTES,
    RAW_HEADER,
    RAW_PIXELS_MOST,
    RAW_PLAIN,
    RAW_STRIP,
)

# generated: begin indices (tools/make_protocol.py)
_RAW_HEADER_FIELDS = const(10)
_RAW_HEADER_TOKEN = const(0)
_RAW_HEADER_FRAME = const(1)
_RAW_HEADER_WIDTH = const(2)
_RAW_HEADER_HEIGHT = const(3)
_RAW_HEADER_LEFT = const(4)
_RAW_HEADER_TOP = const(5)
_RAW_HEADER_COLUMNS = const(6)
_RAW_HEADER_ROWS = const(7)
_RAW_HEADER_CRC_LOW = const(8)
_RAW_HEADER_CRC_HIGH = const(9)
_RAW_CHUNK_FIELDS = const(5)
_RAW_CHUNK_TOKEN = const(0)
_RAW_CHUNK_FIRST = const(1)
_RAW_CHUNK_COUNT = const(2)
_RAW_CHUNK_CODING = const(3)
_RAW_CHUNK_DATA = const(4)
# generated: end indices

_RANGES = const(8)  # requests for pixels that may wait at a time


class RawSender:
    """Source of messages for an Outbox: `next()` gives a type number, its fields are in `values`.

    `size` is the number of pixels. It keeps the frame's buffer until the next `start`; nobody may change that
    buffer meanwhile.
    """

    def __init__(self):
        self._kernels = None
        self.token = -1
        self.values = None
        self.size = 0
        self._pixels = b""
        self._errors = bytearray(RAW_PIXELS_MOST)
        self._chunk = [0] * _RAW_CHUNK_FIELDS
        self._chunk[_RAW_CHUNK_DATA] = bytearray(RAW_CHUNK_BYTES)
        self._header = [0] * _RAW_HEADER_FIELDS
        self._header_due = False
        self._first = [0] * _RANGES
        self._left = [0] * _RANGES  # pixels to send from _first on

    def start(self, token, pixels, width, height, frame, window=None):
        """Sends this frame (`width * height` bytes), or its window (left, top, columns, rows), dropping what
        was left of another."""
        left, top, columns, rows = window or (0, 0, width, height)
        view = memoryview(pixels)
        place = top * width + left
        crc = 0
        for _ in range(rows):
            crc = crc32(view[place : place + columns], crc)
            place += width
        from larics.kernels import raw  # most boards are never asked

        self._kernels = raw
        self.token = token
        self._pixels = pixels
        self.size = columns * rows
        header = self._header
        header[_RAW_HEADER_TOKEN] = token
        header[_RAW_HEADER_FRAME] = frame
        header[_RAW_HEADER_WIDTH] = width
        header[_RAW_HEADER_HEIGHT] = height
        header[_RAW_HEADER_LEFT] = left
        header[_RAW_HEADER_TOP] = top
        header[_RAW_HEADER_COLUMNS] = columns
        header[_RAW_HEADER_ROWS] = rows
        header[_RAW_HEADER_CRC_LOW] = crc & 0xFFFF
        header[_RAW_HEADER_CRC_HIGH] = crc >> 16 & 0xFFFF
        for k in range(_RANGES):
            self._left[k] = 0
        self._first[0] = 0
        self._left[0] = self.size
        self._header_due = True

    def forget(self):
        """Lets go of the frame: its buffer may take another one."""
        self.token = -1
        self._pixels = b""
        self._header_due = False
        for k in range(_RANGES):
            self._left[k] = 0

    def repeat_header(self):
        self._header_due = True

    def again(self, first, count):
        """Queues pixels once more, before the rest; False when too many requests wait already."""
        for k in range(1, _RANGES):
            if not self._left[k]:
                self._first[k] = first
                self._left[k] = count
                return True
        return False

    def busy(self):
        return self._header_due or any(self._left)

    def next(self):
        """The type of the next message, 0 when there is none."""
        if self._header_due:
            self._header_due = False
            self.values = self._header
            return RAW_HEADER
        for k in range(_RANGES - 1, -1, -1):
            if self._left[k]:
                count = self._fill(self._first[k], self._left[k])
                self._first[k] += count
                self._left[k] -= count
                self.values = self._chunk
                return RAW_CHUNK
        return 0

    def _fill(self, first, most):
        """Makes the chunk that begins with pixel `first`, of at most so many; returns how many it holds."""
        header, errors, pixels = self._header, self._errors, self._pixels  # four would make a tuple
        stride, columns = header[_RAW_HEADER_WIDTH], header[_RAW_HEADER_COLUMNS]
        rows = header[_RAW_HEADER_ROWS]
        strip = first // (RAW_STRIP * rows)
        number = first - strip * RAW_STRIP * rows  # within the strip
        width = min(RAW_STRIP, columns - strip * RAW_STRIP)
        column = number % width
        place = (header[_RAW_HEADER_TOP] + number // width) * stride
        place += header[_RAW_HEADER_LEFT] + strip * RAW_STRIP + column
        most = min(most, width * rows - number, RAW_PIXELS_MOST)
        bits = 8 * RAW_CHUNK_BYTES
        found = self._kernels.predict(pixels, errors, place, 1, most, column, width, stride, bits, 0)
        guess = found >> 16
        coding, count = RAW_PLAIN, min(most, RAW_CHUNK_BYTES)
        for k in range(max(0, guess - 1), min(7, guess + 1) + 1):
            fits = self._kernels.fitting(errors, 1, found & 0xFFFF, k, bits)
            if fits > count:
                coding, count = k, fits
        chunk = self._chunk
        data = chunk[_RAW_CHUNK_DATA]
        if coding == RAW_PLAIN:
            self._kernels.gather(pixels, data, place, 0, count, column, width, stride, RAW_CHUNK_BYTES)
        else:
            self._kernels.pack(errors, data, 1, count, coding, RAW_CHUNK_BYTES, 1)
        chunk[_RAW_CHUNK_TOKEN] = self.token
        chunk[_RAW_CHUNK_FIRST] = first
        chunk[_RAW_CHUNK_COUNT] = count
        chunk[_RAW_CHUNK_CODING] = coding
        return count
