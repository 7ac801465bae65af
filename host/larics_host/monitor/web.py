"""The monitor as a page for browsers of this computer: one HTML file, server-sent events, one picture."""

from __future__ import annotations

from http.server import ThreadingHTTPServer
from importlib import resources
from typing import TYPE_CHECKING

from larics_host import local_server

if TYPE_CHECKING:
    from larics_host.monitor.session import Session


class _Handler(local_server.LocalHandler):
    def do_GET(self):
        if not self.is_local():
            return
        path = self.path.split("?")[0]
        if path == "/":
            page = resources.files("larics_host.monitor").joinpath("page.html").read_bytes()
            self.answer(200, "text/html; charset=utf-8", page)
        elif path == "/events":
            self.events(self._snapshot)
        elif path == "/frame.png":
            self._frame()
        else:
            self.answer(404, "text/plain", b"nothing here\n")

    def do_POST(self):
        if not self.is_local():
            return
        if self.path != "/frame":
            self.answer(404, "text/plain", b"nothing here\n")
        elif self.content.fetch_raw():
            self.answer(202, "text/plain", b"asked\n")
        else:
            self.answer(409, "text/plain", b"a log has no camera to ask\n")

    def _frame(self):
        session = self.content
        with session.lock:
            png = session.raw.png
        if png is None:
            self.answer(404, "text/plain", b"no frame yet\n")
        else:
            self.answer(200, "image/png", png)

    def _snapshot(self, number):
        session = self.content
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


def serve(session: Session, port: int) -> ThreadingHTTPServer:
    """The page's server; see local_server.serve."""
    return local_server.serve(_Handler, session, port)
