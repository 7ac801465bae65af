"""larics.locate.navigator on both interpreters: pose, route and the direction to go on."""

from larics.locate.camera_model import Measurement
from larics.locate.navigator import Navigator
from larics.locate.route import MISSED, ON_ROUTE, SAME
from larics.wire.messages import (
    CARRIED,
    COASTING,
    DIRECTION_NONE,
    FAULT_MARKER_PLACE,
    FAULT_ROUTE,
    LOST,
    MOTION_INTERPOLATED,
    ROUTE_NONE,
    TRACKING,
)

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

# a row of markers 2 m apart, each with its orientation line towards the next, the last one back
ROWS = [(k, 2000 * k, 0, 0 if k < 5 else 18000) for k in range(1, 6)]
ROUTE = (1, 2, 3, 4, 5, 4, 3, 2, 1)
FRAME_US = 50000


def seen(marker_id, x_mm10, heading_cdeg, y_mm10=0):
    out = Measurement()
    out.marker_id, out.offset_x_mm10, out.offset_y_mm10 = marker_id, x_mm10, y_mm10
    out.heading_cdeg, out.height_mm10, out.ring_height_mm10 = heading_cdeg, 30000, 30000
    return out


class Odometry:
    """What the wheels say: straight on."""

    state, epoch, jumps = MOTION_INTERPOLATED, 1, 0
    x_mm10 = y_mm10 = heading_cdeg = 0


class Drive:
    """A vehicle that drives along the row at 1 m/s, seeing what is within 700 mm."""

    def __init__(self, start=-1, missing=(), odometry=None):
        self.odometry = odometry
        self.navigator = Navigator(ROWS, ROUTE, start=start)
        self.missing = missing
        self.x_mm = 1000
        self.frame = 0
        self.events = []

    def to(self, x_mm):
        step = 50 if x_mm > self.x_mm else -50
        heading = 0 if step > 0 else 18000
        while self.x_mm != x_mm:
            self.x_mm += step
            self.frame += 1
            view = [
                seen(row[0], (row[1] - self.x_mm) * (10 if step > 0 else -10), (row[3] - heading) % 36000)
                for row in ROWS
                if abs(row[1] - self.x_mm) < 700 and row[0] not in self.missing
            ]
            if self.odometry is not None:
                self.odometry.x_mm10 += abs(step) * 10
            self.navigator.update(view, len(view), self.frame * FRAME_US, self.odometry)
            if self.navigator.event != SAME:
                self.events.append((self.navigator.event, self.navigator.route_position))
        return self


def test_a_lap_of_the_route():
    drive = Drive(start=0).to(10000)
    assert drive.events == [(ON_ROUTE, k) for k in range(5)]
    assert drive.navigator.pose.state == TRACKING and drive.navigator.next_cdeg == 18000
    drive.to(2000)
    assert drive.events[5:] == [(ON_ROUTE, k) for k in (5, 6, 7, 0)]
    assert drive.navigator.next_cdeg == 18000  # vehicle still heads away from marker 2


def test_between_markers_the_direction_is_that_of_the_next_one():
    drive = Drive(start=0).to(5000)
    navigator = drive.navigator
    assert navigator.pose.state == COASTING
    assert navigator.next_cdeg < 100 or navigator.next_cdeg > 35900
    for k in range(100):
        navigator.update([], 0, (drive.frame + k) * FRAME_US)
    assert navigator.pose.state == LOST and navigator.next_cdeg == DIRECTION_NONE
    assert navigator.route_position == 1  # still known: 2 was the last one


def test_a_missing_marker_is_a_fault_and_the_route_goes_on():
    drive = Drive(start=0, missing=(3,)).to(7900)
    assert drive.events == [(ON_ROUTE, 0), (ON_ROUTE, 1), (MISSED, 3)]
    assert drive.navigator.fault == 0  # told in the frame that showed it, not for ever
    drive = Drive(start=0, missing=(3,)).to(7300)
    while drive.navigator.event == SAME:
        drive.to(drive.x_mm + 50)
    assert drive.navigator.fault == FAULT_ROUTE


def test_an_impossible_marker_moves_neither_pose_nor_route():
    drive = Drive(start=0).to(4000)
    navigator = drive.navigator
    at = drive.frame * FRAME_US
    assert navigator.update([seen(5, 0, 0)], 1, at + FRAME_US) == COASTING
    assert navigator.fault == FAULT_MARKER_PLACE and navigator.route_position == 1
    for k in range(2, 4):
        navigator.update([seen(5, 0, 0)], 1, at + k * FRAME_US)
    # three frames agree: the vehicle was moved there, past markers 3 and 4
    assert navigator.pose.state == TRACKING and navigator.event == MISSED and navigator.route_position == 4
    assert navigator.fault == FAULT_MARKER_PLACE


def test_without_a_route_there_is_no_direction():
    navigator = Navigator(ROWS)
    for k in range(3):
        navigator.update([seen(2, 0, 0)], 1, k * FRAME_US)
    assert navigator.pose.state == TRACKING
    assert (navigator.route_position, navigator.next_cdeg) == (ROUTE_NONE, DIRECTION_NONE)


def test_size_and_height_come_from_the_map():
    navigator = Navigator([(3, 0, 0, 0, 28000, 750), (4, 2000, 0, 0)], outer_mm10=1500)
    assert (navigator.outer_mm10(3), navigator.z_mm10(3)) == (750, 28000)
    assert (navigator.outer_mm10(4), navigator.z_mm10(4)) == (1500, 0)
    assert (navigator.outer_mm10(7), navigator.z_mm10(-1)) == (1500, 0)


def test_a_frame_allocates_nothing():
    navigator = Navigator(ROWS, ROUTE)
    views = [[seen(1, 0, 0)], [seen(2, 0, 0), seen(3, 5000, 0)], [], [seen(5, 100, 0), seen(4, 0, 0)]]
    navigator.update(views[0], 1, 0)
    heap_lock()
    try:
        for k in range(60):
            view = views[k // 5 % 4]
            navigator.update(view, len(view), k * FRAME_US)
    finally:
        heap_unlock()


def test_with_odometry_a_missing_marker_is_passed_by():
    """The next direction points to its place, and from there on to the marker after it."""
    drive = Drive(missing=(3,), odometry=Odometry())
    navigator = drive.to(5700).navigator
    assert navigator.route_position == 1 and navigator.next_cdeg == 0 and navigator.pose.state == CARRIED
    navigator = drive.to(5950).navigator
    assert navigator.route_position == 2 and navigator.route.missed == 1 and navigator.event == SAME
    assert drive.events[-1][0] == MISSED
    assert navigator.next_cdeg == 0  # to marker 4
    navigator = drive.to(8000).navigator
    assert navigator.route_position == 3 and drive.events[-1][0] == ON_ROUTE


def test_without_odometry_or_beside_its_place_nobody_knows_that_it_is_missing():
    drive = Drive(missing=(3,))
    assert drive.to(6300).navigator.route_position == 1
    drive = Drive(missing=(3,), odometry=Odometry())
    drive.to(5000)
    drive.odometry.y_mm10 += 3000
    assert drive.to(7000).navigator.route_position == 1


def test_a_marker_that_is_seen_is_not_passed_by():
    drive = Drive(odometry=Odometry())
    drive.to(7900)
    assert MISSED not in [event for event, _ in drive.events] and drive.navigator.route_position == 3
