"""Reads a camera's line, or a log, in a thread of its own, and fetches raw frames on request."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Any

from larics.device.sensor import EVERY_PART
from larics.settings import FIELDS
from larics_host.connection.byte_sources import ConnectionLost
from larics_host.connection.client import PATIENT, Client, NoAnswer
from larics_host.connection.receiver import message_of
from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics_host.monitor.state import MonitorState

# what decides what the camera makes of a frame
_OPTICS = ("focal_q8", "ceiling_mm10", "camera_z_mm10", "outer_mm10")
_DECISIVE = tuple(field.name for field in FIELDS if field.rebuilds & EVERY_PART)


class RawPicture:
    """The last raw frame: its number, the IDs in it, the PNG with the detections drawn in, and how far a
    fetch is."""

    def __init__(self) -> None:
        self.number = None
        self.ids: list[int | None] = []  # None: uncertain
        self.png = None
        self.error = None
        self.progress = None  # (chunks received, chunks), None when no fetch is under way
        self.version = 0


class _UntilStopped:
    """The source, which ends when it is to stop: a camera that does not answer is waited for no longer."""

    def __init__(self, source, stop):
        self._source, self._stop = source, stop
        self.write = getattr(source, "write", None)
        self.baud = getattr(source, "baud", 0)

    def read(self):
        return None if self._stop.is_set() else self._source.read()


class Session:
    """Feeds `state`; use `lock` around reading it. `ended` tells why nothing comes any more, else None;
    `failed` whether that is an error.

    live: whether the source is a camera, which can be asked for settings and raw frames.
    """

    def __init__(self, source: Any, state: MonitorState) -> None:
        self.lock = threading.Lock()
        self.state = state
        self.raw = RawPicture()
        self.live = source.live
        self.ended = None
        self.failed = False
        self._source = source
        self._stop = threading.Event()
        self._client = Client(_UntilStopped(source, self._stop), self._on_message, retries=PATIENT)
        self._start_s = time.monotonic()
        self._wanted = threading.Event()
        self._has_map = bool(state.landmarks)
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stop.set()
        self._thread.join(timeout=5)
        self._source.close()

    def fetch_raw(self) -> bool:
        """Asks for a raw frame; `raw` tells what becomes of it. False when that is not possible."""
        if not self.live or self.ended:
            return False
        self._wanted.set()
        return True

    def _on_message(self, number, sequence, values):
        time_s = self._source.time_s if not self.live else self._passed_s()
        message = message_of(number, sequence, values, time_s)
        with self.lock:
            self.state.add(message, self._client.decoder.counters)

    def _passed_s(self):
        return time.monotonic() - self._start_s

    def _run(self):
        try:
            if self.live:
                self._ask()
            while not self._stop.is_set():
                self._client.poll()
                if self.live:
                    with self.lock:
                        self.state.pass_time(self._passed_s())
                if self._wanted.is_set():
                    self._wanted.clear()
                    self._fetch()
        except (ConnectionLost, UserError) as error:
            if self._stop.is_set():
                return
            at_end = isinstance(error, NoAnswer) and not self.live
            self.failed = not at_end
            self.ended = "the log is at its end" if at_end else str(error)
        except BaseException as error:  # a fault of this program: nobody may wait for what does not come
            self.failed, self.ended = True, "reading failed: %r" % error
            raise

    def _ask(self):
        """Who the camera is, and its map; without an answer they stay unknown."""
        try:
            info = self._client.info()
            with self.lock:
                self.state.info = info
            optics = {name: self._client.get(name) for name in _OPTICS}
            with self.lock:
                self.state.set_optics(optics)
            rows = self._client.get("map")
            with self.lock:
                if not self._has_map:
                    self.state.set_map(rows)
        except NoAnswer:
            with self.lock:
                self.state.events.append((0.0, "no answer: " + self._client.why_silent()))

    def _fetch(self):
        try:
            settings = self._client.get_all(_DECISIVE)
            raw = self._client.raw_frame(self._note_progress)
        except UserError as error:
            self._conclude(error=str(error))
            return
        # elsewhere, so that the line is read on meanwhile
        threading.Thread(target=self._draw, args=(raw, settings), daemon=True).start()

    def _conclude(self, number=None, ids=(), png=None, error=None):
        with self.lock:
            if png:
                self.raw.number, self.raw.ids, self.raw.png = number, list(ids), png
            self.raw.error = error
            self.raw.progress = None
            self.raw.version += 1

    def _note_progress(self, received, total):
        with self.lock:
            self.raw.progress = (received, total)

    def _draw(self, raw, settings):
        import cv2
        import numpy as np

        from larics_host.detection.camera_view import CameraView
        from larics_host.images.drawing import draw_detections

        frame = np.frombuffer(raw.pixels, np.uint8).reshape(raw.height, raw.width)
        try:
            found = CameraView(settings, raw.width, raw.height).detect(frame)
        except UserError as error:
            self._conclude(error=str(error))
            return
        png = cv2.imencode(".png", draw_detections(frame, found))[1].tobytes()
        self._conclude(raw.frame, [one["id"] for one in found], png)
