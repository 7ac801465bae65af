"""The wire: round trips, any chunking, every kind of damage, and no allocation on a board."""

from array import array
from binascii import crc32

from larics.kernels import crc as kernel
from larics.wire import codec as p
from larics.wire import framing
from wire_values import at, changed, named

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock

X = at(p.MARKER, "x_mm10")


class Sink:
    def __init__(self):
        self.messages = []
        self.decoder = p.Decoder(self._keep)

    def _keep(self, number, sequence, values):
        values = [bytes(v) if isinstance(v, bytearray) else v for v in values]
        self.messages.append((number, sequence, values))

    def feed(self, data):
        self.decoder.feed(data, len(data))

    def counts(self):
        return {name: count for name, count in self.decoder.counters.as_dict().items() if count}


class Random:
    """Small generator, so that both interpreters see the same numbers."""

    def __init__(self, seed):
        self.state = seed * 2654435761 % 4294967296 or 1

    def below(self, n):
        x = self.state
        x ^= x << 13 & 0xFFFFFFFF
        x ^= x >> 17
        x ^= x << 5 & 0xFFFFFFFF
        self.state = x
        return x % n


def values_of(number, pick):
    values = []
    for _, code, _, low, high, _ in p.fields(number):
        if code[-1] == "s":
            values.append(bytes([pick(0, 255) for _ in range(int(code[:-1]))]))
        else:
            values.append(pick(low, high))
    return values


def numbers():
    return [message[1] for message in p.MESSAGES]


def frame_of(content):
    """A frame around any content (version, type, sequence, payload), with its CRC."""
    buffer = bytearray(300)
    buffer[1 : 1 + len(content)] = content
    size = framing.seal(buffer, 1 + len(content))
    return bytes(buffer[:size])


def stream(count, seed=1):
    """(bytes, messages) of so many random messages of all types."""
    random = Random(seed)
    encoder = p.Encoder()
    data = b""
    messages = []
    types = numbers()
    for _ in range(count):
        number = types[random.below(len(types))]
        values = values_of(number, lambda low, high: low + random.below(high - low + 1))
        if number == p.INFO or number == p.STATUS:
            values = changed(number, values, boot=7)
        messages.append((number, encoder.sequence, values))
        size = encoder.encode(number, values)
        data += bytes(encoder.buffer[:size])
    return data, messages


def test_every_type_at_its_limits():
    sink = Sink()
    encoder = p.Encoder()
    for number in numbers():
        for pick in (lambda low, high: low, lambda low, high: high):
            values = values_of(number, pick)
            sequence = encoder.sequence
            size = encoder.encode(number, values)
            assert size == p.frame_size(number) <= p.MAX_FRAME
            assert encoder.buffer.find(b"\0") == size - 1
            sink.feed(bytes(encoder.buffer[:size]))
            assert sink.messages[-1] == (number, sequence, values)
    assert sink.counts() == {"messages": 2 * len(numbers()), "restarts": 3}  # boot 0, 65535, 0, 65535


def test_values_out_of_range_are_refused_and_send_nothing():
    encoder = p.Encoder()
    for number in numbers():
        fields = p.fields(number)
        for k in range(len(fields)):
            name, code, _, low, high, _ = fields[k]
            if code[-1] == "s":
                bad = [b"", bytes(int(code[:-1]) + 1)]
            else:
                bad = [low - 1, high + 1, 1 << 40]
            for value in bad:
                values = values_of(number, lambda low, high: low)
                values[k] = value
                try:
                    encoder.encode(number, values)
                except ValueError as error:
                    assert p.name(number) + "." + name in str(error)
                else:
                    raise AssertionError("%s.%s = %s was encoded" % (p.name(number), name, value))
    for number, values in ((p.PING, []), (p.GET_SETTING, [1]), (0, []), (200, [1])):
        try:
            encoder.encode(number, values)
        except ValueError:
            continue
        raise AssertionError((number, values))
    assert encoder.sequence == 0


def test_a_device_clamps_and_counts_instead():
    sink = Sink()
    encoder = p.Encoder(clamp=True)
    values = values_of(p.MARKER, lambda low, high: low)
    values[X] = 2000000
    values[at(p.MARKER, "heading_cdeg")] = -1
    sink.feed(bytes(encoder.buffer[: encoder.encode(p.MARKER, values)]))
    assert encoder.clamped == 2
    found = named(p.MARKER, sink.messages[0][2])
    assert found["x_mm10"] == 1000000 and found["heading_cdeg"] == 0


def test_any_chunking_gives_the_same():
    data, messages = stream(60)
    for step in (1, 2, 3, 7, 64, 1000, len(data)):
        sink = Sink()
        for start in range(0, len(data), step):
            sink.feed(data[start : start + step])
        assert sink.messages == messages
        assert sink.counts() == {"messages": len(messages)}


