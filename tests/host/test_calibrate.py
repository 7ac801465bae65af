"""larics calibrate against rendered frames of a known camera, and its refusals."""

import json

import pytest

from larics_host import cli
from larics_host.calibration import mounting
from larics_host.render.camera import Camera, Motion
from tools.host_figures import SUNNY, calibration_errors, calibration_poses, vehicle_below, write_frames

HEIGHT_MM, FOCAL = 2750.0, 560.0
CAMERA = Camera(
    focal_px=FOCAL, k1=-0.12, tilt_deg=2.0, tilt_direction_deg=70.0, mounting_deg=33.0, offset_x_mm=85.0,
    offset_y_mm=-40.0,
)  # fmt: skip
RADIUS = "25:37"


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("calibration")
    poses = calibration_poses(CAMERA, HEIGHT_MM)
    begin = poses["straight"][0]
    bend = Motion(300.0, 0.0, 12.0)
    poses["bent"] = [bend.pose_after(begin, 0.15 * k) for k in range(14)]
    poses["half"] = poses["turn"][:5]
    poses["corner"] = [vehicle_below(CAMERA, HEIGHT_MM, 100 + k, 110, 0.0) for k in range(6)]
    poses["line"] = [vehicle_below(CAMERA, HEIGHT_MM, 176 + k, 148, 0.0) for k in range(10)]
    return {
        name: write_frames(folder / name, CAMERA, HEIGHT_MM, SUNNY, some, 1700)
        for name, some in poses.items()
    }


def calibrate(*arguments):
    return cli.main(["calibrate", "--radius-px", RADIUS, *arguments])


def close_to_truth(found):
    errors = calibration_errors(found, CAMERA, HEIGHT_MM)
    limits = {"focal length, %": 0.2, "rotation centre, mm": 1.0, "lens's place, mm": 1.0}
    limits.update({"mounting angle, deg": 0.1, "tilt, deg": 0.2, "k1": 0.02})
    assert errors.keys() == limits.keys()
    assert not {name: error for name, error in errors.items() if not abs(error) < limits[name]}


def test_a_rendered_camera_is_found_within_the_tolerances(recordings, tmp_path, capsys):
    out, plot = tmp_path / "camera.json", tmp_path / "fit.png"
    names = [word for name in ("places", "turn", "straight") for word in ("--" + name, recordings[name])]
    assert calibrate(*names, "--height-mm", str(HEIGHT_MM), "-o", str(out), "--plot", str(plot)) == 0
    text = capsys.readouterr().out
    print(text)
    assert "all others are the defaults" in text
    assert "+-" in text and "residual of the places" in text
    found = json.loads(out.read_text())
    close_to_truth(found)
    assert found["ceiling_mm10"] == 27500 and (found["width"], found["height"]) == (360, 296)
    sigmas = [found[name] for name in ("focal_sigma_ppm", "tilt_sigma_cdeg", "mount_sigma_cdeg")]
    assert 100 < sigmas[0] < 3000 and 0 < sigmas[1] < 30 and 0 < sigmas[2] < 30, sigmas
    assert 0 < found["camera_sigma_mm10"] < 100
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


def test_a_calibration_for_another_frame_size_is_begun_anew(recordings, tmp_path, capsys):
    known, out = tmp_path / "known.json", tmp_path / "o.json"
    known.write_text('{"width": 640, "height": 480, "focal_q8": 256000, "k1_e5": 1000, "center_x_q8": 70000}')
    options = ("--height-mm", str(HEIGHT_MM), "--settings", str(known), "-o", str(out))
    assert calibrate("--places", recordings["places"], *options) == 0
    assert "calibrated for frames of 640 x 480 px, these are 360 x 296: begun anew" in capsys.readouterr().out
    found = json.loads(out.read_text())
    assert (found["width"], found["height"], found["center_x_q8"]) == (360, 296, 0)
    assert found["focal_q8"] / 256 == pytest.approx(FOCAL, rel=0.002)


def test_what_is_known_is_kept(recordings, tmp_path, capsys):
    base, out = tmp_path / "base.json", tmp_path / "out.json"
    mount, forward, left = (round(100 * angle) for angle in mounting.angles(CAMERA.rotation))
    base.write_text(json.dumps({
        "focal_q8": round(FOCAL * 256), "k1_e5": -12000, "mount_cdeg": mount % 36000, "tilt_left_cdeg": left,
        "tilt_forward_cdeg": forward, "route": [1, 2], "camera_z_mm10": 1000, "width": 360, "height": 296,
    }))  # fmt: skip
    arguments = ["--turn", recordings["turn"], "--height-mm", str(HEIGHT_MM), "--settings", str(base)]
    assert calibrate(*arguments, "-o", str(out)) == 0
    assert "defaults" not in capsys.readouterr().out
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
            "does not determine the rotation",
        ),
        (["--places", "places", "--turn", "turn"], "turning alone does not tell where forward is"),
        (["--places", "places", "--turn", "turn", "--straight", "corner"], "does not determine the mounting"),
        (["--places", "places", "--turn", "turn", "--straight", "bent"], "the drive was not straight"),
        (["--places", "places", "--turn", "straight", "--facing-deg", "0"], "not determine the rotation"),
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
