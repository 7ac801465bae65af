"""A page's server for browsers of this computer only, in the standard library.

Pages of other sites must not reach it: Host has to name this computer, Origin has to equal it, and a
connection ends with every refusal and every request that has a body, so that no body is taken for a request.
"""

from __future__ import annotations

import contextlib
import io
import json
import re
import socket
import sys
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from larics_host.errors import UserError, report

DEFAULT_PORT = 8731
PERIOD_S = 0.1
_KEEP_ALIVE_S = 5.0
_TIMEOUT_S = 5.0  # for a whole request, and for each piece of an answer
CONNECTIONS = 32  # at a time; a browser takes up to six
_UNREAD_BYTES = 65536  # of a body, so that a refusal still reaches who sent it
_POLICY = (
    "default-src 'self'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' data:; "
    "frame-ancestors 'none'"
)
_HOST = re.compile(r"(127\.0\.0\.1|localhost|\[::1\])(:\d{1,5})?")
_FULL = b"HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"


class _TimedReader(io.RawIOBase):
    """Reads a socket until a time that `begin` sets: also who sends a byte a second has to come to an end."""

    def __init__(self, connection):
        self._connection = connection
        self.begin()

    def begin(self):
        self._end_s = time.monotonic() + _TIMEOUT_S

    def readable(self):
        return True

    def readinto(self, buffer):
        left_s = self._end_s - time.monotonic()
        if left_s <= 0:
            raise TimeoutError
        self._connection.settimeout(left_s)
        return self._connection.recv_into(buffer)


class LocalHandler(BaseHTTPRequestHandler):
    """For handlers of a page: `is_local` first, then `answer` or `events`; `content` is what it shows."""

    protocol_version = "HTTP/1.1"

    def setup(self) -> None:
        super().setup()
        self.rfile.close()
        self._reader = _TimedReader(self.connection)
        self.rfile = io.BufferedReader(self._reader)

    def handle_one_request(self) -> None:
        self._reader.begin()
        super().handle_one_request()

    def log_message(self, *_: Any) -> None:
        """Nobody wants a line for each request."""

    @property
    def content(self) -> Any:
        return self.server.content  # type: ignore[attr-defined]

    def is_local(self) -> bool:
        """Refuses pages of other sites that reach for this one by a name of their own (DNS rebinding)."""
        hosts = self.headers.get_all("Host", [])
        host = hosts[0].strip().lower() if len(hosts) == 1 else ""
        origin = self.headers.get("Origin")
        if _HOST.fullmatch(host) and (origin is None or origin.strip().lower() == "http://" + host):
            return True
        self.answer(403, "text/plain", b"only for this computer\n")
        return False

    def _has_body(self):
        return "Content-Length" in self.headers or "Transfer-Encoding" in self.headers

    def answer(self, code: int, kind: str, body: bytes) -> None:
        """The whole answer to a request."""
        with_body = self._has_body()
        if with_body or code >= 400:
            self.close_connection = True
        self.connection.settimeout(_TIMEOUT_S)
        self.send_response(code)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("Content-Security-Policy", _POLICY)
        self.send_header("X-Content-Type-Options", "nosniff")
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(body)
        if with_body:
            self._discard()

    def _discard(self):
        """What is left unread when a connection closes would take the answer away from who sent it."""
        with contextlib.suppress(OSError, ValueError):
            self.connection.shutdown(socket.SHUT_WR)
            left = _UNREAD_BYTES
            while left > 0:
                data = self.rfile.read1(left)
                if not data:
                    return
                left -= len(data)

    def events(self, snapshot: Callable[[int], tuple[Any, int]]) -> None:
        """Server-sent events until either side ends: of snapshot(number) -> (value for JSON, next number)."""
        self.close_connection = True
        self.connection.settimeout(_TIMEOUT_S)
        self.send_response(200)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Cache-Control", "no-store")
        self.send_header("Connection", "close")
        self.end_headers()
        number, last, sent_s = 0, None, 0.0
        try:
            while not self.server.closing.wait(PERIOD_S):  # type: ignore[attr-defined]
                value, number = snapshot(number)
                text = json.dumps(value, separators=(",", ":"))
                if text == last and time.monotonic() - sent_s < _KEEP_ALIVE_S:
                    continue
                self.wfile.write(b"data: " + text.encode() + b"\n\n")
                self.wfile.flush()
                last, sent_s = text, time.monotonic()
        except OSError:
            return  # the page was closed


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, address, handler, content):
        self.content = content
        self.closing = threading.Event()
        self._free = threading.BoundedSemaphore(CONNECTIONS)
        super().__init__(address, handler)

    def process_request(self, request, client_address):
        if self._free.acquire(blocking=False):
            super().process_request(request, client_address)
            return
        with contextlib.suppress(OSError):
            request.settimeout(PERIOD_S)
            request.sendall(_FULL)
        self.shutdown_request(request)

    def process_request_thread(self, request, client_address):
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def handle_error(self, request, client_address):
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):  # those are browsers that went away
            report("the page's server could not answer a request: %r" % error)

    def shutdown(self):
        self.closing.set()
        super().shutdown()


def serve(handler: type[LocalHandler], content: Any, port: int) -> ThreadingHTTPServer:
    """A server that runs in a thread until its `shutdown`; port 0 takes any free one (`server_port`)."""
    try:
        server = _Server(("127.0.0.1", port), handler, content)
    except OSError as error:
        raise UserError(
            "port %d of this computer cannot be used (%s): give another, --web 0 for any"
            % (port, error.strerror)
        ) from error
    threading.Thread(target=server.serve_forever, args=(PERIOD_S,), daemon=True).start()
    return server
