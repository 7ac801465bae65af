"""Stand-in for OpenMV's `csi` module: names, argument forms, results and errors as in OpenMV 5.0.

A test sets `world`: which sizes the sensor takes, the frames that come, what fails.
"""

from image_object import Image

GRAYSCALE = 0x08020001
RGB565 = 0x0C030002
QVGA, VGA, HD = 8, 12, 15
_SIZES = {QVGA: (320, 240), VGA: (640, 480), HD: (1280, 720)}

TIMEOUT = "Frame capture has timed out."
UNDETECTED = "Failed to detect the image sensor or image sensor is detached."


class World:
    """The sensor and what happens to it."""

    def __init__(self):
        self.detected = True
        self.refused_sizes = ()
        self.minimum_exposure_us = 20
        self.longest_exposure_us = 30000
        self.pending = 0  # complete frames that wait
        self.fails = None  # text of the RuntimeError of snapshot
        self.calls = []
        self.callback = None
        self.while_fetching = None  # called during a snapshot: an interrupt
        self.image_value = 0
        self.opened = 0
        self.cut_px = None  # (width, height) that windows are cut to

    def complete(self, count=1):
        """The sensor finishes frames: the newest replaces one that waits."""
        for _ in range(count):
            self.image_value = (self.image_value + 1) & 255
            self.pending = 1
            if self.callback:
                self.callback()


world = World()


class CSI:
    def __init__(self, cid=-1, delays=True, fflush=True, stream=None):
        if not world.detected:
            raise RuntimeError(UNDETECTED)
        world.opened += 1
        self._pixformat = None
        self._size = None
        self._window = None
        self._buffers = 1
        self._exposure_us = 12345
        self._gain_db = 6.0
        self._memory = None

    def reset(self, *, hard=True):
        world.calls.append("reset")
        self._pixformat = self._size = self._window = None

    def pixformat(self, *args):
        if not args:
            return self._pixformat
        world.calls.append("pixformat")
        self._pixformat = args[0]

    def framesize(self, *args):
        if not args:
            return self._size
        size = _SIZES[args[0]] if isinstance(args[0], int) else args[0]
        if not isinstance(size, tuple):
            raise RuntimeError("An invalid argument is used.")
        if args[0] in world.refused_sizes or (isinstance(args[0], tuple) and "custom" in world.refused_sizes):
            raise RuntimeError("Frame size is not supported or is not set.")
        world.calls.append("framesize")
        self._size = size
        self._window = (0, 0) + size
        self._exposure_us = min(self._exposure_us, 8000)  # some sensors limit it anew
        self._memory = None

    def window(self, *args):
        if self._size is None:
            raise RuntimeError("Frame size is not supported or is not set.")
        if not args:
            return self._window
        wanted = args[0]
        if len(wanted) == 2:
            w, h = wanted
            x, y = self._size[0] // 2 - w // 2, self._size[1] // 2 - h // 2
        elif len(wanted) == 4:
            x, y, w, h = wanted
        else:
            raise ValueError("Expected (w, h) or (x, y, w, h) tuple/list.")
        if w < 1 or h < 1:
            raise ValueError("Invalid ROI dimensions!")
        if x >= self._size[0] or y >= self._size[1]:
            raise ValueError("ROI does not overlap on the image!")
        w, h = min(w, self._size[0] - x), min(h, self._size[1] - y)  # cut to the frame, silently
        if world.cut_px:
            w, h = min(w, world.cut_px[0]), min(h, world.cut_px[1])
        world.calls.append("window")
        self._window = (x, y, w, h)
        self._memory = None

    def framebuffers(self, *args):
        if not args:
            return self._buffers
        if args[0] < 1:
            raise RuntimeError("An invalid argument is used.")
        world.calls.append("framebuffers")
        self._buffers = args[0]

    def snapshot(self, *, time=-1, frames=-1, blocking=True, image=None):
        if self._pixformat is None:
            raise RuntimeError("Pixel format is not supported or is not set.")
        if self._size is None:
            raise RuntimeError("Frame size is not supported or is not set.")
        if world.fails:
            raise RuntimeError(world.fails)
        if time != -1 or frames != -1:
            world.calls.append("settle")
            return None
        if not world.pending:
            if not blocking:
                return None
            raise RuntimeError(TIMEOUT)
        world.pending = 0
        if world.while_fetching:
            world.while_fetching()
        w, h = self._window[2:]
        if self._memory is None:
            self._memory = bytearray(w * h)
        for k in range(0, w * h, 97):
            self._memory[k] = world.image_value
        return Image(w, h, self._memory)

    def auto_exposure(self, enable, *, exposure_us=-1):
        world.calls.append("auto_exposure")
        if not enable and exposure_us >= 0:
            self._exposure_us = max(world.minimum_exposure_us, min(world.longest_exposure_us, exposure_us))

    def exposure_us(self):
        return self._exposure_us

    def auto_gain(self, enable, *, gain_db=None, gain_db_ceiling=None):
        world.calls.append("auto_gain")
        if not enable and gain_db is not None:
            self._gain_db = float(int(gain_db / 0.375) * 0.375)  # in the sensor's steps

    def gain_db(self):
        return self._gain_db

    def framerate(self, *args):
        raise RuntimeError(TIMEOUT)  # stops some sensors for good: nobody may call it

    def frame_callback(self, *args):
        if not args:
            return world.callback
        world.callback = args[0] if callable(args[0]) else None

    def shutdown(self, enable):
        world.calls.append("shutdown")

    def cid(self):
        return 0x7936


def devices():
    return [0x7936]
