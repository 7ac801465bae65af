"""`larics ros2`: another process subscribes by DDS and decodes with rosbags what arrives."""

import contextlib
import json
import os
import socket
import subprocess
import sys
import threading
import time

import pytest

from larics.wire import messages as m
from larics_host import cli
from larics_host.ros.definitions import ros_name
from larics_host.ros.type_hash import type_hash
from larics_host.ros.wire_types import wire_structs
from tests.host.test_dual import ROOT
from tests.host.test_log import info_values, larics, marker_values, status_values, wire
from tests.host.test_ros_types import store
from tests.host.test_ros_view import POSE
from tests.host.waiting import PATIENCE_S
from wire_values import message_values

pytest.importorskip("cyclonedds", reason="no wheel of cyclonedds for this computer")

DOMAIN = str(60 + os.getpid() % 150)  # of this test process alone
TOPICS = {
    "/cart/pose": "geometry_msgs/PoseWithCovarianceStamped",
    "/tf": "tf2_msgs/TFMessage",
    "/cart/map": "visualization_msgs/MarkerArray",
    "/cart/sightings": "visualization_msgs/MarkerArray",
    "/diagnostics": "diagnostic_msgs/DiagnosticArray",
    "/cart/wire/marker": "larics_msgs/Marker",
}


@contextlib.contextmanager
def camera():
    """The address of a camera that tells pose and marker until the end, and answers nothing."""
    server = socket.create_server(("127.0.0.1", 0))
    stop = threading.Event()

    def serve():
        with contextlib.suppress(OSError):
            connection, _ = server.accept()
            frame = 0
            while not stop.wait(0.01):
                told = [(m.MARKER, marker_values(frame))]
                told.append((m.POSE, message_values(m.POSE, **{**POSE, "frame": frame})))
                if frame % 10 == 0:
                    told += [(m.INFO, info_values()), (m.STATUS, status_values(state=m.TRACKING))]
                connection.sendall(wire(*told))
                frame += 1

    threading.Thread(target=serve, daemon=True).start()
    try:
        yield "tcp://127.0.0.1:%d" % server.getsockname()[1]
    finally:
        stop.set()
        server.close()


def reading(*topics):
    return subprocess.Popen(
        [sys.executable, str(ROOT / "tests/host/dds_reader.py"), DOMAIN, *topics],
        stdout=subprocess.PIPE,
        text=True,
        env=dict(os.environ, PYTHONPATH="%s:%s:%s" % (ROOT / "shared", ROOT / "host", ROOT)),
    )


def collected(reader, enough):
    """(messages by topic as bytes, publications by DDS topic), once enough(both) is true."""
    messages, found = {}, {}
    end_s = time.monotonic() + PATIENCE_S
    while not enough(messages, found):
        assert time.monotonic() < end_s, (messages.keys(), found.keys())
        line = reader.stdout.readline()
        assert line, "the reader ended"
        told = json.loads(line)
        if "found" in told:
            found[told["found"]] = told
        else:
            messages.setdefault(told["topic"], []).append(bytes.fromhex(told["data"]))
    return messages, found


def test_another_process_gets_every_topic(tmp_path):
    hall = tmp_path / "hall.json"
    assert cli.main(["map", "create", str(hall), "--marker", "3,1000,0,90"]) == 0
    with camera() as address:
        words = ["--domain", DOMAIN, "--namespace", "cart", "--map", str(hall), "--base-frame", "cart"]
        publishing = larics("ros2", "--port", address, *words)
        reader = None
        try:
            title = "publishing /cart/... in domain %s on the loopback interface alone" % DOMAIN
            assert publishing.stdout.readline().startswith(title)
            said = publishing.stdout.readline()
            assert said == "map -> cart comes from here: nobody else may tell it, or odom -> cart\n"
            # the map was told before there was a reader
            reader = reading(*("%s=%s" % pair for pair in TOPICS.items()))
            names = {"rt" + name for name in TOPICS}
            messages, found = collected(
                reader, lambda messages, found: messages.keys() == TOPICS.keys() and names <= found.keys()
            )
        finally:
            publishing.terminate()
            out, err = publishing.communicate(timeout=PATIENCE_S)
            if reader:
                reader.kill()
                reader.communicate()
    assert publishing.returncode == 0, err
    assert "messages received" in out
    assert not err or (err.count("\n") == 1 and "the camera does not answer" in err)
    types = store()
    decoded = {}
    for name, kind in TOPICS.items():
        told = found["rt" + name]
        package, plain = kind.split("/")
        assert told["type"] == "%s::msg::dds_::%s_" % (package, plain)
        assert told["user"] == ["typehash=%s;" % type_hash(kind, wire_structs())]
        data = messages[name][0]
        decoded[name] = types.deserialize_cdr(data, ros_name(kind))
        again = bytes(types.serialize_cdr(decoded[name], ros_name(kind)))
        assert data == again.ljust(len(data), b"\0") and len(data) - len(again) < 4
    pose = decoded["/cart/pose"]
    assert (pose.header.frame_id, pose.pose.pose.position.x) == ("map", 1.2345)
    assert abs(pose.header.stamp.sec - time.time()) < 3600
    (transform,) = decoded["/tf"].transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("map", "cart")
    assert decoded["/cart/map"].markers[2].text == "ID 3 (height ?)"
    assert decoded["/cart/sightings"].markers[2].text == "ID 3"
    assert len(decoded["/diagnostics"].status[0].hardware_id) in (0, 24)  # before and after INFO
    assert decoded["/cart/wire/marker"].id == 3


