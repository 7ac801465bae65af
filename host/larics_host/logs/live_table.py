"""What a person sees while messages come in: the newest markers, the vehicle's pose and the health."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

from rich.console import Group
from rich.table import Table

from larics.wire import messages as m
from larics_host import wire_names as codes
from larics_host.connection.records import known

if TYPE_CHECKING:
    from larics_host.connection.receiver import Message


_ROWS = 12
STATES = {m.LOST: "LOST", m.COASTING: "COASTING", m.TRACKING: "TRACKING", m.CARRIED: "CARRIED"}


def flag_text(flags: int) -> str:
    """The names of the flags of a MARKER message that are set."""
    return ", ".join(
        codes.name_of("MARKER flag", 1 << bit) for bit in range(flags.bit_length()) if flags >> bit & 1
    )


def fault_text(active: int, last: int) -> str:
    """Faults of a STATUS message: those that last, then the newest that is over."""
    names = [codes.name_of("Fault", bit) for bit in range(1, active.bit_length()) if active >> bit & 1]
    if last and not active >> last & 1:
        names.append("last: " + codes.name_of("Fault", last))
    return ", ".join(names) or "none"


def shown(record: Any, field: str, scale: int = 1, form: str = "%.1f") -> str:
    """A field of a record divided by `scale`, "?" when it is not known."""
    value = known(record, field)
    return "?" if value is None else form % (value / scale)


def marker_row(message: Message) -> list[str]:
    """A MARKER message as texts: frame, time, ID, x, y, z, heading, margin, age, notes."""
    fields = message.fields
    if fields.flags & m.MARKER_NONE:
        measures = ["-"] * 6
    else:
        measures = [shown(fields, "id", form="%d")]
        measures += [shown(fields, offset, 10) for offset in ("x_mm10", "y_mm10", "z_mm10")]
        measures += ["%.2f" % (fields.heading_cdeg / 100), str(fields.margin)]
    return [
        str(fields.frame),
        "%.3f" % message.time_s,
        *measures,
        "%.1f" % (fields.age_us / 1000),
        flag_text(fields.flags),
    ]


HEADINGS = ("frame", "time s", "ID", "x mm", "y mm", "z mm", "heading deg", "margin", "age ms", "notes")
_WANTED = ("ID", "x mm", "y mm", "heading deg", "margin", "notes", "age ms", "time s", "frame", "z mm")
_NOTES_WIDE = 11  # letters at least; longer ones take more lines
_BESIDE_CELL = 3  # two spaces and a line


class LiveTable:
    """Collects messages; `render()` gives what rich shows."""

    def __init__(self, source: str) -> None:
        self._source = source
        self._rows: deque[list[str]] = deque(maxlen=_ROWS)
        self._status: Any = None  # records of the newest messages
        self._pose: Any = None
        self._info: Any = None
        self._counters = None

    def add(self, message: Message) -> None:
        if message.name == "MARKER":
            self._rows.append(marker_row(message))
        elif message.name == "STATUS":
            self._status = message.fields
            if message.fields.state == m.LOST:  # also of a camera that no longer sends poses
                self._pose = None
        elif message.name == "POSE":
            self._pose = message.fields
        elif message.name == "INFO":
            self._info = message.fields

    def render(self, counters: Any, width: int = 110) -> Group:
        """width: letters of the terminal; columns that are not whole in it are left out."""
        table = Table(title="larics log %s" % self._source, title_justify="left")
        columns = self._columns(width)
        for column in columns:
            notes = HEADINGS[column] == "notes"
            table.add_column(
                HEADINGS[column], justify="left" if notes else "right", no_wrap=not notes, overflow="fold"
            )
        for row in self._rows:
            table.add_row(*(row[column] for column in columns))
        return Group(table, *self._lines(counters))

    def _columns(self, width):
        """Places of the columns that fit, asked for in the order in which they are wanted."""
        chosen = []
        width -= 1
        for heading in _WANTED:
            column = HEADINGS.index(heading)
            cells = (HEADINGS, *self._rows)
            letters = _NOTES_WIDE if heading == "notes" else max(len(row[column]) for row in cells)
            if letters + _BESIDE_CELL <= width:
                width -= letters + _BESIDE_CELL
                chosen.append(column)
        return sorted(chosen)

    def _lines(self, counters):
        lines = []
        info = self._info
        if info:
            lines.append("board %s, frames of %dx%d px" % (info.board, info.width, info.height))
        if self._pose:
            pose = self._pose
            lines.append(
                "pose %s: x %s mm, y %s mm, heading %s deg, marker %s ms ago"
                % (
                    STATES[pose.state],
                    shown(pose, "x_mm10", 10),
                    shown(pose, "y_mm10", 10),
                    shown(pose, "heading_cdeg", 100, "%.2f"),
                    shown(pose, "marker_age_ms", form="%d"),
                )
            )
        if self._status:
            status = self._status
            lines.append(
                "%s, %s frames/s, detection %s ms, latency %s ms, exposure %.1f ms, gain %.1f dB"
                % (
                    STATES[status.state],
                    shown(status, "rate_chz", 100),
                    shown(status, "detect_us", 1000),
                    shown(status, "latency_us", 1000),
                    status.exposure_us / 1000,
                    status.gain_cdb / 100,
                )
            )
            lines.append(
                "up %d s, missed %d, dropped %d, faults %d (%s)"
                % (
                    status.uptime_s,
                    status.missed,
                    status.drops,
                    status.faults,
                    fault_text(status.active_faults, status.last_fault),
                )
            )
        lines.append("received %d, lost %d, damaged %d" % reception(counters))
        return lines


def reception(counters: Any) -> tuple[int, int, int]:
    """(messages received, missing by their numbers, damaged) of a decoder's counters."""
    damaged = counters.crc + counters.cobs + counters.length + counters.over_long + counters.out_of_range
    return counters.messages, counters.gaps, damaged
