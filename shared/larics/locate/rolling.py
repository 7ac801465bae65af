"""What a rolling shutter does to the markers that a moving camera sees, undone, in integers.

It exposes the rows of a frame one after the other. So a marker was seen at the time of its row, before or
after the middle of the exposure to which a frame's time and the odometry belong; and its other rows were seen
at other times than its centre, which shears its image along the motion and turns its orientation line: by up
to 0.16 degrees at 1 m/s, with rows that are 25 us apart and 0.22 px a mm. To first order in the time of a
row. Nothing is allocated.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import cos_q14, sin_q14, turn16_from_cdeg, wrap_cdeg
from larics.wire.messages import COUNT_MAX, MOTION_NONE

_LONGEST_US = const(500000)  # between two frames: over more the mean speed is not that of now
_MOST_MM_S = const(8000)  # faster is no vehicle
_MOST_CDEG_S = const(30000)
_MOST_MM10 = const(30000)  # a marker that is further off is left as it is
_MOST_SHEAR = const(10000)
_CDEG_PER_RAD = const(5730)
_LINE_PERCENT = const(143)  # of the ring's radius: where the orientation line tells its direction


class RollingShutter:
    """`follow` with each frame.

    row_ns       from the exposure of a row to that of the one below; negative from below to above
    focal_q8, mount_cdeg, lens_mm10   as of camera_model.Camera (camera_z_mm10)
    """

    def __init__(self, row_ns, focal_q8, mount_cdeg=0, lens_mm10=0):
        self._row_16ns = row_ns // 16
        self._row_px = (row_ns >> 2) * (focal_q8 >> 8)  # 4 ns px
        turn16 = turn16_from_cdeg(mount_cdeg)
        self._down_x, self._down_y = -cos_q14(turn16), -sin_q14(turn16)
        self._lens_mm10 = lens_mm10
        self._height_mm10 = self._shear = -1
        self._last_us = self._x = self._y = self._heading_cdeg = 0
        self._epoch = self._jumps = -1

    def follow(self, measurements, count, time_us, odometry):
        """Puts the first `count` Measurements of a frame captured at time_us (modulo 2**30) right, by how the
        vehicle has moved since the frame before. odometry: larics.locate.odometry.Odometry, set to that
        time, or None."""
        if odometry is None or odometry.state == MOTION_NONE:
            self._epoch = -1
            return
        if count and odometry.epoch == self._epoch and odometry.jumps == self._jumps:
            passed_us = (time_us - self._last_us) & COUNT_MAX
            if passed_us <= _LONGEST_US:
                self._undo(measurements, count, max(1, passed_us // 1000), odometry)
        self._last_us, self._epoch = time_us & COUNT_MAX, odometry.epoch
        self._x, self._y = odometry.x_mm10, odometry.y_mm10
        self._heading_cdeg, self._jumps = odometry.heading_cdeg, odometry.jumps

    def _undo(self, measurements, count, passed_ms, odometry):
        dx, dy = odometry.x_mm10 - self._x, odometry.y_mm10 - self._y
        turn_cdeg_s = wrap_cdeg(odometry.heading_cdeg - self._heading_cdeg) * 1000 // passed_ms
        if dx == 0 and dy == 0 and turn_cdeg_s == 0:
            return
        far = _MOST_MM_S * passed_ms // 100
        if max(abs(dx), abs(dy)) > far or abs(turn_cdeg_s) > _MOST_CDEG_S:
            return
        turn16 = turn16_from_cdeg(self._heading_cdeg + turn_cdeg_s * passed_ms // 2000)
        sin, cos = sin_q14(turn16), cos_q14(turn16)
        forward_mm_s = (dx * cos + dy * sin >> 14) * 100 // passed_ms
        left_mm_s = (dy * cos - dx * sin >> 14) * 100 // passed_ms
        for k in range(count):
            self.correct(measurements[k], forward_mm_s, left_mm_s, turn_cdeg_s)

    def correct(self, measurement, forward_mm_s, left_mm_s, turn_cdeg_s):
        """Puts a Measurement right, for a vehicle that moves so: at most 11.3 m/s each and 300 degrees/s."""
        x, y = measurement.offset_x_mm10, measurement.offset_y_mm10
        if max(abs(x), abs(y)) > _MOST_MM10:
            return
        if measurement.height_mm10 != self._height_mm10:
            self._height_mm10 = measurement.height_mm10
            above_mm = max(1, (self._height_mm10 - self._lens_mm10) // 10)
            self._shear = max(-_MOST_SHEAR, min(_MOST_SHEAR, self._row_px // above_mm)) * 573 // 400
        late_16us = (measurement.row_q8 >> 4) * self._row_16ns // 16000
        # the marker's motion in the vehicle frame
        along_x = y * turn_cdeg_s // (10 * _CDEG_PER_RAD) - forward_mm_s
        along_y = 0 - x * turn_cdeg_s // (10 * _CDEG_PER_RAD) - left_mm_s
        measurement.offset_x_mm10 = x - along_x * late_16us // 6250
        measurement.offset_y_mm10 = y - along_y * late_16us // 6250
        turn16 = turn16_from_cdeg(measurement.heading_cdeg)
        sin, cos = sin_q14(turn16), cos_q14(turn16)
        aside_mm_s = along_y * cos - along_x * sin >> 14
        rows_q14 = self._down_x * cos + self._down_y * sin >> 14
        turned_cdeg = (aside_mm_s * rows_q14 >> 14) * self._shear // 62500
        line_16us = measurement.radius_q8 * _LINE_PERCENT // 25600 * self._row_16ns // 1000
        turned_cdeg -= turn_cdeg_s * (late_16us + (line_16us * rows_q14 >> 14)) // 62500
        measurement.heading_cdeg = (measurement.heading_cdeg - turned_cdeg) % 36000