def test_a_camera_that_falls_silent_is_stale(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = "tcp://127.0.0.1:%d" % server.getsockname()[1]
        publishing = larics("ros2", "--port", address, "--domain", DOMAIN, "--listen")
        reader = reading("/diagnostics=diagnostic_msgs/DiagnosticArray")
        try:
            messages, _ = collected(reader, lambda messages, _: messages)
        finally:
            reader.kill()
            publishing.terminate()
            _, err = publishing.communicate(timeout=PATIENCE_S)
            reader.communicate()
    data, kind = messages["/diagnostics"][0], "diagnostic_msgs/msg/DiagnosticArray"
    (status,) = store().deserialize_cdr(data, kind).status
    assert status.level == 3 and status.message.startswith("no STATUS for ")
    assert publishing.returncode == 2 and "not a byte: is it the address of larics camera" in err


def test_a_log_is_published(tmp_path):
    (tmp_path / "run.bin").write_bytes(wire(*[(m.MARKER, marker_values(k)) for k in range(20)]))
    done = larics(
        "ros2", "--input", str(tmp_path / "run.bin"), "--speed", "1000", "--domain", DOMAIN, "--tf", "none"
    )
    out, err = done.communicate(timeout=PATIENCE_S)
    assert done.returncode == 0 and not err
    assert "20 messages received, 40 messages published" in out  # as they are, and as sightings


@pytest.mark.parametrize(
    "argv, environment, part",
    [
        (
            ["--interface", "nix0"],
            {},
            "DDS does not start on the interface nix0, domain 0: nix0: does not match",
        ),
        (["--network"], {"CYCLONEDDS_URI": "<bad"}, "DDS does not start on the network, domain 0: config: "),
        ([], {"ROS_DOMAIN_ID": "one"}, "ROS_DOMAIN_ID is 'one'"),
        ([], {"ROS_DOMAIN_ID": "233"}, "ROS_DOMAIN_ID 233: a domain is 0 to 232"),
        (["--domain", "-1"], {}, "--domain -1: a domain is 0 to 232"),
        (["--pictures", "5"], {}, "--pictures asks a camera: it needs --port"),
        (["--speed", "0"], {}, "--speed 0: give a number above 0"),
        (["--interface", "lo", "--network"], {}, "not allowed with argument"),
        (["--namespace", "a b"], {}, "namespace 'a b'"),
    ],
)
def test_bad_input_is_one_line(argv, environment, part, tmp_path, monkeypatch, capfd):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    (tmp_path / "run.bin").write_bytes(wire((m.MARKER, marker_values(1))))
    assert cli.main(["ros2", "--input", str(tmp_path / "run.bin"), *argv]) == 2
    err = capfd.readouterr().err
    assert err.startswith("larics: ") and part in err and err.count("\n") == 1


def test_what_holds_nothing_is_told_before_anything_is_published(tmp_path, capfd):
    (tmp_path / "run.bin").write_bytes(b"")
    assert cli.main(["ros2", "--input", str(tmp_path / "run.bin")]) == 2
    out, err = capfd.readouterr()
    assert not out and err.count("\n") == 1 and "is empty" in err
