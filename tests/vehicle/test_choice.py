"""Which of several markers is steered by."""

from larics.wire import messages as m
from larics.wire.codec import fields
from recorded import Stream, frame_of, of_today, stream_of
from session import Session

NEAREST, BY_ID, BY_ROUTE = range(3)


def frames(camera, *markers):
    """Bytes of one frame with these (ID, x, y)."""
    camera.frame += 1
    return b"".join(
        camera.marker(marker_id, x, y, frame=camera.frame, index=k, count=len(markers))
        for k, (marker_id, x, y) in enumerate(markers)
    )


def test_two_in_view_of_a_drive_from_marker_to_marker(program):
    """Three changes, one for each new marker: it was 28."""
    targets = []
    with Session(program, frozen_frames=0, max_age_ms=300) as session:
        names = [name for name, *_ in fields(m.MARKER)]
        for _, number, sequence, values in of_today(stream_of("two_in_view.bin")):
            session.later(frame_of(number, values, sequence), 5)
            if number != m.MARKER:
                continue
            if values[names.index("index")] + 1 == values[names.index("count")]:
                session.later(b"", 5)
                targets.append(session.marker().id)
        assert session.noticed()["changes"] == 4  # the first one counts
    changes = [b for a, b in zip(targets, targets[1:], strict=False) if a != b]
    assert len(targets) == 151 and changes == [5, 6, 2]


def test_a_target_stays_until_another_is_clearly_nearer_for_some_frames(program):
    camera = Stream()
    with Session(program) as session:
        session.later(camera.info() + frames(camera, (3, 1000, 0), (4, 2000, 0)))
        assert session.marker().id == 3
        for _ in range(5):  # a little nearer
            session.later(frames(camera, (3, 1500, 0), (4, 1300, 0)))
        assert session.marker().id == 3
        session.later(frames(camera, (4, 500, 0), (3, 1500, 0)))
        session.later(frames(camera, (3, 1500, 0), (4, 500, 0)))
        assert session.marker().id == 3
        session.later(frames(camera, (4, 500, 0), (3, 1500, 0)))
        assert session.marker().id == 4
        session.later(frames(camera, (3, 100, 0), (4, 500, 0)), 2)
        session.later(frames(camera, (3, 900, 0), (4, 500, 0)), 2)
        session.later(frames(camera, (3, 100, 0), (4, 500, 0)), 2)
        session.later(frames(camera, (3, 100, 0), (4, 500, 0)), 2)
        assert session.marker().id == 4  # not in three frames one after the other


def test_a_target_out_of_view_is_kept_for_a_while(program):
    camera = Stream()
    with Session(program, max_age_ms=1000) as session:
        session.later(camera.info() + frames(camera, (3, 1000, 0)))
        for _ in range(9):
            session.later(frames(camera, (4, 100, 0)), 20)
            assert session.marker().id == 3
        for _ in range(3):
            session.later(frames(camera, (4, 100, 0)), 20)
        assert session.marker().id == 4


def test_an_unusable_marker_does_not_block_a_usable_one(program):
    camera = Stream()
    with Session(program) as session:
        session.later(camera.info())
        for _ in range(3):
            camera.frame += 1
            session.later(
                camera.marker(6, 10, 0, frame=camera.frame, count=2, margin=255, flags=m.MARKER_UNCONFIRMED)
                + camera.marker(3, 900, 0, frame=camera.frame, index=1, count=2, margin=20)
            )
            assert (session.marker().state, session.marker().id) == ("good", 3)


def test_by_id(program):
    camera = Stream()
    with Session(program, **{"choice.mode": BY_ID, "choice.id": 4}) as session:
        session.later(camera.info() + frames(camera, (3, 10, 0)))
        assert session.marker().state == "no_marker"
        session.later(frames(camera, (3, 10, 0), (4, 3000, 0)))
        assert session.marker().id == 4
        session.later(frames(camera, (4, 3000, 0), (4, -500, 0)))  # two of this ID: where it was
        assert session.marker().x == 3000
        session.later(frames(camera, (4, -500, 0), (4, 2900, 0)))
        assert session.marker().x == 2900


def test_by_route(program):
    camera = Stream()
    with Session(program) as session:
        session.follow(3, 5)
        session.later(camera.info() + frames(camera, (7, 10, 0), (3, 400, 0)))
        assert session.marker().id == 3
        for _ in range(3):
            session.later(frames(camera, (3, 400, 0), (5, 4000, 0), (7, 10, 0)))
        assert session.marker().id == 5  # further away, but the next one
        session.follow(5, 6)
        session.later(frames(camera, (5, 100, 0), (3, 4000, 0)))
        assert session.marker().id == 5


def test_a_lost_last_message_of_a_frame_delays_the_choice_by_a_frame(program):
    camera = Stream()
    with Session(program) as session:
        session.later(camera.info())
        camera.frame += 1
        session.later(camera.marker(3, 500, 0, frame=camera.frame, count=2))  # the second one is lost
        assert session.marker().id == 0
        camera.sequence += 1
        session.later(frames(camera, (3, 450, 0)))
        assert (session.marker().id, session.marker().x) == (3, 450)
