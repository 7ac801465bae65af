"""Grey frames from a V4L2 device, a video file or an MJPEG or RTSP address, with the time each was taken.

OpenCV captures; it is asked for the luminance plane as the camera delivered it. What it tells of times:

    V4L2 device   POS_MSEC is the driver's own stamp on the monotonic clock: the start of the transfer, after
                  the exposure by the sensor's read-out time at most
    address       no time: a frame counts as taken when it arrived, later than it was by the way through
                  encoder and network (1-2 ms of MJPEG over loopback, more on a network)
    file          its own time stamps, from the moment the first frame was fetched
"""

import os
import time

os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # before cv2: errors are told in one line here
import cv2  # noqa: E402

from cameras import CameraError

LONGEST_PX = 1024  # of a frame's sides, as the settings allow
_STAMP_MOST_S = 2.0  # a driver's stamp that is further off is no monotonic time
_TIMEOUT_MS = 2000
cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)  # it comments on each frame of some formats


def kind_of(name):
    """ "device", "address" or "file" of what was given as --source: 0, /dev/video0, http://..., a path."""
    if name.isdigit() or name.startswith("/dev/"):
        return "device"
    return "address" if "://" in name else "file"


class VideoSource:
    """`size`: (width, height) to ask a device for, or None; fps likewise. Raises CameraError with what to do.

    width, height   of the frames that `read` returns: a larger picture is reduced by a whole factor
    reduced         that factor
    """

    def __init__(self, name, size=None, fps=None):
        self._name = name
        self.kind = kind_of(name)
        self._first_s = None  # monotonic time of a file's beginning
        self._first = None  # the frame that told the size
        self._capture = self._open(size, fps)
        frame = self._first = self._grey(*self._capture.read())
        if frame is None:
            self.close()
            raise CameraError("%s opens but delivers no frame: is another program using it?" % name)
        height, width = frame.shape
        if size and (width, height) != size:
            self.close()
            raise CameraError("%s delivers %dx%d and not %dx%d" % (name, width, height, size[0], size[1]))
        self._native = frame.shape
        self.reduced = -(-max(width, height) // LONGEST_PX)
        self.width, self.height = width // self.reduced, height // self.reduced

    def _open(self, size, fps):
        wanted = [cv2.CAP_PROP_CONVERT_RGB, 0]
        if self.kind == "device":
            number = int(self._name) if self._name.isdigit() else None
            path = "/dev/video%d" % number if number is not None else self._name
            if not os.path.exists(path):
                raise CameraError("there is no %s: is the camera plugged in?" % path)
            if not os.access(path, os.R_OK | os.W_OK):
                raise CameraError("%s may not be opened: add the user to the group video" % path)
            wanted = []
            if size:
                wanted += [cv2.CAP_PROP_FRAME_WIDTH, size[0], cv2.CAP_PROP_FRAME_HEIGHT, size[1]]
            if fps:
                wanted += [cv2.CAP_PROP_FPS, fps]
            capture = cv2.VideoCapture(path, cv2.CAP_V4L2, wanted)
        else:
            if self.kind == "file" and not os.path.isfile(self._name):
                raise CameraError("there is no file %s" % self._name)
            if self.kind == "address":
                wanted += [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, _TIMEOUT_MS]
                wanted += [cv2.CAP_PROP_READ_TIMEOUT_MSEC, _TIMEOUT_MS]
            capture = cv2.VideoCapture(self._name, cv2.CAP_FFMPEG, wanted)
        if not capture.isOpened():
            why = "busy, or no camera" if self.kind == "device" else "no video that can be read"
            raise CameraError("%s cannot be opened: %s" % (self._name, why))
        if self.kind == "device":
            capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        return capture

    def _grey(self, good, frame):
        """The luminance of a picture as OpenCV gives it; None when there is none."""
        if not good or frame is None or not frame.size:
            return None
        if frame.ndim == 3 and frame.shape[2] >= 3:
            return cv2.cvtColor(frame[:, :, :3], cv2.COLOR_BGR2GRAY)
        if frame.ndim == 3:  # packed YUV: luminance first; or one channel
            frame = frame[:, :, 0]
        return frame

    def read(self):
        """(frame of (height, width) uint8, time.monotonic() when it was taken), or None at the end or when
        none came in time. Raises CameraError when its size changed or it is not whole."""
        if self._first is not None:
            frame, self._first = self._first, None
        else:
            frame = self._grey(*self._capture.read())
        now_s = time.monotonic()
        if frame is None:
            return None
        if frame.shape != self._native:
            height, width = frame.shape
            raise CameraError(
                "%s now delivers %dx%d: start again for another size" % (self._name, width, height)
            )
        if self.reduced > 1:
            size = self.width * self.reduced, self.height * self.reduced
            frame = cv2.resize(
                frame[: size[1], : size[0]], (self.width, self.height), interpolation=cv2.INTER_AREA
            )
        return frame, self._taken_s(now_s)

    def _taken_s(self, now_s):
        stamp_s = self._capture.get(cv2.CAP_PROP_POS_MSEC) / 1000
        if self.kind == "device" and 0 <= now_s - stamp_s < _STAMP_MOST_S:
            return stamp_s
        if self.kind == "file":
            if self._first_s is None:
                self._first_s = now_s - stamp_s
            return self._first_s + stamp_s
        return now_s

    def exposure(self, us):
        """Sets the exposure time of a device that allows it; returns whether it did."""
        if self.kind != "device":
            return False
        self._capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, 1)  # V4L2: manual
        return bool(self._capture.set(cv2.CAP_PROP_EXPOSURE, max(1, us // 100)))  # in 0.1 ms

    def close(self):
        self._capture.release()
