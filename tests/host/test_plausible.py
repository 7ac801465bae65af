"""Configurations that are allowed and yet contradict what is known: noticed, named, or refused."""

import json

import cv2
import numpy as np
import pytest

from larics.settings import Settings
from larics_host import cli
from larics_host.calibration.observe import observe
from larics_host.connection.camera_settings import apply, calibrated_for, doubts
from larics_host.detection.options import DetectionOptions
from larics_host.errors import UserError
from larics_host.mapping.mapfile import parse_marker, read_map
from larics_host.monitor.doubts import Doubts
from larics_host.render import render_frame

OPTICS = {"focal_q8": 300 * 256, "ceiling_mm10": 25000, "camera_z_mm10": 0, "outer_mm10": 1500}


def check(tmp_path, rows):
    path = tmp_path / "survey.csv"
    path.write_text("id,x_mm,y_mm,heading_deg\n" + "".join("%d,%d,0,%s\n" % row for row in rows))
    return cli.main(["map", "create", str(tmp_path / "hall.json"), "--csv", str(path), "--force"])


@pytest.mark.parametrize(
    "headings, said",
    [
        (("0", "1.5708", "3.1416", "4.7124"), "problem"),
        (("-1.5708", "3.1416", "0"), "problem"),
        (("6.2832", "1.57", "0"), "problem"),
        (("0.1", "2.9", "4.4", "6.1"), "doubt"),
        (("-2.9", "-1.7", "0.4", "2.2", "3.05"), "doubt"),
        (("4.0042", "0", "357.992"), ""),  # markers that hang nearly alike
        (("-2.1", "-0.4", "0.3", "1.2", "3.9", "-1.6"), ""),
        (("-2.9", "0.4", "0.3", "-0.2", "2.2"), ""),
        (("1.2", "2.3", "3.4", "4.1"), ""),
        (("0", "0", "0"), ""),
        (("0", "90", "180", "270"), ""),
        (("0", "1", "2"), ""),
        (("0.4", "359.8", "0.2"), ""),
        (("0", "5"), ""),
        (("1.5708", "90", "0"), ""),
    ],
)
def test_headings_in_radians_are_noticed(tmp_path, capsys, headings, said):
    rows = [(k + 1, 1500 * k, heading) for k, heading in enumerate(headings)]
    wrong = int(said == "problem")
    assert check(tmp_path, rows) == wrong
    lines = [line for line in capsys.readouterr().out.splitlines() if "are they radians?" in line]
    assert [line.split(":")[0] for line in lines] == [said] * bool(said)
    assert cli.main(["map", "check", str(tmp_path / "hall.json")]) == wrong


@pytest.mark.parametrize("text, heading", [("400", 40), ("-90", 270), ("360", 0), ("720", 0), ("0", 0)])
def test_a_heading_beyond_a_turn_is_brought_into_it(tmp_path, text, heading):
    assert parse_marker("3,0,0,%s" % text).heading_deg == heading
    path = str(tmp_path / "hall.json")
    assert cli.main(["map", "create", path, "--marker", "3,0,0,%s" % text]) == 0
    assert read_map(path).markers[0].heading_deg == heading


def test_a_heading_that_is_no_angle_is_refused():
    for text in ("9000", "-721"):
        with pytest.raises(UserError, match="heading_deg is %s: give degrees" % text):
            parse_marker("3,0,0,%s" % text)


class Client:
    def __init__(self, values):
        self.values = values

    def set(self, name, value):
        self.values[name] = value

    def get(self, name):
        return self.values[name]


def test_a_frame_size_is_not_changed_under_a_calibration():
    current = Settings({"width": 320, "height": 240, "focal_q8": 400 * 256}).as_dict()
    larger = {"width": 640, "height": 480}
    with pytest.raises(UserError, match="the calibration is for frames of 320 x 240 px, not 640 x 480"):
        apply(Client(dict(current)), current, larger)
    assert apply(Client(dict(current)), current, {**larger, "focal_q8": 800 * 256})
    assert apply(Client(dict(current)), current, {**larger, "focal_q8": 0})
    bare = Settings({"width": 320, "height": 240}).as_dict()
    assert apply(Client(dict(bare)), bare, larger)
    assert calibrated_for(Settings(current), 320, 240) is None
    assert "these are 640 x 480" in calibrated_for(Settings(current), 640, 480)


