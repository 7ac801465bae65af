"""larics calibrate against rendered frames of a known camera, and its refusals."""

import json
import math

import numpy as np
import pytest

from larics.marker import Family
from larics_host import cli, mounting
from larics_host.render.camera import Camera, Motion, Pose
from larics_host.render.plates import Plate
from larics_host.render.scene import Scene
from larics_host.render.sensor import Sensor
from larics_host.render.view import render_view

HEIGHT_MM, FOCAL = 2750.0, 560.0
CAMERA = Camera(
    focal_px=FOCAL, k1=-0.12, tilt_deg=2.0, tilt_direction_deg=70.0, mounting_deg=33.0, offset_x_mm=85.0,
    offset_y_mm=-40.0,
)  # fmt: skip
SENSOR = Sensor(contrast=130.0, black=30.0, read_noise=0.8, shot_noise=0.006, defocus_px=0.5)
RADIUS = "25:37"


def render(folder, poses):
    """Frames of marker 5 at the map's origin from these vehicle poses."""
    folder.mkdir()
    rng = np.random.default_rng(7)
    scene = Scene(ceiling_mm=HEIGHT_MM, plates=(Plate(5, Pose(0.0, 0.0, 0.0), Family(line_mm10=175)),))
    for index, pose in enumerate(poses):
        frame, _ = render_view(scene, pose, Motion(), CAMERA, SENSOR, rng)
        (folder / ("f%03d.pgm" % index)).write_bytes(b"P5\n360 296\n255\n" + frame.tobytes())
    return str(folder)


def vehicle_below(x_px, y_px, heading):
    """The vehicle's pose for which the marker appears at a pixel."""
    ray = CAMERA.ray(x_px, y_px)
    x, y = CAMERA.offset_x_mm + HEIGHT_MM * ray[0] / ray[2], CAMERA.offset_y_mm + HEIGHT_MM * ray[1] / ray[2]
    cos, sin = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    return Pose(-(cos * x - sin * y), -(sin * x + cos * y), heading)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibration")
    grid = [(x, y) for y in (60, 104, 148, 192, 236) for x in (60, 120, 180, 240, 300)]
    places = [vehicle_below(x, y, 37.0 * k) for k, (x, y) in enumerate(grid)]
    start = vehicle_below(190, 150, 0.0)
    turn = [Pose(start.x_mm, start.y_mm, 15.0 * k) for k in range(24)]
    start = vehicle_below(180, 148, 20.0)
    cos, sin = math.cos(math.radians(20.0)), math.sin(math.radians(20.0))
    straight = [Pose(start.x_mm + cos * s, start.y_mm + sin * s, 20.0) for s in range(-300, 301, 40)]
    bend = Motion(300.0, 0.0, 12.0)
    bent = [
        bend.pose_after(Pose(start.x_mm - cos * 280, start.y_mm - sin * 280, 20.0), 0.15 * k)
        for k in range(14)
    ]
    return {
        "bent": render(folder / "bent", bent),
        "places": render(folder / "places", places),
        "turn": render(folder / "turn", turn),
        "straight": render(folder / "straight", straight),
        "corner": render(folder / "corner", [vehicle_below(100 + k, 110, 0.0) for k in range(6)]),
        "half": render(folder / "half", turn[:5]),
        "line": render(folder / "line", [vehicle_below(176 + k, 148, 0.0) for k in range(10)]),
    }


def calibrate(*arguments):
    return cli.main(["calibrate", "--radius-px", RADIUS, *arguments])


def close_to_truth(found):
    mount, forward, left = mounting.angles(CAMERA.rotation)
    assert found["focal_q8"] / 256 == pytest.approx(FOCAL, rel=0.002)
    assert found["mount_cdeg"] / 100 == pytest.approx(mount % 360, abs=0.1)
    assert found["tilt_forward_cdeg"] / 100 == pytest.approx(forward, abs=0.2)
    assert found["tilt_left_cdeg"] / 100 == pytest.approx(left, abs=0.2)
    assert found["k1_e5"] / 1e5 == pytest.approx(CAMERA.k1, abs=0.02)
    assert found["camera_x_mm10"] / 10 == pytest.approx(CAMERA.offset_x_mm, abs=1.0)
    assert found["camera_y_mm10"] / 10 == pytest.approx(CAMERA.offset_y_mm, abs=1.0)


def test_a_rendered_camera_is_found_within_the_tolerances(recordings, tmp_path, capsys):
    out, plot = tmp_path / "camera.json", tmp_path / "fit.png"
    names = [word for name in ("places", "turn", "straight") for word in ("--" + name, recordings[name])]
    assert calibrate(*names, "--height-mm", str(HEIGHT_MM), "-o", str(out), "--plot", str(plot)) == 0
    text = capsys.readouterr().out
    print(text)
    assert "+-" in text and "residual of the places" in text
    found = json.loads(out.read_text())
    close_to_truth(found)
    assert found["ceiling_mm10"] == 27500 and (found["width"], found["height"]) == (360, 296)
    for path in (plot, tmp_path / "fit-turn.png"):
        assert path.read_bytes()[:4] == b"\x89PNG"


