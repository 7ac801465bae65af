"""Rotation centre and mounting angle from a vehicle that turns on the spot, and drives, under a marker.

Seen from the lens, in axes of the vehicle but for a wrong mounting angle, a marker lies at

    offset_i = R(heading_i) m - c

while the vehicle turns: heading_i is the marker's direction, c the lens seen from the rotation centre and
m a constant. That is linear in m and c. Turning says nothing about where forward is, so the mounting
angle needs a straight drive, on which the rotation centre moves forward, or a known direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from larics_host.calibration.spread import bounded, covariance, places_of
from larics_host.errors import UserError
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics_host.annotations import Numbers
    from larics_host.calibration.camera_model import CameraModel
    from larics_host.calibration.observe import Observations


_OUTLIER_MM = 1.0
_NOISE_LEAST_MM = 0.1
_LEAST = 8
_SAME_PLACE_MM, _SAME_PLACE_DEG = 20.0, 10.0
_SPAN_LEAST_DEG = 90.0
_CENTRE_LIMIT_MM = 0.7
_RMS_LIMIT_MM = 4.0
_PATH_LEAST_MM = 150.0
_MOUNT_LIMIT_DEG = 0.1
_BEND_LIMIT_MM = 8.0
_TURN_LIMIT_DEG = 5.0


@dataclass
class Turn:
    """centre_mm: the lens in axes of the model's mounting, seen from the rotation centre; sigma_mm of each;
    residuals_mm (N, 2); span_deg: how far it turned; marker_mm: where the marker is from the centre."""

    centre_mm: np.ndarray
    sigma_mm: float
    marker_mm: np.ndarray
    headings_deg: np.ndarray
    offsets_mm: np.ndarray
    residuals_mm: np.ndarray
    span_deg: float

    @property
    def rms_mm(self) -> float:
        return float(np.sqrt(np.mean(np.sum(self.residuals_mm**2, axis=1))))


@dataclass
class Mount:
    """correction_deg: what the mounting angle has to be turned by; sigma_deg, None where it was given or
    kept; path_mm (N, 2): the rotation centre in the marker's axes, empty without a drive."""

    correction_deg: float
    sigma_deg: float | None
    path_mm: np.ndarray


KEPT = Mount(0.0, None, np.zeros((0, 2)))


def measure(
    observations: Observations, model: CameraModel, height_mm: float
) -> tuple[np.ndarray, np.ndarray]:
    """(offsets from the lens (N, 2) mm, headings deg) of markers at a height above the lens."""
    x, y = observations.x_px, observations.y_px
    return height_mm * model.plane(x, y), model.heading_deg(x, y, observations.heading_deg)


def rotated(vector: Any, angles_deg: Numbers) -> np.ndarray:
    """R(angle) v, for arrays of either: (N, 2), or (2,) for a single angle and vector."""
    c, s = np.cos(np.radians(angles_deg)), np.sin(np.radians(angles_deg))
    x, y = np.asarray(vector, float).T if np.ndim(vector) > 1 else vector
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def _span(headings_deg):
    """The part of the circle that the headings reach over: 360 minus the largest gap."""
    ordered = np.sort(headings_deg % 360)
    gaps = np.diff(np.append(ordered, ordered[0] + 360))
    return 360.0 - float(gaps.max())


