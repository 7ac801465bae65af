"""Messages of long logs as columns: what `connection.receiver` would deliver, a hundred times as fast.

Raw bytes are taken apart in arrays: frames of the length that a type has are unstuffed and checked all at
once. What a Decoder refuses (checksum, version, length, ranges) is left out here, too. Of records only the
wanted types are looked into.
"""

from __future__ import annotations

from binascii import crc32
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from larics.wire import codec, messages
from larics.wire.framing import LIMIT
from larics_host import files
from larics_host.connection.receiver import values_of
from larics_host.errors import UserError
from larics_host.logs.log_lines import Damage
from larics_host.logs.log_reader import read_pieces, tell_cut
from larics_host.logs.log_records import kind_of, read_records
from larics_host.packed import opened

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


_BLOCK = 1 << 22  # bytes read at once
_ROWS = 4096  # records made an array at once
_PACKED = {"B": "u1", "b": "i1", "H": "<u2", "h": "<i2", "I": "<u4", "i": "<i4"}
_NUMBERS = {name: number for name, number, _, _ in messages.MESSAGES}


def read_columns(
    path: StrPath, names: Sequence[str], progress: Callable[[int], object] = files.unwatched
) -> dict[str, np.ndarray]:
    """{name: array} of the messages of these types in a log: a column of int64 for each field, and `order`,
    the place in the log by which messages of all types can be put into one line.

    progress is told the bytes that have been read. Raises UserError when the log cannot be read or is none;
    one without the wanted types gives empty arrays.
    """
    path = Path(path)
    if kind_of(path) == ".bin":
        parts = _of_bytes(path, names, progress)
    else:
        parts = _of_records(path, names, progress)
    found: dict[str, list[np.ndarray]] = {name: [] for name in names}
    for name, array in parts:
        found[name].append(array)
    if not path.stat().st_size:
        raise UserError("%s is empty" % path)
    if kind_of(path) == ".bin":
        if not any(len(array) for arrays in found.values() for array in arrays):
            next(read_pieces(path))  # what is no log at all is told as such
        tell_cut(path)
    return {name: np.concatenate([np.zeros(0, _dtype(name)), *arrays]) for name, arrays in found.items()}


def _dtype(name):
    fields = [field[0] for field in codec.fields(_NUMBERS[name])]
    return np.dtype([(field, np.int64) for field in [*fields, "order"]])


def _table(name, rows):
    return np.array(rows, np.int64).reshape(len(rows), -1).view(_dtype(name))[:, 0]


# records


def _of_records(path, names, progress):
    """Yields (name, array) in pieces."""
    damage = Damage(path, "message")
    waiting = {name: [] for name in names}
    for order, record in enumerate(read_records(path, progress)):
        name = record["message"]
        if name not in waiting:
            continue
        try:
            rows = waiting[name]
            rows.append((*_in_range(name, values_of(_NUMBERS[name], record)), order))
        except (KeyError, ValueError, TypeError, OverflowError) as error:
            damage.bad(order + 1, "is no message: %s" % error)
            continue
        damage.good()
        if len(rows) == _ROWS:
            yield name, _table(name, rows)
            rows.clear()
    damage.tell()
    for name, rows in waiting.items():
        if rows:
            yield name, _table(name, rows)


def _in_range(name, values):
    for (field, _, _, low, high, *_), value in zip(codec.fields(_NUMBERS[name]), values, strict=True):
        if not low <= value <= high:
            raise ValueError("%s.%s = %d is outside %d..%d" % (name, field, value, low, high))
    return values


# bytes


def _of_bytes(path, names, progress):
    """Yields (name, array) in pieces."""
    order = done = 0
    for data in _whole_frames(path):
        ends = np.flatnonzero(data == 0)
        starts = np.concatenate([[0], ends[:-1] + 1])
        sizes = ends - starts
        for name in names:
            size = codec.frame_size(_NUMBERS[name]) - 1
            here = np.flatnonzero(sizes == size)
            good, array = _decoded(name, data[starts[here, None] + np.arange(size)])
            array["order"] = order + here[good]
            yield name, array
        order += len(ends)
        done += len(data)
        progress(done)


def _whole_frames(path):
    """Yields the bytes of a file in blocks that end with a 0; what is longer than any frame is not kept."""
    left = b""
    try:
        with opened(path) as file:
            while block := file.read(_BLOCK):
                whole, zero, rest = (left + block).rpartition(b"\0")
                left = rest[: 2 * LIMIT]
                if zero:
                    yield np.frombuffer(whole + zero, np.uint8)
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error


def _decoded(name, frames):
    """(indices, array) of those of the frames, bytes (N, size) without their final 0, that are messages of a
    type; changes the frames."""
    number, size = _NUMBERS[name], frames.shape[1]
    whole = np.zeros(len(frames), bool)
    row, place = np.arange(len(frames)), np.zeros(len(frames), np.intp)
    while len(row):  # from one stuffed zero to the next
        codes = frames[row, place]
        frames[row, place] = 0
        place = place + codes
        whole[row[place == size]] = True
        row, place = row[place < size], place[place < size]
    message = np.ascontiguousarray(frames[:, 1:])
    buffer, length, covered = message.tobytes(), size - 1, size - 5
    sums = [crc32(buffer[begin : begin + covered]) for begin in range(0, len(buffer), length)]
    told = np.ascontiguousarray(message[:, covered:]).view("<u4")[:, 0]
    good = whole & (told == np.array(sums, np.uint32)) & (message[:, 0] == messages.VERSION)
    good &= message[:, 1] == number
    fields = codec.fields(number)
    packed = np.dtype([(field[0], _PACKED[field[1]]) for field in fields])
    payload = np.ascontiguousarray(message[:, 4:covered]).view(packed)[:, 0]
    for field, _, _, low, high, *_ in fields:
        good &= (payload[field] >= low) & (payload[field] <= high)
    found = np.zeros(good.sum(), _dtype(name))
    for field in packed.names:
        found[field] = payload[field][good]
    return np.flatnonzero(good), found
