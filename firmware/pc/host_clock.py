"""The ticks_* functions of MicroPython's time on CPython, from the clock that V4L2 stamps its frames with."""

import time

_PERIOD = 1 << 30  # of ticks, as on a board: differences within half of it are right


def ticks_of(monotonic_s):
    """The ticks_us() of a reading of time.monotonic()."""
    return int(monotonic_s * 1000000) & (_PERIOD - 1)


def ticks_us():
    return time.monotonic_ns() // 1000 & (_PERIOD - 1)


def ticks_ms():
    return time.monotonic_ns() // 1000000 & (_PERIOD - 1)


def ticks_add(ticks, delta):
    return (ticks + delta) & (_PERIOD - 1)


def ticks_diff(new, old):
    return ((new - old + _PERIOD // 2) & (_PERIOD - 1)) - _PERIOD // 2
