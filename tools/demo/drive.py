"""The drive of the demo: where the vehicle goes, what hangs above it, and the frames its camera takes."""

import hashlib
import json
import math
import multiprocessing
import os
from pathlib import Path

import numpy as np

from larics_host.render import clutter, render_view
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.plates import Plate, printed_family
from larics_host.render.scene import Scene, Surface
from larics_host.render.sensor import Sensor
from larics_host.truth import read_truth, write_truth

FPS = 25
SPEED_MM_S = 400.0
# seconds and turn rate in degrees a second of each piece of the way: it swings to the left and back
LEGS = ((2.6, 0.0), (1.6, 30.0), (1.4, 0.0), (2.4, -30.0), (1.4, 0.0), (1.2, 20.0), (2.4, 0.0))
CEILING_MM = 3000.0
FOCAL_PX = 600.0
WIDTH, HEIGHT = 360, 296
# ID, seconds on the way, offset to its left in mm, heading of the orientation line against the way;
# plain and coded ones, as in a building where both hang
MARKERS = (
    (3, 1.1, 150, 0.0),
    (1261, 4.1, -200, 90.0),
    (2222, 7.3, 180, -60.0),
    (1, 10.0, -150, 180.0),
    (7, 12.3, 120, 30.0),
)
SEED = 1600


def leg_at(seconds):
    """(pose at the start of the leg, motion on it, seconds since then) at a time of the drive."""
    pose = Pose(0.0, 0.0, 0.0)
    for length, turn in LEGS[:-1]:
        motion = Motion(SPEED_MM_S, 0.0, turn)
        if seconds < length:
            return pose, motion, seconds
        pose = motion.pose_after(pose, length)
        seconds -= length
    return pose, Motion(SPEED_MM_S, 0.0, LEGS[-1][1]), seconds


def pose_at(seconds):
    pose, motion, since = leg_at(seconds)
    return motion.pose_after(pose, since)


def frame_count():
    return int(FPS * sum(length for length, _ in LEGS))


def plates():
    """The markers over the way."""
    placed = []
    for marker_id, seconds, left_mm, turn_deg in MARKERS:
        pose = pose_at(seconds)
        heading = math.radians(pose.heading_deg)
        x_mm = round(pose.x_mm - left_mm * math.sin(heading))
        y_mm = round(pose.y_mm + left_mm * math.cos(heading))
        where = Pose(x_mm, y_mm, round(pose.heading_deg + turn_deg) % 360)
        placed.append(Plate(marker_id, where, printed_family(marker_id)))
    return tuple(placed)


def camera():
    return Camera(width=WIDTH, height=HEIGHT, focal_px=FOCAL_PX, row_us=0.0, exposure_us=5000.0)


def settings():
    """What the firmware is told: the camera's calibration and the surveyed map."""
    return {
        "focal_q8": round(FOCAL_PX * 256),
        "ceiling_mm10": round(CEILING_MM * 10),
        "radius_min_px": 25,
        "radius_max_px": 36,
        "max_speed_mm_s": 1000,
        "map": [
            [p.marker_id, int(p.pose.x_mm), int(p.pose.y_mm), round(p.pose.heading_deg * 100), 0, 0]
            for p in plates()
        ],
    }


def scene():
    """The room's ceiling: tiles, pipes, cables, smoke detectors, a few lamps and shadows, and the markers."""
    rng = np.random.default_rng(SEED)
    region = (-1500.0, -1500.0, 6300.0, 2600.0)
    hung = plates()
    keep_out = np.array([(p.pose.x_mm, p.pose.y_mm, p.radius_mm + 30) for p in hung])
    surface = Surface(reflectance=0.7, tile_mm=(625.0, 625.0), tile_angle=0.12, joint_mm=9.0, speckle=0.04)
    return Scene(
        CEILING_MM,
        surface,
        hung,
        clutter.draw_furniture(rng, region, 26, 9, 3, keep_out),
        lamps=np.array(clutter.draw_lamps(rng, region, 3, 3.0, keep_out)),
        shades=np.array(clutter.draw_shadows(rng, region, 4)),
    )


def name_of(index):
    return "frame_%06d.pgm" % index


def _render(arguments):
    folder, index = arguments
    pose, motion, since = leg_at(index / FPS)
    sensor = Sensor(150, 30, read_noise=1.2, shot_noise=0.012, vignetting=0.25, defocus_px=0.6)
    rng = np.random.default_rng([SEED, index])
    frame, truths = render_view(
        _render.scene,
        motion.pose_after(pose, since),
        motion,
        camera(),
        sensor,
        rng,
        name=name_of(index),
        time_us=round(index * 1e6 / FPS),
    )
    (folder / name_of(index)).write_bytes(b"P5\n%d %d\n255\n" % (WIDTH, HEIGHT) + frame.tobytes())
    return truths


def _begin():
    _render.scene = scene()


def fingerprint():
    """Changes when the frames would."""
    here = Path(__file__).resolve()
    renderer = sorted((here.parents[2] / "host" / "larics_host" / "render").glob("*.py"))
    digest = hashlib.sha256()
    for path in [here, *renderer]:
        digest.update(path.read_bytes())
    return digest.hexdigest()


def prepare(folder, progress):
    """Renders the frames into folder/frames unless they are there; returns the list of Truth.

    `progress(done, total)` is called now and then."""
    frames = folder / "frames"
    stamp = folder / "frames.json"
    if stamp.exists() and json.loads(stamp.read_text()) == fingerprint():
        return read_truth(frames), False
    stamp.unlink(missing_ok=True)
    frames.mkdir(parents=True, exist_ok=True)
    for old in frames.glob("*.pgm"):
        old.unlink()
    count = frame_count()
    truths = []
    _begin()
    truths += _render((frames, 0))  # compiles the kernels once, before the workers start
    tasks = [(frames, index) for index in range(1, count)]
    context = multiprocessing.get_context("spawn")
    with context.Pool(min(2, os.cpu_count() or 1), initializer=_begin) as pool:
        for done, found in enumerate(pool.imap(_render, tasks, chunksize=4)):
            truths += found
            progress(done + 2, count)
    write_truth(frames / "truth.csv", truths)
    stamp.write_text(json.dumps(fingerprint()))
    return truths, True
