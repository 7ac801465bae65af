"""The serial link to the vehicle: a ring of whole messages to send, and what arrives handed on.

A call never waits for the line: `send` stores a message, `pump` gives the UART what it takes. When the line
is slower than the messages, those that wait are dropped for the newest, so that what is sent is never old.
"""

from array import array

from larics.messages import COUNT_MAX

_CHUNK = 64
_PUMP_MAX = 256  # some ports wait until the bytes are out: 22 ms at 115200 baud at most
_QUEUE = 32


class Link:
    """`uart`: object with machine.UART's any(), readinto(buffer, count) and write(buffer, offset, count).

    `on_bytes(buffer, count)` gets what arrives. Counters: sent_bytes; dropped (messages); stalled (True
    while the UART takes less than it is offered); failed (True while it raises OSError).
    """

    def __init__(self, uart, on_bytes, ring_bytes=1024):
        self._uart = uart
        self._on_bytes = on_bytes
        self._ring = bytearray(ring_bytes)
        self._head = 0  # next byte to send
        self._used = 0
        self._lengths = array("H", bytes(2 * _QUEUE))  # bytes left of each message that waits
        self._first = 0
        self._waiting = 0
        self._begun = False  # some bytes of the first message are out
        self._received = bytearray(_CHUNK)
        self.sent_bytes = 0
        self.dropped = 0
        self.stalled = False
        self.failed = False

    def free(self):
        """Bytes that can be stored without dropping a message."""
        return len(self._ring) - self._used if self._waiting < _QUEUE else 0

    def pending(self):
        """Bytes that wait to be sent."""
        return self._used

    def send(self, buffer, count):
        """Stores the message buffer[:count]. When it does not fit, the messages that wait are dropped; only
        the rest of one that is already on the line stays. Returns False when that is still too little."""
        if count > self.free():
            self._drop()
            if count > self.free():
                self.dropped = (self.dropped + 1) & COUNT_MAX
                return False
        ring = self._ring
        size = len(ring)
        tail = self._head + self._used
        for index in range(count):
            if tail >= size:
                tail -= size
            ring[tail] = buffer[index]
            tail += 1
        self._used += count
        self._lengths[(self._first + self._waiting) % _QUEUE] = count
        self._waiting += 1
        return True

    def _drop(self):
        keep = 1 if self._begun else 0
        self.dropped = (self.dropped + self._waiting - keep) & COUNT_MAX
        self._waiting = keep
        self._used = self._lengths[self._first] if keep else 0

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
            self._advance(written)
            self.stalled = written < count
            if self.stalled:
                break
            budget -= written
        return True

    def _advance(self, written):
        self._head += written
        if self._head == len(self._ring):
            self._head = 0
        self._used -= written
        self.sent_bytes = (self.sent_bytes + written) & COUNT_MAX
        while written:
            left = self._lengths[self._first]
            if written < left:
                self._lengths[self._first] = left - written
                self._begun = True
                return
            written -= left
            self._first = (self._first + 1) % _QUEUE
            self._waiting -= 1
            self._begun = False

    def poll(self):
        """Hands on what has arrived; returns False when the UART failed."""
        try:
            waiting = self._uart.any()
            if not waiting:
                return True
            count = self._uart.readinto(self._received, min(waiting, _CHUNK))
        except OSError:
            self.failed = True
            return False
        if count:
            self._on_bytes(self._received, count)
        return True
