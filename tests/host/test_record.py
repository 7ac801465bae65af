"""`larics record`: the frames of a real firmware, byte for byte, and those of an ImageIO stream."""

import json

import numpy as np
import pytest

from larics.settings import Settings
from larics_host import cli
from larics_host.images.frame_folder import write_frame
from larics_host.images.frame_sources import open_frames
from larics_host.images.openmv_stream import GRAYSCALE
from larics_host.validation.board import HostRun, compare_messages
from tests.host.plain_marker import plain_frame, stained_frame
from tests.host.test_frames import stream_v2
from tests.host.test_log import marker_values, wire
from tests.host.test_monitor import firmware


def stream_of(pictures):
    return stream_v2(*((GRAYSCALE, p.shape[1], p.shape[0], p.tobytes(), p.size) for p in pictures))


def record(*argv):
    return cli.main(["record", *map(str, argv)])


def test_frames_of_a_camera_with_the_messages_about_them(tmp_path, capsys):
    with firmware(tmp_path) as (device, frames):
        assert record("--port", device, "--frames", 3, "-o", tmp_path / "seen") == 0
        assert "3 frames" in capsys.readouterr().out
        assert record("--port", device, "--frames", 1, "-o", tmp_path / "seen") == 2
        assert "holds frames already" in capsys.readouterr().err
        assert record("--port", device, "--frames", 1, "--window", "-o", tmp_path / "window") == 0
    (window,) = (tmp_path / "window").glob("*.pgm")
    original = frames / ("f%02d.pgm" % (int(window.stem.split("_")[1]) % 40))
    assert window.read_bytes() == original.read_bytes()  # nothing but the marker on an even ground
    seen = sorted((tmp_path / "seen").glob("*.pgm"))
    assert len(seen) == 3
    lines = (tmp_path / "seen" / "messages.jsonl").read_text().splitlines()
    records = [json.loads(line) for line in lines]
    reported = {r["frame"] for r in records if r["message"] == "MARKER"}
    for path in seen:
        number = int(path.stem.split("_")[1])
        assert path.read_bytes() == (frames / ("f%02d.pgm" % (number % 40))).read_bytes()
        assert number in reported
    settings = json.loads((tmp_path / "seen" / "settings.json").read_text())
    assert settings["focal_q8"] == 300 * 256 and len(settings["map"]) == 2

    # the very same frames here: the board's messages are those of this computer
    log = tmp_path / "seen" / "messages.jsonl"
    compare = ["validate", str(tmp_path / "seen"), "--settings", str(tmp_path / "seen" / "settings.json")]
    page = tmp_path / "report.html"
    assert cli.main([*compare, "--board", str(log), "--report", str(page)]) == 0
    assert "board: 3 of 3 frames reported alike; 0 not in the log" in capsys.readouterr().out
    assert "3 of 3 frames reported alike" in page.read_text()
    number = int(seen[1].stem.split("_")[1])
    for one in records:
        if one["message"] == "MARKER" and one["frame"] == number:
            one["x_mm10"] += 1
    log.write_text("".join(json.dumps(one) + "\n" for one in records))
    assert cli.main([*compare, "--board", str(log), "--json", str(tmp_path / "r.json")]) == 1
    result = json.loads((tmp_path / "r.json").read_text())["board"]
    assert (result["compared"], result["equal"]) == (3, 2)
    (difference,) = result["differences"]
    assert difference["field"] == "x_mm10" and difference["board"] == difference["host"] + 1
    assert "marker 0 x_mm10: board" in capsys.readouterr().out


def test_frames_of_a_stream_with_a_log_beside(tmp_path, capsys):
    pictures = [plain_frame(k, heading_deg=40 * k) for k in (1, 2, 3)]
    (tmp_path / "clip.bin").write_bytes(stream_of(pictures))
    (tmp_path / "raw.bin").write_bytes(wire((2, marker_values(0))))
    assert cli.main(["log", "--input", str(tmp_path / "raw.bin"), "-o", str(tmp_path / "run")]) == 0
    log = tmp_path / "run.jsonl"
    assert record("--input", tmp_path / "clip.bin", "--log", log, "-o", tmp_path / "seen") == 0
    assert (tmp_path / "seen" / "messages.jsonl").read_bytes() == log.read_bytes()
    found = [frame for _, frame in open_frames([tmp_path / "seen"])]
    assert len(found) == 3 and all(np.array_equal(a, b) for a, b in zip(found, pictures, strict=True))
    again = ("-o", tmp_path / "seen", "--overwrite")
    assert record("--input", tmp_path / "clip.bin", "--frames", 2, *again) == 0
    assert len(list((tmp_path / "seen").glob("*.pgm"))) == 2


@pytest.mark.parametrize(
    "argv, part",
    [
        (["-o", "x"], "--port --input"),
        (["--port", "/dev/no-port", "-o", "x"], "no port /dev/no-port"),
        (["--input", "none.bin", "-o", "x"], "none.bin: no such file"),
        (["--input", "clip.bin", "--log", "none.jsonl", "-o", "x"], "cannot read none.jsonl"),
        (["--port", "/dev/null", "--log", "a.jsonl", "-o", "x"], "--log goes with --input"),
        (["--input", "clip.bin", "--frames", "0", "-o", "x"], "--frames 0"),
        (["--input", "clip.bin", "--seconds", "-1", "-o", "x"], "--seconds -1"),
        (["--input", "clip.bin", "--window", "-o", "x"], "--window goes with --port"),
        (["--input", "clip.bin", "-o", "clip.bin"], "cannot write to clip.bin"),
    ],
)
def test_bad_input_is_one_line(argv, part, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "clip.bin").write_bytes(stream_of([plain_frame(1)]))
    assert record(*argv) == 2
    err = capsys.readouterr().err
    assert err.startswith("larics: ") and part in err and err.count("\n") == 1
    assert not (tmp_path / "x").exists()


def test_a_board_with_a_small_heap_reports_what_it_can(tmp_path):
    """It does without weighing all that was measured where a rule refuses a marker, as of a stained one."""
    pictures = [plain_frame(k, 70.0, 66.0, 0, size=(148, 132)) for k in (1, 2)] + [stained_frame()]
    for number, one in enumerate(pictures):
        write_frame(tmp_path / ("frame_%06d.pgm" % number), one)
    settings = Settings({"radius_min_px": 24, "radius_max_px": 34, "width": 148, "height": 132})
    runs = HostRun(settings), HostRun(settings, weigh_all=False)
    usual, small = ([one for k, p in enumerate(pictures) for one in run.messages(k, p)] for run in runs)
    assert usual[2]["id"] == 6 and small[2]["id"] is None
    wrong = [small[0], dict(small[1], margin=small[1]["margin"] - 1), small[2]]
    for records, equal in ((usual, 3), (small, 3), (wrong, 2)):
        lines = [dict(one, message="MARKER", time_s=k, sequence=k) for k, one in enumerate(records)]
        (tmp_path / "log.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
        result = compare_messages(tmp_path, tmp_path / "log.jsonl", settings)
        assert (result["compared"], result["equal"]) == (3, equal)
    assert [one["field"] for one in result["differences"]] == ["margin"]
