"""OpenMV's older `sensor` module, for firmware without `csi`; the same rules as in openmv_csi.py."""

import time

import sensor

from cameras import CameraError

_SETTLE_MS = 300
_STALLED_MS = 200  # then a blocking snapshot is taken, which starts the capture again or says what is wrong


class SensorCamera:
    """width, height: wanted frame; readout_us: from the end of the exposure until the frame is complete."""

    ended = False

    def __init__(self, width, height, exposure_us=1000, gain_cdb=0, readout_us=0, clock=time):
        self.width, self.height = width, height
        self._exposure_us, self._gain_cdb = exposure_us, gain_cdb
        self._readout_us = readout_us
        self._clock = clock
        self._image = None

    def start(self):
        self.frame = None
        self.frame_number = -1
        self.skipped = 0
        self.capture_us = self._clock.ticks_us()
        self._last_ms = self._clock.ticks_ms()
        try:
            sensor.reset()
            sensor.set_pixformat(sensor.GRAYSCALE)
            self._set_size()
            sensor.set_framebuffers(3)
            sensor.skip_frames(time=_SETTLE_MS)
            sensor.set_auto_gain(False, gain_db=self._gain_cdb * 0.01)
            sensor.set_auto_exposure(False, exposure_us=self._exposure_us)
            self._exposure_us = sensor.get_exposure_us()
        except (RuntimeError, ValueError, AttributeError) as error:
            raise CameraError("sensor: %s" % error)
        self._asked_us = self._clock.ticks_us()

    def _smallest_size(self):
        for entry in ((sensor.QVGA, 320, 240), (sensor.VGA, 640, 480), (sensor.HD, 1280, 720)):
            if self.width <= entry[1] and self.height <= entry[2]:
                return entry
        raise CameraError("no frame size holds %dx%d" % (self.width, self.height))

    def _set_size(self):
        size, width, height = self._smallest_size()
        sensor.set_framesize(size)
        if (self.width, self.height) != (width, height):
            sensor.set_windowing((self.width, self.height))
        _, _, width, height = sensor.get_windowing()
        if (width, height) != (self.width, self.height):
            raise CameraError("the sensor gives %dx%d, not %dx%d" % (width, height, self.width, self.height))

    def grab(self):
        now_ms = self._clock.ticks_ms()
        asked_us, self._asked_us = self._asked_us, self._clock.ticks_us()
        if not sensor.get_frame_available():
            if self._clock.ticks_diff(now_ms, self._last_ms) < _STALLED_MS:
                return False
        self._last_ms = now_ms
        try:
            image = sensor.snapshot()
        except RuntimeError as error:
            raise CameraError("sensor: %s" % error)
        self.frame_number += 1
        # nothing tells when the frame was complete: after it was asked for in vain, or the one before came
        self.capture_us = self._clock.ticks_add(asked_us, -self._readout_us - (self._exposure_us >> 1))
        self._image = image  # keeps the pixels alive
        self.frame = image.bytearray()
        if len(self.frame) != self.width * self.height:
            raise CameraError("sensor: a frame of %d bytes" % len(self.frame))
        return True

    def exposure(self, us=None):
        if us is not None:
            try:
                sensor.set_auto_exposure(False, exposure_us=us)
                self._exposure_us = sensor.get_exposure_us()
            except RuntimeError as error:
                raise CameraError("sensor: %s" % error)
        return self._exposure_us

    def gain(self, cdb=None):
        if cdb is not None:
            try:
                sensor.set_auto_gain(False, gain_db=cdb * 0.01)
                self._gain_cdb = round(sensor.get_gain_db() * 100)
            except RuntimeError as error:
                raise CameraError("sensor: %s" % error)
        return self._gain_cdb

    def stop(self):
        self.frame = self._image = None
        try:
            sensor.shutdown(True)
        except RuntimeError:
            pass  # a sensor that does not answer cannot be switched off either
