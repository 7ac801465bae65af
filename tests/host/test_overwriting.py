"""No command overwrites what it reads or what it is not asked to."""

import json
import os

import cv2
import pytest

from larics.wire import messages as m
from larics_host import cli, files
from larics_host.truth import Truth, write_truth
from tests.host.plain_marker import plain_frame
from tests.host.test_dual import ROOT
from tests.host.test_log import marker_values, wire

RECORD_LOG = ["--input", "a.png", "--log", "run.jsonl", "-o", "."]
HALL = '{"version": 1, "markers": [{"id": 3, "x_mm": 0, "y_mm": 0, "heading_deg": 0}]}'


@pytest.mark.parametrize(
    "argv, words",
    [
        (
            ["detect", "frames", "--draw", "frames"],
            "--draw frames would overwrite the frames: choose",
        ),
        (["detect", "frames/a.png", "--draw", "frames"], "--draw frames would overwrite the frames"),
        (["fleet", "run.jsonl", "--report", "run.jsonl"], "run.jsonl exists and is no page: choose another"),
        (["validate", "frames", "--report", "frames/truth.csv"], "truth.csv exists and is no page"),
        (["map", "draw", "hall.json", "-o", "hall.json"], "hall.json exists and is no picture"),
        (["map", "build", "run.jsonl", "-o", "new.json", "--png", "hall.json"], "hall.json exists and is no"),
        (
            ["calibrate", "--places", "frames", "--plot", "frames/a.png"],
            "frames/a.png would overwrite what",
        ),
        (["calibrate", "--places", "frames", "--plot", "hall.json"], "hall.json exists and is no picture"),
        (
            ["calibrate", "--turn", "frames/a-turn.png", "--plot", "frames/a.png"],
            "a-turn.png would over",
        ),
    ],
)
def test_what_is_read_and_what_is_of_another_kind_is_not_overwritten(
    argv, words, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "frames").mkdir()
    for name in ("frames/a.png", "frames/a-turn.png"):
        cv2.imwrite(name, plain_frame(5))
    for name, text in (("run.jsonl", "{}"), ("frames/truth.csv", "frame,id"), ("hall.json", HALL)):
        (tmp_path / name).write_text(text)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert cli.main(argv) == 2
    err = capsys.readouterr().err
    assert words in err and err.count("\n") == 1
    assert before == {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    "argv, words",
    [
        (["map", "draw", "hall.json", "-o", "o.svg"], "o.svg: the picture is a PNG: name it o.png"),
        (["map", "build", "run.jsonl", "-o", "new.json", "--png", "o"], "o: the picture is a PNG"),
        (["calibrate", "--places", "frames", "--plot", "o.pdf"], "o.pdf: the picture is a PNG"),
        (["fleet", "run.jsonl", "--report", "o.pdf"], "o.pdf: the page is HTML: name it o.html"),
        (["validate", "frames", "--report", "o.txt"], "o.txt: the page is HTML: name it o.html"),
    ],
)
def test_a_picture_or_page_is_not_named_as_another_kind(argv, words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "frames").mkdir()
    for name, text in (("run.jsonl", "{}"), ("hall.json", HALL)):
        (tmp_path / name).write_text(text)
    assert cli.main(argv) == 2
    err = capsys.readouterr().err
    assert words in err and err.count("\n") == 1
    assert not list(tmp_path.glob("o*"))


