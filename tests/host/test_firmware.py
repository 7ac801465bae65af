"""The firmware on a real MicroPython, over a real pseudo-terminal, read by the host's own tools."""

import json
import os
import signal
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
from tests.host.firmware_process import pieces, running_firmware, start_firmware
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


def receive(process, cable, source, until=lambda message: False):
    """Messages until the program has ended, or until one of them is the last."""
    receiver = Receiver()
    messages = []
    for data in pieces(process, cable, source):
        for message in receiver.feed(data, time.monotonic()):
            messages.append(message)
            if until(message):
                return messages, receiver
    return messages, receiver


def of(messages, name):
    return [message.fields for message in messages if message.name == name]


def run(folder, *options):
    with running_firmware(folder, *FAST, *options) as (process, cable, source):
        messages, receiver = receive(process, cable, source)
        output = process.stdout.read()
    assert process.returncode == 0 and not output, output
    return messages, receiver


@pytest.mark.parametrize("method", ["paper", "larics"])
def test_every_frame_is_reported_and_right(recording, method):
    folder, truths = recording
    # each frame is another scene, so that the one before tells nothing of the next
    settings = "--set", "method=" + method, "--set", "tracking=false"
    begin_s = time.monotonic()
    messages, receiver = run(folder, "--fps", "0", *settings)
    passed_us = (time.monotonic() - begin_s) * 1e6
    assert receiver.counters.gaps == receiver.counters.crc == 0
    assert messages[0].name == "INFO" and messages[0].fields.board == "desk"
    assert (messages[0].fields.width, messages[0].fields.height) == (360, 296)
    markers = of(messages, "MARKER")
    frames = [marker.frame for marker in markers]
    assert sorted(set(frames)) == list(range(COUNT)) and frames == sorted(frames)
    right = 0
    for marker in markers:
        truth = truths[marker.frame][0]
        if marker.id == truth.id and not marker.flags & m.MARKER_NONE:
            right += 1
            image_deg = 90 - marker.heading_cdeg / 100
            assert abs((image_deg - truth.heading_deg + 180) % 360 - 180) < 3
            assert abs(marker.radius_q8 / 256 - truth.radius_px) < 2
            assert marker.flags & m.MARKER_NO_OFFSET
        assert 0 < marker.age_us < passed_us
    assert right >= COUNT - 2
    status = of(messages, "STATUS")[-1]
    assert status.frames == COUNT and status.missed == status.drops == status.faults == 0
    assert status.grey_mean > 5 and status.free_bytes > 100000
    detect_us = [status.detect_us for status in of(messages, "STATUS") if status.detect_us is not None]
    assert detect_us and min(detect_us) > 0 and max(detect_us) < passed_us


def test_frames_that_come_too_fast_are_skipped_and_counted(recording):
    folder, _ = recording
    # once: a whole round later there would be the same picture again, which is no new frame
    messages, _ = run(folder, "--fps", "1000000", "--rounds", "1")
    status = of(messages, "STATUS")[-1]
    assert status.missed > 0 and status.frames + status.missed == COUNT
    frames = [marker.frame for marker in of(messages, "MARKER")]
    assert frames == sorted(frames) and len(set(frames)) + status.drops == status.frames
    assert frames[-1] == COUNT - 1


def test_a_calibrated_camera_reports_millimetres(recording, tmp_path):
    folder, _ = recording
    (tmp_path / "settings.json").write_text(json.dumps({"focal_q8": 600 * 256, "ceiling_mm10": 30000}))
    messages, _ = run(folder, "--settings", str(tmp_path / "settings.json"), "--fps", "0")
    found = [marker for marker in of(messages, "MARKER") if not marker.flags & m.MARKER_NONE]
    assert found
    for marker in found:
        assert not marker.flags & m.MARKER_NO_OFFSET and marker.z_mm10 == 30000
        assert abs(marker.x_mm10) < 8000 and abs(marker.y_mm10) < 10000


def test_frames_without_a_marker(tmp_path):
    rng = np.random.default_rng(3)
    for index in range(3):
        pixels = rng.integers(100, 110, 320 * 240).astype(np.uint8)
        (tmp_path / ("f%d.pgm" % index)).write_bytes(b"P5\n320 240\n255\n" + pixels.tobytes())
    messages, _ = run(tmp_path, "--fps", "0", "--rounds", "9")
    markers = of(messages, "MARKER")
    assert all(marker.flags == m.MARKER_NONE and marker.id == m.ID_NONE for marker in markers)
    assert [marker.frame for marker in markers] == list(range(27))
    assert of(messages, "STATUS")[-1].state == m.LOST


