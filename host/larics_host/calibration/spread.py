"""Standard deviations of fitted values that do not take repeated views for independent ones.

What is wrong in one place of the picture (a lens that the model misses, the same pixels, one pose) is wrong
in all that was measured there, so residuals count by place: the covariance is that of leaving one place out
after the other (the jackknife over clusters, CR3 of MacKinnon, Nielsen and Webb, J. Econometrics 232, 2023),
which also covers how far the values hang on single places.
"""

from __future__ import annotations

import numpy as np


def places_of(points: np.ndarray, near: float) -> np.ndarray:
    """A number for each of the points (N, D), the same for those within `near` of the first of a place."""
    firsts: list[np.ndarray] = []
    numbers = np.zeros(len(points), int)
    for index, point in enumerate(np.asarray(points, float)):
        apart = [float(np.max(np.abs(point - first))) for first in firsts]
        nearest = int(np.argmin(apart)) if apart else -1
        if nearest < 0 or apart[nearest] > near:
            nearest = len(firsts)
            firsts.append(point)
        numbers[index] = nearest
    return numbers


def bounded(residuals: np.ndarray, scale: float) -> np.ndarray:
    """Residuals with the weight that the loss soft_l1 of this scale gives them."""
    return residuals / np.sqrt(1 + (residuals / scale) ** 2)


def covariance(jacobian: np.ndarray, residuals: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Covariance (P, P) of the P values fitted to residuals (N,) with this jacobian (N, P).

    places: for each residual the number of its place. Infinite where one place alone determines a value."""
    jacobian, places = np.asarray(jacobian, float), np.asarray(places)
    normal = jacobian.T @ jacobian
    scale = 1 / np.sqrt(np.maximum(np.diag(normal), 1e-300))  # values differ by orders of magnitude
    jacobian = jacobian * scale
    normal = jacobian.T @ jacobian
    numbers = np.unique(places)
    total = np.zeros_like(normal)
    for number in numbers:
        mine = places == number
        left = normal - jacobian[mine].T @ jacobian[mine]
        if np.linalg.cond(left) > 1e12:
            return np.full_like(normal, np.inf)
        moved = np.linalg.solve(left, jacobian[mine].T @ residuals[mine])
        total += np.outer(moved, moved)
    if len(numbers) < 2:
        return np.full_like(normal, np.inf)
    return (len(numbers) - 1) / len(numbers) * total * np.outer(scale, scale)
