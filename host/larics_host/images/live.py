"""Frames of a camera as they come: a V4L2 device, an MJPEG or RTSP address. The newest one wins.

`larics camera` is the sensor with all that belongs to it; this is for a look, and ends with its source.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator

import numpy as np

from larics_host.errors import UserError
from larics_host.images.frame_sources import EXTENSIONS

_SCHEMES = ("http://", "https://", "rtsp://", "rtsps://")
_OPEN_MS = 10000
_TIMEOUT_MS = 5000  # without a frame


def is_live(text: str) -> bool:
    """Whether a name stands for a camera: a device, or an address that is not that of a file of frames."""
    if text.startswith("/dev/video"):
        return True
    return text.startswith(_SCHEMES) and not text.lower().partition("?")[0].endswith(EXTENSIONS)


class _Newest:
    """A thread that fetches; `take` waits for a frame that was not taken yet."""

    def __init__(self, capture, stopped):
        self._capture, self._stopped = capture, stopped
        self._changed = threading.Condition()
        self._frame = None
        self._ended = False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        while not self._ended:
            good, frame = self._capture.read()
            with self._changed:
                self._ended |= not good
                self._frame = frame if good else self._frame
                self._changed.notify_all()
        self._capture.release()

    def take(self):
        """The frame, or None when no more comes or it is to stop."""
        with self._changed:
            while self._frame is None and not self._ended and not self._stopped():
                self._changed.wait(0.1)  # Ctrl-C comes through
            frame, self._frame = self._frame, None
        return frame

    def end(self):
        """Waits for the read under way: a thread within OpenCV aborts an interpreter that ends."""
        with self._changed:
            self._ended = True
        self._thread.join(_TIMEOUT_MS / 1000 + 1)


def live_frames(name: str, stopped: Callable[[], bool] = lambda: False) -> Iterator[tuple[str, np.ndarray]]:
    """Yields (name#number, grey frame) until the source ends or it is stopped.

    UserError when it cannot be opened."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
    import cv2

    if name.startswith("/dev/"):
        if not os.path.exists(name):
            raise UserError("there is no %s: is the camera plugged in?" % name)
        capture = cv2.VideoCapture(name, cv2.CAP_V4L2)
    else:
        limits = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, _OPEN_MS, cv2.CAP_PROP_READ_TIMEOUT_MSEC, _TIMEOUT_MS]
        capture = cv2.VideoCapture(name, cv2.CAP_FFMPEG, limits)
    if not capture.isOpened():
        why = "busy, or no camera" if name.startswith("/dev/") else "nobody answers there, or no video"
        raise UserError("%s cannot be opened: %s" % (name, why))
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)  # pixels as the camera delivered them
    newest = _Newest(capture, stopped)
    number = 0
    try:
        while (image := newest.take()) is not None:
            grey = np.asarray(image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
            yield "%s#%d" % (name, number), grey
            number += 1
    finally:
        newest.end()
    if not number and not stopped():
        raise UserError("%s delivers no frame" % name)
