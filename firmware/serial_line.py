"""The serial link to the vehicle: a ring of bytes to send, and what arrives handed on.

A call never waits for the line: `send` stores a message, `pump` gives the UART what it takes now.
"""

_CHUNK = 64
_POLL_MAX = 1024  # what a receive buffer holds: after a long detection all of it is read
_PUMP_MAX = 256  # some ports wait until the bytes are out: 22 ms at 115200 baud at most


class SerialLine:
    """`uart`: object with machine.UART's any(), readinto(buffer, count) and write(buffer, offset, count).

    `on_bytes(buffer, count)` gets what arrives. stalled is True while the UART takes less than it is offered,
    failed while it raises OSError.
    """

    def __init__(self, uart, on_bytes, ring_bytes=512):
        self._uart = uart
        self._on_bytes = on_bytes
        self._ring = bytearray(ring_bytes)
        self._head = 0  # next byte to send
        self._used = 0
        self._received = bytearray(_CHUNK)
        self.stalled = False
        self.failed = False

    def free(self):
        """Bytes that send() takes now."""
        return len(self._ring) - self._used

    def pending(self):
        """Bytes that wait to be sent."""
        return self._used

    def send(self, buffer, count):
        """Stores the message buffer[:count]; False when it does not fit as a whole."""
        ring = self._ring
        size = len(ring)
        if count > size - self._used:
            return False
        tail = self._head + self._used
        for index in range(count):
            if tail >= size:
                tail -= size
            ring[tail] = buffer[index]
            tail += 1
        self._used += count
        return True

    def pump(self):
        """Gives the UART what waits, as far as it takes it; returns False when the UART failed."""
        budget = _PUMP_MAX
        while self._used and budget > 0:
            count = min(self._used, len(self._ring) - self._head, _CHUNK)
            try:
                written = self._uart.write(self._ring, self._head, count)
            except OSError:
                self.failed = True
                return False
            self.failed = False
            if written is None:
                written = 0
            self._head += written
            if self._head == len(self._ring):
                self._head = 0
            self._used -= written
            self.stalled = written < count
            if self.stalled:
                break
            budget -= written
        return True

    def poll(self):
        """Hands on what has arrived, a piece at a time; returns False when the UART failed."""
        budget = _POLL_MAX
        try:
            while budget > 0:
                count = min(self._uart.any(), _CHUNK)
                if count:
                    count = self._uart.readinto(self._received, count)
                if not count:
                    return True
                budget -= count
                self._on_bytes(self._received, count)
        except OSError:
            self.failed = True
            return False
        return True
