"""Recorded logs as objects: what .jsonl holds, and what rows of a .csv and messages of an .mcap stand for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from larics_host import files
from larics_host.errors import UserError
from larics_host.logs.log_lines import NOT_OURS, Damage, is_cut, possible_sequence, possible_time, sound
from larics_host.logs.log_writer import MARKER_COLUMNS
from larics_host.logs.mcap_reader import stamped_objects
from larics_host.packed import opened
from larics_host.tables import layout_of, whole

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


_LATER = ("sigma_q12", "sigma_mdeg")  # what a MARKER got after the first logs were written
_UNKNOWN_LATER = dict.fromkeys(_LATER)


def read_objects(
    path: StrPath, progress: Callable[[int], object] = files.unwatched
) -> Iterator[dict[str, Any]]:
    """Yields the objects of a .jsonl log; damaged lines are left out and told. UserError where it is none."""
    damage = Damage(path)
    for number, line in enumerate(files.lines(path, progress), 1):
        if not line.strip():
            continue
        try:
            record = files.parse_json(sound(line))
            _ = (
                record["message"] + "",
                possible_sequence(record["sequence"]),
                possible_time(record["time_s"] + 0.0),
            )
        except (ValueError, KeyError, TypeError, OverflowError):
            damage.bad(number, NOT_OURS, is_cut(line))
            continue
        damage.good()
        yield record
    damage.tell()


def read_records(path: Path, progress: Callable[[int], object] = files.unwatched) -> Iterator[dict[str, Any]]:
    """Yields the objects that the messages of a .jsonl, .csv or .mcap are shown as; progress: see
    files.lines."""
    read = {".jsonl": read_objects, ".csv": _records_of_csv, ".mcap": _records_of_mcap}[kind_of(path)]
    for record in read(path, progress):
        yield {**_UNKNOWN_LATER, **record} if record["message"] == "MARKER" else record


def plain(path: Path) -> Path:
    """A path without the ending of a packed file."""
    return path.with_suffix("") if path.suffix.lower() == ".gz" else path


def kind_of(path: Path) -> str:
    """The extension that fits a log: its own, or by its beginning where that is none of ours."""
    own = plain(path).suffix.lower()
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


def _records_of_csv(path, progress):
    """The objects that the rows of a .csv stand for; an empty cell is None, what is not known."""
    damage = Damage(path)
    numbered = enumerate(files.lines(path, progress), 1)
    columns = ("time_s", "sequence", *MARKER_COLUMNS)
    required = [column for column in columns if column not in _LATER]
    layout = layout_of(numbered, columns, required, path, "from larics log")
    for number, line in numbered:
        try:
            row = layout.row(sound(line))
            if row is None:
                continue
            if is_cut(line):
                raise ValueError  # its last number may be
            record = {name: whole(row[name]) if row.get(name) else None for name in columns[1:]}
            record["time_s"] = possible_time(float(row["time_s"]))
            possible_sequence(record["sequence"])
        except (ValueError, KeyError):
            damage.bad(number, "is cut off" if is_cut(line) else NOT_OURS)
            continue
        damage.good()
        yield {**record, "message": "MARKER"}
    damage.tell()


def _records_of_mcap(path, progress):
    return (record for record, _ in stamped_objects(path, progress))