NEW = "frames/new.png"
REFUSED = [  # (command, option, arguments, file that is there, words)
    ("marker", "-o --output", ["5", "-o", "here.pdf"], "here.pdf", "--force"),
    ("log", "-o --output", ["--input", "run.bin", "-o", "here"], "here.jsonl", "--force"),
    ("log", "-o --output", ["--input", "run.bin", "-o", "here", "--raw"], "here.bin", "--force"),
    ("settings export", "FILE.json", ["--port", "nowhere", "here.json"], "here.json", "--force"),
    ("calibrate", "-o --output", ["--places", "frames", "-o", "here.json"], "here.json", "--force"),
    ("calibrate", "--plot", ["--places", "frames", "--plot", "here.png"], "here.png", "is no picture"),
    (
        "calibrate",
        "--plot",
        ["--places", "frames", "--plot", NEW],
        "here.png",
        "would lie among",
    ),
    ("calibrate", "--plot", ["--turn", "frames", "--plot", NEW], "here.png", "would lie among"),
    ("map create", "MAP.json", ["here.json", "--marker", "3,0,0,0,"], "here.json", "--force"),
    ("map build", "-o --output", ["run.bin", "-o", "here.json"], "here.json", "--force"),
    ("map build", "--png", ["run.bin", "-o", "new.json", "--png", "here.png"], "here.png", "is no picture"),
    ("map draw", "-o --output", ["hall.json", "-o", "here.png"], "here.png", "is no picture"),
    ("fleet", "-o --output", ["run.bin", "-o", "."], "findings.csv", "--force"),
    ("fleet", "-o --output", ["run.bin", "-o", ".", "--format", "parquet"], "markers.parquet", "--force"),
    ("fleet", "--report", ["run.bin", "--report", "here.html"], "here.html", "is no page"),
    ("validate", "--json", ["frames", "--json", "here.json"], "here.json", "--force"),
    ("validate", "--report", ["frames", "--report", "here.html"], "here.html", "is no page"),
    ("detect", "--draw", ["frames", "--draw", "frames"], "frames/b.png", "would overwrite the frames"),
    ("record", "-o --output", ["--input", "a.png", "-o", "."], "frame_000000.pgm", "--overwrite"),
    ("record", "-o --output", RECORD_LOG, "messages.jsonl", "--overwrite"),
    ("simulate", "-o --output", ["-o", "."], "frame_000000.pgm", "--overwrite"),
    ("simulate", "-o --output", ["-o", "."], "truth.csv", "--overwrite"),
    ("simulate", "-o --output", ["-o", ".", "--drive", "loop"], "score.json", "--overwrite"),
    ("simulate", "-o --output", ["-o", ".", "--tour"], "clip.bin", "--overwrite"),
]
_WRITTEN = ("-o --output", "--report", "--plot", "--png", "--draw", "--json")  # options that name such files


@pytest.mark.parametrize("command, option, argv, there, words", REFUSED)
def test_no_command_overwrites_what_it_is_not_asked_to(
    command, option, argv, there, words, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "frames").mkdir()
    for name in ("a.png", "frames/a.png"):
        cv2.imwrite(name, plain_frame(5))
    (tmp_path / "frames" / "truth.csv").write_text("frame,id")
    (tmp_path / "run.bin").write_bytes(wire((m.MARKER, marker_values(0))))
    if "--log" in argv:
        assert cli.main(["log", "--input", "run.bin", "-o", "run"]) == 0
        capsys.readouterr()
    (tmp_path / "hall.json").write_text(HALL)
    (tmp_path / there).write_text("kept")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert cli.main([*command.split(), *argv]) == 2
    err = capsys.readouterr().err
    assert words in err and err.count("\n") == 1
    assert before == {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}


def test_all_commands_that_write_are_asked_not_to_overwrite():
    rows = [line.split("|") for line in (ROOT / "tests/freeze/commands.txt").read_text().splitlines()]
    writing = {
        (row[0].strip().removeprefix("larics "), row[1].strip())
        for row in rows
        if row[1:] and row[1].strip() in _WRITTEN and row[2].strip() != "nothing"
    }
    assert writing > {("fleet", "--report"), ("validate", "--json")}
    assert writing <= {row[:2] for row in REFUSED}


def test_force_and_devices_are_no_files_to_keep(tmp_path, capsys):
    """Tables and figures are replaced where that is asked for, and written to a pipe or a device."""
    frames, figures = tmp_path / "frames", tmp_path / "figures.json"
    frames.mkdir()
    cv2.imwrite(str(frames / "a.png"), plain_frame(5))
    write_truth(frames / "truth.csv", [Truth("a.png")])
    figures.write_text("before")
    words = "validate", str(frames), "--radius-px", "20:40", "--json"
    assert cli.main([*words, str(figures), "--force"]) == 0 == cli.main([*words, os.devnull])
    assert json.loads(figures.read_text())["version"] == 1
    run, tables = tmp_path / "run.bin", tmp_path / "tables"
    run.write_bytes(wire(*[(m.MARKER, marker_values(k)) for k in range(30)]))
    words = "fleet", str(run), "-o", str(tables), "--jobs", "1"
    assert [cli.main([*words, *more]) for more in ((), (), ("--force",))] == [0, 2, 0]


def test_pages_and_pictures_are_made_anew(tmp_path, capsys):
    hall, picture = tmp_path / "hall.json", tmp_path / "hall.png"
    hall.write_text(HALL)
    for _ in range(2):
        assert cli.main(["map", "draw", str(hall), "-o", str(picture)]) == 0
    assert picture.read_bytes().startswith(files.PICTURE)
