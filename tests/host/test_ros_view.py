"""What of the camera's messages becomes which topic: values, units, frames, times, unknowns."""

import math
import random

import cv2
import numpy as np
import pytest

from larics import settings as setting_rules
from larics.locate.camera_model import Camera
from larics.wire import messages as m
from larics_host.connection.receiver import message_of
from larics_host.errors import begin_run
from larics_host.ros import frames
from larics_host.ros.options import Options
from larics_host.ros.topics import BASE, NONE, ODOM, TREE, Names, qos_of
from larics_host.ros.view import View
from larics_host.truth import by_frame, read_truth
from tests.host.test_dual import ROOT
from tests.host.test_raw_frame import transfer
from wire_values import message_values

T0_NS = 1_700_000_000_123_456_789
PLACE = {"x_mm10": 12345, "y_mm10": -500, "heading_cdeg": 9000}
SIGMAS = {"sigma_x_mm10": 30, "sigma_y_mm10": 40, "correlation_q14": 8192, "sigma_cdeg": 100}
POSE = {"state": m.TRACKING, "age_us": 8000, **PLACE, **SIGMAS}


class Feed:
    """A View, fed with messages 10 ms apart."""

    def __init__(self, options=None):
        self.view = View(options)
        self.count = 0

    def __call__(self, number, **given):
        """{topic without namespace: [Output]} of one message."""
        message = message_of(number, self.count, message_values(number, **given), self.count / 100)
        found = {}
        for output in self.view.messages(message, T0_NS + self.count * 10_000_000):
            found.setdefault(output.topic.replace("/larics/", ""), []).append(output)
        self.count += 1
        return found

    def setting(self, name, value):
        """The SETTING messages of a value, of which the last one tells."""
        field = setting_rules.field(name)
        numbers = field.numbers(value)
        for first in range(0, max(1, len(numbers)), 8):
            part = numbers[first : first + 8]
            told = {"value%d" % k: number for k, number in enumerate(part)}
            found = self(m.SETTING, key=field.key, first=first, count=len(numbers), **told)
        return found


def only(outputs):
    (output,) = outputs
    return output.value


def test_a_pose_in_metres_and_radians_at_the_time_of_the_exposure():
    output = Feed()(m.POSE, **POSE)["pose"][0]
    assert output.stamp_ns == T0_NS - 8_000_000
    value = output.value
    assert value["header"]["frame_id"] == "map"
    assert value["header"]["stamp"] == {"sec": 1_700_000_000, "nanosec": 115_456_789}
    pose = value["pose"]["pose"]
    assert pose["position"] == {"x": 1.2345, "y": -0.05}
    assert pose["orientation"] == pytest.approx({"z": math.sqrt(0.5), "w": math.sqrt(0.5)})
    matrix = np.array(value["pose"]["covariance"]).reshape(6, 6)
    assert (matrix == matrix.T).all()
    assert matrix[:2, :2] == pytest.approx(np.array([[9e-6, 6e-6], [6e-6, 16e-6]]))
    assert matrix[5, 5] == pytest.approx(math.radians(1) ** 2)
    assert [matrix[k, k] for k in (2, 3, 4)] == [1e6] * 3  # not measured on a plane


def test_what_is_not_known_of_a_pose_is_not_zero():
    unknown = dict.fromkeys(("sigma_x_mm10", "sigma_y_mm10", "sigma_cdeg"), m.SIGMA_UNKNOWN)
    matrix = only(Feed()(m.POSE, **{**POSE, **unknown, "correlation_q14": 0})["pose"])["pose"]["covariance"]
    assert [matrix[7 * k] for k in range(6)] == [1e6] * 6 and sum(matrix) == 6e6
    lost = Feed()(m.POSE, state=m.LOST, x_mm10=m.PLACE_UNKNOWN, y_mm10=m.PLACE_UNKNOWN, heading_cdeg=36000)
    assert set(lost) == {"wire/pose"}
    assert math.isnan(only(lost["wire/pose"])["x_mm10"])


def test_all_of_one_frame_has_one_time():
    feed = Feed(Options(tf=TREE))
    marker = feed(m.MARKER, frame=7, age_us=5000, count=1, id=3)["wire/marker"][0]
    pose = feed(m.POSE, **{**POSE, "frame": 7})["pose"][0]
    motion = feed(m.MOTION, frame=7, state=m.MOTION_INTERPOLATED)
    assert marker.stamp_ns == pose.stamp_ns == motion["wire/motion"][0].stamp_ns == T0_NS - 5_000_000
    assert {output.stamp_ns for output in motion["/tf"]} == {T0_NS - 5_000_000}
    assert feed(m.POSE, **{**POSE, "frame": 8})["pose"][0].stamp_ns == T0_NS + 30_000_000 - 8_000_000


