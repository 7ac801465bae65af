"""The driver for videos and addresses: sources that are lost, slow or broken, from a real MJPEG server."""

import contextlib
import itertools
import threading

import cv2
import pytest

from cameras import CameraError
from pc import video_camera, video_source
from pc.video_camera import VideoCamera
from pc.video_source import VideoSource, is_whole
from tests.host.mjpeg import PICTURES, jpeg, mjpeg_server
from tests.host.waiting import Clock, wait_until


@pytest.fixture(autouse=True)
def patience(monkeypatch):
    """Who serves the pictures may stand still for a while."""
    monkeypatch.setattr(video_source, "_TIMEOUT_MS", 60000)


@contextlib.contextmanager
def driver(address, opens=None, **options):
    """A started VideoCamera, with what it told."""
    told = []
    camera = VideoCamera(opens or (lambda: VideoSource(address)), tell=told.append, **options)
    camera.start()
    try:
        yield camera, told
    finally:
        camera.stop()


def next_frame(camera):
    wait_until(camera.grab)
    return bytes(camera.frame)


def shown(frame):
    """Which of the pictures a frame shows, None when it is none of them whole."""
    decoded = [cv2.imdecode(cv2.imencode(".jpg", p, [cv2.IMWRITE_JPEG_QUALITY, 95])[1], 0) for p in PICTURES]
    return next((k for k in range(3) if decoded[k].tobytes() == frame), None)


def test_an_opening_is_waited_for_and_a_restart_does_not_begin_another():
    gate = threading.Event()
    opened = []

    def slowly():
        opened.append(True)
        assert len(opened) == 1 or gate.wait(100)
        return VideoSource(server.address)

    with mjpeg_server() as server, driver(server.address, slowly) as (camera, _):
        next_frame(camera)
        camera.stop()
        camera.start()
        wait_until(lambda: len(opened) == 2)
        for _ in range(3):  # whoever insists waits for the same opening
            assert camera.opening and not camera.grab()
            camera.stop()
            camera.start()
        assert len(opened) == 2
        gate.set()
        assert shown(next_frame(camera)) is not None
        assert not camera.opening and len(opened) == 3


def test_the_source_is_opened_once():
    with mjpeg_server() as server:
        camera = VideoCamera(lambda: VideoSource(server.address))
        camera.open()
        camera.start()
        numbers = []
        for _ in range(4):
            next_frame(camera)
            numbers.append(camera.frame_number)
        camera.stop()
        assert server.opened == 1 and numbers == sorted(set(numbers)) and numbers[0] >= 0


def test_a_stream_that_falls_silent_is_opened_again_until_it_speaks(monkeypatch):
    monkeypatch.setattr(video_source, "_TIMEOUT_MS", 2000)
    bodies = [jpeg(frame) for frame in PICTURES]
    silent = threading.Event()
    with (
        mjpeg_server(lambda number: None if silent.is_set() else bodies[number % 3]) as server,
        driver(server.address) as (camera, told),
    ):
        next_frame(camera)
        silent.set()
        wait_until(lambda: told and "cannot be opened" in told[-1])
        assert camera.opening and "no more frames: opening it again" in told
        while camera.grab():
            pass
        silent.clear()
        next_frame(camera)
        wait_until(lambda: told[-1] == "frames again")


def test_half_frames_are_left_out_and_counted():
    bodies = [jpeg(frame) for frame in PICTURES]

    def every_third_whole(number):
        body = bodies[number // 3 % 3]
        return body if number % 3 == 0 else body[: len(body) // 2]

    with mjpeg_server(every_third_whole) as server, driver(server.address) as (camera, _):
        seen = [shown(next_frame(camera)) for _ in range(6)]
        assert None not in seen and len(set(seen)) == 3
        assert camera.skipped >= 10


def test_a_source_of_half_frames_is_told(monkeypatch):
    monkeypatch.setattr(video_source, "_TIMEOUT_MS", 500)
    body = jpeg(PICTURES[0])
    with (
        mjpeg_server(lambda number: body[:-300]) as server,
        pytest.raises(CameraError, match="delivers half frames only"),
    ):
        VideoSource(server.address)


def test_a_thumbnail_in_the_header_is_no_end():
    body = jpeg(PICTURES[0])
    with_thumbnail = body[:2] + b"\xff\xe1\x00\x08ab\xff\xd9xy"[:10] + body[2:]
    assert is_whole(body) and is_whole(with_thumbnail) and is_whole(body + b"\r\n\0\0")
    assert not is_whole(with_thumbnail[:-300]) and not is_whole(b"") and not is_whole(b"no jpeg")


def test_another_size_is_told_and_the_first_one_is_waited_for():
    bodies = [jpeg(PICTURES[0]), jpeg(cv2.resize(PICTURES[0], (480, 400)))]
    large = threading.Event()
    with (
        mjpeg_server(lambda number: bodies[large.is_set()]) as server,
        driver(server.address) as (camera, told),
    ):
        next_frame(camera)
        large.set()
        wait_until(lambda: len(told) >= 2)
        assert "now delivers 480x400 instead of 360x296" in told[0]
        assert told[1] == "frames of 480x400 instead of 360x296: start again for another size"
        large.clear()
        wait_until(lambda: told[-1] == "frames again")
        wait_until(camera.grab)
        assert (camera.width, camera.height) == (360, 296)


def test_attempts_become_rarer_and_are_told_once(monkeypatch):
    waits_s = (0.02, 0.04, 0.08, 0.16)
    monkeypatch.setattr(video_camera, "_REOPEN_S", waits_s)
    attempts = []

    def once():
        attempts.append(video_camera.time.monotonic())
        if len(attempts) == 1:
            return VideoSource(server.address)
        raise CameraError("gone")

    with mjpeg_server() as server, driver(server.address, once) as (camera, told):
        next_frame(camera)
        server.stop.set()
        wait_until(lambda: len(attempts) == 8)
        gaps_s = [after - before for before, after in itertools.pairwise(attempts[1:])]
        assert all(gap >= wait for gap, wait in zip(gaps_s, (*waits_s[1:], *waits_s[-1:] * 3), strict=False))
        assert told == ["no more frames: opening it again", "gone"]


def test_the_first_opening_is_patient_with_what_is_slow_and_not_with_a_refusal(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(video_camera, "time", clock)
    attempts = []

    def slowly(took_s=2.0, least=9):
        attempts.append(took_s)
        clock.now_s += took_s
        if len(attempts) < least:
            raise CameraError("no frame")
        return VideoSource(server.address)

    with mjpeg_server() as server:
        VideoCamera(lambda: slowly(least=2)).open()
        assert len(attempts) == 2
        for took_s, count in ((2.0, 5), (0.1, 1)):
            attempts.clear()
            with pytest.raises(CameraError, match="no frame"):
                VideoCamera(lambda: slowly(took_s)).open()  # noqa: B023 (called at once)
            assert len(attempts) == count


def test_a_device_that_is_none():
    with pytest.raises(CameraError, match="/dev/null is no camera"):
        VideoSource("/dev/null")


def test_a_size_that_is_not_delivered():
    with mjpeg_server() as server, pytest.raises(CameraError, match="delivers 360x296 and not 640x480"):
        VideoSource(server.address, (640, 480))
