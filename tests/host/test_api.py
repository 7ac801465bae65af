"""The Python API: typed items of a log, a port, an address; times, errors, asyncio, commands, the README's
lines."""

import asyncio
import contextlib
import io
import itertools
import json
import math
import os
import socket
import subprocess
import sys
import threading
from datetime import UTC, datetime, timedelta

import cv2
import pytest

import larics_host
from larics.wire import messages as m
from larics_host import (
    Camera,
    CameraError,
    Health,
    Measurement,
    Motion,
    NothingSeen,
    Pose,
    Started,
)
from larics_host.connection.frame_times import FrameTimes
from larics_host.connection.pty_pair import PtyPair
from larics_host.connection.receiver import Receiver
from larics_host.connection.records import Marker
from larics_host.logs.log_writer import LogWriter
from tests.host.test_dual import ROOT
from tests.host.test_log import info_values, marker_values, status_values, wire, write_all
from tests.host.test_monitor import firmware
from tests.host.waiting import Clock
from wire_values import message_values

START = datetime(2026, 3, 1, 12, 0, 0, tzinfo=UTC)
NOTHING = {"frame": 2, "age_us": 7000, "flags": m.MARKER_NONE, "id": m.ID_NONE}
UNKNOWN = {"sigma_q12": m.SIGMA_UNKNOWN, "sigma_mdeg": m.SIGMA_UNKNOWN}
PLACE = {"x_mm10": 12345, "y_mm10": -500, "heading_cdeg": 9050, "sigma_x_mm10": 30, "sigma_y_mm10": 40}
MORE = {"correlation_q14": 8192, "sigma_cdeg": 25, "way_mm": 70, "next_cdeg": 100}
TRACKED = {"frame": 1, "age_us": 9000, "state": m.TRACKING, "id": 3, "marker_age_ms": 250, **PLACE, **MORE}
LOST = {
    "frame": 2, "age_us": 9000, "state": m.LOST, "id": m.ID_NONE, "marker_age_ms": m.AGE_UNKNOWN,
    "x_mm10": m.PLACE_UNKNOWN, "y_mm10": m.PLACE_UNKNOWN, "heading_cdeg": m.HEADING_UNKNOWN,
    "sigma_x_mm10": m.SIGMA_UNKNOWN, "sigma_y_mm10": m.SIGMA_UNKNOWN, "sigma_cdeg": m.SIGMA_UNKNOWN,
    "way_mm": m.WAY_UNKNOWN, "route_position": m.ROUTE_NONE, "next_cdeg": m.DIRECTION_NONE,
}  # fmt: skip
LOGGED = (
    (m.INFO, info_values(unique_id=bytes(range(12)), version_minor=1)),
    (m.MARKER, marker_values(1)),
    (
        m.POSE,
        message_values(m.POSE, **TRACKED),
    ),
    (m.MOTION, message_values(m.MOTION, frame=1, state=m.MOTION_INTERPOLATED, x_mm10=55, heading_cdeg=4500)),
    (m.MARKER, message_values(m.MARKER, **NOTHING, **UNKNOWN)),
    (m.POSE, message_values(m.POSE, **LOST)),
    (m.ACK, message_values(m.ACK)),
    (m.STATUS, status_values(state=m.LOST, active_faults=1 << m.FAULT_CAMERA_DARK, faults=2, rate_chz=5990)),
)


def write_log(prefix, messages=LOGGED, every_s=0.5):
    log = LogWriter(str(prefix), start_ns=int(START.timestamp() * 1e9), mcap=True)
    receiver = Receiver()
    for k, one in enumerate(messages):
        (message,) = receiver.feed(wire(one), every_s * k)
        log.write(message)
    log.close()
    return str(prefix) + ".jsonl"


def test_what_a_log_holds_is_typed_and_timed(tmp_path):
    path = write_log(tmp_path / "run")
    with Camera(path) as camera:
        items = list(camera)
        assert list(camera) == [] and camera.lost == 0
    kinds = [type(item) for item in items]
    assert kinds == [Started, Measurement, Pose, Motion, NothingSeen, Pose, Health]
    started, seen, pose, motion, nothing, lost, health = items
    assert started.board == "desk" and started.unique_id == "000102030405060708090a0b"
    assert (started.width, started.height, started.version) == (320, 240, (0, 1, 0))
    assert (seen.marker_id, seen.x_mm, seen.y_mm, seen.z_mm) == (3, 123.4, -56.7, 2500.0)
    assert (seen.heading_deg, seen.radius_px, seen.margin, seen.flags) == (45.5, 30.0, 200, ())
    assert (seen.sigma_px, seen.sigma_deg) == (0.0, 0.0)
    assert seen.time == START + timedelta(seconds=0.5, milliseconds=-8)
    assert seen.time_s == pytest.approx(0.492)
    assert pose.time == motion.time == seen.time  # of one frame
    assert pose.known and (pose.state, pose.x_mm, pose.y_mm, pose.heading_deg) == (
        "tracking",
        1234.5,
        -50.0,
        90.5,
    )
    assert pose.covariance_mm2 == ((9.0, 6.0), (6.0, 16.0)) and pose.sigma_deg == 0.25
    assert (pose.marker_id, pose.marker_age_s, pose.way_mm, pose.next_deg) == (3, 0.25, 70, 1.0)
    assert (motion.state, motion.x_mm, motion.heading_deg) == ("interpolated", 5.5, 45.0)
    assert not lost.known and lost.state == "lost"
    for name in ("x_mm", "y_mm", "heading_deg", "covariance_mm2", "sigma_deg", "marker_id", "marker_age_s"):
        assert getattr(lost, name) is None
    assert (lost.way_mm, lost.route_position, lost.next_deg) == (None, None, None)
    assert nothing.frame == 2 and nothing.time == START + timedelta(seconds=2, milliseconds=-7)
    assert (health.state, health.faults, health.fault_count) == ("lost", ("camera dark",), 2)
    assert health.rate_hz == 59.9 and health.record.rate_chz == 5990


