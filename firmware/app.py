"""Puts the program together from a camera, a UART and the settings, whatever the board."""

import os
import time

import heap
from actions import Actions
from camera_watch import CameraWatch
from faults import Faults
from larics.device.commands import Commands
from larics.device.frame_messages import Reports
from larics.device.outbox import Outbox, Uptime
from larics.device.raw_frame import RawSender
from larics.locate.odometry import Odometry
from larics.settings import load
from larics.wire import messages as m
from larics.wire.codec import Decoder, Encoder, frame_size
from larics.wire.encodings import measurement_encoder
from leds import NoLeds
from loop import Loop
from parts import Parts
from safe_mode import NoWatchdog
from serial_line import SerialLine
from status import Status


class App:
    """The running program: its components, made and joined.

    camera      driver, not yet started; a camera that does not start is tried again while the program runs
    uart        opened, see serial_line.SerialLine
    board       its name; unique_id: of the processor, bytes
    keeper      settings_store.SettingsStore of the settings, or None where they cannot be kept
    leds, sentinel, watchdog   see leds, safe_mode; what a PC does not have
    detector    when it was made already, as long as the heap was in one piece
    baud        bits a second that the line takes, when that is not the setting
    banner      line printed on the console in the first seconds, for who has just flashed the board
    """

    def __init__(
        self, settings, camera, uart, board, unique_id=b"", keeper=None, faults=None, leds=None,
        sentinel=None, detector=None, clock=time, baud=None,
    ):  # fmt: skip
        self.settings = settings
        self.faults = faults or Faults()
        self.leds = leds or NoLeds()
        self.sentinel = sentinel
        self.watchdog = NoWatchdog()
        self.banner = None
        baud = baud or settings.baud
        boot = os.urandom(2)
        boot = boot[0] << 8 | boot[1]
        started = self._start(camera)
        self.watch = CameraWatch(camera, self.faults, clock, started)
        self.parts = Parts(settings, camera, self.faults, detector)
        self.actions = Actions(self.watch, settings, self.parts, self.faults, keeper, board, unique_id)
        raw = RawSender()
        uptime = Uptime()
        self.odometry = Odometry(clock.ticks_us, frame_size(m.ODOMETRY) * 10000000 // baud)
        self.commands = Commands(settings, raw, self.actions, boot, uptime, self.odometry)
        self.decoder = Decoder(self.commands.on_message)
        self.line = SerialLine(uart, self.decoder.feed)
        self.encoder = Encoder(clamp=True)  # a device reports the nearest value rather than nothing
        uptime = Uptime()
        self.outbox = Outbox(
            self.line,
            self.encoder,
            (self.commands, raw),
            baud,
            clock.ticks_diff,
            measurements=measurement_encoder(settings, uptime),
            divider=settings.rate_divider,
            uptime=uptime,
        )
        self.actions.outbox, self.actions.raw = self.outbox, raw
        self.reports = Reports(self.outbox)
        self.status = Status(boot, self, clock)
        self.loop = Loop(self, clock)
        heap.loaded()

    def _start(self, camera):
        """Starts the camera; settings that do not suit the size of its frames are left at their defaults."""
        try:
            camera.start()
        except Exception:
            self.faults.report(m.FAULT_CAMERA)
            return False
        size = {"width": camera.width, "height": camera.height}
        try:
            self.settings.update(size)
        except ValueError:
            self.faults.begin(m.FAULT_SETTINGS_CORRUPT)
            self.settings.update(load(self.settings.as_dict(), size)[0].as_dict())
        return True

    def run(self):
        self.commands.announce()
        self.loop.run()

    def announce_only(self):
        """Says on the line who is there and in which state, and starts nothing."""
        self.commands.announce()
        self.loop.close()
