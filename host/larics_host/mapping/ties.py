"""Groups of markers that nothing seen ties together, tied by distances measured by hand."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from larics_host.mapping.graph import DISTANCE_SIGMA_MM
from larics_host.mapping.poses import Pose, after

_LIMIT_MM = 30.0  # rms of the distances that tie two groups
_STARTS = 8


def tie(
    group: Sequence[int],
    main: Sequence[int],
    poses: dict[int, Pose],
    distances: Sequence[tuple[int, int, float]],
    names: str,
    notes: list[str],
) -> dict[int, Pose] | None:
    """The group's poses in the axes of the main one by distances (number, number, mm) between the two; None,
    and a line added to notes, if they do not determine it. names: the group's markers, for people."""
    from scipy.optimize import least_squares

    if not distances:
        return None
    pairs = [(a, b, mm) if a in main else (b, a, mm) for a, b, mm in distances]
    if len({pair[:2] for pair in pairs}) < 3 or len({b for _, b, _ in pairs}) < 2:
        notes.append("marker %s: tying it takes three distances, to two markers of its group" % names)
        return None

    def moved(values):
        return {k: after((values[0], values[1], values[2]), poses[k]) for k in group}

    def residuals(values):
        new = moved(values)
        return [math.dist(poses[a][:2], new[b][:2]) - mm for a, b, mm in pairs]

    centre = np.mean([poses[a][:2] for a, _, _ in pairs], axis=0).tolist()
    reach = float(np.mean([mm for _, _, mm in pairs]))
    found = []
    for k in range(_STARTS):
        for quarter in range(4):
            side = after((*centre, 2 * math.pi * k / _STARTS), (reach, 0.0, 0.0))
            begin = (*side[:2], quarter * math.pi / 2)
            solution = least_squares(residuals, begin, method="lm", x_scale=(100.0, 100.0, 0.2))
            found.append((math.sqrt(2 * solution.cost / len(pairs)), solution.x))
    found.sort(key=lambda one: one[0])
    best = moved(found[0][1])
    if found[0][0] > _LIMIT_MM:
        notes.append("marker %s: the distances contradict each other by %.0f mm" % (names, found[0][0]))
        return None
    for rms, values in found:
        other = moved(values)
        apart = max(math.dist(best[k][:2], other[k][:2]) for k in group)
        if rms < max(DISTANCE_SIGMA_MM, 3 * found[0][0]) and apart > 100:
            notes.append("marker %s: the distances allow two places: give one more" % names)
            return None
    return best
