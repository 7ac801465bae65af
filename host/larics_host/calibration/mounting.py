"""A camera's rotation matrix and the three angles by which larics.locate.camera_model knows it."""

from __future__ import annotations

import math

import numpy as np


def about(axis: str, angle_deg: float) -> np.ndarray:
    """3x3 right-handed rotation about "x", "y" or "z"."""
    cos, sin = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    if axis == "x":
        return np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])
    if axis == "y":
        return np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
    return np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])


# looking up with the image's top forward: image right is the vehicle's left, image down is backward
LEVEL = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def rotation(mount_deg: float, tilt_forward_deg: float, tilt_left_deg: float) -> np.ndarray:
    """Camera axes (image right, image down, out of the lens) -> vehicle frame."""
    return about("y", tilt_forward_deg) @ about("x", -tilt_left_deg) @ about("z", mount_deg) @ LEVEL


def angles(matrix: np.ndarray) -> tuple[float, float, float]:
    """(mount, tilt forward, tilt left) in degrees of a rotation; the inverse of `rotation`."""
    axis = matrix[:, 2]
    left = math.asin(max(-1.0, min(1.0, axis[1])))
    forward = math.atan2(axis[0], axis[2])
    tilt = about("y", math.degrees(forward)) @ about("x", -math.degrees(left))
    turned = tilt.T @ matrix @ LEVEL.T
    return math.degrees(math.atan2(turned[1, 0], turned[0, 0])), math.degrees(forward), math.degrees(left)
