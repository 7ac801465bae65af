"""OpenMV's `csi` module (OpenMV 4.7 and later), without copying a frame.

Only sizes that every board takes are asked for (AE3 refuses others): the smallest of QVGA, VGA and HD that
holds the wanted frame, and a window cut out of its middle. Exposure and gain are set last, because some
sensors limit the exposure anew whenever size or rate change. The frame rate is left alone: setting it stops
some sensors for good.
"""

import time

import csi

from cameras import CameraError

_SETTLE_MS = 300  # the first frames after a change of size are old or dark


class CsiCamera:
    """width, height: wanted frame; readout_us: from the end of the exposure until the frame is complete."""

    ended = False

    def __init__(self, width, height, exposure_us=1000, gain_cdb=0, readout_us=0, clock=time):
        self.width, self.height = width, height
        self._exposure_us, self._gain_cdb = exposure_us, gain_cdb
        self._readout_us = readout_us
        self._clock = clock
        self._csi = None
        self._image = None
        self._completed = 0
        self._completed_us = 0
        self._counted = False

    def start(self):
        self.frame = None
        self.frame_number = -1
        self.skipped = 0
        self.capture_us = self._clock.ticks_us()
        try:
            self._csi = csi.CSI()
            self._csi.reset()
            self._csi.pixformat(csi.GRAYSCALE)
            self._set_size()
            self._csi.framebuffers(3)  # one is read, one is filled, one is the newest
            self._csi.snapshot(time=_SETTLE_MS)
            self._csi.auto_gain(False, gain_db=self._gain_cdb * 0.01)
            self._csi.auto_exposure(False, exposure_us=self._exposure_us)
            self._exposure_us = self._csi.exposure_us()
        except (RuntimeError, ValueError, AttributeError) as error:
            raise CameraError("csi: %s" % error)
        self._asked_us = self._clock.ticks_us()
        self._completed = 0
        self._counted = hasattr(self._csi, "frame_callback")
        if self._counted:
            self._csi.frame_callback(self._on_frame)

    def _smallest_size(self):
        for entry in ((csi.QVGA, 320, 240), (csi.VGA, 640, 480), (csi.HD, 1280, 720)):
            if self.width <= entry[1] and self.height <= entry[2]:
                return entry
        raise CameraError("no frame size holds %dx%d" % (self.width, self.height))

    def _set_size(self):
        size, width, height = self._smallest_size()
        self._csi.framesize(size)
        if (self.width, self.height) != (width, height):
            self._csi.window((self.width, self.height))
        _, _, width, height = self._csi.window()
        if (width, height) != (self.width, self.height):
            raise CameraError("the sensor gives %dx%d, not %dx%d" % (width, height, self.width, self.height))

    def _on_frame(self):
        # runs in the camera's interrupt: nothing may be allocated here
        self._completed_us = self._clock.ticks_us()
        self._completed = (self._completed + 1) & 0x3FFFFFFF

    def grab(self):
        asked_us, self._asked_us = self._asked_us, self._clock.ticks_us()
        number, complete_us = self._completed - 1, self._completed_us
        try:
            image = self._csi.snapshot(blocking=False)
        except RuntimeError as error:
            raise CameraError("csi: %s" % error)
        if image is None:
            return False
        if not (self._counted and self._completed):
            # nothing tells when it was complete: after it was asked for in vain, or the one before came
            number, complete_us = self.frame_number + 1, asked_us
        elif number <= self.frame_number:  # it came just now
            number, complete_us = self._completed - 1, self._completed_us
        if number > self.frame_number + 1:
            self.skipped += number - self.frame_number - 1
        self.frame_number = max(number, self.frame_number + 1)
        self.capture_us = self._clock.ticks_add(complete_us, -self._readout_us - (self._exposure_us >> 1))
        self._image = image  # keeps the pixels alive
        self.frame = image.bytearray()
        if len(self.frame) != self.width * self.height:
            raise CameraError("csi: a frame of %d bytes" % len(self.frame))
        return True

    def exposure(self, us=None):
        if us is not None:
            try:
                self._csi.auto_exposure(False, exposure_us=us)
                self._exposure_us = self._csi.exposure_us()
            except RuntimeError as error:
                raise CameraError("csi: %s" % error)
        return self._exposure_us

    def gain(self, cdb=None):
        if cdb is not None:
            try:
                self._csi.auto_gain(False, gain_db=cdb * 0.01)
                self._gain_cdb = round(self._csi.gain_db() * 100)
            except RuntimeError as error:
                raise CameraError("csi: %s" % error)
        return self._gain_cdb

    def stop(self):
        self.frame = self._image = None
        if self._csi is not None:
            try:
                if self._counted:
                    self._csi.frame_callback(None)
                self._csi.shutdown(True)
            except RuntimeError:
                pass  # a sensor that does not answer cannot be switched off either
            self._csi = None
