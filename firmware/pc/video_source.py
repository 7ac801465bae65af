"""Grey frames from a V4L2 device, a video file or an MJPEG or RTSP address, with the time each was taken.

OpenCV captures; it is asked for the luminance plane as the camera delivered it. What it tells of times:

    V4L2 device   POS_MSEC is the driver's own stamp on the monotonic clock: the start of the transfer, after
                  the exposure by the sensor's read-out time at most
    address       no time: a frame counts as taken when it arrived, later than it was by the way through
                  encoder and network (1-2 ms of MJPEG over loopback, more on a network)
    file          its own time stamps, from the moment the first frame was fetched

Pictures of an MJPEG stream are taken undecoded: of one that is cut, ffmpeg fills what is missing with pixels
of an earlier picture, and one of another size it stretches to the first one's; nobody could see that
afterwards.

Pixels are taken as they were captured: a tag that asks to show a video turned is not obeyed.
"""

import fcntl
import os
import struct
import time

os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # before cv2: errors are told in one line here
os.environ.setdefault("OPENCV_VIDEOIO_V4L_SELECT_TIMEOUT", "2")  # seconds; 10 is too late for a vehicle
import cv2  # noqa: E402

from cameras import CameraError

LONGEST_PX = 1024  # of a frame's sides, as the settings allow
_STAMP_MOST_S = 2.0  # a driver's stamp that is further off is no monotonic time
_TIMEOUT_MS = 2000
_QUERYCAP = 0x80685600  # VIDIOC_QUERYCAP
_CAPTURE = 0x1001  # V4L2_CAP_VIDEO_CAPTURE and _MPLANE
_MJPG = int.from_bytes(b"MJPG", "little")
_RTSP = "rtsp_transport;tcp|fflags;nobuffer|flags;low_delay"  # no packet is lost, none waits for others
cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)  # it comments on each frame of some formats


def kind_of(name):
    """ "device", "address" or "file" of what was given as --source: 0, /dev/video0, http://..., a path."""
    if name.isdigit() or name.startswith("/dev/"):
        return "device"
    return "address" if "://" in name else "file"


def is_whole(data):
    """Whether a JPEG has its end: the pixels begin at SOS, 0xFFDA, and hold no EOI, 0xFFD9, of their own."""
    return data.rfind(b"\xff\xd9") > data.rfind(b"\xff\xda") > 0


def _check_device(path):
    """Raises CameraError unless that is a device for video that may be opened."""
    if not os.path.exists(path):
        raise CameraError("there is no %s: is the camera plugged in?" % path)
    if not os.access(path, os.R_OK | os.W_OK):
        raise CameraError("%s may not be opened: add the user to the group video" % path)
    capability = bytearray(104)
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_NONBLOCK)
    except OSError as error:
        raise CameraError("%s cannot be opened: %s" % (path, error.strerror.lower()))
    try:
        fcntl.ioctl(descriptor, _QUERYCAP, capability)
    except OSError:
        raise CameraError("%s is no camera" % path)
    finally:
        os.close(descriptor)
    if not struct.unpack_from("<I", capability, 88)[0] & _CAPTURE:
        raise CameraError("%s belongs to a camera but delivers no pictures: try another number" % path)


def _check_file(path):
    """Raises CameraError unless that is a file that may be read."""
    if os.path.isdir(path):
        raise CameraError("%s is a folder: give one of its videos" % path)
    if not os.path.isfile(path):
        raise CameraError("there is no file %s" % path)
    if not os.access(path, os.R_OK):
        raise CameraError("%s may not be read: its owner has to allow that" % path)
    if not os.path.getsize(path):
        raise CameraError("%s is empty" % path)


