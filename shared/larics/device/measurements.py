"""From the detections of a frame to the measurements that may be reported. Allocates nothing."""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.locate.camera_model import Measurement
from larics.marker.id_set import within

MARKERS_MOST = const(8)  # reported of one frame


class Measuring:
    """`measurements` are reused; after `locate`, `rejected` is how many detections of that frame were not
    reported."""

    def __init__(self):
        self.measurements = [Measurement() for _ in range(MARKERS_MOST)]
        self.rejected = 0

    def locate(self, found, settings, locator, navigator):
        """Puts the detections that may be reported in place, the first of `measurements`; returns how many.

        settings, locator   larics.settings.Settings, larics.locate.camera_model.Camera
        navigator           larics.locate.navigator.Navigator, or None without a map
        """
        measurements = self.measurements
        count = self.rejected = 0
        allowed = settings.allowed_ids
        for detection in found:
            if count == MARKERS_MOST:
                break
            measurement = measurements[count]
            placed = self._place(detection, measurement, settings, locator, navigator)
            marker_id = measurement.marker_id
            if placed and (marker_id < 0 or within(allowed, marker_id)):
                count += 1
            else:
                self.rejected += 1
        return count

    def _place(self, detection, measurement, settings, locator, navigator):
        """Size and height of a marker are those of the map, if it says so, else of the settings."""
        outer_mm10, z_mm10 = settings.outer_mm10, 0
        if navigator is not None:
            marker_id = locator.read_id(detection.marker_id)
            outer_mm10 = navigator.outer_mm10(marker_id)
            z_mm10 = navigator.z_mm10(marker_id)
        return locator.locate(detection, measurement, outer_mm10, z_mm10)
