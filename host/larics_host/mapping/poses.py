"""Poses in the plane: (x mm, y mm, heading rad)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

Pose = tuple[float, float, float]
Numbers = Sequence[float] | np.ndarray


def after(pose: Numbers, step: Numbers) -> Pose:
    """A pose that is given in the axes of another, in the axes of that one."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    x, y = pose[0] + cos * step[0] - sin * step[1], pose[1] + sin * step[0] + cos * step[1]
    return float(x), float(y), float(pose[2] + step[2])


def inverse(pose: Numbers) -> Pose:
    """Where the origin is in the axes of a pose."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    x, y = -cos * pose[0] - sin * pose[1], sin * pose[0] - cos * pose[1]
    return float(x), float(y), float(-pose[2])


def between(pose: Numbers, other: Numbers) -> Pose:
    """Another pose in the axes of a pose."""
    return after(inverse(pose), other)


def wrapped(angle: Any) -> Any:
    """An angle, or an array of them, in -pi..pi."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


def axes(heading: float) -> np.ndarray:
    """(3, 3): turns a vector (x, y, rad) by a heading."""
    cos, sin = math.cos(heading), math.sin(heading)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def rigid_fit(source: np.ndarray, target: np.ndarray) -> Pose:
    """The motion that brings points (N, 2) nearest to others: after(motion, source) is target."""
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    angle = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    moved = after((0.0, 0.0, angle), (*source.mean(axis=0), 0.0))
    x, y = target.mean(axis=0) - moved[:2]
    return float(x), float(y), angle
