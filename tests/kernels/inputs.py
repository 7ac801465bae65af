"""Inputs for kernels, equal on every interpreter: a generator of numbers of its own, frames, buffers."""

from array import array

from larics.arith import fixed


class Random:
    """A linear congruential generator in integers; the same seed gives the same numbers everywhere."""

    def __init__(self, seed):
        self.state = seed & 0x7FFFFFFF

    def below(self, limit):
        """0 .. limit - 1, for limits up to 2**30."""
        self.state = (self.state * 1103515245 + 12345) & 0x7FFFFFFF
        value = self.state >> 16
        self.state = (self.state * 1103515245 + 12345) & 0x7FFFFFFF
        return (value << 15 | self.state >> 16) % limit

    def between(self, low, high):
        """low .. high, both included."""
        return low + self.below(high - low + 1)


def _black(x, y, width, height, random):
    return 0


def _white(x, y, width, height, random):
    return 255


def _checkerboard(x, y, width, height, random):
    return 255 if (x + y) & 1 else 0


def _blocks(x, y, width, height, random):
    return 255 if (x // 4 + y // 4) & 1 else 0


def _columns(x, y, width, height, random):
    return 255 if x // 3 & 1 else 0


def _rows(x, y, width, height, random):
    return 255 if y // 2 & 1 else 0


def _ramp(x, y, width, height, random):
    return 255 * x // (width - 1)


def _saw(x, y, width, height, random):
    return (7 * x + 13 * y) & 255


def _noise(x, y, width, height, random):
    return random.below(256)


def _salt(x, y, width, height, random):
    return 255 * random.below(2)


def _spike(x, y, width, height, random):
    return 255 if x == width // 2 and y == height // 2 else 0


def _hole(x, y, width, height, random):
    return 0 if x == 5 and y == 5 else 255


def _rings(x, y, width, height, random):
    dx, dy = 2 * x - width, 2 * y - height
    return 255 if fixed.isqrt(dx * dx + dy * dy) // 8 & 1 else 0


PATTERNS = {
    "black": _black,
    "white": _white,
    "checkerboard": _checkerboard,
    "blocks": _blocks,
    "columns": _columns,
    "rows": _rows,
    "ramp": _ramp,
    "saw": _saw,
    "noise": _noise,
    "salt": _salt,
    "spike": _spike,
    "hole": _hole,
    "rings": _rings,
}


def pixels(name, width, height, random):
    """A frame of one of the PATTERNS as a bytearray."""
    pattern = PATTERNS[name]
    data = bytearray(width * height)
    for y in range(height):
        for x in range(width):
            data[y * width + x] = pattern(x, y, width, height, random)
    return data


def view(data):
    """Pixels as the detectors pass them to kernels."""
    if hasattr(fixed, "frame_view"):
        return fixed.frame_view(data)
    return data


def frames(width, height, random):
    """Yields a frame of each of the PATTERNS, in order of their names."""
    for name in sorted(PATTERNS):
        yield view(pixels(name, width, height, random))


def random_bytes(count, random, limit=256):
    return bytearray([random.below(limit) for _ in range(count)])


def words(count, random, low=0, high=65535):
    """array('H') of numbers from low to high, both of which occur when there is room."""
    return _bounded("H", count, random, low, high)


def ints(count, random, low=0, high=0x3FFFFFFF):
    """array('i') of numbers from low to high, both of which occur when there is room."""
    return _bounded("i", count, random, low, high)


def _bounded(code, count, random, low, high):
    items = array(code, [random.between(low, high) for _ in range(count)])
    if count > 1:
        items[random.below(count)] = low
        items[random.below(count)] = high
    return items


def zeros16(count):
    return array("H", bytes(2 * count))


def zeros32(count):
    return array("i", bytes(4 * count))
