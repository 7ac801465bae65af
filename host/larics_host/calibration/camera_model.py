"""The camera of larics.locate.camera_model in floating point, on whole arrays: for fitting."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from larics_host.calibration import mounting

if TYPE_CHECKING:
    from larics.settings import Settings
    from larics_host.annotations import Numbers


_RIM = np.linspace(0, 2 * math.pi, 36, endpoint=False)
# area of a regular polygon over that of its circle
_POLYGON = math.sin(_RIM[1]) / _RIM[1]
_HEADING_STEP_PX = 0.5


@dataclass(frozen=True)
class CameraModel:
    """Lengths in px, angles in degrees; meaning and conventions as in larics.locate.camera_model."""

    width: int
    height: int
    focal_px: float
    center_px: tuple
    k1: float = 0.0
    k2: float = 0.0
    mount_deg: float = 0.0
    mirrored: bool = False
    tilt_forward_deg: float = 0.0
    tilt_left_deg: float = 0.0

    @property
    def rotation(self) -> np.ndarray:
        """3x3: camera -> vehicle frame."""
        return mounting.rotation(self.mount_deg, self.tilt_forward_deg, self.tilt_left_deg)

    def turned(self, angle_deg: float) -> CameraModel:
        """The same camera turned about the vehicle's vertical axis, its lean with it."""
        mount, forward, left = mounting.angles(mounting.about("z", angle_deg) @ self.rotation)
        return replace(self, mount_deg=mount % 360, tilt_forward_deg=forward, tilt_left_deg=left)

    def plane(self, x_px: Numbers, y_px: Numbers) -> np.ndarray:
        """Where pixels look at, on a level plane one unit above the lens: (..., 2), forward and left."""
        side = -1.0 if self.mirrored else 1.0
        u = side * (np.asarray(x_px, float) - self.center_px[0]) / self.focal_px
        v = (np.asarray(y_px, float) - self.center_px[1]) / self.focal_px
        distorted = np.hypot(u, v)
        radius = distorted.copy()
        for _ in range(12):  # Newton
            square = radius * radius
            error = radius * (1 + square * (self.k1 + square * self.k2)) - distorted
            radius = radius - error / (1 + square * (3 * self.k1 + square * 5 * self.k2))
        scale = np.where(distorted > 0, radius / np.where(distorted > 0, distorted, 1), 1.0)
        rays = np.stack([u * scale, v * scale, np.ones_like(u)], axis=-1) @ self.rotation.T
        return rays[..., :2] / rays[..., 2:]

    def project(self, points: np.ndarray) -> np.ndarray:
        """Pixels (..., 2) of points (..., 2) on that plane."""
        points = np.asarray(points, float)
        rays = np.concatenate([points, np.ones_like(points[..., :1])], axis=-1) @ self.rotation
        flat = rays[..., :2] / rays[..., 2:]
        square = np.sum(flat * flat, axis=-1, keepdims=True)
        flat = flat * (1 + square * (self.k1 + square * self.k2)) * self.focal_px
        side = -1.0 if self.mirrored else 1.0
        return np.stack([self.center_px[0] + side * flat[..., 0], self.center_px[1] + flat[..., 1]], axis=-1)

    def radius_px(self, x_px: Numbers, y_px: Numbers, ring: Numbers) -> np.ndarray:
        """Radius in the image (geometric mean of the axes) of rings centred at these pixels; `ring` is
        their radius over their height above the lens."""
        rim = ring * np.stack([np.cos(_RIM), np.sin(_RIM)], axis=-1)
        pixels = self.project(self.plane(x_px, y_px)[..., None, :] + rim)
        x, y = pixels[..., 0], pixels[..., 1]
        area = np.abs(np.sum(x * np.roll(y, -1, -1) - np.roll(x, -1, -1) * y, axis=-1)) / 2
        return np.sqrt(area / (math.pi * _POLYGON))

    def heading_deg(self, x_px: Numbers, y_px: Numbers, image_deg: Numbers) -> np.ndarray:
        """Direction in the vehicle frame, 0..360, of what has this image angle at these pixels."""
        angle = np.radians(image_deg)
        dx, dy = _HEADING_STEP_PX * np.cos(angle), -_HEADING_STEP_PX * np.sin(angle)
        step = self.plane(x_px + dx, y_px + dy) - self.plane(x_px - dx, y_px - dy)
        return np.degrees(np.arctan2(step[..., 1], step[..., 0])) % 360


def model_of(settings: Settings, width: int, height: int) -> CameraModel:
    """The CameraModel of a larics.settings.Settings for frames of this size. Without a focal length it has
    one that only serves to begin a fit with."""
    center = (
        settings.center_x_q8 / 256 if settings.center_x_q8 else (width - 1) / 2,
        settings.center_y_q8 / 256 if settings.center_y_q8 else (height - 1) / 2,
    )
    return CameraModel(
        width,
        height,
        settings.focal_q8 / 256 or float(max(width, height)),
        center,
        settings.k1_e5 / 1e5,
        settings.k2_e5 / 1e5,
        settings.mount_cdeg / 100,
        settings.mirrored,
        settings.tilt_forward_cdeg / 100,
        settings.tilt_left_cdeg / 100,
    )


def settings_of(model: CameraModel) -> dict[str, Any]:
    """{setting: value} of a model."""
    return {
        "width": model.width,
        "height": model.height,
        "focal_q8": round(model.focal_px * 256),
        "k1_e5": round(model.k1 * 1e5),
        "k2_e5": round(model.k2 * 1e5),
        "mount_cdeg": round(model.mount_deg * 100) % 36000,
        "tilt_forward_cdeg": round(model.tilt_forward_deg * 100),
        "tilt_left_cdeg": round(model.tilt_left_deg * 100),
    }
