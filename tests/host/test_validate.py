"""`larics validate`: figures against counting by hand, comparison, thresholds, report."""

import json
import re

import cv2
import numpy as np
import pytest
from plain_marker import plain_frame

from larics_host import cli
from larics_host.detection import batch
from larics_host.detection.options import DetectionOptions
from larics_host.truth import Truth, write_truth

RADIUS = ("--radius-px", "25:35")
MARKERS = ((5, 60.0, 55.0, 30.0), (3, 64.25, 52.5, 200.0), (7, 66.0, 60.0, 300.0))


def truth(frame, marker_id, x, y, heading, visible=1.0):
    return Truth(frame, 0, marker_id, x, y, heading, 30.0, visible=visible)


@pytest.fixture
def folder(tmp_path):
    """Three markers, a frame without one, and a frame in which the truth claims one that is not there."""
    place = tmp_path / "frames"
    place.mkdir()
    truths = []
    for index, (marker_id, x, y, heading) in enumerate(MARKERS):
        name = "f%d.pgm" % index
        cv2.imwrite(str(place / name), plain_frame(marker_id, x, y, heading))
        truths.append(truth(name, marker_id, x, y, heading))
    for name in ("f3.pgm", "f4.pgm"):
        cv2.imwrite(str(place / name), np.full((112, 128), 120, np.uint8))
    truths += [Truth("f3.pgm"), truth("f4.pgm", 2, 60, 55, 0)]
    write_truth(place / "truth.csv", truths)
    return place


def validate(*argv):
    return cli.main(["validate", *map(str, argv)])


def log_of(folder, path, capsys, change=lambda record: None):
    """A log of detections, changed line by line."""
    assert cli.main(["detect", str(folder), "--json", *RADIUS]) == 0
    records = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    for record in records:
        change(record)
    path.write_text("".join(json.dumps(record) + "\n" for record in records))
    return path


def test_figures_of_a_folder(folder, tmp_path, capsys):
    assert validate(folder, *RADIUS, "--json", tmp_path / "r.json") == 0
    printed = capsys.readouterr().out
    assert "75.000 %" in printed
    result = json.loads((tmp_path / "r.json").read_text())
    assert result["version"] == 1 and len(result["methods"]) == 1
    figures = result["methods"][0]
    expected = {"frames": 5, "markers": 4, "detected_pct": 75.0, "read_pct": 75.0, "wrong": 0}
    assert {key: figures[key] for key in expected} == expected
    assert figures["centre_max_px"] < 0.2 and figures["heading_max_deg"] < 0.5
    confusion = figures["confusion"]
    assert confusion["true"] == [2, 3, 5, 7] and confusion["reported"] == [3, 5, 7, "missed"]
    assert confusion["counts"] == [[0, 0, 0, 1], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]
    assert figures["worst"][0] == {"frame": "f4.pgm", "why": "missed"}


def test_a_log_is_scored_like_a_method_and_versions_are_compared(folder, tmp_path, capsys):
    def spoil(record):
        for one in record["detections"]:
            if one["id"] == 5:
                one["id"] = 4
            elif one["id"] == 3:
                one["id"] = None
            else:
                one["x"] += 100
        if record["frame"].endswith("f4.pgm"):
            record["detections"].append(
                {"id": 2, "x": 60.0, "y": 55.4, "heading": 1.5, "radius": 30.0, "margin": 9, "flags": []}
            )

    old = log_of(folder, tmp_path / "old.jsonl", capsys)
    new = log_of(folder, tmp_path / "new.jsonl", capsys, spoil)
    assert validate(folder, "--detections", old, "--against", new, "--json", "-") == 0
    result = json.loads(capsys.readouterr().out)
    old.write_text(old.read_text().replace("/", "\\\\"))  # as Windows writes names of frames
    assert validate(folder, "--detections", old, "--against", new, "--json", "-") == 0
    assert json.loads(capsys.readouterr().out)["methods"] == result["methods"]
    first, second = result["methods"]
    assert (first["label"], second["label"]) == ("old", "new") and first["detected_pct"] == 75.0
    assert (second["wrong"], second["uncertain"], second["false_positives"]) == (1, 1, 1)
    assert second["detected_pct"] == 75.0 and second["read_pct"] == 25.0
    assert [one["why"] for one in second["worst"][:3]] == ["wrong ID", "false detection", "ID uncertain"]
    compared = result["comparison"]
    assert compared["read_only_by_first"] == ["f0.pgm", "f1.pgm", "f2.pgm"]
    assert compared["read_only_by_second"] == ["f4.pgm"] and compared["same_within_1px"] == 2
    assert {"first": "right", "second": "wrong", "count": 1} in compared["markers"]


