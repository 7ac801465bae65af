"""Watches over the camera: a driver that fails or falls silent is started again, for as long as it takes."""

import gc

from larics.device.frame_check import FrameCheck
from larics.locate.localizer import SILENT_US
from larics.wire import messages as m

_TIMEOUT_MS = SILENT_US // 1000
_RETRY_MS = 2000
_HELD_MS = 1500  # a frame that was sent stays for chunks that are asked for again
_COPIES = 5  # in a row are a fault; one or two may come from a driver that was asked too early
_BLIND = 10  # frames in a row, black or white: by then the exposure has tried


def _tell(faults, code, count, least):
    if count >= least:
        faults.begin(code)
    elif not count:
        faults.end(code)


class CameraWatch:
    """camera         driver, see cameras; started: whether its start succeeded
    frame_number   of the newest frame: goes on where a driver that was started again begins anew, so that it
                   never goes back before 2**30 frames
    missed         counts the frames that the camera made and nobody fetched
    check          frame_check.FrameCheck of the newest frame

    A frame that is the one before once more is no new frame: it would only repeat what was measured already,
    as if it had been measured again. A camera that serves nothing else is treated as one that is silent.
    """

    def __init__(self, camera, faults, clock, started=True):
        self.camera = camera
        self.frame_number = -1
        self.missed = 0
        self.check = FrameCheck()
        self._copies = self._dark = self._white = 0  # in a row
        self._driver_number = -1  # the same as the driver counts it
        self._held = None
        self._held_ms = 0
        self._faults = faults
        self._clock = clock
        self._started = started
        self._skipped = 0  # of the driver, at the last frame
        self._frame_ms = clock.ticks_ms()  # of the newest frame, or a time-out ago if that is later
        self._start_ms = self._frame_ms  # of the last start, or of the end of the opening that followed

    def hold(self, raw):
        """Fetches no frame until `raw`, a RawSender, has sent the newest one, and what may be asked again."""
        self._held = raw
        self._held_ms = self._clock.ticks_ms()

    def _is_held(self, now_ms):
        if self._held is None:
            return False
        if self._held.busy():
            self._held_ms = now_ms
        if self._clock.ticks_diff(now_ms, self._held_ms) < _HELD_MS:
            self._frame_ms = self._start_ms = now_ms  # the camera is not to blame
            return True
        self._held.forget()
        self._held = None
        return False

    def grab(self):
        """True when `camera.frame` is a new frame. Never raises and never waits but for a start."""
        camera, faults, clock = self.camera, self._faults, self._clock
        now_ms = clock.ticks_ms()
        if self._is_held(now_ms):
            return False
        if not self._started:
            return self._restart(now_ms)
        try:
            if camera.grab():
                faults.end(m.FAULT_CAMERA_TIMEOUT)
                self._count()
                if self._is_new():
                    self._frame_ms = self._start_ms = now_ms
                    return True
            if not self._is_silent(now_ms):
                return False
        except MemoryError:
            faults.report(m.FAULT_MEMORY)
            gc.collect()
            return False
        except Exception:
            faults.report(m.FAULT_CAMERA)
        self._started = False
        self._start_ms = clock.ticks_add(now_ms, -_RETRY_MS)  # at once, the first time
        return False

    def _is_silent(self, now_ms):
        """Whether no new frame has come for so long that another start may help; tells it as a fault."""
        camera, clock = self.camera, self._clock
        if getattr(camera, "opening", False):
            self._start_ms = now_ms  # to start it again would only begin the opening anew
        if camera.ended or clock.ticks_diff(now_ms, self._frame_ms) < _TIMEOUT_MS:
            return False
        self._frame_ms = clock.ticks_add(now_ms, -_TIMEOUT_MS)  # or the clock would wrap
        if not self._copies:
            self._faults.begin(m.FAULT_CAMERA_TIMEOUT)
        elif not getattr(camera, "adjustable", True):
            return False  # a recording: begun anew, it would be the same
        return clock.ticks_diff(now_ms, self._start_ms) >= _TIMEOUT_MS

    def _is_new(self):
        """Whether the frame may count as one, and not as a copy of the one before; tells what it shows."""
        check, faults = self.check, self._faults
        check.update(self.camera.frame)
        self._copies = self._copies + 1 if check.is_copy else 0
        self._dark = self._dark + 1 if check.is_dark else 0
        self._white = self._white + 1 if check.is_white else 0
        _tell(faults, m.FAULT_CAMERA_FROZEN, self._copies, _COPIES)
        _tell(faults, m.FAULT_CAMERA_DARK, self._dark, _BLIND)
        _tell(faults, m.FAULT_CAMERA_WHITE, self._white, _BLIND)
        return not check.is_copy

    def _count(self):
        """Takes over the driver's numbers, as far as they go up."""
        camera = self.camera
        steps = camera.frame_number - self._driver_number
        self._driver_number = camera.frame_number
        self.frame_number = (self.frame_number + max(1, steps)) & m.COUNT_MAX
        self.missed = (self.missed + max(0, camera.skipped - self._skipped)) & m.COUNT_MAX
        self._skipped = camera.skipped

    def _restart(self, now_ms):
        if self._clock.ticks_diff(now_ms, self._start_ms) < _RETRY_MS:
            return False
        camera, faults = self.camera, self._faults
        try:
            camera.stop()
        except Exception:
            faults.report(m.FAULT_CAMERA)
        try:
            camera.start()
            self._skipped = 0
            self._driver_number = camera.frame_number
            self._started = True
            faults.report(m.FAULT_CAMERA_RESET)
        except Exception:
            faults.report(m.FAULT_CAMERA)
            gc.collect()
        self._start_ms = self._clock.ticks_ms()
        return False
