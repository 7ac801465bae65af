"""The candidates of a frame that the direct reader rejected: the blur-model reader looks at a few of them."""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

X_Q8 = const(1)  # items of a candidate: centre and range of radii where the search found it,
Y_Q8 = const(2)
RADIUS_MIN_Q8 = const(3)
RADIUS_MAX_Q8 = const(4)
VERDICT = const(5)  # what the direct reader said,
SCORE = const(6)  # how much it looks like rings, and the rings' coarse pose
X_Q10 = const(7)
Y_Q10 = const(8)
RADIUS_Q8 = const(9)
E1 = const(10)
E2 = const(11)

_ITEMS = const(12)
_CAPACITY = const(8)
_LEAST_SCORE = const(4300)  # of 16384; half of the clutter has less,
_GOOD_SCORE = const(9000)  # hardly any so much
_RANKS = (0, 5, 1, 2, 3, 3, 4, 4, 4, 5)  # by sharp verdict: how far the candidate came


class Candidates:
    """Up to eight candidates, those that came farther before the others.

    items    array('i') of the candidates' items, which lie where `best` says
    """

    def __init__(self):
        self.items = array("i", bytes(4 * _ITEMS * (_CAPACITY + 1)))
        self._count = self._looked = 0

    def memory(self):
        """Bytes of the buffer."""
        return 4 * len(self.items)

    def forget(self):
        """Begins a new frame."""
        self._count = self._looked = 0

    def remember(self, x_q8, y_q8, radius_min_q8, radius_max_q8, verdict, votes):
        """Keeps a candidate, unless one of its size nearby came as far; equals are ranked by their votes."""
        items = self.items
        rank = (_RANKS[verdict] << 16) + votes
        near_q8 = radius_min_q8 >> 2
        for index in range(self._count):
            slot = _ITEMS * index
            if (
                items[slot + RADIUS_MIN_Q8] == radius_min_q8
                and abs(items[slot + X_Q8] - x_q8) < near_q8
                and abs(items[slot + Y_Q8] - y_q8) < near_q8
                and items[slot] >= rank
            ):
                return
        slot = self._count
        while slot and items[_ITEMS * (slot - 1)] < rank:
            for item in range(_ITEMS):
                items[_ITEMS * slot + item] = items[_ITEMS * (slot - 1) + item]
            slot -= 1
        slot *= _ITEMS
        items[slot] = rank
        items[slot + X_Q8] = x_q8
        items[slot + Y_Q8] = y_q8
        items[slot + RADIUS_MIN_Q8] = radius_min_q8
        items[slot + RADIUS_MAX_Q8] = radius_max_q8
        items[slot + VERDICT] = verdict
        if self._count < _CAPACITY:
            self._count += 1

    def best(self, frame, rings):
        """The first item of the one that looks most like rings and has not been taken yet; -1 without any.

        Looks coarsely at one after the other until one looks good enough."""
        items = self.items
        best = 0
        found = -1
        for index in range(self._count):
            slot = _ITEMS * index
            if index == self._looked:
                self._look(frame, rings, slot)
            if items[slot + SCORE] > max(best, _LEAST_SCORE):
                best = items[slot + SCORE]
                found = slot
            if best >= _GOOD_SCORE:
                break
        if found >= 0:
            items[found + SCORE] = 0
        return found

    def _look(self, frame, rings, slot):
        items = self.items
        self._looked += 1
        items[slot + SCORE] = rings.coarse(
            frame, items[slot + X_Q8], items[slot + Y_Q8], items[slot + RADIUS_MIN_Q8],
            items[slot + RADIUS_MAX_Q8],
        )  # fmt: skip
        items[slot + X_Q10] = rings.x_q10
        items[slot + Y_Q10] = rings.y_q10
        items[slot + RADIUS_Q8] = rings.radius_q8
        items[slot + E1] = rings.e1
        items[slot + E2] = rings.e2