def told(found):
    """[(parent, child, x, y, angle)] of the transforms that a message gave."""
    result = []
    for output in found.get("/tf", ()):
        (one,) = output.value["transforms"]
        place, turn = one["transform"]["translation"], one["transform"]["rotation"]
        angle = 2 * math.atan2(turn["z"], turn["w"])
        result.append((one["header"]["frame_id"], one["child_frame_id"], place["x"], place["y"], angle))
    return result


def drive(feed, count, odometry):
    """All transforms of a drive in which POSE comes before the MOTION of its frame."""
    found = []
    for frame in range(count):
        found += told(feed(m.POSE, **{**POSE, "frame": frame, "x_mm10": 10000 * frame}))
        if odometry:
            state = {"frame": frame, "state": m.MOTION_INTERPOLATED, "heading_cdeg": 4500}
            found += told(feed(m.MOTION, **state, x_mm10=10000 * frame, y_mm10=777))
    return found


@pytest.mark.parametrize(
    "mode, with_odometry, odometry, wanted",
    [
        (None, TREE, False, {("map", "base_link")}),
        (None, TREE, True, {("map", "odom"), ("odom", "base_link")}),
        (None, ODOM, True, {("map", "odom")}),
        (BASE, TREE, True, {("map", "base_link")}),
        (ODOM, TREE, True, {("map", "odom")}),
        (ODOM, TREE, False, set()),
        (TREE, TREE, True, {("map", "odom"), ("odom", "base_link")}),
        (NONE, TREE, True, set()),
    ],
)
def test_no_frame_has_two_parents(mode, with_odometry, odometry, wanted):
    found = drive(Feed(Options(tf=mode, tf_with_odometry=with_odometry)), 5, odometry)
    assert {one[:2] for one in found} == wanted
    for pair in wanted:
        assert sum(one[:2] == pair for one in found) == 5
    if mode is None and not odometry:
        assert [round(one[2], 6) for one in found] == [0, 1, 2, 3, 4]  # the one that waited, too


def test_odometry_that_comes_late_changes_no_parent(capsys):
    begin_run()
    feed = Feed()
    found = drive(feed, 3, odometry=False) + drive(feed, 3, odometry=True)
    assert {one[:2] for one in found} == {("map", "base_link")}
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and "odometry came after the first pose" in err and "--tf tree or odom" in err


def test_the_two_transforms_give_the_pose():
    draw = random.Random(3)
    feed = Feed(Options(tf=TREE))
    for frame in range(20):
        place = [draw.randrange(-90000, 90000) for _ in range(4)] + [draw.randrange(36000) for _ in range(2)]
        feed(
            m.POSE,
            **{**POSE, "frame": frame, "x_mm10": place[0], "y_mm10": place[1], "heading_cdeg": place[4]},
        )
        motion = {"x_mm10": place[2], "y_mm10": place[3], "heading_cdeg": place[5]}
        transforms = {
            one[:2]: one[2:]
            for one in told(feed(m.MOTION, frame=frame, state=m.MOTION_EXTRAPOLATED, **motion))
        }
        x, y, angle = frames.compose(transforms["map", "odom"], transforms["odom", "base_link"])
        assert (x, y) == pytest.approx((place[0] / 1e4, place[1] / 1e4))
        assert math.cos(angle - math.radians(place[4] / 100)) == pytest.approx(1)


def test_frames_and_topics_have_the_names_given():
    names = Names("cart_2/eye", "hall", "wheels", "cart", "cart_eye")
    feed = Feed(Options(names, tf=TREE, ahead_s=0.5))
    pose = feed(m.POSE, **POSE)
    assert set(pose) == {"/cart_2/eye/wire/pose", "/cart_2/eye/pose"}
    assert only(pose["/cart_2/eye/pose"])["header"]["frame_id"] == "hall"
    both = feed(m.MOTION, state=m.MOTION_INTERPOLATED)["/tf"]
    odom, hall = [output.value["transforms"][0] for output in both]
    assert (odom["header"]["frame_id"], odom["child_frame_id"]) == ("wheels", "cart")
    assert (hall["header"]["frame_id"], hall["child_frame_id"]) == ("hall", "wheels")
    times = [one["header"]["stamp"]["sec"] + one["header"]["stamp"]["nanosec"] / 1e9 for one in (odom, hall)]
    assert times[1] - times[0] == pytest.approx(0.5, abs=1e-6)