def test_garbage_costs_at_most_the_frame_it_touches():
    random = Random(5)
    data, messages = stream(3)
    for length in (1, 5, 40, 127, 128, 129, 130, 500, 2000):
        sink = Sink()
        sink.feed(bytes([1 + random.below(255) for _ in range(length)]))
        sink.feed(data)
        assert sink.messages == messages[1:]
        sink = Sink()
        sink.feed(bytes([1 + random.below(255) for _ in range(length)]) + b"\0")
        sink.feed(data)
        assert sink.messages == messages


def test_each_defect_has_its_counter():
    good = bytes([p.VERSION, p.PING, 5, 0, 1, 0])

    def counts(data, before=b""):
        sink = Sink()
        sink.feed(data)
        sink.feed(frame_of(good))
        assert sink.messages[-1] == (p.PING, 5, [1])
        found = sink.counts()
        found["messages"] -= 1
        return {name: count for name, count in found.items() if count}

    frame = frame_of(good)
    flipped = bytearray(frame)
    flipped[2] ^= 2
    assert counts(bytes(flipped)) == {"crc": 1}
    assert counts(b"\x09\x01\x02\0") == {"cobs": 1}
    assert counts(b"\x03\x01\x02\0") == {"length": 1}
    assert counts(b"\0\0\0") == {"empty": 3}
    assert counts(b"\x81" + bytes([1] * 130) + b"\0") == {"over_long": 1}
    assert counts(b"\x01" * 500 + b"\0") == {"over_long": 1}
    assert counts(b"\xff\x01\0") == {"over_long": 1}
    assert counts(frame_of(bytes([p.VERSION + 1]) + good[1:])) == {"version": 1}
    for size in (1, 3):  # with a good CRC, but no whole header
        assert counts(frame_of(good[:size])) == {"length": 1}
        assert counts(frame_of(bytes([p.VERSION + 1]) + good[1:size])) == {"length": 1}
    assert counts(frame_of(bytes([p.VERSION, 63, 4, 0, 1, 2, 3]))) == {"unknown": 1}
    assert counts(frame_of(bytes([p.VERSION, p.PING, 4, 0, 1]))) == {"length": 1}
    assert counts(frame_of(bytes([p.VERSION, p.PING, 4, 0, 1, 2, 3]))) == {"length": 1}
    assert counts(frame_of(good[:2] + b"\x04\x00")) == {"length": 1}
    late = values_of(p.POSE, lambda low, high: low)
    encoder = p.Encoder()
    encoder.sequence = 4
    content = bytearray(p.frame_size(p.POSE) - framing.OVERHEAD)
    encoder.encode(p.POSE, late)
    content[:4] = bytes([p.VERSION, p.POSE, 4, 0])
    state = 4 + sum([p.SIZES[kind] for kind in p.LAYOUTS[p.POSE][1 : 1 + at(p.POSE, "state")]])
    content[state] = 4
    assert counts(frame_of(bytes(content))) == {"out_of_range": 1}
    for top in (0x40, 0x7F, 0x80, 0xFF):
        content[state] = 0
        content[4 + 3] = top
        assert counts(frame_of(bytes(content))) == {"out_of_range": 1}


def test_the_longest_content_fits():
    content = bytes([p.VERSION, 63, 0, 0]) + bytes(framing.LIMIT - 8)
    sink = Sink()
    sink.feed(frame_of(content))
    assert sink.counts() == {"unknown": 1}
    sink = Sink()
    sink.feed(frame_of(content + b"\0"))
    assert sink.counts() == {"over_long": 1}


def test_gaps_and_repeats_are_counted():
    encoder = p.Encoder()
    encoder.sequence = 65533
    frames = []
    for _ in range(8):
        frames.append(bytes(encoder.buffer[: encoder.encode(p.PING, [1])]))
    assert encoder.sequence == 5
    sink = Sink()
    for k in (0, 1, 4, 5, 5, 7):
        sink.feed(frames[k])
    assert sink.counts() == {"messages": 6, "gaps": 3, "repeats": 1}
    assert [sequence for _, sequence, _ in sink.messages] == [65533, 65534, 1, 2, 2, 4]


def numbered(encoder, sequence, boot=None):
    """A PING with this number, or a STATUS that tells its boot number."""
    encoder.sequence = sequence & 0xFFFF
    if boot is None:
        return bytes(encoder.buffer[: encoder.encode(p.PING, [1])])
    values = changed(p.STATUS, values_of(p.STATUS, lambda low, high: low), boot=boot)
    return bytes(encoder.buffer[: encoder.encode(p.STATUS, values)])


def counted(*steps):
    """The counters after messages of (sequence) or (sequence, boot)."""
    sink, encoder = Sink(), p.Encoder()
    for step in steps:
        sink.feed(numbered(encoder, *step))
    found = sink.counts()
    assert found.pop("messages") == len(steps)
    return found


