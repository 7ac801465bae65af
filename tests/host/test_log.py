"""`larics log`: files, live view, and everything that goes wrong with a port."""

import csv
import io
import json
import os
import re
import signal
import subprocess
import sys
import threading

import pytest
from rich.console import Console

from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host import cli
from larics_host.connection.pty_pair import PtyPair
from larics_host.connection.receiver import Receiver
from larics_host.logs.live_table import HEADINGS, LiveTable, flag_text
from larics_host.logs.log_reader import read_pieces
from tests.host.test_dual import ROOT
from tests.host.waiting import PATIENCE_S, Clock, wait_for_lines
from wire_values import changed, message_values


def marker_values(frame, marker_id=3, x_mm10=1234, flags=0):
    place = {"x_mm10": x_mm10, "y_mm10": -567, "z_mm10": 25000, "heading_cdeg": 4550}
    told = {"frame": frame, "age_us": 8000, "flags": flags, "id": marker_id, "count": 1}
    return message_values(m.MARKER, margin=200, radius_q8=7680, **told, **place)


def status_values(**changes):
    return message_values(m.STATUS, **changes)


def info_values(**changes):
    given = {"boot": 1, "width": 320, "height": 240, "settings": 61, "board": b"desk".ljust(16, b"\0")}
    return message_values(m.INFO, **{**given, **changes})


def wire(*messages):
    encoder = protocol.Encoder()
    data = b""
    for number, values in messages:
        count = encoder.encode(number, values)
        data += bytes(encoder.buffer[:count])
    return data


