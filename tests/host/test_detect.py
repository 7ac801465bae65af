"""`larics detect`: the JSON that others parse, the table, the drawings, and every kind of bad input."""

import json

import cv2
import numpy as np
import pytest
from plain_marker import plain_frame

from larics.marker.detection import FLAG_BORDER, FLAG_ID_UNCERTAIN, NO_ID, Detection
from larics_host import cli
from larics_host.detection import detectors
from larics_host.errors import UserError
from larics_host.images import drawing
from larics_host.render import render_frame

RADIUS = ("--radius-px", "25:35")


def save(path, frame):
    assert cv2.imwrite(str(path), frame)
    return path


@pytest.fixture
def folder(tmp_path):
    """Three frames: ID 5, nothing, ID 3."""
    place = tmp_path / "frames"
    place.mkdir()
    save(place / "f1.pgm", plain_frame(5, 60, 55, 30))
    save(place / "f2.png", np.full((112, 128), 120, np.uint8))
    save(place / "f10.pgm", plain_frame(3, 64, 52, 200))
    return place


def detect(*argv):
    return cli.main(["detect", *map(str, argv)])


def objects(text):
    return [json.loads(line) for line in text.splitlines()]


def turn_between(a, b):
    return abs((a - b + 180) % 360 - 180)


def test_json_of_a_folder(folder, capsys):
    assert detect(folder, "--json", *RADIUS) == 0
    out, err = capsys.readouterr()
    first, none, last = objects(out)
    for one in (first, none, last):
        assert list(one) == ["frame", "width", "height", "detections"]
        assert (one["width"], one["height"]) == (128, 112)
    assert first["frame"] == str(folder / "f1.pgm") and last["frame"] == str(folder / "f10.pgm")
    assert none["detections"] == []
    for one, marker_id, x, y, heading in ((first, 5, 60, 55, 30), (last, 3, 64, 52, 200)):
        (found,) = one["detections"]
        assert list(found) == [
            *("id", "x", "y", "heading", "radius", "margin", "flags", "sigma", "heading_sigma")
        ]
        assert found["id"] == marker_id
        assert abs(found["x"] - x) < 0.8 and abs(found["y"] - y) < 0.8
        assert turn_between(found["heading"], heading) < 3
        assert abs(found["radius"] - 30) < 1
        assert 0 <= found["margin"] <= 255 and isinstance(found["flags"], list)
    assert err.startswith("3 frames; 2 with a marker (ID 3: 1, ID 5: 1)") and err.count("\n") == 1


def test_the_paper_method_is_at_hand(folder, capsys):
    assert detect(folder / "f1.pgm", "--json", "--method", "paper", *RADIUS) == 0
    (one,) = objects(capsys.readouterr().out)
    assert one["detections"][0]["id"] == 5


def test_table_and_summary(folder, capsys):
    assert detect(folder, *RADIUS) == 0
    lines = capsys.readouterr().out.splitlines()
    assert " ".join(lines[0].split()) == "frame id x px y px heading deg radius px margin flags"
    assert lines[1].split()[:2] == [str(folder / "f1.pgm"), "5"]
    assert lines[2].split() == [str(folder / "f2.png"), "-"]
    assert lines[3].split()[:2] == [str(folder / "f10.pgm"), "3"]
    assert lines[4].startswith("3 frames; 2 with a marker") and "ms a frame" in lines[4]


def test_an_unknown_radius_needs_no_option(folder, capsys):
    assert detect(folder / "f1.pgm", "--json") == 0
    (one,) = objects(capsys.readouterr().out)
    assert [found["id"] for found in one["detections"]] == [5]


def test_ids_in_use_and_line_width_are_options(tmp_path, capsys):
    save(tmp_path / "thin.pgm", plain_frame(6, radius_px=32.0, line=8))
    assert detect(tmp_path, "--json", "--line-mm", 8, *RADIUS) == 0
    assert detect(tmp_path, "--json", "--line-mm", 8, "--ids", "1,2", *RADIUS) == 0
    reads = [[found["id"] for found in one["detections"]] for one in objects(capsys.readouterr().out)]
    assert reads[0] == [6] and 6 not in reads[1]


