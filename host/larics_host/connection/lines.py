"""The line to a camera by its name: a serial port, or tcp://HOST:PORT, as `larics camera --tcp` serves it."""

from __future__ import annotations

import contextlib
import re
import socket
from typing import Any

from larics_host.connection import byte_sources
from larics_host.connection.byte_sources import ConnectionLost
from larics_host.errors import UserError

_TCP = "tcp://"
_PIECE = 65536
_CONNECT_S = 5.0
_ADDRESS = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[^\s:/\[\]]+):(\d{1,5})")


def is_address(name: str) -> bool:
    """Whether the name of a line is that of a TCP address."""
    return name.lower().startswith(_TCP)


def open_line(name: str, baud: int = 115200, timeout_s: float | None = None) -> Any:
    """An open byte_sources.SerialSource or TcpSource. UserError when that cannot be."""
    more = {} if timeout_s is None else {"timeout_s": timeout_s}
    if is_address(name):
        return TcpSource(name, **more)
    return byte_sources.SerialSource(name, baud, **more)


class TcpSource:
    """A camera at tcp://HOST:PORT. `read` returns b"" when nothing came within `timeout_s`."""

    live = True
    baud = 0  # there is none

    def __init__(self, name: str, timeout_s: float = 0.1) -> None:
        match = _ADDRESS.fullmatch(name[len(_TCP) :])
        if match is None or int(match.group(2)) > 65535:
            raise UserError("%s is no address: write tcp://HOST:PORT, as tcp://127.0.0.1:7007" % name)
        self.name = name
        self._timeout_s = timeout_s
        where = match.group(1).strip("[]"), int(match.group(2))
        try:
            self._socket = socket.create_connection(where, timeout=_CONNECT_S)
        except (OSError, UnicodeError) as error:
            why = getattr(error, "strerror", None) or error
            raise UserError(
                "cannot connect to %s: %s; is larics camera --tcp running there?" % (name, why)
            ) from error
        self._socket.settimeout(timeout_s)
        with contextlib.suppress(OSError):
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def read(self) -> bytes:
        """What has arrived. Raises ConnectionLost when the other side has gone."""
        try:
            data = self._socket.recv(_PIECE)
        except TimeoutError:
            return b""
        except OSError as error:
            raise ConnectionLost("the connection to %s broke" % self.name) from error
        if not data:
            raise ConnectionLost("%s hung up" % self.name)
        return data

    def write(self, data: bytes) -> None:
        """Sends bytes. Raises ConnectionLost when the other side has gone or takes nothing."""
        try:
            self._socket.sendall(data)
        except OSError as error:
            raise ConnectionLost("the connection to %s broke while writing" % self.name) from error

    def flush(self) -> None:
        """Everything that was written is out already."""

    def again(self) -> TcpSource | None:
        """A new connection; None while there is none to be had."""
        try:
            return TcpSource(self.name, self._timeout_s)
        except UserError:
            return None

    def known_as(self) -> str:
        """Nothing but the address tells one from another."""
        return ""

    def title(self) -> str:
        """The line in a sentence."""
        return self.name

    def close(self) -> None:
        self._socket.close()
