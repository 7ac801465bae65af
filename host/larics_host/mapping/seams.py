"""Where a drive lost itself: from some passage on it meets the same markers again in other places.

A vehicle that is carried off, or whose wheels slip far, takes what it knows for something new. Turned and
shifted as a whole, the places after that are those before, and they lie among them, where no marker was
before.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from larics_host.mapping.association import Found
from larics_host.mapping.poses import after, inverse, wrapped

_AGREE_MM, _AGREE_RAD = 500.0, 0.2
_STILL_MM, _STILL_RAD = 400.0, 0.08  # a motion that is none
_LEAST = 4  # places that the motion brings onto each other, beyond those that need none
_AMONG_SHARE, _AMONG_LEAST = 0.6, 3  # of the usual distance from each other; places that lie nearer
_TRIED = 3000


def seam(founds: Sequence[Found]) -> int | None:
    """The passage from which on a drive with these places is lost, None where it is not."""
    pairs = [
        (one, other)
        for one in founds
        for other in founds
        if one.id == other.id and one.passages[-1] < other.passages[0]
    ]
    best: list[tuple[Found, Found]] = []
    for one, other in pairs[:: -(-len(pairs) // _TRIED) or 1]:
        motion = after(one.pose, inverse(other.pose))
        if math.hypot(*motion[:2]) < _STILL_MM and abs(wrapped(motion[2])) < _STILL_RAD:
            continue
        agreeing = [pair for pair in pairs if _fits(motion, pair)]
        if len({id(second) for _, second in agreeing}) > len({id(second) for _, second in best}):
            best = agreeing
    cut, brought = _cut(founds, best)
    if brought < _LEAST:
        return None
    before = [found for found in founds if found.passages[0] < cut]
    new = [found for found in founds if found.passages[0] >= cut]
    return cut if _among(new, before) else None


def _cut(founds, pairs):
    """(passage, number of places): the best cut into what the pairs have before and behind it, and how many
    more places they bring onto each other than were seen on both sides of it."""
    best = 0, -len(founds)
    for cut in sorted({other.passages[0] for _, other in pairs}):
        brought = {id(other) for one, other in pairs if one.passages[-1] < cut <= other.passages[0]}
        both = sum(found.passages[0] < cut <= found.passages[-1] for found in founds)
        if len(brought) - both > best[1]:
            best = cut, len(brought) - both
    return best


def _fits(motion, pair):
    one, other = pair
    x, y, heading = after(motion, other.pose)
    near = math.dist((x, y), one.pose[:2]) < _AGREE_MM
    return near and abs(wrapped(heading - one.pose[2])) < _AGREE_RAD


def _among(new, before):
    """Whether new places lie among those before, where there was no room for them."""
    if len(before) < _LEAST:
        return False
    known = np.array([found.pose[:2] for found in before])
    apart = np.hypot(*(known[:, None] - known[None]).transpose(2, 0, 1))
    np.fill_diagonal(apart, np.inf)
    usual = float(np.median(apart.min(axis=1)))
    nearest = [float(np.hypot(*(known - found.pose[:2]).T).min()) for found in new]
    return sum(away < _AMONG_SHARE * usual for away in nearest) >= _AMONG_LEAST
