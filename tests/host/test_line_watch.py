"""What came when no message could be read: each kind has its own line, with what to do."""

import random
import signal
import struct

import pytest

from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host import cli
from larics_host.connection.client import Client, NoAnswer
from larics_host.connection.line_watch import LineWatch
from larics_host.connection.pty_pair import PtyPair
from larics_host.connection.receiver import Receiver
from tests.host.test_log import larics, marker_values, wire, write_all
from tests.host.waiting import PATIENCE_S, wait_until

NOISE = random.Random(3).randbytes(3000)


def sentence(body):
    checksum = 0
    for byte in body.encode():
        checksum ^= byte
    return b"$%s*%02X\r\n" % (body.encode(), checksum)


def mavlink(version, count):
    frames = b""
    for k in range(count):
        payload = bytes([k % 250 + 1]) * (20 + k % 3)
        head = struct.pack("<BBBBBBB", len(payload), 0, 0, k % 256, 1, 197, 12) + b"\0\0"
        if version == 1:
            head = struct.pack("<BBBBB", len(payload), k % 256, 1, 197, 12)
        frames += (b"\xfd" if version == 2 else b"\xfe") + head + payload + b"\x12\x34"
    return frames


def damaged(count):
    data = bytearray()
    for k in range(count):
        one = bytearray(wire((m.MARKER, marker_values(1000 + k))))
        one[10] ^= 0x40
        data += one
    return bytes(data)


KINDS = (
    (b"", "not a byte: check the power, the wiring"),
    (NOISE, "3000 bytes: noise: most likely the wrong baud rate (115200 here"),
    (b"\0" * 500, "all of them 0x00: TX hangs loose or inverted"),
    (b"\xff" * 500, "all of them 0xff"),
    (damaged(40), "frames like the camera's, but no checksum is right"),
    (
        sentence("PLRCM,1,20,0,5,0,1,,,,0,0,0") * 9,
        "lines of text ($PLRCM): the camera's setting output",
    ),
    (b"x\r\n" + sentence("GPGGA,1,2,N,3,E") * 4, "NMEA lines ($GPGGA) of another device, such as a GPS"),
    (NOISE[:30] + mavlink(2, 20), "MAVLink: the camera's setting output is mavlink"),
    (mavlink(1, 20), "MAVLink"),
    (
        b"MPY: soft reboot\r\nlarics 1.0.0 runs on OpenMV\r\n>>> ",
        "(MPY: soft reboot larics 1.0.0 runs on OpenMV >>>)",
    ),
    (b"Traceback (most recent call last):\r\n  File\r\n", "that is its USB, take the port of its UART"),
    (b"temperature 21.5\r\n" * 20, "text (temperature 21.5 temperature"),
)
FILES = (
    (b"", "it is empty"),
    (
        b'{"time_s": 1.0, "message": "MARKER"}\n',
        "JSON lines, for larics replay, larics monitor",
    ),
    ('\ufeff{"time_s": 1.0, "message": "MARKER"}\n'.encode("utf-16-le"), "JSON lines, for larics replay"),
    (b'\xef\xbb\xbf{"time_s": 1.0}\r\n', "JSON lines, for larics replay"),
    (b"time_s,sequence,frame\n1,2,3\n", "a table of larics log"),
    (b'\xef\xbb\xbf"time_s";"sequence";"frame"\r\n1;2;3\r\n', "a table of larics log"),
    ("\ufeffsep=;\r\ntime_s;sequence\r\n".encode("utf-16-be"), "a table of larics log"),
    (b"\x89MCAP0\r\n" + NOISE, "an MCAP file"),
    (b"OMV IMG STR V2.0" + NOISE, "an ImageIO stream: larics record --input takes it"),
    (b"\x89PNG\r\n\x1a\n" + NOISE, "an image: larics detect takes it"),
    (b"PK\x03\x04" + NOISE, "a compressed file"),
    (
        b"\xff\xfe" + "ÿ\x01\x02".encode("utf-16-le") * 50,
        "another encoding: a console changed the bytes",
    ),
    (bytes(100), "100 bytes: nothing but zeros"),
    (NOISE, "noise, no message among it; it takes the bytes of larics log --raw"),
)


