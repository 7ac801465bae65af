"""The vehicle's clock in terms of the camera's, from messages that tell when they were sent.

A message arrives late by its time on the line, which is known, and by a waiting time that is not: the line is
read between frames. Nothing arrives early, so the least delay seen is the one without waiting. Of that the
estimate goes away again slowly, so that it follows clocks that drift apart; a drift that is faster than that
is learned. All times are in microseconds modulo 2**30. Nothing is allocated.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.wire.messages import COUNT_MAX

_LEAK_PPM = const(400)  # above what crystals drift
_FASTEST_PPM = const(20000)
_LEAP_US = const(1000000)  # no clock drifts, and no message waits, for so long
_FIRST_SPAN_MS = const(2000)  # of messages whose earliest one shows the drift; doubled ...
_LONGEST_SPAN_MS = const(8000)  # ... up to this
_DOUBT_US = const(6000)  # what else than waiting may feign a drift
_LATE_US = const(3000)  # more than the earliest of a longest span waits
_LEAST = const(8)  # messages in a span


def signed_us(difference):
    """A difference of times modulo 2**30 as -2**29 .. 2**29 - 1."""
    difference &= COUNT_MAX
    return difference - COUNT_MAX - 1 if difference > COUNT_MAX >> 1 else difference


def later_us(time_us, passed_us):
    """A time modulo 2**30 and so much more, up to 2**30 either way, within 30 bits."""
    if passed_us > 0:
        time_us = time_us - COUNT_MAX - 1
    return (time_us + passed_us) & COUNT_MAX


class VehicleClock:
    """`hear` every message, then `camera_us`. `drift_ppm`: how much faster the camera's clock runs."""

    def __init__(self):
        self.forget()

    def forget(self):
        """Nothing is known of the vehicle's clock."""
        self.known = False
        self.drift_ppm = 0
        self._offset_us = 0
        self._rest_ns = 0
        self._heard_us = 0
        self._last_us = self._last_offset_us = -1  # the earliest message of the span before
        self._last_waited_us = 0
        self._span_ms = _FIRST_SPAN_MS
        self._begin_span(0, 0)

    def _begin_span(self, now_us, offset_us):
        self._began_us, self._began_offset_us = now_us, offset_us
        self._messages = 0
        self._earliest_us = self._earliest_offset_us = self._waited_us = 0
        self._least_us = _LEAP_US  # by which a message was late, against the span's beginning and the drift
        self._late_us = _LEAP_US  # ... against the estimate

    def hear(self, arrived_us, sent_us, waited_us):
        """Takes a message: when it was read on the camera's clock, less its time on the line; when it was
        sent on the vehicle's; and for how long it may have waited to be read.

        False when the two clocks leapt apart: they say nothing of each other any more."""
        offset_us = (arrived_us - sent_us) & COUNT_MAX
        if not self.known:
            self.known = True
            self._offset_us = offset_us
            self._heard_us = arrived_us
            self._begin_span(arrived_us, offset_us)
        passed_ms = max(0, signed_us(arrived_us - self._heard_us)) // 1000
        self._heard_us = later_us(self._heard_us, passed_ms * 1000)
        self._advance(passed_ms)
        late_us = signed_us(offset_us - self._offset_us)
        if abs(late_us) > _LEAP_US:
            return False
        if late_us < 0:
            self._offset_us = offset_us
            late_us = 0
        self._late_us = min(self._late_us, late_us)
        self._messages += 1
        span_ms = max(0, signed_us(arrived_us - self._began_us)) // 1000
        if span_ms > 4 * _LONGEST_SPAN_MS:  # a long silence says nothing of the drift
            self._last_us = -1
            self._begin_span(arrived_us, offset_us)
            return True
        against_us = signed_us(offset_us - self._began_offset_us) - span_ms * self.drift_ppm // 1000
        if against_us < self._least_us:
            self._least_us = against_us
            self._earliest_us, self._earliest_offset_us = arrived_us, offset_us
            self._waited_us = waited_us
        if span_ms >= self._span_ms and self._messages >= _LEAST:
            self._learn(arrived_us)
            self._begin_span(arrived_us, offset_us)
        return True

    def _advance(self, passed_ms):
        """The offset grows with the drift, and by the leak, which makes room for a later least delay."""
        grown_ns = min(passed_ms, _LONGEST_SPAN_MS) * (self.drift_ppm + _LEAK_PPM) + self._rest_ns
        self._rest_ns = grown_ns % 1000
        self._offset_us = later_us(self._offset_us, grown_ns // 1000)

    def _learn(self, now_us):
        """The drift is the slope between the earliest messages of two spans, where it is beyond doubt."""
        last_us, last_offset_us = self._last_us, self._last_offset_us
        doubt_us = _DOUBT_US + max(self._waited_us, self._last_waited_us)
        self._last_us, self._last_offset_us = self._earliest_us, self._earliest_offset_us
        self._last_waited_us = self._waited_us
        between_ms = signed_us(self._earliest_us - last_us) // 1000
        if last_us >= 0 and 0 < between_ms <= 5 * _LONGEST_SPAN_MS:
            grown_us = signed_us(self._earliest_offset_us - last_offset_us)
            if abs(grown_us - between_ms * self.drift_ppm // 1000) > doubt_us:
                drift_ppm = max(-_LEAP_US, min(_LEAP_US, grown_us)) * 1000 // between_ms
                self.drift_ppm = max(-_FASTEST_PPM, min(_FASTEST_PPM, drift_ppm))
                since_ms = signed_us(now_us - self._earliest_us) // 1000
                self._offset_us = later_us(self._earliest_offset_us, since_ms * self.drift_ppm // 1000)
                self._span_ms = _FIRST_SPAN_MS
                return
        if self._span_ms < _LONGEST_SPAN_MS:
            self._span_ms *= 2
        elif self._late_us > _LATE_US + self._waited_us:  # not one message was as early as expected
            self._offset_us = later_us(self._offset_us, self._late_us)

    def camera_us(self, vehicle_us):
        """A time of the vehicle's clock on the camera's."""
        return later_us(vehicle_us, self._offset_us)
