"""Puts the program together from a camera, a UART and the settings, whatever the board."""

import gc
import os
import time

from faults import Faults
from larics.device.commands import Commands
from larics.device.factory import make_detector, make_locator, make_navigator
from larics.device.frame_messages import Reports
from larics.device.outbox import Outbox, Uptime
from larics.device.raw_frame import RawSender
from larics.settings import Settings, load
from larics.settings.fields import FIELDS
from larics.wire import messages as m
from larics.wire.codec import Decoder, Encoder
from larics.wire.encodings import measurement_encoder
from leds import NoLeds
from loop import Loop
from safe_mode import NoWatchdog
from serial_line import SerialLine
from status import VERSION, Status

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

# generated: begin indices (tools/make_protocol.py)
_INFO_VERSION_MAJOR = const(2)
_INFO_VERSION_MINOR = const(3)
_INFO_VERSION_PATCH = const(4)
_INFO_WIDTH = const(5)
_INFO_HEIGHT = const(6)
_INFO_SETTINGS = const(7)
_INFO_BOARD = const(8)
_INFO_UNIQUE_ID = const(9)
# generated: end indices

_DETECTOR_SETTINGS = ("method", "radius_min_px", "radius_max_px", "outer_mm10", "line_mm10", "allowed_ids")
_DETECTOR_SETTINGS += ("allow_id0", "mirrored", "tracking", "second_opinion")
_DETECTOR_SETTINGS += ("confirm_needed", "confirm_frames", "max_tilt_cdeg", "margin_min")

_EXPOSURE_SETTINGS = ("exposure", "exposure_us", "gain_db10")


