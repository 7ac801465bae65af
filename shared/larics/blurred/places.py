"""Where the blur-model reader examined something in the last frames, and how that ended.

It examines one or two candidates a frame. What was read gives way to what was not examined yet, so that
several markers are read in turns; what was no marker is passed over for a while where it stands still, since
a ceiling hardly changes between frames. What moves may be a marker that comes into view.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

UNKNOWN = const(0)
READ = const(1)  # in the last frame
REJECTED = const(2)

_PLACES = const(4)
_ITEMS = const(5)
_X_Q8 = const(0)
_Y_Q8 = const(1)
_RADIUS_Q8 = const(2)
_AGE = const(3)  # frames
_KIND = const(4)
_REJECTED_FRAMES = const(4)  # so long it is passed over,
_STANDING = const(16)  # while it moves by less than that part of its radius
_FORGOTTEN = const(255)


class Places:
    """Up to four places, the oldest of which gives way to a new one."""

    def __init__(self):
        self._items = array("i", bytes(4 * _ITEMS * _PLACES))
        for slot in range(0, _ITEMS * _PLACES, _ITEMS):
            self._items[slot + _AGE] = _FORGOTTEN
        self.are_noted = False  # whether there are any

    def memory(self):
        """Bytes of the buffer."""
        return 4 * len(self._items)

    def begin(self):
        """Begins a frame."""
        items = self._items
        self.are_noted = False
        for slot in range(0, _ITEMS * _PLACES, _ITEMS):
            age = items[slot + _AGE]
            if age < _FORGOTTEN:
                items[slot + _AGE] = age = age + 1
                if age > (1 if items[slot + _KIND] == READ else _REJECTED_FRAMES):
                    items[slot + _AGE] = _FORGOTTEN
                else:
                    self.are_noted = True

    def kind(self, x_q8, y_q8):
        """How the last examination there ended: within a place's radius, or where it stood if rejected."""
        slot = self._slot(x_q8, y_q8)
        return self._items[slot + _KIND] if slot >= 0 else UNKNOWN

    def _slot(self, x_q8, y_q8):
        items = self._items
        for slot in range(0, _ITEMS * _PLACES, _ITEMS):
            near_q8 = items[slot + _RADIUS_Q8]
            if items[slot + _KIND] == REJECTED:
                near_q8 = near_q8 // _STANDING
            if (
                items[slot + _AGE] < _FORGOTTEN
                and abs(items[slot + _X_Q8] - x_q8) < near_q8
                and abs(items[slot + _Y_Q8] - y_q8) < near_q8
            ):
                return slot
        return -1

    def note(self, x_q8, y_q8, radius_q8, kind):
        """Notes how an examination in this frame ended."""
        items = self._items
        own = self._slot(x_q8, y_q8)
        if own < 0:
            own = 0
            for slot in range(0, _ITEMS * _PLACES, _ITEMS):
                if items[slot + _AGE] > items[own + _AGE]:
                    own = slot
        items[own + _X_Q8] = x_q8
        items[own + _Y_Q8] = y_q8
        items[own + _RADIUS_Q8] = radius_q8
        items[own + _AGE] = 0
        items[own + _KIND] = kind
