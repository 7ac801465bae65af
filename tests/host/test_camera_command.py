"""`larics camera`: the sensor on a computer, with real videos, an MJPEG server, a pty, TCP and C."""

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time

import cv2
import pytest

from larics.wire import messages as m
from larics_host.connection.receiver import Receiver
from larics_host.truth import by_frame, read_truth
from pc import byte_lines
from tests.host.mjpeg import NAMES, PICTURES, jpeg, mjpeg_server, tag_turn
from tests.host.test_dual import ROOT
from tests.host.waiting import PATIENCE_S

# other scenes, one after the other: there is nothing to be tracked
UNTRACKED = "--set", "tracking=false"


def video(path, frames, fps=30):
    height, width = frames[0].shape
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), fps, (width, height), False)
    for frame in frames:
        writer.write(frame)
    writer.release()
    return str(path)


def command(tmp_path, *options):
    settings = ["--settings", str(tmp_path / "settings.json")]
    return [sys.executable, "-m", "larics_host", "camera", *settings, *options]


def environment(tmp_path):
    return dict(os.environ, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"), HOME=str(tmp_path))


def messages_of(data):
    return [(message.name, message.fields) for message in Receiver().feed(data, 0.0)]


@contextlib.contextmanager
def running(tmp_path, *options):
    """(process, where its line is to be had)"""
    process = subprocess.Popen(
        command(tmp_path, *options),
        env=environment(tmp_path),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        said, found = "", None
        while not found:  # before it there may be what is compiled, or that the source stands still
            line = process.stderr.readline()
            said += line
            assert line, said
            found = re.search(r"\d from \S+ to (\S+)$", line.strip())
        yield process, found.group(1)
    finally:
        process.terminate()
        process.communicate(timeout=PATIENCE_S)


class Listener:
    """Reads the messages at a TCP address until one is as wanted."""

    def __init__(self, address):
        host, port = address.split(":")
        self._socket = socket.create_connection((host, int(port)), timeout=PATIENCE_S)
        self._receiver = Receiver()
        self._waiting = []

    def until(self, wanted):
        """The first message from now on for which wanted(name, fields) is true."""
        end_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < end_s:
            while self._waiting:
                message = self._waiting.pop(0)
                if wanted(message.name, message.fields):
                    return message.fields
            data = self._socket.recv(4096)
            assert data, "the camera hung up"
            self._waiting += self._receiver.feed(data, 0.0)
        raise AssertionError("no such message came")


def marker(name, fields):
    return name == "MARKER" and fields.count > 0


def test_every_frame_of_a_video_is_reported_with_its_marker(tmp_path):
    source = video(tmp_path / "drive.avi", PICTURES * 4)
    done = subprocess.run(
        command(tmp_path, "--source", source, "--every", "--stdout", *UNTRACKED),
        env=environment(tmp_path),
        capture_output=True,
        timeout=PATIENCE_S,
    )
    assert done.returncode == 0, done.stderr
    truths = by_frame(read_truth(ROOT / "tests/frames"))
    wanted = [truths[name][0].id for name in NAMES] * 4
    markers = [fields for name, fields in messages_of(done.stdout) if name == "MARKER"]
    assert [fields.id for fields in markers] == wanted
    assert [fields.frame - markers[0].frame for fields in markers] == list(range(12))
    info = next(fields for name, fields in messages_of(done.stdout) if name == "INFO")
    assert (info.board, info.width, info.height) == ("linux", 360, 296)


def test_a_tag_that_turns_a_video_is_told_and_not_obeyed(tmp_path):
    path = tmp_path / "drive.mp4"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), 30, (360, 296), False)
    for frame in PICTURES:
        writer.write(frame)
    writer.release()
    tag_turn(path, 90)
    done = subprocess.run(
        command(tmp_path, "--source", str(path), "--every", "--stdout", *UNTRACKED),
        env=environment(tmp_path),
        capture_output=True,
        timeout=PATIENCE_S,
    )
    info = next(fields for name, fields in messages_of(done.stdout) if name == "INFO")
    assert (info.width, info.height) == (360, 296)
    assert b"a tag asks to show it turned by 90 degrees; that is ignored" in done.stderr


def test_large_frames_are_reduced_by_a_whole_factor(tmp_path):
    large = [cv2.resize(frame, None, fx=4, fy=4, interpolation=cv2.INTER_CUBIC) for frame in PICTURES]
    source = video(tmp_path / "large.avi", large * 2, fps=100)
    done = subprocess.run(
        command(tmp_path, "--source", source, "--stdout", "--set", "radius_max_px=66"),
        env=environment(tmp_path),
        capture_output=True,
        timeout=PATIENCE_S,
    )
    messages = messages_of(done.stdout)
    info = next(fields for name, fields in messages if name == "INFO")
    assert (info.width, info.height) == (720, 592)
    # in its own time: what there was no time for is missed, and told
    assert {fields.count for name, fields in messages if name == "MARKER"} == {1}
    status = [fields for name, fields in messages if name == "STATUS"][-1]
    assert status.frames + status.missed == 6
    told = "%d frames processed, %d missed while the computer was busy" % (status.frames, status.missed)
    assert (told in done.stderr.decode()) == (status.missed > 0)


