"""The candidates of a frame that the direct reader rejected: the blur-model reader looks at a few of them."""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.blurred.places import READ, REJECTED, Places
from larics.kernels import candidates as kernels
from larics.marker import verdicts

_BIAS = const(1 << 24)  # items as in kernels.layouts
X_Q8 = const(1)
Y_Q8 = const(2)
LEAST_Q8 = const(3)
MOST_Q8 = const(4)
VERDICT = const(5)
LOOKED = const(6)
SCORE = const(7)
X_Q10 = const(8)
Y_Q10 = const(9)
RADIUS_Q8 = const(10)
E1 = const(11)
E2 = const(12)
_KIND = const(13)
_ITEMS = const(14)

_CAPACITY = const(8)
_LEAST_SCORE = const(5200)  # of 16384; hardly any marker has less,
_LEAST_SCORE_CLEAR = const(7200)  # in a frame with contrast,
_LEAST_SCORE_MOLTEN = const(6000)  # where defocus has not molten the rings,
_LEAST_SCORE_SMALL = const(4300)  # nor a small one
_SMALL_Q8 = const(2304)
_LEAST_SHADE = const(36)  # of the darkest direction around, 256ths of the rings; 1 in 100 lines has below 57
_MOST_SHADE = const(2000)  # through defocus of 3.5 px lines have up to 867, in noise up to 1714,
_LARGE_Q8 = const(3072)  # but small ones more, and molten ones, which are a band darker than
_MOLTEN_LEAST = const(54)  # in so many directions of 64 what lies on either side
_FIRST_EFFORT = const(700)  # so much more, thousands of instructions, while there is no candidate
_GOOD_SCORE = const(9000)  # hardly any clutter has so much,
_GOOD_SCORE_SEVERAL = const(11500)  # but what other scales take for rings often has more
_RANKS = (0, 5, 1, 2, 3, 3, 4, 4, 4, 5)  # by sharp verdict: how far the candidate came


