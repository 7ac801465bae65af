"""`larics replay`, and what `larics log` adds for it: MCAP, ports that come back, logs read again."""

import json
import os
import random
import re
import signal
import subprocess
import sys
import threading

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host import cli
from larics_host.connection import byte_sources
from larics_host.connection.pty_pair import PtyPair
from larics_host.connection.receiver import Receiver, wire_bytes
from larics_host.connection.records import as_json
from larics_host.logs.log_reader import Piece, read_pieces
from larics_host.logs.log_source import Pacer
from tests.host.test_dual import ROOT
from tests.host.test_log import (
    info_values,
    larics,
    marker_values,
    rows,
    status_values,
    wire,
    write_all,
)
from tests.host.test_monitor import firmware
from tests.host.waiting import PATIENCE_S, Clock, wait_for_lines

NOISE = b"\x07garbage\x00\x00"


def messages(count=20):
    encoder = protocol.Encoder()
    data = NOISE
    for k in range(count):
        number, values = (m.STATUS, status_values(frames=k)) if k % 5 == 4 else (m.MARKER, marker_values(k))
        data += bytes(encoder.buffer[: encoder.encode(number, values)])
        data += b"\x01\x02" if k == 7 else b""
    info = info_values(unique_id=bytes(range(12)))
    return data + bytes(encoder.buffer[: encoder.encode(m.INFO, info)])


@pytest.fixture
def log(tmp_path, capsys):
    """PREFIX of a log with all files, and the bytes it was made of."""
    (tmp_path / "came.bin").write_bytes(messages())
    prefix = tmp_path / "run"
    assert cli.main(["log", "--input", str(tmp_path / "came.bin"), "-o", str(prefix), "--raw", "--mcap"]) == 0
    capsys.readouterr()
    return prefix


