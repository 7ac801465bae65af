"""Who speaks to the vehicle: restarts, other cameras, recordings, echoes and what is lost or comes twice."""

from larics.wire import messages as m
from recorded import Stream, frame_of, message
from session import NEVER, Session, started


def test_a_restart_voids_what_was_before(program):
    camera = Stream()
    with started(program, camera) as session:
        session.later(camera.pose())
        again = Stream(boot=2000)
        session.later(again.info())
        assert session.marker().state == session.pose().state == "restarted"
        assert session.marker().age_ms == session.pose().age_ms == NEVER
        session.later(again.marker())
        assert session.marker().state == "good" and session.noticed()["restarts"] == 1
        session.later(camera.status(5))  # the boot before does not come back
        session.later(again.marker())
        assert session.marker().state == "good" and session.noticed()["foreign"] == 1


def test_a_restart_that_only_the_status_tells(program):
    camera = Stream()
    with Session(program) as session:
        session.later(camera.status(100) + camera.marker())
        assert session.marker().state == "good"
        again = Stream(boot=2000)
        again.sequence = 1  # its INFO got lost
        session.later(again.marker())
        assert session.noticed()["repeated"] == 1
        session.later(again.status(1))
        session.later(again.marker())
        assert session.marker().state == "good"


def test_missing_messages(program):
    camera = Stream()
    with started(program, camera) as session:
        for _ in range(60):  # every second one is lost
            camera.marker()
            session.later(camera.marker(), 5)
        assert session.marker().state == "damaged"
        for _ in range(60):
            session.later(camera.marker(), 5)
        assert session.marker().state == "good"
    with started(program, camera := Stream()) as session:
        for k in range(200):  # one of twenty: the age judges
            if k % 20 == 0:
                camera.marker()
            session.later(camera.marker(), 5)
            assert session.marker().state == "good"


def test_repeated_and_late_messages_are_refused(program):
    camera = Stream()
    with started(program, camera) as session:
        old = camera.marker(x=500)
        session.later(old)
        session.later(camera.marker(x=600))
        session.later(old)
        assert session.marker().x == 600 and session.noticed()["repeated"] == 1
        session.later(old, 150)
        assert session.marker().state == "no_marker"


def test_another_camera_on_the_line(program):
    ours, other = Stream(), Stream(boot=77, unique_id=b"camera-two--")
    other.sequence = other.frame = 5000
    with started(program, ours) as session:
        session.later(other.marker(x=900))
        assert session.marker().state == "unproven" and session.marker().x == 100
        session.later(other.info())
        assert session.marker().state == "foreign"
        session.later(ours.marker() + other.marker(x=900) + ours.status(2) + other.status(9))
        assert session.marker().state == "foreign" and session.marker().id == 0
        session.later(b"", 1600)  # it was swapped for good
        session.later(other.status(10) + other.marker())
        assert session.marker().state == "foreign"
    with Session(program, unique_id=b"camera-one--".hex()) as session:
        session.later(other.info() + other.status(1) + other.marker())
        assert session.marker().state == "foreign"
        session.later(ours.info() + ours.marker())
        assert session.marker().state == "good"
    with Session(program, unique_id=b"camera-one--".hex()) as session:
        session.later(ours.status(3) + ours.marker())
        assert session.marker().state == "unproven"  # who it is, is not known yet


CHALLENGED = {"challenge_ms": 1000, "answer_ms": 100}


def challenged(program, camera):
    session = Session(program, **CHALLENGED)
    session.later(b"")
    session.later(camera.answer(session.challenge()), 20)
    session.later(camera.marker())
    return session


def test_a_challenge_is_answered_at_the_rate_that_was_set(program):
    camera = Stream()
    with challenged(program, camera) as session:
        assert session.marker().state == "good"
        asked = 0
        for k in range(1000):
            request = session.challenge()
            asked += bool(request)
            if k % 200 == 100:
                session.later(camera.status(1 + k // 200), 0)
            session.later((camera.answer(request) if request else b"") + camera.marker(), 5)
            assert session.marker().state == "good"
        assert asked == 5
        for _ in range(300):  # nobody answers any more
            session.challenge()
            session.later(camera.marker(), 5)
        assert session.marker().state == "unproven"


def test_before_the_first_answer_nothing_is_fresh(program):
    camera = Stream()
    with Session(program, **CHALLENGED) as session:
        session.later(camera.info() + camera.status(1) + camera.marker())
        assert session.marker().state == "unproven"


def test_a_recording_after_silence_is_not_fresh(program):
    camera = Stream()
    with challenged(program, camera) as session:
        recording = [camera.status(2)] + [camera.marker(x=800) for _ in range(100)]
        for piece in recording:
            session.later(piece)
        assert session.marker().x == 800
        session.later(b"", 1600)
        for piece in recording:
            session.challenge()  # asked, but a recording cannot answer
            session.later(piece)
            assert session.marker().state == "unproven"
        session.later(b"", 150)
        session.later(camera.answer(session.challenge()))
        session.later(camera.marker(x=900))
        assert (session.marker().state, session.marker().x) == ("good", 900)


def test_a_recording_of_the_same_boot_is_told_by_its_time_without_a_challenge(program):
    camera = Stream()
    with started(program, camera) as session:
        recording = [camera.status(2)] + [camera.marker(x=800) for _ in range(100)] + [camera.status(9)]
        session.later(b"".join(recording))
        session.later(b"", 1600)
        for piece in recording[:-1]:
            session.later(piece)
            assert session.marker().state == "unproven"
        session.later(camera.status(10) + camera.marker())
        assert session.marker().state == "good"


def test_a_recording_of_an_older_boot_is_not_fresh(program):
    camera = Stream()
    recording = [camera.info(), camera.status(1)] + [camera.marker(x=800) for _ in range(50)]
    camera = Stream(boot=2000)
    with challenged(program, camera) as session:
        session.later(b"", 1600)
        for piece in recording:
            session.challenge()
            session.later(piece)
            assert session.marker().state in ("restarted", "unproven", "foreign")


def test_a_boot_number_that_is_drawn_again_is_believed_with_an_answer(program):
    with challenged(program, Stream()) as session:
        for boot in (2000, 1000):
            camera = Stream(boot=boot)
            session.later(camera.status(1) + camera.marker())  # its INFO got lost
            assert session.marker().state in ("restarted", "unproven")
            session.later(b"", 110)
            session.later(camera.answer(session.challenge()))
            session.later(camera.marker(x=900))
            assert (session.marker().state, session.marker().x) == ("good", 900)
    with started(program, Stream()) as session:  # without a challenge it may be a recording
        for boot in (2000, 1000):
            camera = Stream(boot=boot)
            session.later(camera.info())
            session.later(camera.marker(x=boot))
        assert session.marker().x == 2000 and session.noticed()["foreign"] == 1


def test_an_answer_to_another_question_or_too_late_proves_nothing(program):
    camera = Stream()
    with Session(program, **CHALLENGED) as session:
        session.later(b"")
        request = session.challenge()
        wrong = bytearray(request)
        session.later(camera.info(token=12345) + camera.send(m.ACK, token=12345, command=m.GET_INFO))
        session.later(camera.marker())
        assert session.marker().state == "unproven"
        session.later(camera.answer(bytes(wrong)), 101)
        session.later(camera.marker())
        assert session.marker().state == "unproven" and session.noticed()["late_answers"] == 1


def test_our_own_echo_is_refused(program):
    camera = Stream()
    with started(program, camera) as session:
        session.later(frame_of(m.PING, message(m.PING, token=7), camera.sequence))
        assert session.noticed()["foreign"] == 1 and session.marker().state == "good"
