"""The loop: line, camera, newest frame, detection, report; once a second the status. Nothing stops it.

In steady state a round allocates nothing. An exception in a stage costs that stage's work for one frame,
is counted as a fault and reported by its code.
"""

import gc
import time

from larics import messages as m
from larics.camera import Measurement
from reports import VERSION

_MARKERS_MAX = 8  # reported of one frame
_STATUS_MS = 1000
_HEAP_EVERY = 10  # statuses: looking for free memory walks the whole heap
_CAMERA_TIMEOUT_MS = 1000
_CAMERA_RETRY_MS = 2000
_COASTING_MS = 500
_GREY_STEPS = 16  # rows and columns of the grid of pixels whose mean is reported


class Loop:
    """Runs the stages; see `step`.

    camera     started driver, see cameras
    detector   object with detect(frame) -> list of Detection
    locator    larics.camera.Camera; calibrated: whether its offsets mean anything
    settings   larics.settings.Settings
    link, reports, faults, clock (time's ticks_* functions)
    commands   object with step(), or None
    """

    def __init__(self, camera, detector, locator, settings, link, reports, faults, commands=None, clock=time):
        self.camera = camera
        self.detector = detector
        self.locator = locator
        self.settings = settings
        self.commands = commands
        self._link = link
        self._reports = reports
        self._faults = faults
        self._clock = clock
        self._measurements = [Measurement() for _ in range(_MARKERS_MAX)]
        self._status = [0] * 24
        self.frames = 0
        self.missed = 0
        self.detections = 0
        self.rejects = 0
        self.line_crc_errors = 0
        self.line_errors = 0
        self.state = m.LOST
        self._skipped = 0
        self._divider = 0
        self._uptime_s = 0
        self._grey_mean = 0
        self._free_bytes = 0
        self._until_heap = 0
        now_ms = clock.ticks_ms()
        self._seen_ms = now_ms
        self._frame_ms = now_ms
        self._camera_ok = True
        self._status_ms = now_ms
        self._begin_second()

    def _begin_second(self):
        self._second_us = self._clock.ticks_us()
        self._second_frames = 0
        self._detect_us = 0
        self._latency_us = 0

    def run(self):
        """Until the camera says that no frame can come any more (recordings only), and all is sent."""
        while not self.camera.ended:
            self.step()
        self.report_status()
        self.drain()

    def drain(self, limit_ms=2000):
        """Sends what waits, for at most limit_ms."""
        start_ms = self._clock.ticks_ms()
        while self._clock.ticks_diff(self._clock.ticks_ms(), start_ms) < limit_ms:
            if not self._link.pump() or not self._link.pending():
                return

    def step(self):
        """One round; True when a frame was processed."""
        processed = False
        try:
            self._serve_line()
            if self._grab():
                processed = self._process()
            if self._clock.ticks_diff(self._clock.ticks_ms(), self._status_ms) >= 0:
                self.report_status()
        except MemoryError:
            self._faults.report(m.FAULT_MEMORY)
            gc.collect()
        except Exception:
            self._faults.report(m.FAULT_LOOP)
        return processed

    def _serve_line(self):
        link, faults = self._link, self._faults
        link.poll()
        link.pump()
        if link.failed or link.stalled:
            faults.begin(m.FAULT_UART_WRITE)
        else:
            faults.end(m.FAULT_UART_WRITE)
        if self.commands is not None:
            self.commands.step()

    def _grab(self):
        camera = self.camera
        now_ms = self._clock.ticks_ms()
        if not self._camera_ok:
            return self._restart_camera(now_ms)
        try:
            if camera.grab():
                self._frame_ms = now_ms
                self._faults.end(m.FAULT_CAMERA_TIMEOUT)
                self.missed = (self.missed + camera.skipped - self._skipped) & m.COUNT_MAX
                self._skipped = camera.skipped
                return True
            if camera.ended or self._clock.ticks_diff(now_ms, self._frame_ms) < _CAMERA_TIMEOUT_MS:
                return False
            self._faults.begin(m.FAULT_CAMERA_TIMEOUT)
        except MemoryError:
            self._faults.report(m.FAULT_MEMORY)
            gc.collect()
            return False
        except Exception:
            self._faults.report(m.FAULT_CAMERA)
        self._camera_ok = False
        self._frame_ms = self._clock.ticks_add(now_ms, -_CAMERA_RETRY_MS)  # at once, the first time
        return False

    def _restart_camera(self, now_ms):
        if self._clock.ticks_diff(now_ms, self._frame_ms) < _CAMERA_RETRY_MS:
            return False
        try:
            self.camera.stop()
        except Exception:
            self._faults.report(m.FAULT_CAMERA)
        try:
            self.camera.start()
            self._skipped = 0
            self._camera_ok = True
            self._faults.report(m.FAULT_CAMERA_RESET)
        except Exception:
            self._faults.report(m.FAULT_CAMERA)
            gc.collect()
        self._frame_ms = self._clock.ticks_ms()
        return False

    def _process(self):
        clock, camera = self._clock, self.camera
        start_us = clock.ticks_us()
        try:
            found = self.detector.detect(camera.frame)
        except MemoryError:
            self._faults.report(m.FAULT_MEMORY)
            gc.collect()
            return False
        except Exception:
            self._faults.report(m.FAULT_DETECT)
            return False
        self._detect_us += clock.ticks_diff(clock.ticks_us(), start_us)
        count = self._locate(found)
        self.frames = (self.frames + 1) & m.COUNT_MAX
        self._second_frames += 1
        self.detections = (self.detections + count) & m.COUNT_MAX
        self._update_state(count)
        self._divider += 1
        if self._divider >= self.settings.rate_divider:
            self._divider = 0
            self._report(count)
        self._link.pump()
        return True

    def _locate(self, found):
        """Puts the detections that may be reported in place; returns how many."""
        settings, measurements = self.settings, self._measurements
        count = 0
        for detection in found:
            if count == _MARKERS_MAX:
                break
            measurement = measurements[count]
            if not self.locator.locate(detection, measurement, settings.outer_mm10):
                self.rejects = (self.rejects + 1) & m.COUNT_MAX
            elif not self._is_allowed(measurement.marker_id):
                self.rejects = (self.rejects + 1) & m.COUNT_MAX
            else:
                count += 1
        return count

    def _is_allowed(self, marker_id):
        allowed = self.settings.allowed_ids
        return marker_id < 0 or not allowed or marker_id in allowed

    def _update_state(self, count):
        now_ms = self._clock.ticks_ms()
        for index in range(count):
            if self._measurements[index].marker_id >= 0:
                self._seen_ms = now_ms
                self.state = m.TRACKING
                return
        if self.state != m.LOST:
            coasts = self._clock.ticks_diff(now_ms, self._seen_ms) < _COASTING_MS
            self.state = m.COASTING if coasts else m.LOST

    def _report(self, count):
        clock, camera, reports = self._clock, self.camera, self._reports
        frame = camera.frame_number & m.COUNT_MAX
        calibrated = self.settings.focal_q8 > 0
        age_us = clock.ticks_diff(clock.ticks_us(), camera.capture_us)
        if not count:
            reports.no_marker(frame, age_us)
        for index in range(count):
            age_us = clock.ticks_diff(clock.ticks_us(), camera.capture_us)
            reports.marker(frame, age_us, index, count, self._measurements[index], calibrated)
        if age_us > self._latency_us:
            self._latency_us = age_us

    def report_status(self):
        """Sends the status message and begins the next second."""
        clock, status = self._clock, self._status
        now_ms = clock.ticks_ms()
        while clock.ticks_diff(now_ms, self._status_ms) >= 0:
            self._status_ms = clock.ticks_add(self._status_ms, _STATUS_MS)
            self._uptime_s += 1
        if not self._until_heap and hasattr(gc, "mem_free"):
            self._free_bytes = gc.mem_free() & m.COUNT_MAX
            self._until_heap = _HEAP_EVERY
        self._until_heap -= 1
        self._measure_grey()
        frames = self._second_frames
        second_us = max(1, clock.ticks_diff(clock.ticks_us(), self._second_us))
        faults = self._faults
        status[0] = VERSION[0]
        status[1] = VERSION[1]
        status[2] = VERSION[2]
        status[3] = self._reports.boot
        status[4] = self._uptime_s - 1
        status[5] = self.frames
        status[6] = self.missed
        status[7] = self.detections
        status[8] = self.rejects
        status[9] = self._link.dropped
        status[10] = self.line_crc_errors
        status[11] = self.line_errors
        status[12] = faults.total
        status[13] = faults.last
        status[14] = faults.active
        status[15] = self.state
        status[16] = self.camera.exposure()
        status[17] = self.camera.gain()
        status[18] = self._grey_mean
        status[19] = frames * 100000 // max(1, second_us // 1000)
        status[20] = second_us // frames if frames else 0
        status[21] = self._detect_us // frames if frames else 0
        status[22] = self._latency_us
        status[23] = self._free_bytes
        self._reports.send(m.STATUS, status)
        self._begin_second()

    def _measure_grey(self):
        frame = self.camera.frame
        if not frame:
            return
        step = max(1, len(frame) // (_GREY_STEPS * _GREY_STEPS) | 1)  # odd, so that it meets every column
        total = count = place = 0
        while place < len(frame):
            total += frame[place]
            count += 1
            place += step
        self._grey_mean = total // count
