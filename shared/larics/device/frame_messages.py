"""Turns measurements and poses into the messages of one frame. Reuses its lists: nothing is allocated."""

from larics.wire import messages as m


class Reports:
    """Adds the messages of one frame to a larics.device.outbox.Outbox, between its begin() and commit()."""

    def __init__(self, outbox):
        self._outbox = outbox
        self._marker = [0] * 12
        self._pose = [0] * 11

    def marker(self, frame, age_us, index, count, measurement, calibrated):
        """One of the markers of a frame; `measurement` as larics.locate.camera_model fills it."""
        values = self._marker
        flags = measurement.flags
        values[0] = frame
        values[1] = age_us
        values[3] = measurement.marker_id if measurement.marker_id >= 0 else m.ID_NONE
        values[4] = index
        values[5] = count
        if calibrated:
            values[6] = measurement.offset_x_mm10
            values[7] = measurement.offset_y_mm10
            values[8] = measurement.height_mm10
        else:
            flags |= m.MARKER_NO_OFFSET
            values[6] = values[7] = values[8] = 0
        values[2] = flags
        values[9] = measurement.heading_cdeg
        values[10] = measurement.margin
        values[11] = measurement.radius_q8
        self._outbox.add(m.MARKER, values)

    def no_marker(self, frame, age_us):
        """A frame without a marker is reported too."""
        values = self._marker
        for index in range(4, 12):
            values[index] = 0
        values[0] = frame
        values[1] = age_us
        values[2] = m.MARKER_NONE
        values[3] = m.ID_NONE
        self._outbox.add(m.MARKER, values)

    def pose(self, frame, age_us, navigator):
        """The vehicle's pose; age_us: of this frame."""
        values = self._pose
        localizer = navigator.pose
        values[0] = frame
        # the age of the pose grows while the message waits, so it must not be at its limit already
        values[1] = min(m.COUNT_MAX, localizer.age_us + age_us)
        values[2] = localizer.state
        values[3] = localizer.marker_id
        values[4] = localizer.x_mm10
        values[5] = localizer.y_mm10
        values[6] = localizer.heading_cdeg
        values[7] = localizer.sigma_mm10
        values[8] = localizer.sigma_cdeg
        values[9] = navigator.route_position
        values[10] = navigator.next_cdeg
        self._outbox.add(m.POSE, values)
