"""How loud the noise of the wheels is, by what they missed from one marker to another or on short ways under
one, in integers.

A variance from few squares may be small by chance: the fewer there are, the more is added to it. Nothing is
allocated.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.locate.uncertainty import log2_q4, times_q4

LOUDEST_Q4 = const(176)  # the noise at most 2**11 times that of the settings ...
_QUIETEST_Q4 = const(-32)  # ... and a quarter of the least that short ways show
_MOVED_Q4 = const(24)  # at most so much louder by a vehicle that was not where it was expected
_QUIETER_Q4 = const(-96)  # at most so much quieter by one square
_ODD_Q4 = const(512)  # 32: a slip counts for no more
_MEMORY = const(10)  # squares over which it is averaged
_CHANCE_Q4 = const(40)  # one square may be small by chance; so much by their number
_UNSEEN_Q4 = const(48)  # what the camera is not exact enough to see is likely to be less still
_WAYS = const(2)  # so many short ways tell
_MOST_TOLD = const(255)
_MOST_OFF = const(4000)
_MOST_SUM = const(1 << 21)


class Loudness:
    """q4: 16 times the binary logarithm of the noise against the model's, for use."""

    def __init__(self):
        self.q4 = 0
        self._found_q4 = 0
        self._known = 0  # squares that it rests on
        self._is_unseen = False  # short ways showed no noise beside that of the camera
        self._quietest_q4 = 0

    def hear(self, square_q4, moved, least_q4):
        """From one marker to another: the square of what was missed by that of the standard deviation, Q4,
        below 2**25. moved: the vehicle was not where it was expected. least_q4: as for `look`."""
        self._quietest_q4 = least_q4 + _QUIETEST_Q4
        if moved:
            self._found_q4 = min(LOUDEST_Q4, self._found_q4 + max(0, min(_MOVED_Q4, log2_q4(square_q4, 16))))
        else:
            if self._is_unseen:  # a longer way shows more than a bound
                self._is_unseen = False
                self._known = 0
            self._take(times_q4(square_q4, self.q4 - self._found_q4))
        self._settle()

    def look(self, square, scatter, expected, least_q4):
        """On a short way: squares of what was missed, of what of that the camera may be wrong by, and of what
        the model expects, each below 2**20. Too short to show that the noise is louder than the model's, or
        quieter than least_q4."""
        found_q4, q4 = self._found_q4, self.q4
        self._quietest_q4 = min(self._quietest_q4, least_q4 + _QUIETEST_Q4)
        least_q4 = max(least_q4, log2_q4(max(1, scatter >> 2), max(1, expected)))
        noise = times_q4(expected, found_q4)
        if noise < scatter and square < scatter << 2:
            self._is_unseen = True
            self._known = min(_MEMORY, self._known + 1)
        else:
            self._take((square << 4) // max(1, scatter + noise))
        self._found_q4 = max(min(found_q4, least_q4), min(max(0, found_q4), self._found_q4))
        if self._known >= _WAYS:
            self._settle()
            self.q4 = min(self.q4, max(0, q4))

    def follow(self, other_q4):
        """The same wheels are so loud in another way: what the camera does not see here is as loud, within
        what stays unseen."""
        if self._is_unseen and self._known >= _WAYS:
            self._settle()
            self.q4 = max(self.q4, min(self.q4 + _UNSEEN_Q4, other_q4))

    def _take(self, square_q4):
        known_q4 = self._known << 4
        step_q4 = log2_q4(known_q4 + min(_ODD_Q4, square_q4), known_q4 + 16)
        self._found_q4 = max(self._quietest_q4, min(LOUDEST_Q4, self._found_q4 + max(_QUIETER_Q4, step_q4)))
        self._known = min(_MEMORY, self._known + 1)

    def _settle(self):
        q4 = self._found_q4
        if self._known:
            q4 += _CHANCE_Q4 // self._known
        if self._is_unseen:
            q4 -= _UNSEEN_Q4
        self.q4 = max(self._quietest_q4, min(LOUDEST_Q4, q4))


class Slope:
    """What short ways missed beside a share of what odometry told, which is the same for all of them."""

    def __init__(self):
        self._square = self._cross = 0  # sums of told * told and told * missed

    def rest(self, told, missed):
        """The square of what a way missed (0.01 mm, within 4000) beside what the ways before let expect, in
        mm2 Q8, as large as without a share to find; -1 of the first way, which lets expect. told: counts for
        255 at most."""
        told = max(-_MOST_TOLD, min(_MOST_TOLD, told))
        square, cross, more = self._square, self._cross, told * told
        while square + more > _MOST_SUM or abs(cross) + abs(told * missed) > _MOST_SUM:
            square >>= 1
            cross >>= 1
        self._square, self._cross = square + more, cross + told * missed
        if square == 0:
            return -1
        off = max(-_MOST_OFF, min(_MOST_OFF, missed - cross * told // square))
        return (off * off // 39) * ((square << 8) // (square + more)) >> 8