def test_methods_are_compared(folder, tmp_path, capsys):
    assert validate(folder, *RADIUS, "--against", "paper", "--json", tmp_path / "r.json") == 0
    labels = [one["label"] for one in json.loads((tmp_path / "r.json").read_text())["methods"]]
    assert labels == ["larics", "paper"]


@pytest.mark.parametrize(
    "limits, code",
    [
        (("--min-detected", "75", "--max-wrong", "0", "--max-centre-px", "0.3"), 0),
        (("--min-detected", "75.1"), 1),
        (("--max-centre-px", "0.000001"), 1),
        (("--max-wrong", "0", "--max-false", "0", "--max-heading-deg", "1", "--min-read", "70"), 0),
    ],
)
def test_thresholds_decide_the_exit_code(folder, limits, code, capsys):
    assert validate(folder, *RADIUS, *limits) == code
    assert ("FAILED" in capsys.readouterr().out) == bool(code)


def test_the_report_is_one_file_with_pictures(folder, tmp_path, capsys):
    page = tmp_path / "report.html"
    assert validate(folder, *RADIUS, "--report", page, "--worst", "2", "--max-wrong", "0") == 0
    text = page.read_text()
    assert not re.search(r"https?://|<script|<link", text)
    assert text.count("data:image/jpeg;base64,") == 2 and text.count("data:image/png;base64,") == 2
    assert "f4.pgm: missed" in text and "--max-wrong 0" in text


def test_processes_give_the_same_as_one(folder):
    paths = [str(folder)]
    one = list(batch.detect_all(paths, DetectionOptions(radius_px=(25, 35)), jobs=1))
    two = list(batch.detect_all(paths, DetectionOptions(radius_px=(25, 35)), jobs=2, keep_frames=True))
    assert [r.name for r in one] == [r.name for r in two] and len(one) == 5
    assert [r.found for r in one] == [r.found for r in two]
    assert all(r.frame.shape == (112, 128) for r in two) and one[0].frame is None


@pytest.mark.parametrize(
    "argv, part",
    [
        (["nowhere"], "cannot read nowhere"),
        (["frames", "--detections", "none.jsonl"], "cannot read none.jsonl"),
        (["frames", "--detections", "frames/truth.csv"], "truth.csv line 1 is not from larics detect"),
        (["frames", "--detections", "frames/f0.pgm"], "f0.pgm is no text"),
        (["frames", "--detections", "other.jsonl"], "other has none of the frames that the truth names"),
        (["frames", "--board", "none.jsonl"], "--board needs the --settings"),
        (["frames", "--settings", "s.json"], "--settings are those of the board: they go with --board"),
        (["frames", "--board", "none.jsonl", "--settings", "s.json"], "cannot read none.jsonl"),
        (
            ["frames", "--board", "other.jsonl", "--settings", "s.json"],
            "other.jsonl line 1 is not from larics log",
        ),
        (["frames", "--min-detected", "-1"], "--min-detected -1"),
        (["frames", "--min-read", "101"], "--min-read 101: give a share of at most 100 %"),
        (["frames", "--jobs", "0"], "--jobs 0"),
        (["frames", "--worst", "-3"], "--worst -3"),
        (["frames", "--json", "no/such/place.json", *RADIUS], "cannot write no/such/place.json"),
        (["frames", "--report", "no/such/place.html", *RADIUS], "cannot write no/such/place.html"),
    ],
)
def test_bad_input_is_one_line(argv, part, folder, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.json").write_text("{}")
    (tmp_path / "other.jsonl").write_text('{"frame": "x.pgm", "detections": []}\n')
    assert validate(*argv) == 2
    err = capsys.readouterr().err
    assert err.startswith("larics: ") and part in err and err.count("\n") == 1
