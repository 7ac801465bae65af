"""Stand-in for the ESP32's `camera` module (micropython-camera-API)."""

from array import array


class FrameSize:
    R96X96, QQVGA, R128x128, QCIF, HQVGA, R240X240, QVGA, R320X320, CIF, HVGA, VGA = range(11)


class PixelFormat:
    RGB565, YUV422, YUV420, GRAYSCALE, JPEG = range(5)


class GrabMode:
    WHEN_EMPTY, LATEST = 0, 1


_SIZES = {FrameSize.QQVGA: (160, 120), FrameSize.QVGA: (320, 240), FrameSize.CIF: (400, 296)}


class World:
    def __init__(self):
        self.pending = 0
        self.fails = False  # capture returns None
        self.detached = False
        self.image_value = 0
        self.memory = [None, None]
        self.captures = 0
        self.created = []

    def complete(self):
        self.image_value = (self.image_value + 1) & 255
        self.pending = 1


world = World()


class Camera:
    def __init__(
        self, *, data_pins=None, pclk_pin=None, vsync_pin=None, href_pin=None, sda_pin=None, scl_pin=None,
        xclk_pin=None, xclk_freq=20000000, powerdown_pin=-1, reset_pin=-1, pixel_format=PixelFormat.RGB565,
        frame_size=FrameSize.QQVGA, jpeg_quality=85, fb_count=1, grab_mode=GrabMode.WHEN_EMPTY, init=True,
    ):  # fmt: skip
        if world.detached:
            raise OSError("Failed to capture initial frame. Construct a new object ...")
        if data_pins is not None and len(data_pins) != 8:
            raise ValueError("data_pins must have 8 elements")
        world.created.append((frame_size, pixel_format, fb_count, grab_mode, data_pins))
        self._size = _SIZES[frame_size]
        self._ready = True
        self.aec_value = 168
        self.agc_gain = 5
        self.auto = [True, True]
        for k in range(2):
            world.memory[k] = array("b", bytes(self._size[0] * self._size[1]))

    def _check(self):
        if not self._ready:
            raise OSError(2)

    def frame_available(self):
        self._check()
        return world.pending > 0 or world.fails

    def capture(self):
        """A view of signed bytes on one of two buffers; the view before is given back to the driver."""
        self._check()
        if world.fails:
            return None
        world.pending = 0
        world.captures += 1
        memory = world.memory[world.captures & 1]
        for k in range(len(memory)):
            memory[k] = world.image_value
        return memoryview(memory)

    def set_exposure_ctrl(self, on):
        self.auto[0] = on

    def set_gain_ctrl(self, on):
        self.auto[1] = on

    def set_aec_value(self, lines):
        if not 0 <= lines <= 1200:
            raise ValueError("Invalid setting for aec_value")
        self.aec_value = lines

    def set_agc_gain(self, step):
        if not 0 <= step <= 30:
            raise ValueError("Invalid setting for agc_gain")
        self.agc_gain = step

    def deinit(self):
        self._ready = False
