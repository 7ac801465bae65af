"""The presets: what kinds of ceilings, light and driving there are, and one frame drawn from them."""

import math
import zlib
from dataclasses import dataclass, field, replace

import numpy as np

from larics.marker import LARICS3, Family
from larics_host.render import clutter
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.kernels import BOX, ROD
from larics_host.render.plates import TARGETS, Plate
from larics_host.render.scene import Scene, item, table
from larics_host.render.sensor import Sensor
from larics_host.render.view import render_view

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
)


@dataclass(frozen=True)
class Preset:
    """Ranges (low, high) that a frame is drawn from; shares are probabilities, counts inclusive.

    contrast, black, read_noise, shot_noise, vignetting, defocus_px   see Sensor
    exposure_us, speed_mm_s, turn_deg_s, tilt_deg
    markers        how many; place: "inside", or "border" to be cut off by the frame
    circles, straight   pieces of furniture in a view of one square metre
    lamp_share     that there are lamps, `lamp_grey` how bright; share of frames with glare (a bright patch
                   on the plate), a shadow anywhere, the edge of one on the plate, dirt, something in the way
    jpeg_share     that the frame went through JPEG of a quality of 60 to 95
    """

    summary: str
    contrast: tuple = (90.0, 170.0)
    black: tuple = (15.0, 50.0)
    read_noise: tuple = (0.6, 1.2)
    shot_noise: tuple = (0.004, 0.012)
    vignetting: tuple = (0.05, 0.35)
    defocus_px: tuple = (0.3, 0.8)
    exposure_us: tuple = (3000.0, 9000.0)
    speed_mm_s: tuple = (150.0, 220.0)
    turn_deg_s: tuple = (-8.0, 8.0)
    tilt_deg: tuple = (0.0, 2.0)
    markers: tuple = (1, 1)
    place: str = "inside"
    circles: tuple = (0, 2)
    straight: tuple = (0, 2)
    decoys: tuple = (0, 0)
    lamp_share: float = 0.3
    lamp_grey: tuple = (200.0, 600.0)
    glare: float = 0.0
    shadow: float = 0.3
    edge: float = 0.0
    dirt: float = 0.1
    block: float = 0.0
    jpeg_share: float = 0.3


SUNNY = Preset("daylight: high contrast, short exposure, 20 cm/s")
CLOUDY = replace(
    SUNNY,
    summary="dim light: 20-40 grey levels of contrast, 33-60 ms exposure, 20 cm/s",
    contrast=(20.0, 40.0),
    black=(15.0, 45.0),
    read_noise=(1.0, 1.6),
    shot_noise=(0.015, 0.04),
    exposure_us=(33000.0, 60000.0),
    lamp_share=0.1,
)
PRESETS = {
    "sunny": SUNNY,
    "cloudy": CLOUDY,
    "double": replace(SUNNY, summary="daylight at 40 cm/s", speed_mm_s=(380.0, 420.0)),
    "fast": replace(
        SUNNY,
        summary="150 cm/s with 2-4 ms exposure",
        contrast=(60.0, 130.0),
        read_noise=(0.9, 1.5),
        shot_noise=(0.008, 0.02),
        exposure_us=(2000.0, 4000.0),
        speed_mm_s=(1400.0, 1600.0),
        turn_deg_s=(-20.0, 20.0),
    ),
    "harsh": replace(
        SUNNY,
        summary="lamps on the marker, 3-10 degrees of tilt, shadows, things in the way, dirt, low light",
        contrast=(35.0, 110.0),
        black=(10.0, 50.0),
        read_noise=(1.0, 2.0),
        shot_noise=(0.01, 0.035),
        vignetting=(0.1, 0.5),
        defocus_px=(0.4, 1.1),
        exposure_us=(5000.0, 25000.0),
        tilt_deg=(3.0, 10.0),
        circles=(0, 3),
        straight=(0, 3),
        lamp_share=0.5,
        glare=0.5,
        shadow=0.7,
        edge=0.5,
        dirt=0.7,
        block=0.35,
        jpeg_share=0.5,
    ),
    "multi": replace(SUNNY, summary="two to four markers", markers=(2, 4)),
    "border": replace(SUNNY, summary="the marker is cut off by the border of the frame", place="border"),
    "negative": replace(
        SUNNY,
        summary="cluttered ceilings without a marker, decoys included",
        contrast=(20.0, 170.0),
        read_noise=(0.6, 2.0),
        shot_noise=(0.004, 0.035),
        exposure_us=(2000.0, 30000.0),
        tilt_deg=(0.0, 6.0),
        markers=(0, 0),
        circles=(1, 6),
        straight=(0, 5),
        decoys=(0, 2),
        lamp_share=0.5,
        shadow=0.5,
    ),
}


