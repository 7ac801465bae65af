"""Figures of the host tools, measured: calibration and maps on rendered frames against truth, speed, memory.

    python tools/host_figures.py --cameras 6 --halls 3
    python tools/host_figures.py --only calibrate,map

Prints a table a part. The frames are rendered with seeds from 5000 on, on which nothing was tuned.
"""

import argparse
import contextlib
import io
import json
import math
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from larics.device.sensor import Sensor as Device
from larics.marker import Family
from larics.settings import Settings
from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host import cli
from larics_host.calibration import mounting
from larics_host.calibration.camera_model import model_of
from larics_host.connection import records
from larics_host.detection.batch import detect_all
from larics_host.detection.options import DetectionOptions
from larics_host.images.stills import encode_pgm
from larics_host.mapping.mapfile import read_map
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.plates import Plate
from larics_host.render.scene import Scene
from larics_host.render.sensor import Sensor
from larics_host.render.view import render_view

PARTS = ("calibrate", "map", "validate", "log")
SEED = 5000
SUNNY = Sensor(contrast=130.0, black=30.0, read_noise=0.8, shot_noise=0.006, defocus_px=0.5)
CLOUDY = Sensor(contrast=35.0, black=30.0, read_noise=1.3, shot_noise=0.02, defocus_px=0.7)


# calibration


def vehicle_below(camera, height_mm, x_px, y_px, heading_deg):
    """The pose of a vehicle at which a marker in the map's origin appears at a pixel."""
    ray = camera.ray(x_px, y_px)
    x, y = (height_mm * ray[k] / ray[2] for k in (0, 1))
    x, y = x + camera.offset_x_mm, y + camera.offset_y_mm
    cos, sin = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
    return Pose(-(cos * x - sin * y), -(sin * x + cos * y), heading_deg)


def calibration_poses(camera, height_mm):
    """Vehicle poses for the three recordings of a calibration: {"places", "turn", "straight"}."""
    grid = [(x, y) for y in (60, 104, 148, 192, 236) for x in (60, 120, 180, 240, 300)]
    places = [vehicle_below(camera, height_mm, x, y, 37.0 * k) for k, (x, y) in enumerate(grid)]
    begin = vehicle_below(camera, height_mm, 190, 150, 0.0)
    turn = [Pose(begin.x_mm, begin.y_mm, 15.0 * k) for k in range(24)]
    begin = vehicle_below(camera, height_mm, 180, 148, 20.0)
    drive = Motion(1.0)
    straight = [drive.pose_after(begin, s) for s in range(-300, 301, 40)]
    return {"places": places, "turn": turn, "straight": straight}


def write_frames(folder, camera, height_mm, sensor, poses, seed):
    """Frames of marker 5, in the map's origin, from these vehicle poses; returns the folder as text."""
    folder.mkdir(parents=True)
    rng = np.random.default_rng(seed)
    scene = Scene(ceiling_mm=height_mm, plates=(Plate(5, Pose(), Family(line_mm10=175)),))
    for index, pose in enumerate(poses):
        frame, _ = render_view(scene, pose, Motion(), camera, sensor, rng)
        (folder / ("f%03d.pgm" % index)).write_bytes(encode_pgm(frame))
    return str(folder)