def test_the_same_of_every_kind_of_log(tmp_path):
    path = write_log(tmp_path / "run")
    with Camera(path) as camera:
        items = list(camera)
    with Camera(tmp_path / "run.mcap") as camera:
        assert list(camera) == items
    csv = (tmp_path / "run.csv").rename(tmp_path / "alone.csv")  # which does not tell the time of day
    markers = [(type(one), one.frame) for one in items if isinstance(one, (Measurement, NothingSeen))]
    with Camera(csv) as camera:
        assert [(type(one), one.frame) for one in camera if one.time is None] == markers
    with Camera(path) as camera:
        assert [pose.known for pose in camera.poses()] == [True, False]
    with Camera(path) as camera:
        assert [seen.marker_id for seen in camera.measurements()] == [3]


def test_an_id_that_is_not_certain_is_none():
    from larics_host.api.items import item_of

    values = dict(zip(Marker._fields, marker_values(1), strict=True))
    flags = m.MARKER_ID_UNCERTAIN | m.MARKER_NO_OFFSET
    record = Marker(**{**values, "id": m.ID_NONE, "flags": flags, "x_mm10": 0, "y_mm10": 0, "z_mm10": 0})
    item = item_of(record, "MARKER", None, 0.0)
    assert (item.marker_id, item.x_mm, item.y_mm, item.z_mm, item.time) == (None,) * 5
    assert item.flags == ("id uncertain", "no offset")


def test_times_of_a_camera_that_begins_anew():
    times = FrameTimes()
    record = Marker(**dict(zip(Marker._fields, marker_values(1), strict=True)))
    assert times.of(record, 10**9) == times.of(record, 10**9 + 3_000_000) == 10**9 - 8_000_000
    assert times.of(record, 10**10) == 10**10 - 8_000_000 == times.get(1)
    assert times.of(info_values, 5) == 5 and times.get(2) is None


def test_importing_the_package_costs_nothing():
    code = "import sys, larics_host; print(sorted({name.split('.')[0] for name in sys.modules}))"
    environment = dict(os.environ, PYTHONPATH="%s:%s" % (ROOT / "shared", ROOT / "host"))
    out = subprocess.run(
        [sys.executable, "-S", "-c", code], env=environment, capture_output=True, text=True
    ).stdout
    assert not {"larics", "numpy", "serial", "cv2", "numba", "mcap", "importlib_metadata"} & set(eval(out))
    assert set(larics_host.__all__) <= set(dir(larics_host))
    for name in larics_host.__all__:
        assert getattr(larics_host, name).__doc__
    with pytest.raises(AttributeError, match="no attribute 'Lidar'"):
        larics_host.Lidar  # noqa: B018


@contextlib.contextmanager
def server(*parts):
    """The address of somebody who sends each of these to one caller after the other, hanging up after each
    but the last."""
    listening = socket.create_server(("127.0.0.1", 0))
    stop = threading.Event()

    def serve():
        with contextlib.suppress(OSError):
            for data in parts:
                connection, _ = listening.accept()
                with connection:
                    connection.sendall(data)
                    if data is parts[-1]:
                        stop.wait()

    threading.Thread(target=serve, daemon=True).start()
    try:
        yield "tcp://127.0.0.1:%d" % listening.getsockname()[1]
    finally:
        stop.set()
        listening.close()


def test_a_live_camera_tells_wall_clock_times():
    with server(wire((m.MARKER, marker_values(1)))) as address:
        before = datetime.now(UTC)
        with Camera(address) as camera:
            item = next(camera)
        after = datetime.now(UTC)
    assert before <= item.time + timedelta(milliseconds=8, microseconds=1) and item.time <= after


def test_a_camera_that_falls_silent_is_an_error(monkeypatch):
    clock = Clock()
    monkeypatch.setattr("larics_host.api.camera.time", clock)
    with server(wire((m.MARKER, marker_values(1)))) as address, Camera(address, timeout_s=1) as camera:
        assert next(camera).frame == 1
        monkeypatch.setattr(clock, "monotonic", itertools.count().__next__)  # a second at each look
        with pytest.raises(CameraError, match="tcp.* for 1 s; it fell silent after 1 message"):
            next(camera)
    told = pytest.raises(CameraError, match="not a byte: is it the address of larics camera")
    with server(b"") as address, Camera(address, timeout_s=1) as camera, told:
        list(camera)


