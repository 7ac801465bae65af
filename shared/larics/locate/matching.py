"""Which of the map's markers a frame shows: what fits the prediction, what is refused, what moves the pose.

A marker that cannot be is never believed silently. One that is not in the map, that has the wrong size
for its height, or that would put the vehicle where it cannot have come, is refused and named by `fault`.
Only when several frames in a row agree on the new place, was the vehicle really moved there.
Nothing is allocated.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import cos_q14, sin_q14, turn16_from_cdeg, wrap_cdeg
from larics.locate.motion import grown, times_q14
from larics.wire.messages import (
    COUNT_MAX,
    FAULT_MARKER_HEIGHT,
    FAULT_MARKER_PLACE,
    FAULT_MARKER_UNKNOWN,
)

MAX_MARKERS = const(8)  # used of one frame
_SEEN = const(5)  # items of a place
_AGREE_LOST = const(2)  # frames (or markers) that must agree on a place when there was none, or it is far
_AGREE_MOVED = const(3)  # ... and when the place contradicts what was known
_SURE_MM10 = const(3000)  # one frame alone may correct the prediction by so much ...
_SURE_CDEG = const(3000)  # ... and so much
_GATE_MM10 = const(500)  # a measurement may differ from the prediction by this, 6 sigma of both, and what an
_GATE_CDEG = const(500)  # acceleration makes of the time since the last one:
_ACCELERATION_MM10_S2 = const(50000)
_TURN_ACCELERATION_CDEG_S2 = const(72000)
_ODOMETRY_GATE_MM10 = const(150)  # with odometry this, 6 sigma and a twentieth of the way, for its noise may
_ODOMETRY_GATE_CDEG = const(200)  # still be unknown, or this, 6 sigma and 3 degrees a metre
_WAY_MM = const(4000)


class Gate:
    """How far from where it is expected a vehicle may be, 0.1 mm and 0.01 degrees, beside six sigma of the
    measurement itself."""

    def __init__(self):
        self.place_mm10 = self.turn_cdeg = 0
        self.sure_mm10 = _SURE_MM10  # of that a single frame is believed

    def open_for_time(self, sigma_mm10, sigma_cdeg, time_h, speed_mm_s):
        """After a time since the last measurement, at a speed known up to speed_mm_s."""
        self.place_mm10 = _GATE_MM10 + grown(_ACCELERATION_MM10_S2, time_h, 100000)
        self.place_mm10 += speed_mm_s * min(time_h, 10000) // 1000 + 6 * min(sigma_mm10, 1000)
        self.sure_mm10 = _SURE_MM10
        self.turn_cdeg = _GATE_CDEG + grown(_TURN_ACCELERATION_CDEG_S2, time_h, 18000)
        self.turn_cdeg += 6 * min(sigma_cdeg, 500)

    def open_for_way(self, sigma_mm10, sigma_cdeg, way_mm):
        """After a way by odometry."""
        way_mm = min(way_mm, _WAY_MM)
        self.place_mm10 = _ODOMETRY_GATE_MM10 + 6 * min(sigma_mm10, 5000) + (way_mm >> 1)
        self.sure_mm10 = max(_SURE_MM10, 3 * sigma_mm10)
        self.turn_cdeg = _ODOMETRY_GATE_CDEG + 6 * min(sigma_cdeg, 500) + way_mm * 3 // 10


class Matching:
    """tolerance_q8, speed_mm_s: as in localizer.Localizer. After `match` or `relocate`:

    seen      array of five items for each place that fits: x, y, heading, entry, index of its measurement
    fault     0, or why a marker of this frame was refused
    before    where the frame before was, when `has_before`: x, y, heading; at before_us
    """

    def __init__(self, marker_map, speed_mm_s, tolerance_q8):
        self.map = marker_map
        self.speed_mm_s = speed_mm_s
        self.tolerance_q8 = tolerance_q8
        self.hint = -1  # entry that the route expects: decides between places of the same ID
        self.fault = 0
        self.seen = array("i", [0] * (_SEEN * MAX_MARKERS))
        self.before = array("i", [0] * 3)
        self.before_us = 0
        self.has_before = False
        self._gate = Gate()  # between frames that may agree
        self._there = array("i", [0] * 3)  # the new place that several frames must agree on
        self._there_us = 0
        self._agreed = 0
        self._refused_ids = array("i", [0] * MAX_MARKERS)  # of this frame
        self._refusals = 0
        self._doubtful = False  # a marker of this frame is possible, but too far off to be believed alone

    def begin(self, time_us, forget_us):
        """A frame; places that frames agreed on are forgotten after forget_us."""
        self.fault = 0
        self._refusals = 0
        self._doubtful = False
        self.pass_time(time_us, forget_us)

    def pass_time(self, time_us, forget_us):
        if (time_us - self._there_us) & COUNT_MAX > forget_us:
            self._agreed = 0

    def forget(self):
        """Frames have to agree from here on."""
        self._agreed = 0

    def refused(self, marker_id):
        """Whether a marker with this ID was refused in the last frame."""
        for index in range(self._refusals):
            if self._refused_ids[index] == marker_id:
                return True
        return False

    def match(self, measurements, count, expected, gate):
        """Collects the measurements that fit what is expected, array x, y, heading; returns how many."""
        used = 0
        for k in range(count):
            measurement = measurements[k]
            entry = self._usable(measurement, True)
            if entry < 0:
                continue
            possible = False
            while entry >= 0:
                self._place(measurement, entry, _SEEN * used, k)
                if self._is_near(_SEEN * used, expected, gate, measurement, True):
                    used += 1
                    break
                possible = possible or self._is_near(_SEEN * used, expected, gate, measurement, False)
                entry = self.map.find(measurement.marker_id, entry + 1)
            if entry >= 0:
                continue
            if possible:
                self._doubtful = True
            else:
                self._refuse(FAULT_MARKER_PLACE, measurement.marker_id)
        return used

    def relocate(self, measurements, count, time_us, lost):
        """A place without or against a prediction: counts until enough frames agree; then how many used."""
        there, seen, before = self._there, self.seen, self.before
        self._gate.open_for_time(0, 0, ((time_us - self._there_us) & COUNT_MAX) // 100, self.speed_mm_s)
        found = 0
        for k in range(count):
            measurement = measurements[k]
            entry = self._usable(measurement, lost)
            if entry < 0:
                continue
            at = _SEEN * found
            if found:
                self._gate.open_for_time(0, 0, 0, self.speed_mm_s)
            if not self._choose(measurement, entry, at, k):
                continue
            near = self._agreed and self._is_near(at, there, self._gate, measurement, False)
            if found == 0:
                self._agreed = self._agreed + 1 if near else 1
                before[0], before[1] = there[0], there[1]
                before[2] = there[2]
                self.has_before = bool(near)
                there[0], there[1] = seen[0], seen[1]
                there[2] = seen[2]
                found = 1
            elif near:
                self._agreed += 1
                found += 1
        if found == 0:
            return 0
        self.before_us = self._there_us
        self._there_us = time_us
        if self._agreed < (_AGREE_LOST if lost or self._doubtful else _AGREE_MOVED):
            return 0
        self._refusals = 0
        return found

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

    def _place(self, measurement, entry, at, index):
        """Where a measurement of this entry puts the vehicle, into self.seen[at:]."""
        marker_map, seen = self.map, self.seen
        heading = (marker_map.heading_cdeg[entry] - measurement.heading_cdeg) % 36000
        turn16 = turn16_from_cdeg(heading)
        sin, cos = sin_q14(turn16), cos_q14(turn16)
        x, y = measurement.offset_x_mm10, measurement.offset_y_mm10
        seen[at] = marker_map.x_mm10[entry] - times_q14(x, cos) + times_q14(y, sin)
        seen[at + 1] = marker_map.y_mm10[entry] - times_q14(x, sin) - times_q14(y, cos)
        seen[at + 2] = heading
        seen[at + 3] = entry
        seen[at + 4] = index

    def _is_near(self, at, pose, gate, measurement, sure):
        """Whether self.seen[at:] is where a vehicle expected at `pose` can be; `sure`: so near that it needs
        no second frame."""
        seen = self.seen
        reach = gate.place_mm10 + 6 * max(0, min(measurement.sigma_mm10, 1000))
        if sure:
            reach = min(reach, gate.sure_mm10)
        if abs(seen[at] - pose[0]) > reach or abs(seen[at + 1] - pose[1]) > reach:
            return False
        reach = gate.turn_cdeg + 6 * max(0, min(measurement.sigma_mdeg // 10, 500))
        if sure:
            reach = min(reach, _SURE_CDEG)
        return abs(wrap_cdeg(seen[at + 2] - pose[2])) <= reach

    def _choose(self, measurement, entry, at, index):
        """Places a measurement without prediction at its only place, or at that of its places which agrees
        with the frames before, or at the one the route expects; False when that leaves it open."""
        only = self.map.find(measurement.marker_id, entry + 1) < 0
        while entry >= 0:
            self._place(measurement, entry, at, index)
            if only or (self._agreed and self._is_near(at, self._there, self._gate, measurement, False)):
                return True
            entry = self.map.find(measurement.marker_id, entry + 1)
        if self.hint >= 0 and self.map.ids[self.hint] == measurement.marker_id:
            self._place(measurement, self.hint, at, index)
            return True
        return False