def replayed(*argv):
    command = [sys.executable, "-m", "larics_host", "replay", *map(str, argv)]
    environment = dict(os.environ, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"))
    return subprocess.run(command, capture_output=True, env=environment, timeout=PATIENCE_S)


def test_raw_bytes_come_again_one_for_one(log):
    result = replayed(log.with_suffix(".bin"), "--stdout", "--fast", "--rounds", "2")
    assert result.returncode == 0 and result.stdout == 2 * messages()
    assert result.stderr.decode().startswith("40 messages, ")


def test_json_lines_become_the_same_messages(log, tmp_path, capsys):
    result = replayed(log.with_suffix(".jsonl"), "--stdout", "--fast")
    clean = messages().replace(NOISE, b"")
    # the damaged message is not in the log; every other byte is
    assert len(clean) - 80 < len(result.stdout) < len(clean)
    again = tmp_path / "again"
    (tmp_path / "again.bin").write_bytes(result.stdout)
    assert cli.main(["log", "--input", str(tmp_path / "again.bin"), "-o", str(again)]) == 0

    def without_time(prefix):
        records = [json.loads(line) for line in prefix.with_suffix(".jsonl").read_text().splitlines()]
        return [dict(record, time_s=0) for record in records]

    assert without_time(again) == without_time(log) and len(without_time(log)) == 20
    assert [dict(row, time_s=0) for row in rows(again.with_suffix(".csv"))] == [
        dict(row, time_s=0) for row in rows(log.with_suffix(".csv"))
    ]


def test_mcap_and_csv_become_the_same_messages(log):
    pieces = list(read_pieces(log.with_suffix(".jsonl")))
    assert list(read_pieces(log.with_suffix(".mcap"))) == pieces
    markers = [piece for piece in read_pieces(log.with_suffix(".csv"))]
    assert markers == [piece for piece in pieces if len(piece.data) == protocol.frame_size(m.MARKER)]
    assert 10 < len(markers) < len(pieces)


@settings(max_examples=60)
@given(data=st.data())
def test_every_message_goes_to_json_and_back(data):
    _, number, _, fields = data.draw(st.sampled_from(protocol.MESSAGES))
    values = []
    for name, code, _, low, high, _ in fields:
        if name == "board":
            values.append(data.draw(st.text("abcXYZ 09-", max_size=16)).encode().ljust(16, b"\0"))
        elif code.endswith("s"):
            size = int(code[:-1])
            values.append(data.draw(st.binary(min_size=size, max_size=size)))
        else:
            values.append(data.draw(st.integers(low, high)))
    encoder = protocol.Encoder()
    encoder.sequence = data.draw(st.integers(0, 65535))
    sent = bytes(encoder.buffer[: encoder.encode(number, values)])
    (message,) = Receiver().feed(sent, 0.0)
    fields = json.loads(json.dumps(as_json(message.fields)))
    assert wire_bytes(protocol.Encoder(), message.name, message.sequence, fields) == sent


def test_the_original_pace(log, monkeypatch):
    clock = Clock()
    monkeypatch.setattr("larics_host.logs.log_source.time", clock)
    lines = log.with_suffix(".jsonl").read_text().splitlines()
    records = [dict(json.loads(line), time_s=5 + 0.03 * k) for k, line in enumerate(lines)]
    log.with_suffix(".jsonl").write_text("".join(json.dumps(record) + "\n" for record in records))
    for suffix in (".jsonl", ".bin"):
        times = [piece.time_s for piece in read_pieces(log.with_suffix(suffix))]
        assert [time_s for time_s in times if time_s is not None] == [r["time_s"] for r in records]
    pacer = Pacer(2.0)
    for piece in read_pieces(log.with_suffix(".bin")):
        pacer.wait(piece)
    assert clock.now_s == pytest.approx(0.03 * (len(records) - 1) / 2)
    clock.now_s = 0.0
    pacer = Pacer(1.0, baud=10000)
    for _ in range(4):
        pacer.wait(Piece(None, bytes(50)))
    assert clock.now_s == pytest.approx(4 * 50 * 10 / 10000)


def test_over_a_pseudo_terminal_into_a_log(log, tmp_path):
    replay = larics("replay", str(log.with_suffix(".bin")), "--fast")
    device = replay.stdout.readline().split(":")[0]
    logging = larics("log", "--port", device, "-o", str(tmp_path / "again"), "--raw")
    try:
        said, _ = replay.communicate(timeout=PATIENCE_S)
        assert replay.returncode == 0 and "20 messages" in said
        logging.communicate(timeout=PATIENCE_S)  # the port goes with the replay
    finally:
        replay.kill()
        logging.kill()
    assert (tmp_path / "again.bin").read_bytes() == messages()
    assert len(rows(tmp_path / "again.csv")) == len(rows(log.with_suffix(".csv")))


def test_over_a_serial_port(log, tmp_path):
    with PtyPair() as cable:
        logging = larics("log", "--port", cable.device_b, "-o", str(tmp_path / "again"), "--raw")
        wait_for_lines(tmp_path / "again.csv", 1)
        result = replayed(log.with_suffix(".bin"), "--port", cable.device_a, "--fast")
        assert result.returncode == 0
        wait_for_lines(tmp_path / "again.csv", len(rows(log.with_suffix(".csv"))) + 1)
        logging.send_signal(signal.SIGINT)
        logging.communicate(timeout=PATIENCE_S)
    assert (tmp_path / "again.bin").read_bytes() == messages()


def test_the_log_of_a_real_firmware_comes_again_byte_for_byte(tmp_path):
    with firmware(tmp_path) as (device, _):
        logging = larics("log", "--port", device, "-o", str(tmp_path / "run"), "--raw", "--mcap")
        wait_for_lines(tmp_path / "run.csv", 60)
        logging.send_signal(signal.SIGINT)
        said, _ = logging.communicate(timeout=PATIENCE_S)
    # a line that is opened while a camera speaks may begin with the rests of two messages
    assert logging.returncode == 0 and re.search(r" 0 lost, [01] damaged", said), said
    raw = (tmp_path / "run.bin").read_bytes()
    assert replayed(tmp_path / "run.bin", "--stdout", "--fast").stdout == raw
    # the same from the JSON lines, but for what was cut off at both ends: between them nothing is damaged
    again = replayed(tmp_path / "run.jsonl", "--stdout", "--fast").stdout
    assert len(again) > 3000 and again in raw


def test_mcap_holds_every_message_with_its_definition(log):
    from mcap_ros2.reader import read_ros2_messages

    with open(log.with_suffix(".mcap"), "rb") as file:
        summary = make_reader(file).get_summary()
    assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}
    records = [json.loads(line) for line in log.with_suffix(".jsonl").read_text().splitlines()]
    found = [
        one for one in read_ros2_messages(str(log.with_suffix(".mcap"))) if "/wire/" in one.channel.topic
    ]
    assert len(found) == len(records) == 20
    for one, record in zip(found, records, strict=True):
        told = one.ros_msg
        assert one.channel.topic == "/larics/wire/" + record["message"].lower()
        assert one.schema.name == "larics_msgs/msg/" + record["message"].title()
        assert told.sequence == record["sequence"] and told.time_s == record["time_s"]
        for name in set(record) - {"message", "sequence", "time_s", "time"}:
            value = getattr(told, name)
            if record[name] is None:
                assert value == -1 or value != value
            elif name == "unique_id":
                assert bytes(value).hex() == record[name]
            else:
                assert value == record[name], name
        assert one.log_time_ns - one.publish_time_ns == 1000 * record.get("age_us", 0)
        assert told.stamp.sec * 10**9 + told.stamp.nanosec == one.publish_time_ns


