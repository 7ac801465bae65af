"""Calls of the kernels in larics.kernels.crc."""

from inputs import random_bytes, words, zeros16


def crc32(random):
    for length in (0, 1, 5, 253):
        yield random_bytes(length + 4, random), words(32, random), 2, 2 + length, zeros16(2)
    yield bytearray([255] * 64), words(32, random, 65535), 0, 64, zeros16(2)


def cobs(random):
    for length in (1, 2, 3, 254):
        yield random_bytes(length + 1, random), length
        yield random_bytes(length + 1, random, 2), length
        yield bytearray(length + 1), length


def x25(random):
    for length, extra in ((0, 0), (0, 255), (1, 50), (255, 100)):
        yield random_bytes(length + 4, random), 3, 3 + length, extra
    yield bytearray([255] * 64), 0, 64, 255


CASES = {"crc32": crc32, "cobs": cobs, "x25": x25}
