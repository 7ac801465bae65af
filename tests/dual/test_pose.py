"""larics.locate.localizer on both interpreters: states, gates, faults, and no allocation for a frame."""

from larics.locate.camera_model import Measurement
from larics.locate.localizer import Localizer
from larics.locate.marker_map import MarkerMap
from larics.locate.motion import direction_cdeg
from larics.locate.uncertainty import Systematic
from larics.wire.messages import (
    COASTING,
    FAULT_MARKER_HEIGHT,
    FAULT_MARKER_PLACE,
    FAULT_MARKER_UNKNOWN,
    ID_NONE,
    LOST,
    SIGMA_UNKNOWN,
    TRACKING,
)

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

ROWS = ((3, 0, 0, 0), (4, 4000, 0, 9000), (7, 4000, 3000, 18000))
FRAME_US = 20000
EXACT = Systematic(0, 0, 0, 0, 0, 0, 0)  # camera and map


def measured(marker_id, x_mm10, y_mm10, heading_cdeg, ring_mm10=30000):
    out = Measurement()
    out.marker_id = marker_id
    out.offset_x_mm10, out.offset_y_mm10, out.heading_cdeg = x_mm10, y_mm10, heading_cdeg % 36000
    out.height_mm10, out.ring_height_mm10 = 30000, ring_mm10
    return out


def localizer():
    return Localizer(MarkerMap(ROWS), coast_us=1000000, systematic=EXACT)


def tracking():
    """At (-1000, 0), heading 0, one frame after the other below marker 3; returns it and the time."""
    found = localizer()
    for k in range(5):
        found.update([measured(3, 10000, 0, 0)], 1, k * FRAME_US)
    assert found.state == TRACKING
    return found, 4 * FRAME_US


def test_a_pose_needs_two_frames_that_agree():
    found = localizer()
    assert (found.state, found.sigma_mm10, found.marker_id) == (LOST, SIGMA_UNKNOWN, ID_NONE)
    assert found.update([measured(4, 5000, 2000, 4500)], 1, 1000) == LOST
    assert found.update([measured(4, 5000, 2000, 4500)], 1, 1000 + FRAME_US) == TRACKING
    # marker heading 90, seen at 45: the vehicle heads to 45; its offset turned by that is (2121, 4950)
    assert found.heading_cdeg == 4500
    assert abs(found.x_mm10 - 40000 + 2121) <= 1 and abs(found.y_mm10 + 4950) <= 1
    assert (found.age_us, found.marker_id, found.entry, found.fault) == (0, 4, 1, 0)


def test_a_pose_is_no_surer_than_its_markers():
    found, time_us = tracking()
    assert found.sigma_mm10 < 77 and found.sigma_cdeg < 150
    near, far = measured(3, 10000, 0, 0), measured(4, 50000, 0, 9000)
    near.sigma_mm10, near.sigma_mdeg = 20, 1500
    far.sigma_mm10 = 77  # and its heading is not known
    found.update([near, far], 2, time_us + FRAME_US)
    assert found.state == TRACKING
    assert (found.sigma_mm10, found.sigma_cdeg) == (77, 150)
    found.update([measured(3, 10000, 0, 0)], 1, time_us + 2 * FRAME_US)
    assert found.sigma_mm10 < 77


def test_frames_that_disagree_give_no_pose():
    found = localizer()
    for k in range(20):
        found.update([measured(3 if k % 2 else 4, 0, 0, 0)], 1, k * FRAME_US)
        assert found.state == LOST


def test_coasting_carries_on_and_says_so_until_lost():
    found = localizer()
    time_us = 0
    for k in range(30):  # 1 m/s towards marker 3 and on
        time_us = k * FRAME_US
        found.update([measured(3, 10000 - k * 200, 0, 0)], 1, time_us)
    assert found.state == TRACKING and found.x_mm10 == -10000 + 29 * 200
    sigma = found.sigma_mm10
    last = 0
    for k in range(1, 51):
        assert found.update([], 0, time_us + k * FRAME_US) == COASTING
        assert found.age_us == k * FRAME_US
        assert abs(found.x_mm10 - (-10000 + (29 + k) * 200)) < 3 + k and abs(found.y_mm10) < 3
        assert found.sigma_mm10 >= max(sigma, last)
        last = found.sigma_mm10
    assert last > sigma + 300  # 1 s at 0.064 m/s2 is 32 mm
    assert found.update([], 0, time_us + 51 * FRAME_US) == LOST
    assert found.sigma_mm10 == SIGMA_UNKNOWN and found.age_us == 51 * FRAME_US


def test_coasting_follows_the_turn():
    found = localizer()
    for k in range(40):  # turning in place below marker 3 at 90 degrees/s
        found.update([measured(3, 0, 0, -180 * k)], 1, k * FRAME_US)
    found.update([], 0, 50 * FRAME_US)
    assert found.state == COASTING
    assert abs(found.heading_cdeg - 180 * 50) < 30


def test_a_marker_that_is_not_in_the_map_is_refused():
    found, time_us = tracking()
    assert found.update([measured(5, 0, 0, 0)], 1, time_us + FRAME_US) == COASTING
    assert found.fault == FAULT_MARKER_UNKNOWN
    lost = localizer()
    lost.update([measured(5, 0, 0, 0)], 1, 0)
    assert lost.fault == FAULT_MARKER_UNKNOWN and lost.state == LOST