def explained(data, baud):
    receiver, watch = Receiver(), LineWatch()
    for start in range(0, len(data), 700):
        receiver.feed(data[start : start + 700], 0.0)
        watch.feed(data[start : start + 700])
    return watch.explain(receiver.counters, baud)


@pytest.mark.parametrize("data, part", KINDS)
def test_what_came_over_a_line_is_told(data, part):
    told = explained(data, 115200)
    assert part in told and "\n" not in told


@pytest.mark.parametrize("data, part", FILES)
def test_what_a_file_holds_is_told(data, part, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.bin").write_bytes(data)
    assert cli.main(["log", "--input", "run.bin", "-o", "out"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("larics: no message came from run.bin, ") and part in err and err.count("\n") == 1


def test_another_version_is_told(monkeypatch):
    with monkeypatch.context() as other:
        other.setattr(protocol, "VERSION", protocol.VERSION + 1)
        data = wire(*[(m.MARKER, marker_values(k)) for k in range(5)])
    assert "messages of another version" in explained(data, 115200)


def test_messages_of_other_lengths_are_another_version(monkeypatch):
    with monkeypatch.context() as other:
        other.setitem(protocol.LAYOUTS, m.MARKER, protocol.LAYOUTS[m.POSE])
        data = wire(*[(m.MARKER, 20 * [0]) for _ in range(5)])
    assert "messages of another version" in explained(data, None)


@pytest.mark.parametrize(
    "data, part",
    [
        (sentence("PLRCM,1,2") * 400, "the camera's setting output is nmea"),
        (mavlink(2, 300), "MAVLink: the camera's setting output is mavlink"),
        (NOISE * 100, "belong to no message: noise, or messages that were damaged"),
    ],
)
def test_a_few_messages_do_not_hide_what_the_rest_is(tmp_path, monkeypatch, capsys, data, part):
    monkeypatch.chdir(tmp_path)
    few = wire(*[(m.MARKER, marker_values(k)) for k in range(5)])
    (tmp_path / "run.bin").write_bytes(few + data)
    assert cli.main(["log", "--input", "run.bin", "-o", "out"]) == 0
    err = capsys.readouterr().err
    assert part in err and "%d of %d bytes belong" % (len(data), len(few + data)) in err
    (tmp_path / "run.bin").write_bytes(few * 40 + data[:4000])
    assert cli.main(["log", "--input", "run.bin", "-o", "out", "--force"]) == 0
    assert capsys.readouterr().err == ""


def test_a_long_run_is_judged_by_its_beginning_and_its_end():
    assert "output is nmea" in explained(NOISE[:100] + sentence("PLRCM,1,2") * 2000, 115200)


@pytest.mark.parametrize("data, part", [KINDS[1], KINDS[5], KINDS[9]])
def test_a_client_without_an_answer_says_what_came(data, part):
    class Line:
        baud = 115200
        left = [data]

        def read(self):
            return self.left.pop() if self.left else b""

        def write(self, data):
            pass

    client = Client(Line(), timeout_s=0.01, retries=2)
    with pytest.raises(NoAnswer) as caught:
        client.ping()
    assert str(caught.value).startswith("no answer to PING after 2 tries; what came is ")
    assert part in str(caught.value)


def test_a_client_whose_camera_talks_but_does_not_hear():
    class Line:
        def __init__(self):
            self.left = [wire((m.MARKER, marker_values(1)))]

        def read(self):
            return self.left.pop() if self.left else b""

        def write(self, data):
            pass

    with pytest.raises(NoAnswer, match="its messages come, so this TX does not reach its RX"):
        Client(Line(), timeout_s=0.01, retries=2).info()


def test_a_log_of_a_silent_and_of_a_garbled_port(tmp_path):
    with PtyPair() as cable:
        process = larics("log", "--port", cable.device_b, "-o", str(tmp_path / "a"), "--seconds", "0.5")
        _, err = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 2 and "no message came from %s, not a byte" % cable.device_b in err
        process = larics("log", "--port", cable.device_b, "-o", str(tmp_path / "b"), "--raw")
        raw = tmp_path / "b.bin"

        def has_come():
            write_all(cable.device_a, NOISE[:50])
            return raw.exists() and raw.stat().st_size >= 1000

        wait_until(has_come)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE_S)
        assert "noise: most likely the wrong baud rate (115200 here" in err