@dataclass
class View:
    """All that `render_view` needs for one frame, as drawn."""

    scene: Scene
    pose: Pose
    motion: Motion
    camera: Camera
    sensor: Sensor
    rng: np.random.Generator = field(repr=False)


def generator(preset, *numbers):
    """The random numbers of (preset, seed, index, purpose): independent streams, the same everywhere."""
    return np.random.Generator(np.random.PCG64([zlib.crc32(preset.encode()), *numbers]))


def render_frame(preset, seed, index, *, width=360, height=296, radius_px=30.0, target="larics", **overrides):
    """Frame `index` of the series `seed` of a preset.

    radius_px      outer ring of a level marker, drawn within 3 %
    target         "larics", "aruco" or "apriltag": what hangs there, in the same scene
    overrides      contrast (grey levels), blur_px (motion during the exposure), defocus_px (sigma), tilt_deg,
                   occlusion (share of the outer ring hidden), line_mm, marker_ids (sequence to choose from),
                   noise (factor; 0: none), jpeg (quality; 0: none), lens (k1, k2), speed_mm_s, exposure_us
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


def draw_camera(name, seed, width, height, radius_px, lens=None):
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
    return Camera(
        width=width,
        height=height,
        focal_px=focal,
        center_x_px=(width - 1) / 2 + rng.uniform(-0.01, 0.01) * width,
        center_y_px=(height - 1) / 2 + rng.uniform(-0.01, 0.01) * height,
        k1=k1,
        k2=k2,
        row_us=rng.uniform(20.0, 40.0),
    )


def draw_view(name, seed, index, *, width=360, height=296, radius_px=30.0, target="larics", **overrides):
    """Draw what render_frame renders, with the same arguments; returns a View."""
    if name not in PRESETS:
        raise ValueError("unknown preset %s" % name)
    if target not in TARGETS:
        raise ValueError("unknown target %s" % target)
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
    sensor = Sensor(
        contrast=draw(preset.contrast),
        black=draw(preset.black),
        read_noise=draw(preset.read_noise),
        shot_noise=draw(preset.shot_noise),
        vignetting=draw(preset.vignetting),
        defocus_px=draw(preset.defocus_px),
        jpeg=int(layout.integers(60, 96)) if layout.random() < preset.jpeg_share else 0,
    )
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
    plates = _draw_plates(layout, preset, camera, vehicle, ceiling_mm, radius_px, target, overrides)
    under = (camera, vehicle, ceiling_mm)
    scene = _draw_scene(furniture, preset, *under, sensor.contrast, plates, get("occlusion"))
    return View(scene, vehicle, motion, camera, sensor, noise)


def _ceiling_point(camera, ceiling_mm, vehicle, x_px, y_px):
    """Map position of what the pixel at x, y sees."""
    ray = camera.ray(x_px, y_px)
    scale = ceiling_mm / max(ray[2], 0.05)
    heading = math.radians(vehicle.heading_deg)
    cos, sin = math.cos(heading), math.sin(heading)
    forward, left = scale * ray[0] + camera.offset_x_mm, scale * ray[1] + camera.offset_y_mm
    return vehicle.x_mm + cos * forward - sin * left, vehicle.y_mm + sin * forward + cos * left


def _draw_plates(rng, preset, camera, vehicle, ceiling_mm, radius_px, target, overrides):
    plate_ratio = LARICS3.plate_mm10 / LARICS3.outer_mm10
    count = int(rng.integers(preset.markers[0], preset.markers[1] + 1))
    ids = list(overrides.get("marker_ids") or LARICS3.ids())
    if overrides.get("marker_ids") is not None and not len(overrides["marker_ids"]):
        count = 0
    plates, places = [], []
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
        used = {plate.marker_id for plate in plates}
        left = [marker_id for marker_id in ids if marker_id not in used] or ids
        marker_id = int(left[rng.integers(len(left))])
        line_mm10 = int(round(10 * overrides.get("line_mm", line_mm)))
        family = Family(line_mm10=line_mm10, allow_id0=marker_id == 0)
        black = rng.uniform(0.0, 0.04)
        if "contrast" in overrides:
            black = 0.0
        places.append(place)
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


def _draw_scene(rng, preset, camera, vehicle, ceiling_mm, contrast, plates, occlusion):
    corners = [
        _ceiling_point(camera, ceiling_mm, vehicle, x, y)
        for x in (0, camera.width - 1)
        for y in (0, camera.height - 1)
    ]
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    region = (*low, *high)
    view_m2 = camera.width * camera.height * (ceiling_mm / camera.focal_px) ** 2 * 1e-6
    # the region is the upright box around a turned view
    share = (high[0] - low[0]) * (high[1] - low[1]) * 1e-6 / view_m2

    # larger views hold more, but not without end
    density = share * min(max(view_m2 / 2, 0.7), 4.0)

    def count(span):
        return int(round(rng.integers(span[0], span[1] + 1) * density))

    surface = clutter.draw_surface(rng)
    keep_out = np.array([(p.pose.x_mm, p.pose.y_mm, p.radius_mm + 5) for p in plates]).reshape(-1, 3)
    objects = clutter.draw_furniture(
        rng, region, count(preset.circles), count(preset.straight), count(preset.decoys), keep_out
    )
    lamps, shades, occluders = [], [], []
    if rng.random() < preset.lamp_share:
        radiance = rng.uniform(*preset.lamp_grey) / contrast
        lamps += clutter.draw_lamps(rng, region, int(rng.integers(1, 3)), radiance, keep_out)
    if rng.random() < preset.shadow:
        shades += clutter.draw_shadows(rng, region, int(rng.integers(1, 4)))
    for plate in plates:
        x, y, radius = plate.pose.x_mm, plate.pose.y_mm, plate.radius_mm
        if rng.random() < preset.dirt:
            shades += clutter.draw_dirt(rng, x, y, radius, int(rng.integers(2, 14)))
        if rng.random() < preset.edge:
            shades += clutter.draw_shadows(rng, (x - radius, y - radius, x + radius, y + radius), 1)
        if rng.random() < preset.glare:
            lamps.append(clutter.draw_glare(rng, x, y, rng.uniform(0, 330), rng.uniform(0.2, 2.5)))
        direction = rng.uniform(0, 2 * math.pi)
        if occlusion:
            occluders.append(_cover(plate, occlusion, direction))
        elif rng.random() < preset.block:
            occluders.append(_thing_in_the_way(rng, x, y, radius, direction))
    return Scene(ceiling_mm, surface, plates, objects, table(occluders), table(shades), table(lamps))


def _cover(plate, share, direction):
    """A board whose edge hides this share of the outer ring."""
    half = 2000.0
    away = plate.ring_mm * math.cos(math.pi * min(share, 1.0)) + half
    where = (plate.pose.x_mm + away * math.cos(direction), plate.pose.y_mm + away * math.sin(direction))
    return item(BOX, *where, half, half, angle=direction, value=0.5)


def _thing_in_the_way(rng, x, y, radius, direction):
    """A cable, a pipe or the corner of a board that hides a part of the plate."""
    kind = rng.integers(3)
    value = rng.uniform(0.05, 0.9)
    if kind < 2:
        half = rng.uniform(2, 6) if kind == 0 else rng.uniform(8, 25)
        away = rng.uniform(0, 1.0) * radius
        where = (x + away * math.cos(direction), y + away * math.sin(direction))
        across = direction + math.pi / 2
        return item(ROD, *where, 3000, half, angle=across, value=value, extra=rng.uniform(-0.3, 0.3))
    away = rng.uniform(0.45, 1.0) * radius + 600
    where = (x + away * math.cos(direction), y + away * math.sin(direction))
    return item(BOX, *where, 600, rng.uniform(60, 600), angle=direction, value=value)
