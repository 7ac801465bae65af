"""`larics monitor`: its state, the terminal, and the page in a real browser before a real firmware."""

import argparse
import contextlib
import http.client
import io
import json
import math
import os
import sys

import cv2
import numpy as np
import pytest
from rich.console import Console

from larics.wire import codec as protocol
from larics.wire import messages as m
from larics_host import cli
from larics_host.commands import monitor
from larics_host.connection.byte_sources import SerialSource
from larics_host.connection.pty_pair import PtyPair
from larics_host.connection.receiver import Receiver
from larics_host.logs.log_source import LogSource
from larics_host.monitor.drawing import Canvas, draw_view
from larics_host.monitor.session import Session
from larics_host.monitor.state import MonitorState
from larics_host.monitor.terminal import render
from larics_host.monitor.web import serve
from tests.host.browser import headless_browser
from tests.host.firmware_process import start_firmware
from tests.host.plain_marker import plain_frame
from tests.host.terminals import shown_in_terminal
from tests.host.test_log import marker_values, status_values, wire
from tests.host.waiting import PATIENCE_S, Clock, wait_until
from wire_values import changed, message_values

# a camera at which a ring of 30 px hangs 1.5 m above the lens
CAMERA = {
    "focal_q8": 300 * 256,
    "ceiling_mm10": 15000,
    "radius_min_px": 25,
    "radius_max_px": 36,
    "baud": 921600,
}
MAP = [[5, 1000, 500, 9000, 0, 0], [3, 3000, 500, 0, 0, 0]]


def pose_values(frame, state=m.TRACKING, x_mm10=10000, y_mm10=5000, heading_cdeg=9000):
    place = {"x_mm10": x_mm10, "y_mm10": y_mm10, "heading_cdeg": heading_cdeg}
    told = {"frame": frame, "age_us": 5000, "marker_age_ms": 5, "state": state, "id": 3, "sigma_cdeg": 7}
    told |= {"sigma_x_mm10": 12, "sigma_y_mm10": 12}
    return message_values(m.POSE, route_position=1, next_cdeg=4500, **told, **place)


def fed(*messages, step_s=0.02, **options):
    """A MonitorState after these messages."""
    state, receiver = MonitorState("test", **options), Receiver()
    for k, message in enumerate(messages):
        for found in receiver.feed(wire(message), k * step_s):
            state.add(found, receiver.counters)
    return state


def text_of(state, ended=None):
    file = io.StringIO()
    Console(width=110, file=file).print(render(state, ended))
    return file.getvalue()


def test_the_state_tells_the_newest_and_remembers_what_was():
    state = fed(
        *[(m.MARKER, marker_values(k, marker_id=3, x_mm10=100 * k)) for k in range(11)],
        (m.MARKER, marker_values(11, m.ID_NONE, 0, m.MARKER_NONE)),
        (m.STATUS, status_values(state=m.LOST, faults=1, last_fault=m.FAULT_STORAGE)),
        (
            m.STATUS,
            status_values(state=m.COASTING, faults=2, last_fault=m.FAULT_DETECT, active_faults=1 << 7),
        ),
    )
    shot = state.snapshot()
    assert (shot["frames"], shot["frame"], shot["state"]) == (12, 11, "COASTING")
    assert shot["markers"] == [] and shot["rate_hz"] == pytest.approx(50, rel=0.01)
    assert len(shot["points"]) == 12 and shot["points"][10][2:] == (100.0, -56.7, 45.5, 3)
    assert shot["points"][11][2:] == (None, None, None, None)
    assert [text for _, text in shot["events"]] == ["LOST", "COASTING", "fault: detect"]
    assert shot["faults"] == ["storage"]
    assert state.snapshot(after=shot["number"])["points"] == []


def test_markers_of_a_frame_come_nearest_first():
    far = changed(m.MARKER, marker_values(4, 2, 30000), count=2)
    near = changed(m.MARKER, marker_values(4, 6, 100), count=2, index=1)
    shot = fed((m.MARKER, far), (m.MARKER, near)).snapshot()
    assert [marker["id"] for marker in shot["markers"]] == [6, 2]
    assert len(shot["points"]) == 1 and shot["points"][0][5] == 6


