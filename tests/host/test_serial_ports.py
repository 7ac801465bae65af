"""Ports belong to one program, who has one is named, and a device is known again under another name."""

import contextlib
import fcntl
import os
import re
import signal
import subprocess
import sys
import termios

import pytest
from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo

from larics.wire import messages as m
from larics_host import cli
from larics_host.connection import serial_ports
from larics_host.connection.byte_sources import ReconnectingSource, SerialSource
from larics_host.connection.pty_pair import PtyPair
from larics_host.connection.serial_ports import Identity, find_again, identity_of
from larics_host.errors import UserError
from tests.host.test_log import larics, marker_values, rows, wait_for_lines, wire, write_all
from tests.host.waiting import PATIENCE_S

COMMANDS = (
    ["log", "--port", "{port}", "-o", "{folder}/second"],
    ["log", "--port", "{port}", "-o", "{folder}/second", "--reconnect"],
    ["monitor", "--port", "{port}", "--seconds", "1"],
    ["record", "--port", "{port}", "-o", "{folder}/frames"],
    ["replay", "{folder}/run.jsonl", "--port", "{port}"],
    ["settings", "show", "--port", "{port}"],
    ["settings", "set", "--port", "{port}", "rate_divider=2"],
    ["map", "send", "{folder}/hall.json", "--port", "{port}"],
    ["calibrate", "--places", "{folder}", "--port", "{port}", "--send"],
    ["flash", "--port", "{port}"],
    ["flash", "--port", "{port}", "--dry-run"],
)


@pytest.fixture(scope="module")
def taken(tmp_path_factory):
    """(port, folder) while `larics log` has the port."""
    folder = tmp_path_factory.mktemp("taken")
    with PtyPair() as cable:
        process = larics("log", "--port", cable.device_b, "-o", str(folder / "run"))
        wait_for_lines(folder / "run.csv", 1)
        write_all(cable.device_a, wire(*[(m.MARKER, marker_values(k)) for k in range(3)]))
        wait_for_lines(folder / "run.csv", 4)
        assert cli.main(["map", "create", str(folder / "hall.json"), "--marker", "3,0,0,0"]) == 0
        yield cable.device_b, folder, process
        write_all(cable.device_a, wire(*[(m.MARKER, marker_values(k)) for k in range(3, 9)]))
        wait_for_lines(folder / "run.csv", 10)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=PATIENCE_S)
    # nobody took anything of what came
    assert [row["frame"] for row in rows(folder / "run.csv")] == [str(k) for k in range(9)]


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_a_port_in_use_is_refused_and_its_holder_named(taken, command, capsys):
    port, folder, process = taken
    before = sorted(os.listdir(folder))
    assert cli.main([word.format(port=port, folder=folder) for word in command]) == 2
    err = capsys.readouterr().err
    assert (
        err.count("\n") == 1
        and "the port %s is in use by larics log (process %d)" % (port, process.pid) in err
    )
    assert sorted(os.listdir(folder)) == before


def test_a_link_to_a_port_is_that_port(taken, tmp_path):
    port, _, process = taken
    (tmp_path / "camera").symlink_to(port)
    with pytest.raises(UserError, match=r"camera is in use by larics log \(process %d\)" % process.pid):
        SerialSource(str(tmp_path / "camera"))


def test_programs_are_named_as_people_know_them():
    with PtyPair() as cable:
        script = "import sys, time; f = open(sys.argv[1], 'rb', 0); print(flush=True); time.sleep(60)"
        process = subprocess.Popen([sys.executable, "-c", script, cable.device_a], stdout=subprocess.PIPE)
        try:
            process.stdout.readline()
            (name,) = serial_ports.holders(cable.device_a)
            assert re.fullmatch(r".+ \(process %d\)" % process.pid, name)
        finally:
            process.kill()
            process.communicate()
        assert serial_ports.holders(cable.device_a) == []


