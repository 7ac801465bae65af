"""The parts of the running program that settings make, each made anew only when a setting of its own changes.

Whatever the settings say, the program keeps running: what does not suit the frames is made with the usual
settings instead, and reported.
"""

import gc
import sys

import heap
from larics.arith.fixed import forget_words
from larics.device.sensor import Sensor
from larics.settings import Settings
from larics.settings.fields import DETECTOR, EXPOSURE, LOCATOR, NAVIGATOR
from larics.wire import messages as m

_WITH_SECOND_OPINION = 176 << 10  # free bytes on a small heap without which its code is not even loaded:
# once loaded, MicroPython never frees native code
_WITH_MAP = 30 << 10  # more, where the pose in a map takes as much: it comes before the second opinion
_RESERVE = 16384  # what a detector leaves to the rest of the program there: commands, settings, a map
_LEAST_RADII_PX = (0, 15, 22)  # where even less fits: rings that small need finer grids


def _reserve():
    """Memory that the detector about to be made cannot have, where there is little."""
    try:
        return bytearray(_RESERVE) if heap.small else None
    except MemoryError:  # cut up: the detector before has left no more, either
        return None


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
        size = (camera.width or settings.width, camera.height or settings.height)
        self.sensor = Sensor(settings, size, weigh_all=not heap.small)
        self.sensor.detector = detector
        self.exposure = None
        self._reduced = False  # whether the detector is not whole for want of memory
        if detector is None:
            self.restore(DETECTOR, leaves_reserve=True)  # most of the program is not there yet
        self.restore(LOCATOR | NAVIGATOR)
        try:
            self._rebuild_exposure()
        except MemoryError:
            faults.begin(m.FAULT_MEMORY)

    def rebuild(self, parts, leaves_reserve=True):
        """Makes those anew that are among `parts`: a sum of the parts of larics.settings.fields.

        False when there is no memory for one of them; then `restore` must follow."""
        try:
            if parts & DETECTOR:
                self._rebuild_whole_or_reduced(leaves_reserve)
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

    def _rebuild_whole_or_reduced(self, leaves_reserve):
        """A whole detector or, where there was none before, one without second opinion once more."""
        reduced = self._reduced
        try:
            self._rebuild_detector(leaves_reserve)
            self._reduced = False
            self._faults.end(m.FAULT_MEMORY)
        except MemoryError:
            if not reduced:
                raise
            self._rebuild_reduced(leaves_reserve)

    def _rebuild_reduced(self, leaves_reserve):
        """A detector without second opinion; where even that does not fit, without small rings, whose fine
        grids take most."""
        settings = self._settings
        wanted = settings.second_opinion, settings.radius_min_px
        settings.second_opinion = False
        try:
            for least_px in _LEAST_RADII_PX:
                settings.radius_min_px = max(wanted[1], least_px)
                if settings.radius_min_px >= settings.radius_max_px:
                    raise MemoryError
                try:
                    return self._rebuild_detector(leaves_reserve)
                except MemoryError:
                    if least_px == _LEAST_RADII_PX[-1]:
                        raise
                    forget_words()
        finally:
            settings.second_opinion, settings.radius_min_px = wanted
            self._reduced = True

    def restore(self, parts, leaves_reserve=False):
        """As `rebuild`, with what there is memory for: as a last resort a detector without second opinion or
        small rings, which is a fault that lasts until a whole one is built."""
        if self.sensor.detector is not None and parts & DETECTOR:
            parts &= ~DETECTOR  # it was not given up
        if self.rebuild(parts, leaves_reserve):
            return
        if self.sensor.detector is not None:
            self._faults.report(m.FAULT_MEMORY)  # the other parts stay as they were
            return
        self._faults.begin(m.FAULT_MEMORY)
        try:
            self._rebuild_reduced(leaves_reserve)
        except MemoryError:
            gc.collect()
        self.rebuild(parts & ~DETECTOR)  # what comes after the detector

    def without_detector(self, call):
        """What `call` returns, done while there is no detector but for its longest buffers, which would not
        find their place again; it is made anew after that."""
        self.sensor.detector = None
        gc.collect()
        result = call()
        gc.collect()
        self.restore(DETECTOR)
        if self._reduced:  # what was left of `call` is gone by now
            self.rebuild(DETECTOR, leaves_reserve=False)
        return result

    def _rebuild_detector(self, leaves_reserve):
        """A detector, if need be with the usual radii. Its buffers are the largest there are: on a small heap
        there is no room for them beside those of the one before, which is given up first."""
        reserve = _reserve() if leaves_reserve else None
        if heap.small:
            self.sensor.detector = None
            gc.collect()
        self._load_code()
        if heap.small:
            heap.room.clear()
            gc.collect()
        self._make_detector()
        del reserve

    def _load_code(self):
        """Imports what a detector takes, so that its buffers lie side by side behind that."""
        if self._settings.method == "larics":
            import larics.detect.detector

            if self._settings.second_opinion:
                if heap.small and "larics.blurred.reader" not in sys.modules:
                    with_map = _WITH_MAP if self._settings.map else 0
                    if heap.free_bytes() < _WITH_SECOND_OPINION + with_map:
                        raise MemoryError
                import larics.blurred.reader  # noqa: F401

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
