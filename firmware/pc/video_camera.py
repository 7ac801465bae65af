"""A camera driver over a video source: a thread fetches, the newest frame wins, a lost source is reopened."""

import threading
import time

from cameras import CameraError
from pc import host_clock

_REOPEN_S = 1.0
_WAIT_S = 0.002  # grab() waits so long for a frame, or the loop of the program would spin
_FRAMES = (1 << 30) - 1


class VideoCamera:
    """A driver as in cameras. `open_source()` makes a VideoSource; its errors at the first start are raised.

    A file is played at its own pace and ends the camera; with `every`, each of its frames is processed and
    reported, however long that takes: the next one is fetched when `ready()` says so.
    """

    def __init__(self, open_source, every=False):
        self._open = open_source
        self._every = every
        self._changed = threading.Condition()
        self._turn = 0  # of the thread that may deliver; one that hangs in a read when stopped is left alone
        self._thread = None
        self._waiting = None  # (frame, monotonic s), the newest
        self._exposure_us, self._gain_cdb = 1000, 0
        self._wanted_us = None
        self._count = 0
        self._fetched = 0
        self.width = self.height = 0
        self.frame = None
        self.frame_number = -1
        self.capture_us = 0
        self.skipped = 0
        self.ended = False
        self.adjustable = False
        self.ready = lambda: True

    def start(self):
        """Opens the source; later ones return at once, and the source is opened as soon as it is there."""
        self.stop()
        source = None
        if not self.width:
            source = self._open()
            self.width, self.height = source.width, source.height
            self.frame = bytearray(self.width * self.height)
            self.adjustable = source.kind == "device" and source.exposure(self._exposure_us)
        self.skipped = 0
        self._fetched = self._count
        self._thread = threading.Thread(
            target=self._run, args=(source, self._turn), name="frames", daemon=True
        )
        self._thread.start()

    def _run(self, source, turn):
        while self._turn == turn:
            try:
                if source is None:
                    source = self._open()
                    if (source.width, source.height) != (self.width, self.height):
                        raise CameraError("the size of the frames changed: start again")
                self._fetch(source, turn)
                if self.ended:
                    break
            except (CameraError, OSError):
                pass  # the program notices that no frame comes, and tells it as a fault
            if source is not None:
                source.close()
                source = None
            with self._changed:
                self._changed.wait_for(lambda: self._turn != turn, _REOPEN_S)
        if source is not None:
            source.close()

    def _fetch(self, source, turn):
        """Fetches frames until the source gives none any more."""
        while self._turn == turn:
            if self._wanted_us is not None:
                source.exposure(self._wanted_us)
                self._wanted_us = None
            got = source.read()
            if got is None:
                if source.kind == "file":
                    self._finish(turn)
                return
            frame, taken_s = got
            if source.kind == "file" and not self._every:
                time.sleep(max(0.0, taken_s - time.monotonic()))
            with self._changed:
                if self._turn != turn:
                    return
                if self._every:
                    self._changed.wait_for(lambda: self._turn != turn or self._waiting is None)
                    taken_s = time.monotonic()
                self._count += 1
                self._waiting = frame, taken_s
                self._changed.notify_all()

    def _finish(self, turn):
        """The recording is over when its last frame was fetched."""
        with self._changed:
            self._changed.wait_for(lambda: self._turn != turn or self._waiting is None)
            self.ended = self._turn == turn
            self._changed.notify_all()

    def grab(self):
        if self._every and not self.ready():
            return False
        with self._changed:
            if self._waiting is None and not self.ended:
                self._changed.wait(_WAIT_S)
            if self._waiting is None:
                return False
            frame, taken_s = self._waiting
            self._waiting = None
            count = self._count
            self._changed.notify_all()
        self.frame[:] = frame.reshape(-1).data
        self.skipped += count - self._fetched - 1
        self._fetched = count
        self.frame_number = (count - 1) & _FRAMES
        self.capture_us = host_clock.ticks_of(taken_s)
        return True

    def exposure(self, us=None):
        if us is not None:
            self._exposure_us = self._wanted_us = us
        return self._exposure_us

    def gain(self, cdb=None):
        if cdb is not None:
            self._gain_cdb = cdb
        return self._gain_cdb

    def stop(self):
        with self._changed:
            self._turn += 1
            self._waiting = None
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join(0.2)
            self._thread = None
