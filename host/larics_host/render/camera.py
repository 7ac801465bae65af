"""The pin-hole camera under the ceiling: where it looks, how its lens bends rays, when its rows expose.

Frames as in the rest of the product: map and vehicle x, y in mm and counterclockwise seen from above;
image x right, y down, pixel centres at integers. Everything here is float64 and independent of the
integer code of `larics`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from larics_host.annotations import Numbers


LENS_TABLE_SIZE = 1024
# the lens table reaches this far beyond the corner of the frame, for samples just outside it
LENS_TABLE_MARGIN = 1.1


@dataclass(frozen=True)
class Pose:
    """Where a vehicle or a marker is: map position in mm, heading in degrees counterclockwise from x."""

    x_mm: float = 0.0
    y_mm: float = 0.0
    heading_deg: float = 0.0


@dataclass(frozen=True)
class Motion:
    """Constant velocity in the vehicle's own frame and constant turn rate: the vehicle drives an arc."""

    forward_mm_s: float = 0.0
    left_mm_s: float = 0.0
    turn_deg_s: float = 0.0

    def drive(self, pose: Pose, seconds: Numbers) -> tuple[Any, Any, Any]:
        """x, y (mm) and heading (rad) `seconds` after `pose` (negative: before), exact on the arc.

        `seconds` is a number or an array; so are the results.
        """
        half = np.radians(self.turn_deg_s) * np.asarray(seconds, dtype=float) / 2
        chord = seconds * np.sinc(half / math.pi)
        heading = math.radians(pose.heading_deg)
        cos, sin = np.cos(heading + half), np.sin(heading + half)
        x = pose.x_mm + chord * (cos * self.forward_mm_s - sin * self.left_mm_s)
        y = pose.y_mm + chord * (sin * self.forward_mm_s + cos * self.left_mm_s)
        return x, y, heading + 2 * half

    def pose_after(self, pose: Pose, seconds: float) -> Pose:
        """The Pose `seconds` (negative: before) from `pose`."""
        x, y, heading = self.drive(pose, seconds)
        return Pose(float(x), float(y), math.degrees(heading))


@lru_cache(maxsize=16)
def _lens_table(k1, k2, limit):
    """undistorted / distorted radius over the distorted radius squared, 0..limit in equal steps."""
    distorted = np.sqrt(np.linspace(0.0, limit, LENS_TABLE_SIZE))
    radius = distorted.copy()
    for _ in range(30):  # Newton
        square = radius * radius
        error = radius * (1 + square * (k1 + square * k2)) - distorted
        slope = 1 + square * (3 * k1 + square * 5 * k2)
        if np.any(slope <= 0.05):
            raise ValueError("lens distortion k1=%g k2=%g folds over inside the frame" % (k1, k2))
        radius -= error / slope
    table = np.ones(LENS_TABLE_SIZE)
    table[1:] = radius[1:] / distorted[1:]
    return table


@lru_cache(maxsize=16)
def _fold_square(k1, k2):
    """Squared undistorted radius from which the distorted one shrinks again; infinite if it never does."""
    roots = np.roots([5 * k2, 3 * k1, 1.0])
    return min((root.real for root in roots if abs(root.imag) < 1e-12 and root.real > 0), default=math.inf)


