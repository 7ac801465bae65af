"""Bytes and fields of the stream."""

import numpy as np

from larics import _cpython

from .compare import same


def unstuff(before, after, result):
    """What CPython does instead, by searching and copying bytes; a CRC of binascii."""
    assert result == _cpython.unstuff(*before)
    for mine, other in zip(before[2:5], after[2:5], strict=True):
        same(mine, other)


def unpack(before, after, result):
    message, _, fields, values, count, place = before
    expected = list(values)
    for k, (size, signed, low, high) in enumerate(np.reshape(fields, (-1, 4)).tolist()):
        value = int.from_bytes(message[place : place + size], "little", signed=bool(signed))
        place += size
        if not (-low if signed else low) <= value <= high:
            assert result == 0
            return
        expected[k] = value
    assert result == 1 and count == len(expected)
    same(after[3], expected)


ORACLES = {
    "stream": (
        unstuff,
        unpack,
    ),
}
