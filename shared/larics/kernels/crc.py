"""CRC-32 in two 16-bit halves, and COBS in place: a board allocates every int beyond 30 bits.

`table` is array('H') of 32 items: low and high half of the CRC of each 4-bit value.
"""

try:
    import micropython
    from micropython import const  # noqa: F401  (a folder of that name has none)
except ImportError:
    from larics._cpython import micropython, ptr8, ptr16


@micropython.viper
def crc32(data: ptr8, table: ptr16, first: int, end: int, result: ptr16):
    """CRC-32 of data[first..end-1], as binascii.crc32: low half to result[0], high half to result[1]."""
    low = 0xFFFF
    high = 0xFFFF
    while first < end:
        low = low ^ int(data[first])
        n = (low & 15) << 1
        low = ((low >> 4) | ((high & 15) << 12)) ^ int(table[n])
        high = (high >> 4) ^ int(table[n + 1])
        n = (low & 15) << 1
        low = ((low >> 4) | ((high & 15) << 12)) ^ int(table[n])
        high = (high >> 4) ^ int(table[n + 1])
        first += 1
    result[0] = low ^ 0xFFFF
    result[1] = high ^ 0xFFFF


@micropython.viper
def x25(data: ptr8, first: int, end: int, extra: int) -> int:
    """CRC-16 as MAVLink has it: X.25 over data[first..end-1] and then the byte `extra`."""
    crc = 0xFFFF
    while first <= end:
        n = extra
        if first < end:
            n = int(data[first])
        n = (n ^ crc) & 255
        n = (n ^ (n << 4)) & 255
        crc = ((crc >> 8) ^ (n << 8) ^ (n << 3) ^ (n >> 4)) & 0xFFFF
        first += 1
    return crc


@micropython.viper
def cobs(frame: ptr8, end: int):
    """Makes frame[1..end-1], at most 253 bytes, the COBS block frame[0..end-1], and frame[end] = 0."""
    i = 1
    code = 0
    while i < end:
        if int(frame[i]) == 0:
            frame[code] = i - code
            code = i
        i += 1
    frame[code] = end - code
    frame[end] = 0