def larics(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "larics_host", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=dict(os.environ, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host")),
    )


def write_all(device, data):
    descriptor = os.open(device, os.O_WRONLY | os.O_NOCTTY)
    os.write(descriptor, data)
    os.close(descriptor)


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_a_recorded_file_becomes_csv_and_json_lines(tmp_path, capsys):
    data = b"garbage\x00" + wire(
        (m.MARKER, marker_values(7)), (m.STATUS, status_values(frames=8)), (m.MARKER, marker_values(8, 5))
    )
    (tmp_path / "run.bin").write_bytes(data)
    prefix = str(tmp_path / "out")
    assert cli.main(["log", "--input", str(tmp_path / "run.bin"), "-o", prefix, "--raw"]) == 0
    said = capsys.readouterr().out
    assert "3 messages received, 0 lost, 1 damaged" in said and "out.csv" in said
    markers = rows(tmp_path / "out.csv")
    assert [(row["frame"], row["id"], row["x_mm10"], row["heading_cdeg"]) for row in markers] == [
        ("7", "3", "1234", "4550"),
        ("8", "5", "1234", "4550"),
    ]
    records = [json.loads(line) for line in (tmp_path / "out.jsonl").read_text().splitlines()]
    assert [record["message"] for record in records] == ["MARKER", "STATUS", "MARKER"]
    assert records[1]["frames"] == 8 and records[0]["y_mm10"] == -567
    assert (tmp_path / "out.bin").read_bytes() == data


def test_an_id_that_is_none_or_uncertain_is_null_and_comes_back(tmp_path):
    unsure = changed(m.MARKER, marker_values(1), flags=m.MARKER_ID_UNCERTAIN, id=m.ID_NONE)
    data = wire((m.MARKER, unsure), (m.MARKER, marker_values(2)))
    (tmp_path / "run.bin").write_bytes(data)
    assert cli.main(["log", "--input", str(tmp_path / "run.bin"), "-o", str(tmp_path / "out")]) == 0
    assert [row["id"] for row in rows(tmp_path / "out.csv")] == ["", "3"]
    records = [json.loads(line) for line in (tmp_path / "out.jsonl").read_text().splitlines()]
    assert [record["id"] for record in records] == [None, 3]
    assert b"".join(piece.data for piece in read_pieces(tmp_path / "out.jsonl")) == data


def test_a_file_that_is_read_is_never_written(tmp_path, capsys):
    data = wire((m.MARKER, marker_values(7)))
    (tmp_path / "run.bin").write_bytes(data)
    arguments = ["log", "--input", str(tmp_path / "run.bin"), "-o", str(tmp_path / "run"), "--force"]
    assert cli.main([*arguments, "--raw"]) == 2
    assert "would overwrite" in capsys.readouterr().err
    assert cli.main(arguments) == 0
    assert (tmp_path / "run.bin").read_bytes() == data and (tmp_path / "run.csv").exists()


def test_existing_files_are_kept(tmp_path, capsys):
    (tmp_path / "run.bin").write_bytes(wire((m.MARKER, marker_values(7))))
    (tmp_path / "out.csv").write_text("precious")
    arguments = ["log", "--input", str(tmp_path / "run.bin"), "-o", str(tmp_path / "out")]
    assert cli.main(arguments) == 2
    assert "out.csv exists" in capsys.readouterr().err
    assert (tmp_path / "out.csv").read_text() == "precious"
    assert cli.main([*arguments, "--force"]) == 0


@pytest.mark.parametrize(
    "arguments, expected",
    [
        (["--port", "/dev/no-such-port"], "no port /dev/no-such-port"),
        (["--port", "/dev/null"], "/dev/null is no serial port"),
        (["--port", "no-such-camera"], "no port no-such-camera (serial ports here: "),
        (["--port", "/"], "/ is no serial port"),
        (["--input", "/no/such/file"], "cannot read /no/such/file"),
        (["--input", "/dev/null"], "no message came from /dev/null"),
        (["--input", "/dev/null", "--seconds", "0"], "--seconds 0"),
        (["--input", "/dev/null", "--seconds", "nan"], "--seconds nan"),
        (["--port", "/dev/null", "--baud", "-1"], "--baud -1"),
        (["--input", "/dev/null", "-o", "/no/such/folder/run"], "cannot write /no/such/folder/run.csv"),
        ([], "one of the arguments --port --input --convert is required"),
    ],
)
def test_bad_input_gets_one_line(arguments, expected, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["log", *arguments]) == 2
    err = capsys.readouterr().err
    assert err.startswith("larics: ") and expected in err and len(err.splitlines()) == 1


def test_a_port_that_vanishes_keeps_what_came(tmp_path):
    with PtyPair() as cable:
        process = larics("log", "--port", cable.device_b, "-o", str(tmp_path / "run"))
        wait_for_lines(tmp_path / "run.csv", 1)
        write_all(cable.device_a, wire(*[(m.MARKER, marker_values(k)) for k in range(20)]))
        wait_for_lines(tmp_path / "run.csv", 21)
        cable.unplug()
        _, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 2
    assert len(err.splitlines()) == 1 and "vanished while reading" in err and "20 messages received" in err
    assert len(rows(tmp_path / "run.csv")) == 20


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_ending_it_by_force_loses_nothing(tmp_path, number):
    with PtyPair() as cable:
        process = larics("log", "--port", cable.device_b, "-o", str(tmp_path / "run"), "--raw")
        wait_for_lines(tmp_path / "run.csv", 1)
        data = wire(*[(m.MARKER, marker_values(k)) for k in range(30)])
        write_all(cable.device_a, data)
        wait_for_lines(tmp_path / "run.csv", 31)
        process.send_signal(number)
        out, err = process.communicate(timeout=PATIENCE_S)
    assert len(rows(tmp_path / "run.csv")) == 30
    assert len((tmp_path / "run.jsonl").read_text().splitlines()) == 30
    assert (tmp_path / "run.bin").read_bytes() == data
    if number != signal.SIGKILL:
        assert process.returncode == 0 and "30 messages received" in out and not err


def test_seconds_end_it(tmp_path, monkeypatch, capsys):
    clock = Clock()
    monkeypatch.setattr("larics_host.commands.log.time", clock)

    def send():
        try:
            wait_for_lines(tmp_path / "run.csv", 1)  # the port is open, which drops what came before
            write_all(cable.device_a, wire((m.MARKER, marker_values(1))))
            clock.now_s = 29.0
            wait_for_lines(tmp_path / "run.csv", 2)
            write_all(cable.device_a, wire((m.MARKER, marker_values(2))))
            wait_for_lines(tmp_path / "run.csv", 3)
        finally:
            clock.now_s = 30.1

    with PtyPair() as cable:
        sender = threading.Thread(target=send)
        sender.start()
        options = ("-o", str(tmp_path / "run"), "--seconds", "30", "--quiet")
        assert cli.main(["log", "--port", cable.device_b, *options]) == 0
        sender.join()
    assert "2 messages received" in capsys.readouterr().out


def test_live_view_shows_measures_and_health():
    receiver = Receiver()
    view = LiveTable("/dev/x")
    encoder = protocol.Encoder()
    count = encoder.encode(m.INFO, info_values())
    data = bytes(encoder.buffer[:count])
    data += wire(
        (m.MARKER, marker_values(7)),
        (m.MARKER, marker_values(8, m.ID_NONE, 0, m.MARKER_NONE)),
        (m.MARKER, marker_values(9, m.ID_NONE, 0, m.MARKER_ID_UNCERTAIN | m.MARKER_NO_OFFSET)),
        (
            m.STATUS,
            status_values(
                rate_chz=6000, state=m.TRACKING, faults=2, last_fault=1, active_faults=1 << m.FAULT_STORAGE
            ),
        ),
    )
    for message in receiver.feed(data, 1.5):
        view.add(message)
    console = Console(width=160, record=True, file=open(os.devnull, "w"))  # noqa: SIM115
    console.print(view.render(receiver.counters))
    text = console.export_text()
    for expected in ("123.4", "-56.7", "45.50", "none", "id uncertain, no offset", "TRACKING, 60.0 frames/s"):
        assert expected in text, text
    assert "faults 2 (storage, last: camera timeout)" in text and "board desk" in text


@pytest.mark.parametrize(
    "width, there, left_out",
    [
        (40, ("ID", "x mm", "y mm", "heading deg"), ("frame", "time s", "z mm")),
        (80, ("ID", "heading deg", "margin", "notes", "age ms", "time s"), ("z mm",)),
        (110, HEADINGS, ()),
    ],
)
def test_live_view_leaves_out_columns_that_would_not_be_whole(width, there, left_out):
    view = LiveTable("/dev/x")
    receiver = Receiver()
    for message in receiver.feed(wire((m.MARKER, marker_values(7, 3, 0, m.MARKER_ID_UNCERTAIN))), 1.5):
        view.add(message)
    file = io.StringIO()
    Console(width=width, file=file).print(view.render(receiver.counters, width))
    lines = file.getvalue().splitlines()
    assert max(map(len, lines)) <= width and "…" not in file.getvalue() and "45.50" in file.getvalue()
    headings = [cell.strip() for cell in re.split("[┃|]", lines[2])]
    assert set(there) <= set(headings) and not set(left_out) & set(headings)


def test_flag_text_of_no_flag():
    assert flag_text(0) == ""