def calibration_errors(found, camera, height_mm):
    """{quantity: error} of settings found (a dict) against the rendered camera.

    The rotation centre is where the vehicle's vertical axis meets the markers' plane: that, not the lens's
    own place, is what offsets are counted from. Tilt and lens's place trade off against each other there.
    """
    mount, forward, left = mounting.angles(camera.rotation)
    ((x_px, y_px),) = camera.project([(-camera.offset_x_mm, -camera.offset_y_mm, height_mm)])
    seen = height_mm * model_of(Settings(found), camera.width, camera.height).plane(x_px, y_px)
    lens = found["camera_x_mm10"] / 10, found["camera_y_mm10"] / 10
    return {
        "focal length, %": 100 * (found["focal_q8"] / 256 / camera.focal_px - 1),
        "rotation centre, mm": math.hypot(seen[0] + lens[0], seen[1] + lens[1]),
        "lens's place, mm": math.hypot(lens[0] - camera.offset_x_mm, lens[1] - camera.offset_y_mm),
        "mounting angle, deg": (found["mount_cdeg"] / 100 - mount + 180) % 360 - 180,
        "tilt, deg": math.hypot(
            found["tilt_forward_cdeg"] / 100 - forward, found["tilt_left_cdeg"] / 100 - left
        ),
        "k1": found["k1_e5"] / 1e5 - camera.k1,
    }


def random_camera(seed):
    """(Camera, height of the ceiling above it) with everything a calibration has to find."""
    rng = np.random.default_rng(seed)
    height = rng.uniform(2300, 3200)
    return Camera(
        focal_px=height / 150 * rng.uniform(28.0, 32.0),
        k1=rng.uniform(-0.2, 0.05),
        tilt_deg=rng.uniform(0.0, 3.0),
        tilt_direction_deg=rng.uniform(0, 360),
        mounting_deg=rng.uniform(0, 360),
        offset_x_mm=rng.uniform(-150, 150),
        offset_y_mm=rng.uniform(-150, 150),
    ), height


def quietly(*words):
    """Runs a larics command without its output; returns the exit code."""
    with contextlib.redirect_stdout(io.StringIO()):
        return cli.main([str(word) for word in words])


def calibrate(folder, count):
    worst = {}
    for k in range(count):
        camera, height = random_camera(SEED + k)
        sensor = (SUNNY, CLOUDY)[k % 2]
        place = folder / ("camera%d" % k)
        words = ["calibrate", "--radius-px", "24:37", "--height-mm", height, "-o", place / "found.json"]
        for name, poses in calibration_poses(camera, height).items():
            words += ["--" + name, write_frames(place / name, camera, height, sensor, poses, SEED + k)]
        if quietly(*words):
            print("  camera %d was refused" % k)
            continue
        errors = calibration_errors(json.loads((place / "found.json").read_text()), camera, height)
        print("  camera %d: %s" % (k, ", ".join("%s %+.4f" % pair for pair in errors.items())))
        for name, error in errors.items():
            worst[name] = max(worst.get(name, 0.0), abs(error))
    for name, error in worst.items():
        print("  largest error, %-22s %.4f" % (name, error))


# maps


def hall_of(seed, rows=4, columns=5, spacing_mm=950):
    """Markers on a crooked grid: [(ID, x mm, y mm, heading deg)]; the same ID is more than 2 m away."""
    rng = np.random.default_rng(seed)
    hall = []
    for k in range(rows * columns):
        row, column = divmod(k, columns)
        x, y = (spacing_mm * step + rng.uniform(-35, 35) for step in (column, row))
        hall.append(((column + 2 * row) % 7 + 1, x, y, float(rng.uniform(0, 360))))
    return hall


def serpentine(step_mm, rows=4, columns=5, spacing_mm=950):
    """Vehicle poses along the rows, back and forth, and home again."""
    width = spacing_mm * (columns - 1)
    corners = []
    for row in range(rows):
        xs = (0, width) if row % 2 == 0 else (width, 0)
        corners += [(x, spacing_mm * row) for x in xs]
    corners.append((0, 0))
    poses, before = [], 0.0
    for (x1, y1), (x2, y2) in zip(corners[:-1], corners[1:], strict=True):
        length = math.hypot(x2 - x1, y2 - y1)
        heading = math.degrees(math.atan2(y2 - y1, x2 - x1))
        turn = (heading - before + 180) % 360 - 180
        poses += [(x1, y1, before + turn * k / 6) for k in range(1, 6) if turn]
        poses += [
            (x1 + (x2 - x1) * s / length, y1 + (y2 - y1) * s / length, heading)
            for s in np.arange(0, length, step_mm)
        ]
        before = heading
    return poses


