"""A pseudo-terminal that looks like the camera's serial port to whoever opens it."""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import struct
import termios
import time
import tty

_SETTLE_S = 2.0  # a reader sets up the port, and most drop what is in it, right after opening it
_POLL_S = 0.02
_EMPTY_READINGS = 5  # what was just written reaches the reader's side a little later


class PtyPort:
    """`device` is the path to open; `wait_for_reader` returns when somebody has. Ends with `close`."""

    def __init__(self) -> None:
        self._master, slave = os.openpty()
        self.device = os.ttyname(slave)
        os.close(slave)  # with no end of our own open, the master tells whether somebody else's is
        os.set_blocking(self._master, False)
        self._poll = select.poll()
        self._poll.register(self._master, select.POLLHUP)

    def has_reader(self) -> bool:
        return not any(event & select.POLLHUP for _, event in self._poll.poll(0))

    def wait_for_reader(self) -> None:
        """Returns when the reader has dropped what was in the port, as pyserial does at last when it opens
        one; after a while for those that do not."""
        fcntl.ioctl(self._master, termios.TIOCPKT, struct.pack("i", 1))  # the terminal tells of that
        while not self.has_reader():
            time.sleep(_POLL_S)
        with self._other_end() as slave:
            tty.setraw(slave, termios.TCSANOW)  # which drops nothing itself
        end_s = time.monotonic() + _SETTLE_S
        while time.monotonic() < end_s and not self._was_flushed():
            time.sleep(_POLL_S)
        fcntl.ioctl(self._master, termios.TIOCPKT, struct.pack("i", 0))

    def _was_flushed(self):
        """Whether the other side dropped what waited for it, since this was asked last."""
        told = self.read()
        return len(told) == 1 and told[0] & termios.TIOCPKT_FLUSHREAD

    @contextlib.contextmanager
    def _other_end(self):
        slave = os.open(self.device, os.O_RDWR | os.O_NOCTTY)
        try:
            yield slave
        finally:
            os.close(slave)

    def write(self, data: bytes) -> None:
        """Writes all of it, waiting for the reader. BrokenPipeError when the reader has gone."""
        view = memoryview(data)
        while view:
            if not self.has_reader():
                raise BrokenPipeError("the reader of %s has gone" % self.device)
            _, ready, _ = select.select([], [self._master], [], 0.1)
            if ready:
                with contextlib.suppress(BlockingIOError):
                    view = view[os.write(self._master, view) :]

    def read(self) -> bytes:
        """What the other side sent, b"" when nothing waits."""
        try:
            return os.read(self._master, 4096)
        except (BlockingIOError, OSError):
            return b""

    def drain(self) -> None:
        """Waits until the reader has taken everything, or has gone."""
        empty = 0
        while empty < _EMPTY_READINGS and self.has_reader():
            time.sleep(_POLL_S)
            with self._other_end() as slave:
                waiting = fcntl.ioctl(slave, termios.FIONREAD, bytes(4))
            empty = 0 if struct.unpack("i", waiting)[0] else empty + 1

    def close(self) -> None:
        os.close(self._master)
