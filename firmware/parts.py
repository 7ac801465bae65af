"""The parts of the running program that settings make, each made anew only when a setting of its own changes.

Whatever the settings say, the program keeps running: what does not suit the frames is made with the usual
settings instead, and reported.
"""

import gc

from larics.device.sensor import Sensor
from larics.settings import Settings
from larics.settings.fields import DETECTOR, EXPOSURE, LOCATOR, NAVIGATOR
from larics.wire import messages as m

_REBUILDING = 2048  # bytes between collections: what building leaves would cut up a small heap
_LARGE_HEAP = 2 << 20
_TWO_DETECTORS = 1 << 20  # heap in which two fit beside the program


def _heap_bytes():
    """Size of MicroPython's heap; on a PC as much as one likes."""
    return gc.mem_free() + gc.mem_alloc() if hasattr(gc, "mem_free") else 1 << 30


def _collect_often():
    """Lets MicroPython collect a heap that is not large after few bytes; returns what to give to
    `gc.threshold` afterwards, None where nothing was changed."""
    if _heap_bytes() >= _LARGE_HEAP:
        return None
    before = gc.threshold()
    gc.threshold(_REBUILDING)
    return before


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
        if detector is None:
            self.restore(DETECTOR)
        self.restore(LOCATOR | NAVIGATOR)
        self._rebuild_exposure()

    def rebuild(self, parts):
        """Makes those anew that are among `parts`: a sum of the parts of larics.settings.fields.

        False when there is no memory for one of them; then `restore` must follow."""
        try:
            if parts & DETECTOR:
                self._rebuild_detector()
                self._faults.end(m.FAULT_MEMORY)
            if parts & (LOCATOR | NAVIGATOR):
                self._rebuild_places(parts)
            if parts & EXPOSURE:
                self._rebuild_exposure()
                if self.exposure is None:
                    self._fix_exposure()
        except MemoryError:
            gc.collect()
            return False
        return True

    def restore(self, parts):
        """As `rebuild`, with what there is memory for: as a last resort a detector without second opinion,
        which is a fault that lasts until a whole one is built."""
        if self.sensor.detector is not None and parts & DETECTOR:
            parts &= ~DETECTOR  # it was not given up
        if self.rebuild(parts):
            return
        if self.sensor.detector is not None:
            self._faults.report(m.FAULT_MEMORY)  # the other parts stay as they were
            return
        self._faults.begin(m.FAULT_MEMORY)
        settings = self._settings
        wanted, settings.second_opinion = settings.second_opinion, False
        try:
            self._rebuild_detector()
        except MemoryError:
            gc.collect()
        settings.second_opinion = wanted
        self.rebuild(parts & ~DETECTOR)  # what comes after the detector

    def _rebuild_detector(self):
        """A detector, if need be with the usual radii. Its buffers are the largest there are: on a small heap
        those of the one before are given up when there is no room beside them."""
        sensor = self.sensor
        gc.collect()
        threshold = _collect_often()
        try:
            self._make_detector()
        except MemoryError:
            if sensor.detector is None or _heap_bytes() >= _TWO_DETECTORS:
                raise
            sensor.detector = None
            gc.collect()
            self._make_detector()
        finally:
            if threshold is not None:
                gc.threshold(threshold)

    def _make_detector(self):
        try:
            self.sensor.rebuild(DETECTOR)
        except ValueError:  # they suit the size that was set, but not yet that of the frames
            self._faults.begin(m.FAULT_SETTINGS_CORRUPT)
            self.sensor.rebuild(DETECTOR, Settings())

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
