"""From the stream of bytes to the values of a message (wire.codec): COBS undone across pieces, the CRC
compared, the fields of a payload taken out."""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_PLACE = const(0)  # items of `state`: the next byte of the piece,
_SIZE = const(1)  # 1 + bytes of the message so far; 0 before its first COBS byte
_LEFT = const(2)  # 1 + bytes until the next COBS byte; 0 while an over-long frame is skipped
_WHOLE = const(3)
_LIMIT = const(128)  # as wire.framing.LIMIT: `message` has one byte more
_LEAST = const(8)  # header and CRC
_VERSION = const(1)  # as wire.messages.VERSION
_WELL = const(1)
_EMPTY = const(2)
_OVER_LONG = const(3)
_COBS = const(4)
_SHORT = const(5)
_CRC = const(6)
_OTHER_VERSION = const(7)


@micropython.viper
def unstuff(size: int, left: int, data: ptr8, message: ptr8, state: ptr32, count: int, table: ptr16) -> int:
    """Takes bytes from data[state[0]] on up to the end of a frame, or up to data[count - 1].

    0: no frame ended. Else what the frame is that did, one of the numbers above, its size in state[3]; a new
    one begins then. `table` as in kernels.crc. size, left: any."""
    size = int(state[_SIZE]) - 1
    left = int(state[_LEFT]) - 1
    ended = 0
    i = int(state[_PLACE])
    while i < count:
        byte = int(data[i])
        i += 1
        if byte == 0:
            count = i
            ended = 1
        elif left > 0:
            message[size] = byte
            size += 1
            left -= 1
        elif left == 0:
            if size < 0:
                size = 0
            else:
                message[size] = 0
                size += 1
            left = byte - 1
            if size + left > _LIMIT:
                left = 0 - 1
    state[_PLACE] = i
    if ended == 0:
        state[_SIZE] = size + 1
        state[_LEFT] = left + 1
        return 0
    state[_SIZE] = 0
    state[_LEFT] = 1
    if size < 0:
        return _EMPTY
    if left < 0:
        return _OVER_LONG
    if left:
        return _COBS
    if size < _LEAST:
        return _SHORT
    state[_WHOLE] = size
    count = size - 4
    size = 0xFFFF  # low and high half of the CRC
    left = 0xFFFF
    i = 0
    while i < count:
        size = size ^ int(message[i])
        n = (size & 15) << 1
        size = ((size >> 4) | ((left & 15) << 12)) ^ int(table[n])
        left = (left >> 4) ^ int(table[n + 1])
        n = (size & 15) << 1
        size = ((size >> 4) | ((left & 15) << 12)) ^ int(table[n])
        left = (left >> 4) ^ int(table[n + 1])
        i += 1
    size = size ^ 0xFFFF ^ (int(message[i]) | int(message[i + 1]) << 8)
    left = left ^ 0xFFFF ^ (int(message[i + 2]) | int(message[i + 3]) << 8)
    if size | left:
        return _CRC
    if int(message[0]) != _VERSION:
        return _OTHER_VERSION
    return _WELL


@micropython.viper
def unpack(message: ptr8, i: int, fields: ptr32, values: ptr32, count: int, place: int) -> int:
    """Puts `count` fields from message[place] on into values; 0 when one is outside its range, else 1.

    fields: size in bytes, 1 if signed else 0, lowest value without its sign and highest of each field."""
    i = 0
    while i < count:
        k = i << 2
        size = int(fields[k])
        place += size
        low = int(fields[k + 2])
        value = int(message[place - 1])
        if int(fields[k + 1]):
            low = 0 - low
            value = (value ^ 0x80) - 0x80
        if size == 4:
            if value > 63:
                return 0
            if value < 0 - 64:
                return 0
            value = (value << 8) + int(message[place - 2])
            value = (value << 8) + int(message[place - 3])
        if size > 1:
            value = (value << 8) + int(message[place - size])
        if value < low:
            return 0
        if value > int(fields[k + 3]):
            return 0
        values[i] = value
        i += 1
    return 1
