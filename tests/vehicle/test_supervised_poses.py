"""By which poses the vehicle may drive: of a marker, carried by odometry, and how sure they are."""

import pytest

from larics.wire import messages as m
from recorded import Stream
from session import started


def test_a_pose_that_tracks_no_marker_is_refused(program):
    camera = Stream()
    with started(program, camera) as session:
        session.later(camera.pose(x_mm10=10) + camera.pose(x_mm10=20, id=m.ID_NONE))
        assert session.pose().x == 10 and session.noticed()["contradictory"] == 1


def test_poses(program):
    camera = Stream()
    with started(program, camera) as session:
        session.later(camera.pose(x_mm10=10))
        assert (session.pose().state, session.pose().x) == ("good", 10)
        session.later(camera.marker() + camera.pose(state=m.COASTING, id=m.ID_NONE, x_mm10=11))
        assert (session.pose().state, session.pose().x) == ("good", 11)
        session.later(camera.marker() + camera.pose(state=m.LOST, id=m.ID_NONE, x_mm10=12))
        assert (session.pose().state, session.pose().x) == ("no_marker", 11)
        session.later(camera.marker() + camera.pose())
        assert session.pose().state == "good"
        session.later(camera.marker(), 150)
        assert session.pose().state == "no_marker"


def test_a_pose_is_as_old_as_its_marker_unless_odometry_carries_it(program):
    camera = Stream()
    with started(program, camera) as session:
        session.later(camera.marker() + camera.pose(state=m.COASTING, marker_age_ms=900))
        assert session.pose().state == "no_marker" and session.pose().age_ms >= 900
        session.later(camera.marker() + camera.pose(state=m.CARRIED, marker_age_ms=900))
        assert session.pose().state == "good" and session.pose().age_ms < 100


@pytest.mark.parametrize("field", ["sigma_x_mm10", "sigma_y_mm10", "sigma_cdeg"])
@pytest.mark.parametrize("state", [m.TRACKING, m.CARRIED])
def test_a_pose_whose_sigma_is_above_the_limit_or_unknown(program, field, state):
    camera = Stream()
    with started(program, camera, most_sigma_mm10=200, most_sigma_cdeg=200) as session:
        for sigma, expected in ((200, "good"), (201, "imprecise"), (m.SIGMA_UNKNOWN, "imprecise")):
            session.later(camera.marker() + camera.pose(state=state, **{field: sigma}))
            assert session.pose().state == expected and session.may_drive_by() == (expected == "good")
        assert session.marker().state == "good"  # it is the pose that is in doubt
    with started(program, camera := Stream(), most_sigma_mm10=65535, most_sigma_cdeg=65535) as session:
        session.later(camera.marker() + camera.pose(**{field: m.SIGMA_UNKNOWN}))
        assert session.pose().state == "good"


def test_a_pose_that_odometry_has_carried_too_long_or_too_far(program):
    camera = Stream()
    limits = {"most_carried_ms": 3000, "most_way_mm": 1500}
    with started(program, camera, **limits) as session:
        for age_ms, way_mm, expected in (
            (2950, 1500, "good"),
            (3001, 100, "strayed"),
            (m.AGE_UNKNOWN, 100, "strayed"),
            (100, 1501, "strayed"),
            (100, m.WAY_UNKNOWN, "strayed"),
        ):
            carried = {"state": m.CARRIED, "marker_age_ms": age_ms, "way_mm": way_mm}
            session.later(camera.marker() + camera.pose(**carried))
            assert session.pose().state == expected, (age_ms, way_mm)
            assert session.may_drive_by() == (expected == "good")
            session.later(camera.pose(state=m.LOST, id=m.ID_NONE) if way_mm % 2 else camera.marker())
            assert session.may_drive_by()  # that says nothing that is too old
        session.later(camera.marker() + camera.pose(state=m.CARRIED, marker_age_ms=2950))
        assert session.pose().state == "good"
        assert session.pose(session.now + 51).state == "strayed"  # and it goes on while nothing comes
        session.later(camera.marker() + camera.pose(way_mm=m.WAY_UNKNOWN))  # measured: nothing to carry
        assert session.pose().state == "good"
    limits = {"most_carried_ms": 65535, "most_way_mm": 65535}
    with started(program, camera := Stream(), **limits) as session:
        carried = {"state": m.CARRIED, "marker_age_ms": m.AGE_UNKNOWN, "way_mm": m.WAY_UNKNOWN}
        session.later(camera.marker() + camera.pose(**carried))
        assert session.pose().state == "good"