@dataclass(frozen=True)
class Camera:
    """A camera that looks up from the vehicle.

    width, height          frame size, px
    focal_px               focal length; a level ring of radius r at height h has focal * r / h px
    center_x_px, center_y_px   principal point; None is the middle of the frame
    k1, k2                 radial lens distortion as in OpenCV: distorted = r (1 + k1 r^2 + k2 r^4)
    mounting_deg           vehicle direction of the image's top, counterclockwise from forward
    tilt_deg, tilt_direction_deg   the optical axis leans from the vertical towards this vehicle direction
    mirrored               the sensor delivers every row from right to left
    offset_x_mm, offset_y_mm   the lens in the vehicle frame
    row_us                 rolling shutter: time from one row to the next; 0 is a global shutter
    exposure_us            how long each row is exposed

    Raises ValueError when the lens polynomial folds over inside the frame.
    """

    width: int = 360
    height: int = 296
    focal_px: float = 600.0
    center_x_px: float = None  # type: ignore[assignment]  # the middle
    center_y_px: float = None  # type: ignore[assignment]
    k1: float = 0.0
    k2: float = 0.0
    mounting_deg: float = 0.0
    tilt_deg: float = 0.0
    tilt_direction_deg: float = 0.0
    mirrored: bool = False
    offset_x_mm: float = 0.0
    offset_y_mm: float = 0.0
    row_us: float = 0.0
    exposure_us: float = 0.0
    # worked out from the others
    rotation: np.ndarray = field(init=False, repr=False, compare=False)
    middle_row: float = field(init=False, repr=False, compare=False)
    lens_step: float = field(init=False, repr=False, compare=False)
    lens_table: np.ndarray = field(init=False, repr=False, compare=False)
    fold_square: float = field(init=False, repr=False, compare=False)

    def __post_init__(self):
        if self.center_x_px is None:
            object.__setattr__(self, "center_x_px", (self.width - 1) / 2)
        if self.center_y_px is None:
            object.__setattr__(self, "center_y_px", (self.height - 1) / 2)
        object.__setattr__(self, "rotation", self._rotation())
        object.__setattr__(self, "middle_row", (self.height - 1) / 2)
        far_x = max(self.center_x_px, self.width - 1 - self.center_x_px) + 2
        far_y = max(self.center_y_px, self.height - 1 - self.center_y_px) + 2
        limit = LENS_TABLE_MARGIN * (far_x**2 + far_y**2) / self.focal_px**2
        object.__setattr__(self, "lens_step", limit / (LENS_TABLE_SIZE - 1))
        object.__setattr__(self, "lens_table", _lens_table(self.k1, self.k2, limit))
        object.__setattr__(self, "fold_square", _fold_square(self.k1, self.k2))

    def _rotation(self):
        """3x3 camera axes (image right, image down, out of the lens) -> vehicle frame."""
        # looking up with the image's top forward: right is the vehicle's left, down is backward
        base = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        mounting = math.radians(self.mounting_deg)
        cos, sin = math.cos(mounting), math.sin(mounting)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        tilt, towards = math.radians(self.tilt_deg), math.radians(self.tilt_direction_deg)
        # Rodrigues' rotation about the horizontal axis at right angles to the lean
        axis = np.array([-math.sin(towards), math.cos(towards), 0.0])
        cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        lean = np.eye(3) + math.sin(tilt) * cross + (1 - math.cos(tilt)) * (cross @ cross)
        return lean @ turn @ base

    def row_seconds(self, y_px: Numbers) -> Any:
        """Mid-exposure time of a row, seconds after that of the middle of the frame."""
        return (y_px - self.middle_row) * self.row_us * 1e-6

    def project(self, points_vehicle: np.ndarray) -> np.ndarray:
        """(N, 3) points in the vehicle frame, mm from the lens -> (N, 2) px; NaN out of its sight."""
        x, y, z = (np.asarray(points_vehicle, dtype=float) @ self.rotation).T
        with np.errstate(divide="ignore", invalid="ignore"):
            z = np.where(z > 0.02 * np.sqrt(x * x + y * y + z * z), z, np.nan)
            x, y = x / z, y / z
        square = x * x + y * y
        # from its fold on the polynomial would lead far points back into the frame
        square = np.where(square < self.fold_square, square, np.nan)
        bend = 1 + square * (self.k1 + square * self.k2)
        sign = -1.0 if self.mirrored else 1.0
        return np.stack(
            [self.center_x_px + sign * self.focal_px * x * bend, self.center_y_px + self.focal_px * y * bend],
            axis=1,
        )

    def ray(self, x_px: float, y_px: float) -> np.ndarray:
        """Direction in the vehicle frame (3 floats, not normalised) of what pixel position x, y sees."""
        sign = -1.0 if self.mirrored else 1.0
        x = sign * (x_px - self.center_x_px) / self.focal_px
        y = (y_px - self.center_y_px) / self.focal_px
        bend = np.interp((x * x + y * y) / self.lens_step, np.arange(LENS_TABLE_SIZE), self.lens_table)
        return self.rotation @ np.array([x * bend, y * bend, 1.0])

    def look_at(self, map_xy: np.ndarray, ceiling_mm: float, pose: Pose) -> np.ndarray:
        """(N, 2) map points on a ceiling `ceiling_mm` above the lens -> (N, 2) px, vehicle at `pose`."""
        return self._look_from(map_xy, ceiling_mm, pose.x_mm, pose.y_mm, math.radians(pose.heading_deg))

    def _look_from(self, map_xy, ceiling_mm, x, y, heading):
        cos, sin = np.cos(heading), np.sin(heading)
        east, north = map_xy[:, 0] - x, map_xy[:, 1] - y
        points = np.empty((len(east), 3))
        points[:, 0] = cos * east + sin * north - self.offset_x_mm
        points[:, 1] = -sin * east + cos * north - self.offset_y_mm
        points[:, 2] = ceiling_mm
        return self.project(points)

    def capture(
        self, map_xy: np.ndarray, ceiling_mm: float, pose: Pose, motion: Motion
    ) -> tuple[np.ndarray, np.ndarray]:
        """Where map points appear in the frame: each as seen at the mid-exposure of the row it falls on.

        map_xy (N, 2) mm; `pose` is the vehicle's at the mid-exposure of the frame's middle. Returns
        (N, 2) px (NaN behind the camera) and the times of those instants, (N) seconds from the middle's.
        """
        map_xy = np.asarray(map_xy, dtype=float)
        pixels = self.look_at(map_xy, ceiling_mm, pose)
        seconds = np.zeros(len(map_xy))
        if self.row_us:
            # a contraction by (image speed * row time), a few percent at most
            for _ in range(10):
                seconds = self.row_seconds(pixels[:, 1])
                pixels = self._look_from(map_xy, ceiling_mm, *motion.drive(pose, seconds))
        return pixels, seconds