def fit_turn(
    observations: Observations, model: CameraModel, height_mm: float, tilt_sigma_deg: float = 0.0
) -> Turn:
    """The Turn of observations of one marker. UserError when they do not determine the centre.

    tilt_sigma_deg: of the model's tilt, each way: a lens that leans moves all that it sees to one side."""
    from scipy.optimize import least_squares

    offsets, headings = measure(observations, model, height_mm)
    span = _span(headings)
    if len(headings) < _LEAST or span < _SPAN_LEAST_DEG:
        raise UserError(
            "a turn of %.0f degrees in %s does not determine the rotation centre: turn the vehicle once "
            "round under a marker, at least %d frames" % (span, counted(len(headings), "frame"), _LEAST)
        )

    def residuals(values):
        return (offsets - rotated(values[:2], headings) + values[2:]).ravel()

    found = least_squares(residuals, np.zeros(4), loss="soft_l1", f_scale=_OUTLIER_MM)
    left = residuals(found.x).reshape(-1, 2)
    spread = max(_NOISE_LEAST_MM, 1.4826 * float(np.median(np.abs(left))))
    where = places_of(np.column_stack([offsets / _SAME_PLACE_MM, headings / _SAME_PLACE_DEG]), 1.0)
    by_place = covariance(found.jac, bounded(left, _OUTLIER_MM).ravel(), np.repeat(where, 2))
    variance = max(
        spread**2 * np.linalg.inv(found.jac.T @ found.jac).diagonal()[2:].max(), by_place.diagonal()[2:].max()
    )
    sigma = math.sqrt(variance + (height_mm * math.radians(tilt_sigma_deg)) ** 2)
    turn = Turn(found.x[2:], sigma, found.x[:2], headings, offsets, left, span)
    if spread > _RMS_LIMIT_MM:
        raise UserError(
            "the marker does not move on a circle (%.1f mm off): the vehicle did not turn on one spot, or "
            "scale and lens are not calibrated" % spread
        )
    if math.sqrt(variance) > _CENTRE_LIMIT_MM:
        raise UserError(
            "these frames leave the rotation centre open by %.1f mm: take more, over a whole turn"
            % math.sqrt(variance)
        )
    return turn


def mount_by_drive(
    observations: Observations, model: CameraModel, height_mm: float, centre_mm: np.ndarray
) -> Mount:
    """The Mount by a straight drive forward under one marker. UserError when it does not determine it."""
    offsets, headings = measure(observations, model, height_mm)
    path = -rotated(offsets + centre_mm, -headings)  # rotation centre in the marker's axes
    middle = path.mean(axis=0)
    _, _, axes = np.linalg.svd(path - middle)
    along = (path - middle) @ axes[0]
    across = (path - middle) @ axes[1]
    forward = np.sign(along[np.argmax(observations.frame)] - along[np.argmin(observations.frame)])
    length = float(np.ptp(along))
    mean_deg = math.degrees(math.atan2(*np.mean(rotated((1.0, 0.0), headings), axis=0)[::-1]))
    turned = float(np.ptp((headings - mean_deg + 180) % 360 - 180))
    if length < _PATH_LEAST_MM or len(path) < 3:
        text = "a drive of %.0f mm in %s does not determine the mounting angle: drive %.0f mm and more"
        raise UserError(text % (length, counted(len(path), "frame"), _PATH_LEAST_MM))
    if turned > _TURN_LIMIT_DEG or float(np.abs(across).max()) > _BEND_LIMIT_MM:
        text = "the drive was not straight: it turned by %.1f degrees and left the line by %.1f mm"
        raise UserError(text % (turned, float(np.abs(across).max())))
    direction = math.degrees(math.atan2(forward * axes[0][1], forward * axes[0][0]))
    spread = max(_NOISE_LEAST_MM, float(np.sqrt(np.mean(across**2))))
    off_deg = (headings - mean_deg + 180) % 360 - 180
    sigma = math.hypot(
        math.degrees(spread / max(1e-9, math.sqrt(float(np.sum(along**2))))),
        float(np.std(off_deg)) / math.sqrt(max(1, len(np.unique(places_of(path, _SAME_PLACE_MM))) - 1)),
    )
    if sigma > _MOUNT_LIMIT_DEG:
        raise UserError("this drive leaves the mounting angle open by %.2f degrees: drive farther" % sigma)
    return Mount(_wrapped(-direction - mean_deg), sigma, path)


def mount_by_facing(turn: Turn, facing_deg: float) -> Mount:
    """The Mount by what the vehicle faced in the first frame: degrees counterclockwise from the direction of
    the marker's orientation line."""
    return Mount(_wrapped(-facing_deg - float(turn.headings_deg[0])), None, np.zeros((0, 2)))


def _wrapped(angle_deg):
    return (angle_deg + 180) % 360 - 180
