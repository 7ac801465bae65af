"""The serial link's ring: order, whole messages only, and a UART that takes little, nothing or fails."""

from link import Link


class Uart:
    """Takes at most `room` bytes a call; None when 0, as machine.UART; raises when `broken`."""

    def __init__(self, room=1000):
        self.room = room
        self.broken = False
        self.sent = bytearray()
        self.incoming = b""

    def write(self, buffer, offset, count):
        if self.broken:
            raise OSError(5)
        if not self.room:
            return None
        count = min(count, self.room)
        self.sent.extend(bytes(buffer[offset : offset + count]))
        return count

    def any(self):
        if self.broken:
            raise OSError(5)
        return len(self.incoming)

    def readinto(self, buffer, count):
        buffer[:count] = self.incoming[:count]
        self.incoming = self.incoming[count:]
        return count


def ignore(buffer, count):
    pass


def message(number, length):
    return bytes([(number * 37 + index) & 255 for index in range(length)])


def test_bytes_keep_their_order_over_many_turns_of_the_ring():
    uart = Uart(room=13)
    link = Link(uart, ignore, 100)
    expected = b""
    for number in range(200):
        data = message(number, 1 + number * 7 % 40)
        while link.free() < len(data):
            link.pump()
        assert link.send(data, len(data))
        expected += data
    while link.free() < 100:
        assert link.pump()
    assert bytes(uart.sent) == expected
    assert link.sent_bytes == len(expected) and link.dropped == 0


def test_the_newest_message_replaces_those_that_wait():
    uart = Uart()
    link = Link(uart, ignore, 100)
    for number in range(3):
        link.send(message(number, 30), 30)
    assert link.send(message(9, 30), 30)
    assert link.dropped == 3
    link.pump()
    assert bytes(uart.sent) == message(9, 30)


def test_a_message_that_is_already_on_the_line_is_finished():
    uart = Uart(room=10)
    link = Link(uart, ignore, 100)
    for number in range(3):
        link.send(message(number, 30), 30)
    uart.write = one_call(uart)
    link.pump()
    del uart.write
    assert bytes(uart.sent) == message(0, 30)[:10]
    assert link.send(message(9, 60), 60)
    assert link.dropped == 2
    uart.room = 1000
    link.pump()
    assert bytes(uart.sent) == message(0, 30) + message(9, 60)


def one_call(uart):
    """A write that takes `room` bytes once and then nothing."""
    real = uart.write
    calls = []

    def write(buffer, offset, count):
        calls.append(count)
        return real(buffer, offset, count) if len(calls) == 1 else None

    return write


def test_many_small_messages_are_bounded_too():
    uart = Uart(room=0)
    link = Link(uart, ignore, 1000)
    for number in range(33):
        assert link.send(bytes([number]), 1)
    assert link.dropped == 32
    uart.room = 1000
    link.pump()
    assert bytes(uart.sent) == bytes([32])


def test_a_message_longer_than_the_ring_is_refused():
    link = Link(Uart(), ignore, 50)
    assert not link.send(message(2, 51), 51)
    assert link.dropped == 1


def test_only_the_given_count_is_sent():
    uart = Uart()
    link = Link(uart, ignore, 50)
    link.send(message(1, 40), 7)
    link.pump()
    assert bytes(uart.sent) == message(1, 40)[:7]


def test_none_and_short_writes_lose_nothing():
    uart = Uart(room=0)
    link = Link(uart, ignore, 100)
    data = message(5, 60)
    link.send(data, 60)
    assert link.pump() and link.sent_bytes == 0 and link.stalled
    uart.room = 25
    assert link.pump() and link.sent_bytes == 25
    uart.room = 1000
    assert link.pump() and not link.stalled
    assert bytes(uart.sent) == data


def test_a_failing_uart_is_counted_and_the_bytes_wait():
    uart = Uart()
    link = Link(uart, ignore, 100)
    link.send(message(5, 60), 60)
    uart.broken = True
    assert not link.pump() and not link.poll() and link.failed
    uart.broken = False
    assert link.pump() and not link.failed
    assert bytes(uart.sent) == message(5, 60)


def test_one_call_is_bounded():
    uart = Uart()
    link = Link(uart, ignore, 1000)
    link.send(message(5, 900), 900)
    link.pump()
    assert 0 < len(uart.sent) <= 320


def test_what_arrives_is_handed_on():
    uart = Uart()
    got = bytearray()
    link = Link(uart, lambda buffer, count: got.extend(bytes(buffer[:count])), 100)
    uart.incoming = message(9, 150)
    for _ in range(5):
        assert link.poll()
    assert bytes(got) == message(9, 150)
