"""Recorded logs as the bytes that were on the wire, with the time at which each message was received.

`larics log` leaves PREFIX.jsonl with every message, PREFIX.csv with those about markers, and on request
PREFIX.bin with every byte as it came and PREFIX.mcap with every message.
"""

from __future__ import annotations

import os
import struct
import time
from collections.abc import Callable, Generator, Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from larics.wire.codec import Encoder
from larics_host import files
from larics_host.connection.line_watch import LineWatch
from larics_host.connection.receiver import Receiver, wire_bytes
from larics_host.errors import UserError, missing_package, report, report_once
from larics_host.logs.log_writer import MARKER_COLUMNS
from larics_host.packed import opened, place
from larics_host.ros.cdr import decode
from larics_host.ros.definitions import parse_definition
from larics_host.ros.wire_types import from_ros, name_of, type_of
from larics_host.tables import layout_of, whole
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


_PIECE = 65536
_SEQUENCE_MOST = 0xFFFF
_LONGEST_S = 1e9  # thirty years; no log is longer
_LONGEST_SLEEP_S = 1e6  # the operating system takes no more than some hundred years


class Piece(NamedTuple):
    """Bytes up to the end of a message, and when it was received: seconds since the log began, or None."""

    time_s: float | None
    data: bytes


class Damage:
    """Collects the lines of a log that are none, and tells of them once; good ones around them still count.

    A file with none that is good is no log, or lost all it held: then the first one is an error."""

    _GIVE_UP = 100  # lines, of what begins with so many that are none

    def __init__(self, path: StrPath, unit: str = "line") -> None:
        self._path = path
        self._unit = unit
        self._good = 0
        self._bad = 0
        self._first: str | None = None

    def good(self) -> None:
        self._good += 1

    def bad(self, number: int, why: str, cut: bool = False) -> None:
        self._bad += 1
        if self._first is None:
            self._first = "%s %d %s" % (self._unit, number, "is cut off" if cut and self._good else why)
        if not self._good and self._bad >= self._GIVE_UP:
            self.tell()

    def tell(self) -> None:
        if not self._bad:
            return
        if not self._good:
            raise UserError("%s %s" % (self._path, self._first))
        rest = ", and %s more" % counted(self._bad - 1, self._unit) if self._bad > 1 else ""
        text = "%s is damaged: %s%s; the rest is read" % (self._path, self._first, rest)
        report_once(text, text)  # a log is read twice, or for ever


_NONE = "is not from larics log"


def _cut(line):
    """Whether a line was the last when the program or the power ended."""
    return not line.endswith("\n")


def _sound(line):
    """Refuses what a loss of power leaves where a line was: zeros, or bytes of other files."""
    if "\0" in line or "\ufffd" in line:
        raise ValueError
    return line


def possible_time(time_s: float) -> float:
    """A `time_s` as it is; ValueError for one that none can be, NaN among them."""
    if not abs(time_s) <= _LONGEST_S:
        raise ValueError("time_s = %g" % time_s)
    return time_s


def possible_sequence(sequence: Any) -> int:
    """The sequence number of a message as it is; ValueError for what is none."""
    if type(sequence) is not int or not 0 <= sequence <= _SEQUENCE_MOST:
        raise ValueError("sequence = %r" % (sequence,))
    return sequence


def read_objects(
    path: StrPath, progress: Callable[[int], object] = files.unwatched
) -> Iterator[dict[str, Any]]:
    """Yields the objects of a .jsonl log; damaged lines are left out and told. UserError where it is none."""
    damage = Damage(path)
    for number, line in enumerate(files.lines(path, progress), 1):
        if not line.strip():
            continue
        try:
            record = files.parse_json(_sound(line))
            _ = (
                record["message"] + "",
                possible_sequence(record["sequence"]),
                possible_time(record["time_s"] + 0.0),
            )
        except (ValueError, KeyError, TypeError, OverflowError):
            damage.bad(number, _NONE, _cut(line))
            continue
        damage.good()
        yield record
    damage.tell()


def read_pieces(path: StrPath) -> Generator[Piece]:
    """Yields the Pieces of a log: .jsonl, .csv, .mcap, or raw bytes, whose times come from the .jsonl beside;
    packed by gzip or not.

    Raises UserError when it cannot be read or holds nothing.
    """
    path = Path(path)
    raw = kind_of(path) == ".bin"
    pieces = _pieces_of_bytes(path) if raw else _pieces_of_records(path, read_records(path))
    empty = True
    for piece in pieces:
        empty = False
        yield piece
    if empty:
        raise UserError("%s %s" % (path, "holds no message" if path.stat().st_size else "is empty"))


