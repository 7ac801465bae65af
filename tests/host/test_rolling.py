"""What a rolling shutter does to a marker, by the renderer's exact camera, is undone."""

import math

import numpy as np
import pytest

from larics.locate.camera_model import Camera as Locator
from larics.locate.camera_model import Measurement
from larics.locate.rolling import RollingShutter
from larics.marker.detection import Detection
from larics_host.render.camera import Camera, Motion, Pose
from tests.host.small_int import Small

CEILING_MM, FOCAL_PX, LINE_MM = 3000.0, 671.75, 214.5


class Told:
    """What larics.locate.odometry.Odometry tells of an exposure."""

    state, epoch, jumps = 1, 1, 0

    def __init__(self, pose, epoch=1):
        self.x_mm10, self.y_mm10 = round(pose.x_mm * 10), round(pose.y_mm * 10)
        self.heading_cdeg = round(pose.heading_deg * 100) % 36000
        self.epoch = epoch


def measured(camera, locator, pose, motion, direction_deg):
    """The Measurement of a marker at (300, 200) mm with an orientation line in that direction."""
    angle = math.radians(direction_deg)
    ends = np.array([[300.0, 200.0], [300.0 + LINE_MM * math.cos(angle), 200.0 + LINE_MM * math.sin(angle)]])
    (x, y), (end_x, end_y) = camera.capture(ends, CEILING_MM, pose, motion)[0]
    seen, out = Detection(), Measurement()
    seen.marker_id, seen.x_q8, seen.y_q8 = 3, round(x * 256), round(y * 256)
    seen.heading_cdeg = round(math.degrees(math.atan2(y - end_y, end_x - x)) * 100) % 36000
    seen.radius_q8 = round(FOCAL_PX * 150 / CEILING_MM * 256)
    assert locator.locate(seen, out)
    return out


def off(one, other):
    """Distance in mm and difference of the headings in degrees."""
    turned = (one.heading_cdeg - other.heading_cdeg + 18000) % 36000 - 18000
    distance = math.hypot(one.offset_x_mm10 - other.offset_x_mm10, one.offset_y_mm10 - other.offset_y_mm10)
    return distance / 10, abs(turned) / 100


@pytest.mark.parametrize("mount_deg", (0.0, 90.0))
@pytest.mark.parametrize("row_us", (25.0, -25.0))
def test_a_marker_is_where_it_was_in_the_middle_of_the_exposure(mount_deg, row_us):
    options = {"width": 360, "height": 296, "focal_px": FOCAL_PX, "mounting_deg": mount_deg}
    rolling, still = Camera(**options, row_us=row_us), Camera(**options)
    focal_q8, mount_cdeg = round(FOCAL_PX * 256), round(mount_deg * 100)
    locator = Locator(360, 296, focal_q8, mount_cdeg=mount_cdeg, ceiling_mm10=30000)
    worst, uncorrected = np.zeros(2), np.zeros(2)
    for speed, left, turn in ((1500, 0, 0), (-800, 300, 20), (100, 0, 90), (0, 0, -90)):
        motion = Motion(speed, left, turn)
        for direction_deg in range(0, 360, 45):
            pose = Pose(160.0, -60.0, 30.0)
            true = measured(still, locator, pose, motion, direction_deg)
            found = measured(rolling, locator, pose, motion, direction_deg)
            uncorrected = np.maximum(uncorrected, off(found, true))
            undo = RollingShutter(round(row_us * 1000), focal_q8, mount_cdeg)
            undo.follow([], 0, 0, Told(motion.pose_after(pose, -0.02)))
            undo.follow([found], 1, 20000, Told(pose))
            worst = np.maximum(worst, off(found, true))
    assert uncorrected[0] > 1 and uncorrected[1] > 0.2
    assert worst[0] < 0.25 and worst[1] < 0.03, worst


def test_without_a_motion_that_is_known_nothing_is_changed():
    camera = Camera(width=360, height=296, focal_px=FOCAL_PX, row_us=25.0)
    locator = Locator(360, 296, round(FOCAL_PX * 256), ceiling_mm10=30000)
    pose, motion = Pose(160.0, -60.0, 30.0), Motion(1500.0)
    before, jumped = Told(motion.pose_after(pose, -0.02)), Told(pose, epoch=2)
    for first, second, later_us, is_changed in (
        (before, Told(pose), 20000, True),
        (before, Told(pose), 500000, True),
        (before, Told(pose), 500001, False),
        (before, jumped, 20000, False),
        (before, None, 20000, False),
        (None, Told(pose), 20000, False),
        (Told(pose), Told(pose), 20000, False),
    ):
        found = measured(camera, locator, pose, motion, 45)
        undo = RollingShutter(25000, round(FOCAL_PX * 256))
        undo.follow([], 0, 0, first)
        undo.follow([found], 1, later_us, second)
        assert (off(found, measured(camera, locator, pose, motion, 45)) != (0, 0)) == is_changed


def changed(x_mm10, heading_cdeg, later_us, offset_mm10=3000):
    """Whether a motion since a frame before changes a marker so far off."""
    undo, one = RollingShutter(25000, round(FOCAL_PX * 256)), Measurement()
    undo.follow([], 0, 0, Told(Pose(0.0, 0.0, 0.0)))
    one.offset_x_mm10, one.row_q8, one.height_mm10, one.radius_q8 = offset_mm10, 20000, 30000, 8600
    undo.follow([one], 1, later_us, Told(Pose(x_mm10 / 10, 0.0, heading_cdeg / 100)))
    return (one.offset_x_mm10, one.heading_cdeg) != (offset_mm10, 0)


def test_what_no_vehicle_does_and_markers_far_off_are_left_alone():
    assert changed(8000, 0, 100000) and not changed(8001, 0, 100000)  # 8 m/s
    assert changed(-8000, 0, 100000) and not changed(-8001, 0, 100000)
    assert changed(0, 3000, 100000) and not changed(0, 3001, 100000)  # 300 degrees/s
    assert changed(0, -3000, 100000) and not changed(0, -3001, 100000)
    assert changed(80, 0, 999) and not changed(81, 0, 999)  # below a millisecond
    assert changed(1000, 0, 20000, 30000) and not changed(1000, 0, 20000, 30001)
    assert not changed(0, 0, 20000)


def test_shear_is_within_30_bits():
    for row_ns, above_mm10 in ((200000, 10), (-200000, 3000)):
        undo, one = RollingShutter(Small(row_ns), Small(1048575), Small(4500)), Measurement()
        one.height_mm10 = Small(above_mm10)
        undo._items[2] = 1
        undo._correct(one)
        assert abs(undo._items[6]) == 14325
