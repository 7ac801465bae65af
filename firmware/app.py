"""Puts the program together from a camera, a UART and the settings, whatever the board."""

import gc
import os
import time

from faults import Faults
from health import VERSION, Health
from larics import messages as m
from larics.commands import Commands
from larics.encodings import measurement_encoder
from larics.outbox import Outbox, Uptime
from larics.protocol import Decoder, Encoder
from larics.raw import RawSender
from larics.setting_fields import FIELDS
from link import Link
from loop import Loop
from parts import make_detector, make_locator, make_navigator
from reports import Reports

_DETECTOR_SETTINGS = ("method", "radius_min_px", "radius_max_px", "outer_mm10", "line_mm10", "allow_id0")
_DETECTOR_SETTINGS += ("tracking", "second_opinion", "confirm_needed", "confirm_frames", "max_tilt_cdeg")


class App:
    """The running program, and what commands from the wire do to it.

    camera      driver, not yet started
    uart        opened, see link.Link
    board       its name; unique_id: of the processor, bytes
    store       storage.Store of the settings, or None where they cannot be kept
    """

    def __init__(self, settings, camera, uart, board, unique_id=b"", store=None, faults=None, clock=time):
        self.settings = settings
        self.camera = camera
        self.faults = faults or Faults()
        self._board, self._unique_id = board, unique_id
        self._store = store
        boot = os.urandom(2)
        boot = boot[0] << 8 | boot[1]
        self._copy = None
        camera.start()
        settings.update({"width": camera.width, "height": camera.height})
        gc.collect()  # the detector's buffers are the largest: they go in before the heap is cut up
        self.detector = make_detector(settings)
        self.locator = make_locator(settings)
        self.navigator = make_navigator(settings)
        self.raw = RawSender()
        self.commands = Commands(settings, self.raw, self, boot)
        self.decoder = Decoder(self.commands.on_message)
        self.link = Link(uart, self.decoder.feed)
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
        self.health = Health(boot, self.faults, clock)
        self.loop = Loop(self, clock)
        gc.collect()

    def run(self):
        self.commands.announce()
        self.loop.run()

    # what larics.commands.Commands asks for

    def info(self, values):
        values[2], values[3], values[4] = VERSION
        values[5], values[6] = self.camera.width, self.camera.height
        values[7] = max(field.key for field in FIELDS)
        values[8] = padded(self._board, 16)
        values[9] = padded(self._unique_id, 12)

    def settings_changed(self, name):
        """Takes a new value into use; size and baud rate wait for a restart."""
        if name in _DETECTOR_SETTINGS:
            self.detector = None
            gc.collect()
            self.detector = make_detector(self.settings)
        self.locator = make_locator(self.settings)
        self.navigator = make_navigator(self.settings)
        self.outbox.divider = self.settings.rate_divider

    def save(self):
        return False

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
