"""Recorded logs as the bytes that were on the wire, with the time at which each message was received.

`larics log` leaves PREFIX.jsonl with every message, PREFIX.csv with those about markers, and on request
PREFIX.bin with every byte as it came and PREFIX.mcap with every message.
"""

from __future__ import annotations

import contextlib
import csv
import json
import time
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from larics.wire.codec import Encoder
from larics_host.connection.receiver import Receiver, wire_bytes
from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


_PIECE = 65536


class Piece(NamedTuple):
    """Bytes up to the end of a message, and when it was received: seconds since the log began, or None."""

    time_s: float | None
    data: bytes


def read_records(path: StrPath) -> Iterator[dict[str, Any]]:
    """Yields the objects of a .jsonl log. UserError where it is none; a last line cut short is left out."""
    try:
        with open(path, encoding="utf-8") as file:
            for number, line in enumerate(file, 1):
                try:
                    record = json.loads(line)
                    _ = record["message"] + "", record["sequence"] + 0, record["time_s"] + 0.0
                except (ValueError, KeyError, TypeError):
                    if not line.endswith("\n"):
                        return  # the log was ended by force in the middle of this line
                    raise UserError("%s line %d is not from larics log" % (path, number)) from None
                yield record
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error
    except UnicodeDecodeError:
        raise UserError("%s is not from larics log" % path) from None


def read_pieces(path: StrPath) -> Generator[Piece]:
    """Yields the Pieces of a log: .jsonl, .csv, .mcap, or raw bytes, whose times come from the .jsonl beside.

    Raises UserError when it cannot be read or holds nothing.
    """
    path = Path(path)
    read = {".jsonl": read_records, ".csv": _records_of_csv, ".mcap": _records_of_mcap}.get(path.suffix)
    pieces = _pieces_of_records(path, read(path)) if read else _pieces_of_bytes(path)
    empty = True
    for piece in pieces:
        empty = False
        yield piece
    if empty:
        raise UserError("%s is empty" % path)


def _records_of_csv(path):
    """The objects that the rows of a .csv stand for."""
    try:
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                try:
                    numbers = {name: int(text) for name, text in row.items() if name != "time_s"}
                    yield {**numbers, "time_s": float(row["time_s"]), "message": "MARKER"}
                except (ValueError, KeyError, TypeError):
                    raise UserError("%s is not from larics log" % path) from None
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error
    except (UnicodeDecodeError, csv.Error):
        raise UserError("%s is not from larics log" % path) from None


def _records_of_mcap(path):
    """The objects in an .mcap; of one that was ended by force, those that are complete."""
    try:
        from mcap.exceptions import EndOfFile, McapError
        from mcap.reader import NonSeekingReader
    except ImportError:
        raise UserError("an .mcap needs the Python package mcap: pip install mcap") from None
    try:
        with open(path, "rb") as file, contextlib.suppress(EndOfFile):
            for schema, _, message in NonSeekingReader(file).iter_messages(log_time_order=False):
                fields = json.loads(message.data)
                yield {**fields, "message": schema.name.split(".")[-1], "sequence": message.sequence}
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error
    except (McapError, ValueError, AttributeError, TypeError):
        raise UserError("%s is not from larics log" % path) from None


def _pieces_of_records(path, records):
    encoder = Encoder()
    for number, record in enumerate(records, 1):
        try:
            data = wire_bytes(encoder, record["message"], record["sequence"], record)
        except (KeyError, ValueError, TypeError) as error:
            raise UserError("%s, message %d, is none: %s" % (path, number, error)) from None
        yield Piece(record["time_s"], data)


def _pieces_of_bytes(path):
    """Cuts behind each complete message; what is damaged goes with the next one."""
    times = _times(path.with_suffix(".jsonl"))
    receiver = Receiver()
    waiting = bytearray()
    try:
        with open(path, "rb") as file:
            while block := file.read(_PIECE):
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
    if waiting:
        yield Piece(None, bytes(waiting))


def _times(path):
    """A function message -> its time by the log beside, None from the first message on that is not there."""
    records = read_records(path) if path.exists() else iter(())

    def time_of(message):
        nonlocal records
        record = next(records, None)
        if record and (record["message"], record["sequence"]) == (message.name, message.sequence):
            return record["time_s"]
        records = iter(())
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
        if delay_s > 0:
            time.sleep(delay_s)


class RecordedSource:
    """A log as a source of bytes, like link.SerialSource, at the pace of a Pacer. `time_s` is when the bytes
    that were read last had come, as far as the log tells."""

    live = False

    def __init__(self, path: StrPath, speed: float = 0.0) -> None:
        self.name = str(path)
        self.time_s = 0.0
        self._pacer = Pacer(speed)
        self._pieces = read_pieces(path)

    def read(self) -> bytes | None:
        """The next bytes when they are due, or None at the end. UserError when the log cannot be read."""
        piece = next(self._pieces, None)
        if piece is None:
            return None
        self._pacer.wait(piece)
        if piece.time_s is not None:
            self.time_s = piece.time_s
        return piece.data

    def close(self) -> None:
        self._pieces.close()
