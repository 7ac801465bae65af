"""Messages as columns are those that a Decoder delivers, whatever the bytes went through."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from larics.wire import framing
from larics.wire import messages as m
from larics.wire.codec import Encoder
from larics_host.connection.receiver import Receiver
from larics_host.connection.records import Marker, Motion
from larics_host.errors import UserError
from larics_host.logs import columns
from larics_host.logs.columns import read_columns
from larics_host.logs.log_reader import read_pieces
from tools.simulated_drives import Drive, World, drive, messages_of, write_log

NAMES = ("MARKER", "MOTION")


def wire(count=40, seed=3):
    """Bytes of messages of several types, with zeros and extremes in them."""
    rng = np.random.default_rng(seed)
    encoder = Encoder()
    data = bytearray()
    for number in range(count):
        marker = [number, 0, 0, int(rng.integers(0, 65535)), 0, 1, -256 * number, 1000000, -1000000]
        marker += [35999, 255, 65535, 0, 65535]
        motion = [number, number % 3, 255, -65536, 65536, 0, m.COUNT_MAX, 0, 256]
        for kind, values in ((m.MARKER, marker), (m.MOTION, motion), (m.PING, [7]), (m.ACK, [7, 65])):
            data += encoder.buffer[: encoder.encode(kind, values)]
    return bytes(data)


def delivered(data):
    """{name: [fields]} of what the Receiver makes of it."""
    found = {name: [] for name in NAMES}
    for message in Receiver().feed(data, 0.0):
        if message.name in found:
            found[message.name].append(tuple(message.fields))
    return found


def columns_of(path):
    found = read_columns(path, NAMES)
    kinds = {"MARKER": Marker, "MOTION": Motion}
    return {name: [tuple(int(row[f]) for f in kinds[name]._fields) for row in found[name]] for name in NAMES}


damages = st.lists(
    st.tuples(st.sampled_from(["set", "cut", "insert"]), st.integers(0, 10**6), st.binary(max_size=3)),
    max_size=12,
)


@settings(max_examples=150)
@given(damages, st.sampled_from([64, 131, 5000, 1 << 22]))
def test_damaged_bytes_give_what_a_decoder_delivers(tmp_path_factory, damage, block):
    data = bytearray(wire())
    for kind, place, some in damage:
        place %= len(data)
        data[place : place + {"set": len(some), "cut": 7, "insert": 0}[kind]] = b"" if kind == "cut" else some
    path = tmp_path_factory.getbasetemp() / "damaged.bin"
    path.write_bytes(data)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(columns, "_BLOCK", block)
        assert columns_of(path) == delivered(bytes(data))


@pytest.mark.parametrize("place, byte", [(7, 0x7F), (17, 0x7F), (8, 3)])
def test_every_field_is_held_to_its_range(place, byte, tmp_path):
    """Frames that are whole, of the right type, with a value that no sender of ours can have: a frame number
    and a y beyond their range, a state that there is not."""
    encoder = Encoder()
    good = bytes(encoder.buffer[: encoder.encode(m.MOTION, [1, 2, 3, 4, 5, 6, 7, 8, 9])])
    message = undone(good)
    message[place] = byte
    bad = bytearray(framing.LIMIT + 2)
    bad[1 : 1 + len(message)] = message
    data = bytes(bad[: framing.seal(bad, 1 + len(message))]) + good
    (tmp_path / "bad.bin").write_bytes(data)
    assert len(data) == 2 * len(good)
    assert columns_of(tmp_path / "bad.bin") == delivered(data) == delivered(good)


def undone(frame):
    """The message in a frame, without its CRC."""
    data = bytearray(frame[:-1])
    place = 0
    while place < len(data):
        step = data[place]
        data[place] = 0
        place += step
    return data[1:-4]


def test_json_lines_and_bytes_give_the_same(tmp_path, capsys):
    world = World(markers=4, length_m=6.0, wrong=0.0, moved=False)
    one = drive(world, 5)
    raw, lines = write_log(tmp_path / "a.bin", one), write_log(tmp_path / "a.jsonl", one)
    assert columns_of(raw) == columns_of(lines) == delivered(raw.read_bytes())
    assert len(columns_of(raw)["MOTION"]) == len(one.frames) > 100
    text = lines.read_text().splitlines(keepends=True)
    text[3] = text[3].replace('"frame": 2', '"frame": "two"')
    text[5] = text[5][:40] + "\n"
    lines.write_text("".join(text))
    found = columns_of(lines)
    assert sum(map(len, found.values())) == len(text) - 2
    err = capsys.readouterr().err
    assert "message 4 is no message" in err and "line 6 is not from larics log" in err


def test_the_order_of_messages_of_all_types_is_kept(tmp_path):
    one = Drive([], frames=[(k, (0.0, 0.0, 0.0), 0.0, 0.0, []) for k in range(3)])
    sent = [number for number, _ in messages_of(one)]
    for name in ("a.bin", "a.jsonl"):
        found = read_columns(write_log(tmp_path / name, one), NAMES)
        order = sorted((int(row["order"]), name) for name in NAMES for row in found[name])
        assert [m.MARKER if name == "MARKER" else m.MOTION for _, name in order] == sent


@pytest.mark.parametrize("read", [columns_of, lambda path: list(read_pieces(path))])
def test_bytes_that_end_within_a_message_are_told(read, tmp_path, capsys):
    path = tmp_path / "a.bin"
    path.write_bytes(wire())
    read(path)
    assert not capsys.readouterr().err
    path.write_bytes(wire()[:-4])
    read(path)
    said = "larics: %s is cut off: it ends within a message; the rest is read\n"
    assert capsys.readouterr().err == said % path


@pytest.mark.parametrize("data", [b"hello\n", bytes(range(256)) * 9])
def test_bytes_that_are_no_log_are_told_as_such(data, tmp_path, capsys):
    (tmp_path / "a.bin").write_bytes(data)
    with pytest.raises(UserError, match="holds no message, %d bytes: " % len(data)):
        read_columns(tmp_path / "a.bin", NAMES)
    assert not capsys.readouterr().err
    encoder = Encoder()
    (tmp_path / "a.bin").write_bytes(encoder.buffer[: encoder.encode(m.PING, [7])])
    assert not any(map(len, read_columns(tmp_path / "a.bin", NAMES).values()))


def test_progress_goes_up_to_the_size(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(wire())
    told = []
    read_columns(path, NAMES, told.append)
    assert told == sorted(told) and told[-1] == path.stat().st_size


@pytest.mark.parametrize("name", ["empty.bin", "empty.jsonl", "none.bin"])
def test_what_is_no_log_is_told(name, tmp_path):
    if name != "none.bin":
        (tmp_path / name).write_bytes(b"")
    with pytest.raises(UserError, match="is empty|cannot read"):
        read_columns(tmp_path / name, NAMES)
