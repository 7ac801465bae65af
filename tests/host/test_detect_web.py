"""`larics detect` of a camera and its page: live frames from a real MJPEG server, the page over real HTTP."""

import contextlib
import http.client
import json
import os
import re
import signal
import subprocess
import sys
import threading

import cv2
import numpy as np
import pytest

from larics_host import cli
from larics_host.images import live
from larics_host.images.live import is_live, live_frames
from tests.host.browser import headless_browser
from tests.host.mjpeg import NAMES, PICTURES, mjpeg_server
from tests.host.test_dual import ROOT
from tests.host.waiting import PATIENCE_S, wait_until

RADII = "--radius-px", "25:35"


@contextlib.contextmanager
def detecting(tmp_path, *words):
    """(process, port) of a running larics detect --web."""
    environment = dict(os.environ, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"))
    command = [sys.executable, "-m", "larics_host", "detect", *map(str, words), "--web", "0"]
    process = subprocess.Popen(
        command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        line = process.stdout.readline()
        yield process, int(re.match(r"http://127.0.0.1:(\d+)/", line).group(1))
    finally:
        process.kill()
        process.communicate()


def get(port, path, host=None):
    link = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
    link.request("GET", path, headers={"Host": host or "127.0.0.1:%d" % port})
    answer = link.getresponse()
    body = answer.read()
    link.close()
    return answer.status, body


def told(port, condition):
    """The first that the page is told for which the condition holds."""
    link = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
    with contextlib.closing(link):
        link.request("GET", "/events", headers={"Host": "127.0.0.1:%d" % port})
        answer = link.getresponse()
        while line := answer.readline():
            if line.startswith(b"data: "):
                value = json.loads(line[len(b"data: ") :])
                if condition(value):
                    return value
    raise AssertionError("never told")


def test_a_camera_is_watched_on_a_page_until_it_is_ended(tmp_path):
    with mjpeg_server() as server, detecting(tmp_path, server.address, *RADII) as (process, port):
        now = told(port, lambda value: value["number"] > 5 and value["detections"])
        assert now["detections"][0]["id"] in {4, 1, 6} and now["source"] == server.address
        code, body = get(port, "/frame.jpg")
        image = cv2.imdecode(np.frombuffer(body, np.uint8), cv2.IMREAD_COLOR)
        assert code == 200 and image.shape[0] >= 296
        assert np.any(image.max(2) - image.min(2) > 100)  # something is drawn in, in colour
        assert get(port, "/frame.jpg", "evil.example")[0] == 403 and get(port, "/other")[0] == 404
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 0 and re.search(r"\d+ frames; \d+ with a marker", out), err


def test_the_page_of_a_video_shows_its_last_frame_and_that_it_ended(tmp_path):
    frames = [str(ROOT / "tests/frames" / name) for name in NAMES]
    with detecting(tmp_path, *frames, *RADII) as (process, port):
        now = told(port, lambda value: value["ended"])
        assert now["number"] == 3 and now["ended"].startswith("3 frames; 3 with a marker")
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE_S) == 0


def test_a_browser_shows_it(tmp_path):
    frames = [str(ROOT / "tests/frames" / name) for name in NAMES]
    with detecting(tmp_path, *frames, *RADII) as (_, port), headless_browser() as browser:
        browser.get("http://127.0.0.1:%d/" % port)
        wait_until(lambda: browser.execute_script("return document.querySelector('img').naturalWidth") > 0)
        assert len(browser.find_elements("css selector", "tbody tr")) == 1
        assert [one for one in browser.get_log("browser") if "favicon" not in one["message"]] == []


def test_frames_that_nobody_takes_are_left_out():
    class Capture:
        """Twenty frames at once, and then a wait until it is to end."""

        count, has_served, may_end = 0, threading.Event(), threading.Event()

        def read(self):
            if self.count == 20:
                self.has_served.set()
                self.may_end.wait(PATIENCE_S)
                return False, None
            self.count += 1
            return True, np.full((2, 2), self.count, np.uint8)

        def release(self):
            pass

    capture = Capture()
    newest = live._Newest(capture, lambda: False)
    assert capture.has_served.wait(PATIENCE_S) and newest.take()[0, 0] == 20
    capture.may_end.set()
    assert newest.take() is None
    newest.end()


def test_frames_of_an_address_come_until_it_is_closed():
    with mjpeg_server() as server, contextlib.closing(live_frames(server.address)) as frames:
        shown = [next(frames) for _ in range(3)]
        assert [name for name, _ in shown] == ["%s#%d" % (server.address, k) for k in range(3)]
        assert all(frame.shape == PICTURES[0].shape for _, frame in shown)


@pytest.mark.parametrize(
    "name, live",
    [
        ("/dev/video0", True),
        ("rtsp://camera/1", True),
        ("http://camera:8080/stream?x=1", True),
        ("https://host/clip.mp4", False),
        ("s3://bucket/frames", False),
        ("drive.mp4", False),
    ],
)
def test_what_is_a_camera(name, live):
    assert is_live(name) == live


@pytest.mark.parametrize(
    "words, said",
    [
        (["http://127.0.0.1:9/"], "http://127.0.0.1:9/ cannot be opened: nobody answers there"),
        (["/dev/video77"], "there is no /dev/video77"),
        (["/dev/video0", "x.png"], "one camera at a time"),
        (["x.png", "--web", "70000"], "--web 70000: give a port"),
    ],
)
def test_bad_input_is_one_line(words, said, capsys):
    assert cli.main(["detect", *words]) == 2
    err = capsys.readouterr().err
    assert said in err and len(err.strip().splitlines()) == 1
