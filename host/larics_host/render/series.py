"""Frames of a preset, each drawn from (preset, seed, index) alone."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from larics.marker import CODED_ID_MOST, FAMILY_NAMES, ID_COUNT, LARICS3
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.furnish import furnish
from larics_host.render.plates import TARGETS, Plate, printed_family
from larics_host.render.presets import PRESETS
from larics_host.render.scene import Scene
from larics_host.render.sensor import Sensor
from larics_host.render.troubles import Troubles, trouble_plate, trouble_scene, trouble_sensor
from larics_host.render.view import render_view

if TYPE_CHECKING:
    from larics_host.render.presets import Preset
    from larics_host.truth import Truth


OVERRIDES = (
    "contrast",
    "blur_px",
    "defocus_px",
    "tilt_deg",
    "occlusion",
    "line_mm",
    "marker_ids",
    "noise",
    "jpeg",
    "lens",
    "speed_mm_s",
    "exposure_us",
    "family",
)
FAMILIES = (*FAMILY_NAMES, "mixed")


@dataclass
class View:
    """All that `render_view` needs for one frame, as drawn."""

    scene: Scene
    pose: Pose
    motion: Motion
    camera: Camera
    sensor: Sensor
    rng: np.random.Generator = field(repr=False)


def generator(preset: str, *numbers: int) -> np.random.Generator:
    """The random numbers of (preset, seed, index, purpose): independent streams, the same everywhere."""
    return np.random.Generator(np.random.PCG64([zlib.crc32(preset.encode()), *numbers]))


def render_frame(
    preset: str,
    seed: int,
    index: int,
    *,
    width: int = 360,
    height: int = 296,
    radius_px: float = 30.0,
    target: str = "larics",
    **overrides: Any,
) -> tuple[np.ndarray, list[Truth]]:
    """Frame `index` of the series `seed` of a preset.

    radius_px      outer ring of a level marker, drawn within 3 %
    target         "larics", "aruco" or "apriltag": what hangs there, in the same scene
    overrides      contrast (grey levels), blur_px (motion during the exposure), defocus_px (sigma), tilt_deg,
                   occlusion (share of the outer ring hidden), line_mm, marker_ids (sequence to choose from),
                   noise (factor; 0: none), jpeg (quality; 0: none), lens (k1, k2), speed_mm_s, exposure_us,
                   family ("plain"; "coded": the same frame with cells added; "mixed": some of both), which
                   marker_ids overrules
    Returns (frame, truths): (height, width) uint8 and a list of Truth, as render_view does. The same
    arguments give the same bytes, in any process and any order.
    Raises ValueError for an unknown preset, target, override, or a size that is not positive.
    """
    view = draw_view(
        preset, seed, index, width=width, height=height, radius_px=radius_px, target=target, **overrides
    )
    return render_view(
        view.scene,
        view.pose,
        view.motion,
        view.camera,
        view.sensor,
        view.rng,
        name="frame_%06d.pgm" % index,
        time_us=index * 33333,
    )


def draw_camera(name: str, seed: int, width: int, height: int, radius_px: float, lens: Any = None) -> Camera:
    """The camera of a series: its focal length and lens depend on preset and seed alone."""
    rng = generator(name, seed)
    # about 30 degrees of view at a ring of 30 px, wider and narrower within what lenses do
    focal = float(np.clip(20.0 * radius_px, 0.75 * width, 2.2 * width)) * rng.uniform(0.95, 1.05)
    half_diagonal = math.hypot(width, height) / 2 / focal
    # at most 2.5 % of distortion in the corner of a normal lens, more of a wide one
    strength = min(0.01 + 0.1 * half_diagonal**2, 0.08) / half_diagonal**2
    k1 = rng.uniform(-1.0, 0.3) * strength
    k2 = rng.uniform(-0.1, 0.1) * strength / half_diagonal**2
    k1, k2 = lens if lens is not None else (k1, k2)
    camera = Camera(
        width=width,
        height=height,
        focal_px=focal,
        center_x_px=(width - 1) / 2 + rng.uniform(-0.01, 0.01) * width,
        center_y_px=(height - 1) / 2 + rng.uniform(-0.01, 0.01) * height,
        k1=k1,
        k2=k2,
        row_us=rng.uniform(20.0, 40.0),
    )
    span = PRESETS[name].row_us
    return camera if span is None else replace(camera, row_us=rng.uniform(*span))


def draw_sensor(rng: np.random.Generator, preset: Preset) -> Sensor:
    """Light and noise within the ranges of a preset."""
    return Sensor(
        contrast=rng.uniform(*preset.contrast),
        black=rng.uniform(*preset.black),
        read_noise=rng.uniform(*preset.read_noise),
        shot_noise=rng.uniform(*preset.shot_noise),
        vignetting=rng.uniform(*preset.vignetting),
        defocus_px=rng.uniform(*preset.defocus_px),
        jpeg=int(rng.integers(60, 96)) if rng.random() < preset.jpeg_share else 0,
    )


def draw_view(
    name: str,
    seed: int,
    index: int,
    *,
    width: int = 360,
    height: int = 296,
    radius_px: float = 30.0,
    target: str = "larics",
    **overrides: Any,
) -> View:
    """Draw what render_frame renders, with the same arguments; returns a View."""
    if name not in PRESETS:
        raise ValueError("unknown preset %s" % name)
    if target not in TARGETS:
        raise ValueError("unknown target %s" % target)
    if overrides.get("family", "plain") not in FAMILIES:
        raise ValueError("unknown family %s: use one of %s" % (overrides["family"], ", ".join(FAMILIES)))
    unknown = set(overrides) - set(OVERRIDES)
    if unknown:
        raise ValueError("unknown override %s" % sorted(unknown)[0])
    if width < 1 or height < 1 or not radius_px > 0:
        raise ValueError("width, height and radius_px must be positive")
    preset = PRESETS[name]
    get = overrides.get
    layout, furniture, noise = (generator(name, seed, index, purpose) for purpose in (1, 2, 3))

    def draw(span):
        return layout.uniform(*span)

    camera = draw_camera(name, seed, width, height, radius_px, get("lens"))
    drawn = replace(
        camera,
        tilt_deg=draw(preset.tilt_deg),
        tilt_direction_deg=draw((0, 360)),
        exposure_us=draw(preset.exposure_us),
    )
    sensor = draw_sensor(layout, preset)
    speed, direction, turn = draw(preset.speed_mm_s), draw((0, 2 * math.pi)), draw(preset.turn_deg_s)
    ceiling_mm = camera.focal_px * LARICS3.outer_mm10 / 10 / radius_px * draw((0.97, 1.03))
    vehicle = Pose(draw((-5000, 5000)), draw((-5000, 5000)), draw((0, 360)))

    camera = replace(
        drawn, tilt_deg=get("tilt_deg", drawn.tilt_deg), exposure_us=get("exposure_us", drawn.exposure_us)
    )
    if "blur_px" in overrides:
        speed = get("blur_px") * ceiling_mm / camera.focal_px / (camera.exposure_us * 1e-6)
        turn = 0.0
    speed = get("speed_mm_s", speed)
    motion = Motion(speed * math.cos(direction), speed * math.sin(direction), turn)
    factor = get("noise", 1.0)
    sensor = replace(
        sensor,
        contrast=get("contrast", sensor.contrast),
        defocus_px=get("defocus_px", sensor.defocus_px),
        read_noise=sensor.read_noise * factor,
        shot_noise=sensor.shot_noise * factor**2,
        jpeg=get("jpeg", sensor.jpeg),
    )
    extension = _extension(generator(name, seed, index, 4), overrides)
    plates = _draw_plates(
        layout, preset, camera, vehicle, ceiling_mm, radius_px, target, overrides, extension
    )
    scene = Scene(ceiling_mm=ceiling_mm, plates=plates)
    region = _region(camera, ceiling_mm, vehicle)
    furnish(
        scene, furniture, preset, region, view_area_m2(camera, ceiling_mm), sensor.contrast, get("occlusion")
    )
    if preset.troubles is not None:
        sensor = trouble(
            scene, sensor, camera, vehicle, preset.troubles, (name, seed, index), "contrast" in overrides
        )
    return View(scene, vehicle, motion, camera, sensor, noise)


def trouble(
    scene: Scene,
    sensor: Sensor,
    camera: Camera,
    vehicle: Pose,
    troubles: Troubles,
    stream: tuple,
    keep_ink: bool = False,
) -> Sensor:
    """Draw a preset's troubles into a furnished scene and return the Sensor with its own.

    stream  (preset, seed, ...) that the troubles' own random numbers follow from"""
    print_and_light, processor = (generator(*stream, purpose) for purpose in (4, 5))
    scene.plates = tuple(trouble_plate(print_and_light, plate, troubles, keep_ink) for plate in scene.plates)
    heading = math.radians(vehicle.heading_deg)
    cos, sin = math.cos(heading), math.sin(heading)
    ahead, left = camera.offset_x_mm, camera.offset_y_mm
    lens = (vehicle.x_mm + cos * ahead - sin * left, vehicle.y_mm + sin * ahead + cos * left)
    trouble_scene(scene, print_and_light, troubles, lens, sensor.contrast)
    return trouble_sensor(processor, sensor, troubles)


