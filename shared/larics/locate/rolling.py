"""What a rolling shutter does to the markers that a moving camera sees, undone, in integers.

It exposes the rows of a frame one after the other. So a marker was seen at the time of its row, before or
after the middle of the exposure to which a frame's time and the odometry belong; and its other rows were seen
at other times than its centre, which shears its image along the motion and turns its orientation line: by up
to 0.16 degrees at 1 m/s, with rows that are 25 us apart and 0.22 px a mm. To first order in the time of a
row. Nothing is allocated.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import cos_q14, sin_q14, turn16_from_cdeg
from larics.arith.tables import QUARTER_SINE_Q14
from larics.kernels.rolling import follow, unroll
from larics.wire.messages import MOTION_NONE

_MOST_MM10 = const(30000)  # a marker that is further off is left as it is
_MOST_SHEAR = const(10000)
_ROLLING_ROW = const(5)
_ROLLING_SHEAR = const(6)
_ROLLING_DOWN_X = const(7)
_ROLLING_DOWN_Y = const(8)
_ROLLING_X = const(9)
_ROLLING_Y = const(10)
_ROLLING_HEADING = const(11)
_ROLLING_ITEMS = const(16)


class RollingShutter:
    """`follow` with each frame.

    row_ns       from the exposure of a row to that of the one below; negative from below to above
    focal_q8, mount_cdeg, lens_mm10   as of camera_model.Camera (camera_z_mm10)
    """

    def __init__(self, row_ns, focal_q8, mount_cdeg=0, lens_mm10=0):
        items = self._items = array("i", [0] * _ROLLING_ITEMS)
        items[_ROLLING_ROW] = row_ns // 16
        self._row_px = (row_ns >> 2) * (focal_q8 >> 8)  # 4 ns px
        turn16 = turn16_from_cdeg(mount_cdeg)
        items[_ROLLING_DOWN_X], items[_ROLLING_DOWN_Y] = -cos_q14(turn16), -sin_q14(turn16)
        self._lens_mm10 = lens_mm10
        self._height_mm10 = -1
        self._epoch = self._jumps = -1

    def follow(self, measurements, count, time_us, odometry):
        """Puts the first `count` Measurements of a frame captured at time_us (modulo 2**30) right, by how the
        vehicle has moved since the frame before. odometry: larics.locate.odometry.Odometry, set to that
        time, or None."""
        if odometry is None or odometry.state == MOTION_NONE:
            self._epoch = -1
            return
        known = 0
        if odometry.epoch == self._epoch and odometry.jumps == self._jumps:
            known = 1
        else:
            self._epoch, self._jumps = odometry.epoch, odometry.jumps
        x, y = odometry.x_mm10, odometry.y_mm10
        if follow(0, 0, self._items, x, y, odometry.heading_cdeg, time_us, known):
            for k in range(count):
                self._correct(measurements[k])

    def _correct(self, measurement):
        x, y = measurement.offset_x_mm10, measurement.offset_y_mm10
        if abs(x) > _MOST_MM10 or abs(y) > _MOST_MM10:
            return
        items = self._items
        if measurement.height_mm10 != self._height_mm10:
            self._height_mm10 = measurement.height_mm10
            above_mm = max(1, (self._height_mm10 - self._lens_mm10) // 10)
            shear = max(-_MOST_SHEAR, min(_MOST_SHEAR, self._row_px // above_mm))
            items[_ROLLING_SHEAR] = shear * 573 // 400
        unroll(
            0, 0, items, QUARTER_SINE_Q14, x, y, measurement.heading_cdeg, measurement.row_q8,
            measurement.radius_q8,
        )  # fmt: skip
        measurement.offset_x_mm10, measurement.offset_y_mm10 = items[_ROLLING_X], items[_ROLLING_Y]
        measurement.heading_cdeg = items[_ROLLING_HEADING]