def test_what_is_believed_is_an_option(tmp_path, capsys):
    save(tmp_path / "blurred.pgm", render_frame("sunny", 1203, 0, blur_px=10)[0])
    save(tmp_path / "sharp.pgm", render_frame("sunny", 1203, 0)[0])
    save(tmp_path / "tilted.pgm", render_frame("sunny", 1203, 3, tilt_deg=38)[0])

    def ids(*options):
        assert detect(tmp_path, "--json", "--radius-px", "25:35", *options) == 0
        return [[found["id"] for found in one["detections"]] for one in objects(capsys.readouterr().out)]

    assert ids() == [[6], [6], []]
    assert ids("--no-second-opinion") == [[], [6], []]
    assert ids("--margin-min", 120) == [[], [6], []]
    assert ids("--max-tilt", 38) == [[6], [6], [6]]


def test_frames_of_different_sizes_in_one_run(tmp_path, capsys):
    for name, size in (("a.pgm", (128, 112)), ("b.pgm", (160, 120)), ("c.pgm", (128, 112))):
        save(tmp_path / name, plain_frame(6, 60, 55, 100, size=size))
    assert detect(tmp_path, "--json", *RADIUS) == 0
    found = objects(capsys.readouterr().out)
    assert [(one["width"], one["detections"][0]["id"]) for one in found] == [(128, 6), (160, 6), (128, 6)]


def test_drawings(folder, tmp_path, capsys):
    assert detect(folder, folder / "f1.pgm", "--draw", tmp_path / "out" / "deep", *RADIUS) == 0
    names = sorted(path.name for path in (tmp_path / "out" / "deep").iterdir())
    assert names == ["f1-2.png", "f1.png", "f10.png", "f2.png"]
    drawn = cv2.imread(str(tmp_path / "out" / "deep" / "f1.png"))
    assert drawn.shape == (672, 768, 3)
    empty = cv2.imread(str(tmp_path / "out" / "deep" / "f2.png"))
    assert (empty == 120).all()


def test_a_drawing_lies_on_the_marker():
    frame = np.full((100, 120), 200, np.uint8)
    found = {"id": 4, "x": 50.0, "y": 45.0, "heading": 90.0, "radius": 20.0, "margin": 9, "flags": []}
    zoom = 6
    image = drawing.draw_detections(frame, [found], zoom)
    colours = image.astype(int)
    green = colours[..., 1] - colours[..., 2] > 60  # lines are anti-aliased

    def is_green(x, y):
        row, column = round((y + 0.5) * zoom - 0.5), round((x + 0.5) * zoom - 0.5)
        return green[row - 1 : row + 2, column - 1 : column + 2].any()

    # outer ring, inner ring, centre, orientation line upwards: image y runs down
    assert is_green(30, 45) and is_green(50, 65) and is_green(50 + 20 * 0.6, 45 + 20 * 0.8)
    assert is_green(50 - 20 * 2 / 3, 45) and is_green(50, 45) and is_green(50, 45 - 28)
    assert not is_green(50, 45 + 28) and not is_green(50 + 28, 45) and not is_green(10, 10)
    unsure = drawing.draw_detections(frame, [dict(found, id=None)], zoom)
    assert (unsure == drawing.UNCERTAIN).all(axis=2).any()
    assert not (unsure == drawing.CERTAIN).all(axis=2).any()


def test_a_drawing_near_the_border_keeps_its_label_inside():
    frame = np.full((60, 60), 200, np.uint8)
    for x, y in ((0.0, 0.0), (59.0, 59.0), (-10.0, 80.0)):
        found = {"id": 1, "x": x, "y": y, "heading": 10.0, "radius": 20.0, "margin": 255, "flags": []}
        assert drawing.draw_detections(frame, [found]).shape == (720, 720, 3)


def test_units_of_the_json():
    one = Detection()
    one.marker_id, one.x_q8, one.y_q8, one.heading_cdeg = 2, 25600 + 1, 128, 35999
    one.radius_q8, one.margin, one.flags = 7680, 77, FLAG_BORDER
    expected = {"id": 2, "x": 100.0039, "y": 0.5, "heading": 359.99, "radius": 30.0, "margin": 77}
    unknown = {"sigma": None, "heading_sigma": None}
    assert detectors.as_dict(one) == dict(expected, flags=["border"], **unknown)
    one.sigma_q12, one.sigma_mdeg = 48, 120
    assert detectors.as_dict(one)["sigma"] == 0.0117 and detectors.as_dict(one)["heading_sigma"] == 0.12
    one.marker_id, one.flags = NO_ID, FLAG_ID_UNCERTAIN
    assert detectors.as_dict(one)["id"] is None and detectors.as_dict(one)["flags"] == ["id_uncertain"]


