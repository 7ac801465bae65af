"""Runs the program on a PC in a closed loop: frames and the vehicle's bytes from a pipe in, the wire on a
terminal device out.

    micropython firmware/pc/closed_loop_main.py PIPE PORT SETTINGS.json [LATENCY_US [CONTROLS]]

Also runs on CPython, for long simulations; see pc.pipe_camera for the frames, and for CONTROLS, the
pipe that is told exposure and gain.
"""

import json
import sys

from app import App
from cameras import CameraError
from larics.settings import Settings
from pc.pipe_camera import Line, Pipe

if sys.implementation.name == "micropython":
    from pc.uart_unix import UART
else:
    import os

    class UART:
        """What pc.uart_unix has, as far as a Line writes to it."""

        def __init__(self, device):
            self._descriptor = os.open(device, os.O_RDWR | os.O_NOCTTY)

        def write(self, buffer, offset, count):
            return os.write(self._descriptor, memoryview(buffer)[offset : offset + count])


def main(arguments):
    if not 3 <= len(arguments) <= 5:
        sys.stderr.write("live: give PIPE PORT SETTINGS.json [LATENCY_US [CONTROLS]]\n")
        return 2
    try:
        with open(arguments[2]) as file:
            settings = Settings(json.load(file))
        line = Line(UART(arguments[1]))
        latency_us = int(arguments[3]) if len(arguments) > 3 else 15000
        camera = Pipe(arguments[0], latency_us, line, arguments[4] if len(arguments) > 4 else None)
        app = App(settings, camera, line, "live", clock=camera.clock)
    except (ValueError, OSError, CameraError) as error:
        sys.stderr.write("live: %s\n" % error)
        return 2
    app.run()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
