"""Places of markers that agree with all that was seen of them together, and with given distances.

Unknown are x, y and heading of each marker but one; a link says where its second marker lies in the axes
of the first, and the other way round. Least squares with soft-L1 loss, so that what a wrong reading
claims counts linearly, not squared. Groups of markers that no link ties together are tied by distances
where three or more determine how the groups lie to each other.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from larics_host.calibration.spread import bounded, covariance
from larics_host.errors import UserError
from larics_host.mapping.links import turn, wrapped

if TYPE_CHECKING:
    from larics_host.annotations import MarkerPose
    from larics_host.mapping.links import Links


_SIGMA_MM, _SIGMA_DEG = 2.0, 0.15  # of a link's reading
_DISTANCE_SIGMA_MM = 3.0
_TIE_LIMIT_MM = 30.0  # rms of the distances that tie two groups
_TIE_STARTS = 8
_PASSES = 6  # parts that the readings of a link are cut into, in their order


@dataclass
class Built:
    """poses {number: (x mm, y mm, heading deg)} of the markers that are tied together; sigmas_mm {number:
    standard deviation of the place against the first marker}; untied: groups of numbers that are not;
    link_rms_mm: what the readings differ by from the result; notes for the user."""

    poses: dict
    sigmas_mm: dict
    untied: list
    link_rms_mm: float
    notes: list = field(default_factory=list)


def build(links: Links, distances: Iterable[tuple[int, int, float]] = ()) -> Built:
    """The Built of links.Links; distances: [(number, number, mm)]. UserError when no two markers are tied."""
    groups = _groups(len(links.places), links.links)
    poses = {}
    for group in groups:
        poses.update(_spread(group, links.links))
    notes: list[str] = []
    main = list(groups[0])
    waiting = [group for group in groups[1:]]
    tied = True
    while tied:
        tied = False
        for group in waiting:
            between = [
                d for d in distances if (d[0] in main) != (d[1] in main) and {d[0], d[1]} <= {*main, *group}
            ]
            moved = _tie(group, main, poses, between, links, notes)
            if moved:
                poses.update(moved)
                main += group
                waiting.remove(group)
                tied = True
                break
    if len(main) < 2:
        raise UserError(
            "no two markers were seen in one frame often enough: drive so that neighbours are in view "
            "together, or give distances"
        )
    inside = [d for d in distances if d[0] in main and d[1] in main]
    return _adjust(main, links.links, inside, poses, waiting, notes)


def _groups(count, links):
    """Numbers that links tie together, the largest group first."""
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
    return sorted(groups.values(), key=lambda group: (-len(group), group[0]))


def _spread(group, links):
    """First poses of a group, from its first marker outwards along the links with the most readings."""
    poses = {group[0]: (0.0, 0.0, 0.0)}
    while len(poses) < len(group):
        ready = [(len(r), a, b) for (a, b), r in links.items() if (a in poses) != (b in poses)]
        _, a, b = max((count, a, b) for count, a, b in ready if a in group)
        x, y, heading = np.median(links[a, b], axis=0)
        if a in poses:
            poses[b] = _after(poses[a], (x, y, heading))
        else:
            back = turn(-x, -y, -heading)
            poses[a] = _after(poses[b], (*back, -heading))
    return poses


def _after(pose, step):
    dx, dy = turn(step[0], step[1], pose[2])
    return pose[0] + dx, pose[1] + dy, wrapped(pose[2] + step[2])


def _tie(group, main, poses, distances, links, notes):
    """The group's poses in the axes of the main one by distances between the two; None if not determined."""
    from scipy.optimize import least_squares

    if not distances:
        return None
    names = ", ".join(str(links.places[k].id) for k in group)
    pairs = [(a, b, mm) if a in main else (b, a, mm) for a, b, mm in distances]
    if len({pair[:2] for pair in pairs}) < 3 or len({b for _, b, _ in pairs}) < 2:
        notes.append("marker %s: tying it takes three distances, to two markers of its group" % names)
        return None

    def moved(values):
        return {k: _after((values[0], values[1], values[2]), poses[k]) for k in group}

    def residuals(values):
        new = moved(values)
        return [math.dist(poses[a][:2], new[b][:2]) - mm for a, b, mm in pairs]

    centre = np.mean([poses[a][:2] for a, _, _ in pairs], axis=0)
    reach = np.mean([mm for _, _, mm in pairs])
    found = []
    for k in range(_TIE_STARTS):
        for angle in range(0, 360, 90):
            side = turn(reach, 0.0, 360.0 * k / _TIE_STARTS)
            begin = (centre[0] + side[0], centre[1] + side[1], float(angle))
            solution = least_squares(residuals, begin, method="lm", x_scale=(100.0, 100.0, 10.0))
            found.append((math.sqrt(2 * solution.cost / len(pairs)), solution.x))
    found.sort(key=lambda one: one[0])
    best = moved(found[0][1])
    if found[0][0] > _TIE_LIMIT_MM:
        notes.append("marker %s: the distances contradict each other by %.0f mm" % (names, found[0][0]))
        return None
    for rms, values in found:
        other = moved(values)
        apart = max(math.dist(best[k][:2], other[k][:2]) for k in group)
        if rms < max(_DISTANCE_SIGMA_MM, 3 * found[0][0]) and apart > 100:
            notes.append("marker %s: the distances allow two places: give one more" % names)
            return None
    return best


