"""Puts the program together from a camera, a UART and the settings, whatever the board."""

import gc
import os
import time

from faults import Faults
from larics.protocol import Decoder
from larics.setting_fields import FIELDS
from link import Link
from loop import Loop
from parts import make_detector, make_locator
from reports import Reports


class App:
    """The running program. `camera`: driver not yet started; `uart`: opened; the names of the board and of
    the processor are for the info message."""

    def __init__(self, settings, camera, uart, board, unique_id=b"", faults=None, clock=time):
        self.settings = settings
        self.faults = faults or Faults()
        self._board, self._unique_id = board, unique_id
        boot = os.urandom(2)
        self._decoder = Decoder(self._on_message)
        self.link = Link(uart, self._decoder.feed)
        self.reports = Reports(self.link, boot[0] << 8 | boot[1])
        camera.start()
        settings.update({"width": camera.width, "height": camera.height})
        gc.collect()  # the detector's buffers are the largest, they go in before the heap is cut up
        self.loop = Loop(
            camera,
            make_detector(settings),
            make_locator(settings),
            settings,
            self.link,
            self.reports,
            self.faults,
            clock=clock,
        )
        gc.collect()

    def _on_message(self, number, sequence, values):
        pass

    def send_info(self, token=0):
        settings = self.settings
        keys = max(field.key for field in FIELDS)
        self.reports.info(token, settings.width, settings.height, keys, self._board, self._unique_id)

    def run(self):
        self.send_info()
        self.loop.run()
