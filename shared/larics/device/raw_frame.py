"""A raw frame on its way to the host, in numbered chunks that can be asked for again."""

from binascii import crc32

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.wire.messages import RAW_CHUNK, RAW_CHUNK_BYTES, RAW_HEADER

# generated: begin indices (tools/make_protocol.py)
_RAW_HEADER_FIELDS = const(7)
_RAW_HEADER_TOKEN = const(0)
_RAW_HEADER_FRAME = const(1)
_RAW_HEADER_WIDTH = const(2)
_RAW_HEADER_HEIGHT = const(3)
_RAW_HEADER_CHUNKS = const(4)
_RAW_HEADER_CRC_LOW = const(5)
_RAW_HEADER_CRC_HIGH = const(6)
_RAW_CHUNK_FIELDS = const(3)
_RAW_CHUNK_TOKEN = const(0)
_RAW_CHUNK_CHUNK = const(1)
_RAW_CHUNK_DATA = const(2)
# generated: end indices

_RANGES = const(8)  # requests for chunks that may wait at a time


class RawSender:
    """Source of messages for an Outbox: `next()` gives a type number, its fields are in `values`.

    It keeps the frame's buffer until the next `start`; nobody may change that buffer meanwhile.
    """

    def __init__(self):
        self.token = -1
        self.values = None
        self.chunks = 0
        self._pixels = b""
        self._size = 0
        self._chunk = [0] * _RAW_CHUNK_FIELDS
        self._chunk[_RAW_CHUNK_DATA] = bytearray(RAW_CHUNK_BYTES)
        self._header = [0] * _RAW_HEADER_FIELDS
        self._header_due = False
        self._first = [0] * _RANGES
        self._left = [0] * _RANGES  # chunks to send from _first on

    def start(self, token, pixels, width, height, frame):
        """Sends this frame (`width * height` bytes), dropping what was left of another."""
        view = memoryview(pixels)[: width * height]
        crc = crc32(view)
        self.token = token
        self._pixels = pixels
        self._size = width * height
        self.chunks = (self._size + RAW_CHUNK_BYTES - 1) // RAW_CHUNK_BYTES
        header = self._header
        header[_RAW_HEADER_TOKEN] = token
        header[_RAW_HEADER_FRAME] = frame
        header[_RAW_HEADER_WIDTH] = width
        header[_RAW_HEADER_HEIGHT] = height
        header[_RAW_HEADER_CHUNKS] = self.chunks
        header[_RAW_HEADER_CRC_LOW] = crc & 0xFFFF
        header[_RAW_HEADER_CRC_HIGH] = crc >> 16 & 0xFFFF
        for k in range(_RANGES):
            self._left[k] = 0
        self._first[0] = 0
        self._left[0] = self.chunks
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
        """Queues chunks once more, before the rest; False when too many requests wait already."""
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
                self._fill(self._first[k])
                self._first[k] += 1
                self._left[k] -= 1
                self.values = self._chunk
                return RAW_CHUNK
        return 0

    def _fill(self, chunk):
        pixels = self._pixels
        data = self._chunk[_RAW_CHUNK_DATA]
        start = chunk * RAW_CHUNK_BYTES
        count = min(RAW_CHUNK_BYTES, self._size - start)
        for k in range(count):
            data[k] = pixels[start + k]
        for k in range(count, RAW_CHUNK_BYTES):
            data[k] = 0
        self._chunk[_RAW_CHUNK_TOKEN] = self.token
        self._chunk[_RAW_CHUNK_CHUNK] = chunk