def _region(camera, ceiling_mm, vehicle):
    """The upright box (x0, y0, x1, y1) in the map around what the camera sees."""
    corners = [
        _ceiling_point(camera, ceiling_mm, vehicle, x, y)
        for x in (0, camera.width - 1)
        for y in (0, camera.height - 1)
    ]
    return (*np.min(corners, axis=0), *np.max(corners, axis=0))


def view_area_m2(camera: Camera, ceiling_mm: float) -> float:
    """How much of the ceiling a level camera sees, square metres."""
    return camera.width * camera.height * (ceiling_mm / camera.focal_px) ** 2 * 1e-6


def _ceiling_point(camera, ceiling_mm, vehicle, x_px, y_px):
    """Map position of what the pixel at x, y sees."""
    ray = camera.ray(x_px, y_px)
    scale = ceiling_mm / max(ray[2], 0.05)
    heading = math.radians(vehicle.heading_deg)
    cos, sin = math.cos(heading), math.sin(heading)
    forward, left = scale * ray[0] + camera.offset_x_mm, scale * ray[1] + camera.offset_y_mm
    return vehicle.x_mm + cos * forward - sin * left, vehicle.y_mm + sin * forward + cos * left


def _extension(rng, overrides):
    """Function of a plain ID -> that of the marker to hang: the same lines, with cells where wanted."""
    family = overrides.get("family", "plain")
    if family == "plain" or overrides.get("marker_ids") is not None:
        return lambda marker_id: marker_id

    def extended(marker_id):
        longer = ID_COUNT * int(rng.integers(1, ID_COUNT**3)) + marker_id
        coded = (family == "coded" or rng.random() < 0.5) and longer <= CODED_ID_MOST
        return longer if coded else marker_id + ID_COUNT if family == "coded" else marker_id

    return extended