class Candidates:
    """Up to eight candidates, those that came farther before the others.

    several  whether they are of several scales
    is_cut   whether there was no time for a look at all of them, and none looks good
    items    array('i') of the candidates' items (kernels.layouts: CANDIDATE), which lie where `best` says
    places   what was examined in the last frames, and how that ended
    clear    whether the frame has contrast
    """

    def __init__(self, several=False):
        self.several = several
        self.items = array("i", bytes(4 * _ITEMS * _CAPACITY))
        self.places = Places()
        self._count = 0
        self.clear = self.is_cut = self._passes_over = False

    def memory(self):
        """Bytes of the buffers."""
        return 4 * len(self.items) + self.places.memory()

    def forget(self):
        """Begins a new frame."""
        self._count = 0

    def remember(self, x_q8, y_q8, radius_min_q8, radius_max_q8, verdict, votes, clear):
        """Keeps a candidate, unless one of its size nearby came as far; equals are ranked by their votes.

        clear: whether the frame has contrast; then less is forgiven."""
        self.clear = clear
        self._count = kernels.remember(
            self.items, 0, 0, self._count, _CAPACITY, (_RANKS[verdict] << 16) + votes, x_q8 + _BIAS,
            y_q8 + _BIAS, radius_min_q8, radius_max_q8, verdict,
        )  # fmt: skip

    def best(self, frame, rings, passes_over, effort_most=1 << 29):
        """The first item of the one that looks most like rings and has not been taken yet; -1 without any.

        Looks coarsely at one after the other until one looks good enough, where little is to be done one that
        looks good. What was read in the last frame gives way to all others; passes_over: what was rejected is
        not looked at, and little is to be done; effort_most: of the rings, with which no other look begins
        once there is one, and a little later without; then `is_cut`."""
        items = self.items
        self.is_cut = False
        self._passes_over = passes_over
        good = _GOOD_SCORE_SEVERAL if self.several and not passes_over else _GOOD_SCORE
        found = self._best()
        while found < 0 or items[found + SCORE] < good or items[found + _KIND] == READ:
            slot = kernels.next_unseen(items, 0, 0, self._count)
            if slot < 0:
                break
            if rings.effort > effort_most:
                if found >= 0:
                    break
                if self.several and rings.effort > effort_most + _FIRST_EFFORT:
                    self.is_cut = True
                    break
            self._look(frame, rings, slot)
            if items[slot + SCORE] and (found < 0 or self._is_better(slot, found)):
                found = slot
        if found >= 0:
            items[found + SCORE] = 0
        return found

    def _best(self):
        """The first item of the best of those looked at; -1 without any."""
        items = self.items
        found = -1
        for slot in range(0, _ITEMS * self._count, _ITEMS):
            if items[slot + SCORE] and (found < 0 or self._is_better(slot, found)):
                found = slot
        return found

    def _is_better(self, slot, other):
        items = self.items
        if (items[slot + _KIND] == READ) != (items[other + _KIND] == READ):
            return items[other + _KIND] == READ
        return items[slot + SCORE] > items[other + SCORE]

    def recognize(self):
        """Recognizes what was examined in the last frames; whether any was read in the last one."""
        items = self.items
        places = self.places
        places.begin()
        read = False
        if places.are_noted:
            for slot in range(0, _ITEMS * self._count, _ITEMS):
                items[slot + _KIND] = kind = places.kind(items[slot + X_Q8], items[slot + Y_Q8])
                read = read or kind == READ
        return read

    def was_read(self, slot):
        """Whether a marker was read there in the last frame."""
        return self.items[slot + _KIND] == READ

    def postpone_others(self, taken, verdict, views):
        """Leaves the others to the next frame, but for what was read in the last one; whether there were any.

        Unless `views`, other views of the rings of the one taken stay where these did not hold."""
        items = self.items
        near_q8 = items[taken + LEAST_Q8] if verdict < verdicts.NO_ORIENTATION and not views else 0
        postponed = False
        for slot in range(0, _ITEMS * self._count, _ITEMS):
            if (
                (items[slot + SCORE] or not items[slot + LOOKED])
                and items[slot + _KIND] != READ
                and (
                    abs(items[slot + X_Q8] - items[taken + X_Q8]) > near_q8
                    or abs(items[slot + Y_Q8] - items[taken + Y_Q8]) > near_q8
                )
            ):
                items[slot + LOOKED] = 1
                items[slot + SCORE] = 0
                postponed = True
        return postponed

    def note(self, slot, radius_q8, kind):
        """Notes how the examination of one ended."""
        items = self.items
        self.places.note(items[slot + X_Q8], items[slot + Y_Q8], radius_q8, kind)

    def note_looked(self):
        """Notes those that were looked at as no markers."""
        items = self.items
        for slot in range(0, _ITEMS * self._count, _ITEMS):
            if items[slot + LOOKED] and items[slot + _KIND] != READ:
                self.note(slot, items[slot + LEAST_Q8], REJECTED)

    def dismiss_ghosts(self, taken):
        """Dismisses what may be but another view, from beside them, of the rings of the one taken.

        Noise may show the better view second: only where the frame has contrast."""
        if self.clear:
            self._dismiss(taken, self.items[taken + LEAST_Q8], 0)

    def dismiss_judged(self, taken, radius_q8):
        """Dismisses the same rings at another scale: those of the one taken, of this radius, were judged."""
        self._dismiss(taken, radius_q8 >> 2, radius_q8)

    def _dismiss(self, taken, near_q8, radius_q8):
        items = self.items
        for slot in range(0, _ITEMS * self._count, _ITEMS):
            if (
                abs(items[slot + X_Q8] - items[taken + X_Q8]) < near_q8
                and abs(items[slot + Y_Q8] - items[taken + Y_Q8]) < near_q8
                and (
                    abs(items[slot + RADIUS_Q8] - radius_q8) < radius_q8 >> 3
                    if radius_q8
                    else items[slot + LEAST_Q8] == near_q8
                )
            ):
                if not radius_q8:
                    items[slot + LOOKED] = 1
                items[slot + SCORE] = 0

    def _look(self, frame, rings, slot):
        items = self.items
        items[slot + LOOKED] = 1
        items[slot + SCORE] = 0
        if items[slot + VERDICT] == verdicts.NO_CODE:
            return  # it was seen well enough
        if self._passes_over and items[slot + _KIND] == REJECTED:
            return
        small = items[slot + LEAST_Q8] < _SMALL_Q8
        least = _LEAST_SCORE_MOLTEN if self.clear else _LEAST_SCORE
        score = rings.coarse(
            frame, items[slot + X_Q8] - _BIAS, items[slot + Y_Q8] - _BIAS, items[slot + LEAST_Q8],
            items[slot + MOST_Q8], _LEAST_SCORE_SMALL if small else least,
        )  # fmt: skip
        if score:
            shade = rings.line_shade(frame)
            molten = rings.dark_around >= _MOLTEN_LEAST
            weak = self.clear and not small and score < _LEAST_SCORE_CLEAR
            vague = shade > _MOST_SHADE and items[slot + LEAST_Q8] >= _LARGE_Q8
            # rings without a line, or no rings
            if shade >= _LEAST_SHADE and (molten or not (weak or vague)):
                items[slot + SCORE] = score
        items[slot + X_Q10] = rings.x_q10
        items[slot + Y_Q10] = rings.y_q10
        items[slot + RADIUS_Q8] = rings.radius_q8
        items[slot + E1] = rings.e1
        items[slot + E2] = rings.e2
