"""The whole firmware on MicroPython: other encodings and commands over a real pseudo-terminal."""

import signal
import time

import pytest

from larics.wire import messages as m
from larics_host.connection.client import Client, Refused
from larics_host.render import render_frame
from tests.host.firmware_process import pieces, running_firmware
from tests.host.waiting import PATIENCE_S

FAST = ["--set", "baud=921600", "--set", "radius_min_px=25", "--set", "radius_max_px=36"]
CALIBRATED = ["--set", "focal_q8=153600", "--set", "ceiling_mm10=30000"]
COUNT = 8


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    folder = tmp_path_factory.mktemp("frames")
    frames = []
    for index in range(COUNT):
        frame, _ = render_frame("sunny", 1701, index)
        frames.append(frame.tobytes())
        (folder / ("f%03d.pgm" % index)).write_bytes(b"P5\n360 296\n255\n" + frames[-1])
    return folder, frames


def everything(folder, *options):
    """All bytes that the firmware sends of two rounds of the recording. Without a rate no frame is skipped,
    however slow the machine is."""
    with running_firmware(folder, *FAST, "--fps", "0", "--rounds", "2", *options) as (process, cable, source):
        data = b"".join(pieces(process, cable, source))
        output = process.stdout.read()
    assert process.returncode == 0 and not output, output
    return data


DOWN = ["--set", "mavlink_target=ardupilot"]


def test_mavlink(recording):
    mavlink = pytest.importorskip("pymavlink.dialects.v20.common")
    folder, _ = recording
    parser = mavlink.MAVLink(None)
    parser.robust_parsing = True
    options = ["--set", "output=mavlink", *DOWN, *CALIBRATED]
    targets, beats = [], 0
    with running_firmware(folder, *FAST, *options, "--fps", "10", "--rounds", "0") as (
        process,
        cable,
        source,
    ):
        for data in pieces(process, cable, source):
            found = parser.parse_buffer(data) or []
            targets += [message for message in found if message.get_type() == "LANDING_TARGET"]
            beats += sum(message.get_type() == "HEARTBEAT" for message in found)
            if len(targets) >= COUNT and beats >= 2:
                break
    assert process.returncode == -signal.SIGKILL
    for target in targets:
        assert target.z == pytest.approx(3, rel=1e-6) and abs(target.x) < 0.9 and abs(target.y) < 1.1
        assert target.distance == pytest.approx((target.x**2 + target.y**2 + 9) ** 0.5, rel=1e-3)
    times = [target.time_usec for target in targets]
    assert times == sorted(times) and times[-1] > times[0]


def test_text(recording):
    folder, _ = recording
    lines = [line for line in everything(folder, "--set", "output=nmea").split(b"\r\n") if b"$PLRC" in line]
    frames = []
    for line in lines:
        body, check = line[line.index(b"$PLRC") + 1 :].decode().split("*")
        expected = 0
        for character in body:
            expected ^= ord(character)
        assert int(check, 16) == expected
        name, number, *_ = body.split(",")
        if name == "PLRCM":
            frames.append(int(number))
    assert frames == list(range(2 * COUNT))
    assert any(b"$PLRCS" in line for line in lines)


def test_commands(recording):
    folder, frames = recording
    kinds = []
    with running_firmware(folder, *FAST, "--fps", "10", "--rounds", "0") as (_, _, source):
        client = Client(source, lambda number, _, values: kinds.append(number), timeout_s=PATIENCE_S)
        end_s = time.monotonic() + PATIENCE_S
        while m.MARKER not in kinds and time.monotonic() < end_s:
            client.decoder.feed(piece := source.read(), len(piece))
        info = client.info()
        assert info.board == "desk" and (info.width, info.height) == (360, 296)
        client.set("route", list(range(1, 21)))
        assert client.get("route") == list(range(1, 21))
        client.set("rate_divider", 2)
        assert client.get("rate_divider") == 2
        with pytest.raises(Refused, match="conflict"):
            client.set("radius_min_px", 70)
        kinds.clear()
        raw = client.raw_frame()
        assert (raw.width, raw.height) == (360, 296) and raw.pixels in frames
        assert m.MARKER in kinds  # the measurements went on