class VideoSource:
    """`size`: (width, height) to ask a device for, or None; fps likewise. Raises CameraError with what to do.

    width, height   of the frames that `read` returns: a larger picture is reduced by a whole factor
    reduced         that factor
    turned          degrees, clockwise, by which a tag asks to show it; the frames are not
    cut             counts the frames that were not whole and are left out
    """

    def __init__(self, name, size=None, fps=None):
        self._name = name
        self.kind = kind_of(name)
        self._first_s = None  # monotonic time of a file's beginning
        self.cut = 0
        self.turned = 0
        self._packed = False  # the capture delivers JPEGs
        self._capture = self._open_device(size, fps) if self.kind == "device" else self._open_stream()
        try:
            self._first = self._next()
            if self._first is None:
                raise CameraError(
                    "%s opens but delivers no frame: is another program using it?" % name
                    if self.kind == "device"
                    else "%s opens but delivers no frame" % name
                )
            height, width = self._native = self._first.shape
            if size and (width, height) != size:
                raise CameraError("%s delivers %dx%d and not %dx%d" % (name, width, height, size[0], size[1]))
        except CameraError:
            self.close()
            raise
        self.reduced = -(-max(width, height) // LONGEST_PX)
        self.width, self.height = width // self.reduced, height // self.reduced

    def _open_device(self, size, fps):
        path = "/dev/video" + self._name if self._name.isdigit() else self._name
        _check_device(path)
        wanted = []
        if size:
            wanted += [cv2.CAP_PROP_FRAME_WIDTH, size[0], cv2.CAP_PROP_FRAME_HEIGHT, size[1]]
        if fps:
            wanted += [cv2.CAP_PROP_FPS, fps]
        capture = cv2.VideoCapture(path, cv2.CAP_V4L2, wanted)
        if not capture.isOpened():
            raise CameraError("%s cannot be opened: another program uses it" % path)
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)
        return capture

    def _open_stream(self):
        name = self._name
        wanted = []
        if self.kind == "file":
            _check_file(name)
        if self.kind == "address":
            wanted = [
                cv2.CAP_PROP_OPEN_TIMEOUT_MSEC,
                _TIMEOUT_MS,
                cv2.CAP_PROP_READ_TIMEOUT_MSEC,
                _TIMEOUT_MS,
            ]
        if name.startswith("rtsp"):
            os.environ.setdefault("OPENCV_FFMPEG_CAPTURE_OPTIONS", _RTSP)
            return self._opened(wanted, cv2.CAP_PROP_CONVERT_RGB, 0)
        capture = self._opened(wanted, cv2.CAP_PROP_FORMAT, -1)
        self._packed = int(capture.get(cv2.CAP_PROP_FOURCC)) == _MJPG
        if self._packed:
            return capture
        capture.release()
        return self._opened(wanted, cv2.CAP_PROP_CONVERT_RGB, 0)

    def _opened(self, wanted, name, value):
        capture = cv2.VideoCapture(self._name, cv2.CAP_FFMPEG, wanted + [name, value])
        if not capture.isOpened():
            why = "nobody answers there, or " if self.kind == "address" else ""
            raise CameraError("%s cannot be opened: %sno video that can be read" % (self._name, why))
        self.turned = round(capture.get(cv2.CAP_PROP_ORIENTATION_META)) % 360
        capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
        return capture

    def _next(self):
        """The next whole picture's luminance, None when none comes. CameraError when all are cut."""
        end_s = time.monotonic() + _TIMEOUT_MS / 1000
        cut = 0
        while True:
            good, frame = self._capture.read()
            if not good or frame is None or not frame.size:
                if cut and self.kind == "file":
                    return None
                break
            if self._packed:
                frame = self._unpacked(frame)
            elif frame.ndim == 3 and frame.shape[2] >= 3:
                return cv2.cvtColor(frame[:, :, :3], cv2.COLOR_BGR2GRAY)
            elif frame.ndim == 3:  # packed YUV: luminance first; or one channel
                return frame[:, :, 0]
            if frame is not None:
                return frame
            cut += 1
            self.cut += 1
            if time.monotonic() > end_s:
                break
        if cut:
            raise CameraError("%s delivers half frames only" % self._name)
        return None

    def _unpacked(self, data):
        """The luminance of a JPEG, as it lies; None when it is not whole."""
        if not is_whole(data.tobytes()):
            return None
        return cv2.imdecode(data, cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)

    def read(self):
        """(frame of (height, width) uint8, time.monotonic() when it was taken), or None at the end or when
        none came in time. Raises CameraError when its size changed or no frame is whole."""
        if self._first is not None:
            frame, self._first = self._first, None
        else:
            frame = self._next()
        now_s = time.monotonic()
        if frame is None:
            return None
        if frame.shape != self._native:
            sizes = self._name, frame.shape[1], frame.shape[0], self._native[1], self._native[0]
            raise CameraError("%s now delivers %dx%d instead of %dx%d" % sizes)
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
