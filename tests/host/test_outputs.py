"""Standard output: JSON lines as they come, and readers that go away; what a log keeps of nothing."""

import datetime
import json
import os
import signal
import subprocess

import pytest

from larics.wire import messages as m
from larics_host import cli
from larics_host.connection.pty_pair import PtyPair
from tests.host.larics_process import COMMAND, ENVIRONMENT, recorded
from tests.host.test_dual import ROOT
from tests.host.test_log import marker_values, wait_for_lines, wire, write_all
from tests.host.test_monitor import firmware
from tests.host.waiting import PATIENCE_S

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
def test_an_output_that_nobody_reads_ends_every_command_alike(camera, tmp_path, argv, closed):
    hall = tmp_path / "hall.json"
    assert cli.main(["map", "create", str(hall), "--marker", "3,0,0,0"]) == 0
    words = [word.format(port=camera, hall=hall, log=recorded(tmp_path)) for word in argv]
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


def test_the_time_of_bytes_recorded_earlier_is_not_known(tmp_path, capsys):
    log = str(recorded(tmp_path))
    assert cli.main(["log", "--input", log, "-o", "-"]) == 0
    out, err = capsys.readouterr()
    assert all(json.loads(line)["time"] is None for line in out.splitlines()) and "201 messages" in err
    assert cli.main(["log", "--input", log, "-o", "-", "--raw"]) == 2
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


def test_a_log_that_holds_nothing_leaves_nothing(tmp_path, capsys):
    (tmp_path / "empty.bin").write_bytes(b"")
    (tmp_path / "noise.bin").write_bytes(b"\x81\x93\xa7" * 50)
    argv = ["-o", str(tmp_path / "out"), "--raw"]
    assert cli.main(["log", "--input", str(tmp_path / "empty.bin"), *argv]) == 2
    assert list(tmp_path.glob("out*")) == []
    assert cli.main(["log", "--input", str(tmp_path / "noise.bin"), *argv]) == 2
    assert [path.name for path in tmp_path.glob("out*")] == ["out.bin"]
    assert "the bytes are in %s" % (tmp_path / "out.bin") in capsys.readouterr().err
