"""A first map: parts that logs tell of by themselves, laid over each other where they agree.

A part is a drive with its places, or a group of markers that frames showed together. Where each ID stands
once, an ID seen elsewhere than most of the time is set aside; with repeated IDs, it is another marker.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from larics_host.errors import UserError
from larics_host.mapping.association import OVERLAP_MM, Found, places_of, shares_of
from larics_host.mapping.collect import Collected
from larics_host.mapping.links import Place
from larics_host.mapping.passages import Drive
from larics_host.mapping.poses import Pose, after, inverse, rigid_fit, wrapped
from larics_host.mapping.seams import seam
from larics_host.mapping.wheels import SHARES, Leg, Way

_AGREE_MM, _AGREE_SHARE, _AGREE_RAD = 600.0, 0.02, 0.3  # and so much of the distance
_CONFLICT_MM = 400.0  # two IDs so near each other cannot be
_SURE = 2  # passages; more are no misread marker
_LOUDER = (1.0, 4.0)  # a wheel that slipped early is no reason to take a drive for lost
_TRIED = 400  # ways to lay one part over another


@dataclass
class Part:
    """items [(ID, pose, weight)]; drive with founds, one an item, or numbers of the collected places."""

    items: list
    drive: Drive | None = None
    way: Way | None = None
    founds: list = field(default_factory=list)
    shares: np.ndarray = field(default_factory=lambda: np.zeros(SHARES))
    numbers: list = field(default_factory=list)

    @property
    def weight(self) -> int:
        return sum(item[2] for item in self.items)

    def frames(self) -> np.ndarray:
        assert self.drive is not None
        return np.array([passage.frame for passage in self.drive.passages])

    def legs(self, shares: np.ndarray) -> list[Leg]:
        """The Legs from each passage of the drive to the next."""
        assert self.drive is not None and self.way is not None
        passages = self.drive.passages
        leaving, entries = [one.leaving for one in passages[:-1]], [one.entry for one in passages[1:]]
        return self.way.legs(self.frames(), shares, leaving, entries)


@dataclass
class Group:
    """Parts laid over each other: poses {number: (x mm, y mm, rad)}; parts [(Part, motion into the group's
    axes, {index of its item: number})]."""

    poses: dict[int, Pose] = field(default_factory=dict)
    parts: list[tuple[Part, Pose, dict[int, int]]] = field(default_factory=list)


@dataclass
class Layout:
    """places {number: Place} and the groups that nothing ties to each other, the largest first."""

    places: dict[int, Place]
    groups: list[Group]


def layout(collected: Collected, noise: float, lengths: Sequence[tuple[int, int, float]] = ()) -> Layout:
    """The Layout of what was collected; noise: of the wheels, see wheels; lengths: [(ID, ID, mm)] that are
    known. UserError where a drive lost itself."""
    parts = [_driven(drive, collected.repeats, noise, lengths) for drive in collected.drives]
    parts += _seen_together(collected)
    waiting = sorted((part for part in parts if part.items), key=lambda part: -part.weight)
    places: dict[int, Place] = {}
    groups = []
    while waiting:
        group = Group()
        _join(group, waiting.pop(0), (0.0, 0.0, 0.0), {}, places, collected)
        joined = True
        while joined:
            joined = False
            for part in waiting:
                laid = _overlay(group, part, places, collected.repeats)
                if laid:
                    motion, same = laid
                    _join(group, part, motion, same, places, collected)
                    waiting.remove(part)
                    joined = True
                    break
        groups.append(group)
    groups.sort(key=lambda group: (-len(group.poses), min(group.poses)))
    return Layout(places, groups)


def _driven(drive, repeats, noise, lengths):
    way = Way(drive.stretch.x_mm, drive.stretch.y_mm, drive.stretch.heading)
    shares, sigma = shares_of(drive, way, noise)
    part = Part([], drive, way, shares=shares)
    lost = None
    for louder in _LOUDER:
        founds = places_of(drive, part.legs(shares), sigma, louder * noise)
        lost = seam(founds)
        if lost is None:
            break
    if lost is not None:
        metres = way.driven_mm[drive.passages[lost].frame] / 1000
        raise UserError(
            "a drive does not make one map: after %.0f m it meets the same markers again in other places; "
            "was the vehicle carried, or did it slip far? Drive anew, or begin a new log there" % metres
        )
    kept = _apart(founds, repeats)
    if not repeats:
        kept = _one_each(kept, lengths)
    part.founds = kept
    part.items = [(found.id, tuple(found.pose), len(found.passages)) for found in kept]
    return part


def _one_each(founds, lengths):
    """Of each ID the one that was passed most often; of several such, that which the lengths fit best."""
    by_id = defaultdict(list)
    for found in founds:
        by_id[found.id].append(found)
    for same in by_id.values():
        most = max(len(found.passages) for found in same)
        same[:] = [found for found in same if len(found.passages) == most]
    for a, b, mm in lengths:
        for one, other in ((a, b), (b, a)):
            if by_id[one] and len(by_id[other]) == 1:
                there = by_id[other][0].pose[:2]
                by_id[one].sort(key=lambda found: abs(math.dist(found.pose[:2], there) - mm))
    return [found for found in founds if by_id[found.id][0] is found]


def _apart(founds, repeats):
    """Without those that lie where another ID, read more often, has its plate. Where IDs do not repeat, one
    that is as often read elsewhere counts less."""
    total = Counter(found.id for found in founds for _ in found.passages)

    def weight(found):
        return len(found.passages), 0 if repeats else len(found.passages) - total[found.id]

    kept: list[Found] = []
    for found in sorted(founds, key=weight, reverse=True):
        near = (
            math.dist(found.pose[:2], other.pose[:2]) < OVERLAP_MM for other in kept if other.id != found.id
        )
        if len(found.passages) > _SURE or not any(near):
            kept.append(found)
    return sorted(kept, key=lambda one: one.passages[0])


def _seen_together(collected):
    for numbers in _groups(len(collected.places), collected.links):
        poses = _spread(numbers, collected.links)
        items = [(collected.places[k].id, poses[k], collected.places[k].seen) for k in numbers]
        if len(numbers) > 1 or collected.places[numbers[0]].seen:
            yield Part(items, numbers=numbers)


def _groups(count, links):
    """Numbers that links tie together."""
    parent = list(range(count))

    def root(k):
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    for a, b in links:
        parent[root(a)] = root(b)
    groups = defaultdict(list)
    for k in range(count):
        groups[root(k)].append(k)
    return list(groups.values())


def _spread(group, links):
    """First poses of a group, from its first marker outwards along the links with the most readings."""
    poses = {group[0]: (0.0, 0.0, 0.0)}
    while len(poses) < len(group):
        ready = [(len(r), a, b) for (a, b), r in links.items() if (a in poses) != (b in poses)]
        _, a, b = max((count, a, b) for count, a, b in ready if a in group)
        x, y, heading = np.median(links[a, b], axis=0)
        step = (x, y, math.radians(heading))
        if a in poses:
            poses[b] = after(poses[a], step)
        else:
            poses[a] = after(poses[b], inverse(step))
    return poses


def _join(group, part, motion, same, places, collected):
    """Takes a part into a group; same {index of its item: number of a place that is there already}."""
    numbers = dict(same)
    for index, (_, pose, _) in enumerate(part.items):
        if index not in numbers:
            number = len(places)
            places[number] = Place(number)
            numbers[index] = number
            group.poses[number] = after(motion, pose)
        place = places[numbers[index]]
        if part.drive is None:
            told = collected.places[part.numbers[index]]
            place.votes += told.votes
            place.heights_mm += told.heights_mm
        else:
            for k in part.founds[index].passages:
                place.votes[part.drive.passages[k].id] += part.drive.passages[k].seen
                place.heights_mm.append(part.drive.passages[k].height_mm)
    group.parts.append((part, motion, numbers))


def _overlay(group, part, places, repeats):
    """(motion, {index of an item: number}) by which a part lies over a group; None where that is not
    certain."""
    there = [(number, places[number].id, pose) for number, pose in group.poses.items()]
    pairs = [(pose, item[1]) for _, marker_id, pose in there for item in part.items if item[0] == marker_id]
    common = {marker_id for _, marker_id, _ in there} & {item[0] for item in part.items}
    best = None
    for pose, own in pairs[:: -(-len(pairs) // _TRIED) or 1]:
        motion = after(pose, inverse(own))
        same, conflicts = _agreeing(there, part.items, motion, pose)
        if best is None or len(same) - conflicts > best[0]:
            best = len(same) - conflicts, motion, same
    if best is None or best[0] < (2 if repeats or len(common) > 1 else 1):
        return None
    _, motion, same = best
    if len(same) > 1:
        own = np.array([part.items[k][1][:2] for k in same])
        theirs = np.array([group.poses[number][:2] for number in same.values()])
        motion = rigid_fit(own, theirs)
    if not repeats:  # an ID names its marker wherever the first sight of it puts it
        by_id = {marker_id: number for number, marker_id, _ in there}
        same = {k: by_id[item[0]] for k, item in enumerate(part.items) if item[0] in by_id}
    return motion, same


def _agreeing(there, items, motion, centre):
    same, conflicts = {}, 0
    for index, (marker_id, own, _) in enumerate(items):
        x, y, heading = after(motion, own)
        limit = _AGREE_MM + _AGREE_SHARE * math.dist((x, y), centre[:2])
        near = [(math.dist((x, y), pose[:2]), number, other, pose) for number, other, pose in there]
        fit = [
            (away, number)
            for away, number, other, pose in near
            if other == marker_id and away < limit and abs(wrapped(pose[2] - heading)) < _AGREE_RAD
        ]
        if fit:
            same[index] = min(fit)[1]
        elif any(away < _CONFLICT_MM for away, *_ in near):
            conflicts += 1
    return same, conflicts