def _adjust(main, links, distances, poses, untied, notes):
    from scipy.optimize import least_squares

    index = {number: k for k, number in enumerate(main)}
    pairs = [(a, b) for a, b in links if a in index and b in index]
    first = np.concatenate([np.full(len(links[p]), index[p[0]]) for p in pairs])
    second = np.concatenate([np.full(len(links[p]), index[p[1]]) for p in pairs])
    read = np.concatenate([links[p] for p in pairs])
    back = np.stack(_turned(-read[:, 0], -read[:, 1], -read[:, 2]), axis=1)
    ends = [(index[a], index[b], mm) for a, b, mm in distances]
    start = np.array([poses[number] for number in main])

    def poses_of(values):
        return np.concatenate([start[:1], values.reshape(-1, 3)])

    def apart(all_poses):
        """(N, 5): both ways' places in mm, and the heading in deg, that the readings are off by."""
        a, b = all_poses[first], all_poses[second]
        dx, dy = b[:, 0] - a[:, 0], b[:, 1] - a[:, 1]
        ahead = np.stack(_turned(dx, dy, -a[:, 2]), axis=1) - read[:, :2]
        behind = np.stack(_turned(-dx, -dy, -b[:, 2]), axis=1) - back
        heading = wrapped(b[:, 2] - a[:, 2] - read[:, 2])
        return np.column_stack([ahead, behind, heading])

    def residuals(values):
        all_poses = poses_of(values)
        off = apart(all_poses) / (math.sqrt(2) * _SIGMA_MM)
        off[:, 4] *= math.sqrt(2) * _SIGMA_MM / _SIGMA_DEG
        given = [
            (math.dist(all_poses[a][:2], all_poses[b][:2]) - mm) / _DISTANCE_SIGMA_MM for a, b, mm in ends
        ]
        return np.concatenate([off.ravel(), given])

    pattern = _pattern(first, second, ends, len(main))
    found = least_squares(residuals, start[1:].ravel(), loss="soft_l1", jac_sparsity=pattern)
    result = poses_of(found.x)
    jacobian = found.jac.toarray() if hasattr(found.jac, "toarray") else found.jac
    by_reading = np.diag(np.linalg.pinv(jacobian.T @ jacobian))
    passes = np.concatenate([np.repeat(_passes(links, pairs), 5), len(read) + np.arange(len(ends))])
    by_pass = np.diag(covariance(jacobian, bounded(residuals(found.x), 1.0), passes))
    spread = np.sqrt(np.where(np.isfinite(by_pass), np.maximum(by_reading, by_pass), by_reading))
    spread = spread.reshape(-1, 3)
    sigmas = {number: float(np.hypot(*spread[k - 1, :2])) if k else 0.0 for number, k in index.items()}
    rms = float(np.sqrt(np.mean(apart(result)[:, :2] ** 2)))
    placed = {number: (*result[k, :2], result[k, 2] % 360) for number, k in index.items()}
    return Built(placed, sigmas, untied, rms, notes)


def _passes(links, pairs):
    """For each reading the number of the part of the drive that it comes from: readings one after the other
    share their errors."""
    numbers = []
    for index, pair in enumerate(pairs):
        count = len(links[pair])
        numbers.append(index * _PASSES + np.arange(count) * min(_PASSES, count) // count)
    return np.concatenate(numbers)


def _pattern(first, second, ends, count):
    """Which residual depends on which unknown: five residuals a reading, one a distance; the first marker
    of `count` is fixed."""
    from scipy.sparse import coo_matrix

    rows = [np.repeat(np.arange(5 * len(first)), 3)] * 2
    markers = [np.repeat(first, 15), np.repeat(second, 15)]
    for side in (0, 1):
        rows.append(np.repeat(5 * len(first) + np.arange(len(ends)), 3))
        markers.append(np.repeat([end[side] for end in ends], 3).astype(int))
    rows, markers = np.concatenate(rows), np.concatenate(markers)
    columns = 3 * (markers - 1) + np.arange(len(rows)) % 3
    free = markers > 0
    shape = (5 * len(first) + len(ends), 3 * (count - 1))
    return coo_matrix((np.ones(free.sum(), int), (rows[free], columns[free])), shape)


def _turned(x, y, angle_deg):
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return c * x - s * y, s * x + c * y


def anchored(poses: dict[int, MarkerPose], number: int, anchor: MarkerPose) -> dict[int, MarkerPose]:
    """The poses moved and turned as a whole, so that one of them is `anchor` (x mm, y mm, heading deg)."""
    x, y, heading = poses[number]
    angle = anchor[2] - heading
    moved = {}
    for key, pose in poses.items():
        dx, dy = turn(pose[0] - x, pose[1] - y, angle)
        moved[key] = (anchor[0] + dx, anchor[1] + dy, (pose[2] + angle) % 360)
    return moved
