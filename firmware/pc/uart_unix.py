"""machine.UART for MicroPython's unix port: the same calls on a terminal device such as /dev/pts/3.

Whoever opens the other end sets the terminal's raw mode. A write never waits: it takes what the device
has room for and returns None when that is nothing, as machine.UART may.
"""

import select

_CHUNK = 256  # a terminal that reports room takes this much without waiting


class UART:
    def __init__(self, device, baudrate=115200, **_):
        self._file = open(device, "r+b")
        self._poll = select.poll()
        self._poll.register(self._file, select.POLLIN | select.POLLOUT)

    def _events(self):
        for _, events in self._poll.ipoll(0):
            return events
        return 0

    def any(self):
        return 1 if self._events() & select.POLLIN else 0  # readinto() would wait for a second byte

    def readinto(self, buffer, count):
        return self._file.readinto(buffer, count)

    def write(self, buffer, offset, count):
        if not self._events() & (select.POLLOUT | select.POLLHUP | select.POLLERR):
            return None
        return self._file.write(buffer, offset, min(count, _CHUNK))