def start_of(path: StrPath) -> int | None:
    """The wall clock, ns since 1970, at time_s 0 of a log; None when it does not tell. UserError when it
    cannot be read."""
    path = Path(path)
    kind = kind_of(path)
    try:
        if kind == ".mcap":
            return next(_mcap_starts(path), None)
        beside = path if kind == ".jsonl" else _plain(path).with_suffix(".jsonl")
        if beside != path and not beside.exists():
            return None
        record = next((one for one in read_objects(beside) if one.get("time")), None)
        if record is None:
            return None
        passed = datetime.fromisoformat(record["time"]) - datetime.fromtimestamp(0, UTC)
    except (ValueError, TypeError, OverflowError):
        return None
    return 1000 * (passed // timedelta(microseconds=1) - round(record["time_s"] * 1e6))


def read_records(path: Path, progress: Callable[[int], object] = files.unwatched) -> Iterator[dict[str, Any]]:
    """Yields the objects that the messages of a .jsonl, .csv or .mcap are shown as; progress: see
    files.lines."""
    read = {".jsonl": read_objects, ".csv": _records_of_csv, ".mcap": _records_of_mcap}[kind_of(path)]
    for record in read(path, progress):
        yield {**_UNKNOWN_LATER, **record} if record["message"] == "MARKER" else record


def _plain(path):
    """A path without the ending of a packed file."""
    return path.with_suffix("") if path.suffix.lower() == ".gz" else path


def kind_of(path: Path) -> str:
    """The extension that fits a log: its own, or by its beginning where that is none of ours."""
    own = _plain(path).suffix.lower()
    if own in (".jsonl", ".csv", ".mcap", ".bin"):
        return own
    try:
        with opened(path) as file:
            head = file.peek(256)[:256]
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error
    if head.startswith(b"\x89MCAP"):
        return ".mcap"
    start = head.decode(files.encoding_of(head), errors="replace").lstrip()
    return ".jsonl" if start.startswith("{") else ".csv" if "time_s" in start else ".bin"


_LATER = ("sigma_q12", "sigma_mdeg")  # what a MARKER got after the first logs were written
_UNKNOWN_LATER = dict.fromkeys(_LATER)


def _records_of_csv(path, progress):
    """The objects that the rows of a .csv stand for; an empty cell is None, what is not known."""
    damage = Damage(path)
    numbered = enumerate(files.lines(path, progress), 1)
    columns = ("time_s", "sequence", *MARKER_COLUMNS)
    required = [column for column in columns if column not in _LATER]
    layout = layout_of(numbered, columns, required, path, "from larics log")
    for number, line in numbered:
        try:
            row = layout.row(_sound(line))
            if row is None:
                continue
            if _cut(line):
                raise ValueError  # its last number may be
            record = {name: whole(row[name]) if row.get(name) else None for name in columns[1:]}
            record["time_s"] = possible_time(float(row["time_s"]))
            possible_sequence(record["sequence"])
        except (ValueError, KeyError):
            damage.bad(number, "is cut off" if _cut(line) else _NONE)
            continue
        damage.good()
        yield {**record, "message": "MARKER"}
    damage.tell()


def _mcap_starts(path):
    """The wall clock at time_s 0 by each message in an .mcap."""
    for record, log_ns in _stamped_records_of_mcap(path, files.unwatched):
        yield log_ns - round(record["time_s"] * 1e9)


def _records_of_mcap(path, progress):
    """The objects in an .mcap; of one that is damaged, those before the damage."""
    for record, _ in _stamped_records_of_mcap(path, progress):
        yield record


def _stamped_records_of_mcap(path, progress):
    """(object, wall clock of its reception in ns) of the messages in an .mcap."""
    try:
        from mcap.exceptions import EndOfFile, McapError
        from mcap.reader import NonSeekingReader
        from zstandard import ZstdError
    except ImportError:
        raise missing_package("an .mcap", "mcap") from None
    damage = (McapError, ZstdError, ValueError, LookupError, AttributeError, TypeError, struct.error)
    count = 0
    try:
        with opened(path) as file:
            records, reader = _McapRecords(), NonSeekingReader(file, validate_crcs=True)
            for schema, channel, message in reader.iter_messages(log_time_order=False):
                record = records.of(schema, channel, message)
                if record is not None:
                    yield record, message.log_time
                    count += 1
                    progress(place(file))
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error
    except EndOfFile:
        if count:
            report("%s was cut off: it has no end; %s read" % (path, counted(count, "message")))
    except (*damage, MemoryError):
        if not count:
            raise UserError("%s %s" % (path, _NONE)) from None
        report("%s is damaged: read up to message %d, where it ceases to be a log" % (path, count))


class _McapRecords:
    """Objects of the messages in an .mcap: of `larics_msgs` in CDR, or JSON as earlier versions wrote it.
    Other topics tell the same in other words."""

    def __init__(self):
        self._types = {}  # ID of a schema: (name of the message, type, what it is made of); None for others

    def of(self, schema, channel, message):
        """The object of a message, None for other topics."""
        if channel.message_encoding == "json":
            fields = files.parse_json(message.data.decode())
            return {**fields, "message": schema.name.split(".")[-1], "sequence": message.sequence}
        if schema.id not in self._types:
            self._types[schema.id] = self._type(schema)
        known = self._types[schema.id]
        if known is None:
            return None
        name, kind, structs = known
        return from_ros(name, decode(kind, message.data, structs))

    @staticmethod
    def _type(schema):
        name = name_of(schema.name)
        if name is None:
            return None
        kind = type_of(name)
        return name, kind, parse_definition(kind, schema.data.decode())


def _pieces_of_records(path, records):
    damage = Damage(path, "message")
    encoder = Encoder()
    for number, record in enumerate(records, 1):
        try:
            data = wire_bytes(encoder, record["message"], record["sequence"], record)
            time_s = possible_time(float(record["time_s"]))
        except (KeyError, ValueError, TypeError, OverflowError) as error:
            damage.bad(number, "is no message: %s" % error)
            continue
        damage.good()
        yield Piece(time_s, data)
    damage.tell()


def _pieces_of_bytes(path):
    """Cuts behind each complete message; what is damaged goes with the next one."""
    times = _times(_plain(path).with_suffix(".jsonl"))
    receiver, watch = Receiver(), LineWatch()
    waiting = bytearray()
    try:
        with opened(path) as file:
            while block := file.read(_PIECE):
                watch.feed(block)
                start = 0
                while start < len(block):
                    end = block.find(b"\0", start) + 1 or len(block)
                    part = block[start:end]
                    start = end
                    waiting += part
                    for message in receiver.feed(part, 0.0):
                        yield Piece(times(message), bytes(waiting))
                        waiting.clear()
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error
    if receiver.counters.messages:
        tell_cut(path)
    if waiting and not receiver.counters.messages:
        raise UserError("%s holds no message, %s" % (path, watch.explain(receiver.counters)))
    if waiting:
        yield Piece(None, bytes(waiting))


def tell_cut(path: StrPath) -> None:
    """Reports where raw bytes end within a message, as they do when the program or the power ended."""
    with opened(path) as file:
        last = b""
        if file.seekable():
            file.seek(-1, os.SEEK_END)
        while block := file.read(_PIECE):
            last = block[-1:]
        if last not in (b"", b"\0"):
            report("%s is cut off: it ends within a message; the rest is read" % path)


def _times(path):
    """A function message -> its time by the log beside, None for those that are not there."""
    records = read_objects(path) if path.exists() else iter(())
    waiting = None

    def time_of(message):
        nonlocal records, waiting
        try:
            waiting = waiting or next(records, None)
        except UserError as error:  # the bytes are what was asked for
            report("%s: the times of the bytes beside are not known" % error)
            records = iter(())
        if waiting and (waiting["message"], waiting["sequence"]) == (message.name, message.sequence):
            time_s, waiting = waiting["time_s"], None
            return time_s
        return None

    return time_of


class Pacer:
    """Waits until a Piece is due: at the speed of the recording times `speed`, not at all when that is 0.
    Bytes whose time is unknown take as long as on a line of `baud`."""

    def __init__(self, speed: float = 1.0, baud: int = 115200) -> None:
        self._speed = speed
        self._byte_s = 10 / baud
        self._origin_s: float | None = None
        self._recorded_s = 0.0

    def wait(self, piece: Piece) -> None:
        if not self._speed:
            return
        if self._origin_s is None:
            self._origin_s = time.monotonic() - (piece.time_s or 0.0) / self._speed
        if piece.time_s is None:
            self._recorded_s += self._byte_s * len(piece.data)
        else:
            self._recorded_s = piece.time_s
        delay_s = self._origin_s + self._recorded_s / self._speed - time.monotonic()
        while delay_s > 0:
            time.sleep(min(delay_s, _LONGEST_SLEEP_S))
            delay_s -= _LONGEST_SLEEP_S


class LogSource:
    """A log as a source of bytes, like byte_sources.SerialSource, at the pace of a Pacer.

    `time_s` is when the bytes that were read last had come, as far as the log tells."""

    live = False

    def __init__(self, path: StrPath, speed: float = 0.0) -> None:
        self.name = str(path)
        self.time_s = 0.0
        self._untimed_bytes = 0  # since then
        self._pacer = Pacer(speed)
        self._pieces = read_pieces(path)

    def read(self) -> bytes | None:
        """The next bytes when they are due, or None at the end. UserError when the log cannot be read."""
        piece = next(self._pieces, None)
        if piece is None:
            return None
        self._pacer.wait(piece)
        self._untimed_bytes += len(piece.data)
        if piece.time_s is not None:
            self.time_s = piece.time_s
            self._untimed_bytes = 0
        return piece.data

    def likely_s(self, baud: int) -> float:
        """`time_s`, and for bytes whose time the log does not tell how long they take on a line of `baud`."""
        return self.time_s + self._untimed_bytes * 10 / baud

    def close(self) -> None:
        self._pieces.close()
