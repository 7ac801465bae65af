"""A drive: a vehicle follows a path under several markers, and its camera takes pictures at a steady rate."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from larics.marker import LARICS3
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.furnish import furnish
from larics_host.render.plates import Plate, printed_family
from larics_host.render.presets import PRESETS
from larics_host.render.scene import Scene
from larics_host.render.sensor import Sensor
from larics_host.render.series import draw_camera, draw_sensor, generator, trouble, view_area_m2
from larics_host.render.view import render_view

if TYPE_CHECKING:
    from larics_host.truth import Truth


CURVE_RADIUS_MM = 2500.0
SHAPES = ("straight", "curve")
# how far from the path, and from its direction, a marker may hang
ASIDE_MM, ASKEW_DEG = 120.0, 10.0


@dataclass(frozen=True)
class Path:
    """A chain of arcs: (length mm, curvature 1/mm; positive turns left), from `start` on."""

    start: Pose
    arcs: tuple

    @property
    def length_mm(self) -> float:
        """Length of all arcs."""
        return sum(length for length, _ in self.arcs)

    def at(self, distance_mm: float) -> tuple[Pose, float]:
        """(Pose, curvature) at a distance along the path; beyond its end it goes on as it ended."""
        pose = self.start
        for index, (length, curvature) in enumerate(self.arcs):
            last = index == len(self.arcs) - 1
            # one mm a second makes seconds of millimetres
            motion = Motion(1.0, 0.0, math.degrees(curvature))
            if distance_mm <= length or last:
                return motion.pose_after(pose, distance_mm), curvature
            pose = motion.pose_after(pose, length)
            distance_mm -= length
        raise ValueError("a path needs an arc")


@dataclass
class Drive:
    """All of a drive; `frame(index)` may be called in any order and always gives the same."""

    preset: str
    seed: int
    scene: Scene
    path: Path
    camera: Camera
    sensor: Sensor
    speed_mm_s: float
    rate_hz: float

    @property
    def frames(self) -> int:
        """How many frames the whole path takes."""
        return int(self.path.length_mm / self.speed_mm_s * self.rate_hz) + 1

    def frame(self, index: int) -> tuple[np.ndarray, list[Truth]]:
        """(frame, truths) of frame `index`; see render_view."""
        pose, curvature = self.path.at(index * self.speed_mm_s / self.rate_hz)
        motion = Motion(self.speed_mm_s, 0.0, math.degrees(curvature * self.speed_mm_s))
        return render_view(
            self.scene,
            pose,
            motion,
            self.camera,
            self.sensor,
            generator(self.preset, self.seed, index, 3),
            name="frame_%06d.pgm" % index,
            time_us=int(round(index * 1e6 / self.rate_hz)),
        )


def draw_drive(
    name: str,
    seed: int,
    *,
    shape: str = "straight",
    marker_ids: Sequence[int] = (1, 2, 3, 4, 5),
    spacing_mm: float = 1500.0,
    speed_mm_s: float | None = None,
    rate_hz: float = 30.0,
    width: int = 360,
    height: int = 296,
    radius_px: float = 30.0,
    target: str = "larics",
) -> Drive:
    """A Drive in the light of preset `name`, under the markers in this order, one each `spacing_mm`.

    shape   "straight", or "curve": an S of wide bends
    Each marker points along the path, a little askew and aside; speed None is the preset's.
    Raises ValueError for an unknown preset or shape, and for numbers that are not positive.
    """
    if name not in PRESETS:
        raise ValueError("unknown preset %s" % name)
    if shape not in SHAPES:
        raise ValueError("unknown shape %s" % shape)
    preset = PRESETS[name]
    layout, furniture = generator(name, seed, 1), generator(name, seed, 2)
    speed_mm_s = layout.uniform(*preset.speed_mm_s) if speed_mm_s is None else speed_mm_s
    if min(speed_mm_s, rate_hz, spacing_mm, radius_px, width, height) <= 0:
        raise ValueError("speed, rate, spacing and sizes must be positive")
    camera = replace(
        draw_camera(name, seed, width, height, radius_px),
        tilt_deg=layout.uniform(*preset.tilt_deg),
        tilt_direction_deg=layout.uniform(0, 360),
        exposure_us=layout.uniform(*preset.exposure_us),
    )
    sensor = draw_sensor(layout, preset)
    ceiling_mm = camera.focal_px * LARICS3.outer_mm10 / 10 / radius_px
    path = _draw_path(shape, spacing_mm * len(marker_ids))
    plates = []
    for index, marker_id in enumerate(marker_ids):
        pose, _ = path.at((index + 0.5) * spacing_mm)
        left = math.radians(pose.heading_deg + 90)
        aside = layout.uniform(-ASIDE_MM, ASIDE_MM)
        place = (pose.x_mm + aside * math.cos(left), pose.y_mm + aside * math.sin(left))
        heading = (pose.heading_deg + layout.uniform(-ASKEW_DEG, ASKEW_DEG)) % 360
        family = printed_family(int(marker_id), int(layout.integers(150, 201)))
        plates.append(Plate(int(marker_id), Pose(*place, heading), family, target))
    scene = Scene(ceiling_mm=ceiling_mm, plates=tuple(plates))
    points = [path.at(distance)[0] for distance in np.linspace(0, path.length_mm, 200)]
    around = math.hypot(width, height) / 2 * ceiling_mm / camera.focal_px
    region = (
        min(pose.x_mm for pose in points) - around,
        min(pose.y_mm for pose in points) - around,
        max(pose.x_mm for pose in points) + around,
        max(pose.y_mm for pose in points) + around,
    )
    furnish(scene, furniture, preset, region, view_area_m2(camera, ceiling_mm), sensor.contrast)
    if preset.troubles is not None:
        # low lamps stand where they are mirrored to the vehicle when it is under the path's middle
        middle, _ = path.at(path.length_mm / 2)
        sensor = trouble(scene, sensor, camera, middle, preset.troubles, (name, seed))
    return Drive(name, seed, scene, path, camera, sensor, speed_mm_s, rate_hz)


def _draw_path(shape, length_mm):
    start = Pose(0.0, 0.0, 0.0)
    if shape == "straight":
        return Path(start, ((length_mm, 0.0),))
    # left for a quarter of the way, right for a half, left again
    bend = 1 / max(CURVE_RADIUS_MM, length_mm / 4)
    return Path(start, ((length_mm / 4, bend), (length_mm / 2, -bend), (length_mm / 4, bend)))
