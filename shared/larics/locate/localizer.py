"""The vehicle in the map: from what the camera measured, frame by frame, in integers only.

TRACKING  measured in this frame, from every marker that fits
COASTING  no usable marker; carried on at the last speed and turn rate, with a growing sigma
CARRIED   no usable marker; carried on by the vehicle's odometry, for as long as its sigma allows
LOST      nothing to go by; the numbers are the last known ones

A marker that cannot be is never believed silently. One that is not in the map, that has the wrong size
for its height, or that would put the vehicle where it cannot have come, is refused and named by `fault`.
Only when several frames in a row agree on the new place, was the vehicle really moved there.
Sigma is the scatter of the measurements and, since they do not scatter, the standard deviations that
calibration and map tell of themselves; with odometry it grows as larics.locate.carrier says.
All values stay within +-2**30 and a frame allocates nothing.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import cos_q14, sin_q14, turn16_from_cdeg, wrap_cdeg
from larics.locate.carrier import Carrier
from larics.locate.motion import Motion, direction_cdeg, grown, times_q14
from larics.locate.noise import Residuals
from larics.locate.uncertainty import OdometryNoise, Systematic, root_of_squares
from larics.wire.messages import (
    CARRIED,
    COASTING,
    COUNT_MAX,
    FAULT_MARKER_HEIGHT,
    FAULT_MARKER_PLACE,
    FAULT_MARKER_UNKNOWN,
    ID_NONE,
    LOST,
    MOTION_NONE,
    SIGMA_UNKNOWN,
    TRACKING,
)

MAX_MARKERS = const(8)  # used of one frame
SILENT_US = const(1000000)  # without a processed frame, nothing is tracked any more
_AGREE_LOST = const(2)  # frames (or markers) that must agree on a place when there was none, or it is far
_AGREE_MOVED = const(3)  # ... and when the place contradicts what was known
_SURE_MM10 = const(3000)  # one frame alone may correct the prediction by so much ...
_SURE_CDEG = const(3000)  # ... and so much
_GATE_MM10 = const(500)  # a measurement may differ from the prediction by this, 6 sigma, and what an
_GATE_CDEG = const(500)  # acceleration makes of the time since the last one:
_ACCELERATION_MM10_S2 = const(50000)
_TURN_ACCELERATION_CDEG_S2 = const(72000)
_COAST_ACCELERATION_MM10_S2 = const(3000)  # typical, not possible: for sigma while coasting
_COAST_TURN_CDEG_S2 = const(6000)
_FLOOR_MM10 = const(3)
_FLOOR_CDEG = const(2)
_START_MM10 = const(20)  # sigma before there are residuals
_START_CDEG = const(15)
_CARRIED_MM10 = const(10000)  # carried on by odometry up to this sigma ...
_CARRIED_CDEG = const(3500)  # ... and this: then LOST, since a guess at the speed is no better


class Localizer:
    """Pose of the vehicle in a MarkerMap.

    coast_us        how long to carry on without a marker before LOST
    speed_mm_s      fastest drive: how far two frames may lie apart that agree on an unexpected place
    tolerance_q8    how far the ring's size may contradict the marker's known height, 1/256 of it
    systematic, odometry_noise   of larics.locate.uncertainty; None: the usual ones

    After `update`: state, x_mm10, y_mm10, heading_cdeg (0..35999), sigma_mm10, sigma_cdeg (SIGMA_UNKNOWN
    when LOST), age_us since the last measurement, marker_id and entry of that one (ID_NONE and -1 before
    the first), fault (0, or why a marker of this frame was refused). `carrier` has the covariance while
    `carried` says that it has one.
    """

    def __init__(
        self, marker_map, coast_us=3000000, speed_mm_s=2000, tolerance_q8=20, systematic=None,
        odometry_noise=None,
    ):  # fmt: skip
        self.map = marker_map
        self.coast_us = coast_us
        self.speed_mm_s = speed_mm_s
        self.tolerance_q8 = tolerance_q8
        self.state = LOST
        self.x_mm10 = self.y_mm10 = self.heading_cdeg = 0
        self.sigma_mm10 = self.sigma_cdeg = SIGMA_UNKNOWN
        self.age_us = COUNT_MAX
        self.marker_id = ID_NONE
        self.entry = -1
        self.hint = -1  # entry that the route expects: decides between places of the same ID
        self.fault = 0
        self.carrier = Carrier(odometry_noise or OdometryNoise())
        self._systematic = systematic or Systematic()
        self._certain_mm10 = self._certain_cdeg = 0  # systematic standard deviations of this frame's place
        self.carried = False
        self._frame_us = 0
        self._fix_us = 0  # time of the last measurement, and what it said
        self._motion = Motion()
        self._history = array("i", [0] * 7)  # the measurement before the last: x, y, heading, 100 us to the
        # next; the last: x, y, heading
        self._known = 0
        self._told_mm10 = self._told_cdeg = 0
        self._noise = (Residuals(_START_MM10), Residuals(_START_MM10), Residuals(_START_CDEG))
        self._guess = array("i", [0] * 3)  # prediction for this frame
        self._seen = array("i", [0] * (4 * MAX_MARKERS))  # x, y, heading, entry of each accepted marker
        self._there = array("i", [0] * 3)  # the new place that several frames must agree on
        self._there_us = 0
        self._agreed = 0
        self._refused_ids = array("i", [0] * MAX_MARKERS)  # of this frame
        self._refusals = 0
        self._doubtful = False  # a marker of this frame is possible, but too far off to be believed alone

    def refused(self, marker_id):
        """Whether a marker with this ID was refused in the last frame."""
        for index in range(self._refusals):
            if self._refused_ids[index] == marker_id:
                return True
        return False

    def update(self, measurements, count, time_us, odometry=None):
        """Takes the first `count` Measurements of a frame captured at time_us (any clock modulo 2**30).

        odometry: larics.locate.odometry.Odometry, set to that time, of a vehicle that tells it.
        Returns the state. Call it for every frame, also for those without a marker."""
        self.fault = 0
        self._refusals = 0
        self._doubtful = False
        passed_us = (time_us - self._fix_us) & COUNT_MAX
        if self.age_us == COUNT_MAX or passed_us > COUNT_MAX >> 1:
            passed_us = COUNT_MAX
        self.age_us = passed_us
        if (time_us - self._there_us) & COUNT_MAX > self.coast_us:
            self._agreed = 0
        self._frame_us = time_us & COUNT_MAX
        self.carried = self._is_carried(odometry)  # or, when it has been for too long, LOST
        if self.state != LOST:
            self.state = CARRIED if self.carried else COASTING
        if self.state == COASTING and passed_us > self.coast_us:
            self._lose()
        time_h = passed_us // 100
        if self.state == COASTING:
            self._predict(time_h)
        elif self.state == CARRIED:
            time_h = 0  # nothing that the odometry did not see has moved the vehicle
            self._take_carried()
        used = self._compare(measurements, min(count, MAX_MARKERS), time_h)
        if used == 0 and count:
            used = self._relocate(measurements, min(count, MAX_MARKERS), time_us)
            passed_us = (time_us - self._fix_us) & COUNT_MAX
        if used:
            self._hear(measurements, count)
            self._fix(used, time_us, passed_us)
        elif self.state == COASTING:
            self._coast(passed_us // 100)
        elif self.state == LOST:
            self.sigma_mm10 = self.sigma_cdeg = SIGMA_UNKNOWN
        return self.state

    def _is_carried(self, odometry):
        """Whether odometry carries the pose on to this frame, with a sigma that is still of use."""
        carrier = self.carrier
        if odometry is None or odometry.state == MOTION_NONE or not carrier.move(odometry):
            return False
        if carrier.doubted:
            return False
        sigma_mm10 = max(carrier.sigma_x_mm10, carrier.sigma_y_mm10)
        if sigma_mm10 <= _CARRIED_MM10 and carrier.sigma_cdeg <= _CARRIED_CDEG:
            return True
        if self.state != LOST:
            self._lose()
        return False

    def _take_carried(self):
        """The pose that odometry tells becomes the prediction, and the pose unless a marker says better."""
        guess, carrier = self._guess, self.carrier
        guess[0] = self.x_mm10 = carrier.x_mm10
        guess[1] = self.y_mm10 = carrier.y_mm10
        guess[2] = self.heading_cdeg = carrier.heading_cdeg
        self.sigma_mm10 = max(carrier.sigma_x_mm10, carrier.sigma_y_mm10)
        self.sigma_cdeg = carrier.sigma_cdeg

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
        if (time_us - self._there_us) & COUNT_MAX > self.coast_us:
            self._agreed = 0
        return self.state

    def _lose(self):
        self.state = LOST
        self.sigma_mm10 = self.sigma_cdeg = SIGMA_UNKNOWN
        self._agreed = 0
        self.carried = False

    def bearing_cdeg(self, x_mm10, y_mm10):
        """Direction of a place of the map in the vehicle frame, 0..35999."""
        return (direction_cdeg(x_mm10 - self.x_mm10, y_mm10 - self.y_mm10) - self.heading_cdeg) % 36000

    def _hear(self, measurements, count):
        """How sure the markers themselves are of a frame's place and heading, and how far calibration and map
        may have put them off: as the least sure of them."""
        self._told_mm10 = self._told_cdeg = self._certain_mm10 = self._certain_cdeg = 0
        systematic, marker_map = self._systematic, self.map
        for index in range(count):
            measurement = measurements[index]
            entry = marker_map.find(measurement.marker_id)
            if entry < 0 or self.refused(measurement.marker_id):
                continue
            self._told_mm10 = max(self._told_mm10, measurement.sigma_mm10)
            self._told_cdeg = max(self._told_cdeg, measurement.sigma_mdeg // 10)
            map_mm10, map_cdeg = marker_map.sigma_mm10[entry], marker_map.sigma_cdeg[entry]
            self._certain_mm10 = max(self._certain_mm10, systematic.of_place(measurement, map_mm10, map_cdeg))
            self._certain_cdeg = max(self._certain_cdeg, systematic.of_heading(map_cdeg))

    def _predict(self, time_h):
        """The last measurement carried on."""
        guess, history = self._guess, self._history
        guess[0], guess[1] = history[4], history[5]
        guess[2] = history[6]
        self._motion.carry(guess, time_h)

    def _usable(self, measurement, tell):
        """The first entry of a measurement that could be what it says; -1 otherwise, with a fault if told."""
        if measurement.marker_id < 0:
            return -1
        entry = self.map.find(measurement.marker_id)
        if entry < 0:
            if tell:
                self._refuse(FAULT_MARKER_UNKNOWN, measurement.marker_id)
            return -1
        difference = abs(measurement.ring_height_mm10 - measurement.height_mm10)
        if difference << 8 > self.tolerance_q8 * measurement.height_mm10:
            if tell:
                self._refuse(FAULT_MARKER_HEIGHT, measurement.marker_id)
            return -1
        return entry

    def _refuse(self, fault, marker_id):
        self.fault = fault
        if self._refusals < MAX_MARKERS and not self.refused(marker_id):
            self._refused_ids[self._refusals] = marker_id
            self._refusals += 1

    def _place(self, measurement, entry, at):
        """Where a measurement of this entry puts the vehicle, into self._seen[at:at + 4]."""
        marker_map, seen = self.map, self._seen
        heading = (marker_map.heading_cdeg[entry] - measurement.heading_cdeg) % 36000
        turn16 = turn16_from_cdeg(heading)
        sin, cos = sin_q14(turn16), cos_q14(turn16)
        x, y = measurement.offset_x_mm10, measurement.offset_y_mm10
        seen[at] = marker_map.x_mm10[entry] - times_q14(x, cos) + times_q14(y, sin)
        seen[at + 1] = marker_map.y_mm10[entry] - times_q14(x, sin) - times_q14(y, cos)
        seen[at + 2] = heading
        seen[at + 3] = entry

    def _is_near(self, at, pose, time_h, speed_mm_s, sure=False):
        """Whether self._seen[at:] is where a vehicle expected at `pose` can be after that time, when its
        speed was known up to speed_mm_s; `sure`: so near that it needs no second frame."""
        seen = self._seen
        lost = self.state == LOST
        reach = _GATE_MM10 + grown(_ACCELERATION_MM10_S2, time_h, 100000)
        reach += speed_mm_s * min(time_h, 10000) // 1000 + (0 if lost else 6 * min(self.sigma_mm10, 1000))
        if sure:
            reach = min(reach, _SURE_MM10)
        if abs(seen[at] - pose[0]) > reach or abs(seen[at + 1] - pose[1]) > reach:
            return False
        reach = _GATE_CDEG + (0 if lost else 6 * min(self.sigma_cdeg, 500))
        reach += grown(_TURN_ACCELERATION_CDEG_S2, time_h, 18000)
        if sure:
            reach = min(reach, _SURE_CDEG)
        return abs(wrap_cdeg(seen[at + 2] - pose[2])) <= reach

    def _compare(self, measurements, count, time_h):
        """Collects the measurements that fit the prediction; returns how many."""
        if self.state == LOST:
            return 0
        unknown_mm_s = self.speed_mm_s if self._known < 2 and not self.carried else 0
        used = 0
        for k in range(count):
            measurement = measurements[k]
            entry = self._usable(measurement, True)
            if entry < 0:
                continue
            possible = False
            while entry >= 0:
                self._place(measurement, entry, 4 * used)
                if self._is_near(4 * used, self._guess, time_h, unknown_mm_s, True):
                    used += 1
                    break
                possible = possible or self._is_near(4 * used, self._guess, time_h, unknown_mm_s)
                entry = self.map.find(measurement.marker_id, entry + 1)
            if entry >= 0:
                continue
            if possible:
                self._doubtful = True
            else:
                self._refuse(FAULT_MARKER_PLACE, measurement.marker_id)
        return used

    def _relocate(self, measurements, count, time_us):
        """A place without or against a prediction: counts until enough frames agree; then how many used."""
        lost = self.state == LOST
        there, seen = self._there, self._seen
        time_h = ((time_us - self._there_us) & COUNT_MAX) // 100
        found = 0
        for k in range(count):
            measurement = measurements[k]
            entry = self._usable(measurement, lost)
            if entry < 0:
                continue
            at = 4 * found
            if found:
                time_h = 0
            if not self._choose(measurement, entry, at, time_h):
                continue
            near = self._agreed and self._is_near(at, there, time_h, self.speed_mm_s)
            if found == 0:
                self._agreed = self._agreed + 1 if near else 1
                before_x, before_y = there[0], there[1]
                before_heading = there[2]
                moving = near
                there[0], there[1] = seen[0], seen[1]
                there[2] = seen[2]
                found = 1
            elif near:
                self._agreed += 1
                found += 1
        if found == 0:
            return 0
        before_us = self._there_us
        self._there_us = time_us
        expected = lost or self._doubtful
        if self._agreed < (_AGREE_LOST if expected else _AGREE_MOVED):
            return 0
        self._refusals = 0
        self._known = 0
        self._motion.stop()
        if moving:  # the frame before agreed, so it tells the speed
            history = self._history
            history[4], history[5] = before_x, before_y
            history[6] = before_heading
            self._fix_us = before_us
            self._known = 1
        return found

    def _choose(self, measurement, entry, at, time_h):
        """Places a measurement without prediction at its only place, or at that of its places which agrees
        with the frames before, or at the one the route expects; False when that leaves it open."""
        only = self.map.find(measurement.marker_id, entry + 1) < 0
        while entry >= 0:
            self._place(measurement, entry, at)
            if only or (self._agreed and self._is_near(at, self._there, time_h, self.speed_mm_s)):
                return True
            entry = self.map.find(measurement.marker_id, entry + 1)
        if self.hint >= 0 and self.map.ids[self.hint] == measurement.marker_id:
            self._place(measurement, self.hint, at)
            return True
        return False

    def _fix(self, used, time_us, passed_us):
        """The mean of the first `used` places becomes the pose; noise and speed are learned from it."""
        seen = self._seen
        x = y = turned = 0
        for at in range(0, 4 * used, 4):
            x += seen[at] - seen[0]
            y += seen[at + 1] - seen[1]
            turned += wrap_cdeg(seen[at + 2] - seen[2])
        self.x_mm10 = x = seen[0] + x // used
        self.y_mm10 = y = seen[1] + y // used
        self.heading_cdeg = heading = (seen[2] + turned // used) % 36000
        self.entry = seen[3]
        self.marker_id = self.map.ids[self.entry]
        history = self._history
        last_h = max(1, passed_us // 100)
        if self._known and passed_us <= self.coast_us:
            forward_h = history[3]
            turned = wrap_cdeg(heading - history[6])
            if self._known > 1:
                # what was driven before, turned as the vehicle has turned since: straight lines and arcs
                middle = turn16_from_cdeg(wrap_cdeg(heading - history[2]) // 2)
                sin, cos = sin_q14(middle), cos_q14(middle)
                dx, dy = history[4] - history[0], history[5] - history[1]
                before_x = times_q14(dy, sin) - times_q14(dx, cos)
                before_y = 0 - times_q14(dx, sin) - times_q14(dy, cos)
                self._noise[0].add(before_x, 0, x - history[4], forward_h, last_h)
                self._noise[1].add(before_y, 0, y - history[5], forward_h, last_h)
                self._noise[2].add(wrap_cdeg(history[2] - history[6]), 0, turned, forward_h, last_h)
            dx, dy = x - history[4], y - history[5]
            self._motion.learn(dx, dy, history[6], turned, last_h, self._known < 2)
            history[0], history[1] = history[4], history[5]
            history[2], history[3] = history[6], last_h
            self._known = 2
        else:
            for noise in self._noise:
                noise.reset()
            self._known = 1
        history[4], history[5] = x, y
        history[6] = heading
        self.sigma_mm10 = max(self._noise[0].sigma(_FLOOR_MM10), self._noise[1].sigma(_FLOOR_MM10))
        self.sigma_mm10 = min(20000, max(self.sigma_mm10, self._told_mm10))
        self.sigma_cdeg = min(18000, max(self._noise[2].sigma(_FLOOR_CDEG), self._told_cdeg))
        carrier = self.carrier
        if carrier.begun:
            carrier.fix(
                x, y, heading, self.sigma_mm10, self.sigma_cdeg, self._certain_mm10, self._certain_cdeg
            )
        self.sigma_mm10 = root_of_squares(self.sigma_mm10, self._certain_mm10)
        self.sigma_cdeg = root_of_squares(self.sigma_cdeg, self._certain_cdeg)
        self._fix_us = time_us & COUNT_MAX
        self.age_us = 0
        self._agreed = 0
        self.state = TRACKING

    def _coast(self, time_h):
        guess = self._guess
        self.x_mm10, self.y_mm10 = guess[0], guess[1]
        self.heading_cdeg = guess[2] % 36000
        noise = self._noise
        # whether a turn ended or went on is not known, so what it takes to turn counts as unknown, too
        scatter_mm10 = max(noise[0].sigma(_FLOOR_MM10), noise[1].sigma(_FLOOR_MM10))
        self.sigma_mm10 = root_of_squares(scatter_mm10, self._certain_mm10) + grown(
            _COAST_ACCELERATION_MM10_S2 + self._motion.sideways_mm10_s2(), time_h, 60000
        )
        if self._known < 2:
            self.sigma_mm10 = min(60000, self.sigma_mm10 + self.speed_mm_s * min(time_h, 10000) // 1000)
        self.sigma_cdeg = root_of_squares(noise[2].sigma(_FLOOR_CDEG), self._certain_cdeg)
        self.sigma_cdeg += grown(_COAST_TURN_CDEG_S2, time_h, 18000)
