"""The pose carried by odometry, on both interpreters: the same numbers, and nothing allocated."""

from larics.arith.fixed import cos_q14, sin_q14, turn16_from_cdeg
from larics.locate.camera_model import Measurement
from larics.locate.localizer import Localizer
from larics.locate.marker_map import MarkerMap
from larics.wire.messages import CARRIED, MOTION_INTERPOLATED, TRACKING

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

FRAME_US = 50000
ROWS = ((1, 0, 0, 0), (2, 2500, 0, 9000, 0, 0, 15, 20), (3, 5000, 0, 0), (4, 7500, 0, 18000))


class Drive:
    """Straight along the markers, 1 m/s; odometry tells 1 % less and turns by 0.1 degrees a metre."""

    def __init__(self):
        self.state, self.epoch, self.jumps = MOTION_INTERPOLATED, 1, 0
        self.x_mm10 = self.y_mm10 = self.heading_cdeg = 0
        self.true_mm10 = -3000
        self.one = Measurement()
        self.seen = [self.one]
        self.found = Localizer(MarkerMap(ROWS))
        self.frame = 0

    def step(self, way_mm10=500):
        """A frame; returns the state."""
        self.true_mm10 += way_mm10
        told = way_mm10 * 99 // 100
        self.heading_cdeg = self.true_mm10 // 1000 % 36000
        turn16 = turn16_from_cdeg(self.heading_cdeg)
        self.x_mm10 += told * cos_q14(turn16) >> 14
        self.y_mm10 += told * sin_q14(turn16) >> 14
        self.frame += 1
        one, count = self.one, 0
        for entry in range(4):
            ahead = entry * 25000 - self.true_mm10
            if abs(ahead) < 6000:
                count = 1
                one.marker_id = entry + 1
                one.offset_x_mm10, one.offset_y_mm10 = ahead, 0
                one.heading_cdeg = self.found.map.heading_cdeg[entry]
                one.height_mm10 = one.ring_height_mm10 = 30000
                one.sigma_mm10, one.sigma_mdeg = 5, 40
        return self.found.update(self.seen, count, self.frame * FRAME_US, self)


def test_the_same_numbers_on_both_interpreters_and_nothing_allocated():
    drive = Drive()
    for _ in range(60):
        drive.step()
    carried = tracking = odd = 0
    heap_lock()
    try:
        for _ in range(75):
            state = drive.step()
            carried += state == CARRIED
            tracking += state == TRACKING
            odd += drive.found.sigma_mm10 > 1000
    finally:
        heap_unlock()
    found, shares = drive.found, drive.found.carrier.shares
    assert (carried, tracking, odd) == (45, 30, 0), (carried, tracking, odd)
    numbers = [found.x_mm10, found.y_mm10, found.heading_cdeg, found.sigma_x_mm10, found.sigma_y_mm10]
    numbers += [found.sigma_cdeg, found.correlation_q14, found.way_mm]
    for share in (shares.scale, shares.turn, shares.drift):
        numbers += [share.value_q20, share.sigma_q20]
    assert numbers == [64477, -7, 0, 33, 36, 14, 561, 889, 10486, 256, 0, 7340, -1818, 627], numbers


def test_a_long_way_without_a_marker_ends_where_sigma_is_of_no_use():
    drive = Drive()
    while drive.step() != CARRIED:
        pass
    drive.one.marker_id = -1
    frames, drive.true_mm10 = 0, 1 << 20  # no marker there
    while drive.step() == CARRIED:
        frames += 1
    assert 100 < frames < 1000, frames
