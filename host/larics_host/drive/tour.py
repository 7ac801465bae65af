"""What the tour of the README works on: a small hall that one camera drives through, and its calibration.

The folder gets `drive`, frames there and back under three markers of which two are in view at a time, with
their truth and the camera's settings, for `simulate --desk` and `validate`; `places`, `turn` and `ahead`, the
three recordings that `larics calibrate` asks for; and `clip.bin`, the drive's begin as a board records it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from larics_host.calibration import mounting
from larics_host.compilation import told
from larics_host.connection.camera_settings import write_file
from larics_host.drive.desk import SAVED
from larics_host.errors import UserError
from larics_host.images.frame_folder import frame_name, make_folder, refuse_beside, write_frame
from larics_host.images.openmv_stream import write_stream
from larics_host.progress import watched
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.plates import Plate
from larics_host.render.scene import Scene, Surface
from larics_host.render.sensor import Sensor
from larics_host.render.view import render_view
from larics_host.truth import TruthWriter

CEILING_MM = 2750.0  # above the lens
RATE_HZ = 15
SPEED_MM_S = 240.0
SEED = 5012
CLIP_FRAMES = 30
# the marker of the middle hangs a little askew, as real ones do
MARKERS = ((3, Pose(0.0, 40.0, 0.0)), (5, Pose(700.0, -30.0, 4.0)), (6, Pose(1400.0, 20.0, 358.0)))
CAMERA = Camera(
    focal_px=550.0,
    center_x_px=181.0,
    center_y_px=146.5,
    k1=-0.06,
    tilt_deg=0.8,
    tilt_direction_deg=70.0,
    mounting_deg=3.0,
    exposure_us=4000.0,
)
SENSOR = Sensor(contrast=120.0, black=30.0, read_noise=0.8, shot_noise=0.006, defocus_px=0.5)
_SURFACE = Surface(reflectance=0.72, tile_mm=(625.0, 625.0), tile_angle=0.1, joint_mm=8.0, speckle=0.03)


def _vehicle_below(x_px, y_px, heading_deg):
    """The pose at which the marker in the map's origin appears at a pixel."""
    ray = CAMERA.ray(x_px, y_px)
    x, y = (CEILING_MM * ray[k] / ray[2] for k in (0, 1))
    cos, sin = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
    return Pose(-(cos * x - sin * y), -(sin * x + cos * y), heading_deg)


def calibration_poses() -> dict[str, list[Pose]]:
    """{folder: vehicle poses}: one marker all over the picture, a turn on the spot, a straight drive."""
    grid = [(x, y) for y in (60, 104, 148, 192, 236) for x in (60, 120, 180, 240, 300)]
    start = _vehicle_below(190, 150, 0.0)
    ahead = Motion(1.0)
    begin = _vehicle_below(180, 148, 20.0)
    return {
        "places": [_vehicle_below(x, y, 37.0 * k) for k, (x, y) in enumerate(grid)],
        "turn": [Pose(start.x_mm, start.y_mm, 15.0 * k) for k in range(24)],
        "ahead": [ahead.pose_after(begin, s) for s in range(-280, 281, 40)],
    }


def drive_poses() -> list[tuple[Pose, Motion]]:
    """(pose, motion) of each frame: from the first marker to the last and, backwards, to the first again."""
    step_mm = SPEED_MM_S / RATE_HZ
    there = [float(x) for x in np.arange(0.0, MARKERS[-1][1].x_mm, step_mm)]
    forward = [(Pose(x, 0.0, 0.0), Motion(SPEED_MM_S)) for x in there]
    back = [(Pose(x + step_mm, 0.0, 0.0), Motion(-SPEED_MM_S)) for x in reversed(there)]
    return forward + back


def settings() -> dict[str, object]:
    """Of the camera on the desk: calibrated, without a map. A fast line, so that raw frames take seconds."""
    mount_deg, forward_deg, left_deg = mounting.angles(CAMERA.rotation)
    radius_px = CAMERA.focal_px * 150.0 / CEILING_MM
    return {
        "baud": 921600,
        "width": CAMERA.width,
        "height": CAMERA.height,
        "focal_q8": round(CAMERA.focal_px * 256),
        "center_x_q8": round(CAMERA.center_x_px * 256),
        "center_y_q8": round(CAMERA.center_y_px * 256),
        "k1_e5": round(CAMERA.k1 * 1e5),
        "mount_cdeg": round(mount_deg * 100) % 36000,
        "tilt_forward_cdeg": round(forward_deg * 100),
        "tilt_left_cdeg": round(left_deg * 100),
        "ceiling_mm10": round(CEILING_MM * 10),
        "radius_min_px": int(radius_px * 0.85),
        "radius_max_px": math.ceil(radius_px * 1.15),
    }


def _render(folder, scene, steps, rng) -> Iterator[np.ndarray]:
    """Writes the frames of (pose, motion) steps with their truth, and yields them."""
    with TruthWriter(folder / "truth.csv") as truth:
        for index, (pose, motion) in enumerate(steps):
            name, time_us = frame_name(index), round(index * 1e6 / RATE_HZ)
            with told("the renderer"):
                frame, truths = render_view(
                    scene, pose, motion, CAMERA, SENSOR, rng, name=name, time_us=time_us
                )
            write_frame(folder / name, frame)
            truth.write(truths)
            yield frame


def write_tour(target: Path, overwrite: bool = False) -> int:
    """Writes everything below the folder; returns how many frames. UserError when that fails."""
    rng = np.random.default_rng(SEED)
    hall = Scene(ceiling_mm=CEILING_MM, surface=_SURFACE, plates=tuple(Plate(i, pose) for i, pose in MARKERS))
    alone = Scene(ceiling_mm=CEILING_MM, surface=_SURFACE, plates=(Plate(5, Pose()),))
    recordings: dict[str, tuple[Scene, list[tuple[Pose, Motion]]]] = {"drive": (hall, drive_poses())}
    for name, poses in calibration_poses().items():
        recordings[name] = (alone, [(pose, Motion()) for pose in poses])
    total = sum(len(steps) for _, steps in recordings.values())
    try:
        target.mkdir(parents=True, exist_ok=True)
        refuse_beside(target, ("clip.bin", "drive/settings.json"), overwrite)
        frames = watched(_all_frames(target, recordings, overwrite, rng), total, quiet_stdout=True)
        clip = [frame for frame, _ in zip(frames, drive_poses()[:CLIP_FRAMES], strict=False)]
        for _ in frames:
            pass
        with open(target / "clip.bin", "wb") as file:
            write_stream(file, clip, 1000 // RATE_HZ)
        (target / "drive" / SAVED).unlink(missing_ok=True)
        write_file(target / "drive" / "settings.json", settings())
    except OSError as error:
        raise UserError("cannot write %s: %s" % (error.filename or target, error.strerror)) from error
    return total


def _all_frames(target, recordings, overwrite, rng) -> Iterable[np.ndarray]:
    for name, (scene, steps) in recordings.items():
        yield from _render(make_folder(target / name, overwrite, ("truth.csv",)), scene, steps, rng)
