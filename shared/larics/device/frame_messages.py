"""Turns measurements and poses into the messages of one frame. Reuses its lists: nothing is allocated."""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.wire import messages as m

# generated: begin indices (tools/make_protocol.py)
_MARKER_FIELDS = const(14)
_MARKER_FRAME = const(0)
_MARKER_AGE_US = const(1)
_MARKER_FLAGS = const(2)
_MARKER_ID = const(3)
_MARKER_INDEX = const(4)
_MARKER_COUNT = const(5)
_MARKER_X_MM10 = const(6)
_MARKER_Y_MM10 = const(7)
_MARKER_Z_MM10 = const(8)
_MARKER_HEADING_CDEG = const(9)
_MARKER_MARGIN = const(10)
_MARKER_RADIUS_Q8 = const(11)
_MARKER_SIGMA_Q12 = const(12)
_MARKER_SIGMA_MDEG = const(13)
_POSE_FIELDS = const(15)
_POSE_FRAME = const(0)
_POSE_AGE_US = const(1)
_POSE_MARKER_AGE_MS = const(2)
_POSE_STATE = const(3)
_POSE_ID = const(4)
_POSE_X_MM10 = const(5)
_POSE_Y_MM10 = const(6)
_POSE_HEADING_CDEG = const(7)
_POSE_SIGMA_X_MM10 = const(8)
_POSE_SIGMA_Y_MM10 = const(9)
_POSE_CORRELATION_Q14 = const(10)
_POSE_SIGMA_CDEG = const(11)
_POSE_WAY_MM = const(12)
_POSE_ROUTE_POSITION = const(13)
_POSE_NEXT_CDEG = const(14)
_MOTION_FIELDS = const(9)
_MOTION_FRAME = const(0)
_MOTION_STATE = const(1)
_MOTION_EPOCH = const(2)
_MOTION_X_MM10 = const(3)
_MOTION_Y_MM10 = const(4)
_MOTION_HEADING_CDEG = const(5)
_MOTION_WAY_MM10 = const(6)
_MOTION_TURN_CDEG = const(7)
_MOTION_ODOMETRY_AGE_US = const(8)
# generated: end indices


def _told(sigma):
    """A standard deviation as the wire has it; a detection's unknown one is negative."""
    return m.SIGMA_UNKNOWN if sigma < 0 else min(sigma, m.SIGMA_UNKNOWN - 1)


class Reports:
    """Adds the messages of one frame to a larics.device.outbox.Outbox, between its begin() and commit()."""

    def __init__(self, outbox):
        self._outbox = outbox
        self._marker = [0] * _MARKER_FIELDS
        self._pose = [0] * _POSE_FIELDS
        self._motion = [0] * _MOTION_FIELDS

    def marker(self, frame, age_us, index, count, measurement, calibrated):
        """One of the markers of a frame; `measurement` as larics.locate.camera_model fills it."""
        values = self._marker
        flags = measurement.flags
        values[_MARKER_FRAME] = frame
        values[_MARKER_AGE_US] = age_us
        values[_MARKER_ID] = measurement.marker_id if measurement.marker_id >= 0 else m.ID_NONE
        values[_MARKER_INDEX] = index
        values[_MARKER_COUNT] = count
        if calibrated:
            values[_MARKER_X_MM10] = measurement.offset_x_mm10
            values[_MARKER_Y_MM10] = measurement.offset_y_mm10
            values[_MARKER_Z_MM10] = measurement.height_mm10
        else:
            flags |= m.MARKER_NO_OFFSET
            values[_MARKER_X_MM10] = values[_MARKER_Y_MM10] = values[_MARKER_Z_MM10] = 0
        values[_MARKER_FLAGS] = flags
        values[_MARKER_HEADING_CDEG] = measurement.heading_cdeg
        values[_MARKER_MARGIN] = measurement.margin
        values[_MARKER_RADIUS_Q8] = measurement.radius_q8
        values[_MARKER_SIGMA_Q12] = _told(measurement.sigma_q12)
        values[_MARKER_SIGMA_MDEG] = _told(measurement.sigma_mdeg)
        self._outbox.add(m.MARKER, values)

    def no_marker(self, frame, age_us):
        """A frame without a marker is reported too."""
        values = self._marker
        for index in range(_MARKER_FIELDS):
            values[index] = 0
        values[_MARKER_FRAME] = frame
        values[_MARKER_AGE_US] = age_us
        values[_MARKER_FLAGS] = m.MARKER_NONE
        values[_MARKER_ID] = m.ID_NONE
        values[_MARKER_SIGMA_Q12] = m.SIGMA_UNKNOWN
        values[_MARKER_SIGMA_MDEG] = m.SIGMA_UNKNOWN
        self._outbox.add(m.MARKER, values)

    def pose(self, frame, age_us, navigator):
        """The vehicle's pose; age_us: of this frame."""
        values = self._pose
        localizer = navigator.pose
        values[_POSE_FRAME] = frame
        values[_POSE_AGE_US] = age_us
        marker_age_us = min(m.COUNT_MAX, localizer.age_us + age_us)
        values[_POSE_MARKER_AGE_MS] = min(m.AGE_UNKNOWN, (marker_age_us + 999) // 1000)
        values[_POSE_STATE] = localizer.state
        values[_POSE_ID] = localizer.marker_id
        if localizer.state == m.LOST:  # the last known place is that of the message before
            values[_POSE_X_MM10] = values[_POSE_Y_MM10] = m.PLACE_UNKNOWN
            values[_POSE_HEADING_CDEG] = m.HEADING_UNKNOWN
        else:
            values[_POSE_X_MM10] = localizer.x_mm10
            values[_POSE_Y_MM10] = localizer.y_mm10
            values[_POSE_HEADING_CDEG] = localizer.heading_cdeg
        values[_POSE_SIGMA_X_MM10] = min(m.SIGMA_UNKNOWN, localizer.sigma_x_mm10)
        values[_POSE_SIGMA_Y_MM10] = min(m.SIGMA_UNKNOWN, localizer.sigma_y_mm10)
        values[_POSE_CORRELATION_Q14] = localizer.correlation_q14
        values[_POSE_SIGMA_CDEG] = min(m.SIGMA_UNKNOWN, localizer.sigma_cdeg)
        values[_POSE_WAY_MM] = localizer.way_mm
        values[_POSE_ROUTE_POSITION] = navigator.route_position
        values[_POSE_NEXT_CDEG] = navigator.next_cdeg
        self._outbox.add(m.POSE, values)

    def motion(self, frame, odometry):
        """The vehicle's odometry at the exposure of a frame, as larics.locate.odometry.Odometry found it."""
        values = self._motion
        values[_MOTION_FRAME] = frame
        values[_MOTION_STATE] = odometry.state
        values[_MOTION_EPOCH] = odometry.epoch
        values[_MOTION_X_MM10] = odometry.x_mm10
        values[_MOTION_Y_MM10] = odometry.y_mm10
        values[_MOTION_HEADING_CDEG] = odometry.heading_cdeg
        values[_MOTION_WAY_MM10] = odometry.way_mm10
        values[_MOTION_TURN_CDEG] = odometry.turn_cdeg
        values[_MOTION_ODOMETRY_AGE_US] = odometry.age_us
        self._outbox.add(m.MOTION, values)
