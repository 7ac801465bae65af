"""The noise of measurements from the measurements themselves, in integers only."""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import isqrt

_MEMORY = const(16)  # frames over which residuals are averaged


class Residuals:
    """The noise of one coordinate, from how far its values stray from going on as before: what cannot be
    told from noise, such as hard acceleration, makes it larger, not smaller."""

    def __init__(self, start):
        self.start = start
        self.reset()

    def reset(self):
        self.square = self.start * self.start
        self.weight = 1

    def add(self, before, last, now, before_h, last_h):
        """Three values as differences to any near origin; the times between them, 100 us."""
        q8 = (last_h << 8) // before_h
        if q8 > 1024:  # the line through the first two says nothing that far on
            return
        residual = now - last - ((last - before) * q8 >> 8)
        residual = max(-4000, min(4000, residual))
        spread_q8 = 512 + 2 * q8 + (q8 * q8 >> 7)  # 1 + (1 + q)**2 + q**2
        square = (residual * residual << 6) // (spread_q8 >> 2)
        if self.weight < _MEMORY:
            self.weight += 1
        else:
            self.square -= self.square // _MEMORY
        self.square += square

    def sigma(self, floor):
        """Standard deviation of one value, at least `floor`."""
        return max(floor, isqrt(self.square // self.weight))
