"""The loop: line, camera, newest frame, detection, report; once a second the status. Nothing stops it.

In steady state a round allocates nothing. An exception in a stage costs that stage's work for one frame,
is counted as a fault and reported by its code.
"""

import gc
import time

from larics.settings.fields import DETECTOR
from larics.wire import messages as m

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

# generated: begin indices (tools/make_protocol.py)
_STATUS_UPTIME_S = const(4)
# generated: end indices

_STATUS_MS = 1000
_BANNER_S = 15


class Loop:
    """Runs the stages; see `step`. `app`: object with

    watch      camera_watch.CameraWatch with its camera
    parts      parts.Parts: what settings make anew while the program runs
    line, outbox, reports, commands, odometry, faults, status
    leds, watchdog, banner; sentinel: safe_mode.SafeMode or None
    """

    def __init__(self, app, clock=time):
        self._app = app
        self._clock = clock
        self._status_ms = self._shown_ms = clock.ticks_ms()

    def run(self):
        """Until the camera says that no frame can come any more (recordings only) or a restart is due."""
        app = self._app
        while not app.watch.camera.ended and not (app.commands.restart_due and app.outbox.idle()):
            self.step()
        self.close()

    def close(self, limit_ms=2000):
        """Sends a last status and all that waits, for at most limit_ms."""
        app, clock = self._app, self._clock
        self._report_status()
        start_ms = clock.ticks_ms()
        while True:  # at least once: the program may have stood still since
            sent = app.outbox.empty()
            self._serve_line()
            late = clock.ticks_diff(clock.ticks_ms(), start_ms) >= limit_ms
            if late or (sent and not app.line.pending()):
                return

    def step(self):
        """One round; True when a frame was processed."""
        processed = False
        try:
            self._serve_line()
            if self._app.watch.grab():
                processed = self._process()
                self._serve_line()
            now_ms = self._clock.ticks_ms()
            if self._clock.ticks_diff(now_ms, self._status_ms) >= 0:
                self._report_status()
            self._show(now_ms)
            self._app.watchdog.feed()
        except MemoryError:
            self._app.faults.report(m.FAULT_MEMORY)
            gc.collect()
        except Exception:
            self._app.faults.report(m.FAULT_LOOP)
        return processed

    def _show(self, now_ms):
        app = self._app
        state = app.parts.sensor.state(now_ms, self._clock.ticks_us())
        elapsed_ms = self._clock.ticks_diff(now_ms, self._shown_ms)
        self._shown_ms = now_ms
        coasts = state == m.COASTING or state == m.CARRIED
        app.leds.show(state == m.TRACKING, coasts, app.faults.active, elapsed_ms)

    def _serve_line(self):
        app = self._app
        line, faults = app.line, app.faults
        app.odometry.look()
        try:
            line.poll()
        except MemoryError:
            faults.report(m.FAULT_MEMORY)
            gc.collect()
        except Exception:
            faults.report(m.FAULT_COMMAND)
        app.outbox.poll(self._clock.ticks_us())
        line.pump()
        if line.failed or line.stalled:
            faults.begin(m.FAULT_UART_WRITE)
        else:
            faults.end(m.FAULT_UART_WRITE)

    def _process(self):
        clock, app = self._clock, self._app
        camera, sensor = app.watch.camera, app.parts.sensor
        if sensor.detector is None:
            return False  # _report_status tries again
        start_us = clock.ticks_us()
        sensor.found = ()
        try:
            found = sensor.detector.detect(camera.frame)
        except MemoryError:
            app.faults.report(m.FAULT_MEMORY)
            gc.collect()
            return False
        except Exception:
            app.faults.begin(m.FAULT_DETECT)  # until a frame is processed
            return False
        app.faults.end(m.FAULT_DETECT)
        sensor.found = found
        detect_us = clock.ticks_diff(clock.ticks_us(), start_us)
        odometry = app.odometry if app.odometry.heard else None
        if odometry is not None:
            self._serve_line()  # what came meanwhile: the exposure lies between two poses
            odometry.at(camera.capture_us & m.COUNT_MAX)
        count = sensor.place(found)
        app.status.frame_done(count, sensor.rejected, detect_us)
        doubted = sensor.navigator is not None and sensor.navigator.pose.carrier.shares.doubted
        if doubted or app.odometry.is_wild:
            app.faults.begin(m.FAULT_ODOMETRY)
        else:
            app.faults.end(m.FAULT_ODOMETRY)
        fault = sensor.follow(count, camera.capture_us, clock.ticks_ms(), odometry)
        if fault:
            app.faults.report(fault)
        if app.outbox.begin():
            self._report(count)
        if app.parts.exposure is not None:
            self._expose(found)
        return True

    def _expose(self, found):
        app, camera = self._app, self._app.watch.camera
        try:
            app.parts.exposure.update(camera.frame, camera.width, camera.height, found)
        except MemoryError:
            app.faults.report(m.FAULT_MEMORY)
            gc.collect()
        except Exception:
            app.faults.report(m.FAULT_CAMERA)

    def _report(self, count):
        clock, app = self._clock, self._app
        reports, sensor, camera = app.reports, app.parts.sensor, app.watch.camera
        frame = app.watch.frame_number
        now_us = clock.ticks_us()
        age_us = max(0, clock.ticks_diff(now_us, camera.capture_us))
        if not count:
            reports.no_marker(frame, age_us)
        for index in range(count):
            reports.marker(frame, age_us, index, count, sensor.measurements[index], sensor.calibrated)
        if sensor.navigator is not None:
            reports.pose(frame, age_us, sensor.navigator)
        if app.odometry.heard:
            reports.motion(frame, app.odometry)
        app.outbox.commit(now_us)

    def _report_status(self):
        clock, app = self._clock, self._app
        now_ms = clock.ticks_ms()
        while clock.ticks_diff(now_ms, self._status_ms) >= 0:
            self._status_ms = clock.ticks_add(self._status_ms, _STATUS_MS)
        values = app.status.fill(now_ms)
        app.outbox.status(m.STATUS, values)
        if app.parts.sensor.detector is None:
            app.parts.restore(DETECTOR)
        if app.sentinel is not None:
            app.sentinel.settled(values[_STATUS_UPTIME_S])
        if app.banner and values[_STATUS_UPTIME_S] <= _BANNER_S:
            if app.status.frames:
                print(app.banner)
            else:  # whoever has just flashed the board must not take it for running
                print("larics: no frame processed yet, faults %x" % app.faults.active)
