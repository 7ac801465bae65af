"""What the vehicle may steer by: each fault of the line and of the camera told as itself, and nothing old."""

import pytest

from larics.wire import messages as m
from recorded import Stream, frame_of, of_today, stream_of, timed_stream_of
from session import NEVER, Session, started


def test_a_time_read_before_the_message_came_counts_as_now(program):
    camera = Stream()
    with started(program, camera) as session:
        assert session.marker(session.now - 5).state == "good"
        assert session.marker(session.now - 59_000).age_ms == session.marker().age_ms - 2
        assert session.marker(session.now).state == "good"


def test_an_undamaged_stream_is_always_fresh_with_one_reading_of_the_clock_a_loop(program):
    """60 frames/s, a loop of 1 to 4 ms; the clock is read at its top and the messages come after it."""
    camera = Stream()
    asked = stopped = 0
    with started(program, camera) as session:
        ends = [
            (session.now + 20 + k * 50 // 3, camera.marker() if k % 60 else camera.status(2 + k // 60))
            for k in range(600)
        ]
        top = session.now
        while ends:
            top += 1 + top % 4
            session.turn(top)
            while ends and ends[0][0] <= top + 1:  # while it reads, the clock goes on
                session.feed(ends.pop(0)[1])
            if top > 1030:
                asked += 1
                stopped += session.marker(top).state != "good"
    assert asked > 2000 and stopped == 0


def test_ages_add_up_and_the_clock_may_wrap(program):
    camera = Stream()
    with Session(program, now=2**32 - 20) as session:
        session.later(camera.info())
        session.turn(2**32 - 10)
        session.turn(2**32 - 4, camera.marker())
        # 15 ms told, 1 rounded off, those on the line, since the drain before; the clock comes round
        on_line = len(camera.marker()) * 10000 // 115200 + 1
        session.turn(2**32 + 10)
        assert session.marker() == ("good", 20 + 15 + 1 + on_line, 3, 100, 0)
        assert session.marker(session.now + 100).age_ms == 120 + 16 + on_line
        session.turn(2**32 + 61_000)
        assert session.marker().age_ms == NEVER
        session.turn(2**33 - 10)  # a whole turn of the clock later it is not young again
        assert session.marker().age_ms == NEVER and session.marker().state != "good"


def test_what_waited_in_the_buffer_while_the_loop_was_blocked_is_old(program):
    camera = Stream()
    with started(program, camera) as session:
        session.later(camera.marker(x=111))
        assert session.marker().state == "good"
        session.blocked(camera.marker(x=222), 1000)  # the oldest bytes are still in the buffer
        view = session.marker()
        assert (view.state, view.x) == ("overrun", 222) and view.age_ms >= 1016
        assert session.noticed()["overruns"] == 1
        session.later(camera.marker(x=333))
        assert (session.marker().state, session.marker().x) == ("good", 333)
        session.blocked(camera.marker(x=444), 2000)
        assert (session.marker().state, session.marker().x) == ("overrun", 333)
        session.later(camera.status(3))  # after such a silence, who speaks proves itself
        session.later(camera.marker(x=555))
        assert (session.marker().state, session.marker().x) == ("good", 555)
        before = session.noticed()["overruns"]
        session.blocked(b"", 5)  # 64 bytes last 5.5 ms at 115200 baud
        assert session.noticed()["overruns"] == before
        session.blocked(b"", 6)
        assert session.noticed()["overruns"] == before + 1


def test_silent_stalled_and_out_of_sight_are_not_the_same(program):
    camera = Stream()
    with Session(program) as session:
        assert session.marker().state == "waiting" and session.marker().age_ms == NEVER
        session.later(camera.info() + camera.status(1) + camera.marker())
        assert session.marker().state == "good" and session.may_search()
        session.later(camera.nothing(), 150)
        view = session.marker()
        assert view.state == "no_marker" and view.age_ms > 150 and session.may_search()
        session.later(camera.status(2), 501)
        assert session.marker().state == "stalled" and not session.may_search()
        session.later(b"", 1501)
        assert session.marker().state == "silent"


def test_markers_that_may_not_be_steered_by(program):
    camera = Stream()
    with started(program, camera, stalled_ms=5000) as session:
        for flags, marker_id in (
            (m.MARKER_UNCONFIRMED, 3),
            (m.MARKER_ID_UNCERTAIN, m.ID_NONE),
            (m.MARKER_NO_OFFSET, 3),
        ):
            session.later(b"", 200)
            x = 0 if flags == m.MARKER_NO_OFFSET else 70
            session.later(camera.marker(marker_id, x=x, flags=flags, z_mm10=0))
            assert session.marker().state == "unusable"
        session.later(camera.marker(flags=m.MARKER_TRACKED | m.MARKER_BORDER))
        assert session.marker().state == "good"


@pytest.mark.parametrize("code", [m.FAULT_CAMERA, m.FAULT_SETTINGS_CORRUPT, m.FAULT_LOOP])
def test_a_lasting_fault_that_touches_the_measurement(program, code):
    camera = Stream()
    with started(program, camera) as session:
        session.later(camera.status(2, last_fault=code, active_faults=1 << code))
        session.later(camera.marker())
        assert session.marker().state == "faulty" and not session.may_search()
        session.later(camera.status(3, last_fault=code))
        assert session.marker().state == "good"
    with started(program, camera := Stream(), faults=0) as session:  # the user decides which
        session.later(camera.status(2, active_faults=1 << code) + camera.marker())
        assert session.marker().state == "good"


@pytest.mark.parametrize("active_faults", [0, 1 << m.FAULT_CAMERA_DARK])
def test_a_status_that_stops_leaves_the_health_unknown(program, active_faults):
    """While the markers go on: neither the faults told last nor their absence stand for ever."""
    camera = Stream()
    with started(program, camera) as session:
        session.later(camera.status(2, active_faults=active_faults))
        before = "faulty" if active_faults else "good"
        for _ in range(25):
            session.later(camera.marker(), 200)
            assert session.marker().state == before and 0 < session.status_age_ms() <= 5000
        session.later(camera.marker(), 200)
        assert session.marker().state == "no_status" and not session.may_search()
        session.later(camera.pose())
        assert session.pose().state == "no_status"
        for _ in range(300):
            session.later(camera.marker(), 200)
            assert session.marker().state == "no_status"
        assert session.status_age_ms() == NEVER
        session.later(camera.status(90) + camera.marker())
        assert session.marker().state == "good" and session.status_age_ms() == 0
    with started(program, camera := Stream(), status_ms=0) as session:  # who gets no STATUS has to say so
        for _ in range(30):
            session.later(camera.marker(), 200)
        assert session.marker().state == "good"


def test_a_camera_that_never_tells_its_status(program):
    camera = Stream()
    with Session(program) as session:
        session.later(b"", 30_000)
        session.later(camera.marker())
        assert session.marker().state == "good" and session.status_age_ms() == NEVER
        for _ in range(26):
            session.later(camera.marker(), 200)
        assert session.marker().state == "no_status"
        session.later(Stream(boot=2000).info())  # its first STATUS may take as long
        camera.sequence = 1
        session.later(camera.marker())
        assert session.marker().state == "good"


def test_the_same_picture_again_and_again(program):
    camera = Stream()
    with started(program, camera, frozen_frames=20) as session:
        for _ in range(25):
            session.later(camera.marker(noise=0), 5)
        assert session.marker().state == "frozen"
        session.later(camera.marker(noise=3))
        assert session.marker().state == "good"
        for _ in range(25):
            session.later(camera.marker(noise=0) + camera.nothing(), 5)  # flickers: still the same picture
        assert session.marker().state == "frozen"
        for _ in range(60):  # the marker is gone, so it is another picture
            session.later(camera.nothing(), 10)
        assert session.marker().state == "no_marker" and session.may_search()


@pytest.mark.parametrize(
    "values",
    [
        {"id": m.ID_NONE},
        {"id": 3, "flags": m.MARKER_ID_UNCERTAIN},
        {"index": 1, "count": 1},
        {"index": 5, "count": 2},
        {"count": 0},
        {"flags": m.MARKER_NONE},
        {"flags": m.MARKER_NONE, "count": 0},
        {"flags": m.MARKER_NONE, "count": 0, "id": m.ID_NONE},
        {"flags": m.MARKER_NO_OFFSET},
    ],
)
def test_contradictory_markers_are_refused(program, values):
    camera = Stream()
    with started(program, camera) as session:
        session.later(camera.marker(x=777, **values))
        assert session.noticed()["contradictory"] == 1 and session.marker().x == 100


@pytest.mark.parametrize(
    "code, state",
    [
        (m.FAULT_CAMERA_FROZEN, "frozen"),
        (m.FAULT_CAMERA_DARK, "faulty"),
        (m.FAULT_CAMERA_WHITE, "faulty"),
    ],
)
def test_a_camera_that_says_that_its_picture_is_worth_nothing(program, code, state):
    camera = Stream()
    with started(program, camera) as session:
        session.later(camera.status(2, active_faults=1 << code) + camera.marker())
        assert session.marker().state == state and not session.may_search()
        session.later(camera.status(3) + camera.marker())
        assert session.marker().state == "good"


def test_a_camera_whose_sensor_went_silent(program):
    """STATUS goes on for 58 s and says TRACKING all the time."""
    camera = Stream()
    found = of_today(stream_of("camera_stalled_60s.bin"))
    states = []
    with Session(program, frozen_frames=0) as session:  # rendered without noise
        for _, number, sequence, values in found:
            camera.sequence = sequence
            session.later(frame_of(number, values, sequence), 1000 if number == m.STATUS else 20)
            states.append(session.marker().state)
    assert set(states[:190]) <= {"unusable", "unproven", "stalled"} and "unusable" in states
    assert set(states[-55:]) <= {"stalled", "faulty"}


def test_a_sensor_that_was_restarted_after_100_s_is_heard_at_once(program):
    stream, times = timed_stream_of("sensor_restart_100s.xz")
    began = None
    with Session(program, now=0, frozen_frames=0) as session:  # rendered without noise
        for end, number, sequence, values in of_today(stream):
            session.at(times[end], frame_of(number, values, sequence))
            if number != m.MARKER or not 99_000 < times[end] < 110_000:
                continue
            if values[0] == 0:
                began = times[end]
            assert session.marker().state == "good", times[end]
        assert began and session.noticed()["sensor_restarts"] == 1
    with Session(program, now=0) as session:  # the same picture for 100 s is no sensor's
        for end, number, sequence, values in of_today(stream)[:200]:
            session.at(times[end], frame_of(number, values, sequence))
        assert session.marker().state == "frozen"