def test_a_sender_that_begins_anew_lost_nothing():
    assert counted((500,), (0,), (1,)) == {"restarts": 1}
    assert counted((100, 7), (101,), (0, 8), (1,)) == {"restarts": 1}
    # from a high number the step looks like a gap until the boot number is heard
    assert counted((60000, 7), (3,)) == {"gaps": 5538}
    assert counted((60000, 7), (3,), (4, 8), (5,)) == {"restarts": 1}
    assert counted((60000, 7), (60005,), (3,), (4, 8), (6,)) == {"restarts": 1, "gaps": 5}
    assert counted((60000, 7), (3,), (4, 7)) == {"gaps": 5538}
    # the port was closed for long and the sender went on: no restart
    assert counted((100, 7), (50000,), (50001, 7)) == {"gaps": 49899}
    assert counted((100, 7), (50000,), (50001, 8)) == {"restarts": 1}
    assert counted((100, 7), (101, 8), (102, 9)) == {"restarts": 2}


def test_messages_that_overtake_each_other_are_not_missing():
    assert counted((5,), (7,), (6,), (8,)) == {}
    assert counted((65534,), (0,), (65535,), (1,)) == {}
    assert counted((5,), (13,), (6,), (14,)) == {"gaps": 6}
    assert counted((5,), (14,), (6,), (7,)) == {"gaps": 8, "restarts": 1}


def test_damage_never_makes_a_message():
    data, messages = stream(400, seed=9)
    sent = set(repr(message) for message in messages)
    random = Random(77)
    for _ in range(12):
        damaged = bytearray(data)
        for _wound in range(60):
            place = random.below(len(damaged))
            kind = random.below(4)
            if kind == 0:
                damaged[place] ^= 1 << random.below(8)
            elif kind == 1:
                damaged = damaged[:place] + damaged[place + 1 + random.below(20) :]
            elif kind == 2:
                damaged = damaged[:place] + bytes([random.below(256)]) + damaged[place:]
            else:
                damaged = damaged[: place + 30] + damaged[place:]
        sink = Sink()
        sink.feed(damaged)
        for message in sink.messages:
            assert repr(message) in sent
        assert len(sink.messages) >= 400 - 3 * 60


def test_a_callback_that_fails_leaves_the_decoder_usable():
    seen = []

    def on_message(number, sequence, values):
        seen.append(values[0])
        if len(seen) == 1:
            raise RuntimeError

    decoder = p.Decoder(on_message)
    encoder = p.Encoder()
    for token in (7, 8):
        frame = bytes(encoder.buffer[: encoder.encode(p.PING, [token])])
        try:
            decoder.feed(frame, len(frame))
        except RuntimeError:
            pass
    assert seen == [7, 8]


def test_the_kernel_is_binascii():
    random = Random(3)
    result = array("H", (0, 0))
    data = bytearray(200)
    for _ in range(40):
        for k in range(len(data)):
            data[k] = random.below(256)
        first = random.below(100)
        end = first + random.below(100)
        kernel.crc32(data, framing.CRC_TABLE, first, end, result)
        expected = crc32(data[first:end]) & 0xFFFFFFFF
        assert result[0] == expected & 0xFFFF and result[1] == expected >> 16
        halves = framing.crc_halves(data, first, end)
        assert list(halves) == list(result)


def test_the_cobs_kernel_is_what_seal_does():
    random = Random(4)
    for size in (4, 30, 124):
        content = bytes([random.below(3) for _ in range(size)])
        frame = frame_of(content)
        block = bytearray(size + 6)
        block[1 : 1 + size] = content
        block[1 + size : 5 + size] = _undo_cobs(frame)[size:]
        kernel.cobs(block, 5 + size)
        assert bytes(block) == frame
        assert _undo_cobs(frame)[:size] == content


def _undo_cobs(frame):
    out = bytearray()
    place = 0
    while frame[place]:
        code = frame[place]
        out.extend(frame[place + 1 : place + code])
        out.append(0)
        place += code
    return bytes(out[:-1])


def test_nothing_is_allocated_for_a_message():
    counted = [0]

    def on_message(number, sequence, values):
        counted[0] += values[0] & 1

    encoder = p.Encoder(clamp=True)
    decoder = p.Decoder(on_message)
    marker = values_of(p.MARKER, lambda low, high: high)
    pose = values_of(p.POSE, lambda low, high: low)
    status = array("i", values_of(p.STATUS, lambda low, high: high))
    broken = bytearray([p.VERSION, p.MARKER, 0, 0]) + bytearray([255] * 34)
    garbage = frame_of(bytes(broken[:-8]))
    garbage = garbage + bytes([7] * 300) + b"\0\0" + frame_of(b"\x01\x3f\x00\x00") + b"\x05\x01\0"

    def work():
        marker[X] = 2000000
        for number, values in pairs:
            size = encoder.encode(number, values)
            decoder.feed(encoder.buffer, size)
        decoder.feed(garbage, len(garbage))

    pairs = ((p.MARKER, marker), (p.POSE, pose), (p.STATUS, status))
    work()
    heap_lock()
    try:
        for _ in range(3):
            work()
    finally:
        heap_unlock()
    assert decoder.counters.messages == 12
    assert counted[0] == 8
