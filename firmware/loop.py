"""The loop: line, camera, newest frame, detection, report; once a second the status. Nothing stops it.

In steady state a round allocates nothing. An exception in a stage costs that stage's work for one frame,
is counted as a fault and reported by its code.
"""

import gc
import time

from larics.device.measurements import Measuring
from larics.wire import messages as m

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

# generated: begin indices (tools/make_protocol.py)
_STATUS_UPTIME_S = const(4)
# generated: end indices

_STATUS_MS = 1000
_CAMERA_TIMEOUT_MS = 1000
_CAMERA_RETRY_MS = 2000
_COASTING_MS = 500
_BANNER_S = 15


class Loop:
    """Runs the stages; see `step`. `parts`: object with

    camera     started driver, see cameras
    detector   detect(frame) -> list of Detection
    locator    larics.locate.camera_model.Camera; calibrated: whether its millimetres mean anything
    exposure   exposure.Exposure, or None when the exposure is fixed
    navigator  larics.locate.navigator.Navigator, or None without a map
    settings   larics.settings.Settings
    link, outbox, reports, commands, faults, health, decoder
    leds, watchdog, banner; sentinel: guard.SafeMode or None

    `camera_ok`: whether the camera is started; if not, it is tried again and again.
    """

    def __init__(self, parts, camera_ok=True, clock=time):
        self._parts = parts
        self._clock = clock
        self._measuring = Measuring()
        self._measurements = self._measuring.measurements
        self._skipped = 0
        now_ms = clock.ticks_ms()
        self._seen_ms = now_ms
        self._frame_ms = now_ms
        self._status_ms = now_ms
        self._shown_ms = now_ms
        self._camera_ok = camera_ok

    def run(self):
        """Until the camera says that no frame can come any more (recordings only) or a restart is due."""
        parts = self._parts
        while not parts.camera.ended and not (parts.commands.restart_due and parts.outbox.idle()):
            self.step()
        self.close()

    def close(self, limit_ms=2000):
        """Sends a last status and all that waits, for at most limit_ms."""
        parts, clock = self._parts, self._clock
        self._report_status()
        start_ms = clock.ticks_ms()
        idle = False
        while not idle and clock.ticks_diff(clock.ticks_ms(), start_ms) < limit_ms:
            idle = parts.outbox.idle()
            self._serve_line()
            idle = idle and not parts.link.pending()

    def step(self):
        """One round; True when a frame was processed."""
        processed = False
        try:
            self._serve_line()
            if self._grab():
                processed = self._process()
                self._serve_line()
            now_ms = self._clock.ticks_ms()
            if self._clock.ticks_diff(now_ms, self._status_ms) >= 0:
                self._report_status()
            self._show(now_ms)
            self._parts.watchdog.feed()
        except MemoryError:
            self._parts.faults.report(m.FAULT_MEMORY)
            gc.collect()
        except Exception:
            self._parts.faults.report(m.FAULT_LOOP)
        return processed

    def _show(self, now_ms):
        parts = self._parts
        state = parts.health.state
        elapsed_ms = self._clock.ticks_diff(now_ms, self._shown_ms)
        self._shown_ms = now_ms
        parts.leds.show(state == m.TRACKING, state == m.COASTING, parts.faults.active, elapsed_ms)

    def _serve_line(self):
        parts = self._parts
        link, faults = parts.link, parts.faults
        try:
            link.poll()
        except MemoryError:
            faults.report(m.FAULT_MEMORY)
            gc.collect()
        except Exception:
            faults.report(m.FAULT_COMMAND)
        parts.outbox.poll(self._clock.ticks_us())
        link.pump()
        if link.failed or link.stalled:
            faults.begin(m.FAULT_UART_WRITE)
        else:
            faults.end(m.FAULT_UART_WRITE)

    def _grab(self):
        camera, faults = self._parts.camera, self._parts.faults
        now_ms = self._clock.ticks_ms()
        if not self._camera_ok:
            return self._restart_camera(now_ms)
        try:
            if camera.grab():
                self._frame_ms = now_ms
                faults.end(m.FAULT_CAMERA_TIMEOUT)
                health = self._parts.health
                health.missed = (health.missed + camera.skipped - self._skipped) & m.COUNT_MAX
                self._skipped = camera.skipped
                return True
            if camera.ended or self._clock.ticks_diff(now_ms, self._frame_ms) < _CAMERA_TIMEOUT_MS:
                return False
            faults.begin(m.FAULT_CAMERA_TIMEOUT)
        except MemoryError:
            faults.report(m.FAULT_MEMORY)
            gc.collect()
            return False
        except Exception:
            faults.report(m.FAULT_CAMERA)
        self._camera_ok = False
        self._frame_ms = self._clock.ticks_add(now_ms, -_CAMERA_RETRY_MS)  # at once, the first time
        return False

    def _restart_camera(self, now_ms):
        if self._clock.ticks_diff(now_ms, self._frame_ms) < _CAMERA_RETRY_MS:
            return False
        camera, faults = self._parts.camera, self._parts.faults
        try:
            camera.stop()
        except Exception:
            faults.report(m.FAULT_CAMERA)
        try:
            camera.start()
            self._skipped = 0
            self._camera_ok = True
            faults.report(m.FAULT_CAMERA_RESET)
        except Exception:
            faults.report(m.FAULT_CAMERA)
            gc.collect()
        self._frame_ms = self._clock.ticks_ms()
        return False

    def _process(self):
        clock, parts = self._clock, self._parts
        if parts.detector is None:
            return False
        start_us = clock.ticks_us()
        try:
            found = parts.detector.detect(parts.camera.frame)
        except MemoryError:
            parts.faults.report(m.FAULT_MEMORY)
            gc.collect()
            return False
        except Exception:
            parts.faults.report(m.FAULT_DETECT)
            return False
        detect_us = clock.ticks_diff(clock.ticks_us(), start_us)
        count = self._measuring.locate(found, parts.settings, parts.locator, parts.navigator)
        parts.health.rejects = (parts.health.rejects + self._measuring.rejected) & m.COUNT_MAX
        parts.health.frame_done(count, detect_us)
        self._update_state(count)
        if parts.outbox.begin():
            self._report(count)
        if parts.exposure is not None:
            self._expose(found)
        return True

    def _expose(self, found):
        parts, camera = self._parts, self._parts.camera
        try:
            parts.exposure.update(camera.frame, camera.width, camera.height, found)
        except MemoryError:
            parts.faults.report(m.FAULT_MEMORY)
            gc.collect()
        except Exception:
            parts.faults.report(m.FAULT_CAMERA)

    def _update_state(self, count):
        parts, clock = self._parts, self._clock
        if parts.navigator is not None:
            capture_us = parts.camera.capture_us & m.COUNT_MAX
            parts.health.state = parts.navigator.update(self._measurements, count, capture_us)
            if parts.navigator.fault:
                parts.faults.report(parts.navigator.fault)
            return
        now_ms = clock.ticks_ms()
        for index in range(count):
            measurement = self._measurements[index]
            if measurement.marker_id >= 0 and not measurement.flags & m.MARKER_UNCONFIRMED:
                self._seen_ms = now_ms
                parts.health.state = m.TRACKING
                return
        if parts.health.state != m.LOST:
            coasts = clock.ticks_diff(now_ms, self._seen_ms) < _COASTING_MS
            parts.health.state = m.COASTING if coasts else m.LOST

    def _report(self, count):
        clock, parts = self._clock, self._parts
        reports = parts.reports
        frame = parts.camera.frame_number & m.COUNT_MAX
        calibrated = parts.calibrated
        now_us = clock.ticks_us()
        age_us = max(0, clock.ticks_diff(now_us, parts.camera.capture_us))
        if not count:
            reports.no_marker(frame, age_us)
        for index in range(count):
            reports.marker(frame, age_us, index, count, self._measurements[index], calibrated)
        if parts.navigator is not None:
            reports.pose(frame, age_us, parts.navigator)
        parts.outbox.commit(now_us)

    def _report_status(self):
        clock, parts = self._clock, self._parts
        now_ms = clock.ticks_ms()
        while clock.ticks_diff(now_ms, self._status_ms) >= 0:
            self._status_ms = clock.ticks_add(self._status_ms, _STATUS_MS)
        values = parts.health.fill(parts.camera, parts.outbox, parts.decoder.counters)
        parts.outbox.status(m.STATUS, values)
        if parts.sentinel is not None:
            parts.sentinel.settled(values[_STATUS_UPTIME_S])
        if parts.banner and values[_STATUS_UPTIME_S] <= _BANNER_S:
            print(parts.banner)
