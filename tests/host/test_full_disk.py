"""Disks without room: what is written is whole, what is kept is told, no traceback."""

import json
import resource
import subprocess
import sys

import pytest

from larics_host import cli, files
from larics_host.logs.log_reader import read_pieces
from larics_host.truth import read_truth
from tests.host.larics_process import COMMAND, ENVIRONMENT, recorded
from tests.host.test_dual import ROOT
from tests.host.test_log import rows
from tests.host.waiting import PATIENCE_S


def run_with_room(size, *argv, **more):
    """(exit code, standard error) of larics when no file can become larger than `size` bytes."""

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    result = subprocess.run(
        [*COMMAND, *map(str, argv)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env=ENVIRONMENT,
        preexec_fn=limit,
        timeout=PATIENCE_S,
        **more,
    )
    assert "Traceback" not in result.stderr
    return result.returncode, result.stderr


@pytest.mark.parametrize("size", [0, 60, 5000, 20000])
def test_a_log_without_room_keeps_whole_messages(tmp_path, size):
    prefix = tmp_path / "out"
    code, err = run_with_room(size, "log", "--input", recorded(tmp_path), "-o", prefix, "--mcap", "--raw")
    assert code == 2 and err.count("\n") == 1 and "cannot write %s" % prefix in err
    left = sorted(path.name for path in tmp_path.glob("out.*"))
    if size < 1000:
        assert not [name for name in left if name != "out.bin"]
        return
    assert "written to" in err and all(str(tmp_path / name) in err for name in left)
    for name in ("out.csv", "out.jsonl"):
        data = (tmp_path / name).read_bytes()
        assert 0 < len(data) <= size and data.endswith(b"\n")
    count = len((tmp_path / "out.jsonl").read_text().splitlines())
    assert abs(len(rows(tmp_path / "out.csv")) - count) <= 1
    assert [json.loads(line)["frame"] for line in (tmp_path / "out.jsonl").read_text().splitlines()] == list(
        range(count)
    )
    if size >= 20000:  # there is room for the one chunk of the bag, or for nothing of it
        found = list(read_pieces(tmp_path / "out.mcap"))
        assert found and found == list(read_pieces(tmp_path / "out.jsonl"))[: len(found)]


def test_a_bag_without_any_room_leaves_nothing(tmp_path):
    code, err = run_with_room(10, "log", "--input", recorded(tmp_path), "-o", tmp_path / "out", "--bag")
    assert code == 2 and err.count("\n") == 1 and "cannot write %s" % tmp_path in err
    assert not (tmp_path / "out").exists()


FILL = """
import random, resource, sys
from larics.wire import messages as m
from larics_host.connection.receiver import message_of
from larics_host.files import CannotWrite
from larics_host.logs.mcap_log import McapLog

log, draw = McapLog(sys.argv[1], 0), random.Random(1)  # what zstd cannot make small
resource.setrlimit(resource.RLIMIT_FSIZE, (160000, 300000))
try:
    for k in range(2000):
        log.write(message_of(m.RAW_CHUNK, k, (1, k, 1, 8, draw.randbytes(64)), k / 1000))
except CannotWrite as error:
    print(error)
resource.setrlimit(resource.RLIMIT_FSIZE, (300000, 300000))
log.close()  # there is room again, too late
"""


def test_a_bag_of_which_a_chunk_had_no_room_gets_no_index(tmp_path, capsys):
    path = tmp_path / "run.mcap"
    result = subprocess.run(
        [sys.executable, "-c", FILL, str(path)], env=ENVIRONMENT, capture_output=True, text=True
    )
    assert result.returncode == 0 and "cannot write %s: File too large" % path in result.stdout
    whole = path.read_bytes()
    assert 100000 < len(whole) <= 160000 and not whole.endswith(b"\x89MCAP0\r\n")
    assert 800 < sum(1 for _ in read_pieces(path)) < 2000
    assert "was cut off" in capsys.readouterr().err


def test_a_simulation_without_room_keeps_frames_that_have_their_truth(tmp_path):
    size = ["--width", "64", "--height", "48", "--radius-px", "8", "--frames", "60"]
    assert cli.main(["simulate", *size, "-o", str(tmp_path / "warm")]) == 0  # compiles all of the loops
    folder = tmp_path / "frames"
    code, err = run_with_room(4000, "simulate", *size, "-o", folder)
    assert code == 2 and err.count("\n") == 1 and "truth.csv: File too large" in err
    names = sorted(path.name for path in folder.glob("*.pgm"))
    assert 3 < len(names) < 60 and "%d frames kept in %s" % (len(names), folder) in err
    assert sorted({truth.frame for truth in read_truth(folder)}) == names
    code, err = run_with_room(1000, "simulate", *size, "-o", tmp_path / "none")
    assert code == 2 and "frame_000000.pgm: File too large" in err and not (tmp_path / "none").exists()


def test_a_file_is_whole_or_as_it_was_before(tmp_path):
    target = tmp_path / "hall.json"
    argv = ["map", "create", target, "--marker", "3,0,0,0"]
    code, err = run_with_room(20, *argv)
    assert code == 2 and err == "larics: cannot write %s: File too large\n" % target
    assert list(tmp_path.iterdir()) == []
    target.write_text("before")
    target.chmod(0o640)
    code, err = run_with_room(20, *argv, "--force")
    assert code == 2 and "File too large; the one before is kept" in err
    assert target.read_text() == "before" and list(tmp_path.iterdir()) == [target]
    assert cli.main([*map(str, argv), "--force"]) == 0
    assert json.loads(target.read_text())["markers"] and target.stat().st_mode & 0o777 == 0o640
    link = tmp_path / "link.json"
    link.symlink_to(target)
    files.write_file(link, "through")
    assert link.is_symlink() and target.read_text() == "through"


@pytest.mark.parametrize(
    "argv",
    [
        ["marker", "3", "-o", "/dev/full"],
        ["marker", "3", "-o", "{folder}/m.svg"],
        ["marker", "3", "5", "-o", "{folder}/m.svg"],
        ["map", "draw", "{hall}", "-o", "{folder}/m.png"],
        ["detect", "{frame}", "--draw", "{folder}/drawn"],
    ],
)
def test_every_output_that_has_no_room_is_named(tmp_path, argv):
    hall, frame = tmp_path / "hall.json", ROOT / "tests" / "frames" / "sunny_r30_1000_0.pgm"
    assert cli.main(["map", "create", str(hall), "--marker", "3,0,0,0"]) == 0
    folder = tmp_path / "out"
    folder.mkdir()
    words = [word.format(folder=folder, hall=hall, frame=frame) for word in argv]
    code, err = run_with_room(100, *words)
    assert code == 2 and err.count("\n") == 1
    assert ("cannot write %s" % folder in err) or "/dev/full" in err
    assert not [path for path in folder.rglob("*") if path.is_file()]


def test_standard_output_without_room_is_named(tmp_path):
    with open("/dev/full", "w") as full:
        result = subprocess.run(
            [*COMMAND, "detect", "--json", str(ROOT / "tests" / "frames" / "sunny_r30_1000_0.pgm")],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            env=ENVIRONMENT,
        )
    assert result.returncode == 2
    assert "larics: cannot write to standard output: No space left on device\n" in result.stderr
    assert "Traceback" not in result.stderr and "Exception ignored" not in result.stderr
