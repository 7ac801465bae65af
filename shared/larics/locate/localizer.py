"""The vehicle in the map: from what the camera measured, frame by frame, in integers only.

TRACKING  measured in this frame, from every marker that fits
COASTING  no usable marker; carried on at the last speed and turn rate, with a growing sigma
CARRIED   no usable marker; carried on by the vehicle's odometry, for as long as its sigma allows
LOST      nothing to go by; the numbers are the last known ones

Which markers are believed, larics.locate.matching decides. Sigma is that of the detections or, where they
tell none, the scatter of the places, and, since they do not scatter, the standard deviations that calibration
and map tell of themselves; with odometry it grows as larics.locate.carrier says.
All values stay within +-2**30 and a frame allocates nothing.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import wrap_cdeg
from larics.locate.carrier import Carrier, Fix
from larics.locate.coasting import Coasting
from larics.locate.matching import MAX_MARKERS, Gate, Matching
from larics.locate.motion import direction_cdeg
from larics.locate.uncertainty import OdometryNoise, Systematic, root_of_squares
from larics.marker.detection import NO_SIGMA
from larics.wire.messages import (
    CARRIED,
    COASTING,
    COUNT_MAX,
    ID_NONE,
    LOST,
    MOTION_NONE,
    SIGMA_UNKNOWN,
    TRACKING,
    WAY_UNKNOWN,
)

SILENT_US = const(1000000)  # without a processed frame, nothing is tracked any more
_CARRIED_MM10 = const(10000)  # carried on by odometry up to this sigma ...
_CARRIED_CDEG = const(3500)  # ... and this: then LOST, since a guess at the speed is no better
_MOST_SIGMA = const(20000)
_SEEN = const(5)  # of larics.locate.matching; a step of range() that is not known here would be allocated


class Localizer:
    """Pose of the vehicle in a MarkerMap.

    coast_us        how long to carry on without a marker and without odometry before LOST
    speed_mm_s      fastest drive: how far two frames may lie apart that agree on an unexpected place
    tolerance_q8    how far the ring's size may contradict the marker's known height, 1/256 of it
    systematic, odometry_noise   of larics.locate.uncertainty; None: the usual ones

    After `update`: state, x_mm10, y_mm10, heading_cdeg (0..35999), sigma_x_mm10, sigma_y_mm10, sigma_mm10
    (the larger one), sigma_cdeg (all SIGMA_UNKNOWN when LOST), correlation_q14 of x and y, way_mm since the
    last measurement by odometry (WAY_UNKNOWN without), age_us since then, marker_id and entry of that one
    (ID_NONE and -1 before the first), fault (0, or why a marker of this frame was refused). carried: whether
    odometry told of this frame; carrier.shares.doubted: whether odometry is ignored, since it contradicts the
    markers.

    No properties: with one, MicroPython needs five times as long for each attribute that is set.
    """

    def __init__(
        self, marker_map, coast_us=3000000, speed_mm_s=2000, tolerance_q8=20, systematic=None,
        odometry_noise=None,
    ):  # fmt: skip
        self.map = marker_map
        self.coast_us = coast_us
        self.state = LOST
        self.x_mm10 = self.y_mm10 = self.heading_cdeg = 0
        self.age_us = COUNT_MAX
        self.marker_id = ID_NONE
        self.entry = -1
        self.fault = 0
        self.carrier = Carrier(odometry_noise or OdometryNoise())
        self.carried = False
        self.matching = Matching(marker_map, speed_mm_s, tolerance_q8)
        self._systematic = systematic or Systematic()
        self._coasting = Coasting(speed_mm_s)
        self._gate = Gate()
        self._last = Fix()
        self._guess = array("i", [0] * 3)  # prediction for this frame
        self._frame_us = 0
        self._fix_us = 0  # time of the last measurement
        self._know_nothing()

    def refused(self, marker_id):
        """Whether a marker with this ID was refused in the last frame."""
        return self.matching.refused(marker_id)

    def update(self, measurements, count, time_us, odometry=None):
        """Takes the first `count` Measurements of a frame captured at time_us (any clock modulo 2**30).

        odometry: larics.locate.odometry.Odometry, set to that time, of a vehicle that tells it.
        Returns the state. Call it for every frame, also for those without a marker."""
        count = min(count, MAX_MARKERS)
        self.matching.begin(time_us, self.coast_us)
        passed_us = (time_us - self._fix_us) & COUNT_MAX
        if self.age_us == COUNT_MAX or passed_us > COUNT_MAX >> 1:
            passed_us = COUNT_MAX
        self.age_us = passed_us
        self._frame_us = time_us & COUNT_MAX
        self.carried = self._is_carried(odometry, time_us)  # or, when it has been for too long, LOST
        if self.state != LOST:
            self.state = CARRIED if self.carried else COASTING
        if self.state == COASTING and passed_us > self.coast_us:
            self._lose()
        if self.state == COASTING:
            self._coast(passed_us // 100)
        elif self.state == CARRIED:
            self._expect_carried()
        used = 0
        if count:
            used = self._match(measurements, count, time_us, passed_us)
        if used == 0:
            if self.state == CARRIED:
                self._tell_carried()
            elif self.state == COASTING:
                guess = self._guess
                self.x_mm10, self.y_mm10 = guess[0], guess[1]
                self.heading_cdeg = guess[2] % 36000
        self.fault = self.matching.fault
        return self.state

    def _match(self, measurements, count, time_us, passed_us):
        """Takes what fits into the pose; returns how many measurements."""
        matching, lost = self.matching, self.state == LOST
        used = 0 if lost else matching.match(measurements, count, self._guess, self._gate)
        moved = used == 0
        if moved:
            used = matching.relocate(measurements, count, time_us, lost)
            if used:
                # when the frame before agreed, it tells the speed
                self._coasting.begin(matching.before if matching.has_before else None)
                passed_us = COUNT_MAX
                if matching.has_before:
                    passed_us = (time_us - matching.before_us) & COUNT_MAX
        if used:
            self._fix(measurements, used, passed_us, moved and not lost)
            self._fix_us = time_us & COUNT_MAX
        return used

    def _is_carried(self, odometry, time_us):
        """Whether odometry carries the pose on to this frame, with a sigma that is still of use."""
        carrier = self.carrier
        if odometry is None or odometry.state == MOTION_NONE or not carrier.move(odometry, time_us):
            return False
        if carrier.shares.doubted:
            return False
        sigma_mm10 = max(carrier.sigma_x_mm10, carrier.sigma_y_mm10)
        if sigma_mm10 <= _CARRIED_MM10 and carrier.sigma_cdeg <= _CARRIED_CDEG:
            return True
        if self.state != LOST:
            self._lose()
        return False

    def _expect_carried(self):
        """The pose that odometry tells becomes the prediction.

        Nothing that the odometry did not see has moved the vehicle."""
        guess, carrier = self._guess, self.carrier
        guess[0], guess[1] = carrier.x_mm10, carrier.y_mm10
        guess[2] = carrier.heading_cdeg
        self._gate.open_for_way(
            max(carrier.sigma_x_mm10, carrier.sigma_y_mm10), carrier.sigma_cdeg, carrier.way_mm
        )

    def _tell_carried(self):
        """No marker says better: it is the pose."""
        carrier = self.carrier
        self.x_mm10, self.y_mm10 = carrier.x_mm10, carrier.y_mm10
        self.heading_cdeg = carrier.heading_cdeg
        self.sigma_x_mm10, self.sigma_y_mm10 = carrier.sigma_x_mm10, carrier.sigma_y_mm10
        self.sigma_mm10 = max(carrier.sigma_x_mm10, carrier.sigma_y_mm10)
        self.sigma_cdeg, self.correlation_q14 = carrier.sigma_cdeg, carrier.correlation_q14
        self.way_mm = carrier.way_mm

    def _coast(self, time_h):
        """The last measurement carried on becomes the prediction; sigma grows with the time since then."""
        coasting, last, gate = self._coasting, self._last, self._gate
        coasting.predict(self._guess, time_h)
        sigma_mm10, sigma_cdeg = last.sigma_mm10, last.sigma_cdeg
        gate.open_for_time(sigma_mm10, sigma_cdeg, time_h, coasting.speed_mm_s if coasting.known < 2 else 0)
        self._tell_round(sigma_mm10 + coasting.grown_mm10(time_h), sigma_cdeg + coasting.grown_cdeg(time_h))

    def _tell_round(self, sigma_mm10, sigma_cdeg):
        """x and y are alike."""
        self.sigma_mm10 = self.sigma_x_mm10 = self.sigma_y_mm10 = sigma_mm10
        self.sigma_cdeg = sigma_cdeg
        self.correlation_q14 = 0
        self.way_mm = WAY_UNKNOWN

    def pass_time(self, time_us):
        """Call it between frames, at least every five minutes: without them the state goes on with the time.

        time_us: now, by the clock of the frames. Returns the state. Without a frame for SILENT_US, TRACKING
        becomes COASTING, and that LOST in its time; place and heading stay those of the last frame."""
        passed_us = (time_us - self._fix_us) & COUNT_MAX
        if passed_us > COUNT_MAX >> 1:
            self.age_us = COUNT_MAX  # before the clock has gone round
        silent_us = (time_us - self._frame_us) & COUNT_MAX
        if self.state == CARRIED and silent_us <= SILENT_US:
            return self.state
        if self.state != LOST:
            if passed_us > self.coast_us:
                self._lose()
            elif passed_us > SILENT_US and self.state == TRACKING:
                self.state = COASTING
        self.matching.pass_time(time_us, self.coast_us)
        return self.state

    def _lose(self):
        self.state = LOST
        self._know_nothing()
        self.matching.forget()
        self.carried = False

    def _know_nothing(self):
        self._tell_round(SIGMA_UNKNOWN, SIGMA_UNKNOWN)

    def bearing_cdeg(self, x_mm10, y_mm10):
        """Direction of a place of the map in the vehicle frame, 0..35999."""
        return (direction_cdeg(x_mm10 - self.x_mm10, y_mm10 - self.y_mm10) - self.heading_cdeg) % 36000

    def _fix(self, measurements, used, passed_us, moved):
        """The mean of the first `used` places becomes the pose; what can be is learned from it."""
        seen, last = self.matching.seen, self._last
        x = y = turned = 0
        for at in range(0, _SEEN * used, _SEEN):
            x += seen[at] - seen[0]
            y += seen[at + 1] - seen[1]
            turned += wrap_cdeg(seen[at + 2] - seen[2])
        last.x_mm10 = self.x_mm10 = seen[0] + x // used
        last.y_mm10 = self.y_mm10 = seen[1] + y // used
        last.heading_cdeg = self.heading_cdeg = (seen[2] + turned // used) % 36000
        last.entry = self.entry = seen[3]
        last.moved = moved
        self.marker_id = self.map.ids[self.entry]
        first = measurements[seen[4]]
        self._coasting.measured(last, passed_us, passed_us <= self.coast_us, self._is_told(first))
        self._weigh(measurements, used)
        last.sigma_mm10 = root_of_squares(last.scatter_mm10, last.certain_mm10)
        last.sigma_cdeg = root_of_squares(last.scatter_cdeg, last.certain_cdeg)
        self.carrier.fix(last)
        self._tell_round(last.sigma_mm10, last.sigma_cdeg)
        if self.carried:
            self.way_mm = 0
        self.age_us = 0
        self.matching.forget()
        self.state = TRACKING

    def _is_told(self, measurement):
        """Whether the detection knows how sure it is: nobody needs to find out how its values scatter."""
        return measurement.sigma_mm10 != NO_SIGMA and measurement.sigma_mdeg != NO_SIGMA

    def _weigh(self, measurements, used):
        """How sure the markers themselves are of a frame's place and heading, and how far calibration and map
        may have put them off: as the least sure of them."""
        seen, last, coasting = self.matching.seen, self._last, self._coasting
        systematic, marker_map = self._systematic, self.map
        last.scatter_mm10 = last.scatter_cdeg = last.certain_mm10 = last.certain_cdeg = 0
        for at in range(0, _SEEN * used, _SEEN):
            measurement, entry = measurements[seen[at + 4]], seen[at + 3]
            sigma_mm10, sigma_mdeg = measurement.sigma_mm10, measurement.sigma_mdeg
            told_mm10 = coasting.scatter_mm10 if sigma_mm10 == NO_SIGMA else min(_MOST_SIGMA, sigma_mm10)
            told_cdeg = min(18000, (sigma_mdeg + 5) // 10)
            if sigma_mdeg == NO_SIGMA:
                told_cdeg = coasting.scatter_cdeg
            map_cdeg = marker_map.sigma_cdeg[entry]
            certain_mm10 = systematic.of_place(measurement, marker_map.sigma_mm10[entry], map_cdeg)
            last.scatter_mm10 = max(last.scatter_mm10, told_mm10)
            last.scatter_cdeg = max(last.scatter_cdeg, told_cdeg)
            last.certain_mm10 = max(last.certain_mm10, certain_mm10)
            last.certain_cdeg = max(last.certain_cdeg, systematic.of_heading(map_cdeg))
