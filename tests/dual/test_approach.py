"""larics_vehicle.approach on both interpreters: what each state does, the limits, and no allocation."""

from larics.wire.messages import (
    CARRIED,
    COASTING,
    DIRECTION_NONE,
    ID_NONE,
    LOST,
    MARKER,
    MARKER_NONE,
    POSE,
    ROUTE_NONE,
    STATUS,
    TRACKING,
)
from larics_vehicle import approach as a
from larics_vehicle.approach import Approach
from wire_values import message_values

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock


def marker(marker_id, x_mm10, y_mm10, heading_cdeg, age_us=0):
    place = {"x_mm10": x_mm10, "y_mm10": y_mm10, "z_mm10": 30000, "heading_cdeg": heading_cdeg % 36000}
    return message_values(MARKER, age_us=age_us, id=marker_id, count=1, margin=255, radius_q8=7680, **place)


def pose(next_cdeg, position=0, state=TRACKING):
    return message_values(POSE, state=state, id=3, route_position=position, next_cdeg=next_cdeg)


NO_MARKER = message_values(MARKER, flags=MARKER_NONE, id=ID_NONE)


def settle(controller, message, steps=100, number=MARKER):
    """Steps of 20 ms with the same message each time."""
    for _ in range(steps):
        if message is not None:
            controller.on_message(number, 0, message)
        controller.step(20)
    return controller


def test_silence_halts_and_a_word_ends_it():
    controller = Approach(stale_ms=200)
    assert controller.step(20) == a.HALT
    assert settle(controller, NO_MARKER).state == a.SEARCH and controller.speed_mm_s > 0
    for k in range(19):
        controller.step(20)
        assert controller.state == a.SEARCH, k  # up to twice stale_ms
    settle(controller, None, 60)
    assert controller.state == a.HALT and (controller.speed_mm_s, controller.turn_cdeg_s) == (0, 0)
    assert settle(controller, message_values(STATUS), 2, STATUS).state == a.SEARCH


def test_a_hand_stops_it():
    controller = settle(Approach(), marker(3, 9000, 0, 0), 30)
    assert controller.speed_mm_s == 200
    controller.stop()
    assert settle(controller, marker(3, 9000, 0, 0), 60).state == a.HALT
    assert controller.speed_mm_s == 0
    controller.start()
    assert settle(controller, marker(3, 9000, 0, 0), 2).state == a.CENTER


def test_it_drives_to_the_marker():
    for x, y, forward, turn in (
        (5000, 0, 1, 0),
        (5000, 1000, 1, 1),
        (5000, -1000, 1, -1),
        (0, 5000, 0, 1),
        (-5000, 0, -1, 0),
        (-5000, 1000, -1, -1),
    ):
        controller = settle(Approach(), marker(3, x, y, 0))
        assert controller.state == a.CENTER
        assert (controller.speed_mm_s > 0) - (controller.speed_mm_s < 0) == forward, (x, y)
        assert (controller.turn_cdeg_s > 0) - (controller.turn_cdeg_s < 0) == turn, (x, y)


def test_below_the_marker_it_turns_to_the_orientation_line():
    controller = settle(Approach(), marker(3, 50, -50, 12000))
    assert controller.state == a.ALIGN and controller.speed_mm_s == 0 and controller.turn_cdeg_s > 0
    controller = settle(Approach(), marker(3, 50, -50, -12000))
    assert controller.turn_cdeg_s < 0
    controller = settle(Approach(), marker(3, 50, 50, 0), 10)
    assert controller.state == a.GO and controller.left_id == 3 and controller.speed_mm_s > 0


def test_the_route_says_where_to_go_before_the_line_does():
    controller = Approach()
    for _ in range(50):
        controller.on_message(MARKER, 0, marker(3, 0, 0, 0))
        controller.on_message(POSE, 0, pose(33000))
        controller.step(20)
    assert controller.state == a.ALIGN and controller.turn_cdeg_s < 0


def test_at_the_end_of_the_route_it_has_arrived():
    controller = Approach()
    for _ in range(50):
        controller.on_message(MARKER, 0, marker(3, 0, 0, 9000))
        controller.on_message(POSE, 0, pose(DIRECTION_NONE, 5))
        controller.step(20)
    assert controller.state == a.ARRIVED and (controller.speed_mm_s, controller.turn_cdeg_s) == (0, 0)
    # but not while the route's position is only unknown, or the pose lost
    for message in (pose(DIRECTION_NONE, ROUTE_NONE), pose(DIRECTION_NONE, 5, LOST)):
        controller = Approach()
        for _ in range(50):
            controller.on_message(MARKER, 0, marker(3, 0, 0, 9000))
            controller.on_message(POSE, 0, message)
            controller.step(20)
        assert controller.state == a.ALIGN


