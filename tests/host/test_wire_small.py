"""No intermediate of what runs for each frame leaves the small integers of a 32-bit board."""

import random

from larics.arith.float32 import put_float32
from larics.device.outbox import Outbox, Uptime
from larics.wire import codec as protocol
from larics.wire import messages as m
from larics.wire.mavlink import MavlinkEncoder
from larics.wire.nmea import NmeaEncoder
from tests.host.small_int import Small
from tools.vehicle_build import random_values
from wire_values import at

MEASURED = (m.MARKER, m.POSE, m.STATUS)


def small(values):
    return [value if isinstance(value, bytes) else Small(value) for value in values]


def test_unpacking_any_bytes():
    generator = random.Random(1)
    decoder = protocol.Decoder(lambda *message: None)
    refused = 0
    for _ in range(3000):
        number = generator.choice([message[1] for message in m.MESSAGES])
        fill = generator.choice((None, 0, 0x3F, 0x7F, 0x80, 0xBF, 0xFF))
        decoder._message = [
            Small(generator.randrange(256) if fill is None else fill) for _ in range(protocol.MAX_FRAME)
        ]
        layout = protocol.LAYOUTS[number]
        refused += not decoder._unpack(layout, decoder._values_of(number, layout))
    assert 500 < refused < 3000


def test_floats():
    for denominator in (1, 3, 10000, 16384, 1562500, 12500000, 16777215):
        for numerator in (0, 1, 16777216, 33554433, (1 << 30) - 1):
            for sign in (1, -1):
                put_float32([0] * 4, 0, Small(sign * numerator), Small(denominator))


def test_text_and_mavlink():
    generator = random.Random(2)
    uptime = Uptime()
    mavlink = MavlinkEncoder(uptime, target="ardupilot")
    text = NmeaEncoder()
    for _ in range(3000):
        uptime.s = Small(generator.choice((0, 1, 65535, 65536, 1 << 27, (1 << 30) - 1)))
        uptime.us = Small(generator.randrange(1000000))
        number = generator.choice(MEASURED)
        values = small(random_values(generator, number))
        text.encode(number, values)
        if number == m.MARKER:
            values[at(number, "flags")] = Small(0)
            values[at(number, "frame")] = Small(uptime.us)
        if number == m.POSE:
            values[at(number, "state")] = Small(m.TRACKING)
        assert mavlink.encode(number, values) > 0


class Sink:
    sent = 0

    def free(self):
        return Small(1024)

    def send(self, buffer, count):
        self.sent += 1


class Nothing:
    def next(self):
        return 0


def test_the_outbox():
    generator = random.Random(3)
    for baud in (9600, 921600):
        encoder = protocol.Encoder(clamp=True)
        sink = Sink()
        outbox = Outbox(sink, encoder, (Nothing(), Nothing()), baud, lambda new, old: new - old)
        now = Small(0)
        for _ in range(500):
            outbox.begin()
            outbox.add(m.MARKER, small(random_values(generator, m.MARKER)))
            outbox.commit(now)
            outbox.poll(now)
            now = now + generator.choice((0, 100, 20000, 2000000))
        assert sink.sent > 100