def test_markers_are_placed_by_the_pose_unless_the_map_has_them():
    values = marker_values(1, marker_id=3, x_mm10=2000)  # 200 mm ahead, 56.7 mm to the right, turned by 45.5
    state = fed((m.MARKER, values), (m.POSE, pose_values(1)))
    ((x_mm, y_mm, heading_deg, sure),) = state.landmarks[3]
    assert (x_mm, y_mm, heading_deg, sure) == (1056.7, 700.0, 135.5, False)
    state = fed((m.MARKER, values), (m.POSE, pose_values(1)), map_rows=[[3, 10, 20, 9000, 0, 0]])
    assert state.landmarks == {3: [(10, 20, 90.0, True)]}


def test_the_terminal_shows_everything():
    text = text_of(MonitorState("port"))
    assert "WAITING" in text and "nothing received yet" in text
    state = fed((m.MARKER, marker_values(1, 3)), (m.STATUS, status_values(rate_chz=6000, gain_cdb=600)))
    text = text_of(state, "the end")
    for part in ("LOST", "ID 3", "x 123.4  y -56.7 mm", "45.50 deg", "200 of 255", "8.0 ms", "60.0 frames/s"):
        assert part in text, text
    assert "from above, forward is up" in text and "ended: the end" in text
    state = fed((m.MARKER, marker_values(1, 3)), (m.POSE, pose_values(1)))
    text = text_of(state)
    assert "TRACKING" in text and "x 1000.0  y 500.0 mm" in text and "route" in text and "map; " in text


def test_what_a_status_told_is_unknown_when_it_stops_while_markers_go_on():
    told = status_values(active_faults=1 << m.FAULT_CAMERA_DARK)
    markers = [(m.MARKER, marker_values(k, 3)) for k in range(1, 6)]
    state = fed((m.STATUS, told), *markers, step_s=1.0)
    assert state.faults() == ["camera dark"] and not any("no STATUS" in text for _, text in state.events)
    state = fed((m.STATUS, told), *markers, (m.MARKER, marker_values(6, 3)), step_s=1.0)
    assert state.status is None and state.faults() == [] and state.snapshot()["status"] is None
    assert "no STATUS for 5 s: faults and rates are unknown" in text_of(state)
    state = fed((m.STATUS, told), *markers * 2, (m.STATUS, told), step_s=1.0)
    assert state.faults() == ["camera dark"]


def test_nothing_stands_when_all_messages_stop():
    told = [
        (m.MARKER, marker_values(1, 3)),
        (m.STATUS, status_values(state=m.TRACKING)),
        (m.POSE, pose_values(1)),
    ]
    state = fed(*told, step_s=1.0)
    state.pass_time(5.0)
    assert state.state == "TRACKING" and state.markers and state.pose["x_mm"] == 1000.0
    for _ in range(2):
        state.pass_time(5.1)
        shot = state.snapshot()
        assert shot["silent"] and shot["state"] is shot["status"] is shot["frame"] is shot["rate_hz"] is None
        assert shot["markers"] == shot["faults"] == [] and set(shot["pose"].values()) == {None}
        said = [text for _, text in shot["events"] if "unknown" in text]
        assert said == ["nothing received for 3 s: state, markers and pose are unknown"]
    text = text_of(state)
    assert "SILENT" in text and "TRACKING  larics" not in text and "x -  y - mm" in text
    receiver = Receiver()
    for found in receiver.feed(wire((m.MARKER, marker_values(2, 3))), 60.0):
        state.add(found, receiver.counters)
    assert state.markers and not state.is_silent and state.state is None


def test_what_stops_while_other_messages_go_on_is_unknown():
    status = (m.STATUS, status_values(state=m.LOST))
    state = fed((m.MARKER, marker_values(1, 3)), *[status] * 6, step_s=1.0)
    assert state.markers == [] and state.frame is None and state.state == "LOST"
    assert any(text == "no MARKER for 5 s: what is in sight is unknown" for _, text in state.events)
    frames = [(m.MARKER, marker_values(1, 3)), status, status, (m.MARKER, marker_values(2, 3))]
    for seconds, is_known in ((9, True), (10, False)):  # a frame in three seconds
        assert bool(fed(*frames, *[status] * seconds, step_s=1.0).markers) is is_known
    markers = [(m.MARKER, marker_values(k, 3)) for k in range(2, 8)]
    state = fed((m.MARKER, marker_values(1, 3)), (m.POSE, pose_values(1)), *markers[:5], step_s=1.0)
    assert state.pose["x_mm"] == 1000.0 and state.state == "TRACKING"
    state = fed((m.MARKER, marker_values(1, 3)), (m.POSE, pose_values(1)), *markers, step_s=1.0)
    assert state.pose["x_mm"] is None and state.state is None
    assert any(text == "no POSE for 5 s: the pose is unknown" for _, text in state.events)


