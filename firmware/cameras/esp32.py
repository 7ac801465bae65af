"""ESP32-S3 boards with the community's `camera` module (micropython-camera-API 0.4 and later).

The module has no time-stamps, no window and no exposure in microseconds: the exposure is counted in sensor
lines, whose duration here is that of an OV2640 at 25 frames a second and only about right.
"""

import math
import time

import uctypes
from camera import Camera, FrameSize, GrabMode, PixelFormat

from cameras import CameraError

_LINE_US = 60
_LINES_MAX = 1200
_GAIN_STEPS_MAX = 30  # the sensor's step n amplifies by n + 1
_SIZES = {
    (160, 120): "QQVGA",
    (240, 240): "R240X240",
    (320, 240): "QVGA",
    (400, 296): "CIF",
    (640, 480): "VGA",
}


class EspCamera:
    """width, height: one of the sensor's frame sizes; readout_us: from the end of the exposure until the
    frame is complete; pins: keyword arguments of camera.Camera, for firmware that does not know the board."""

    ended = False

    def __init__(self, width, height, exposure_us=1000, gain_cdb=0, readout_us=0, pins=None, clock=time):
        self.width, self.height = width, height
        self._exposure_us, self._gain_cdb = exposure_us, gain_cdb
        self._readout_us = readout_us
        self._pins = pins or {}
        self._clock = clock
        self._camera = None
        self._address = 0

    def start(self):
        self.frame = None
        self.frame_number = -1
        self.skipped = 0
        self.capture_us = self._clock.ticks_us()
        name = _SIZES.get((self.width, self.height))
        if name is None:
            raise CameraError("the sensor has no frame size %dx%d" % (self.width, self.height))
        try:
            self._camera = Camera(
                frame_size=getattr(FrameSize, name),
                pixel_format=PixelFormat.GRAYSCALE,
                fb_count=2,
                grab_mode=GrabMode.LATEST,
                **self._pins,
            )
            self._camera.set_exposure_ctrl(False)
            self._camera.set_gain_ctrl(False)
            self.gain(self._gain_cdb)
            self.exposure(self._exposure_us)
            self._asked_us = self._clock.ticks_us()
        except (OSError, ValueError, AttributeError, TypeError) as error:
            raise CameraError("camera: %s" % error)

    def grab(self):
        camera = self._camera
        asked_us, self._asked_us = self._asked_us, self._clock.ticks_us()
        try:
            if hasattr(camera, "frame_available") and not camera.frame_available():
                return False
            view = camera.capture()
        except OSError as error:
            raise CameraError("camera: %s" % error)
        if view is None:
            raise CameraError("camera: no frame could be captured")
        if len(view) != self.width * self.height:
            raise CameraError("camera: a frame of %d bytes" % len(view))
        self.frame_number += 1
        # nothing tells when the frame was complete: after it was asked for in vain, or the one before came
        self.capture_us = self._clock.ticks_add(asked_us, -self._readout_us - (self._exposure_us >> 1))
        address = uctypes.addressof(view)
        if self.frame is None or address != self._address:
            self._address = address
            self.frame = uctypes.bytearray_at(address, len(view))  # the module's view is of signed bytes
        return True

    def exposure(self, us=None):
        if us is not None:
            lines = max(1, min(_LINES_MAX, us // _LINE_US))
            try:
                self._camera.set_aec_value(lines)
            except (OSError, ValueError) as error:
                raise CameraError("camera: %s" % error)
            self._exposure_us = lines * _LINE_US
        return self._exposure_us

    def gain(self, cdb=None):
        if cdb is not None:
            step = max(0, min(_GAIN_STEPS_MAX, round(10 ** (cdb / 2000)) - 1))
            try:
                self._camera.set_agc_gain(step)
            except (OSError, ValueError) as error:
                raise CameraError("camera: %s" % error)
            self._gain_cdb = round(2000 * math.log10(step + 1))
        return self._gain_cdb

    def stop(self):
        self.frame = None
        if self._camera is not None:
            try:
                self._camera.deinit()
            except OSError:
                pass  # a sensor that does not answer cannot be switched off either
            self._camera = None