def _draw_plates(rng, preset, camera, vehicle, ceiling_mm, radius_px, target, overrides, extension):
    plate_ratio = LARICS3.plate_mm10 / LARICS3.outer_mm10
    count = int(rng.integers(preset.markers[0], preset.markers[1] + 1))
    ids = list(overrides.get("marker_ids") or LARICS3.ids())
    if overrides.get("marker_ids") is not None and not len(overrides["marker_ids"]):
        count = 0
    plates, places, used = [], [], set()
    # room is sought for whole plates first, then for whole rings, then for centres
    margins = [plate_ratio * 1.06, 1.1, 0.3]
    for _ in range(count):
        for attempt in range(90):
            margin = margins[attempt // 30] * radius_px + 1
            half_x, half_y = max(camera.width / 2 - margin, 0), max(camera.height / 2 - margin, 0)
            x = (camera.width - 1) / 2 + rng.uniform(-1, 1) * half_x
            y = (camera.height - 1) / 2 + rng.uniform(-1, 1) * half_y
            if preset.place == "border":
                x, y = _border_place(rng, camera, radius_px)
            place = _ceiling_point(camera, ceiling_mm, vehicle, x, y)
            apart = 2.05 * LARICS3.plate_mm10 / 10
            if all(math.dist(place, other) > apart for other in places):
                break
        else:
            continue
        heading, line_mm = rng.uniform(0, 360), rng.uniform(15.0, 20.0)
        # repeated IDs only where there are more markers than IDs to choose from
        left = [marker_id for marker_id in ids if marker_id not in used] or ids
        marker_id = int(left[rng.integers(len(left))])
        used.add(marker_id)
        line_mm10 = int(round(10 * overrides.get("line_mm", line_mm)))
        if target == "larics":
            marker_id = extension(marker_id)
        black = rng.uniform(0.0, 0.04)
        if "contrast" in overrides:
            black = 0.0
        places.append(place)
        family = printed_family(marker_id, line_mm10)
        plates.append(Plate(marker_id, Pose(*place, heading), family, target, 1.0, black))
    return tuple(plates)


def _border_place(rng, camera, radius_px):
    """A centre so near to a side that the plate is cut, at the worst with half of the ring outside."""
    inside = rng.uniform(0.0, 1.6) * radius_px
    along = rng.uniform(0.1, 0.9)
    side = rng.integers(4)
    if side < 2:
        return (inside if side == 0 else camera.width - 1 - inside), along * (camera.height - 1)
    return along * (camera.width - 1), (inside if side == 2 else camera.height - 1 - inside)