def rotation(q):
    x, y, z, w = q["x"], q["y"], q["z"], q["w"]
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@pytest.mark.parametrize(
    "mount, forward, left", [(0, 0, 0), (9000, 0, 0), (3100, 700, -1200), (27000, -500, 40)]
)
def test_where_the_camera_sits_is_what_the_camera_model_says(mount, forward, left):
    feed = Feed()
    given = {"camera_x_mm10": 1234, "camera_y_mm10": -50, "camera_z_mm10": 8000}
    angles = {"mount_cdeg": mount, "tilt_forward_cdeg": forward, "tilt_left_cdeg": left}
    for name, value in {**given, **angles}.items():
        found = feed.setting(name, value)
    (one,) = only(found["/tf_static"])["transforms"]
    assert (one["header"]["frame_id"], one["child_frame_id"]) == ("base_link", "camera_optical_frame")
    assert one["transform"]["translation"] == {"x": 0.1234, "y": -0.005, "z": 0.8}
    model = Camera(320, 240, 300 * 256, **angles)
    ours = rotation(one["transform"]["rotation"])
    assert ours == pytest.approx(np.array(model._matrix).reshape(3, 3) / 2**18, abs=1e-4)


def test_the_map_is_drawn_when_it_is_known_and_again_when_it_changes():
    feed = Feed()
    assert "map" not in feed(m.STATUS)
    feed.setting("ceiling_mm10", 27000)
    rows = [[3, 0, 1500, 9000, 0, 0], [5, 2000, 1500, 0, 31000, 1000], [1261, 100, 0, 0, 0, 0]]
    parts = only(feed.setting("map", rows)["map"])["markers"]
    assert all(part["header"]["frame_id"] == "map" and part["ns"] == "map" for part in parts)
    assert len({part["id"] for part in parts}) == len(parts) == 9
    discs = [part for part in parts if part["type"] == 3]
    assert [part["pose"]["position"] for part in discs] == [
        {"x": 0.0, "y": 1.5, "z": 2.7}, {"x": 2.0, "y": 1.5, "z": 3.1}, {"x": 0.1, "y": 0.0, "z": 2.7},
    ]  # fmt: skip
    assert [part["scale"]["x"] for part in discs] == [0.3, 0.2, 0.3]
    assert [part["text"] for part in parts if part["type"] == 9] == ["ID 3", "ID 5", "ID 1261"]
    arrow = next(part for part in parts if part["type"] == 0)
    assert arrow["pose"]["orientation"] == frames.quaternion(math.pi / 2) and arrow["scale"]["x"] == 0.23
    parts = only(feed.setting("route", [3, 5])["map"])["markers"]
    assert [part["points"] for part in parts if part["ns"] == "route"] == [
        [{"x": 0.0, "y": 1.5, "z": 2.7}, {"x": 2.0, "y": 1.5, "z": 3.1}]
    ]
    assert "map" not in feed.setting("route", [3, 5])
    assert qos_of("/larics/map").durability == "transient_local" and qos_of("/tf").durability == "volatile"


def test_a_map_of_a_file_comes_first_and_a_height_that_nobody_told_is_said():
    feed = Feed(Options(map_rows=[[3, 0, 0, 0, 0, 0]], route=[]))
    parts = only(feed(m.STATUS)["map"])["markers"]
    assert [part["text"] for part in parts if part["type"] == 9] == ["ID 3 (height ?)"]
    assert "map" not in feed(m.STATUS)


def seen(feed, **given):
    told = {"count": 1, "x_mm10": 5000, "y_mm10": -1000, "z_mm10": 27000, "heading_cdeg": 1000, **given}
    return feed(m.MARKER, **told).get("sightings")


def test_sightings_come_and_go():
    feed = Feed()
    assert seen(feed, frame=1, id=3, count=2) is None  # the other one of the frame is still to come
    parts = only(seen(feed, frame=1, id=m.ID_NONE, flags=m.MARKER_ID_UNCERTAIN, index=1, count=2))["markers"]
    assert [part["text"] for part in parts if part.get("text")] == ["ID 3", "ID ?"]
    assert {part["header"]["frame_id"] for part in parts} == {"base_link"}
    assert parts[0]["pose"]["position"] == {"x": 0.5, "y": -0.1, "z": 2.7}
    assert parts[0]["color"]["g"] != parts[3]["color"]["g"] and parts[0]["lifetime"]["nanosec"] == 500_000_000
    gone = [part["action"] for part in only(seen(feed, frame=2, id=3))["markers"]]
    assert gone == [0, 0, 0, 2, 2, 2]
    none = {"frame": 3, "flags": m.MARKER_NONE, "id": m.ID_NONE, "count": 0}
    assert [part["action"] for part in only(feed(m.MARKER, **none)["sightings"])["markers"]] == [2, 2, 2]
    assert "sightings" not in feed(m.MARKER, **{**none, "frame": 4})
    assert seen(feed, frame=5, id=3, flags=m.MARKER_NO_OFFSET, x_mm10=0, y_mm10=0, z_mm10=0) is None