class App:
    """The running program, and what commands from the wire do to it.

    camera      driver, not yet started; a camera that does not start is tried again while the program runs
    uart        opened, see link.SerialLine
    board       its name; unique_id: of the processor, bytes
    keeper      keeper.SettingsStore of the settings, or None where they cannot be kept
    leds, sentinel, watchdog   see leds, guard; what a PC does not have
    detector    when it was made already, as long as the heap was in one piece
    banner      line printed on the console in the first seconds, for who has just flashed the board
    """

    def __init__(
        self, settings, camera, uart, board, unique_id=b"", keeper=None, faults=None, leds=None,
        sentinel=None, detector=None, clock=time,
    ):  # fmt: skip
        self.settings = settings
        self.camera = camera
        self.faults = faults or Faults()
        self.leds = leds or NoLeds()
        self.sentinel = sentinel
        self.watchdog = NoWatchdog()
        self.banner = None
        self._board, self._unique_id = board, unique_id
        self._keeper = keeper
        boot = os.urandom(2)
        boot = boot[0] << 8 | boot[1]
        self._copy = None
        camera_ok = self._start_camera()
        self.detector = detector
        if detector is None:
            self._build_detector()
        self._build_locator()
        self._build_exposure()
        self.raw = RawSender()
        self.commands = Commands(settings, self.raw, self, boot)
        self.decoder = Decoder(self.commands.on_message)
        self.link = SerialLine(uart, self.decoder.feed)
        uptime = Uptime()
        self.outbox = Outbox(
            self.link,
            Encoder(clamp=True),  # a device reports the nearest value rather than nothing
            (self.commands, self.raw),
            settings.baud,
            clock.ticks_diff,
            measurements=measurement_encoder(settings, uptime),
            divider=settings.rate_divider,
            uptime=uptime,
        )
        self.reports = Reports(self.outbox)
        self.health = Status(boot, self.faults, clock)
        self.loop = Loop(self, camera_ok, clock)
        gc.collect()
        if hasattr(gc, "mem_free"):  # MicroPython: main.py made it collect often while loading
            gc.threshold(-1)

    def _start_camera(self):
        try:
            self.camera.start()
        except Exception:
            self.faults.report(m.FAULT_CAMERA)
            return False
        size = {"width": self.camera.width, "height": self.camera.height}
        try:
            self.settings.update(size)
        except ValueError:  # they do not suit this size: as many of them as do
            self.faults.begin(m.FAULT_SETTINGS_CORRUPT)
            self.settings.update(load(self.settings.as_dict(), size)[0].as_dict())
        return True

    def _size(self):
        """Of the frames: a size that was set counts after a restart."""
        return self.camera.width or self.settings.width, self.camera.height or self.settings.height

    def _build_detector(self):
        """A detector, if need be with the usual radii; None only when there is no memory for one."""
        settings = self.settings
        self.detector = None
        gc.collect()  # its buffers are the largest: they go in before the heap is cut up
        try:
            self.detector = make_detector(settings, self._size())
        except ValueError:  # they suit the size that was set, but not yet that of the frames
            self.faults.begin(m.FAULT_SETTINGS_CORRUPT)
            self.detector = make_detector(Settings(), self._size())
        except MemoryError:
            gc.collect()
            self.faults.begin(m.FAULT_MEMORY)

    def _build_locator(self):
        """Pixels to millimetres and the pose in the map, as far as the settings make sense."""
        settings = self.settings
        self.navigator = None
        self.calibrated = settings.focal_q8 > 0
        try:
            self.locator = make_locator(settings, self._size())
            self.navigator = make_navigator(settings)
        except ValueError:
            self.faults.begin(m.FAULT_SETTINGS_CORRUPT)
            self.calibrated = False
            self.locator = make_locator(Settings(), self._size())

    def _build_exposure(self):
        """The control of the exposure; without it, exposure and gain are those of the settings."""
        self.exposure = None
        if self.settings.exposure == "auto" and getattr(self.camera, "adjustable", True):
            from exposure import Exposure  # a recording does without

            self.exposure = Exposure(self.camera, self.settings)

    def _fix_exposure(self):
        try:
            self.camera.gain(self.settings.gain_db10 * 10)
            self.camera.exposure(self.settings.exposure_us)
        except Exception:
            self.faults.report(m.FAULT_CAMERA)

    def run(self):
        self.commands.announce()
        self.loop.run()

    def announce_only(self):
        """Says on the line who is there and in which state, and starts nothing."""
        self.commands.announce()
        self.loop.close()

    # what larics.device.commands.Commands asks for

    def info(self, values):
        values[_INFO_VERSION_MAJOR], values[_INFO_VERSION_MINOR], values[_INFO_VERSION_PATCH] = VERSION
        values[_INFO_WIDTH], values[_INFO_HEIGHT] = self.camera.width, self.camera.height
        values[_INFO_SETTINGS] = max(field.key for field in FIELDS)
        values[_INFO_BOARD] = padded(self._board, 16)
        values[_INFO_UNIQUE_ID] = padded(self._unique_id, 12)

    def settings_changed(self, name):
        """Takes a new value into use; size, baud rate and encoding wait for a restart."""
        if name in _DETECTOR_SETTINGS:
            self._build_detector()
        self._build_locator()
        self._build_exposure()
        if name in _EXPOSURE_SETTINGS and self.exposure is None:
            self._fix_exposure()
        self.outbox.divider = self.settings.rate_divider

    def save(self):
        return self._keeper is not None and self._keeper.save(self.settings)

    def raw_frame(self):
        camera = self.camera
        if not camera.frame:
            return None
        try:
            if self._copy is None or len(self._copy) != len(camera.frame):
                self._copy = None
                self._copy = bytearray(len(camera.frame))
        except MemoryError:
            self.faults.report(m.FAULT_MEMORY)
            return None
        self._copy[:] = camera.frame
        return self._copy, camera.width, camera.height, camera.frame_number & m.COUNT_MAX


def padded(text, size):
    """Text or bytes as exactly `size` bytes, cut or filled with zeros."""
    data = text.encode() if isinstance(text, str) else bytes(text)
    return (data + bytes(size))[:size]
