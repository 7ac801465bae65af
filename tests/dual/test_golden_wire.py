"""Golden bytes of every type: what is on the line must never change without a new type or version."""

from binascii import hexlify, unhexlify

from larics.wire import codec as p

GOLDEN = {
    "INFO": (
        "310101ff018a6415dda02bb641bfcc3757808182838485868788898a8b8c8d8e8f909192939495969798999a9b22270d5700"
    ),
    "MARKER": ("080102ff028950f80414c9fc021f1e2abaf2400239f1ff8db1f5ff182afaff4c29f7827e0df7986fa1c6938700"),
    "POSE": (
        "1d0103ff03883c720113b576019e2d01b41e409788c1cb0f8dc13b85e0116b79b92e816a0ce3975b2f81bdf8ee4400"
    ),
    "STATUS": (
        "330104ff0487129d2892b30afe013e830202c9fb060254740b02dfec0f026a651402f5dd180280561d020bcf2102"
        "9621c02a023737b13302c2294da2d81a63934502ee0b4a0279844e0204fd52028f7557021aee5b02a566600230df"
        "6402bb57690246d06d0202a7ce6b00"
    ),
    "ACK": ("0c0105ff0586141152e2ca3700"),
    "NACK": ("060106ff068508109b26f9eaea5600"),
    "SETTING": (
        "300107ff0784ec0f9add2556b1ce6bc33c4770c3c7bf74c3523879c3ddb07dc3682982c3f3a186c37e1a8bc3e84115e300"
    ),
    "RAW_HEADER": ("190108ff0883d80e51d80376cd064695be3a33c5abf8480d4d00"),
    "RAW_CHUNK": (
        "4d0109ff0982c40d3d202122232425262728292a2b2c2d2e2f303132333435363738393a3b3c3d3e3f4041424344"
        "45464748494a4b4c4d4e4f505152535455565758595a5b5c5d5e5f377694ed00"
    ),
    "MOTION": ("09010aff0a81b0c7041c97231ad5e4ae92d9e4b831c383e2044efce604d974eb04dce3b72500"),
    "GET_INFO": ("0b0140ff404b78becea1c100"),
    "PING": ("0b0141ff414a6437e019f000"),
    "GET_SETTING": ("0c0142ff424950d441d5bcc600"),
    "SET_SETTING": (
        "100143ff43483cd35e2de9a5751effdf0d9703e08b0f08e016880ce0a11311e02c7915e0b7f119e0426a1ee0097eacda00"
    ),
    "SAVE_SETTINGS": ("0b0144ff4447285adef6f400"),
    "GET_RAW": ("0b0145ff4546141bd020fe00"),
    "GET_RAW_AGAIN": ("060146ff46450bd0785bf14f8bbb17228d00"),
    "RESTART": ("0b0147ff4744eccf64fb33029400"),
    "ODOMETRY": ("1d0148ff4843d84e22ce5053225ac95702e5415c024f21fa01dab36be600"),
}


def golden_values(number):
    """Values that differ from field to field and use their ranges."""
    values = []
    fields = p.fields(number)
    for k in range(len(fields)):
        _, code, _, low, high, _ = fields[k]
        if code[-1] == "s":
            values.append(bytes([(16 * k + j) & 255 for j in range(int(code[:-1]))]))
        else:
            spread = (k + 1) * 37 + number * 1009
            values.append(low + spread * 7919 % (high - low + 1))
    return values


def golden_sequence(number):
    return 256 * number + 255


def test_every_type_has_golden_bytes():
    assert sorted(GOLDEN) == sorted(message[0] for message in p.MESSAGES)


def test_the_encoder_writes_them():
    for name, number, _, _ in p.MESSAGES:
        encoder = p.Encoder()
        encoder.sequence = golden_sequence(number)
        size = encoder.encode(number, golden_values(number))
        assert hexlify(bytes(encoder.buffer[:size])).decode() == GOLDEN[name], name


def test_the_decoder_reads_them():
    found = []

    def keep(number, sequence, values):
        values = [bytes(value) if isinstance(value, bytearray) else value for value in values]
        found.append((number, sequence, values))

    decoder = p.Decoder(keep)
    for name, _, _, _ in p.MESSAGES:
        data = unhexlify(GOLDEN[name])
        decoder.feed(data, len(data))
    numbers = [message[1] for message in p.MESSAGES]
    assert found == [(number, golden_sequence(number), golden_values(number)) for number in numbers]