@pytest.mark.parametrize(
    "width, height", [(110, 50), (100, 24), (80, 24), (60, 50), (40, 40), (40, 24), (30, 60)]
)
def test_it_fits_a_small_terminal(width, height):
    pose = pose_values(1)
    state = fed((m.MARKER, marker_values(1, 3)), (m.STATUS, status_values(rate_chz=6000)), (m.POSE, pose))
    for second in range(9):
        state.events.append((second, "event"))
    file = io.StringIO()
    Console(width=width, height=height, file=file).print(render(state, "the end", (width, height)))
    lines = file.getvalue().splitlines()
    text = " ".join(file.getvalue().replace("│", " ").split())
    assert max(map(len, lines)) <= width and (len(lines) <= height or (width, height) == (40, 24))
    for part in (
        "TRACKING",
        "ID 3",
        "x 123.4 y -56.7 mm",
        "200 of 255",
        "x 1000.0 y 500.0 mm",
        "60.0 frames/s",
    ):
        assert part in text, text
    assert "ended: the end" in text and "8.00 s event" in text
    assert ("map; " in text) == (height > 24 or width > 40)


def test_the_drawing_has_things_where_they_are():
    canvas = Canvas(10, 5, (0.0, 0.0), 10.0)
    canvas.point(-95.0, 95.0)
    canvas.text(0.0, 0.0, "X")
    canvas.point(1e6, 0.0)  # outside
    lines = canvas.lines()
    assert lines[0][0] == chr(0x2801) and lines[2][5] == "X" and len(lines) == 5
    ahead_left = marker_values(1, 4, 8000)
    ahead_left[7] = 9000
    _, lines = draw_view(fed((m.MARKER, ahead_left)), 40, 14)
    row = next(k for k, line in enumerate(lines) if "4" in line)
    assert row < 6 and lines[row].index("4") < 17


@contextlib.contextmanager
def firmware(folder, marker_id=5, mirrored=False):
    """The serial port of a firmware that drives under a marker for ever."""
    frames = folder / "frames"
    frames.mkdir()
    for k in range(40):
        frame = plain_frame(marker_id, 80.0, 56.0 + 0.8 * k, 90.0, size=(160, 144))
        data = (frame[:, ::-1] if mirrored else frame).tobytes()
        (frames / ("f%02d.pgm" % k)).write_bytes(b"P5\n160 144\n255\n" + data)
    settings = folder / "settings.json"
    # without tracking each frame stands alone, so that any of them can be compared
    settings.write_text(json.dumps(dict(CAMERA, map=MAP, tracking=False, mirrored=mirrored)))
    with PtyPair() as cable:
        options = ("--settings", str(settings), "--fps", "40", "--rounds", "0")
        process = start_firmware(frames, cable.device_a, *options)
        try:
            yield cable.device_b, frames
        finally:
            process.kill()
            process.communicate()


@contextlib.contextmanager
def monitored(source, rows=()):
    """(session, server) of a source, both running."""
    session = Session(source, MonitorState(source.name, rows))
    server = serve(session, 0)
    session.start()
    try:
        yield session, server
    finally:
        session.stop()
        server.shutdown()
        server.server_close()


