"""`larics calibrate --odometry`: what odometry leaves out, from the log of a drive."""

import json
import math

import numpy as np
import pytest

from larics.wire import messages as m
from larics.wire.codec import Encoder, fields
from larics_host import cli
from tools.odometry_drives import Ceiling, Wheels, path


def values(number, **given):
    return [given.get(field[0], 0) for field in fields(number)]


def write_log(target, seconds=120, seed=5201, bias=0.01, distort=None, turns=0):
    """A log of a drive at 1 m/s and 20 frames/s, then of turns on the spot below a marker, of which odometry
    tells 2 % less; the wheels have this bias. Returns the true scale, and drift in degrees a metre."""
    found = path(1000, seconds, seed, bias=bias)
    off = np.random.default_rng(seed).normal(0, bias, 2)
    ceiling, wheels, encoder, data = Ceiling(found, seed, 0.3), Wheels(), Encoder(clamp=True), b""
    mark_x, mark_y, _ = ceiling.marks[-1]
    spot = [(mark_x, mark_y, 0.05 * k, *found[-1][3:5], found[-1][5] + 0.05 * k * 0.98) for k in range(turns)]
    for k, (x, y, heading, *told) in enumerate([*found[::5], *spot]):
        wheels.set(*(distort(*told) if distort else told))
        if k == len(found[::5]):
            wheels.epoch += 1  # it was put there
        seen, pose = ceiling.see(x, y, heading), ceiling.localizer
        pose.update(seen, len(seen), k * 50000, wheels)
        for number, given in (
            (m.POSE, {"frame": k, "state": pose.state, "id": pose.marker_id, "x_mm10": pose.x_mm10,
                      "y_mm10": pose.y_mm10, "heading_cdeg": pose.heading_cdeg, "sigma_cdeg": pose.sigma_cdeg,
                      "sigma_x_mm10": pose.sigma_x_mm10, "sigma_y_mm10": pose.sigma_y_mm10}),
            (m.MOTION, {"frame": k, "state": m.MOTION_INTERPOLATED, "epoch": wheels.epoch,
                        "x_mm10": wheels.x_mm10, "y_mm10": wheels.y_mm10,
                        "heading_cdeg": wheels.heading_cdeg}),
        ):  # fmt: skip
            data += encoder.buffer[: encoder.encode(number, values(number, **given))]
    target.write_bytes(data)
    return 1 / (1 + off.mean()) - 1, math.degrees(-(off[1] - off[0]) / 300 * 1000)


def test_scale_turn_drift_and_noise_are_found_and_written(tmp_path, capsys):
    log, target = tmp_path / "drive.bin", tmp_path / "camera.json"
    scale, drift = write_log(log, turns=700)
    assert cli.main(["calibrate", "--odometry", str(log), "-o", str(target)]) == 0
    said = capsys.readouterr().out
    assert "the way is longer by" in said and "drift to the left" in said
    found = json.loads(target.read_text())
    for name, true, most in (
        ("odometry_scale_ppm", scale * 1e6, 2500),
        ("odometry_drift_mdeg_m", drift * 1e3, 300),
        ("odometry_turn_ppm", 20408, 3000),
    ):
        sigma = found[name.replace("_ppm", "_sigma_ppm").replace("_mdeg_m", "_sigma_mdeg_m")]
        assert abs(found[name] - true) < most and sigma < most, (name, found[name], true, sigma)
    assert 100 <= found["odometry_noise_mm2_km"] < 5000  # encoders that see the noise of the wheels


def test_without_turns_the_track_is_left_open(tmp_path, capsys):
    log, target = tmp_path / "drive.bin", tmp_path / "camera.json"
    write_log(log, seconds=60)
    assert cli.main(["calibrate", "--odometry", str(log), "-o", str(target)]) == 0
    assert "too few turns" in capsys.readouterr().out
    assert json.loads(target.read_text())["odometry_turn_sigma_ppm"] == 7000


@pytest.mark.parametrize(
    "options, words",
    [
        ({"seconds": 5}, "of 4 at least"),
        ({"distort": lambda x, y, heading: (x / 2, y / 2, heading)}, "check its unit, sign and axes"),
    ],
)
def test_what_no_odometry_is_calibrated_by_is_one_line(options, words, tmp_path, capsys):
    log = tmp_path / "drive.bin"
    write_log(log, **options)
    assert cli.main(["calibrate", "--odometry", str(log)]) == 2
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1