@pytest.mark.parametrize("method", detectors.METHODS)
def test_every_method_takes_the_default_range_in_small_and_large_frames(method):
    for size in ((80, 60), (160, 120), (640, 480)):
        assert detectors.make_detector(method, *size) is not None
    with pytest.raises(UserError, match="smaller than a ring"):
        detectors.make_detector(method, 15, 15)
    with pytest.raises(UserError, match="smaller than a ring"):
        detectors.make_detector(method, 80, 60, (40, 50))


def test_a_bad_file_is_reported_and_the_rest_is_done(folder, capsys):
    (folder / "f3.png").write_bytes(b"")
    assert detect(folder, "--json", *RADIUS) == 2
    out, err = capsys.readouterr()
    assert len(objects(out)) == 3
    assert err.splitlines()[0] == "larics: %s: empty file" % (folder / "f3.png")


def test_frames_too_small_are_reported_once(folder, tmp_path, capsys):
    for index in range(3):
        save(folder / ("small%d.pgm" % index), np.zeros((20, 20), np.uint8))
    assert detect(folder, "--json", *RADIUS) == 2
    out, err = capsys.readouterr()
    assert len(objects(out)) == 3 and err.count("smaller than a ring") == 1 and "3 skipped" in err


@pytest.mark.parametrize(
    "argv, part",
    [
        (["nothing.png"], "nothing.png: no such file"),
        ([""], "an empty name of a file or folder"),
        (["empty.pgm"], "empty.pgm: empty file"),
        (["short.pgm"], "short.pgm: truncated"),
        (["deep.png"], "deep.png: a 16-bit image"),
        (["bare"], "bare: no frames in this folder"),
        (["tiny.pgm"], "tiny.pgm: a frame of 12 x 12 px is smaller"),
        (["good.pgm", "--radius-px", "35:25"], "--radius-px"),
        (["good.pgm", "--radius-px", "0:25"], "--radius-px"),
        (["good.pgm", "--radius-px", "-5:25"], "--radius-px"),
        (["good.pgm", "--radius-px", "30"], "--radius-px"),
        (["good.pgm", "--method", "guess"], "guess"),
        (["good.pgm", "--line-mm", "0"], "--line-mm 0"),
        (["good.pgm", "--line-mm", "x"], "--line-mm"),
        (["good.pgm", "--ids", "1;2"], "--ids"),
        (["good.pgm", "--ids", "8"], "--ids"),
        (["good.pgm", "--ids", "0,1"], "--allow-id0"),
        (["good.pgm", "--ids", "1", "--method", "paper"], "--ids"),
        (["good.pgm", "--max-tilt", "41"], "--max-tilt 41"),
        (["good.pgm", "--margin-min", "256"], "--margin-min 256"),
        (["good.pgm", "--margin-min", "40", "--method", "paper"], "--margin-min"),
        (["good.pgm", "--draw", "good.pgm"], "cannot write to good.pgm"),
        ([], "FRAME"),
    ],
)
def test_bad_input_is_one_line(argv, part, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bare").mkdir()
    (tmp_path / "empty.pgm").write_bytes(b"")
    (tmp_path / "short.pgm").write_bytes(b"P5 10 10 255 abc")
    save(tmp_path / "deep.png", np.zeros((112, 128), np.uint16))
    save(tmp_path / "tiny.pgm", np.zeros((12, 12), np.uint8))
    save(tmp_path / "good.pgm", plain_frame(1))
    assert detect(*argv) == 2
    out, err = capsys.readouterr()
    errors = [line for line in err.splitlines() if line.startswith("larics: ")]
    assert len(errors) == 1 and part in errors[0] and "Traceback" not in err and len(errors[0]) < 300


def test_a_printed_marker_is_detected(tmp_path, capsys):
    """The printed PNG, seen as if by a camera: what is printed is what is read."""
    path = tmp_path / "m.png"
    assert cli.main(["marker", "6", "-o", str(path), "--dpi", "25.4"]) == 0  # 1 px per mm
    sheet = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    save(tmp_path / "seen.png", cv2.resize(sheet, None, fx=0.2, fy=0.2, interpolation=cv2.INTER_AREA))
    capsys.readouterr()
    assert detect(tmp_path / "seen.png", "--json", *RADIUS) == 0
    (one,) = objects(capsys.readouterr().out)
    (found,) = one["detections"]
    assert found["id"] == 6 and turn_between(found["heading"], 0) < 1.5
    assert abs(found["x"] - one["width"] / 2) < 1.5
