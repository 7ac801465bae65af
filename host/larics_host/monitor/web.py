"""The monitor as a page for browsers of this computer: one HTML file, server-sent events, one picture."""

from __future__ import annotations

import json
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from typing import TYPE_CHECKING

from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics_host.monitor.session import Session

_PERIOD_S = 0.1
_KEEP_ALIVE_S = 5.0
_POLICY = "default-src 'self' data:; script-src 'unsafe-inline'; style-src 'unsafe-inline'"
_HOSTS = ("127.0.0.1", "localhost")


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *_):
        """Nobody wants a line for each request."""

    def do_GET(self):
        if not self._is_local():
            return
        path = self.path.split("?")[0]
        if path == "/":
            page = resources.files("larics_host.monitor").joinpath("page.html").read_bytes()
            self._answer(200, "text/html; charset=utf-8", page)
        elif path == "/events":
            self._events()
        elif path == "/frame.png":
            self._frame()
        else:
            self._answer(404, "text/plain", b"nothing here\n")

    def do_POST(self):
        if not self._is_local():
            return
        if self.path != "/frame":
            self._answer(404, "text/plain", b"nothing here\n")
        elif self.server.session.fetch_raw():
            self._answer(202, "text/plain", b"asked\n")
        else:
            self._answer(409, "text/plain", b"a log has no camera to ask\n")

    def _is_local(self):
        """Refuses pages of other sites that reach for this one by a name of their own (DNS rebinding)."""
        host = self.headers.get("Host", "").rsplit(":", 1)[0]
        origin = self.headers.get("Origin")
        if host in _HOSTS and (origin is None or origin.split("//")[-1].rsplit(":", 1)[0] in _HOSTS):
            return True
        self._answer(403, "text/plain", b"only for this computer\n")
        return False

    def _answer(self, code, kind, body):
        self.send_response(code)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        policy = (
            "default-src 'self'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' data:"
        )
        self.send_header("Content-Security-Policy", policy)
        self.end_headers()
        self.wfile.write(body)

    def _frame(self):
        session = self.server.session
        with session.lock:
            png = session.raw.png
        if png is None:
            self._answer(404, "text/plain", b"no frame yet\n")
        else:
            self._answer(200, "image/png", png)

    def _events(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Cache-Control", "no-store")
        self.send_header("Connection", "close")
        self.end_headers()
        self.close_connection = True
        number, last, sent_s = 0, None, 0.0
        try:
            while not self.server.closing.wait(_PERIOD_S):
                snapshot, number = self._snapshot(number)
                text = json.dumps(snapshot, separators=(",", ":"))
                if text == last and time.monotonic() - sent_s < _KEEP_ALIVE_S:
                    continue
                self.wfile.write(b"data: " + text.encode() + b"\n\n")
                self.wfile.flush()
                last, sent_s = text, time.monotonic()
        except OSError:
            return  # the page was closed

    def _snapshot(self, number):
        session = self.server.session
        with session.lock:
            snapshot = session.state.snapshot(number)
            raw = session.raw
            snapshot["raw"] = {
                "number": raw.number,
                "ids": raw.ids,
                "progress": raw.progress,
                "error": raw.error,
                "version": raw.version,
            }
        snapshot["live"] = session.live
        snapshot["ended"] = session.ended
        return snapshot, snapshot["number"]


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, address, session):
        self.session = session
        self.closing = threading.Event()
        super().__init__(address, _Handler)

    def shutdown(self):
        self.closing.set()
        super().shutdown()


def serve(session: Session, port: int) -> ThreadingHTTPServer:
    """A server that runs in a thread until its `shutdown`; port 0 takes any free one (`server_port`)."""
    try:
        server = _Server(("127.0.0.1", port), session)
    except OSError as error:
        raise UserError(
            "port %d of this computer cannot be used (%s): give another, --web 0 for any"
            % (port, error.strerror)
        ) from error
    threading.Thread(target=server.serve_forever, args=(_PERIOD_S,), daemon=True).start()
    return server
