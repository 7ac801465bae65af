"""Frozen bytes of every type: what is on the line never changes without a new type or version."""

from binascii import hexlify, unhexlify

from frozen_frames import FRAMES
from larics.wire import codec as p


def test_every_type_has_frozen_bytes():
    assert sorted({number for number, _, _, _ in FRAMES}) == sorted([message[1] for message in p.MESSAGES])


def test_the_encoder_writes_them():
    for number, sequence, values, text in FRAMES:
        encoder = p.Encoder()
        encoder.sequence = sequence
        size = encoder.encode(number, values)
        assert hexlify(bytes(encoder.buffer[:size])).decode() == text, (p.name(number), values)


def test_the_decoder_reads_them():
    found = []

    def keep(number, sequence, values):
        values = [bytes(value) if isinstance(value, bytearray) else value for value in values]
        found.append((number, sequence, tuple(values)))

    decoder = p.Decoder(keep)
    for _, _, _, text in FRAMES:
        data = unhexlify(text)
        decoder.feed(data, len(data))
    assert found == [frame[:3] for frame in FRAMES]
