"""Path sequences: where on its route the vehicle is, from the IDs passed so far, in integers only.

A route is a list of IDs in the order of driving, such as 1-2-3-4-3-2-1; one that ends where it began is
driven again and again. An ID may occur several times, in the route and in the building, so one marker
alone may not tell the position: every position is kept with the cost of the cheapest story that leads
there, and the vehicle is located when one story is cheaper than all others. A story is made of steps:

    the next marker of the route, or the same one again      0
    a marker of the route was not seen                       2 each, at most two in a row
    a marker was seen that does not belong here              5
    the next marker was reached, but read as another one     6
    the vehicle was put elsewhere on the route               7

So one wrong marker is reported and does not move the vehicle on its route; a second one that fits
elsewhere does. `see` allocates nothing.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

MISSED_COST = const(2)
EXTRA_COST = const(5)
MISREAD_COST = const(6)
MOVED_COST = const(7)
_MOST_MISSED = const(2)
_MOST = const(60000)

# what `see` found out
SAME = const(0)  # still the same marker: nothing happened
ON_ROUTE = const(1)  # the marker that the route expected
AMBIGUOUS = const(2)  # several positions explain the markers passed equally well
MISSED = const(3)  # one or two markers of the route were not seen (`missed`: how many)
UNEXPECTED = const(4)  # a marker that does not belong here; the position is kept
MISREAD = const(5)  # the expected marker was reached, but another ID was read
MOVED = const(6)  # elsewhere on the route than one could have driven: position found again

_WORDS = (
    "the same marker",
    "on the route",
    "position still open",
    "passed over a marker",
    "unexpected marker",
    "misread marker",
    "moved elsewhere on the route",
)


def route_reason(ids, map_rows=()):
    """None when the IDs can be a route (over the map, if it has rows), else one line that says why not."""
    if len(ids) == 1:
        return "route has one marker only: at least two are needed"
    places = [row[0] for row in map_rows]
    for step in range(len(ids)):
        if places and ids[step] not in places:
            return "route step %d: marker %d is not in the map" % (step + 1, ids[step])
        if step and ids[step] == ids[step - 1]:
            return "route step %d: impossible step from marker %d to itself" % (step + 1, ids[step])
    return None


def resolve_entries(ids, marker_map):
    """The map entry of each step: where an ID repeats in the building, the shortest way decides.

    Returns a list; ValueError as `route_reason`. Runs once, at start."""
    reason = route_reason(ids, [(marker_id,) for marker_id in marker_map.ids])
    if reason:
        raise ValueError(reason)
    closed = len(ids) > 2 and ids[0] == ids[-1]
    best = None
    for first in range(marker_map.count):
        if not len(ids) or marker_map.ids[first] != ids[0]:
            continue
        ways = [(0, [first])]
        for marker_id in ids[1:]:
            longer = []
            for entry in range(marker_map.count):
                if marker_map.ids[entry] == marker_id:
                    longer.append(
                        min([(w[0] + _way(marker_map, w[1][-1], entry), w[1] + [entry]) for w in ways])
                    )
            ways = longer
        for way in ways:
            if (best is None or way < best) and not (closed and way[1][-1] != first):
                best = way
    return best[1] if best else []


def _way(marker_map, a, b):
    dx = (marker_map.x_mm10[a] - marker_map.x_mm10[b]) // 10
    dy = (marker_map.y_mm10[a] - marker_map.y_mm10[b]) // 10
    return max(abs(dx), abs(dy)) + min(abs(dx), abs(dy)) // 2  # near enough to the distance to compare


class Route:
    """Follows a vehicle along a route.

    ids         IDs in the order of driving, 2 to 64 of them
    marker_map  MarkerMap, or None: then there are no entries
    start       index in the route of the first marker to be met, -1 when the vehicle may be anywhere

    position    index in the route of the marker reached last, -1 while unknown
    missed      how many markers the last MISSED passed over
    Raises ValueError in one line for what cannot be a route.
    """

    def __init__(self, ids, marker_map=None, start=-1):
        reason = route_reason(ids)
        if reason or not len(ids):
            raise ValueError(reason or "route is empty")
        if not -1 <= start < len(ids):
            raise ValueError("route start %d is outside the route of %d markers" % (start, len(ids)))
        self.ids = array("i", ids)
        self.closed = len(ids) > 2 and ids[0] == ids[-1]
        self.count = len(ids) - 1 if self.closed else len(ids)  # positions
        self.entries = resolve_entries(ids, marker_map) if marker_map is not None else None
        self._start = start % self.count if start >= 0 else -1
        self._cost = array("H", [0] * self.count)
        self._next = array("H", [0] * self.count)
        self.restart()

    def restart(self):
        """Forgets the markers passed."""
        self.position = self._start
        self.missed = 0
        self._last_id = -1
        for k in range(self.count):
            self._cost[k] = 0 if self._start in (-1, k) else MOVED_COST

    def next_position(self):
        """Index in the route of the marker to drive to; -1 at the end, or while the position is unknown."""
        if self.position < 0:
            return -1
        if self.position + 1 < self.count:
            return self.position + 1
        return 0 if self.closed else -1

    def entry(self, position):
        """The map entry of a position, -1 without map or position."""
        return self.entries[position] if self.entries and position >= 0 else -1

    def lose_sight(self):
        """The last marker went out of view: its ID, when read again, is a new marker passed."""
        self._last_id = -1

    def see(self, marker_id):
        """Takes the ID read in this frame and returns what it means; call it while a marker is in view."""
        if marker_id == self._last_id:
            return SAME
        self._last_id = marker_id
        before = self.position
        best = self._advance(marker_id)
        if best < 0:
            self.position = -1
            return AMBIGUOUS
        self.position = best
        return self._meaning(before, best, marker_id)

    def pass_by(self):
        """The vehicle was at the place of the next marker and did not see it: it counts as passed."""
        following = self.next_position()
        if following < 0:
            return SAME
        self._advance(self.ids[following])
        self.position = following
        self.missed = 1
        self._last_id = -1
        return MISSED

    def _advance(self, marker_id):
        """The cost of every position after this marker; returns the cheapest, -1 when there are several."""
        ids, count = self.ids, self.count
        cost, after = self._cost, self._next
        moved = MOVED_COST  # the least cost is always 0
        least = _MOST
        best = -1
        for k in range(count):
            fits = ids[k] == marker_id
            cheapest = cost[k] if fits else cost[k] + EXTRA_COST
            if fits and moved < cheapest:
                cheapest = moved
            for back in range(1, _MOST_MISSED + 2):
                origin = k - back
                if origin < 0:
                    if not self.closed or back >= count:
                        break
                    origin += count
                way = cost[origin] + (back - 1) * MISSED_COST + (0 if fits else MISREAD_COST)
                if way < cheapest:
                    cheapest = way
            cheapest = min(cheapest, _MOST)
            after[k] = cheapest
            if cheapest < least:
                least = cheapest
                best = k
            elif cheapest == least:
                best = -1
        for k in range(count):
            after[k] -= least
        self._cost = after
        self._next = cost
        return best

    def _meaning(self, before, now, marker_id):
        fits = self.ids[now] == marker_id
        if before < 0:
            return ON_ROUTE if fits else UNEXPECTED
        steps = now - before
        if steps < 0 and self.closed:
            steps += self.count
        if steps == 0:
            return ON_ROUTE if fits else UNEXPECTED
        if not fits:
            return MISREAD
        if steps == 1:
            return ON_ROUTE
        if 1 < steps <= _MOST_MISSED + 1:
            self.missed = steps - 1
            return MISSED
        return MOVED

    def describe(self, meaning, marker_id):
        """One line for a person."""
        text = "route: marker %d: %s" % (marker_id, _WORDS[meaning])
        following = self.next_position()
        if following >= 0:
            text += ", next is marker %d" % self.ids[following]
        return text
