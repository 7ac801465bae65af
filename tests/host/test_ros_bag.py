"""Bags: read by rosbags, from logs and recordings, with all that belongs into them."""

import json
import socket
import threading

import cv2
import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader

from larics.wire import messages as m
from larics_host import cli
from larics_host.connection.asker import Asker
from larics_host.connection.receiver import Receiver, message_of
from larics_host.logs.log_reader import read_pieces
from larics_host.logs.log_records import read_objects
from larics_host.ros.definitions import STRUCTS, ros_name
from larics_host.ros.type_hash import type_hash
from tests.host.test_dual import ROOT
from tests.host.test_log import info_values, larics, marker_values, status_values, wire
from tests.host.test_monitor import firmware
from tests.host.test_ros_types import store
from tests.host.test_ros_view import POSE, raw_messages
from tests.host.waiting import PATIENCE_S, wait_until
from wire_values import message_values

FRAME = ROOT / "tests/frames/sunny_r30_1000_0.pgm"


def recorded(count=40):
    """The wire of a drive with pose and odometry, and one raw frame."""
    found = [(m.INFO, info_values())]
    for k in range(count):
        found.append((m.MARKER, marker_values(k)))
        found.append((m.POSE, message_values(m.POSE, **{**POSE, "frame": k})))
        found.append((m.MOTION, message_values(m.MOTION, frame=k, state=m.MOTION_INTERPOLATED)))
    found.append((m.STATUS, status_values(state=m.TRACKING)))
    frame = cv2.imread(str(FRAME), cv2.IMREAD_GRAYSCALE)
    found += [(number, message_values(number, **fields)) for number, fields in raw_messages(frame, 3)]
    return wire(*found, (m.MARKER, marker_values(count)))


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """PREFIX of a log with PREFIX.mcap and the folder PREFIX."""
    folder = tmp_path_factory.mktemp("bag")
    (folder / "came.bin").write_bytes(recorded())
    assert cli.main(["map", "create", str(folder / "hall.json"), "--marker", "3,0,0,0"]) == 0
    words = [
        "--input",
        folder / "came.bin",
        "-o",
        folder / "run",
        "--mcap",
        "--bag",
        "--map",
        folder / "hall.json",
    ]
    assert cli.main(["log", *map(str, words)]) == 0
    return folder / "run"


def read(path):
    """{topic: [(time, message)]} by rosbags, each message written again byte for byte."""
    types, found = store(), {}
    with Reader(path) as reader:
        for connection, time_ns, data in reader.messages():
            message = types.deserialize_cdr(data, connection.msgtype)
            assert bytes(types.serialize_cdr(message, connection.msgtype)) == bytes(data)
            assert connection.digest in ("", types.hash_rihs01(connection.msgtype))
            found.setdefault(connection.topic, []).append((time_ns, message))
        assert reader.message_count == sum(map(len, found.values()))
    return found


def test_a_folder_and_a_file_are_read_by_rosbags(bag):
    found = read(bag)
    counts = {topic: len(messages) for topic, messages in found.items()}
    assert {topic: counts[topic] for topic in counts if "/wire/" not in topic} == {
        "/larics/map": 1,
        "/larics/pose": 40,
        "/tf": 80,
        "/larics/sightings": 41,
        "/diagnostics": 1,
        "/larics/image/compressed": 1,
        "/larics/annotations": 1,
    }
    wires = {topic: counts[topic] for topic in counts if "/wire/" in topic and "raw" not in topic}
    names = {"info": 1, "marker": 41, "pose": 40, "motion": 40, "status": 1}
    assert wires == {"/larics/wire/" + name: count for name, count in names.items()}
    again = read(bag.with_suffix(".mcap"))
    assert {topic: len(messages) for topic, messages in again.items()} == counts
    picture, drawn = found["/larics/image/compressed"][0][1], found["/larics/annotations"][0][1]
    assert picture.header.stamp == drawn.timestamp == found["/larics/pose"][3][1].header.stamp
    one, other = (message.transforms[0] for _, message in found["/tf"][:2])
    assert (one.child_frame_id, other.child_frame_id) == ("base_link", "odom")


