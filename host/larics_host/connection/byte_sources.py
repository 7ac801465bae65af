"""Reading the camera's wire on a PC: from a serial port, or from a file of recorded bytes."""

from __future__ import annotations

import contextlib
import signal
import sys
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import serial

from larics_host.connection.serial_ports import find_again, identity_of, open_port
from larics_host.errors import UserError, report
from larics_host.packed import opened

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


_PIECE = 4096
_RETRY_S = 0.2
_WRITE_S = 5  # or this computer stood still meanwhile
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
        self._port = open_port(port, baud, timeout_s, write_timeout_s=_WRITE_S)

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
        """Sends bytes. Raises ConnectionLost when the port has gone or does not take them in time."""
        try:
            self._port.write(data)
        except (serial.SerialException, OSError) as error:
            raise ConnectionLost("the port %s vanished or is stuck while writing" % self.name) from error

    def flush(self) -> None:
        """Waits until everything that was written is out."""
        self._port.flush()

    def again(self) -> SerialSource | None:
        """The same device, opened once more under the name that it has by now; None while it is not there.
        UserError when it is and cannot be opened."""
        name = find_again(self.name, self.identity)
        if name is None:
            return None
        source = SerialSource(name, *self.settings[1:])
        source.identity = self.identity
        return source

    def known_as(self) -> str:
        """What tells the device from others; empty when nothing does."""
        return self.identity.text()

    def title(self) -> str:
        """The line in a sentence."""
        return "the port %s" % self.name

    def close(self) -> None:
        self._port.close()


class ReconnectingSource:
    """A SerialSource or TcpSource that survives unplugging: `read` returns b"" while the line is gone, and
    goes on when the same device is back, whatever its port is called then; what is written meanwhile is
    dropped. `on_change(text)` is told of both."""

    live = True

    def __init__(
        self,
        source: Any,
        on_change: Callable[[str], object] = report,
    ) -> None:
        self.name = source.name
        self.baud = source.baud
        self._source = source
        self._gone = False
        self._on_change = on_change
        self._refusals = 0

    def read(self) -> bytes:
        """What has arrived, b"" also while the line is gone."""
        if self._gone:
            time.sleep(_RETRY_S)
            self._open_again()
        if self._gone:
            return b""
        try:
            return self._source.read()
        except ConnectionLost as error:
            self._lose(error)
            return b""

    def write(self, data: bytes) -> None:
        """Sends bytes, if there is somebody."""
        if not self._gone:
            try:
                self._source.write(data)
            except ConnectionLost as error:
                self._lose(error)

    def flush(self) -> None:
        """Waits until everything that was written is out."""
        if not self._gone:
            self._source.flush()

    def _lose(self, error):
        self._source.close()
        self._gone = True
        known = self._source.known_as()
        what = " (%s, under any name)" % known if known else ""
        self._on_change("%s; waiting for it%s" % (error, what))

    def _open_again(self):
        try:
            again = self._source.again()
        except UserError as error:
            # such as a port that somebody else has taken; a new one may lack its rights for a moment
            self._refusals += 1
            if self._refusals == _PATIENCE:
                self._on_change("%s; still waiting" % error)
            return
        if again is None:
            return
        self._refusals = 0
        before, known = self.name, self._source.known_as()
        self._source, self._gone, self.name = again, False, again.name
        text = "%s is back" % again.title()
        if again.name != before:
            text = "the device with the %s is back as %s" % (known, again.name)
        self._on_change(text)

    def close(self) -> None:
        if not self._gone:
            self._source.close()


@contextlib.contextmanager
def stop_on_signals(live: bool, note: Callable[[], object] = lambda: None) -> Iterator[Callable[[], bool]]:
    """A function that tells whether Ctrl-C or SIGTERM came. A source that is not live may block for ever,
    so there they raise KeyboardInterrupt; from a live one nothing that was read gets lost. note: called
    when one comes."""
    came = []

    def take(*_):
        came.append(True)
        note()
        if not live:
            raise KeyboardInterrupt

    previous = {number: signal.signal(number, take) for number in (signal.SIGINT, signal.SIGTERM)}
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
            self._file = sys.stdin.buffer if path == "-" else opened(path)
        except OSError as error:
            raise UserError("cannot read %s: %s" % (path, error.strerror)) from error

    def read(self) -> bytes | None:
        """The next bytes, or None at the end."""
        return self._file.read(_PIECE) or None

    def close(self) -> None:
        if self._file is not sys.stdin.buffer:
            self._file.close()
