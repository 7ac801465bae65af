"""The parts of the running program that settings make, each made anew only when a setting of its own changes.

Whatever the settings say, the program keeps running: what does not suit the frames is made with the usual
settings instead, and reported.
"""

import gc

from larics.device.sensor import EVERY_PART, Sensor
from larics.settings import Settings
from larics.settings.fields import DETECTOR, EXPOSURE, LOCATOR, NAVIGATOR
from larics.wire import messages as m


class Parts:
    """sensor: larics.device.sensor.Sensor, its detector None only when there is no memory for one;
    exposure: exposure.Exposure, None when exposure and gain are those of the settings.

    camera, faults   as in app.App; the camera was started, so that it knows the size of its frames
    detector         when it was made already
    """

    def __init__(self, settings, camera, faults, detector=None):
        self._settings = settings
        self._camera = camera
        self._faults = faults
        # a size that was set counts after a restart
        self.sensor = Sensor(settings, (camera.width or settings.width, camera.height or settings.height))
        self.sensor.detector = detector
        self.exposure = None
        self.rebuild(EVERY_PART & ~DETECTOR if detector else EVERY_PART)
        self._rebuild_exposure()

    def rebuild(self, parts):
        """Makes those anew that are among `parts`: a sum of the parts of larics.settings.fields."""
        if parts & DETECTOR:
            self._rebuild_detector()
        if parts & (LOCATOR | NAVIGATOR):
            self._rebuild_places(parts)
        if parts & EXPOSURE:
            self._rebuild_exposure()
            if self.exposure is None:
                self._fix_exposure()

    def _rebuild_detector(self):
        """A detector, if need be with the usual radii."""
        sensor = self.sensor
        sensor.detector = None
        gc.collect()  # its buffers are the largest: they go in before the heap is cut up
        try:
            sensor.rebuild(DETECTOR)
        except ValueError:  # they suit the size that was set, but not yet that of the frames
            self._faults.begin(m.FAULT_SETTINGS_CORRUPT)
            sensor.rebuild(DETECTOR, Settings())
        except MemoryError:
            gc.collect()
            self._faults.begin(m.FAULT_MEMORY)

    def _rebuild_places(self, parts):
        """Pixels to millimetres and the pose in the map, as far as the settings make sense."""
        try:
            self.sensor.rebuild(parts & (LOCATOR | NAVIGATOR))
        except ValueError:
            self._faults.begin(m.FAULT_SETTINGS_CORRUPT)
            self.sensor.rebuild(LOCATOR | NAVIGATOR, Settings())

    def _rebuild_exposure(self):
        self.exposure = None
        if self._settings.exposure == "auto" and getattr(self._camera, "adjustable", True):
            from exposure import Exposure  # a recording does without

            self.exposure = Exposure(self._camera, self._settings)

    def _fix_exposure(self):
        try:
            self._camera.gain(self._settings.gain_db10 * 10)
            self._camera.exposure(self._settings.exposure_us)
        except Exception:
            self._faults.report(m.FAULT_CAMERA)