def test_a_bag_is_as_rosbag2_writes_it(bag):
    import yaml

    information = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert information["relative_file_paths"] == ["run_0.mcap"]
    assert [one["path"] for one in information["files"]] == ["run_0.mcap"]
    assert information["version"] == 8 and information["storage_identifier"] == "mcap"
    with open(bag / "run_0.mcap", "rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert reader.get_header().profile == "ros2"
        (metadata,) = reader.iter_metadata()
        assert metadata.name == "rosbag2"
        assert yaml.safe_load(metadata.metadata["serialized_metadata"]) == information
    assert len(summary.chunk_indexes) > 2
    assert {chunk.compression for chunk in summary.chunk_indexes} == {"zstd"}
    assert sorted(chunk.uncompressed_size for chunk in summary.chunk_indexes)[-2] < 80000  # but the picture's
    assert summary.chunk_indexes[0].message_index_offsets  # older readers look there alone
    topics = {one["topic_metadata"]["name"]: one for one in information["topics_with_message_count"]}
    for channel in summary.channels.values():
        schema, told = summary.schemas[channel.schema_id], topics[channel.topic]["topic_metadata"]
        assert (
            channel.message_encoding == "cdr" and schema.encoding == "ros2msg" and schema.name == told["type"]
        )
        assert channel.metadata["offered_qos_profiles"] == told["offered_qos_profiles"]
        assert channel.metadata["topic_type_hash"] == told["type_description_hash"]
        (qos,) = yaml.safe_load(told["offered_qos_profiles"])
        latched = channel.topic in ("/larics/map", "/tf_static")
        assert (qos["durability"], qos["reliability"], qos["history"]) == (1 if latched else 2, 1, 1)
        assert topics[channel.topic]["message_count"] == summary.statistics.channel_message_counts[channel.id]
    assert topics["/larics/pose"]["topic_metadata"]["type_description_hash"] == type_hash(
        "geometry_msgs/PoseWithCovarianceStamped", STRUCTS
    )


def test_a_log_becomes_the_same_bag_once_more(bag, tmp_path, capsys):
    for suffix in (".jsonl", ".mcap"):
        out = tmp_path / suffix[1:]
        assert cli.main(["log", "--convert", str(bag.with_suffix(suffix)), "-o", str(out), "--mcap"]) == 0
        assert list(read_pieces(out.with_suffix(".mcap"))) == list(read_pieces(bag.with_suffix(".mcap")))
    err = capsys.readouterr().err
    assert "run.jsonl does not tell the time of day: the bag begins now" in err and "run.mcap" not in err
    first, again = read(bag.with_suffix(".mcap")), read(tmp_path / "mcap.mcap")
    assert [time_ns for time_ns, _ in first["/larics/pose"]] == [
        time_ns for time_ns, _ in again["/larics/pose"]
    ]


def test_times_of_a_log_are_kept(tmp_path):
    lines = []
    for k, piece in enumerate([{"frame": 1}, {"frame": 2}]):
        told = {"time_s": 1.5 + k, "time": "2026-03-01T12:00:0%d.250000Z" % (1 + k), "message": "MARKER"}
        fields = next(read_objects_of(wire((m.MARKER, marker_values(piece["frame"]))), tmp_path))
        lines.append(json.dumps({**fields, **told}))
    (tmp_path / "run.jsonl").write_text("\n".join(lines) + "\n")
    assert (
        cli.main(["log", "--convert", str(tmp_path / "run.jsonl"), "-o", str(tmp_path / "out"), "--bag"]) == 0
    )
    times = [time_ns for time_ns, _ in read(tmp_path / "out")["/larics/wire/marker"]]
    assert times == [1772366401_250_000_000, 1772366402_250_000_000]
    assert (tmp_path / "out.jsonl").read_text() == (tmp_path / "run.jsonl").read_text()


def read_objects_of(data, folder):
    (folder / "some.bin").write_bytes(data)
    assert cli.main(["log", "--input", str(folder / "some.bin"), "-o", str(folder / "some"), "--force"]) == 0
    return read_objects(folder / "some.jsonl")


def test_bytes_without_times_take_as_long_as_on_their_line(tmp_path, capsys):
    one = wire((m.MARKER, marker_values(1)))
    (tmp_path / "came.bin").write_bytes(one * 5)
    words = ["--convert", str(tmp_path / "came.bin"), "--baud", "9600", "-o", str(tmp_path / "out"), "--bag"]
    assert cli.main(["log", *words]) == 0
    assert "does not tell the time of day" in capsys.readouterr().err
    times = [record["time_s"] for record in read_objects(tmp_path / "out.jsonl")]
    assert times == pytest.approx([(k + 1) * len(one) * 10 / 9600 for k in range(5)], abs=1e-6)


def test_what_is_converted_is_never_overwritten(tmp_path, capsys):
    (tmp_path / "came.bin").write_bytes(wire((m.MARKER, marker_values(1))))
    words = ["--convert", str(tmp_path / "came.bin"), "-o", str(tmp_path / "out"), "--bag"]
    assert cli.main(["log", *words]) == 0
    whole = (tmp_path / "out.jsonl").read_bytes()
    same = ["log", "--convert", str(tmp_path / "out.jsonl"), "-o", str(tmp_path / "out"), "--force"]
    assert cli.main(same) == 2
    assert "out.jsonl, which is read: choose another -o" in capsys.readouterr().err
    assert (tmp_path / "out.jsonl").read_bytes() == whole
    metadata = tmp_path / "out" / "metadata.yaml"
    before = metadata.read_text()
    (tmp_path / "came.bin").write_bytes(b"")
    assert cli.main(["log", *words, "--force"]) == 2
    assert metadata.read_text() == before  # what cannot be read replaces nothing


def test_a_recording_becomes_a_bag_with_its_pictures(tmp_path, capsys):
    folder = tmp_path / "seen"
    folder.mkdir()
    (tmp_path / "came.bin").write_bytes(wire(*[(m.MARKER, marker_values(k)) for k in range(5)]))
    assert cli.main(["log", "--input", str(tmp_path / "came.bin"), "-o", str(folder / "messages")]) == 0
    for number in (2, 4, 77):
        (folder / ("frame_%06d.pgm" % number)).write_bytes(FRAME.read_bytes())
    (folder / "settings.json").write_text('{"version": 1, "camera_x_mm10": 500, "width": 360, "height": 296}')
    assert cli.main(["log", "--convert", str(folder), "-o", str(tmp_path / "out"), "--bag"]) == 0
    assert "1 picture of which the log says nothing left out" in capsys.readouterr().err
    found = read(tmp_path / "out")
    markers = [message.stamp for _, message in found["/larics/wire/marker"]]
    assert [message.header.stamp for _, message in found["/larics/image/compressed"]] == [
        markers[2],
        markers[4],
    ]
    assert len(found["/larics/annotations"]) == 2 and found["/larics/annotations"][0][1].circles


def test_a_real_firmware_is_asked_for_settings_and_pictures(tmp_path):
    with firmware(tmp_path) as (device, _):
        logging = larics("log", "--port", device, "-o", str(tmp_path / "run"), "--bag", "--pictures", "0.1")
        try:
            wait_until(lambda: has_two_pictures(tmp_path / "run.jsonl") or logging.poll() is not None)
        finally:
            logging.terminate()
            said = logging.communicate(timeout=PATIENCE_S)
    assert logging.returncode == 0, said
    found = read(tmp_path / "run")
    assert found["/larics/image/compressed"] and found["/larics/map"] and found["/tf_static"]


def has_two_pictures(path):
    """Whether the log has an ACK, and after it two headers of raw frames."""
    text = path.read_text() if path.exists() else ""
    return text.partition("ACK")[2].count("RAW_HEADER") >= 2


class Line:
    """A camera that answers as it is told: takes questions, gives messages."""

    def __init__(self):
        self.questions = []
        self._receiver = Receiver()

    def write(self, data):
        self.questions += [(one.name, one.fields) for one in self._receiver.feed(data, 0.0)]


def test_questions_are_repeated_and_given_up():
    line, silent = Line(), []
    asker = Asker(line.write, ["map"], 5.0, lambda: silent.append(True))
    for step in range(200):
        asker.step(0.1 * step)
    names = [name for name, _ in line.questions]
    assert names[:6] == ["GET_INFO"] * 6 and len({fields.token for _, fields in line.questions[:6]}) == 1
    assert silent == [True] and "GET_SETTING" not in names
    assert "GET_RAW" in names[6:]  # a camera that wakes up later is heard


def test_chunks_that_were_lost_are_asked_for_again():
    line = Line()
    asker = Asker(line.write, [], 1000.0)
    sequence = iter(range(10000))

    def answer(number, **fields):
        asker.note(message_of(number, next(sequence), message_values(number, **fields), 0.0))

    asker.step(0.0)
    answer(m.ACK, token=line.questions[-1][1].token, command=m.GET_INFO)
    asker.step(0.1)
    token = line.questions[-1][1].token
    frame = {"width": 16, "height": 32, "columns": 16, "rows": 32}
    answer(m.RAW_HEADER, token=token, **frame)
    answer(m.ACK, token=token, command=m.GET_RAW)
    for chunk in (0, 1, 4, 7):
        answer(m.RAW_CHUNK, token=token, first=64 * chunk, count=64, coding=m.RAW_PLAIN)
    asker.step(1.0)
    assert line.questions[-1][0] == "GET_RAW"
    asker.step(2.5)
    name, fields = line.questions[-1]
    assert (name, fields.transfer, fields.first, fields.count) == ("GET_RAW_AGAIN", token, 128, 128)
    answer(m.ACK, token=fields.token, command=m.GET_RAW_AGAIN)
    for chunk in (2, 3, 5, 6):
        answer(m.RAW_CHUNK, token=token, first=64 * chunk, count=64, coding=m.RAW_PLAIN)
    asker.step(900.0)
    count = len(line.questions)
    asker.step(1002.6)
    assert count == len(line.questions) - 1 and line.questions[-1][0] == "GET_RAW"
    answer(m.STATUS, boot=5)
    answer(m.STATUS, boot=6)  # it has begun anew
    asker.step(1002.7)
    assert line.questions[-1][0] == "GET_INFO"


def test_a_log_from_a_tcp_address(tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            connection, _ = server.accept()
            with connection:
                connection.sendall(wire(*[(m.MARKER, marker_values(k)) for k in range(30)]))

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        name = "tcp://127.0.0.1:%d" % server.getsockname()[1]
        logging = larics("log", "--port", name, "-o", str(tmp_path / "run"))
        _, err = logging.communicate(timeout=PATIENCE_S)
    assert logging.returncode == 2 and "%s hung up; 30 messages received" % name in err
    assert len(list(read_pieces(tmp_path / "run.jsonl"))) == 30


@pytest.mark.parametrize(
    "argv, part",
    [
        (["--port", "tcp://here", "-o", "x"], "tcp://here is no address: write tcp://HOST:PORT"),
        (
            ["--port", "tcp://127.0.0.1:1", "-o", "x"],
            "cannot connect to tcp://127.0.0.1:1: Connection refused",
        ),
        (["--convert", "none.jsonl", "-o", "x", "--bag"], "cannot read none.jsonl"),
        (["--convert", "folder", "-o", "x", "--bag"], "cannot read folder/messages.jsonl"),
        (["--convert", "run.bin", "-o", "x", "--raw"], "with --convert none do"),
        (["--convert", "run.bin", "-o", "-", "--bag"], "--bag need the name of a file"),
        (["--input", "run.bin", "-o", "x", "--pictures", "3"], "--pictures asks a camera: it needs --port"),
        (["--port", "x", "-o", "x", "--pictures", "0"], "--pictures 0: give a number above 0"),
        (["--input", "run.bin", "-o", "x", "--bag", "--namespace", "7"], "namespace '7'"),
        (["--input", "run.bin", "-o", "x", "--bag", "--base-frame", "map"], "must differ"),
        (["--input", "run.bin", "-o", "x", "--bag", "--tf-ahead", "nan"], "--tf-ahead nan: give 0 to 10 s"),
        (["--input", "run.bin", "-o", "x", "--bag", "--map", "none.json"], "cannot read none.json"),
        (["--input", "run.bin", "-o", "x", "--bag", "--settings", "run.bin"], "run.bin"),
        (["--input", "run.bin", "-o", "folder", "--bag"], "folder exists: choose another name, or --force"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(argv, part, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.bin").write_bytes(wire((m.MARKER, marker_values(1))))
    (tmp_path / "folder").mkdir()
    assert cli.main(["log", *argv]) == 2
    err = capsys.readouterr().err
    assert err.startswith("larics: ") and part in err and err.count("\n") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "run.bin"]


def test_names_of_types_are_those_of_ros():
    assert ros_name("geometry_msgs/Pose") == "geometry_msgs/msg/Pose"