def test_the_page_in_a_browser_before_a_real_firmware(tmp_path):
    with (
        headless_browser() as browser,
        firmware(tmp_path) as (device, frames),
        monitored(SerialSource(device)) as (session, server),
    ):
        browser.get("http://127.0.0.1:%d/" % server.server_port)

        def text(name):
            return browser.execute_script("return document.getElementById(arguments[0])?.textContent", name)

        def number(name):
            """What stands there, not a number while the camera stands still and nothing is known."""
            try:
                return float(text(name))
            except ValueError:
                return math.nan

        wait_until(lambda: text("state") == "TRACKING" and text("t-ID") == "5")
        seen = set()
        wait_until(lambda: seen.add(number("t-offset-x")) or max(seen) - min(seen) > 5)
        wait_until(lambda: abs(number("t-offset-y")) < 200)
        assert "desk, 160×144 px" in text("board")
        wait_until(lambda: 1 < number("t-frame-rate") < 41)
        wait_until(lambda: "processed" in text("counters"))
        wait_until(lambda: browser.execute_script("return trail.length") > 20)
        # asked of the camera, which may answer after all that
        wait_until(lambda: browser.execute_script("return now.landmarks.map(l => l[0])") == [5, 3])

        browser.find_element("id", "fetch").click()
        wait_until(lambda: text("rawname").startswith("frame "))
        assert browser.execute_script("return document.getElementById('raw').naturalWidth") == 160 * 5
        # the picture is that very frame, with the marker's drawing in green on it
        with session.lock:
            number, png = session.raw.number, session.raw.png
        picture = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
        frame = cv2.imread(str(frames / ("f%02d.pgm" % (number % 40))), cv2.IMREAD_GRAYSCALE)
        enlarged = cv2.resize(frame, None, fx=5, fy=5, interpolation=cv2.INTER_NEAREST)
        same = (picture == enlarged[..., None]).all(axis=2)
        green = picture[..., 1].astype(int) - picture[..., 2] > 60
        assert same.mean() > 0.75 and green.sum() > 1000

        def inked(canvas):
            script = """const c = document.getElementById(arguments[0]), t = new Set();
                const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
                for (let k = 0; k < d.length; k += 4)
                    if (d[k + 3] > 200) t.add(d[k] << 16 | d[k + 1] << 8 | d[k + 2]);
                return [...t]"""
            return {"%06x" % colour for colour in browser.execute_script(script, canvas)}

        wait_until(lambda: "0b5fa5" in inked("map") and {"0b5fa5", "c8660d", "23834b"} <= inked("strip"))
        assert not [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"]
        folder = os.environ.get("LARICS_SCREENSHOTS")
        if folder:
            browser.save_screenshot(os.path.join(folder, "monitor.png"))


def test_the_picture_of_a_mirrored_sensor_shows_the_ids_that_the_camera_sends(tmp_path):
    with (
        firmware(tmp_path, marker_id=4, mirrored=True) as (device, _),
        monitored(SerialSource(device)) as (session, server),
    ):
        wait_until(lambda: session.state.markers)
        assert json.loads(request(server, "/events").readline().removeprefix(b"data: "))["raw"]["ids"] == []
        assert session.fetch_raw()
        wait_until(lambda: session.raw.version)  # the kernels may have to be compiled
        with session.lock:
            assert session.raw.error is None and session.raw.ids == [4]
            assert {marker["id"] for marker in session.state.markers} == {4}


@pytest.fixture
def log(tmp_path):
    messages = [(m.MARKER, marker_values(k, 3)) for k in range(5)]
    (tmp_path / "run.bin").write_bytes(wire(*messages, (m.STATUS, status_values(state=m.TRACKING))))
    return tmp_path / "run.bin"


def request(server, path, method="GET", **headers):
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=PATIENCE_S)
    connection.request(method, path, headers=headers)
    return connection.getresponse()


def test_the_server_is_for_this_computer_only(log):
    with monitored(LogSource(log)) as (session, server):
        assert server.server_address[0] == "127.0.0.1"
        page = request(server, "/")
        assert page.status == 200 and b"LARICS monitor" in page.read()
        assert b"https://" not in request(server, "/").read()
        assert request(server, "/", Host="evil.example:80").status == 403
        assert request(server, "/frame", "POST", Origin="http://evil.example").status == 403
        assert request(server, "/frame", "POST").status == 409  # a log
        assert request(server, "/frame.png").status == 404
        assert request(server, "/../../etc/passwd").status == 404
        wait_until(lambda: session.ended)
        events = request(server, "/events")
        snapshot = json.loads(events.readline().removeprefix(b"data: "))
        assert snapshot["frames"] == 5 and snapshot["state"] == "TRACKING" and not snapshot["live"]


