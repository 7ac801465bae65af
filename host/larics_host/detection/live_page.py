"""Frames with what was found in them, on a page of this computer, while detection runs on at full speed.

The page asks for the newest frame; only what it asks for is drawn.
"""

from __future__ import annotations

import threading
import time
from http.server import ThreadingHTTPServer
from importlib import resources
from typing import Any

import numpy as np

from larics_host import local_server

_RATE_S = 1.0  # over which frames a second are counted


class LiveView:
    """What the page shows: `show` each frame; from several threads."""

    def __init__(self, source: str) -> None:
        self.source = source
        self._lock = threading.Lock()
        self._frame: np.ndarray | None = None
        self._found: list[dict[str, Any]] = []
        self._name = ""
        self._number = 0
        self._rate: float | None = None
        self._since = time.monotonic(), 0
        self._ended: str | None = None

    def show(self, name: str, frame: np.ndarray, found: list[dict[str, Any]]) -> None:
        """The newest frame and its detections."""
        now_s = time.monotonic()
        with self._lock:
            self._frame, self._found, self._name = frame, found, name
            self._number += 1
            start_s, count = self._since
            if now_s - start_s >= _RATE_S:
                self._rate = (self._number - count) / (now_s - start_s)
                self._since = now_s, self._number

    def end(self, text: str) -> None:
        """No more frames come, and why."""
        with self._lock:
            self._ended = text

    def snapshot(self) -> dict[str, Any]:
        """All but the picture, for JSON."""
        with self._lock:
            return {
                "source": self.source,
                "name": self._name,
                "number": self._number,
                "rate": self._rate,
                "detections": self._found,
                "ended": self._ended,
            }

    def picture(self) -> bytes | None:
        """The newest frame with its detections as JPEG."""
        import cv2

        from larics_host.images.drawing import draw_detections

        with self._lock:
            frame, found = self._frame, self._found
        if frame is None:
            return None
        image = draw_detections(frame, found)
        return cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 88])[1].tobytes()


class _Handler(local_server.LocalHandler):
    def do_GET(self):
        if not self.is_local():
            return
        path = self.path.split("?")[0]
        if path == "/":
            page = resources.files("larics_host.detection").joinpath("live_page.html").read_bytes()
            self.answer(200, "text/html; charset=utf-8", page)
        elif path == "/events":
            self.events(lambda number: (self.content.snapshot(), number))
        elif path == "/frame.jpg":
            picture = self.content.picture()
            if picture is None:
                self.answer(404, "text/plain", b"no frame yet\n")
            else:
                self.answer(200, "image/jpeg", picture)
        else:
            self.answer(404, "text/plain", b"nothing here\n")


def serve(view: LiveView, port: int) -> ThreadingHTTPServer:
    """The page's server; see local_server.serve."""
    return local_server.serve(_Handler, view, port)
