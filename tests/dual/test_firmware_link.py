"""The serial link's ring: order, whole messages only, and a UART that takes little, nothing or fails."""

from serial_line import SerialLine


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
    link = SerialLine(uart, ignore, 100)
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


def test_a_message_that_does_not_fit_is_refused_whole():
    uart = Uart()
    link = SerialLine(uart, ignore, 50)
    assert link.send(message(1, 30), 30)
    assert not link.send(message(2, 30), 30)
    assert link.send(message(3, 20), 20)
    assert link.free() == 0 and link.pending() == 50
    while link.pending():
        link.pump()
    assert bytes(uart.sent) == message(1, 30) + message(3, 20)


def test_only_the_given_count_is_sent():
    uart = Uart()
    link = SerialLine(uart, ignore, 50)
    link.send(message(1, 40), 7)
    link.pump()
    assert bytes(uart.sent) == message(1, 40)[:7]


def test_none_and_short_writes_lose_nothing():
    uart = Uart(room=0)
    link = SerialLine(uart, ignore, 100)
    data = message(5, 60)
    link.send(data, 60)
    assert link.pump() and link.stalled and not uart.sent
    uart.room = 25
    assert link.pump() and len(uart.sent) == 25
    uart.room = 1000
    assert link.pump() and not link.stalled
    assert bytes(uart.sent) == data


def test_a_failing_uart_is_counted_and_the_bytes_wait():
    uart = Uart()
    link = SerialLine(uart, ignore, 100)
    link.send(message(5, 60), 60)
    uart.broken = True
    assert not link.pump() and not link.poll() and link.failed
    uart.broken = False
    assert link.pump() and not link.failed
    assert bytes(uart.sent) == message(5, 60)


def test_one_call_is_bounded():
    uart = Uart()
    link = SerialLine(uart, ignore, 1000)
    link.send(message(5, 900), 900)
    link.pump()
    assert 0 < len(uart.sent) <= 320


def test_what_arrives_is_handed_on():
    uart = Uart()
    got = bytearray()
    link = SerialLine(uart, lambda buffer, count: got.extend(bytes(buffer[:count])), 100)
    uart.incoming = message(9, 150)
    for _ in range(5):
        assert link.poll()
    assert bytes(got) == message(9, 150)