def test_a_log_without_a_terminal(log, capsys, monkeypatch):
    assert cli.main(["monitor", "--input", str(log), "--speed", "0"]) == 0
    printed = capsys.readouterr().out
    assert "ID 3" in printed and "6 messages, 0 lost" in printed and "the log is at its end" in printed
    monkeypatch.setenv("COLUMNS", "40")
    assert cli.main(["monitor", "--input", str(log), "--speed", "0"]) == 0
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 40


def test_a_live_port_without_a_terminal(tmp_path, monkeypatch, capsys):
    sessions = []

    class Seen(Session):
        def __init__(self, *arguments):
            super().__init__(*arguments)
            sessions.append(self)

    class UntilAllCame(Clock):
        """The seconds are over when what the view is to show has come, however slow the camera is."""

        def sleep(self, seconds):
            wait_until(lambda: sessions[0].state.state == "TRACKING" and sessions[0].state.markers)
            wait_until(lambda: sessions[0].state.landmarks)
            self.now_s += 2

    monkeypatch.setattr("larics_host.monitor.session.Session", Seen)
    monkeypatch.setattr(monitor, "time", UntilAllCame())
    with firmware(tmp_path) as (device, _):
        assert cli.main(["monitor", "--port", device, "--seconds", "6"]) == 0
    printed = capsys.readouterr().out
    assert "ID 5" in printed and "TRACKING" in printed and "map; " in printed


def test_what_a_terminal_shows_last_is_the_end(monkeypatch):
    class Ending:
        lock, state, told = contextlib.nullcontext(), MonitorState("x"), 0

        @property
        def ended(self):
            self.told += 1
            return "it is over" if self.told > 1 else None  # while something is shown

    shown = io.StringIO()
    monkeypatch.setattr(
        "larics_host.consoles.Console", lambda: Console(file=shown, force_terminal=True, width=100, height=40)
    )
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monitor._show(argparse.Namespace(seconds=None, web=None), Ending(), lambda: False)
    assert "ended: it is over" in shown.getvalue()


def test_in_a_terminal(log):
    """The live display itself, on a pseudo-terminal."""
    shown = shown_in_terminal("monitor", "--input", log, "--speed", "0")
    assert b"ID 3" in shown and b"\x1b[" in shown


def test_a_port_that_vanishes_is_told(capsys):
    with PtyPair() as cable:
        session = Session(SerialSource(cable.device_b), MonitorState("x"))
        session.start()
        cable.unplug()
        wait_until(lambda: session.ended)
        session.stop()
    assert session.failed and "vanished" in session.ended
    assert not session.fetch_raw()


@pytest.mark.parametrize(
    "argv, part",
    [
        ([], "--port --input"),
        (["--port", "/dev/no-port"], "no port /dev/no-port"),
        (["--input", "none.bin"], "cannot read none.bin"),
        (["--input", "run.bin", "--speed", "-1"], "--speed -1"),
        (["--input", "run.bin", "--seconds", "0"], "--seconds 0"),
        (["--input", "run.bin", "--web", "70000"], "--web 70000"),
        (["--input", "run.bin", "--map", "none.json"], "cannot read none.json"),
    ],
)
def test_bad_input_is_one_line(argv, part, log, monkeypatch, capsys):
    monkeypatch.chdir(log.parent)
    assert cli.main(["monitor", *argv]) == 2
    err = capsys.readouterr().err
    assert err.startswith("larics: ") and part in err and err.count("\n") == 1


def test_a_web_port_in_use_is_told(log, capsys):
    with monitored(LogSource(log)) as (_, server):
        port = server.server_port
        assert cli.main(["monitor", "--input", str(log), "--web", str(port)]) == 2
    assert "port %d of this computer cannot be used" % port in capsys.readouterr().err


def test_types_of_messages_are_all_taken():
    """Whatever a camera sends, the monitor goes on."""
    state, receiver = MonitorState("x"), Receiver()
    for _, number, _, fields in protocol.MESSAGES:
        values = [bytes(int(code[:-1])) if code.endswith("s") else low for _, code, _, low, _, _ in fields]
        for message in receiver.feed(wire((number, values)), 1.0):
            state.add(message, receiver.counters)
    json.dumps(state.snapshot())
    assert text_of(state)