def test_the_status_comes_each_second(recording):
    uptimes = []

    def is_third(message):
        """Whether three came a second apart; a program that stood still meanwhile does so later."""
        if message.name == "STATUS":
            uptimes.append(message.fields.uptime_s)
        return len(uptimes) >= 3 and uptimes[-3] == uptimes[-1] - 2 == uptimes[-2] - 1

    with running_firmware(recording[0], *FAST, "--fps", "10", "--rounds", "0") as (process, cable, source):
        messages, _ = receive(process, cable, source, is_third)
    assert uptimes == sorted(uptimes) and process.returncode == -signal.SIGKILL


def test_commands_are_answered_while_frames_go_on(recording):
    folder, _ = recording
    encoder = protocol.Encoder()

    def is_late_chunk(message):
        return message.name == "RAW_CHUNK" and message.fields.first > 38400

    def command(number, *values):
        return bytes(encoder.buffer[: encoder.encode(number, values)])

    with running_firmware(folder, *FAST, "--fps", "0", "--rounds", "0") as (process, cable, source):
        messages, _ = receive(process, cable, source, lambda message: message.name == "MARKER")
        boot = of(messages, "INFO")[0].boot
        source.write(b"noise\0" + command(m.PING, 77))
        messages, _ = receive(process, cable, source, lambda message: message.name == "ACK")
        assert messages[-1].fields == Ack(77, m.PING)
        divider = message_values(m.SET_SETTING, token=78, key=field("rate_divider").key, count=1, value0=3)
        source.write(command(m.SET_SETTING, *divider))
        receive(process, cable, source, lambda message: message.name == "ACK")
        frames = []

        def is_ninth(message):
            if message.name == "MARKER":
                frames.append(message.fields.frame)
            return len(frames) == 9

        receive(process, cable, source, is_ninth)
        steps = {after - before for before, after in zip(frames[2:], frames[3:], strict=False)}
        assert not any(step % 3 for step in steps)  # more than 3 where a full line made it drop one
        source.write(command(m.SAVE_SETTINGS, 79))
        messages, _ = receive(process, cable, source, lambda message: message.name in ("ACK", "NACK"))
        assert messages[-1].fields.reason == m.NACK_STORAGE  # nowhere to keep them
        source.write(command(m.GET_RAW, 80, m.RAW_WHOLE))
        messages, _ = receive(process, cable, source, is_late_chunk)
        header = of(messages, "RAW_HEADER")[0]
        assert (header.width, header.height, header.columns, header.rows) == (360, 296) * 2
        assert of(messages, "MARKER")  # measurements go on between the chunks
        source.write(command(m.RESTART, 81, boot ^ 1))
        messages, _ = receive(process, cable, source, lambda message: message.name == "NACK")
        assert messages[-1].fields.reason == m.NACK_BOOT and process.poll() is None
        source.write(command(m.RESTART, 82, boot))
        messages, _ = receive(process, cable, source)
        assert Ack(82, m.RESTART) in of(messages, "ACK")
        assert process.wait(timeout=PATIENCE_S) == 0


def test_a_cable_pulled_out_does_not_stop_the_firmware(recording):
    folder, _ = recording
    with running_firmware(folder, *FAST, "--fps", "30", "--rounds", "0") as (process, cable, source):
        receive(process, cable, source, lambda message: message.name == "MARKER")
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
    whole = path.read_text().rpartition("\n")[0]
    return json.loads(whole.splitlines()[-1]).get("frames", 0) if whole else 0


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
        process = start_firmware(recording[0], cable.device_a, *FAST, "--fps", "0")
        assert process.communicate(timeout=PATIENCE_S)[0] == ""
        wait_until(lambda: last_frames(tmp_path / "run.jsonl") == COUNT)
        log.terminate()
        output = log.communicate(timeout=PATIENCE_S)[0]
    assert log.returncode == 0 and "messages received, 0 lost, 0 damaged" in output, output
    records = [json.loads(line) for line in (tmp_path / "run.jsonl").read_text().splitlines()]
    assert {"INFO", "MARKER", "STATUS"} == {record["message"] for record in records}
    assert records[-1]["message"] == "STATUS" and records[-1]["frames"] == COUNT
