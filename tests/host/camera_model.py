"""A camera on a vehicle in floating point: rotation matrices and rays, independent of larics.locate.

The vehicle stands at (x, y, heading) on the map; the camera sits on it and looks up at a ceiling plane.
Used as the oracle of the geometry tests.
"""

import math

import numpy as np


def rotation(axis, angle_deg):
    """Right-handed rotation about "x", "y" or "z"."""
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    return np.array(
        {
            "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
            "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
        }[axis]
    )


# columns: where the camera's x (image right), y (image down) and z (optical axis) point in the vehicle
# frame (x forward, y left, z up) when the camera looks up and the image's top is forward
DEFAULT_MOUNTING = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


class FloatCamera:
    """The model that locate.camera_model approximates; lengths in mm, angles in degrees, focal in px."""

    def __init__(
        self,
        width,
        height,
        focal,
        center=None,
        k1=0.0,
        k2=0.0,
        mount=0.0,
        mirrored=False,
        tilt_forward=0.0,
        tilt_left=0.0,
        position=(0.0, 0.0, 0.0),
    ):
        self.focal, self.k1, self.k2, self.mirrored = focal, k1, k2, mirrored
        self.center = center or ((width - 1) / 2, (height - 1) / 2)
        self.position = np.array(position, float)
        self.to_vehicle = (
            rotation("y", tilt_forward) @ rotation("x", -tilt_left) @ rotation("z", mount) @ DEFAULT_MOUNTING
        )

    def project(self, point):
        """Pixel of a point given in the vehicle frame."""
        ray = self.to_vehicle.T @ (np.asarray(point, float) - self.position)
        u, v = ray[0] / ray[2], ray[1] / ray[2]
        square = u * u + v * v
        lens = 1 + self.k1 * square + self.k2 * square * square
        side = -1 if self.mirrored else 1
        return np.array(
            [self.center[0] + side * self.focal * u * lens, self.center[1] + self.focal * v * lens]
        )

    def view(self, offset_x, offset_y, height, heading_deg, outer=150.0):
        """What a perfect detector reports of a marker in the vehicle frame: x, y, image angle, radius.

        The angle is that of the projected orientation line at the centre; the radius is the geometric
        mean of the axes of the projected outer ring, through its area."""
        centre = np.array([offset_x, offset_y, height])
        along = np.array([math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg)), 0.0])
        pixel = self.project(centre)
        step = (self.project(centre + 0.01 * along) - self.project(centre - 0.01 * along)) / 0.02
        angle = math.degrees(math.atan2(-step[1], step[0])) % 360
        turns = np.radians(np.arange(0, 360, 5.0))
        ring = np.array(
            [self.project(centre + outer * np.array([math.cos(t), math.sin(t), 0])) for t in turns]
        )
        following = np.roll(ring, -1, axis=0)
        area = 0.5 * abs(np.sum(ring[:, 0] * following[:, 1] - following[:, 0] * ring[:, 1]))
        polygon = 36 * math.sin(math.radians(5.0))  # area of the 72-gon in the unit circle
        return pixel[0], pixel[1], angle, math.sqrt(area / polygon)


def turned(offset, heading_deg):
    """A vehicle-frame vector in the map frame, for a vehicle with this heading."""
    return (rotation("z", heading_deg) @ np.array([offset[0], offset[1], 0.0]))[:2]


def angle_difference(a_deg, b_deg):
    """a - b, in -180..180."""
    return (a_deg - b_deg + 180) % 360 - 180
