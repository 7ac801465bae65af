"""Full disks, closed outputs and Ctrl-C: what is written is whole, what is kept is told, no traceback."""

import datetime
import json
import os
import resource
import signal
import subprocess
import sys

import cv2
import pytest

from larics.wire import messages as m
from larics_host import cli, files
from larics_host.connection.pty_pair import PtyPair
from larics_host.drive import simulation
from larics_host.logs.log_reader import read_pieces
from larics_host.truth import Truth, read_truth, write_truth
from tests.host.plain_marker import plain_frame
from tests.host.test_dual import ROOT
from tests.host.test_log import marker_values, rows, status_values, wait_for_lines, wire, write_all
from tests.host.test_monitor import firmware
from tests.host.waiting import PATIENCE_S

ENVIRONMENT = dict(os.environ, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"))
COMMAND = [sys.executable, "-m", "larics_host"]
RECORD_LOG = ["--input", "a.png", "--log", "run.jsonl", "-o", "."]
HALL = '{"version": 1, "markers": [{"id": 3, "x_mm": 0, "y_mm": 0, "heading_deg": 0}]}'


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


@pytest.fixture
def run_bin(tmp_path):
    values = [(m.MARKER, marker_values(k)) for k in range(200)]
    (tmp_path / "run.bin").write_bytes(wire(*values, (m.STATUS, status_values())))
    return tmp_path / "run.bin"


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


@pytest.mark.parametrize("size", [0, 60, 5000, 20000])
def test_a_log_without_room_keeps_whole_messages(run_bin, tmp_path, size):
    prefix = tmp_path / "out"
    code, err = run_with_room(size, "log", "--input", run_bin, "-o", prefix, "--mcap", "--raw")
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


def test_a_bag_without_any_room_leaves_nothing(run_bin, tmp_path):
    code, err = run_with_room(10, "log", "--input", run_bin, "-o", tmp_path / "out", "--bag")
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


FRAME = str(ROOT / "tests" / "frames" / "sunny_r30_1000_0.pgm")


@pytest.mark.parametrize(
    "closed, argv",
    [
        ("reader", ["detect", "--json", FRAME]),
        ("stdout", ["detect", FRAME]),
        ("reader", ["settings", "show", "--port", "{port}"]),
        ("stdout", ["settings", "show", "--port", "{port}"]),
        ("reader", ["settings", "show", "--port", "{port}", "--json"]),
        ("stdout", ["map", "check", "{hall}"]),
        ("reader", ["replay", "{log}", "--stdout", "--fast"]),
        ("reader", ["log", "--input", "{log}", "-o", "-"]),
        ("reader", ["monitor", "--input", "{log}", "--speed", "0"]),
        ("reader", ["--help"]),
    ],
    ids=str,
)
def test_an_output_that_nobody_reads_ends_every_command_alike(camera, run_bin, tmp_path, argv, closed):
    hall = tmp_path / "hall.json"
    assert cli.main(["map", "create", str(hall), "--marker", "3,0,0,0"]) == 0
    words = [word.format(port=camera, hall=hall, log=run_bin) for word in argv]
    reader, writer = os.pipe()
    os.close(reader)
    result = subprocess.run(
        [*COMMAND, *words],
        stdout=writer,
        stderr=subprocess.PIPE,
        text=True,
        env=ENVIRONMENT,
        preexec_fn=(lambda: os.close(1)) if closed == "stdout" else None,
        timeout=PATIENCE_S,
    )
    os.close(writer)
    assert result.returncode == 141
    # the sums of what was done may stand there, nothing else
    assert not [line for line in result.stderr.splitlines() if not line.startswith(("1 frame", "201 mess"))]


@pytest.fixture(scope="module")
def camera(tmp_path_factory):
    with firmware(tmp_path_factory.mktemp("camera")) as (device, _):
        yield device


def test_json_lines_go_to_standard_output_as_they_come(tmp_path):
    with PtyPair() as cable:
        before = datetime.datetime.now(datetime.UTC)
        process = subprocess.Popen(
            [*COMMAND, "log", "--port", cable.device_b, "-o", "-"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=ENVIRONMENT,
            cwd=tmp_path,
        )
        for k in range(3):
            while True:  # until the port is open, what is sent is lost
                write_all(cable.device_a, wire((m.MARKER, marker_values(k))))
                if k or select_readable(process.stdout, 0.1):
                    break
            record = json.loads(process.stdout.readline())
            while record["frame"] != k:  # sent more than once
                record = json.loads(process.stdout.readline())
            moment = datetime.datetime.fromisoformat(record["time"])
            assert before <= moment <= datetime.datetime.now(datetime.UTC)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0 and "received" in err and list(tmp_path.iterdir()) == []


def select_readable(file, limit_s):
    import select

    return bool(select.select([file], [], [], limit_s)[0])


def test_the_time_of_bytes_recorded_earlier_is_not_known(run_bin, tmp_path, capsys):
    assert cli.main(["log", "--input", str(run_bin), "-o", "-"]) == 0
    out, err = capsys.readouterr()
    assert all(json.loads(line)["time"] is None for line in out.splitlines()) and "201 messages" in err
    assert cli.main(["log", "--input", str(run_bin), "-o", "-", "--raw"]) == 2
    assert "need the name of a file" in capsys.readouterr().err


def test_absolute_times_stand_in_the_lines_of_a_log(tmp_path):
    with PtyPair() as cable:
        process = subprocess.Popen(
            [*COMMAND, "log", "--port", cable.device_b, "-o", str(tmp_path / "run")], env=ENVIRONMENT
        )
        wait_for_lines(tmp_path / "run.csv", 1)
        before = datetime.datetime.now(datetime.UTC)
        write_all(cable.device_a, wire((m.MARKER, marker_values(1))))
        wait_for_lines(tmp_path / "run.jsonl", 1)
        after = datetime.datetime.now(datetime.UTC)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=PATIENCE_S)
    (record,) = map(json.loads, (tmp_path / "run.jsonl").read_text().splitlines())
    assert record["time"].endswith("Z") and before <= datetime.datetime.fromisoformat(record["time"]) <= after


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_drive_that_is_interrupted_keeps_what_was_driven(tmp_path, monkeypatch, capfd, number):
    firmwares = []
    report_frame = simulation.Simulation._report_frame

    def interrupted(self, firmware, index, *exposed):
        if index == 5:
            # Ctrl-C in a terminal goes to all of its session: the interpreter of the firmware is not in it
            assert os.getsid(firmware._process.pid) != os.getsid(0)
            firmwares.append(firmware._process)
            os.kill(os.getpid(), number)
        report_frame(self, firmware, index, *exposed)

    monkeypatch.setattr(simulation.Simulation, "_report_frame", interrupted)
    folder = tmp_path / "drive"
    assert cli.main(["simulate", "--drive", "loop", "--seconds", "60", "-o", str(folder)]) == 130
    out, err = capfd.readouterr()
    assert err == "" and out.startswith("interrupted after")
    assert "frames.csv and score.json in %s" % folder in out
    assert firmwares[0].returncode is not None and len(rows(folder / "frames.csv")) == 5
    assert json.loads((folder / "score.json").read_text())
    assert (folder / "wire.bin").stat().st_size > 100
    for name in ("path.png", "strip.png"):
        assert (folder / name).read_bytes().startswith(b"\x89PNG")


def test_a_drive_that_is_interrupted_before_its_first_frame_leaves_nothing(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(simulation.Simulation, "_report_frame", interrupted)
    folder = tmp_path / "drive"
    assert cli.main(["simulate", "--drive", "loop", "-o", str(folder)]) == 130
    assert not folder.exists()


def test_a_simulation_that_is_interrupted_keeps_whole_frames(tmp_path, capsys, monkeypatch):
    from larics_host.commands import simulate

    written = []

    def write(path, frame):
        if len(written) == 3:
            raise KeyboardInterrupt
        written.append(path.name)
        files.write_file(path, frame.tobytes())

    monkeypatch.setattr(simulate, "write_frame", write)
    folder = tmp_path / "frames"
    assert cli.main(["simulate", "--frames", "9", "-o", str(folder)]) == 130
    assert capsys.readouterr().out.startswith("interrupted: 3 frames with ")
    assert [truth.frame for truth in read_truth(folder)] == written


def test_a_log_that_holds_nothing_leaves_nothing(tmp_path, capsys):
    (tmp_path / "empty.bin").write_bytes(b"")
    (tmp_path / "noise.bin").write_bytes(b"\x81\x93\xa7" * 50)
    argv = ["-o", str(tmp_path / "out"), "--raw"]
    assert cli.main(["log", "--input", str(tmp_path / "empty.bin"), *argv]) == 2
    assert list(tmp_path.glob("out*")) == []
    assert cli.main(["log", "--input", str(tmp_path / "noise.bin"), *argv]) == 2
    assert [path.name for path in tmp_path.glob("out*")] == ["out.bin"]
    assert "the bytes are in %s" % (tmp_path / "out.bin") in capsys.readouterr().err
