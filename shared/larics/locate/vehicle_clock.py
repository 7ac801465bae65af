"""The vehicle's clock in terms of the camera's, from messages that tell when they were sent.

A message arrives late by its time on the line, which is known, and by a waiting time that is not: the line is
read between frames. Nothing arrives early, so the least delay seen is the one without waiting. Of that the
estimate goes away again slowly, so that it follows clocks that drift apart; a drift that is faster than that
is learned. All times are in microseconds modulo 2**30. Nothing is allocated.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.kernels.odometry import hear
from larics.wire.messages import COUNT_MAX

_CLOCK_KNOWN = const(0)  # as in kernels.layouts
_CLOCK_OFFSET_US = const(1)
_CLOCK_DRIFT_PPM = const(4)
_CLOCK_HAS_LAST = const(5)
_CLOCK_LAST_US = const(6)
_CLOCK_LAST_OFFSET_US = const(7)
_CLOCK_LAST_WAITED_US = const(8)
_CLOCK_SPAN_MS = const(9)
_CLOCK_BEGAN_US = const(10)
_CLOCK_BEGAN_OFFSET_US = const(11)
_CLOCK_MESSAGES = const(12)
_CLOCK_EARLIEST_US = const(13)
_CLOCK_EARLIEST_OFFSET_US = const(14)
_CLOCK_WAITED_US = const(15)
_CLOCK_LEAST_US = const(16)
_CLOCK_LATE_US = const(17)
_CLOCK_ARRIVED_US = const(18)
_CLOCK_SENT_US = const(19)
_CLOCK_READ_US = const(20)
_CLOCK_ITEMS = const(21)
SPAN_OVER = const(2)  # what hear() gives
_FASTEST_PPM = const(20000)
_LEAP_US = const(1000000)  # no clock drifts, and no message waits, for so long
_FIRST_SPAN_MS = const(2000)  # of messages whose earliest one shows the drift; doubled ...
_LONGEST_SPAN_MS = const(8000)  # ... up to this
_DOUBT_US = const(6000)  # what else than waiting may feign a drift
_MOST_LATE_US = const(3000)  # more than the earliest of a longest span waits


def _signed_us(difference):
    """A difference of times modulo 2**30 as -2**29 .. 2**29 - 1."""
    difference &= COUNT_MAX
    return difference - COUNT_MAX - 1 if difference > COUNT_MAX >> 1 else difference


def later_us(time_us, passed_us):
    """A time modulo 2**30 and so much more, up to 2**30 either way, within 30 bits."""
    if passed_us > 0:
        time_us = time_us - COUNT_MAX - 1
    return (time_us + passed_us) & COUNT_MAX


class VehicleClock:
    """`hear` every message, then `camera_us`.

    items   as in kernels.layouts"""

    def __init__(self):
        self.items = array("i", [0] * _CLOCK_ITEMS)

    def drift_ppm(self):
        """How much faster the camera's clock runs."""
        return self.items[_CLOCK_DRIFT_PPM]

    def forget(self):
        """Nothing is known of the vehicle's clock."""
        self.items[_CLOCK_KNOWN] = self.items[_CLOCK_DRIFT_PPM] = 0

    def hear(self, arrived_us, sent_us, waited_us):
        """Takes a message: when it was read on the camera's clock, less its time on the line; when it was
        sent on the vehicle's; and for how long it may have waited to be read.

        False when the two clocks leapt apart: what was known of them before is forgotten."""
        items = self.items
        items[_CLOCK_ARRIVED_US], items[_CLOCK_SENT_US] = arrived_us, sent_us
        items[_CLOCK_READ_US] = waited_us
        found = hear(0, 0, self.items)
        if found == SPAN_OVER:
            self.learn()
        return found != 0

    def learn(self):
        """A span of messages is over: the drift is the slope between its earliest one and that of the span
        before, where it is beyond doubt."""
        items = self.items
        arrived_us = items[_CLOCK_ARRIVED_US]
        offset_us = (arrived_us - items[_CLOCK_SENT_US]) & COUNT_MAX
        if _signed_us(arrived_us - items[_CLOCK_BEGAN_US]) // 1000 <= 4 * _LONGEST_SPAN_MS:
            self._learn_drift(arrived_us)
        else:
            items[_CLOCK_HAS_LAST] = 0  # a long silence says nothing of the drift
        items[_CLOCK_BEGAN_US], items[_CLOCK_BEGAN_OFFSET_US] = arrived_us, offset_us
        items[_CLOCK_MESSAGES] = items[_CLOCK_WAITED_US] = 0
        items[_CLOCK_EARLIEST_US] = items[_CLOCK_EARLIEST_OFFSET_US] = 0
        items[_CLOCK_LEAST_US] = items[_CLOCK_LATE_US] = _LEAP_US

    def _learn_drift(self, now_us):
        items = self.items
        earliest_us, earliest_offset_us = items[_CLOCK_EARLIEST_US], items[_CLOCK_EARLIEST_OFFSET_US]
        waited_us, drift_ppm = items[_CLOCK_WAITED_US], items[_CLOCK_DRIFT_PPM]
        doubt_us = _DOUBT_US + max(waited_us, items[_CLOCK_LAST_WAITED_US])
        between_ms = _signed_us(earliest_us - items[_CLOCK_LAST_US]) // 1000
        grown_us = _signed_us(earliest_offset_us - items[_CLOCK_LAST_OFFSET_US])
        comparable = items[_CLOCK_HAS_LAST] and 0 < between_ms <= 5 * _LONGEST_SPAN_MS
        items[_CLOCK_HAS_LAST] = 1
        items[_CLOCK_LAST_US], items[_CLOCK_LAST_OFFSET_US] = earliest_us, earliest_offset_us
        items[_CLOCK_LAST_WAITED_US] = waited_us
        if comparable and abs(grown_us - between_ms * drift_ppm // 1000) > doubt_us:
            drift_ppm = max(-_LEAP_US, min(_LEAP_US, grown_us)) * 1000 // between_ms
            drift_ppm = max(-_FASTEST_PPM, min(_FASTEST_PPM, drift_ppm))
            since_ms = _signed_us(now_us - earliest_us) // 1000
            items[_CLOCK_DRIFT_PPM] = drift_ppm
            items[_CLOCK_OFFSET_US] = later_us(earliest_offset_us, since_ms * drift_ppm // 1000)
            items[_CLOCK_SPAN_MS] = _FIRST_SPAN_MS
        elif items[_CLOCK_SPAN_MS] < _LONGEST_SPAN_MS:
            items[_CLOCK_SPAN_MS] *= 2
        elif items[_CLOCK_LATE_US] > _MOST_LATE_US + waited_us:  # not one message was as early as expected
            items[_CLOCK_OFFSET_US] = later_us(items[_CLOCK_OFFSET_US], items[_CLOCK_LATE_US])

    def camera_us(self, vehicle_us):
        """A time of the vehicle's clock on the camera's."""
        return later_us(vehicle_us, self.items[_CLOCK_OFFSET_US])