def test_health():
    feed = Feed()
    feed(m.INFO, board=b"desk".ljust(16, b"\0"), unique_id=bytes(range(12)), width=320, height=240)

    def status(**given):
        (one,) = only(feed(m.STATUS, **given)["/diagnostics"])["status"]
        return one["level"], one["message"], one

    level, text, one = status(state=m.TRACKING, faults=1, rate_chz=6000, grey_mean=m.GREY_UNKNOWN)
    assert (level, text) == (0, "TRACKING") and one["hardware_id"] == bytes(range(12)).hex()
    values = {pair["key"]: pair["value"] for pair in one["values"]}
    assert values["rate_chz"] == "6000 0.01 Hz" and values["grey_mean"] == "unknown"
    assert values["board"] == "desk" and values["frame size"] == "320 x 240 px"
    assert status(state=m.LOST, faults=1)[:2] == (1, "LOST")
    level, text, _ = status(state=m.TRACKING, faults=2, last_fault=m.FAULT_UART_WRITE)
    assert level == 1 and text == "fault: uart write; TRACKING"
    assert status(state=m.TRACKING, faults=2, last_fault=m.FAULT_UART_WRITE)[0] == 0
    lasting = 1 << m.FAULT_CAMERA_DARK
    level, text, one = status(state=m.LOST, faults=3, active_faults=lasting)
    assert (level, text) == (2, "camera dark; LOST")
    silent = feed.view.silent(4.2, T0_NS)
    assert silent.value["status"][0]["level"] == 3 and "no STATUS for 4 s" in str(silent.value)


def raw_messages(frame, number, token=9):
    """(number, fields) of a raw frame."""
    header, chunks = transfer(frame)
    yield m.RAW_HEADER, header._replace(token=token, frame=number)._asdict()
    for chunk in chunks:
        yield m.RAW_CHUNK, chunk._replace(token=token)._asdict()


@pytest.mark.parametrize("background", [False, True])
def test_a_raw_frame_is_a_picture_with_what_is_in_it(background):
    name = "sunny_r30_1000_0.pgm"
    frame = cv2.imread(str(ROOT / "tests/frames" / name), cv2.IMREAD_GRAYSCALE)
    (truth, *_) = by_frame(read_truth(ROOT / "tests/frames"))[name]
    feed = Feed(Options(background=background))
    feed(m.MARKER, frame=70, age_us=5000, count=1)
    messages = list(raw_messages(frame, 70))
    random.Random(1).shuffle(messages[1:])
    outputs = {}
    for number, fields in [*messages[:9], *messages]:  # some of it twice, as after a question
        outputs.update(feed(number, **fields))
    for output in feed.view.finish():
        outputs[output.topic.replace("/larics/", "")] = [output]
    picture, drawn = outputs["image/compressed"][0], outputs["annotations"][0]
    assert picture.stamp_ns == drawn.stamp_ns == T0_NS - 5_000_000
    assert picture.value["header"]["frame_id"] == "camera_optical_frame" and picture.value["format"] == "png"
    data = np.frombuffer(picture.value["data"], np.uint8)
    assert (cv2.imdecode(data, cv2.IMREAD_UNCHANGED) == frame).all()
    outer, inner = drawn.value["circles"]
    # counted from the corner of the first pixel
    place = outer["position"]["x"], outer["position"]["y"]
    assert (
        place == pytest.approx((truth.x_px + 0.5, truth.y_px + 0.5), abs=0.1)
        and inner["position"] == outer["position"]
    )
    assert outer["diameter"] / 2 == pytest.approx(truth.radius_px, abs=0.3)
    first, last = drawn.value["points"][0]["points"]
    angle = math.degrees(math.atan2(first["y"] - last["y"], last["x"] - first["x"])) % 360
    assert angle == pytest.approx(truth.heading_deg, abs=0.3)
    assert drawn.value["texts"][0]["text"].startswith("ID %d  margin" % truth.id)


def test_a_raw_frame_that_is_damaged_or_incomplete_is_no_picture():
    frame = np.arange(64 * 3, dtype=np.uint8).reshape(12, 16)
    (header, *chunks) = list(raw_messages(frame, 1))
    for messages in (
        [header, *chunks[:-1]],
        chunks,
        [header, *chunks[:-1], (m.RAW_CHUNK, {**chunks[-1][1], "data": bytes(64)})],
        [header, *[(m.RAW_CHUNK, {**fields, "token": 8}) for _, fields in chunks]],
    ):
        feed = Feed()
        assert not any("image/compressed" in feed(number, **fields) for number, fields in messages)