def test_a_ring_size_that_ceiling_and_radii_contradict_is_doubted(tmp_path, capsys):
    good = {"focal_q8": 300 * 256, "ceiling_mm10": 25000, "radius_min_px": 10, "radius_max_px": 30}
    assert doubts(Settings(good)) == [] and doubts(Settings({"ceiling_mm10": 25000})) == []
    (line,) = doubts(Settings({**good, "outer_mm10": 500}))
    assert "has a radius of 6 px, outside radius_min_px = 10 to radius_max_px = 30" in line
    path = tmp_path / "camera.json"
    path.write_text('{"focal_q8": 76800, "ceiling_mm10": 5000}')
    assert cli.main(["settings", "check", str(path)]) == 0
    assert "doubt: a ring of outer_mm10 = 1500 at ceiling_mm10 = 5000" in capsys.readouterr().out


def test_the_monitor_doubts_rings_of_another_size_than_the_ceiling_allows():
    seen = Doubts()
    seen.set_optics(OPTICS)
    told = [line for _ in range(60) for line in seen.add(3, 25.0, ())]
    assert told == ["rings of 25 px, 18 px by ceiling_mm10, outer_mm10 and focal_q8: one is wrong"]
    fits, unknown, mapped = Doubts(), Doubts(), Doubts()
    fits.set_optics(OPTICS)
    mapped.set_optics(OPTICS)
    for _ in range(60):
        assert not [*fits.add(3, 19.0, ()), *unknown.add(3, 90.0, ()), *mapped.add(3, 90.0, (3,))]


def test_the_monitor_doubts_a_camera_that_reads_the_mirror_images_of_its_map():
    seen = Doubts()
    told = [line for k in range(60) for line in seen.add((4, 2)[k % 2], 20.0, {1, 2})]
    assert told == ["marker 4 is read, which the map has only mirrored, as 1: is the setting mirrored wrong?"]
    for right in ({1, 4}, {4, 2}, set()):
        calm = Doubts()
        assert not [line for k in range(60) for line in calm.add((4, 2)[k % 2], 20.0, right)]
    misread = Doubts()  # a wrong reading now and then is no mirror
    assert not [line for k in range(300) for line in misread.add(1 if k % 5 else 4, 20.0, {1})]


@pytest.fixture(scope="module")
def mirrored(tmp_path_factory):
    """A folder of frames of one marker as a mirrored camera delivers them, and their truths."""
    folder = tmp_path_factory.mktemp("mirrored")
    truths = []
    for index in range(20):
        frame, found = render_frame("sunny", 5301, index, radius_px=30, marker_ids=(3,))
        cv2.imwrite(str(folder / ("f%02d.png" % index)), np.ascontiguousarray(frame[:, ::-1]))
        truths += found
    return folder, truths


def test_detect_reads_the_frames_of_a_mirrored_camera(mirrored, capsys):
    folder, truths = mirrored
    argv = ["detect", "--json", "--radius-px", "25:36", str(folder)]
    assert cli.main(argv) == 0
    plain = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert cli.main([*argv, "--mirrored"]) == 0
    right = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert {one["id"] for frame in plain for one in frame["detections"]} == {6}
    for frame, truth in zip(right, truths, strict=True):
        (one,) = frame["detections"]
        assert one["id"] == 3 and abs(one["x"] - (frame["width"] - 1 - truth.x_px)) < 0.3
        assert abs(one["y"] - truth.y_px) < 0.3
        assert abs((one["heading"] - (180 - truth.heading_deg) + 180) % 360 - 180) < 0.5


def test_calibrate_says_that_the_camera_is_mirrored(mirrored, capsys):
    folder, _ = mirrored
    argv = ["--ids", "3", "--radius-px", "25:36", "--height-mm", "2750", "--level"]
    assert cli.main(["calibrate", "--places", str(folder), *argv]) == 2
    assert (
        "they are read in the mirror, so the camera is mirrored: give --mirrored" in capsys.readouterr().err
    )


def test_a_turn_needs_a_calibration_for_its_frame_size(mirrored, tmp_path, capsys):
    folder, _ = mirrored
    known = tmp_path / "camera.json"
    known.write_text('{"width": 640, "height": 480, "focal_q8": 204800}')
    argv = ["--settings", str(known), "--radius-px", "25:36", "--height-mm", "2750", "--mirrored"]
    assert cli.main(["calibrate", *argv, "--turn", str(folder), "--facing-deg", "0"]) == 2
    assert "calibrated for frames of 640 x 480 px, these are 360 x 296" in capsys.readouterr().err


def test_copies_of_a_frame_count_once(mirrored, tmp_path, capsys):
    folder, _ = mirrored
    for path in folder.iterdir():
        for copy in range(2):
            (tmp_path / ("%s-%d.png" % (path.stem, copy))).write_bytes(path.read_bytes())
    seen = observe([tmp_path], DetectionOptions(radius_px=(25, 36), mirrored=True))
    assert seen.frames == 40 and len(seen.x_px) == 20 and len(set(seen.x_px)) == 20
    assert "20 copies of frames in %s left out" % tmp_path in capsys.readouterr().err