def marker_line(frame, index, count, marker_id, x_mm, y_mm, heading_deg, flags=0):
    """A MARKER message as larics log writes it."""
    fields = dict.fromkeys(records.Marker._fields, 0)
    fields.update(frame=frame, index=index, count=count, id=marker_id, flags=flags, z_mm10=27500, margin=99)
    fields.update(
        x_mm10=round(10 * x_mm), y_mm10=round(10 * y_mm), heading_cdeg=round(100 * heading_deg) % 36000
    )
    return (
        json.dumps({"time_s": frame * 0.04, "message": "MARKER", "sequence": frame % 65536, **fields}) + "\n"
    )


def rendered_log(path, hall, seed, step_mm):
    """The log of a drive under rendered markers, found and located by the product's own code."""
    camera, height = Camera(width=300, height=240, focal_px=320.0), 2750.0
    plates = tuple(Plate(i, Pose(x, y, h), Family(line_mm10=175)) for i, x, y, h in hall)
    scene = Scene(ceiling_mm=height, plates=plates)
    known = {"width": 300, "height": 240, "focal_q8": 320 * 256, "ceiling_mm10": round(10 * height)}
    device = Device(Settings(known | {"radius_min_px": 15, "radius_max_px": 21, "tracking": False}))
    device.rebuild()
    rng, lines = np.random.default_rng(seed), []
    for frame, pose in enumerate(serpentine(step_mm)):
        picture, _ = render_view(scene, Pose(*pose), Motion(), camera, SUNNY, rng)
        count = device.place(device.detector.detect(picture))
        for index, one in enumerate(device.measurements[:count]):
            marker_id = m.ID_NONE if one.marker_id < 0 else one.marker_id
            place = one.offset_x_mm10 / 10, one.offset_y_mm10 / 10, one.heading_cdeg / 100
            lines.append(marker_line(frame, index, count, marker_id, *place, one.flags))
    path.write_text("".join(lines))


def map_errors(built, hall):
    """mm by which each marker of a map (of a mapfile.Map) is off after the rigid motion that fits best.

    ValueError when the map's markers are not those of the hall."""
    fits = [_errors_from(built, hall, k) for k in range(len(hall)) if hall[k][0] == built[0].id]
    fits = [off for off in fits if off is not None]
    if not fits:
        raise ValueError("the map lacks markers of the hall, or has others")
    return min(fits, key=lambda off: off.max())


def _errors_from(built, hall, k):
    """The same when the map's first marker is number k of the hall; None when it cannot be."""
    first, start = built[0], hall[k]
    turn = math.radians(start[3] - first.heading_deg)
    pairs = []
    for marker in built:
        x, y = marker.x_mm - first.x_mm, marker.y_mm - first.y_mm
        x, y = math.cos(turn) * x - math.sin(turn) * y, math.sin(turn) * x + math.cos(turn) * y
        near = [one for one in hall if one[0] == marker.id]
        true = min(near, key=lambda one: math.hypot(one[1] - start[1] - x, one[2] - start[2] - y))
        pairs.append((*true[1:3], marker.x_mm, marker.y_mm))
    if len({pair[:2] for pair in pairs}) != len(hall) or len(built) != len(hall):
        return None
    table = np.array(pairs) - np.mean(pairs, axis=0)
    true, found = table[:, :2], table[:, 2:]
    u, _, v = np.linalg.svd(found.T @ true)
    return np.hypot(*(found @ (u @ v) - true).T)


def maps(folder, count):
    for k in range(count):
        hall = hall_of(SEED + k)
        log, out = folder / ("hall%d.jsonl" % k), folder / ("hall%d.json" % k)
        rendered_log(log, hall, SEED + k, 150)
        quietly("map", "build", log, "-o", out, "--repeats")
        off = map_errors(read_map(out).markers, hall)
        print("  hall %d: 20 markers, error median %.2f mm, largest %.2f mm" % (k, np.median(off), off.max()))


