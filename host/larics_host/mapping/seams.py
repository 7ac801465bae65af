"""Where a drive lost itself: from some passage on it meets the same markers again in other places.

A vehicle that is carried off, or whose wheels slip far, takes what it knows for something new. Turned and
shifted as a whole, many of the places after that are those before: by chance two or three of a map are, ten
and more of one that is lost. Where rows of a hall repeat themselves, with the same IDs and headings, a motion
brings them onto each other as well; but such rows are parallel or at right angles, and the new ones do not
lie among those before, where no marker was before.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from larics_host.mapping.association import Found
from larics_host.mapping.poses import after, inverse, wrapped

_AGREE_MM, _AGREE_RAD = 500.0, 0.2
_STILL_MM, _STILL_RAD = 400.0, 0.08  # a motion that is none
_LEAST, _SURE = 4, 5  # places that the motion brings onto each other; without new ones among those before
_BEFORE = 4  # places that tell how far they hang from each other
_ASKEW_RAD = 0.2  # against a right angle
_AMONG_SHARE, _AMONG_LEAST = 0.6, 3  # of the usual distance from each other; places that lie nearer ...
_MISREAD_MM = 300.0  # ... but not as near as one whose ID was misread
_TRIED = 3000


def seam(founds: Sequence[Found]) -> int | None:
    """The passage from which on a drive with these places is lost, None where it is not."""
    pairs = [
        (one, other)
        for one in founds
        for other in founds
        if one.id == other.id and one.passages[0] < other.passages[0]
    ]
    best: list[tuple[Found, Found]] = []
    turned = 0.0
    for one, other in pairs[:: -(-len(pairs) // _TRIED) or 1]:
        motion = after(one.pose, inverse(other.pose))
        if math.hypot(*motion[:2]) < _STILL_MM and abs(wrapped(motion[2])) < _STILL_RAD:
            continue
        agreeing = [pair for pair in pairs if _fits(motion, pair)]
        if _brought(agreeing) > _brought(best):
            best, turned = agreeing, motion[2]
    if _brought(best) < _LEAST:
        return None
    cut = _cut(best)
    before = [found for found in founds if found.passages[0] < cut]
    new = [found for found in founds if found.passages[0] >= cut]
    is_sure = _brought(best) >= _SURE and _is_askew(turned)
    return cut if is_sure or _among(new, before) else None


def _brought(pairs):
    """How many places pairs bring onto how many others, the fewer of both."""
    return min(len({id(found) for found in side}) for side in zip(*pairs, strict=True)) if pairs else 0


def _cut(pairs):
    """The passage that parts most pairs, into a place met before and one met from it on."""
    cuts = sorted({other.passages[0] for _, other in pairs})
    return max(cuts, key=lambda cut: sum(one.passages[0] < cut <= other.passages[0] for one, other in pairs))


def _fits(motion, pair):
    one, other = pair
    x, y, heading = after(motion, other.pose)
    near = math.dist((x, y), one.pose[:2]) < _AGREE_MM
    return near and abs(wrapped(heading - one.pose[2])) < _AGREE_RAD


def _is_askew(turn):
    """Whether rows of a hall would neither be parallel nor at right angles."""
    return abs(math.remainder(turn, math.pi / 2)) > _ASKEW_RAD


def _among(new, before):
    """Whether new places lie among those before, where there was no room for them."""
    if len(before) < _BEFORE:
        return False
    known = np.array([found.pose[:2] for found in before])
    apart = np.hypot(*(known[:, None] - known[None]).transpose(2, 0, 1))
    np.fill_diagonal(apart, np.inf)
    usual = float(np.median(apart.min(axis=1)))
    nearest = [float(np.hypot(*(known - found.pose[:2]).T).min()) for found in new]
    return sum(_MISREAD_MM < away < _AMONG_SHARE * usual for away in nearest) >= _AMONG_LEAST
