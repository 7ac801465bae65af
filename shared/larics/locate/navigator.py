"""Pose and route together: what a frame's markers mean for the vehicle's way, in integers only."""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.locate.localizer import Localizer
from larics.locate.marker_map import MarkerMap
from larics.locate.motion import direction_cdeg
from larics.locate.route import AMBIGUOUS, SAME, Route
from larics.marker.detection import FLAG_UNCONFIRMED
from larics.wire.messages import CARRIED, DIRECTION_NONE, FAULT_ROUTE, LOST, ROUTE_NONE

_PASSED_MM10 = const(
    2500
)  # so near to a marker's place, or within two sigma, one sees it, if it is there ...
_PASSED_MOST_MM10 = const(10000)
_PASSED_FRAMES = const(2)  # ... in one of so many frames
_NEARER = const(2)  # another marker in view counts as reached when it is so many times nearer


class Navigator:
    """Follows the vehicle in the map and, when there is one, along its route.

    rows, ids       map and route as in the settings; ValueError in one line for what cannot be
    systematic, odometry_noise   as for Localizer
    pose, route     the Localizer; the Route or None

    After `update`: route_position (ROUTE_NONE when unknown), next_cdeg (vehicle frame, 0..35999, or
    DIRECTION_NONE), fault (0, or why a marker of this frame was refused or did not fit the route),
    event (what `route` said of the marker of this frame).
    """

    def __init__(
        self, rows, ids=(), known_ids=(), outer_mm10=1500, lens_mm10=0, speed_mm_s=2000, start=-1,
        systematic=None, odometry_noise=None,
    ):  # fmt: skip
        self.map = MarkerMap(rows, known_ids, outer_mm10, lens_mm10)
        self.pose = Localizer(
            self.map, speed_mm_s=speed_mm_s, systematic=systematic, odometry_noise=odometry_noise
        )
        self.route = Route(ids, self.map, start) if len(ids) else None
        self.usual_mm10 = outer_mm10
        self.route_position = ROUTE_NONE
        self.next_cdeg = DIRECTION_NONE
        self.fault = 0
        self.event = SAME
        self._last_id = -1
        self._unseen = 0  # frames in a row at the place of the next marker, without it

    def outer_mm10(self, marker_id):
        """Radius of the outer ring of a marker with this ID."""
        entry = self.map.find(marker_id)
        return self.map.outer_mm10[entry] if entry >= 0 else self.usual_mm10

    def z_mm10(self, marker_id):
        """Its height in the vehicle frame, 0 when the map leaves it to the ceiling."""
        entry = self.map.find(marker_id)
        return self.map.z_mm10[entry] if entry >= 0 else 0

    def update(self, measurements, count, time_us, odometry=None):
        """As Localizer.update; returns the state."""
        pose = self.pose
        state = pose.update(measurements, count, time_us, odometry)
        self.fault = pose.fault
        if self.route is None:
            return state
        self._follow(measurements, count)
        position = self.route.position
        self.route_position = position if position >= 0 else ROUTE_NONE
        pose.matching.hint = self.route.entry(position)
        self._aim(measurements, count)
        return state

    def pass_time(self, time_us):
        """As Localizer.pass_time; returns the state."""
        before = self.pose.state
        state = self.pose.pass_time(time_us)
        if state == LOST and before != LOST:
            self._lose_sight()
        return state

    def _lose_sight(self):
        self.next_cdeg = DIRECTION_NONE
        self._last_id = -1
        if self.route is not None:
            self.route.lose_sight()

    def _follow(self, measurements, count):
        self.event = SAME
        reached = self._reached(measurements, count)
        if reached < 0:
            if self.pose.state == LOST and count == 0:
                self._lose_sight()
            elif self._is_at_next():
                self._unseen += 1
                if self._unseen >= _PASSED_FRAMES:
                    self._unseen = 0
                    self._last_id = -1
                    self.event = self.route.pass_by()
                    self.fault = self.fault or FAULT_ROUTE
            else:
                self._unseen = 0
            return
        self._unseen = 0
        self._last_id = reached
        self.event = self.route.see(reached)
        if self.event > AMBIGUOUS:
            self.fault = self.fault or FAULT_ROUTE

    def _is_at_next(self):
        """Whether odometry has carried the vehicle to the place of the marker to drive to."""
        pose = self.pose
        goal = self.route.entry(self.route.next_position())
        if goal < 0 or pose.state != CARRIED:
            return False
        near = max(_PASSED_MM10, min(_PASSED_MOST_MM10, 2 * pose.sigma_mm10))
        dx, dy = abs(self.map.x_mm10[goal] - pose.x_mm10), abs(self.map.y_mm10[goal] - pose.y_mm10)
        return max(dx, dy) + (min(dx, dy) >> 1) < near

    def _reached(self, measurements, count):
        """The ID of the marker in view that the vehicle is at, -1 for none: the nearest, but the one it
        was at stays it until another is much nearer. A marker that the pose refused does not count."""
        best = -1
        least = last = 1 << 28
        for k in range(count):
            measurement = measurements[k]
            marker_id = measurement.marker_id
            if marker_id < 0 or measurement.flags & FLAG_UNCONFIRMED or not self._is_believed(marker_id):
                continue
            distance = abs(measurement.offset_x_mm10) + abs(measurement.offset_y_mm10)
            if marker_id == self._last_id:
                last = min(last, distance)
            if distance < least:
                least = distance
                best = marker_id
        if last < 1 << 28 and least * _NEARER > last:
            return self._last_id
        return best

    def _is_believed(self, marker_id):
        return self.map.find(marker_id) >= 0 and (self.pose.state == LOST or not self.pose.refused(marker_id))

    def _aim(self, measurements, count):
        """At the marker: the direction of the leg that begins there. Between markers: to the next one."""
        self.next_cdeg = DIRECTION_NONE
        goal = self.route.entry(self.route.next_position())
        if goal < 0:
            return
        marker_map, pose = self.map, self.pose
        here = self.route.entry(self.route.position)
        leg = direction_cdeg(
            marker_map.x_mm10[goal] - marker_map.x_mm10[here],
            marker_map.y_mm10[goal] - marker_map.y_mm10[here],
        )
        for k in range(count):
            measurement = measurements[k]
            if measurement.marker_id == marker_map.ids[here]:
                self.next_cdeg = (measurement.heading_cdeg + leg - marker_map.heading_cdeg[here]) % 36000
                return
        if pose.state != LOST:
            self.next_cdeg = pose.bearing_cdeg(marker_map.x_mm10[goal], marker_map.y_mm10[goal])
