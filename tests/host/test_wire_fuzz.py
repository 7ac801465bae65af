"""Whatever comes over the line: no parser raises, nothing is made up, and each frame counts once."""

from array import array

from hypothesis import example, given, settings
from hypothesis import strategies as st

from larics.device.commands import Commands
from larics.device.outbox import Uptime
from larics.device.raw_frame import RawSender
from larics.locate.odometry import Odometry
from larics.settings import FIELDS, Settings
from larics.wire import codec, framing
from larics.wire import messages as m
from larics_host.connection.client import Client
from larics_host.connection.receiver import Receiver, wire_bytes
from larics_host.connection.records import as_json
from wire_values import at

ENDED = ("messages", "crc", "cobs", "length", "version", "unknown", "over_long", "empty", "out_of_range")


@st.composite
def values_of(draw, number):
    values = []
    for _, code, _, low, high, _ in codec.fields(number):
        if code[-1] == "s":
            values.append(draw(st.binary(min_size=int(code[:-1]), max_size=int(code[:-1]))))
        else:
            values.append(draw(st.integers(low, high) | st.sampled_from([low, high, min(max(0, low), high)])))
    return values


@st.composite
def frames(draw):
    """A sound message, or a frame with a right CRC around any content."""
    if draw(st.booleans()):
        number = draw(st.sampled_from([message[1] for message in m.MESSAGES]))
        encoder = codec.Encoder()
        encoder.sequence = draw(st.integers(0, 65535))
        return bytes(encoder.buffer[: encoder.encode(number, draw(values_of(number)))])
    content = draw(st.binary(max_size=framing.LIMIT - 4))
    buffer = bytearray(300)
    buffer[1 : 1 + len(content)] = content
    return bytes(buffer[: framing.seal(buffer, 1 + len(content))])


@settings(max_examples=50)
@given(pieces=st.lists(frames() | st.binary(max_size=200), max_size=12), step=st.integers(1, 300))
@example(pieces=[b"\0\0", b"\1\0", b"\xff" * 400, b"\0"], step=3)
def test_any_bytes_and_each_frame_counts_once(pieces, step):
    data = b"".join(pieces)
    receiver = Receiver()
    found = []
    for start in range(0, len(data), step):
        found += receiver.feed(data[start : start + step], 0.0)
    counters = receiver.counters
    assert sum(getattr(counters, name) for name in ENDED) == data.count(b"\0")
    assert counters.messages == len(found)
    for message in found:  # each is on the line as it was told, also after a way through JSON
        again = wire_bytes(codec.Encoder(), message.name, message.sequence, as_json(message.fields))
        assert again in data


class _Actions:
    def info(self, values):
        values[at(m.INFO, "board")], values[at(m.INFO, "unique_id")] = bytes(16), bytes(12)

    def settings_changed(self, name):
        pass

    def save(self):
        return False

    def raw_frame(self):
        return bytes(300), 20, 15, 7

    def window(self):
        return 3, 2, 17, 13


@st.composite
def requests(draw):
    number = draw(st.sampled_from([k for _, k, _, _ in m.MESSAGES] + [63, 200]))
    if number in (63, 200):
        return number, draw(st.integers(0, 65535)), [draw(st.integers(0, 3))]
    values = draw(values_of(number))
    if number in (m.GET_SETTING, m.SET_SETTING) and draw(st.booleans()):
        field = draw(st.sampled_from(FIELDS))
        values[at(number, "key")] = field.key
        if number == m.SET_SETTING:
            values[at(number, "first")] = draw(st.sampled_from([0, 0, 8]))
            values[at(number, "count")] = draw(st.integers(0, 12))
    if number >= m.FIRST_COMMAND and number != m.ODOMETRY:
        values[0] = draw(st.integers(0, 5))
    return number, draw(st.integers(0, 65535) | st.integers(0, 9)), values


@settings(max_examples=50)
@given(wanted=st.lists(requests(), max_size=40), seconds=st.lists(st.integers(0, 40), max_size=40))
def test_any_requests_are_answered_within_their_ranges(wanted, seconds):
    uptime = Uptime()
    chosen, raw = Settings(), RawSender()
    odometry = Odometry(lambda: uptime.s * 1000000 & m.COUNT_MAX)
    commands = Commands(chosen, raw, _Actions(), 1, uptime, odometry)
    encoder = codec.Encoder()
    for k, (number, sequence, values) in enumerate(wanted):
        uptime.s += seconds[k] if k < len(seconds) else 0
        as_decoded = array("i", values) if number >= m.FIRST_COMMAND else values
        commands.on_message(number, sequence, as_decoded)
        answers = []
        while k % 3 == 2 and (answer := commands.next()):
            assert encoder.encode(answer, commands.values)
            answers.append(answer)
        for _ in range(4):
            chunk = raw.next()
            assert not chunk or encoder.encode(chunk, raw.values)
        assert len(commands._remembered) <= 8 and len(commands._waiting) <= 9
    Settings(chosen.as_dict())  # what was set is a sound whole


@settings(max_examples=50)
@given(pieces=st.lists(frames() | st.binary(max_size=60), max_size=12))
def test_any_bytes_as_answers_to_the_host(pieces):
    heard = []

    class Stream:
        def read(self):
            return b"".join(pieces)

        def write(self, data):
            pass

    client = Client(Stream(), on_message=lambda number, sequence, values: heard.append(number))
    client._waiting_for = (7, m.GET_INFO)
    client.poll()
    assert len(heard) <= client.decoder.counters.messages
