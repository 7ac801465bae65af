"""Writes received messages to files, each out of the program as soon as it is complete."""

from __future__ import annotations

import csv
import io
import json
import sys
import time
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any

from larics_host.connection.records import Marker, as_json
from larics_host.files import CannotWrite, GrowingFile, refuse_existing
from larics_host.ros.bag import require_mcap

if TYPE_CHECKING:
    import numpy as np

    from larics_host.connection.receiver import Message
    from larics_host.logs.mcap_log import McapLog
    from larics_host.ros.options import Options


MARKER_COLUMNS = Marker._fields


class LogWriter:
    """PREFIX.csv: one row for each MARKER message; PREFIX.jsonl: one object for each message of any type;
    with raw=True PREFIX.bin: every byte as it came; with mcap=True PREFIX.mcap, with bag=True the folder
    PREFIX, see mcap_log (`ros`: its options). `time_s` counts from the start of the log; in the JSON lines
    `time` is the same as date and time of day (UTC, ISO 8601). What is not known, an uncertain ID for one, is
    null, in the CSV nothing.

    start_ns: wall clock at time_s 0, None when that is not known, as of bytes recorded earlier.

    Each message is out of the program at once: ending it by force loses nothing that was received before.
    Only bags lose their last chunk, and their index; `larics log --convert PREFIX.jsonl` makes them again.
    What holds nothing in the end is removed; `files` are those that stay.
    """

    def __init__(
        self,
        prefix: str,
        raw: bool = False,
        force: bool = False,
        mcap: bool = False,
        start_ns: int | None = None,
        bag: bool = False,
        ros: Options | None = None,
    ) -> None:
        names = [prefix + ".csv", prefix + ".jsonl"] + ([prefix + ".bin"] if raw else [])
        bags = ([prefix + ".mcap"] if mcap else []) + ([prefix] if bag else [])
        names += bags
        for name in names:
            refuse_existing(name, force)
        if bags:
            require_mcap()  # before there are files
        self.files = names
        self.messages = 0
        self._start_ns = start_ns
        self._raw: GrowingFile | None = None
        self._bags: list[McapLog] = []
        self._open: list[Any] = []
        try:
            self._csv = self._opened(GrowingFile(names[0]))
            self._jsonl = self._opened(GrowingFile(names[1]))
            if raw:
                self._raw = self._opened(GrowingFile(names[2]))
            for name in bags:
                from larics_host.logs.mcap_log import McapLog

                now_ns = time.time_ns() if start_ns is None else start_ns
                self._bags.append(self._opened(McapLog(name, now_ns, ros, folder=name == prefix)))
            self._csv.append(_csv_line(["time_s", "sequence", *MARKER_COLUMNS]))
        except CannotWrite:
            for file in self._open:
                file.discard()
            raise

    def _opened(self, file):
        self._open.append(file)
        return file

    def write_bytes(self, data: bytes) -> None:
        """Keeps bytes as they came, with raw=True. CannotWrite when there is no room."""
        if self._raw is not None:
            self._raw.append(data)

    def write(self, message: Message) -> None:
        """Writes one Message. CannotWrite when there is no room; what was written before stays whole."""
        self._jsonl.append(json_line(message, self._start_ns))
        if message.name == "MARKER":
            fields = as_json(message.fields)
            values = [fields[column] for column in MARKER_COLUMNS]
            self._csv.append(_csv_line(["%.6f" % message.time_s, message.sequence, *values]))
        for bag in self._bags:
            bag.write(message)
        self.messages += 1

    def picture(self, number: int, frame: np.ndarray) -> None:
        """Adds a raw frame ((height, width) uint8) of which a message was written, to bags."""
        for bag in self._bags:
            bag.picture(number, frame)

    def close(self) -> None:
        """Ends the files. CannotWrite when an .mcap has no room for its end; what is in it can be read."""
        files, self._open = self._open, []
        if not files:
            return
        empty = [file for file in files if not self.messages and file is not self._raw]
        if self._raw is not None and not self._raw.size:
            empty.append(self._raw)
        gone = [name for name, file in zip(self.files, files, strict=True) if file in empty]
        self.files = [name for name in self.files if name not in gone]
        for file in empty:
            file.discard()
        for file in files:
            file.close()


def json_line(message: Message, start_ns: int | None) -> bytes:
    """A Message as a JSON line; start_ns as of LogWriter."""
    record: dict[str, Any] = {"time_s": round(message.time_s, 6), "time": None}
    if start_ns is not None:
        moment = datetime.fromtimestamp(0, UTC) + timedelta(
            microseconds=start_ns // 1000 + round(message.time_s * 1e6)
        )
        record["time"] = moment.isoformat(timespec="microseconds").replace("+00:00", "Z")
    record.update(message=message.name, sequence=message.sequence)
    record.update(as_json(message.fields))
    return json.dumps(record).encode() + b"\n"


class StdoutLog:
    """Like a LogWriter: JSON lines on standard output, each as soon as it is complete."""

    def __init__(self, start_ns: int | None = None) -> None:
        self._start_ns = start_ns
        self.files = ["standard output"]

    def write_bytes(self, data: bytes) -> None:
        """Raw bytes are not kept."""

    def write(self, message: Message) -> None:
        """Writes one Message. BrokenPipeError when nobody reads any more."""
        sys.stdout.write(json_line(message, self._start_ns).decode())
        sys.stdout.flush()

    def close(self) -> None:
        """Nothing to end."""


def _csv_line(cells):
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue().encode()