# speed and memory


def _cpu_s():
    """Processor time of this process and of those that it has waited for."""
    own, others = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + others.ru_utime + others.ru_stime


def validate(folder):
    """Processor time a frame, reading included, start of processes taken out by comparing two lengths."""
    frames = str(folder / "frames")
    quietly("simulate", "--preset", "cloudy", "--frames", "1000", "--seed", SEED, "-o", frames)
    options = DetectionOptions(radius_px=(25, 36))
    for jobs in (1, 2):
        spent = []
        for rounds in (1, 5):
            start = _cpu_s()
            count = sum(1 for _ in detect_all([frames] * rounds, options, jobs))
            spent.append((count, _cpu_s() - start))
        (few, less), (many, more) = spent
        each = (more - less) / (many - few)
        print(
            "  %d process%s: %.2f ms a frame, %.0f frames/s a core"
            % (jobs, "es"[: 2 * jobs - 2], 1e3 * each, 1 / each)
        )


def _peak_mib(pid):
    """Most memory that a running process has had, 0 when it has just ended; rusage would count ours too."""
    with contextlib.suppress(OSError, IndexError):
        text = Path("/proc/%d/status" % pid).read_text()
        return int(text.split("VmHWM:")[1].split()[0]) / 1024
    return 0.0


def log(folder):
    encoder = protocol.Encoder()
    empty = {kind: kind(*[0] * len(kind._fields)) for kind in (records.Marker, records.Pose)}
    for minutes in (4, 60):
        path = folder / ("log%d.bin" % minutes)
        with open(path, "wb") as file:
            for k in range(minutes * 3600):
                marker = empty[records.Marker]._replace(
                    frame=k, age_us=8000, id=k // 500 % 7 + 1, count=1, x_mm10=k % 9000, y_mm10=-k % 9000,
                    z_mm10=27500, heading_cdeg=k % 36000, margin=200, radius_q8=7680,
                )  # fmt: skip
                file.write(encoder.buffer[: encoder.encode(m.MARKER, marker)])
                pose = empty[records.Pose]._replace(
                    frame=k, age_us=8000, state=m.TRACKING, id=3, x_mm10=k, y_mm10=k, heading_cdeg=100,
                    marker_age_ms=8, sigma_x_mm10=10, sigma_y_mm10=10, sigma_cdeg=10, route_position=1,
                    next_cdeg=m.DIRECTION_NONE,
                )  # fmt: skip
                file.write(encoder.buffer[: encoder.encode(m.POSE, pose)])
        command = [sys.executable, "-m", "larics_host", "log", "--input", str(path), "--mcap", "--force"]
        process = subprocess.Popen([*command, "-o", str(folder / "again")], stdout=subprocess.DEVNULL)
        peak = 0.0
        while process.poll() is None:
            peak = max(peak, _peak_mib(process.pid))
            time.sleep(0.02)
        if process.returncode:
            raise SystemExit("larics log failed")
        print("  %2d minutes at 60 frames/s: peak memory %.0f MiB" % (minutes, peak))


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cameras", type=int, default=6)
    parser.add_argument("--halls", type=int, default=3)
    parser.add_argument("--only", default=",".join(PARTS), help="of " + ", ".join(PARTS))
    options = parser.parse_args()
    work = {
        "calibrate": lambda folder: calibrate(folder, options.cameras),
        "map": lambda folder: maps(folder, options.halls),
        "validate": validate,
        "log": log,
    }
    for part in options.only.split(","):
        if part not in work:
            parser.error("unknown part %s" % part)
        print(part, flush=True)
        with tempfile.TemporaryDirectory() as folder:
            work[part](Path(folder))


if __name__ == "__main__":
    main()