def test_a_real_port_is_closed_to_others_and_to_who_had_it_before(monkeypatch):
    with PtyPair() as cable:
        monkeypatch.setattr(serial_ports, "_is_pseudo", lambda port: False)
        with contextlib.closing(serial_ports.open_port(cable.device_a, 115200, 0.1)) as port:
            exclusive = fcntl.ioctl(port.fileno(), getattr(termios, "TIOCGEXCL", 0x80045440), bytes(4))
            assert exclusive != bytes(4)
        monkeypatch.setattr(serial_ports, "holders", lambda port: ["minicom (process 7)"])
        with pytest.raises(UserError, match=r"in use by minicom \(process 7\): two programs"):
            serial_ports.open_port(cable.device_a, 115200, 0.1)
        assert not serial_ports.why_shut(cable.device_a)  # nothing stays locked


def info(device, vid=None, pid=None, serial_number=None):
    item = ListPortInfo(device)
    item.vid, item.pid, item.serial_number = vid, pid, serial_number
    return item


def test_a_device_is_known_by_its_serial_number():
    ports = [
        info("/dev/ttyACM0", 0x37C5, 0x1206, "A1"),
        info("/dev/ttyACM1", 0x37C5, 0x1206, "B2"),
        info("/dev/ttyS0"),
    ]
    one = identity_of("/dev/ttyACM1", ports)
    assert one == (0x37C5, 0x1206, "B2") and one.text() == "USB serial number B2"
    assert find_again("/dev/ttyACM1", one, ports) == "/dev/ttyACM1"
    # it comes back as another, and somebody else has its old name
    moved = [info("/dev/ttyACM1", 0x37C5, 0x1206, "A1"), info("/dev/ttyACM2", 0x37C5, 0x1206, "B2")]
    assert find_again("/dev/ttyACM1", one, moved) == "/dev/ttyACM2"
    assert find_again("/dev/ttyACM1", one, moved[:1]) is None


def test_a_device_without_a_number_is_known_by_its_kind():
    one = Identity(0x1A86, 0x7523)
    assert one.text() == "USB device 1a86:7523"
    assert find_again("/dev/ttyUSB0", one, [info("/dev/ttyUSB1", 0x1A86, 0x7523)]) == "/dev/ttyUSB1"
    two = [info("/dev/ttyUSB%d" % k, 0x1A86, 0x7523) for k in range(2)]
    assert find_again("/dev/ttyUSB0", one, two) == "/dev/ttyUSB0"
    assert find_again("/dev/ttyUSB7", one, two) is None  # which of them is not known
    assert find_again("/dev/ttyUSB0", one, [info("/dev/ttyUSB0", 0x0403, 0x6001, "FT")]) is None


def test_a_port_that_is_no_usb_device_is_known_by_its_name(tmp_path):
    assert identity_of("/dev/ttyS0", []) == (None, None, None) and Identity().text() == ""
    assert find_again(str(tmp_path / "gone"), Identity(), []) is None
    (tmp_path / "gone").write_text("")
    assert find_again(str(tmp_path / "gone"), Identity(), []) == str(tmp_path / "gone")


def test_a_log_follows_its_device_to_another_name(monkeypatch, tmp_path):
    said = []
    with PtyPair() as first, PtyPair() as second, PtyPair() as third:
        ports = [info(first.device_b, 1, 2, "A1"), info(third.device_b, 1, 2, "ZZ")]
        monkeypatch.setattr(list_ports, "comports", lambda: ports)
        source = ReconnectingSource(SerialSource(first.device_b), said.append)
        write_all(first.device_a, b"one")
        assert source.read()
        first.unplug()
        del ports[0]
        while source.read():
            pass
        assert source.read() == b""  # another device of the same kind is not taken for it
        text = "the port %s vanished while reading; waiting for it (USB serial number A1, under any name)"
        assert said == [text % first.device_b]
        ports.append(info(second.device_b, 1, 2, "A1"))
        source.read()
        write_all(second.device_a, b"two")
        assert b"two".startswith(source.read() or b"!")
        assert said[1:] == ["the device with the USB serial number A1 is back as %s" % second.device_b]
        assert source.name == second.device_b
        source.close()