def faulty(fields):
    return fields.active_faults >> m.FAULT_CAMERA_TIMEOUT & 1


def test_a_stream_that_falls_silent_and_comes_back(tmp_path):
    bodies = [jpeg(frame) for frame in PICTURES]
    silent = threading.Event()
    with contextlib.ExitStack() as stack:
        server = stack.enter_context(
            mjpeg_server(lambda number: None if silent.is_set() else bodies[number % 3])
        )
        _, line = stack.enter_context(running(tmp_path, "--source", server.address, "--tcp", "0", *UNTRACKED))
        listener = Listener(line)
        first = listener.until(marker)
        silent.set()
        listener.until(lambda n, f: n == "STATUS" and faulty(f) and f.state == m.LOST)
        silent.clear()
        again = listener.until(lambda name, fields: marker(name, fields) and fields.frame > first.frame)
        assert again.id in {4, 1, 6}  # those of the pictures
        listener.until(lambda n, f: n == "STATUS" and not faulty(f) and f.state == m.TRACKING)


def test_a_source_that_vanishes_is_opened_again(tmp_path):
    with contextlib.ExitStack() as stack:
        with mjpeg_server() as server:
            options = "--source", server.address, "--tcp", "0"
            _, line = stack.enter_context(running(tmp_path, *options))
            listener = Listener(line)
            first = listener.until(marker)
        with mjpeg_server(port=server.server_address[1]):
            later = listener.until(lambda n, f: marker(n, f) and f.frame > first.frame + 2)
            assert later.id in {4, 1, 6}  # those of the pictures


def test_settings_are_kept_for_the_next_start(tmp_path):
    link = "--link", str(tmp_path / "larics")
    with mjpeg_server() as server, running(tmp_path, "--source", server.address, *link):
        pairs = [sys.executable, "-m", "larics_host", "settings"]
        port = ["--port", str(tmp_path / "larics")]
        for words in (["set", "max_speed_mm_s=1234"], ["save"]):
            done = subprocess.run(
                [*pairs, words[0], *port, *words[1:]],
                env=environment(tmp_path),
                capture_output=True,
                text=True,
            )
            assert done.returncode == 0, done.stderr
    assert b'"max_speed_mm_s": 1234' in (tmp_path / "settings.json").read_bytes()
    assert not os.path.lexists(tmp_path / "larics")


def test_the_c_library_reads_it(tmp_path):
    program = tmp_path / "read_stream"
    sources = sorted((ROOT / "firmware/vehicle/src").glob("*.c"))
    example = ROOT / "firmware/vehicle/examples/linux/read_stream.c"
    include = "-I%s" % (ROOT / "firmware/vehicle/src")
    subprocess.run(["gcc", "-std=c99", include, *sources, example, "-o", program], check=True)
    source = video(tmp_path / "drive.avi", PICTURES * 8)
    done = subprocess.run(
        command(tmp_path, "--source", source, "--every", "--stdout", *UNTRACKED),
        env=environment(tmp_path),
        capture_output=True,
    )
    said = subprocess.run([program], input=done.stdout, capture_output=True, text=False).stdout.decode()
    assert said.count("(1 of 1)") == 24, said[:600]


