"""The firmware on a real MicroPython, over a real pseudo-terminal, read by the host's own tools."""

import json
import os
import subprocess
import sys
import time

import numpy as np
import pytest

from larics.settings import field
from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host.connection.byte_sources import ConnectionLost
from larics_host.connection.pty_pair import PtyPair
from larics_host.connection.receiver import Receiver
from larics_host.connection.records import Ack
from larics_host.render import render_frame
from tests.host.firmware_process import running_firmware, start_firmware
from tests.host.test_dual import ROOT, unix_port
from tests.host.waiting import PATIENCE_S, wait_for_lines, wait_until
from wire_values import message_values

FAST = ["--set", "baud=921600", "--set", "radius_min_px=25", "--set", "radius_max_px=36"]
COUNT = 12


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A folder of frames and the truth of each."""
    folder = tmp_path_factory.mktemp("frames")
    truths = []
    for index in range(COUNT):
        frame, found = render_frame("sunny", 1700, index)
        truths.append(found)
        (folder / ("f%03d.pgm" % index)).write_bytes(b"P5\n360 296\n255\n" + frame.tobytes())
    return folder, truths


def receive(process, source, until=lambda message: False, limit_s=PATIENCE_S):
    """Messages until the program has ended and the line is quiet, or until one of them is the last."""
    receiver = Receiver()
    messages = []
    end_s = time.monotonic() + limit_s
    quiet_s = None
    while time.monotonic() < end_s:
        data = source.read()
        for message in receiver.feed(data, time.monotonic()):
            messages.append(message)
            if until(message):
                return messages, receiver
        if data or process.poll() is None:
            quiet_s = time.monotonic()
        elif time.monotonic() - quiet_s > 1:
            return messages, receiver
    raise AssertionError("no end within %d s; %d messages" % (limit_s, len(messages)))


def of(messages, name):
    return [message.fields for message in messages if message.name == name]


def lost_to_load(messages):
    """Frames that a busy machine did not process, or not send, because a newer one was there."""
    status = of(messages, "STATUS")[-1]
    return status.missed + status.drops


def run(folder, *options):
    with running_firmware(folder, *FAST, *options) as (process, cable, source):
        messages, receiver = receive(process, source)
        output = process.stdout.read()
    assert process.returncode == 0 and not output, output
    return messages, receiver


@pytest.mark.parametrize("method", ["paper", "larics"])
def test_every_frame_is_reported_and_right(recording, method):
    folder, truths = recording
    # each frame is another scene, so that the one before tells nothing of the next
    settings = "--set", "method=" + method, "--set", "tracking=false"
    messages, receiver = run(folder, "--fps", "20", *settings)
    assert receiver.counters.gaps == receiver.counters.crc == 0
    assert messages[0].name == "INFO" and messages[0].fields.board == "desk"
    assert (messages[0].fields.width, messages[0].fields.height) == (360, 296)
    markers = of(messages, "MARKER")
    missed = lost_to_load(messages)
    frames = {marker.frame for marker in markers}
    assert len(frames) == COUNT - missed and missed <= COUNT - 4 and max(frames) <= COUNT - 1
    right = 0
    for marker in markers:
        truth = truths[marker.frame][0]
        if marker.id == truth.id and not marker.flags & m.MARKER_NONE:
            right += 1
            image_deg = 90 - marker.heading_cdeg / 100
            assert abs((image_deg - truth.heading_deg + 180) % 360 - 180) < 3
            assert abs(marker.radius_q8 / 256 - truth.radius_px) < 2
            assert marker.flags & m.MARKER_NO_OFFSET
        assert 0 < marker.age_us < 1000000
    assert right >= len(frames) - 2
    status = of(messages, "STATUS")[-1]
    assert status.frames == len(frames) + status.drops and status.faults == 0
    assert 0 < status.detect_us < 500000 and status.grey_mean > 5 and status.free_bytes > 100000


def test_a_calibrated_camera_reports_millimetres(recording, tmp_path):
    folder, _ = recording
    (tmp_path / "settings.json").write_text(json.dumps({"focal_q8": 600 * 256, "ceiling_mm10": 30000}))
    messages, _ = run(folder, "--settings", str(tmp_path / "settings.json"), "--fps", "20")
    found = [marker for marker in of(messages, "MARKER") if not marker.flags & m.MARKER_NONE]
    assert found
    for marker in found:
        assert not marker.flags & m.MARKER_NO_OFFSET and marker.z_mm10 == 30000
        assert abs(marker.x_mm10) < 8000 and abs(marker.y_mm10) < 10000


def test_frames_without_a_marker_and_the_status_each_second(tmp_path):
    rng = np.random.default_rng(3)
    for index in range(3):
        pixels = rng.integers(100, 110, 320 * 240).astype(np.uint8)
        (tmp_path / ("f%d.pgm" % index)).write_bytes(b"P5\n320 240\n255\n" + pixels.tobytes())
    messages, _ = run(tmp_path, "--fps", "10", "--rounds", "9")
    markers = of(messages, "MARKER")
    assert all(marker.flags == m.MARKER_NONE and marker.id == m.ID_NONE for marker in markers)
    assert len(markers) + lost_to_load(messages) == 27
    uptimes = [status.uptime_s for status in of(messages, "STATUS")]
    assert uptimes[:3] == [0, 1, 2]
    assert of(messages, "STATUS")[-1].state == m.LOST


def test_commands_are_answered_while_frames_go_on(recording):
    folder, _ = recording
    encoder = protocol.Encoder()

    def command(number, *values):
        return bytes(encoder.buffer[: encoder.encode(number, values)])

    with running_firmware(folder, *FAST, "--fps", "30", "--rounds", "0") as (process, cable, source):
        messages, _ = receive(process, source, lambda message: message.name == "MARKER")
        boot = of(messages, "INFO")[0].boot
        source.write(b"noise\0" + command(m.PING, 77))
        messages, _ = receive(process, source, lambda message: message.name == "ACK")
        assert messages[-1].fields == Ack(77, m.PING)
        divider = message_values(m.SET_SETTING, token=78, key=field("rate_divider").key, count=1, value0=3)
        source.write(command(m.SET_SETTING, *divider))
        receive(process, source, lambda message: message.name == "ACK")
        messages, _ = receive(process, source, lambda message: message.name == "STATUS")
        frames = [marker.frame for marker in of(messages, "MARKER")][2:]
        steps = [after - before for before, after in zip(frames, frames[1:], strict=False)]
        assert steps and min(steps) >= 3
        source.write(command(m.SAVE_SETTINGS, 79))
        messages, _ = receive(process, source, lambda message: message.name in ("ACK", "NACK"))
        assert messages[-1].fields.reason == m.NACK_STORAGE  # nowhere to keep them
        source.write(command(m.GET_RAW, 80, m.RAW_WHOLE))
        messages, _ = receive(
            process, source, lambda message: message.name == "RAW_CHUNK" and message.fields.first > 38400
        )
        header = of(messages, "RAW_HEADER")[0]
        assert (header.width, header.height, header.columns, header.rows) == (360, 296) * 2
        assert of(messages, "MARKER")  # measurements go on between the chunks
        source.write(command(m.RESTART, 81, boot ^ 1))
        messages, _ = receive(process, source, lambda message: message.name == "NACK")
        assert messages[-1].fields.reason == m.NACK_BOOT and process.poll() is None
        source.write(command(m.RESTART, 82, boot))
        messages, _ = receive(process, source)
        assert Ack(82, m.RESTART) in of(messages, "ACK")
        assert process.wait(timeout=PATIENCE_S) == 0


def test_a_cable_pulled_out_does_not_stop_the_firmware(recording):
    folder, _ = recording
    with running_firmware(folder, *FAST, "--fps", "30", "--rounds", "0") as (process, cable, source):
        receive(process, source, lambda message: message.name == "MARKER")
        cable.unplug()
        with pytest.raises(ConnectionLost):
            for _ in range(100):
                source.read()
        time.sleep(1)
        assert process.poll() is None


@pytest.mark.parametrize(
    "options, expected",
    [
        (["--frames", "/no/such"], "--frames: there is no /no/such"),
        (["--frames", "{frames}", "--settings", "/no/such"], "--settings: there is no /no/such"),
        (["--frames", "tests/frames"], "not as the first"),
        (["--frames", "."], "no .pgm frame"),
        (["--frames", "{frames}", "--set", "width=1"], "width = 1 is not allowed"),
        (["--frames", "{frames}", "--set", "nonsense=1"], "there is no setting nonsense"),
        (["--frames", "{frames}", "--set", "radius_min_px=x"], "x is no value for radius_min_px"),
        (["--frames", "{frames}", "--fps", "-3"], "--fps wants a whole number"),
        (["--frames", "{frames}", "--speed", "3"], "unknown option --speed"),
        ([], "--frames is missing"),
    ],
)
def test_bad_input_gets_one_line(recording, options, expected):
    options = [option.format(frames=recording[0]) for option in options]
    result = subprocess.run(
        [*unix_port(), "firmware/pc/replay_main.py", "--port", "/dev/null", *options],
        cwd=ROOT,
        env=dict(os.environ, MICROPYPATH="shared:firmware:.frozen"),
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert result.returncode == 2 and not result.stdout
    assert len(result.stderr.splitlines()) == 1 and expected in result.stderr, result.stderr


def test_help_of_the_program_on_a_pc():
    result = subprocess.run(
        [*unix_port(), "firmware/pc/replay_main.py", "--help"],
        cwd=ROOT,
        env=dict(os.environ, MICROPYPATH="shared:firmware:.frozen"),
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert result.returncode == 0 and not result.stderr
    assert result.stdout.startswith("usage: ") and "--settings FILE.json" in result.stdout


def test_a_port_that_does_not_exist(recording):
    process = start_firmware(recording[0], "/dev/no-such-port")
    output = process.communicate(timeout=PATIENCE_S)[0]
    assert process.returncode == 2 and output.startswith("desk: ") and "ENOENT" in output


def last_frames(path):
    """The frames counted by the last message, 0 where that is no STATUS."""
    last = path.read_text().splitlines()[-1:] or ["{}"]
    return json.loads(last[0]).get("frames", 0)


def test_larics_log_records_a_run(recording, tmp_path):
    with PtyPair() as cable:
        command = [sys.executable, "-m", "larics_host", "log", "--port", cable.device_b]
        log = subprocess.Popen(
            [*command, "-o", str(tmp_path / "run")],
            cwd=ROOT,
            env=dict(os.environ, PYTHONPATH="shared:host"),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        wait_for_lines(tmp_path / "run.csv", 1)
        process = start_firmware(recording[0], cable.device_a, *FAST, "--fps", "20")
        assert process.communicate(timeout=PATIENCE_S)[0] == ""
        wait_until(lambda: last_frames(tmp_path / "run.jsonl") >= COUNT - 3)
        log.terminate()
        output = log.communicate(timeout=PATIENCE_S)[0]
    assert log.returncode == 0 and "messages received, 0 lost, 0 damaged" in output, output
    records = [json.loads(line) for line in (tmp_path / "run.jsonl").read_text().splitlines()]
    assert {"INFO", "MARKER", "STATUS"} == {record["message"] for record in records}
    assert records[-1]["message"] == "STATUS" and records[-1]["frames"] >= COUNT - 3
