"""What is not known is said so: never as 0, and never as the number that stands for it on the wire."""

import io
import json

import pytest

from larics.wire import messages as m
from larics.wire.codec import Counters, Encoder
from larics_host import wire_names as codes
from larics_host.connection.receiver import message_of, wire_bytes
from larics_host.connection.records import Pose, Status, as_json, known, record_of
from larics_host.logs.live_table import LiveTable
from larics_host.logs.log_writer import LogWriter
from larics_host.monitor.drawing import draw_view
from larics_host.monitor.state import MonitorState
from larics_host.monitor.terminal import render
from wire_values import changed, message_values

POSE_UNKNOWN = {
    name: codes.UNKNOWN[name] for name in Pose._fields if name in codes.UNKNOWN and name != "correlation_q14"
}
LOST = message_values(m.POSE, frame=7, age_us=9000, state=m.LOST, **POSE_UNKNOWN)
SOMETHING = dict.fromkeys(POSE_UNKNOWN, 3) | {"x_mm10": 10000}
TRACKED = message_values(m.POSE, frame=6, age_us=9000, state=m.TRACKING, **SOMETHING)
STATUS_UNKNOWN = {name: codes.UNKNOWN[name] for name in Status._fields if name in codes.UNKNOWN}
FIRST = message_values(m.STATUS, state=m.LOST, exposure_us=5000, **STATUS_UNKNOWN)
SIGMAS = {"sigma_q12": m.SIGMA_UNKNOWN, "sigma_mdeg": m.SIGMA_UNKNOWN}
NOTHING = message_values(m.MARKER, frame=7, flags=m.MARKER_NONE, id=m.ID_NONE, **SIGMAS)
UNPLACED = message_values(m.MARKER, frame=7, flags=m.MARKER_NO_OFFSET, id=3, count=1, margin=9)
SENTINELS = ("107374", "1073741", "655.35", "6553.5", "65535", "360.0")


def message(number, values, time_s=1.0):
    return message_of(number, 5, values, time_s)


def monitor(*messages):
    state = MonitorState("test")
    for k, (number, values) in enumerate(messages):
        state.add(message(number, values, 1.0 + k), None)
    return state


def text_of(renderable):
    from rich.console import Console

    file = io.StringIO()
    Console(width=150, file=file).print(renderable)
    return file.getvalue()


@pytest.mark.parametrize(
    ("number", "values", "unknown"),
    [
        (m.POSE, LOST, set(POSE_UNKNOWN)),
        (m.POSE, TRACKED, set()),
        (m.STATUS, FIRST, set(STATUS_UNKNOWN)),
        (m.MARKER, NOTHING, {"id", *SIGMAS, *codes.UNKNOWN_BY_FLAG[m.MARKER_NONE]}),
        (m.MARKER, UNPLACED, {"x_mm10", "y_mm10", "z_mm10"}),
    ],
)
def test_json_says_null_and_goes_back_to_the_same_bytes(number, values, unknown):
    record = record_of(number, values)
    shown = as_json(record)
    assert {name for name, value in shown.items() if value is None} == unknown
    name = type(record).__name__.upper()
    assert wire_bytes(Encoder(), name, 5, shown) == wire_bytes(Encoder(), name, 5, record._asdict())


def test_a_lost_camera_has_no_place_on_the_page_and_in_the_terminal():
    state = monitor((m.POSE, TRACKED), (m.POSE, LOST), (m.STATUS, FIRST))
    shot = json.loads(json.dumps(state.snapshot()))
    assert {key: value for key, value in shot["pose"].items() if value is not None} == {
        "state": "LOST",
        "age_ms": 9.0,  # of the frame
    }
    assert shot["status"]["rate_chz"] is None and shot["status"]["grey_mean"] is None
    text = text_of(render(state))
    assert "LOST" in text and not any(sentinel in text for sentinel in SENTINELS), text
    assert any("?" in line for line in draw_view(state, 40, 12)[1])  # where it was last


def test_a_camera_that_sends_no_more_poses_is_lost_when_its_status_says_so():
    state = monitor((m.POSE, TRACKED), (m.STATUS, FIRST))
    assert state.state == "LOST" and state.pose["x_mm"] is None and state.pose["age_ms"] is None
    table = LiveTable("test")
    table.add(message(m.POSE, TRACKED))
    table.add(message(m.STATUS, FIRST))
    assert "TRACKING" not in text_of(table.render(Counters()))


def test_the_live_table_says_question_marks():
    table = LiveTable("test")
    coasting = changed(m.STATUS, FIRST, state=m.COASTING)  # one that is LOST takes the pose away
    for number, values in ((m.POSE, LOST), (m.STATUS, coasting), (m.MARKER, UNPLACED)):
        table.add(message(number, values))
    text = text_of(table.render(Counters()))
    assert "x ? mm, y ? mm, heading ? deg, marker ? ms ago" in text and "? frames/s" in text
    assert not any(sentinel in text for sentinel in SENTINELS), text


def test_logs_say_null_and_mcap_has_no_time_of_a_thousand_seconds_ago(tmp_path):
    from mcap.reader import make_reader

    prefix = str(tmp_path / "run")
    log = LogWriter(prefix, mcap=True)
    for number, values in ((m.POSE, LOST), (m.POSE, TRACKED), (m.MARKER, NOTHING)):
        log.write(message(number, values))
    log.close()
    lines = (tmp_path / "run.jsonl").read_text().splitlines()
    lost, tracked, nothing = [json.loads(line) for line in lines]
    assert lost["x_mm10"] is None and lost["marker_age_ms"] is None and tracked["x_mm10"] == 10000
    assert nothing["heading_cdeg"] is None
    assert ",7,0,32,,0,0,,,," in (tmp_path / "run.csv").read_text().splitlines()[1]
    with open(prefix + ".mcap", "rb") as file:
        found = make_reader(file).iter_messages(topics=["/larics/wire/pose", "/larics/wire/marker"])
        times = [one.log_time - one.publish_time for _, _, one in found]
    assert times == [9000000, 9000000, 9000000]  # of one frame, whose age the first message told


def test_every_value_that_stands_for_unknown_fits_its_field():
    assert len(POSE_UNKNOWN) == 11 and len(STATUS_UNKNOWN) == 5
    for number, fields in ((m.POSE, POSE_UNKNOWN), (m.STATUS, STATUS_UNKNOWN)):
        for field, value in fields.items():
            values = message_values(number, **{field: value})
            assert known(record_of(number, values), field) is None
            assert Encoder().encode(number, values)
