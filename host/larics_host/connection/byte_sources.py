"""Reading the camera's wire on a PC: from a serial port, or from a file of recorded bytes."""

from __future__ import annotations

import contextlib
import signal
import sys
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import serial

from larics_host.connection.serial_ports import find_again, identity_of, open_port
from larics_host.errors import UserError, report

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


_PIECE = 4096
_RETRY_S = 0.2
_PATIENCE = 5  # tries


class ConnectionLost(Exception):
    """The port vanished while reading; what was received before stays valid."""


class SerialSource:
    """A serial port. `read` returns b"" when nothing came within `timeout_s`."""

    live = True

    def __init__(self, port: str, baud: int = 115200, timeout_s: float = 0.1) -> None:
        self.name = port
        self.baud = baud
        self.settings = (port, baud, timeout_s)
        self.identity = identity_of(port)
        self._port = open_port(port, baud, timeout_s, write_timeout_s=1)

    def read(self) -> bytes:
        """What has arrived, as bytes. Raises ConnectionLost when the port has gone."""
        try:
            data = self._port.read(1)
            if data:
                data += self._port.read(min(self._port.in_waiting, _PIECE))
            return data
        except (serial.SerialException, OSError, TypeError) as error:  # TypeError: closed under the read
            raise ConnectionLost("the port %s vanished while reading" % self.name) from error

    def write(self, data: bytes) -> None:
        """Sends bytes. Raises ConnectionLost when the port has gone or takes nothing for a second."""
        try:
            self._port.write(data)
        except (serial.SerialException, OSError) as error:
            raise ConnectionLost("the port %s vanished or is stuck while writing" % self.name) from error

    def flush(self) -> None:
        """Waits until everything that was written is out."""
        self._port.flush()

    def close(self) -> None:
        self._port.close()


class ReconnectingSource:
    """A SerialSource that survives unplugging: `read` returns b"" while the port is gone, and goes on when
    the same device is back, whatever its port is called then. `on_change(text)` is told of both."""

    live = True

    def __init__(
        self,
        source: SerialSource,
        on_change: Callable[[str], object] = report,
    ) -> None:
        self.name = source.name
        self._source: SerialSource | None = source
        self._settings = source.settings
        self._identity = source.identity
        self._on_change = on_change
        self._refusals = 0

    def read(self) -> bytes:
        """What has arrived, b"" also while the port is gone."""
        if self._source is None:
            time.sleep(_RETRY_S)
            self._open_again()
        if self._source is None:
            return b""
        try:
            return self._source.read()
        except ConnectionLost as error:
            self._source.close()
            self._source = None
            known = self._identity.text()
            what = " (%s, under any name)" % known if known else ""
            self._on_change("%s; waiting for it%s" % (error, what))
            return b""

    def _open_again(self):
        name = find_again(self.name, self._identity)
        if name is None:
            return
        try:
            self._source = SerialSource(name, *self._settings[1:])
        except UserError as error:
            # such as a port that somebody else has taken; a new one may lack its rights for a moment
            self._refusals += 1
            if self._refusals == _PATIENCE:
                self._on_change("%s; still waiting" % error)
            return
        self._refusals = 0
        before, self.name = self.name, name
        known = self._identity.text()
        again = "the port %s is back" % name
        if name != before:
            again = "the device with the %s is back as %s" % (known, name)
        self._on_change(again)

    def close(self) -> None:
        if self._source is not None:
            self._source.close()


@contextlib.contextmanager
def stop_on_signals(live: bool) -> Iterator[Callable[[], bool]]:
    """A function that tells whether Ctrl-C or SIGTERM came. A source that is not live may block for ever,
    so there they raise KeyboardInterrupt; from a live one nothing that was read gets lost."""
    came = []

    def note(*_):
        came.append(True)
        if not live:
            raise KeyboardInterrupt

    previous = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


class FileSource:
    """A file of raw bytes as the camera sent them, or "-" for standard input."""

    live = False

    def __init__(self, path: StrPath) -> None:
        self.name = path
        try:
            self._file = sys.stdin.buffer if path == "-" else open(path, "rb")  # noqa: SIM115
        except OSError as error:
            raise UserError("cannot read %s: %s" % (path, error.strerror)) from error

    def read(self) -> bytes | None:
        """The next bytes, or None at the end."""
        return self._file.read(_PIECE) or None

    def close(self) -> None:
        if self._file is not sys.stdin.buffer:
            self._file.close()