def test_on_its_way_it_steers_to_the_line_and_takes_the_next_marker():
    controller = settle(Approach(), marker(3, 0, 0, 0), 10)
    settle(controller, marker(3, -2000, 1000, 0), 20)  # the line is 100 mm to the left
    assert controller.state == a.GO and controller.turn_cdeg_s > 0
    settle(controller, marker(3, -2000, -1000, 0), 20)
    assert controller.turn_cdeg_s < 0
    settle(controller, NO_MARKER, 100)
    assert controller.state == a.GO and controller.speed_mm_s == 200 and controller.turn_cdeg_s == 0
    assert settle(controller, marker(4, 6000, 0, 0), 3).state == a.CENTER


def test_the_marker_left_is_no_new_one_when_it_is_misread():
    controller = settle(Approach(), marker(3, 0, 0, 0), 10)
    settle(controller, marker(3, -3000, 0, 0), 20)
    settle(controller, marker(7, -4000, 300, 9000), 10)  # still the same place
    assert controller.state == a.GO and abs(controller.turn_cdeg_s) < 300
    assert settle(controller, marker(7, 5000, 300, 9000), 2).state == a.CENTER  # another place


def test_a_leg_without_end_becomes_a_search():
    controller = settle(Approach(leg_mm=1000), marker(3, 0, 0, 0), 10)
    assert settle(controller, NO_MARKER, 200).state == a.GO
    assert settle(controller, NO_MARKER, 100).state == a.SEARCH
    assert controller.turn_cdeg_s > 0
    first = controller.turn_cdeg_s
    settle(controller, NO_MARKER, 500)
    assert 0 < controller.turn_cdeg_s < first  # the spiral widens


def test_commands_stay_within_their_limits():
    controller = Approach(speed_mm_s=300, turn_cdeg_s=4000, accel_mm_s2=500, turn_accel_cdeg_s2=9000)
    state, speed, turn = 1, 0, 0
    for _ in range(2000):
        state = (state * 75 + 74) % 65537
        if state % 3:
            controller.on_message(
                MARKER, 0, marker(state % 7, state % 12000 - 6000, state % 9001 - 4500, state, state % 900000)
            )
        if state % 5 == 0:
            controller.on_message(POSE, 0, pose(state % 36001, state % 9))
        controller.step(20)
        assert abs(controller.speed_mm_s) <= 300 and abs(controller.turn_cdeg_s) <= 4000
        assert abs(controller.speed_mm_s - speed) <= 10 and abs(controller.turn_cdeg_s - turn) <= 180
        speed, turn = controller.speed_mm_s, controller.turn_cdeg_s


def test_a_step_allocates_nothing():
    controller = Approach()
    views = [
        marker(3, 3000, 500, 8000),
        marker(3, 10, 10, 500),
        marker(3, 0, 0, 0),
        NO_MARKER,
        marker(4, 900, 0, 0),
    ]
    poses = [pose(9000), pose(0), pose(DIRECTION_NONE, ROUTE_NONE)]
    controller.step(20)
    heap_lock()
    try:
        for k in range(1000):
            if k < 900:
                controller.on_message(MARKER, 0, views[k // 60 % 5])
                controller.on_message(POSE, 0, poses[k // 100 % 3])
            controller.step(20)
    finally:
        heap_unlock()


def guided(controller, next_cdeg, state, steps):
    for _ in range(steps):
        controller.on_message(MARKER, 0, NO_MARKER)
        controller.on_message(POSE, 0, pose(next_cdeg, state=state))
        controller.step(20)
    return controller


def test_a_camera_with_odometry_says_where_to_go_on_without_a_marker():
    for state, expected in ((CARRIED, a.GO), (COASTING, a.SEARCH)):
        controller = settle(Approach(leg_mm=300), NO_MARKER, 10)
        assert controller.state == a.SEARCH
        assert guided(controller, 9000, state, 10).state == expected, state
    guided(controller, 0, CARRIED, 200)
    assert controller.state == a.GO and abs(controller.turn_cdeg_s) < 20  # far beyond the longest leg
    assert controller.speed_mm_s == 200
    guided(controller, 6000, CARRIED, 40)
    assert controller.speed_mm_s == 0 and controller.turn_cdeg_s == 6000
    assert guided(controller, DIRECTION_NONE, CARRIED, 40).state == a.SEARCH
    assert guided(controller, 0, CARRIED, 1).state == a.GO
    assert settle(controller, NO_MARKER, 120).state == a.SEARCH  # an old word is good for a leg
