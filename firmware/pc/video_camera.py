"""A camera driver over a video source: a thread opens and fetches, the newest frame wins.

Only the thread opens, one source at a time: a device has one user. Whoever restarts the driver waits neither
for an opening nor for a read that hangs, and ends neither; the next thread begins when the one before has
ended.
"""

import threading
import time

from cameras import CameraError
from pc import host_clock

_REOPEN_S = (0.5, 1.0, 2.0, 4.0, 8.0)  # between attempts to open, the longer the more have failed
_OPEN_S = 10.0  # a source, a network or a computer that was busy at the first attempts
_SLOW_S = 1.5  # what fails sooner was refused
_WAIT_S = 0.004  # grab() waits so long for a frame, or the loop of the program would spin
_FRAMES = (1 << 30) - 1
_STOP_S = 0.2


class VideoCamera:
    """A driver as in cameras. `open_source()` makes a VideoSource, or raises CameraError or OSError.

    A file is played at its own pace and ends the camera; with `every`, each of its frames is processed and
    reported, however long that takes: the next one is fetched when `ready()` says so.
    `tell(text)` is called, from the thread, when the source fails, fails for another reason, and is back.
    """

    def __init__(self, open_source, every=False, tell=lambda text: None):
        self._open = open_source
        self._every = every
        self._tell = tell
        self._trouble = ""
        self._changed = threading.Condition()
        self._turn = 0  # of the thread that may deliver
        self._thread = None
        self._first = None  # source that open() opened, for the first thread
        self._waiting = None  # (frame, monotonic s), the newest
        self._exposure_us, self._gain_cdb = 1000, 0
        self._wanted_us = None
        self._count = 0
        self._fetched = 0
        self.width = self.height = self.turned = 0
        self.frame = None
        self.frame_number = -1
        self.capture_us = 0
        self.skipped = 0
        self.ended = False
        self.adjustable = False
        self.opening = False
        self.ready = lambda: True

    def open(self):
        """The first opening, with its errors raised: from then on the size of the frames is known."""
        source = self._first = self._open_patiently()
        self.width, self.height, self.turned = source.width, source.height, source.turned
        self.frame = bytearray(self.width * self.height)
        self.adjustable = source.kind == "device" and source.exposure(self._exposure_us)

    def _open_patiently(self):
        """Opens it, again where nothing came in time; errors that come at once are raised at once."""
        end_s = time.monotonic() + _OPEN_S
        while True:
            begin_s = time.monotonic()
            try:
                return self._open()
            except CameraError:
                now_s = time.monotonic()
                if now_s - begin_s < _SLOW_S or now_s >= end_s:
                    raise

    def start(self):
        """Returns at once, except the first time when nobody called open()."""
        self.stop()
        if not self.width:
            self.open()
        source, self._first = self._first, None
        self.skipped = 0
        self._fetched = self._count
        self.opening = source is None
        before = self._thread
        self._thread = threading.Thread(
            target=self._run, args=(source, self._turn, before), name="frames", daemon=True
        )
        self._thread.start()

    def _run(self, source, turn, before):
        if before is not None:
            before.join()
        failures = 0
        while self._turn == turn and not self.ended:
            count = self._count
            try:
                if source is None:
                    source = self._open_again()
                self._set_opening(turn, False)
                self._fetch(source, turn)
                self._say("" if self.ended or self._turn != turn else "no more frames: opening it again")
            except (CameraError, OSError) as error:
                self._say(str(error))
            self._set_opening(turn, True)
            if source is not None:
                source.close()
                source = None
            failures = 0 if self._count > count + 1 else failures + 1
            with self._changed:
                wait_s = _REOPEN_S[min(failures, len(_REOPEN_S) - 1)]
                self._changed.wait_for(lambda: self._turn != turn or self.ended, wait_s)
        if source is not None:
            source.close()

    def _open_again(self):
        source = self._open()
        if (source.width, source.height) != (self.width, self.height):
            size = source.width, source.height, self.width, self.height
            source.close()
            raise CameraError("frames of %dx%d instead of %dx%d: start again for another size" % size)
        if self.adjustable:
            self._wanted_us = self._exposure_us  # a device forgets it
        return source

    def _set_opening(self, turn, opening):
        with self._changed:
            if self._turn == turn:
                self.opening = opening

    def _say(self, trouble):
        """Once for each change; nothing but a frame ends a trouble."""
        if trouble and trouble != self._trouble:
            self._trouble = trouble
            self._tell(trouble)

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
                self._count += 1 + source.cut  # the camera made those, too
                source.cut = 0
                self._waiting = frame, taken_s
                self._changed.notify_all()
            if self._trouble:
                self._trouble = ""
                self._tell("frames again")

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
        """Ends the thread, or leaves it to end when its read returns."""
        with self._changed:
            self._turn += 1
            self._waiting = None
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join(_STOP_S)
            if not self._thread.is_alive():
                self._thread = None
