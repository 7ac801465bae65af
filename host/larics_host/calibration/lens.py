"""Focal length, tilt and distortion from the sizes in which rings of known size appear.

A ring of radius R at height H above the lens, centred at a pixel, has an image whose area the camera's
model gives; the measured centre says where, the measured radius how large. The vehicle's place and
direction, which are unknown in every frame, drop out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from larics_host.calibration.camera_model import CameraModel
from larics_host.calibration.spread import bounded, covariance, places_of
from larics_host.errors import UserError
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics_host.calibration.observe import Observations


SCALE = ("focal_px",)
LENS = ("focal_px", "tilt_forward_deg", "tilt_left_deg", "k1")

# what a fit may at most leave open (standard deviation), and how it is named
_LIMITS = {
    "focal_px": (0.002, "the focal length", "%"),
    "tilt_forward_deg": (0.1, "the tilt", "deg"),
    "tilt_left_deg": (0.1, "the tilt", "deg"),
    "k1": (0.02, "the lens distortion k1", ""),
    "k2": (0.1, "the lens distortion k2", ""),
}
_STEPS = {"tilt_forward_deg": 1.0, "tilt_left_deg": 1.0, "k1": 0.1, "k2": 0.1}
_OUTLIER_PX = 0.1
# no detection is better than this, however well a few of them agree
_NOISE_LEAST_PX = 0.005
# what all radii of a camera are off by alike, as light and line width have it: no frame of it shows that
_COMMON_PX = 0.02
_LEAST = 3
_SAME_PLACE = 0.2  # of a ring's radius: centres nearer than that show the same pixels


@dataclass
class LensFit:
    """model; sigmas {parameter: standard deviation}; residuals: measured minus predicted radius, px."""

    model: CameraModel
    sigmas: dict
    residuals_px: np.ndarray

    @property
    def rms_px(self) -> float:
        return float(np.sqrt(np.mean(self.residuals_px**2)))


def fit(
    observations: Observations, model: CameraModel, free: Sequence[str], height_mm: float, outer_mm: float
) -> LensFit:
    """Fits the parameters named by `free` to the radii.

    height_mm: markers above the lens;  outer_mm: radius of their outer ring
    Raises UserError when the observations do not determine every one of them.
    """
    from scipy.optimize import least_squares

    seen = observations
    if len(seen.x_px) < max(_LEAST, 2 * len(free)):
        text = "%s seen, too few for %s: take more frames, with the marker everywhere"
        raise UserError(text % (counted(len(seen.x_px), "marker"), counted(len(free), "unknown")))
    start = model.focal_px
    if "focal_px" in free:  # begin near the answer: the model in use may be none at all
        start = float(np.median(seen.radius_px)) * height_mm / outer_mm

    def made(values):
        changes = {name: value * _STEPS.get(name, start) for name, value in zip(free, values, strict=True)}
        return replace(model, **changes)

    def residuals(values):
        predicted = made(values).radius_px(seen.x_px, seen.y_px, outer_mm / height_mm)
        return np.nan_to_num(seen.radius_px - predicted, nan=1e3, posinf=1e3, neginf=-1e3)

    begin = [1.0 if name == "focal_px" else getattr(model, name) / _STEPS[name] for name in free]
    found = least_squares(residuals, begin, loss="soft_l1", f_scale=_OUTLIER_PX, x_scale="jac")
    left = residuals(found.x)
    fitted = made(found.x)
    radius_px = float(np.median(seen.radius_px))
    where = places_of(np.column_stack([seen.x_px, seen.y_px]), _SAME_PLACE * radius_px)
    sigmas = _sigmas(found.jac, left, free, start, where)
    _refuse(fitted, sigmas, free, left, radius_px)
    if "focal_px" in sigmas:
        sigmas["focal_px"] = math.hypot(sigmas["focal_px"], fitted.focal_px * _COMMON_PX / radius_px)
    return LensFit(fitted, sigmas, left)


def _sigmas(jacobian, residuals, free, start, where):
    spread = max(_NOISE_LEAST_PX, 1.4826 * float(np.median(np.abs(residuals))))
    # a singular system has infinite deviations instead of an exception
    values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
    with np.errstate(divide="ignore"):
        variances = (vectors**2) @ (1 / np.maximum(values, 1e-300))
    by_place = np.diag(covariance(jacobian, bounded(residuals, _OUTLIER_PX), where))
    return {
        name: float(np.sqrt(max(spread**2 * variance, other)) * _STEPS.get(name, start))
        for name, variance, other in zip(free, variances, by_place, strict=True)
    }


def _refuse(model, sigmas, free, residuals, radius_px):
    for name in free:
        limit, text, unit = _LIMITS[name]
        sigma = sigmas[name] / model.focal_px if name == "focal_px" else sigmas[name]
        if not sigma <= limit:
            shown = "%.2g %s" % (100 * sigma, unit) if unit == "%" else "%.2g %s" % (sigma, unit)
            raise UserError(
                "these frames do not determine %s (+-%s): take more, with the marker in all corners "
                "of the picture" % (text, shown.strip())
            )
    share = float(np.median(np.abs(residuals))) / radius_px
    if share > 0.01:
        raise UserError(
            "the rings' sizes do not fit one height and size (%.1f %% apart): are all markers alike, at one "
            "height, and flat?" % (100 * share)
        )
