"""The frame around a message: CRC-32 behind it, COBS, and a 0 that ends it.

A message (header, payload and CRC: at most LIMIT bytes) never fills one of COBS's blocks of 254, so one
byte in front and the final 0 are all that COBS adds.
"""

from array import array
from binascii import crc32

try:
    from micropython import const

    from larics.kernels import crc as _kernel
except ImportError:
    from larics._cpython import const

    _kernel = None  # CPython has no ints to save, and binascii is faster than any kernel

LIMIT = const(128)
OVERHEAD = const(6)  # COBS byte, CRC, final 0


def _crc_table():
    table = array("H", bytes(64))
    for nibble in range(16):
        low, high = nibble, 0
        for _ in range(4):
            odd = low & 1
            low = low >> 1 | (high & 1) << 15
            high >>= 1
            if odd:  # the reversed polynomial 0xEDB88320
                low ^= 0x8320
                high ^= 0xEDB8
        table[2 * nibble] = low
        table[2 * nibble + 1] = high
    return table


CRC_TABLE = _crc_table()
_crc = array("H", (0, 0))


def crc_halves(buffer, first, end):
    """CRC-32 of buffer[first:end] as two items, low and high 16 bits; the array is reused."""
    if _kernel:
        _kernel.crc32(buffer, CRC_TABLE, first, end, _crc)
    else:
        value = crc32(memoryview(buffer)[first:end])
        _crc[0] = value & 0xFFFF
        _crc[1] = value >> 16
    return _crc


def seal(frame, end):
    """Turns the message in frame[1:end], a bytearray, into a frame in frame[:n]; returns n."""
    crc = crc_halves(frame, 1, end)
    for half in crc:
        frame[end] = half & 0xFF
        frame[end + 1] = half >> 8
        end += 2
    if _kernel:
        _kernel.cobs(frame, end)
    else:
        code = 0
        place = frame.find(0, 1, end)
        while place >= 0:
            frame[code] = place - code
            code = place
            place = frame.find(0, place + 1, end)
        frame[code] = end - code
        frame[end] = 0
    return end + 1
