"""Reference behaviour for a vehicle controller: from marker to marker, in integers only.

    SEARCH   no marker: a spiral whose turns lie 80 cm apart
    CENTER   drive until the marker is above the vehicle
    ALIGN    turn in place to the next direction: that of the route, or the marker's orientation line
    GO       drive on along that line, or where a camera with odometry says that the next marker is, until it
             comes into view
    ARRIVED  the last marker of the route
    HALT     nothing heard for too long, held by the supervision, or stopped by hand: brake and wait

Feed it the messages of the wire (`on_message` is what `protocol.Decoder` calls) and call `step` at a
steady rate; it sets `speed_mm_s` (forward) and `turn_cdeg_s` (counterclockwise) for the wheels. Between
messages what was seen is carried along by the commanded motion, so a slow camera will do. Speed, turn
rate and both accelerations are limited; nothing is allocated. `firmware/vehicle/src/larics_drive.c` does the
same in C, step by step.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import (
    atan2_turn16,
    cdeg_from_turn16,
    cos_q14,
    isqrt,
    sin_q14,
    turn16_from_cdeg,
    wrap_cdeg,
)
from larics.wire.messages import (
    CARRIED,
    DIRECTION_NONE,
    ID_NONE,
    MARKER,
    MARKER_NO_OFFSET,
    MARKER_NONE,
    POSE,
    ROUTE_NONE,
    TRACKING,
)

# generated: begin indices (tools/make_protocol.py)
_MARKER_AGE_US = const(1)
_MARKER_FLAGS = const(2)
_MARKER_ID = const(3)
_MARKER_X_MM10 = const(6)
_MARKER_Y_MM10 = const(7)
_MARKER_HEADING_CDEG = const(9)
_POSE_STATE = const(3)
_POSE_ROUTE_POSITION = const(13)
_POSE_NEXT_CDEG = const(14)
# generated: end indices

HALT = const(0)
SEARCH = const(1)
CENTER = const(2)
ALIGN = const(3)
GO = const(4)
ARRIVED = const(5)

STATE_NAMES = ("halt", "search", "center", "align", "go", "arrived")

_ID = const(0)  # what is kept of a marker
_X = const(1)
_Y = const(2)
_HEADING = const(3)
_AGE_MS = const(4)
_NEVER_MS = const(1000000)
_TURN_GAIN = const(3)  # 1/s: turn rate for an error in direction
_AHEAD_CDEG = const(3000)  # drives only when what it drives to is within this of straight ahead
_CROSS_CDEG_PER_MM = const(20)  # how sharply GO steers back to its line ...
_CROSS_MOST_CDEG = const(2500)  # ... and at most
_LEFT_BEHIND_MM = const(400)  # GO takes the marker it left for a new one only so far on its way
_SAME_PLACE_MM10 = const(3000)  # two markers never hang so near to each other
_SPIRAL_START_MM = const(200)
_SPIRAL_PITCH_MM = const(254)  # per turn, divided by pi: 800 mm from one turn to the next


def _clamp(value, limit):
    return max(-limit, min(limit, value))


class Approach:
    """Limits, in the units of their names:

    speed_mm_s, turn_cdeg_s            of the vehicle
    accel_mm_s2, turn_accel_cdeg_s2    also for braking
    stale_ms      a marker seen longer ago is not believed; twice that without any message means HALT
    center_mm10   the vehicle is below the marker within this distance
    align_cdeg    and turned to the next direction within this angle
    leg_mm        a leg longer than this without a marker ends in SEARCH

    Set `is_held` to hold the vehicle in HALT for as long as the camera is not to be trusted, and `is_end`
    when the marker reached is the last of a route that the vehicle keeps (a camera with a route tells it).
    After `step`: state, and the command, speed_mm_s and turn_cdeg_s.
    """

    def __init__(
        self,
        speed_mm_s=200,
        turn_cdeg_s=6000,
        accel_mm_s2=400,
        turn_accel_cdeg_s2=18000,
        stale_ms=500,
        center_mm10=300,
        align_cdeg=150,
        leg_mm=6000,
    ):
        self.limit_speed_mm_s = speed_mm_s
        self.limit_turn_cdeg_s = turn_cdeg_s
        self.accel_mm_s2 = accel_mm_s2
        self.turn_accel_cdeg_s2 = turn_accel_cdeg_s2
        self.stale_ms = stale_ms
        self.center_mm10 = center_mm10
        self.align_cdeg = align_cdeg
        self.leg_mm = leg_mm
        self.state = SEARCH
        self.stopped = False
        self.is_held = False
        self.speed_mm_s = 0
        self.turn_cdeg_s = 0
        self.left_id = ID_NONE  # GO came from this marker
        self._target = array("i", [ID_NONE, 0, 0, 0, _NEVER_MS])
        self._behind = array("i", [ID_NONE, 0, 0, 0, _NEVER_MS])
        self._next_cdeg = 0
        self._next_ms = _NEVER_MS  # age of that
        self._is_carried = False  # and whether odometry told it
        self.is_end = False  # the route ends at the marker reached
        self._silent_ms = _NEVER_MS
        self._way_um = 0  # driven since the state began, up to 1 km
        self._leg_cdeg = 0  # direction of the leg, from the orientation line of the marker left
        self._frame_ms = 0  # age of the last frame heard of

    # ------------------------------------------------------------------ what the camera says

    def on_message(self, number, sequence, values):
        """Takes a MARKER or POSE message (of a frame in that order); others only count as a sign of life."""
        self._silent_ms = 0
        if number == MARKER:
            self._take_marker(values)
        elif number == POSE:
            self._take_pose(values)

    def _take_marker(self, values):
        self._frame_ms = age_ms = min(values[_MARKER_AGE_US] // 1000, 10000)
        if values[_MARKER_FLAGS] & (MARKER_NONE | MARKER_NO_OFFSET) or values[_MARKER_ID] == ID_NONE:
            return
        marker_id = values[_MARKER_ID]
        if self._is_misread(marker_id, values[_MARKER_X_MM10], values[_MARKER_Y_MM10]):
            return
        if self._is_behind(marker_id):
            slot = self._behind
        elif self._is_better(marker_id, abs(values[_MARKER_X_MM10]) + abs(values[_MARKER_Y_MM10])):
            slot = self._target
        else:
            return
        slot[_ID] = marker_id
        slot[_X] = _clamp(values[_MARKER_X_MM10], 100000)
        slot[_Y] = _clamp(values[_MARKER_Y_MM10], 100000)
        slot[_HEADING] = values[_MARKER_HEADING_CDEG]
        slot[_AGE_MS] = 0
        self._carry(slot, age_ms)

    def _is_behind(self, marker_id):
        """Whether this is the marker that GO has just left: once out of view, it counts as any other."""
        if self.state != GO or marker_id != self.left_id:
            return False
        return self._way_um < _LEFT_BEHIND_MM * 1000 or self._behind[_AGE_MS] <= self.stale_ms

    def _is_misread(self, marker_id, x, y):
        """Whether this is the marker that GO has just left, read with another ID as the border cuts it."""
        behind = self._behind
        if self.state != GO or marker_id == self.left_id or behind[_AGE_MS] > 4 * self.stale_ms:
            return False
        return max(abs(x - behind[_X]), abs(y - behind[_Y])) < _SAME_PLACE_MM10

    def _is_better(self, marker_id, distance):
        """Whether to turn to this marker: none yet, the same one, or a nearer one while none is reached."""
        target = self._target
        if target[_AGE_MS] > self.stale_ms or target[_ID] == marker_id:
            return True
        return self.state != ALIGN and distance * 2 < abs(target[_X]) + abs(target[_Y])

    def _take_pose(self, values):
        next_cdeg = values[_POSE_NEXT_CDEG]
        self._is_carried = values[_POSE_STATE] == CARRIED and next_cdeg != DIRECTION_NONE
        if values[_POSE_STATE] == TRACKING:
            self.is_end = values[_POSE_ROUTE_POSITION] != ROUTE_NONE and next_cdeg == DIRECTION_NONE
        elif not self._is_carried:
            return  # what is predicted without odometry is not steered by: the wheels know better
        if next_cdeg != DIRECTION_NONE:
            self._next_cdeg = next_cdeg - self.turn_cdeg_s * self._frame_ms // 1000
            self._next_ms = 0

    # ------------------------------------------------------------------ what the vehicle does

    def stop(self):
        """Brakes, whatever comes, until `start`."""
        self.stopped = True

    def start(self):
        """Ends `stop`, and leaves ARRIVED."""
        self.stopped = False
        self._enter(SEARCH)

    def step(self, elapsed_ms):
        """Sets speed_mm_s and turn_cdeg_s for the time until the next call; returns the state."""
        elapsed_ms = max(1, min(elapsed_ms, 1000))
        self._pass_time(elapsed_ms)
        if self.stopped or self.is_held or self._silent_ms > 2 * self.stale_ms:
            self._enter(HALT)
        elif self.state == HALT:
            self._enter(SEARCH)
        seen = self._target[_AGE_MS] <= self.stale_ms
        state = self.state
        if state == HALT or state == ARRIVED:
            self._drive(0, 0, elapsed_ms)
        elif state == GO or (not seen and self._is_guided()):
            self._go(seen, elapsed_ms)
        elif not seen:
            self._search(elapsed_ms)
        elif state == ALIGN:
            self._align(elapsed_ms)
        else:
            self._center(elapsed_ms)
        return self.state

    def _is_guided(self):
        """Whether the camera knows by odometry where to go on, without a marker."""
        return self._is_carried and self._next_ms <= self.stale_ms

    def _enter(self, state):
        if state != self.state:
            self.state = state
            self._way_um = 0

    def _pass_time(self, elapsed_ms):
        self._silent_ms = min(_NEVER_MS, self._silent_ms + elapsed_ms)
        self._next_ms = min(_NEVER_MS, self._next_ms + elapsed_ms)
        self._next_cdeg = wrap_cdeg(self._next_cdeg - self.turn_cdeg_s * elapsed_ms // 1000)
        self._way_um = min(1000000000, self._way_um + abs(self.speed_mm_s) * elapsed_ms)
        self._carry(self._target, elapsed_ms)
        self._carry(self._behind, elapsed_ms)

    def _carry(self, slot, elapsed_ms):
        """Where a marker is after the commanded motion of that time."""
        slot[_AGE_MS] = min(_NEVER_MS, slot[_AGE_MS] + elapsed_ms)
        if slot[_AGE_MS] > 10000:
            return
        turned = turn16_from_cdeg(self.turn_cdeg_s * elapsed_ms // 1000)
        sin, cos = sin_q14(turned), cos_q14(turned)
        x, y = slot[_X] - self.speed_mm_s * elapsed_ms // 100, slot[_Y]
        x, y = _clamp(x, 120000) >> 2, _clamp(y, 120000) >> 2
        slot[_X] = (x * cos + y * sin) >> 12
        slot[_Y] = (y * cos - x * sin) >> 12
        slot[_HEADING] = (slot[_HEADING] - self.turn_cdeg_s * elapsed_ms // 1000) % 36000

    def _search(self, elapsed_ms):
        self._enter(SEARCH)
        speed = self.limit_speed_mm_s * 3 // 4
        way_mm = min(self._way_um // 1000, 1000000)
        radius_mm = isqrt(_SPIRAL_START_MM * _SPIRAL_START_MM + _SPIRAL_PITCH_MM * way_mm)
        self._drive(speed, 5730 * speed // radius_mm, elapsed_ms)

    def _center(self, elapsed_ms):
        self._enter(CENTER)
        x, y = _clamp(self._target[_X], 20000), _clamp(self._target[_Y], 20000)
        distance_mm10 = isqrt(x * x + y * y)
        if distance_mm10 <= self.center_mm10:
            self._enter(ALIGN)
            self._align(elapsed_ms)
            return
        error = wrap_cdeg(cdeg_from_turn16(atan2_turn16(y, x)))
        forward = 1
        if abs(error) > 10000:  # it is behind: back up
            forward = -1
            error = wrap_cdeg(error + 18000)
        speed = min(self.limit_speed_mm_s, isqrt(self.accel_mm_s2 * distance_mm10 // 10))
        speed = speed * max(0, _AHEAD_CDEG - abs(error)) // _AHEAD_CDEG
        self._drive(forward * speed, error * _TURN_GAIN, elapsed_ms)

    def _direction(self):
        """Where to go on from the marker, vehicle frame."""
        if self._next_ms <= self.stale_ms:
            return wrap_cdeg(self._next_cdeg)
        return wrap_cdeg(self._target[_HEADING])

    def _align(self, elapsed_ms):
        target = self._target
        if abs(target[_X]) + abs(target[_Y]) > 4 * self.center_mm10:
            self._center(elapsed_ms)
            return
        if self.is_end:
            self._enter(ARRIVED)
            self._drive(0, 0, elapsed_ms)
            return
        error = self._direction()
        slow = abs(self.turn_cdeg_s) * 5 < 10 * self.align_cdeg
        if abs(error) <= self.align_cdeg and slow and abs(self.speed_mm_s) < 20:
            self._leave()
            self._go(False, elapsed_ms)
            return
        self._drive(0, error * _TURN_GAIN, elapsed_ms)

    def _leave(self):
        target, behind = self._target, self._behind
        for k in range(5):
            behind[k] = target[k]
        self.left_id = target[_ID]
        target[_AGE_MS] = _NEVER_MS
        self._leg_cdeg = wrap_cdeg(self._direction() - target[_HEADING])
        self._enter(GO)

    def _go(self, seen, elapsed_ms):
        if seen:
            self._center(elapsed_ms)
            return
        self._enter(GO)
        if self._way_um > self.leg_mm * 1000 and not self._is_guided():
            self._search(elapsed_ms)
            return
        behind = self._behind
        error = 0
        if behind[_AGE_MS] <= self.stale_ms:
            error = wrap_cdeg(behind[_HEADING] + self._leg_cdeg)
            turn16 = turn16_from_cdeg(error)
            x, y = behind[_X] >> 2, behind[_Y] >> 2
            aside_mm = (y * cos_q14(turn16) - x * sin_q14(turn16)) // 40960  # the line is left of the vehicle
            error += _clamp(aside_mm * _CROSS_CDEG_PER_MM, _CROSS_MOST_CDEG)
        elif self._next_ms < _NEVER_MS:  # the last direction told, kept by the commanded turns
            error = wrap_cdeg(self._next_cdeg)
        speed = self.limit_speed_mm_s * max(0, _AHEAD_CDEG - abs(error)) // _AHEAD_CDEG
        self._drive(speed, error * _TURN_GAIN, elapsed_ms)

    def _drive(self, speed_mm_s, turn_cdeg_s, elapsed_ms):
        """Moves the commands towards these values, within all limits."""
        speed_mm_s = _clamp(speed_mm_s, self.limit_speed_mm_s)
        turn_cdeg_s = _clamp(turn_cdeg_s, self.limit_turn_cdeg_s)
        step = max(1, self.accel_mm_s2 * elapsed_ms // 1000)
        self.speed_mm_s += _clamp(speed_mm_s - self.speed_mm_s, step)
        step = max(1, self.turn_accel_cdeg_s2 * elapsed_ms // 1000)
        self.turn_cdeg_s += _clamp(turn_cdeg_s - self.turn_cdeg_s, step)
