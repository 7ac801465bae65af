"""Calls of the kernels in larics.kernels.stream."""

from array import array

from inputs import random_bytes

from larics.wire import codec
from larics.wire.framing import CRC_TABLE, seal


def _frame(number, values):
    encoder = codec.Encoder()
    return bytearray(encoder.buffer[: encoder.encode(number, values)])


def unstuff(random):
    frame = _frame(codec.ODOMETRY, [1, 0, -5, 256, 35999, 7, 1])
    size = len(frame)
    spoilt = bytearray(frame)
    spoilt[9] ^= 1
    short = bytearray(16)  # with a good CRC, but no whole header
    short = short[: seal(short, 4)]
    for data, size_before, left_before in (
        (frame, 0, 1), (spoilt, 0, 1), (frame[: size - 1], 0, 1), (bytearray(3), 0, 1), (frame, 5, 3),
        (bytearray([3, 1, 0]), 0, 1), (bytearray([255] * 140 + [0]), 0, 1), (bytearray([2, 1, 0]), 0, 1),
        (short, 0, 1),
    ):  # fmt: skip
        message = bytearray(129)
        state = array("i", [0, size_before, left_before, 0])
        yield 0, 0, data, message, state, len(data), CRC_TABLE
    yield 0, 0, random_bytes(200, random), bytearray(129), array("i", [0, 0, 1, 0]), 200, CRC_TABLE


def unpack(random):
    for number in (codec.ODOMETRY, codec.SET_SETTING, codec.PING):
        ranges = codec.ranges_of(codec.LAYOUTS[number])
        fields = len(ranges) // 4
        for fill in (0, 63, 64, 191, 192, 255, 256):
            message = random_bytes(64, random) if fill == 256 else bytearray([fill] * 64)
            yield message, 0, ranges, array("i", [0] * fields), fields, 4


CASES = {"unstuff": unstuff, "unpack": unpack}
