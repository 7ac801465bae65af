"""Recorded logs as the bytes that were on the wire, with the time at which each message was received.

`larics log` leaves PREFIX.jsonl with every message, PREFIX.csv with those about markers, and on request
PREFIX.bin with every byte as it came and PREFIX.mcap with every message.
"""

from __future__ import annotations

import os
from collections.abc import Generator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from larics.wire.codec import Encoder
from larics_host.connection.line_watch import LineWatch
from larics_host.connection.receiver import Receiver, wire_bytes
from larics_host.errors import UserError, report
from larics_host.logs.log_lines import Damage, possible_time
from larics_host.logs.log_records import kind_of, plain, read_objects, read_records
from larics_host.logs.mcap_reader import stamped_objects
from larics_host.packed import opened

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


_PIECE = 65536  # bytes read at once


class Piece(NamedTuple):
    """Bytes up to the end of a message, and when it was received: seconds since the log began, or None."""

    time_s: float | None
    data: bytes


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
            record, log_ns = next(stamped_objects(path), (None, 0))
            return None if record is None else log_ns - round(record["time_s"] * 1e9)
        beside = path if kind == ".jsonl" else plain(path).with_suffix(".jsonl")
        if beside != path and not beside.exists():
            return None
        record = next((one for one in read_objects(beside) if one.get("time")), None)
        if record is None:
            return None
        passed = datetime.fromisoformat(record["time"]) - datetime.fromtimestamp(0, UTC)
    except (ValueError, TypeError, OverflowError):
        return None
    return 1000 * (passed // timedelta(microseconds=1) - round(record["time_s"] * 1e6))


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
    times = _times(plain(path).with_suffix(".jsonl"))
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