def test_a_refused_id_takes_no_other_with_it():
    found, time_us = tracking()
    found.update([measured(3 + 16, 0, 0, 0), measured(4094, 0, 0, 0)], 2, time_us + FRAME_US)
    assert found.refused(19) and found.refused(4094) and not found.refused(3) and not found.refused(4094 - 16)
    found.update([measured(3, 10000, 0, 0)], 1, time_us + 2 * FRAME_US)
    assert not found.refused(19)


def test_a_marker_of_the_wrong_size_is_refused():
    found, time_us = tracking()
    assert found.update([measured(3, 10000, 0, 0, 33000)], 1, time_us + FRAME_US) == COASTING
    assert found.fault == FAULT_MARKER_HEIGHT
    assert found.update([measured(3, 10000, 0, 0, 30500)], 1, time_us + 2 * FRAME_US) == TRACKING
    assert found.fault == 0


def test_an_impossible_place_is_refused_and_a_moved_vehicle_found():
    found, time_us = tracking()
    assert found.update([measured(4, 0, 0, 0)], 1, time_us + FRAME_US) == COASTING
    assert found.fault == FAULT_MARKER_PLACE and found.x_mm10 == -10000
    assert found.update([measured(3, 10000, 0, 0)], 1, time_us + 2 * FRAME_US) == TRACKING
    states = [found.update([measured(7, 100, 0, 0)], 1, time_us + (3 + k) * FRAME_US) for k in range(3)]
    assert states == [COASTING, COASTING, TRACKING]
    assert found.marker_id == 7 and found.heading_cdeg == 18000
    assert found.x_mm10 == 40100 and found.y_mm10 == 30000


def test_a_good_marker_beside_a_misread_one():
    found, time_us = tracking()
    both = [measured(7, 0, 0, 0), measured(3, 10000, 0, 0)]
    assert found.update(both, 2, time_us + FRAME_US) == TRACKING
    assert found.marker_id == 3 and found.fault == FAULT_MARKER_PLACE


def test_two_markers_are_fused():
    found = Localizer(MarkerMap(((3, 0, 0, 0), (4, 1000, 0, 0))))
    for k in range(2):
        found.update([measured(3, -4990, 0, 10), measured(4, 5000, 0, -10)], 2, k * FRAME_US)
    assert found.state == TRACKING and abs(found.heading_cdeg - 0) <= 1
    assert abs(found.x_mm10 - 4995) <= 1


def test_an_id_that_repeats_in_the_building():
    found = Localizer(MarkerMap(((3, 0, 0, 0), (3, 9000, 0, 0), (4, 4000, 0, 0))))
    for k in range(6):
        assert found.update([measured(3, 0, 0, 0)], 1, k * FRAME_US) == LOST
    found.matching.hint = 1
    assert found.update([measured(3, 0, 0, 0)], 1, 6 * FRAME_US) == LOST
    assert found.update([measured(3, 0, 0, 0)], 1, 7 * FRAME_US) == TRACKING
    assert found.x_mm10 == 90000 and found.entry == 1
    found.matching.hint = -1
    for k in range(8, 40):  # on at 1 m/s to the left of the map, tracked by its prediction
        assert found.update([measured(3, (k - 8) * 200, 0, 0)], 1, k * FRAME_US) == TRACKING
        assert found.entry == 1


def test_sigma_follows_the_noise_and_not_the_speed():
    found = localizer()
    state = 1
    noise = [0, 0, 0]
    for k in range(200):  # 1 m/s, uniform noise of +-8 units: sigma 4.9
        for n in range(3):
            state = (state * 75 + 74) % 65537
            noise[n] = state % 17 - 8
        x = 5000 - 200 * (k % 50) + noise[0]  # the heading's noise adds less than 5 units at this distance
        if k % 50 == 0:
            found = localizer()
        found.update([measured(3, x, noise[1], noise[2])], 1, k * FRAME_US)
        if k % 50 > 30:
            assert 3 <= found.sigma_mm10 <= 12, found.sigma_mm10
            assert 3 <= found.sigma_cdeg <= 9, found.sigma_cdeg


def test_the_clock_may_wrap():
    found = localizer()
    start = (1 << 30) - 3 * FRAME_US
    for k in range(6):
        found.update([measured(3, 10000, 0, 0)], 1, (start + k * FRAME_US) & 0x3FFFFFFF)
    assert found.state == TRACKING
    found.update([], 0, (start + 8 * FRAME_US) & 0x3FFFFFFF)
    assert found.state == COASTING and found.age_us == 3 * FRAME_US


def test_a_frame_allocates_nothing():
    found = localizer()
    seen = measured(3, 10000, 0, 0)
    other = measured(7, 0, 0, 0)
    both, nothing = [seen, other], []
    found.update(both, 2, 0)
    heap_lock()
    try:
        time_us = 0
        for k in range(200):
            time_us += FRAME_US
            seen.offset_x_mm10 = 10000 - 50 * k
            if k % 50 > 40:
                found.update(nothing, 0, time_us)
            elif k > 150:
                found.update(both, 1, time_us + 2000000)
            else:
                found.update(both, 2, time_us)
    finally:
        heap_unlock()


def test_directions():
    assert (
        direction_cdeg(1, 0) == 0 and direction_cdeg(0, 5) == 9000 and direction_cdeg(-100000000, 0) == 18000
    )
    assert direction_cdeg(0, 0) == 0
    found, _ = tracking()
    assert found.bearing_cdeg(-10000, 50000) == 9000
