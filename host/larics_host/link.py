"""Reading the camera's wire on a PC: from a serial port, or from a file of recorded bytes."""

import os
import sys

import serial
from serial.tools import list_ports

from larics_host.errors import UserError

_PIECE = 4096


class LinkLost(Exception):
    """The port vanished while reading; what was received before stays valid."""


class SerialSource:
    """A serial port. `read` returns b"" when nothing came within `timeout_s`."""

    live = True

    def __init__(self, port, baud=115200, timeout_s=0.1):
        self.name = port
        try:
            self._port = serial.Serial(port, baud, timeout=timeout_s, write_timeout=1)
        except (serial.SerialException, OSError, ValueError) as error:
            raise UserError(_why_not_open(port, error)) from error

    def read(self):
        """What has arrived, as bytes. Raises LinkLost when the port has gone."""
        try:
            data = self._port.read(1)
            if data:
                data += self._port.read(min(self._port.in_waiting, _PIECE))
            return data
        except (serial.SerialException, OSError, TypeError) as error:  # TypeError: closed under the read
            raise LinkLost("the port %s vanished while reading" % self.name) from error

    def write(self, data):
        """Sends bytes. Raises LinkLost when the port has gone or takes nothing for a second."""
        try:
            self._port.write(data)
        except (serial.SerialException, OSError) as error:
            raise LinkLost("the port %s vanished or is stuck while writing" % self.name) from error

    def close(self):
        self._port.close()


class FileSource:
    """A file of raw bytes as the camera sent them, or "-" for standard input."""

    live = False

    def __init__(self, path):
        self.name = path
        try:
            self._file = sys.stdin.buffer if path == "-" else open(path, "rb")  # noqa: SIM115
        except OSError as error:
            raise UserError("cannot read %s: %s" % (path, error.strerror)) from error

    def read(self):
        """The next bytes, or None at the end."""
        return self._file.read(_PIECE) or None

    def close(self):
        if self._file is not sys.stdin.buffer:
            self._file.close()


def _why_not_open(port, error):
    if not os.path.exists(port) and "/" in port:
        found = ", ".join(item.device for item in list_ports.comports()) or "none"
        return "no port %s (serial ports here: %s)" % (port, found)
    if isinstance(error, PermissionError) or getattr(error, "errno", None) == 13:
        return "no permission to open %s: add your user to the group that owns it (often dialout)" % port
    return "cannot open the port %s: %s" % (port, str(error).splitlines()[0])
