"""The field of a drive: markers, light, camera, and what happens on the way.

The published field is three markers with the IDs 3, 4 and 7 that face each other, 3 m above a camera of
360x296 px with a view of 30 degrees. What the publication leaves open is chosen here, and named in
ASSUMED.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from larics_host.calibration import mounting
from larics_host.render import clutter
from larics_host.render.camera import Camera, Pose
from larics_host.render.furnish import furnish
from larics_host.render.plates import Plate, printed_family
from larics_host.render.presets import PRESETS
from larics_host.render.scene import Scene, table
from larics_host.render.sensor import Sensor
from larics_host.render.series import generator, view_area_m2

IDS = (3, 4, 7)
CODED_IDS = (491, 665, 821)  # of larics.marker.far_apart
CEILING_MM = 3000.0
WIDTH, HEIGHT = 360, 296
FOCAL_PX = WIDTH / 2 / math.tan(math.radians(15))
PUBLISHED_RATE_HZ = 2.8

ASSUMED = (
    "the three markers hang at the corners of a triangle with equal sides of 2 m; each orientation line "
    "points to the next marker, and the route is 3-4-7-3",
    "tables 1, 2 and 3 are cloudy, sunny and double speed; double speed is 40 cm/s in sunny light",
    "30 degrees is the horizontal view; square pixels; a ring of 15 cm then has a radius of 33.6 px",
    "the camera leans by 1 degree, sits 60 mm before the rotation centre and has 2 % of lens distortion in "
    "the corner, all of it calibrated",
    "sunny and cloudy are the renderer's presets: 90-170 and 20-40 grey levels of contrast, 3-9 and 33-60 "
    "ms of exposure; the light drifts by 20 % with a period of 40 s",
    "the ceiling around the markers has tiles, lamps and furniture as the presets draw them, among them "
    "rings that are no markers; the published experiment's ceiling may have been kinder",
    "the vehicle has two driven wheels 300 mm apart, 60 ms of delay, 80 ms of lag, 0.3 % of bias and 2 % of "
    "noise on each wheel's speed",
    "the exposure stays as it is, but where the light is switched: there the firmware's control sets it, and "
    "a frame has the exposure that was set two frames before",
    "capture and detection take 15 ms: 3.7 ms are half the readout of 296 rows, and 11 ms are two million "
    "instructions, as counted on an emulated Cortex-M7 for a frame with one marker, at a clock of 480 MHz "
    "and an assumed 2.7 cycles an instruction; then the line of 115200 baud",
    "the vehicle stops below each marker and turns there, as in figure 9",
)


@dataclass(frozen=True)
class Event:
    """Something that happens `at_s` into the drive: kind "push", or "light" with a factor."""

    at_s: float
    kind: str
    forward_mm: float = 0.0
    left_mm: float = 0.0
    turn_deg: float = 0.0
    factor: float = 1.0


@dataclass(frozen=True)
class Condition:
    """One kind of drive.

    preset, speed_mm_s, rate_hz, seconds, side_mm (of the triangle)
    dirty, missing   ID of a marker with stains, and of one that has been taken down
    ids              of the markers, in the order of the route
    events           function (rng, seconds) -> list of Event
    has_exposure_control   the firmware sets exposure and gain; otherwise they stay
    accel_mm_s2, miscalibrated (the settings differ from the camera by what a good calibration leaves)
    """

    summary: str
    preset: str = "sunny"
    speed_mm_s: float = 200.0
    rate_hz: float = 20.0
    seconds: float = 90.0
    side_mm: float = 2000.0
    ids: tuple[int, ...] = IDS
    dirty: int = 0
    missing: int = 0
    events: Callable[..., list[Event]] | None = None
    accel_mm_s2: float = 400.0
    miscalibrated: bool = False
    has_exposure_control: bool = False


def _pushes(rng, seconds):
    return [
        Event(at, "push", rng.uniform(-500, 500), rng.uniform(-500, 500), rng.uniform(-90, 90))
        for at in np.arange(20.0, seconds - 15, 25.0)
    ]


def _switches(_, seconds):
    return [
        Event(at, "light", factor=0.2 if index % 2 == 0 else 1.0)
        for index, at in enumerate(np.arange(10.0, seconds, 10.0))
    ]


_PAPER = Condition("", rate_hz=PUBLISHED_RATE_HZ, seconds=420.0)
_PUBLISHED = {
    "cloudy": replace(_PAPER, summary="cloudy, 20 cm/s, as published", preset="cloudy"),
    "sunny": replace(_PAPER, summary="sunny, 20 cm/s, as published"),
    "double": replace(_PAPER, summary="sunny, 40 cm/s, as published", speed_mm_s=400.0),
}
CODED = "-coded"
CONDITIONS = {
    **_PUBLISHED,
    **{
        name + CODED: replace(one, summary=one.summary + ", coded markers", ids=CODED_IDS)
        for name, one in _PUBLISHED.items()
    },
    "steady": Condition("sunny, 20 cm/s, 20 frames/s"),
    "fast-1": Condition("sunny, 1 m/s", speed_mm_s=1000.0, side_mm=4000.0, accel_mm_s2=1500.0, rate_hz=30.0),
    "fast-2": Condition("sunny, 2 m/s", speed_mm_s=2000.0, side_mm=5000.0, accel_mm_s2=3000.0, rate_hz=30.0),
    "lights": Condition(
        "lights switched every 10 s, to a fifth and back", events=_switches, has_exposure_control=True
    ),
    "dirty": Condition("marker 4 is dirty", dirty=4),
    "missing": Condition("marker 4 has been taken down", missing=4, seconds=160.0),
    "pushed": Condition("robot pushed aside and turned every 25 s", events=_pushes),
    "calibration": Condition(
        "settings off by 0.2 % of focal length, 0.1 and 0.2 degrees", miscalibrated=True
    ),
}


@dataclass
class Field:
    """All that a drive needs, drawn from (condition, seed)."""

    name: str
    condition: Condition
    markers: dict  # ID: (x_mm, y_mm, heading_deg)
    route: tuple
    scene: Scene
    camera: Camera
    sensor: Sensor
    start: Pose
    events: list
    settings: dict
    noise: np.random.Generator = field(repr=False)

    def light(self, time_s: float, exposure_us: float | None = None, gain: float = 1.0) -> Sensor:
        """The sensor in the light of this moment, with an exposure (None: the camera's) and a linear gain."""
        factor = 1.0 + 0.2 * math.sin(2 * math.pi * time_s / 40.0)
        switched = 1.0
        for event in self.events:
            if event.kind == "light" and event.at_s <= time_s:
                switched = event.factor
        amount = factor * switched * gain * (exposure_us or self.camera.exposure_us) / self.camera.exposure_us
        return replace(
            self.sensor,
            contrast=self.sensor.contrast * amount,
            read_noise=self.sensor.read_noise * gain,
            shot_noise=self.sensor.shot_noise * gain,
        )


def triangle(side_mm: float, ids: Sequence[int] = IDS) -> dict[int, tuple[float, float, float]]:
    """{ID: (x_mm, y_mm, heading_deg)}: corners of a triangle, each pointing to the next."""
    radius = side_mm / math.sqrt(3)
    corners = [
        (radius * math.cos(math.radians(a)), radius * math.sin(math.radians(a))) for a in (210, 330, 90)
    ]
    places: dict[int, tuple[float, float, float]] = {}
    for index, marker_id in enumerate(ids):
        x, y = round(corners[index][0]), round(corners[index][1])  # the map has whole millimetres
        ahead = corners[(index + 1) % len(ids)]
        heading = math.degrees(math.atan2(ahead[1] - y, ahead[0] - x)) % 360
        places[marker_id] = (x, y, round(heading, 2))
    return places


def draw_field(name: str, seed: int) -> Field:
    """The Field of CONDITIONS[name]; the same for the same seed."""
    condition = CONDITIONS[name]
    layout, furniture, noise, fate = (generator("drive-" + name, seed, purpose) for purpose in (1, 2, 3, 4))
    preset = PRESETS[condition.preset]
    markers = triangle(condition.side_mm, condition.ids)
    half_diagonal_square = (WIDTH**2 + HEIGHT**2) / 4 / FOCAL_PX**2
    camera = Camera(
        width=WIDTH,
        height=HEIGHT,
        focal_px=FOCAL_PX,
        k1=-0.02 / half_diagonal_square,
        tilt_deg=1.0,
        tilt_direction_deg=layout.uniform(0, 360),
        offset_x_mm=60.0,
        row_us=25.0,
        exposure_us=layout.uniform(*preset.exposure_us),
    )
    # the middle of the preset's ranges, so that one drive stands for the condition
    middle = {
        key: (getattr(preset, key)[0] + getattr(preset, key)[1]) / 2
        for key in ("contrast", "black", "read_noise", "shot_noise", "vignetting", "defocus_px")
    }
    plates = tuple(
        Plate(marker_id, Pose(*place), printed_family(marker_id, 175))
        for marker_id, place in markers.items()
        if marker_id != condition.missing
    )
    scene = Scene(ceiling_mm=CEILING_MM, plates=plates)
    reach = condition.side_mm / math.sqrt(3) + 1500.0
    furnish(
        scene,
        furniture,
        preset,
        (-reach, -reach, reach, reach),
        view_area_m2(camera, CEILING_MM),
        middle["contrast"],
    )
    if condition.dirty:
        x, y, _ = markers[condition.dirty]
        stains = table(clutter.draw_dirt(furniture, x, y, plates[0].radius_mm, 40))
        scene.shades = np.concatenate([scene.shades, stains]) if len(scene.shades) else stains
    first = markers[condition.ids[0]]
    angle = layout.uniform(0, 2 * math.pi)
    start = Pose(first[0] + 250 * math.cos(angle), first[1] + 250 * math.sin(angle), layout.uniform(0, 360))
    return Field(
        name,
        condition,
        markers,
        (*condition.ids, condition.ids[0]),
        scene,
        camera,
        Sensor(**middle),
        start,
        condition.events(fate, condition.seconds) if condition.events else [],
        camera_settings(camera, markers, condition),
        noise,
    )


# how well a calibration that is off by so much knows itself to be
_WRONG_BY = {
    "focal_sigma_ppm": 2000,
    "mount_sigma_cdeg": 10,
    "tilt_sigma_cdeg": 20,
    "camera_sigma_mm10": 10,
}


def camera_settings(
    camera: Camera, markers: dict[int, tuple[float, float, float]], condition: Condition
) -> dict[str, Any]:
    """The settings of the firmware for this camera and field."""
    off = 1.0 if condition.miscalibrated else 0.0
    mount_deg, forward_deg, left_deg = mounting.angles(camera.rotation)
    radius_px = camera.focal_px * 150.0 / CEILING_MM
    return {
        "focal_q8": round(camera.focal_px * (1 + 0.002 * off) * 256),
        "center_x_q8": round(camera.center_x_px * 256),
        "center_y_q8": round(camera.center_y_px * 256),
        "k1_e5": round(camera.k1 * 1e5),
        "k2_e5": round(camera.k2 * 1e5),
        "mount_cdeg": round((mount_deg + 0.1 * off) * 100) % 36000,
        "tilt_forward_cdeg": round((forward_deg + 0.2 * off) * 100),
        "tilt_left_cdeg": round(left_deg * 100),
        "camera_x_mm10": round((camera.offset_x_mm + off) * 10),
        "camera_y_mm10": round(camera.offset_y_mm * 10),
        "ceiling_mm10": round(CEILING_MM * 10),
        "row_ns": round(camera.row_us * 1000),
        **(_WRONG_BY if condition.miscalibrated else {}),
        "radius_min_px": int(radius_px * 0.85),
        "radius_max_px": math.ceil(radius_px * 1.15),
        "max_speed_mm_s": int(condition.speed_mm_s),
        "exposure_us": round(camera.exposure_us),
        "route": [*condition.ids, condition.ids[0]],
        "map": [
            [marker_id, x, y, round(heading * 100) % 36000, 0, 0]
            for marker_id, (x, y, heading) in markers.items()
        ],
    }
