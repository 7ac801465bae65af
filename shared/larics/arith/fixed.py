"""Fixed-point helpers: sine, cosine, arc tangent, roots and angles, in integers only.

An angle is in 1/65536 turn (`_turn16`, 0..65535) inside the detector and in hundredths of a degree
(`_cdeg`, 0..35999) outside; both count counterclockwise.
"""

from array import array

try:
    import micropython  # noqa: F401  (its presence tells the interpreter)
    from micropython import const

    def table16(data):
        return data

    _FLAT = (bytearray, bytes, memoryview)  # made once: it would be allocated with each frame

    def frame_view(frame):
        """A frame as a flat buffer: an OpenMV image or a dense array of ulab as it lies, the rest as it is.

        Raises ValueError when the items are not single bytes or not side by side."""
        if isinstance(frame, _FLAT):
            return frame
        if hasattr(frame, "bytearray"):  # an image
            return frame.bytearray()
        try:
            view = memoryview(frame)
        except (TypeError, ValueError):  # ulab refuses views with gaps
            view = None
        if view is None or view.itemsize != 1:
            raise ValueError("a frame is a contiguous buffer of 8-bit pixels")
        return view

    _kept = {}
except ImportError:
    from larics._cpython import const, frame_view, micropython, table16  # noqa: F401  (frame_view is for the callers)

    _kept = None

from larics.arith import tables

COSINE = table16(tables.COSINE_Q14_BIASED)
LOG_GREY = table16(tables.LOG_GREY_Q8)
AXES = table16(tables.AXES_48)
ROOT = table16(tables.ROOT_Q14)
CELL_AXES = table16(tables.CELL_AXES)
CELL_ROWS = table16(tables.CELL_ROWS)

_TURN = const(65536)
_QUARTER = const(16384)


def words(count, name=None, code="i"):
    """An array of so many items of 32 bits or, of code "H", 16, whatever they hold: scratch space for
    kernels. Made from zeros, it would need twice the memory for a moment.

    With a name, which scratch space of more than half a kilobyte should have, MicroPython keeps the longest
    one and gives it to the next that asks: what is loaded while a detector is made anew would settle where
    the buffers of the one before were. Two detectors may share it, since none of them looks at it after its
    frame. MemoryError leaves the one before. A name that MicroPython has anyway takes no memory."""
    if name is None or _kept is None:
        return array(code, range(count))
    size = len(_kept.get(name, ()))
    if size < count or name not in _kept:
        longer, before = range(count), range(size)  # made first: they must not lie where the buffer was
        _kept.pop(name, None)
        try:
            _kept[name] = array(code, longer)
        except MemoryError:
            _kept[name] = array(code, before)
            raise
    return _kept[name] if size <= count else memoryview(_kept[name])[:count]


class Parts:
    """Scratch space, for kernels alone: on a board parts of a buffer of words that is idle meanwhile, one
    behind the other; without such a buffer, and on a PC, arrays of their own. `used`: words handed out, and
    those before them."""

    def __init__(self, idle=None, used=0):
        self._idle = None if _kept is None else idle
        self.used = used

    def of16(self, count):
        """So many 16-bit items. MemoryError when the buffer has no more."""
        return array("H", bytes(2 * count)) if self._idle is None else self.of32(count + 1 >> 1)

    def of32(self, count):
        """So many 32-bit items."""
        if self._idle is None:
            return array("i", bytes(4 * count))
        first = self.used
        self.used = first + count
        if self.used > len(self._idle):
            raise MemoryError
        return memoryview(self._idle)[first : self.used]


def forget_words():
    """Gives back what `words` keeps, so that shorter ones take less. What is in use stays."""
    if _kept is not None:
        _kept.clear()


def _entry(table, index):
    return table[2 * index] | table[2 * index + 1] << 8


def log_grey(grey):
    """256 * log2((grey + 16) / 16) of a grey level of 0..255; more counts as 255."""
    return _entry(tables.LOG_GREY_Q8, min(255, grey))


def sin_q14(angle_turn16):
    """Sine of an angle in 1/65536 turn, any integer, as -16384..16384; error below 2 units."""
    angle = angle_turn16 & 65535
    sign = 1
    if angle >= 32768:
        angle -= 32768
        sign = -1
    if angle > _QUARTER:
        angle = 32768 - angle
    at, rest, sines = angle >> 6 << 1, angle & 63, tables.QUARTER_SINE_Q14
    value = sines[at] | sines[at + 1] << 8  # not by _entry: this is called often
    if rest:
        value += (((sines[at + 2] | sines[at + 3] << 8) - value) * rest + 32) >> 6
    return sign * value


def cos_q14(angle_turn16):
    """Cosine of an angle in 1/65536 turn, as `sin_q14`."""
    return sin_q14(angle_turn16 + _QUARTER)


def atan2_turn16(y, x):
    """Angle of the vector (x, y) in 1/65536 turn, 0..65535; 0 for the null vector. |x|, |y| < 2**22."""
    ax, ay = abs(x), abs(y)
    if ax == 0 and ay == 0:
        return 0
    small, large = ay, ax  # a conditional pair would allocate a tuple
    if ay > ax:
        small, large = ax, ay
    while large >= 16384:  # keep the quotient below within 30 bits
        small >>= 1
        large >>= 1
    quotient = ((small << 16) + (large >> 1)) // large
    index, rest = quotient >> 8, quotient & 255
    angle = _entry(tables.ARCTAN, index)
    if rest:
        angle += ((_entry(tables.ARCTAN, index + 1) - angle) * rest + 128) >> 8
    angle = (angle + 2) >> 2
    if ay > ax:
        angle = _QUARTER - angle
    if x < 0:
        angle = 32768 - angle
    return (-angle if y < 0 else angle) & 65535


@micropython.native
def isqrt(value):
    """Floor of the square root of a non-negative integer below 2**60."""
    if value < 2:
        return value
    root, bits = value, 0
    while root:
        root >>= 2
        bits += 1
    root = 1 << bits
    while True:
        better = (root + value // root) >> 1
        if better >= root:
            return root
        root = better


def cdeg_from_turn16(angle_turn16):
    """1/65536 turn -> hundredths of a degree, 0..35999, rounded."""
    return ((angle_turn16 & 65535) * 1125 + 1024) // 2048 % 36000


def turn16_from_cdeg(angle_cdeg):
    """Hundredths of a degree -> 1/65536 turn, 0..65535, rounded."""
    return (angle_cdeg % 36000 * 2048 + 562) // 1125 & 65535


def wrap_cdeg(angle_cdeg):
    """Any angle in hundredths of a degree -> -18000..17999."""
    return (angle_cdeg + 18000) % 36000 - 18000
