"""The tree of frames (REP 105: map -> odom -> base_link): which transform is told, and by whom.

A frame has one parent. So either map -> base_link is told (nobody knows odometry), or map -> odom, and
odom -> base_link is told by whoever has the odometry: the vehicle's own node, or this program from what the
vehicle sent to the camera (MOTION).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from larics.wire import messages as m
from larics_host.errors import report_once
from larics_host.ros.topics import BASE, ODOM, TREE, Names, Output, header

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

Pose2 = tuple[float, float, float]  # x m, y m, angle rad

_UNKNOWN_VARIANCE = 1e6  # m^2 or rad^2: as good as not measured, for filters that have no word for it
_KEPT = 8  # frames
_LATE = (
    "the vehicle's odometry came after the first pose: %s -> %s is told on; --tf tree or odom chooses before"
)


def quaternion(angle_rad: float) -> dict[str, float]:
    """A turn around z, of the two that tell it the one with w >= 0."""
    angle_rad = math.remainder(angle_rad, 2 * math.pi)
    return {"z": math.sin(angle_rad / 2), "w": math.cos(angle_rad / 2)}


def compose(first: Pose2, second: Pose2) -> Pose2:
    """`second`, told in the frame `first`, in the frame that `first` is told in."""
    c, s = math.cos(first[2]), math.sin(first[2])
    x, y, angle = second
    return first[0] + c * x - s * y, first[1] + s * x + c * y, first[2] + angle


def inverse(pose: Pose2) -> Pose2:
    """The frame that `pose` is told in, told in `pose`."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return -c * pose[0] - s * pose[1], s * pose[0] - c * pose[1], -pose[2]


def place_of(fields: Any) -> Pose2:
    """Of a record with x_mm10, y_mm10 and heading_cdeg."""
    return fields.x_mm10 / 1e4, fields.y_mm10 / 1e4, math.radians(fields.heading_cdeg / 100)


def covariance(fields: Any) -> list[float]:
    """The 6 x 6 covariance of a POSE record (x, y, z, about x, y, z): the vehicle drives on a plane, so z and
    the tilts are not measured; nor is a sigma that is not known."""
    values = [0.0] * 36
    for index in range(6):
        values[7 * index] = _UNKNOWN_VARIANCE
    if m.SIGMA_UNKNOWN not in (fields.sigma_x_mm10, fields.sigma_y_mm10):
        sigma_x, sigma_y = fields.sigma_x_mm10 / 1e4, fields.sigma_y_mm10 / 1e4
        values[0], values[7] = sigma_x**2, sigma_y**2
        values[1] = values[6] = fields.correlation_q14 / 16384 * sigma_x * sigma_y
    if fields.sigma_cdeg != m.SIGMA_UNKNOWN:
        values[35] = math.radians(fields.sigma_cdeg / 100) ** 2
    return values


def transform(stamp_ns: int, parent: str, child: str, place: Pose2) -> dict[str, Any]:
    """A geometry_msgs/TransformStamped in the plane."""
    return {
        "header": header(stamp_ns, parent),
        "child_frame_id": child,
        "transform": {"translation": {"x": place[0], "y": place[1]}, "rotation": quaternion(place[2])},
    }


def camera_transform(stamp_ns: int, names: Names, settings: Mapping[str, Any]) -> dict[str, Any]:
    """base_link -> camera by the settings of mounting (see larics.locate.camera_model for the rotation)."""
    half = math.radians(settings["mount_cdeg"] / 100 + 90) / 2
    turn = (0.0, 0.0, math.sin(half), math.cos(half))
    left = math.radians(-settings["tilt_left_cdeg"] / 100) / 2
    forward = math.radians(settings["tilt_forward_cdeg"] / 100) / 2
    tilts = _product(
        (0.0, math.sin(forward), 0.0, math.cos(forward)), (math.sin(left), 0.0, 0.0, math.cos(left))
    )
    x, y, z, w = _product(tilts, turn)
    return {
        "header": header(stamp_ns, names.base),
        "child_frame_id": names.camera,
        "transform": {
            "translation": {axis: settings["camera_%s_mm10" % axis] / 1e4 for axis in "xyz"},
            "rotation": {"x": x, "y": y, "z": z, "w": w},
        },
    }


def _product(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


class Tree:
    """Tells transforms from POSE and MOTION records of the same frame, in whichever order they come.

    mode: of topics.MODES; None: `with_odometry` where odometry comes with the first pose, else BASE; and then
    for good, since a frame whose parent changes has two.
    """

    def __init__(self, names: Names, mode: str | None, with_odometry: str = TREE) -> None:
        self.mode = mode
        self._names = names
        self._with_odometry = with_odometry
        self._odometry = False  # whether the camera has been told any
        self._first: tuple[Any, int, int] | None = None  # the first pose, while its odometry may still come
        self._poses: dict[int, Pose2] = {}
        self._motions: dict[int, Pose2] = {}

    def pose(self, fields: Any, stamp_ns: int, ahead_ns: int = 0) -> Iterator[Output]:
        """Of a POSE that is not LOST. ahead_ns: by how much map -> odom is told for later than it was
        measured."""
        if self.mode is None:
            if self._first is None and not self._odometry:
                self._first = fields, stamp_ns, ahead_ns
                return
            self.mode = self._with_odometry if self._odometry else BASE
            if self._first is not None:
                yield from self.pose(*self._first)
        if self.mode == BASE:
            yield self._told(stamp_ns, self._names.map, self._names.base, place_of(fields))
        elif self.mode in (ODOM, TREE):
            _keep(self._poses, fields.frame, place_of(fields))
            yield from self._correction(fields.frame, stamp_ns + ahead_ns)

    def motion(self, fields: Any, stamp_ns: int, ahead_ns: int = 0) -> Iterator[Output]:
        """Of a MOTION."""
        if self.mode == BASE and not self._odometry:
            report_once(self, _LATE % (self._names.map, self._names.base))
        self._odometry = True
        if self.mode is None and self._first is not None:
            self.mode = self._with_odometry
            yield from self.pose(*self._first)
        if fields.state == m.MOTION_NONE:
            return
        if self.mode in (ODOM, TREE):
            _keep(self._motions, fields.frame, place_of(fields))
            if self.mode == TREE:
                yield self._told(stamp_ns, self._names.odom, self._names.base, place_of(fields))
            yield from self._correction(fields.frame, stamp_ns + ahead_ns)

    def _correction(self, frame, stamp_ns):
        if frame in self._poses and frame in self._motions:
            place = compose(self._poses.pop(frame), inverse(self._motions.pop(frame)))
            yield self._told(stamp_ns, self._names.map, self._names.odom, place)

    def _told(self, stamp_ns, parent, child, place):
        value = {"transforms": [transform(stamp_ns, parent, child, place)]}
        return Output("/tf", "tf2_msgs/TFMessage", value, stamp_ns)


def _keep(places, frame, place):
    places[frame] = place
    while len(places) > _KEPT:
        del places[next(iter(places))]
