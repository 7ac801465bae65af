"""What a sample of pixels tells of a frame: whether it is the one before again, and whether it shows any.

A sensor never repeats its noise, so a frame whose sample equals that of the frame before is no new frame but
a copy that a stuck sensor, driver or memory serves again. Where there is no light, or far too much, all
pixels may be alike without that.

A kernel does it: 28,000 instructions a frame on an emulated Cortex-M7; the same of slices and sums of ulab
takes 59,000, and 1,136 bytes of heap for each frame.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.kernels.grey import take_sample

# pixels. With little noise (half of them as before) one frame in 2**251 would be taken for a copy; in a
# picture smoothed so much that 98 of 100 pixels stay, one in 160, and five in a row never
SAMPLE = const(251)
_DARK_MOST = const(24)  # grey: a black level and its noise
_WHITE_LEAST = const(250)
_DIFFERENT, _LEAST, _MOST, _TOTAL = const(0), const(1), const(2), const(3)  # items of what take_sample found


class FrameCheck:
    """After `update`: is_copy, is_dark, is_white of the frame, and its mean grey (0..255), of its sample."""

    def __init__(self):
        self._kept = bytearray(SAMPLE)
        self._found = array("H", [0, 0, 0, 0])
        self._size = 0
        self._count = 1
        self._step = 1
        self.is_copy = self.is_dark = self.is_white = False

    def update(self, frame):
        """frame: a buffer of 8-bit pixels."""
        size = len(frame)
        is_first = size != self._size
        if is_first:
            self._size = size
            self._step = max(1, size // SAMPLE) | 1  # odd, so that it meets every column
            self._count = min(SAMPLE, (size + self._step - 1) // self._step)
        found = self._found
        take_sample(frame, self._kept, 0, 0, self._step, self._count, found)
        self.is_dark = found[_MOST] <= _DARK_MOST
        self.is_white = found[_LEAST] >= _WHITE_LEAST
        self.is_copy = not (is_first or found[_DIFFERENT] or self.is_dark or self.is_white)

    @property
    def mean(self):
        return self._found[_TOTAL] // self._count
