"""The list of candidates for the blur-model reader (blurred.candidates)."""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr32

_CANDIDATE_RANK = const(0)  # items as in kernels.layouts
_CANDIDATE_X_Q8 = const(1)
_CANDIDATE_Y_Q8 = const(2)
_CANDIDATE_LEAST_Q8 = const(3)
_CANDIDATE_MOST_Q8 = const(4)
_CANDIDATE_VERDICT = const(5)
_CANDIDATE_LOOKED = const(6)
_CANDIDATE_SCORE = const(7)
_CANDIDATE_KIND = const(13)
_CANDIDATE_ITEMS = const(14)


@micropython.viper
def remember(
    items: ptr32, slot: int, i: int, count: int, capacity: int, rank: int, x: int, y: int, least: int,
    most: int, verdict: int,
) -> int:  # fmt: skip
    """Keeps a candidate (layouts.CANDIDATE), in the place of one of its size nearby or of the last of a full
    list, if it ranks higher than that; returns the number of candidates.

    rank > 0; x, y: with BIAS added; least, most: radii, 1/256 px. Nearby is a quarter of `least`."""
    near = least >> 2
    lowest = rank
    found = capacity
    i = 0
    while i < count:
        slot = i * _CANDIDATE_ITEMS
        value = int(items[slot])
        if int(items[slot + _CANDIDATE_LEAST_Q8]) == least:
            dx = int(items[slot + _CANDIDATE_X_Q8]) - x
            dy = int(items[slot + _CANDIDATE_Y_Q8]) - y
            if dx < near and 0 - near < dx and dy < near and 0 - near < dy:
                if value >= rank:
                    return count
                lowest = 0
                found = i
        if value < lowest:
            lowest = value
            found = i
        i += 1
    if lowest > 0 and count < capacity:
        found = count
        count += 1
    if found < capacity:
        slot = found * _CANDIDATE_ITEMS
        items[slot] = rank
        items[slot + _CANDIDATE_X_Q8] = x
        items[slot + _CANDIDATE_Y_Q8] = y
        items[slot + _CANDIDATE_LEAST_Q8] = least
        items[slot + _CANDIDATE_MOST_Q8] = most
        items[slot + _CANDIDATE_VERDICT] = verdict
        items[slot + _CANDIDATE_LOOKED] = 0
        items[slot + _CANDIDATE_SCORE] = 0
        items[slot + _CANDIDATE_KIND] = 0
    return count


@micropython.viper
def next_unseen(items: ptr32, slot: int, found: int, count: int) -> int:
    """The first item of the highest-ranking candidate that was not looked at yet; -1 without any."""
    found = 0 - 1
    best = 0
    slot = 0
    end = count * _CANDIDATE_ITEMS
    while slot < end:
        if int(items[slot + _CANDIDATE_LOOKED]) == 0 and int(items[slot]) > best:
            best = int(items[slot])
            found = slot
        slot += _CANDIDATE_ITEMS
    return found