def test_a_line_that_has_gone_is_an_error_or_waited_for(caplog):
    parts = [wire((m.MARKER, marker_values(k))) for k in (1, 2)]
    with server(*parts) as address, Camera(address) as camera:
        assert next(camera).frame == 1
        with pytest.raises(CameraError, match="hung up"):
            next(camera)
    with server(*parts) as address, Camera(address, reconnect=True, timeout_s=None) as camera:
        assert [next(camera).frame for _ in range(2)] == [1, 2]
    assert "hung up; waiting for it" in caplog.text and "is back" in caplog.text


def test_asyncio(tmp_path):
    path = write_log(tmp_path / "run")

    async def collect():
        async with Camera(path) as camera:
            return [item async for item in camera]

    with Camera(path) as camera:
        assert asyncio.run(collect()) == list(camera)


def test_who_is_cancelled_while_waiting_loses_nothing():
    with PtyPair() as cable:

        async def work():
            found = []
            async with Camera(cable.device_b) as camera:
                for k in range(5):
                    waiting = asyncio.ensure_future(anext(camera))
                    await asyncio.sleep(0)
                    waiting.cancel()
                    write_all(cable.device_a, wire((m.MARKER, marker_values(k))))
                    found.append((await anext(camera)).frame)
            return found

        assert asyncio.run(work()) == list(range(5))


def test_a_real_firmware_is_asked_while_it_tells(tmp_path):
    with firmware(tmp_path) as (device, frames), Camera(device) as camera:
        assert next(camera.measurements()).marker_id == 5
        assert camera.get("tracking") is False and camera.settings()["tracking"] is False
        camera.set("margin_min", 20)
        assert camera.get("margin_min") == 20
        picture = camera.picture()
        assert picture.pixels.shape == (144, 160) and picture.time is not None
        shown = {path.name: cv2.imread(str(path), cv2.IMREAD_GRAYSCALE) for path in frames.iterdir()}
        assert any((one == picture.pixels).all() for one in shown.values())
        assert sum(isinstance(item, Measurement) for item, _ in zip(camera, range(20), strict=False)) > 5
        with pytest.raises(CameraError, match="margin_min = 999"):
            camera.set("margin_min", 999)
        with pytest.raises(CameraError, match="there is no setting margins"):
            camera.get("margins")
        with pytest.raises(CameraError, match="is open already"):
            camera.open()


def test_what_nobody_takes_is_dropped_and_counted(monkeypatch, tmp_path):
    from larics_host.api import camera as module

    monkeypatch.setattr(module, "_WAITING_MOST", 3)
    with Camera(write_log(tmp_path / "run")) as camera:
        while camera._poll(0.0):
            pass
        assert camera.dropped == 4 and len(list(camera)) == 3


@pytest.mark.parametrize(
    "source, more, part",
    [
        ("/dev/nothing-here", {}, "no port /dev/nothing-here"),
        ("tcp://127.0.0.1:1", {}, "cannot connect to tcp://127.0.0.1:1"),
        ("tcp://nowhere", {}, "is no address"),
        ("{folder}/odd.jsonl", {}, "line 1 is not from larics log"),
        ("{folder}/empty.bin", {}, "is empty"),
        ("x", {"timeout_s": 0}, "timeout_s is 0"),
        ("x", {"speed": math.nan}, "speed is nan"),
    ],
)
def test_every_error_is_of_one_type(source, more, part, tmp_path):
    (tmp_path / "odd.jsonl").write_text("{}\n")
    (tmp_path / "empty.bin").write_bytes(b"")
    with pytest.raises(CameraError, match=part) as error, Camera(source.format(folder=tmp_path), **more):
        pass
    assert "\n" not in str(error.value)


def test_what_cannot_be_asked(tmp_path):
    camera = Camera(write_log(tmp_path / "run"))
    with pytest.raises(CameraError, match="is not open: use `with Camera"):
        next(camera)
    with camera:
        for ask in (camera.save, camera.picture, camera.restart, lambda: camera.get("map"), camera.settings):
            with pytest.raises(CameraError, match="is a log, which cannot be asked"):
                ask()
    with pytest.raises(CameraError, match="is not open"):
        camera.get("map")


def test_the_lines_of_the_readme_do_what_they_say(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_log(tmp_path / "run")
    part = (ROOT / "README.md").read_text().split("<!-- api:begin -->")[1].split("<!-- api:end -->")[0]
    code = part.split("```python\n")[1].split("```")[0]
    shown = part.split("```text\n")[1].split("```")[0]
    assert len(code.strip().splitlines()) <= 10
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(code, {})
    assert out.getvalue() == shown
    assert json.loads((tmp_path / "run.jsonl").read_text().splitlines()[1])["frame"] == 1
