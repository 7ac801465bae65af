"""Two pseudo-terminals joined back to back: a serial cable without hardware."""

from __future__ import annotations

import os
import select
import threading
import tty


class PtyPair:
    """`device_a` and `device_b` are paths to open as serial ports; what one side writes the other reads.

    Use as a context manager. `unplug()` takes both devices away, as pulling a USB plug does.
    `carried_bytes` counts what went from a to b.
    """

    def __init__(self) -> None:
        self._masters = []
        self._slaves = []
        for _ in range(2):
            master, slave = os.openpty()
            tty.setraw(slave)
            os.set_blocking(master, False)
            self._masters.append(master)
            self._slaves.append(slave)  # kept open: a master reports a hang-up while no slave is open
        self.device_a, self.device_b = (os.ttyname(slave) for slave in self._slaves)
        self.carried_bytes = 0
        self._stop_read, self._stop_write = os.pipe()
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self._thread.start()

    def _carry(self):
        a, b = self._masters
        waiting = {a: b"", b: b""}  # to be written to this side
        while True:
            # a full side is not read on, so that the writer feels the line's limit
            sources = [end for end, other in ((a, b), (b, a)) if len(waiting[other]) < 4096]
            targets = [end for end in (a, b) if waiting[end]]
            readable, writable, _ = select.select([*sources, self._stop_read], targets, [])
            if self._stop_read in readable:
                return
            for end in readable:
                data = os.read(end, 4096)
                other = b if end == a else a
                waiting[other] += data
                if end == a:
                    self.carried_bytes += len(data)
            for end in writable:
                try:
                    written = os.write(end, waiting[end])
                except BlockingIOError:
                    continue
                waiting[end] = waiting[end][written:]

    def unplug(self) -> None:
        """Closes everything; whoever has a device open gets an error. Safe to call twice."""
        if not self._masters:
            return
        os.write(self._stop_write, b"x")
        self._thread.join()
        for end in self._slaves + self._masters + [self._stop_read, self._stop_write]:
            os.close(end)
        self._masters = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.unplug()
