"""Stand-in for OpenMV's older `sensor` module: functions instead of an object, snapshots that block."""

from image_object import Image

GRAYSCALE = 0x08020001
QVGA, VGA, HD = 8, 12, 15
_SIZES = {QVGA: (320, 240), VGA: (640, 480), HD: (1280, 720)}


class World:
    def __init__(self):
        self.pending = 0
        self.fails = None
        self.calls = []
        self.image_value = 0
        self.size = self.window = self.pixformat = None
        self.exposure_us = 9999
        self.gain_db = 3.0
        self.memory = None

    def complete(self, count=1):
        self.image_value = (self.image_value + count) & 255
        self.pending = 1


world = World()


def reset():
    world.calls.append("reset")
    world.size = world.window = world.pixformat = None


def set_pixformat(pixformat):
    world.pixformat = pixformat


def set_framesize(size):
    world.size = _SIZES[size]
    world.window = (0, 0) + world.size
    world.memory = None


def set_windowing(*args):
    wanted = args[0] if len(args) == 1 else args
    if world.size is None:
        raise RuntimeError("Frame size is not supported or is not set.")
    if len(wanted) == 2:
        w, h = wanted
        x, y = world.size[0] // 2 - w // 2, world.size[1] // 2 - h // 2
    elif len(wanted) == 4:
        x, y, w, h = wanted
    else:
        raise ValueError("The tuple/list must either be (x, y, w, h) or (w, h)")
    if x >= world.size[0] or y >= world.size[1]:
        raise ValueError("ROI does not overlap on the image!")
    world.window = (x, y, min(w, world.size[0] - x), min(h, world.size[1] - y))
    world.memory = None


def get_windowing():
    return world.window


def set_framebuffers(count):
    world.calls.append("framebuffers %d" % count)


def skip_frames(*args, time=300):
    world.calls.append("skip_frames")


def get_frame_available():
    return world.pending > 0


def snapshot():
    if world.pixformat is None:
        raise RuntimeError("Pixel format is not supported or is not set.")
    if world.fails:
        raise RuntimeError(world.fails)
    if not world.pending:
        world.calls.append("blocking snapshot")
        world.image_value = (world.image_value + 1) & 255  # it starts the capture and waits for it
    world.pending = 0
    w, h = world.window[2:]
    if world.memory is None:
        world.memory = bytearray(w * h)
    for k in range(0, w * h, 97):
        world.memory[k] = world.image_value
    return Image(w, h, world.memory)


def set_auto_exposure(enable, *, exposure_us=-1):
    if not enable and exposure_us >= 0:
        world.exposure_us = min(exposure_us, 30000)


def get_exposure_us():
    return world.exposure_us


def set_auto_gain(enable, *, gain_db=None, gain_db_ceiling=None):
    if not enable and gain_db is not None:
        world.gain_db = gain_db


def get_gain_db():
    return world.gain_db


def shutdown(enable):
    world.calls.append("shutdown")