def test_a_known_direction_replaces_the_straight_drive(recordings, tmp_path):
    out = tmp_path / "camera.json"
    names = [word for name in ("places", "turn") for word in ("--" + name, recordings[name])]
    # in the first frame of the turn the vehicle's heading is that of the marker
    assert calibrate(*names, "--facing-deg", "0", "--height-mm", str(HEIGHT_MM), "-o", str(out)) == 0
    close_to_truth(json.loads(out.read_text()))


def test_focal_length_alone(recordings, tmp_path, capsys):
    level = tmp_path / "level.json"
    mount, forward, left = (round(100 * angle) for angle in mounting.angles(CAMERA.rotation))
    values = {"k1_e5": -12000, "mount_cdeg": mount % 36000, "tilt_forward_cdeg": forward}
    level.write_text(json.dumps(dict(values, tilt_left_cdeg=left)))
    options = (
        "--height-mm",
        str(HEIGHT_MM),
        "--level",
        "--settings",
        str(level),
        "-o",
        str(tmp_path / "o.json"),
    )
    assert calibrate("--places", recordings["places"], *options) == 0
    found = json.loads((tmp_path / "o.json").read_text())
    assert found["focal_q8"] / 256 == pytest.approx(FOCAL, rel=0.002)
    assert found["tilt_forward_cdeg"] == forward and "mm per px" in capsys.readouterr().out


def test_what_is_known_is_kept(recordings, tmp_path):
    base, out = tmp_path / "base.json", tmp_path / "out.json"
    mount, forward, left = (round(100 * angle) for angle in mounting.angles(CAMERA.rotation))
    base.write_text(json.dumps({
        "focal_q8": round(FOCAL * 256), "k1_e5": -12000, "mount_cdeg": mount % 36000, "tilt_left_cdeg": left,
        "tilt_forward_cdeg": forward, "route": [1, 2], "camera_z_mm10": 1000,
    }))  # fmt: skip
    arguments = ["--turn", recordings["turn"], "--height-mm", str(HEIGHT_MM), "--settings", str(base)]
    assert calibrate(*arguments, "-o", str(out)) == 0
    found = json.loads(out.read_text())
    assert found["route"] == [1, 2] and found["ceiling_mm10"] == 28500
    assert abs(found["tilt_forward_cdeg"] - forward) <= 1 and abs(found["mount_cdeg"] - mount % 36000) <= 1
    assert found["camera_x_mm10"] / 10 == pytest.approx(CAMERA.offset_x_mm, abs=1.0)
    assert calibrate(*arguments, "-o", str(out)) == 2  # not overwritten unasked


@pytest.mark.parametrize(
    "options, words",
    [
        ([], "nothing to calibrate from"),
        (["--places", "corner"], "too few for 4 unknowns"),
        (["--places", "line"], "do not determine"),
        (
            ["--places", "places", "--turn", "half", "--facing-deg", "0"],
            "degrees do not determine the rotation",
        ),
        (["--places", "places", "--turn", "turn"], "turning alone does not tell where forward is"),
        (["--places", "places", "--turn", "turn", "--straight", "corner"], "does not determine the mounting"),
        (["--places", "places", "--turn", "turn", "--straight", "bent"], "the drive was not straight"),
        (["--places", "places", "--turn", "straight", "--facing-deg", "0"], "do not determine the rotation"),
        (["--turn", "turn", "--facing-deg", "0"], "needs the focal length"),
        (["--straight", "straight"], "nothing to calibrate from"),
        (["--places", "places", "--facing-deg", "0"], "give --turn too"),
        (["--places", "no-such-folder"], "no such file"),
        (["--turn", "turn", "--height-mm", "5"], "--height-mm is 5"),
        (["--places", "places", "--send"], "--send needs the --port"),
    ],
)
def test_refusals_are_one_line(options, words, recordings, capsys):
    options = [recordings.get(word, word) for word in options]
    if "--height-mm" not in options:
        options += ["--height-mm", str(HEIGHT_MM)]
    assert calibrate(*options) == 2
    errors = capsys.readouterr().err.splitlines()
    assert words in errors[-1] and errors[-1].startswith("larics: ")


def test_without_height_the_scale_is_all_that_can_be_said(recordings, capsys):
    assert calibrate("--places", recordings["places"]) == 2
    error = capsys.readouterr().err
    assert "1 px is 4.9" in error and "--height-mm" in error
