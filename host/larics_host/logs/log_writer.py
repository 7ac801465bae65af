"""Writes received messages to files, each out of the program as soon as it is complete."""

from __future__ import annotations

import csv
import json
import os
import time
from typing import TYPE_CHECKING, Any

from larics_host.connection.records import Marker, as_json
from larics_host.errors import UserError
from larics_host.logs.mcap_log import McapLog, writer_class

if TYPE_CHECKING:
    from larics_host.connection.receiver import Message


MARKER_COLUMNS = Marker._fields


class LogWriter:
    """PREFIX.csv: one row for each MARKER message; PREFIX.jsonl: one object for each message of any type;
    with raw=True PREFIX.bin: every byte as it came; with mcap=True PREFIX.mcap, see mcap_log. `time_s` counts
    from the start of the log. What is not known, an uncertain ID for one, is null, in the CSV nothing.

    Line-buffered: ending the program by force loses nothing that was received before.
    """

    def __init__(self, prefix: str, raw: bool = False, force: bool = False, mcap: bool = False) -> None:
        names = [prefix + ".csv", prefix + ".jsonl"] + ([prefix + ".bin"] if raw else [])
        names += [prefix + ".mcap"] if mcap else []
        for name in names:
            if os.path.exists(name) and not force:
                raise UserError("%s exists: choose another -o, or --force to overwrite it" % name)
        if mcap:
            writer_class()  # before there are files
        self.files = names
        self._open: list[Any] = []
        try:
            for name in names[:2]:
                self._open.append(open(name, "w", buffering=1, newline="", encoding="utf-8"))  # noqa: SIM115
            self._raw = None
            if raw:
                self._raw = open(names[2], "wb", buffering=0)  # noqa: SIM115
                self._open.append(self._raw)
            self._mcap = None
            if mcap:
                self._mcap = McapLog(names[-1], time.time_ns())
                self._open.append(self._mcap)
        except OSError as error:
            self.close()
            raise UserError("cannot write %s: %s" % (error.filename, error.strerror)) from error
        self._csv = csv.writer(self._open[0], lineterminator="\n")
        self._csv.writerow(["time_s", "sequence", *MARKER_COLUMNS])

    def write_bytes(self, data: bytes) -> None:
        if self._raw is not None:
            self._raw.write(data)

    def write(self, message: Message) -> None:
        """Writes one Message. OSError when the disk is full."""
        record = {"time_s": round(message.time_s, 6), "message": message.name, "sequence": message.sequence}
        fields = as_json(message.fields)
        record.update(fields)
        self._open[1].write(json.dumps(record) + "\n")
        if message.name == "MARKER":
            values = [fields[column] for column in MARKER_COLUMNS]
            self._csv.writerow(["%.6f" % message.time_s, message.sequence, *values])
        if self._mcap is not None:
            self._mcap.write(message)

    def close(self) -> None:
        for file in self._open:
            file.close()
        self._open = []