def test_what_a_killed_log_had_not_yet_in_its_bag_is_made_again_of_its_lines(tmp_path, capsys):
    with PtyPair() as cable:
        process = larics("log", "--port", cable.device_b, "-o", str(tmp_path / "run"), "--mcap")
        wait_for_lines(tmp_path / "run.csv", 1)
        write_all(cable.device_a, wire(*[(m.MARKER, marker_values(k)) for k in range(200)]))
        wait_for_lines(tmp_path / "run.csv", 201)
        wait_for_lines(tmp_path / "run.jsonl", 200)
        process.kill()
        process.communicate(timeout=PATIENCE_S)
    lines = list(read_pieces(tmp_path / "run.jsonl"))
    assert len(lines) == 200
    left = list(read_pieces(tmp_path / "run.mcap"))  # its complete chunks
    assert 30 < len(left) < 200 and left == lines[: len(left)]
    assert "was cut off" in capsys.readouterr().err
    again = str(tmp_path / "again")
    assert cli.main(["log", "--convert", str(tmp_path / "run.jsonl"), "-o", again, "--mcap"]) == 0
    assert list(read_pieces(tmp_path / "again.mcap")) == lines
    assert (tmp_path / "again.jsonl").read_bytes() == (tmp_path / "run.jsonl").read_bytes()
    (tmp_path / "cut.jsonl").write_text((tmp_path / "run.jsonl").read_text()[:-9])
    assert len(list(read_pieces(tmp_path / "cut.jsonl"))) == 199


def test_a_port_that_returns(tmp_path):
    name = tmp_path / "port"
    with PtyPair() as cable:
        name.symlink_to(cable.device_b)
        process = larics("log", "--port", str(name), "-o", str(tmp_path / "run"), "--reconnect", "--raw")
        wait_for_lines(tmp_path / "run.csv", 1)
        write_all(cable.device_a, wire(*[(m.MARKER, marker_values(k)) for k in range(5)]))
        wait_for_lines(tmp_path / "run.csv", 6)
        name.unlink()
    assert "vanished while reading; waiting for it" in process.stderr.readline()
    with PtyPair() as cable:
        name.symlink_to(cable.device_b)
        assert "is back" in process.stderr.readline()
        write_all(cable.device_a, wire(*[(m.MARKER, marker_values(k)) for k in range(5, 12)]))
        wait_for_lines(tmp_path / "run.csv", 13)
        process.send_signal(signal.SIGTERM)
        out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0 and "12 messages received" in out and not err
    assert [int(row["frame"]) for row in rows(tmp_path / "run.csv")] == list(range(12))


def test_a_signal_while_data_is_at_hand_loses_none(tmp_path, monkeypatch, capsys):
    """The signal comes between reading and writing, the worst moment."""

    class Source:
        live, name = True, "fake"

        def read(self):
            os.kill(os.getpid(), signal.SIGINT)
            return wire((m.MARKER, marker_values(1)))

        def close(self):
            pass

    monkeypatch.setattr(byte_sources, "SerialSource", lambda port, baud: Source())
    assert threading.current_thread() is threading.main_thread()
    assert cli.main(["log", "--port", "x", "-o", str(tmp_path / "run")]) == 0
    assert len(rows(tmp_path / "run.csv")) == 1


@pytest.mark.parametrize(
    "argv, part",
    [
        (["none.bin"], "cannot read none.bin"),
        (["none.jsonl"], "cannot read none.jsonl"),
        (["empty.bin"], "empty.bin is empty"),
        (["note.txt", "--stdout"], "note.txt holds no message, 6 bytes: text (hello)"),
        (["noise.bin", "--rounds", "0"], "noise.bin holds no message, 300 bytes: noise"),
        (["bad.jsonl"], "bad.jsonl line 1 is not from larics log"),
        (["odd.jsonl"], "odd.jsonl message 1 is no message"),
        (["nan.jsonl"], "nan.jsonl line 1 is not from larics log"),
        (["far.jsonl"], "far.jsonl line 1 is not from larics log"),
        (["odd.csv"], "odd.csv is not from larics log"),
        (["odd.mcap"], "odd.mcap is not from larics log"),
        (["none.mcap"], "cannot read none.mcap"),
        (["empty.bin", "--speed", "0"], "--speed 0"),
        (["empty.bin", "--rounds", "-1"], "--rounds -1"),
        (["empty.bin", "--baud", "0"], "--baud 0"),
        (["good.bin", "--port", "/dev/nothing-here"], "no port /dev/nothing-here"),
    ],
)
def test_bad_input_is_one_line(argv, part, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty.bin").write_bytes(b"")
    (tmp_path / "note.txt").write_text("hello\n")
    (tmp_path / "noise.bin").write_bytes(random.Random(1).randbytes(300))
    (tmp_path / "good.bin").write_bytes(messages())
    (tmp_path / "bad.jsonl").write_text("{}\n{}\n")
    (tmp_path / "odd.csv").write_text("a,b\n1,2\n")
    (tmp_path / "odd.mcap").write_bytes(messages())
    (tmp_path / "odd.jsonl").write_text('{"message": "MARKER", "sequence": 1, "time_s": 0.5}\n')
    for name, time_s in (("nan", "NaN"), ("far", "1e300")):
        line = '{"message": "PING", "sequence": 1, "time_s": %s, "token": 1}\n' % time_s
        (tmp_path / (name + ".jsonl")).write_text(line)
    assert cli.main(["replay", *argv]) == 2
    err = capsys.readouterr().err
    assert err.startswith("larics: ") and part in err and err.count("\n") == 1