@pytest.mark.parametrize(
    "options, said",
    [
        (["--source", "/dev/video77"], "there is no /dev/video77: is the camera plugged in?"),
        (["--source", "/dev/null"], "/dev/null is no camera"),
        (["--source", "nothing.mp4"], "there is no file nothing.mp4"),
        (["--source", "."], ". is a folder"),
        (["--source", "empty.mp4"], "empty.mp4 is empty"),
        (["--source", "http://127.0.0.1:9/"], "cannot be opened: nobody answers there"),
        (["--source", "x", "--size", "640"], "--size 640 is no size"),
        (["--source", "x", "--tcp", "70000"], "--tcp 70000 is no port"),
        (["--source", "x", "--fps", "nan"], "--fps nan"),
        (["--source", "x", "--baud", "0"], "--baud 0"),
        (["--source", "x", "--set", "nonsense=1"], "nonsense"),
        (["--source", "x", "--settings", "run.csv"], "saving would overwrite it: choose another name"),
        (["--source", "empty.mp4", "--settings", "."], "cannot read .: Is a directory"),
        (["--source", "x", "--port", "/dev/null", "--stdout"], "not allowed with"),
    ],
)
def test_bad_input_is_one_line(tmp_path, options, said):
    (tmp_path / "empty.mp4").touch()
    (tmp_path / "run.csv").write_text("frame,id\n1,3\n")
    done = subprocess.run(
        command(tmp_path, *options),
        env=environment(tmp_path),
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        cwd=tmp_path,
    )
    assert done.returncode == 2 and said in done.stderr, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_what_cannot_be_opened_is_told_before_anything_is_compiled(tmp_path):
    pytest.importorskip("numba")
    (tmp_path / "loops").mkdir()
    done = subprocess.run(
        command(tmp_path, "--source", "nothing.mp4"),
        env=environment(tmp_path) | {"NUMBA_CACHE_DIR": str(tmp_path / "loops")},
        capture_output=True, text=True, timeout=PATIENCE_S,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (2, "larics: there is no file nothing.mp4\n")
    assert not list((tmp_path / "loops").rglob("*.nbi"))


def test_a_port_that_cannot_be_opened_is_told_plainly():
    with pytest.raises(OSError, match="^/dev/nothere cannot be opened: no such file or directory$"):
        byte_lines.SerialPort("/dev/nothere", 115200)


def test_a_tcp_port_that_is_taken_is_told_plainly():
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with pytest.raises(OSError, match="^TCP port %d of this computer cannot be served: address" % port):
            byte_lines.TcpServer(port)


def test_settings_that_are_not_read_whole_are_told(tmp_path):
    kept = tmp_path / "kept.json"
    source = video(tmp_path / "short.avi", PICTURES[:3])
    for text, said in (
        ('{"margin_min": 999}', "not allowed"),
        ('{"version": 9}', "version"),
    ):
        kept.write_text(text)
        done = subprocess.run(
            command(tmp_path, "--source", source, "--every", "--stdout", "--settings", str(kept)),
            env=environment(tmp_path), capture_output=True, timeout=PATIENCE_S,
        )  # fmt: skip
        assert done.returncode == 0 and done.stdout
        lines = done.stderr.decode().splitlines()
        assert sum(str(kept) in line and said in line for line in lines) == 1, lines


def test_a_port_and_settings_belong_to_one_camera(tmp_path):
    with mjpeg_server() as server, running(tmp_path, "--source", server.address):
        done = subprocess.run(
            command(tmp_path, "--source", server.address),
            env=environment(tmp_path),
            capture_output=True,
            text=True,
        )
        assert done.returncode == 2 and "another larics camera uses" in done.stderr


def test_it_ends_when_nobody_reads_its_output(tmp_path):
    source = video(tmp_path / "drive.avi", PICTURES * 200, fps=20)
    process = subprocess.Popen(
        command(tmp_path, "--source", source, "--stdout"),
        env=environment(tmp_path),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    process.stdout.read(10)
    process.stdout.close()
    assert process.wait(timeout=PATIENCE_S) == 0
    assert b"Traceback" not in process.stderr.read()
    process.stderr.close()


def test_a_signal_waits_until_a_compiled_loop_is_loaded():
    code = """
import os, signal
from pc import linux_main
linux_main.stop_by_signals()
text = "os.kill(os.getpid(), signal.SIGTERM); print('loaded', flush=True)"
loading = compile(text, "/a/numba/b.py", "exec")
try:
    exec(loading)
    print("goes on", flush=True)
    while True:
        signal.pause()
except linux_main.Stop:
    print("ends")
"""
    paths = ":".join(str(ROOT / name) for name in ("firmware", "shared"))
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=dict(os.environ, PYTHONPATH=paths),
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert (done.stdout.split("\n"), done.stderr) == (["loaded", "goes on", "ends", ""], "")


def test_ctrl_c_while_its_modules_load_ends_it_without_a_traceback(tmp_path):
    (tmp_path / "app.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n")
    paths = ":".join(str(path) for path in (tmp_path, ROOT / "firmware", ROOT / "shared"))
    done = subprocess.run(
        [sys.executable, str(ROOT / "firmware" / "pc" / "linux_start.py"), "{}"],
        env=dict(os.environ, PYTHONPATH=paths),
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    assert (done.returncode, done.stderr) == (-signal.SIGINT, "")


def test_a_signal_ends_it_well(tmp_path):
    for number in (signal.SIGTERM, signal.SIGINT):
        with mjpeg_server() as server, running(tmp_path, "--source", server.address) as (process, _):
            process.send_signal(number)
            assert process.wait(timeout=PATIENCE_S) == 0


def test_a_file_of_settings_as_editors_of_windows_save_it(tmp_path):
    source = video(tmp_path / "drive.avi", PICTURES)
    path = tmp_path / "settings.json"
    for data, part in (
        (b"\xef\xbb\xbf" + b'{"version": 1, "margin_min": 7}', None),
        ('{"version": 1}'.encode("utf-16"), "is a text in UTF-16: save it as UTF-8"),
        ('{"version": 1}'.encode("utf-16-le"), "is a text in UTF-16-LE: save it as UTF-8"),
    ):
        path.write_bytes(data)
        done = subprocess.run(
            command(tmp_path, "--source", source, "--every", "--stdout"),
            env=environment(tmp_path),
            capture_output=True,
            timeout=PATIENCE_S,
        )
        told = done.stderr.decode()
        if part:
            assert done.returncode == 2 and part in told and path.read_bytes() == data
        else:
            assert done.returncode == 0 and "default" not in told, told
