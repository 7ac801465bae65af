"""The monitor in the terminal."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

from rich.columns import Columns
from rich.console import Console, Group
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from larics_host.logs.live_table import fault_text, reception, shown
from larics_host.monitor.drawing import draw_view
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics_host.monitor.state import MonitorState


_COLOURS = {
    "TRACKING": "bold white on green",
    "COASTING": "bold black on yellow",
    "CARRIED": "bold black on yellow",
    "LOST": "bold white on red",
}
_VIEW = (46, 15)  # letters wide and high, at most
_LEAST_VIEW = (24, 5)
_FRAME = 4  # letters that a box takes beside what is in it
_VALUES_WIDE = 40


def _number(value, layout="%.1f"):
    return "-" if value is None else layout % value


def _grid(rows):
    table = Table.grid(padding=(0, 2))
    table.add_column(style="dim")
    table.add_column()
    for name, value in rows:
        table.add_row(name, value)
    return table


def _marker_rows(state):
    marker = state.markers[0] if state.markers else None
    if marker is None:
        never = "unknown" if state.frames else "nothing received yet"
        yield "marker", "none in sight" if state.frame is not None else never
        return
    more = " and %d more" % (len(state.markers) - 1) if len(state.markers) > 1 else ""
    yield "marker", ("ID ?" if marker["id"] is None else "ID %d" % marker["id"]) + more
    yield "offset", "x %s  y %s mm" % (_number(marker["x_mm"]), _number(marker["y_mm"]))
    yield "height", "%s mm" % _number(marker["z_mm"])
    yield "heading", "%.2f deg" % marker["heading_deg"]
    yield "margin", "%d of 255" % marker["margin"]
    yield "age", "%.1f ms" % marker["age_ms"]
    if marker["flags"]:
        yield "notes", marker["flags"]


def _pose_rows(state):
    pose = state.pose
    yield "position", "x %s  y %s mm" % (_number(pose["x_mm"]), _number(pose["y_mm"]))
    yield "direction", "%s deg" % _number(pose["heading_deg"], "%.2f")
    sigmas = _number(pose["sigma_x_mm"]), _number(pose["sigma_y_mm"]), _number(pose["sigma_deg"], "%.2f")
    yield "sigma", "x %s  y %s mm, %s deg" % sigmas
    if pose["route"] is not None:
        yield "route", "position %d, next %s deg" % (pose["route"], _number(pose["next_deg"]))


def _health_rows(state):
    rate = state.rate_hz()
    yield "frames", "%d, %s a second here" % (state.frames, _number(rate))
    status = state.status
    if status:
        yield (
            "camera",
            "%s frames/s, detection %s ms, latency %s ms"
            % (
                shown(status, "rate_chz", 100),
                shown(status, "detect_us", 1000),
                shown(status, "latency_us", 1000),
            ),
        )
        yield (
            "exposure",
            "%.2f ms, gain %.1f dB, mean grey %s"
            % (
                status.exposure_us / 1000,
                status.gain_cdb / 100,
                shown(status, "grey_mean", form="%d"),
            ),
        )
        yield (
            "counters",
            "up %d s, missed %d, rejects %d, dropped %d, line errors %d"
            % (
                status.uptime_s,
                status.missed,
                status.rejects,
                status.drops,
                status.crc_errors + status.line_errors,
            ),
        )
        text = fault_text(status.active_faults, status.last_fault)
        yield "faults", Text("%d (%s)" % (status.faults, text), style="red" if state.faults() else "")
    if state.counters:
        received, lost, damaged = reception(state.counters)
        yield "received", "%s, %d lost, %d damaged" % (counted(received, "message"), lost, damaged)


def _rows(part, width):
    """How many lines a part takes that is so wide."""
    console = Console(width=width, file=io.StringIO())
    return len(console.render_lines(part, pad=False))


def _boxes(state, values, width, rows):
    """The view and the values beside it, or above it where that is too narrow, in so many lines; the values
    alone where no view fits."""
    if width >= _VALUES_WIDE + _FRAME + _LEAST_VIEW[0]:
        view_wide = min(_VIEW[0], width - _VALUES_WIDE - _FRAME - 1)
        view_high = max(_rows(values, _VALUES_WIDE - _FRAME), min(_VIEW[1], rows - 2))
        caption, lines = draw_view(state, view_wide, view_high)
        view = Panel(Text("\n".join(lines)), title=caption, title_align="left", width=view_wide + _FRAME)
        yield Columns([view, Panel(values, width=_VALUES_WIDE, height=view_high + 2)])
        return
    values_wide = min(_VALUES_WIDE, width)
    view_wide = min(_VIEW[0], width - _FRAME)
    view_high = min(_VIEW[1], rows - 2 - _rows(values, values_wide - _FRAME) - 2)
    if view_wide >= _LEAST_VIEW[0] and view_high >= _LEAST_VIEW[1]:
        caption, lines = draw_view(state, view_wide, view_high)
        yield Panel(Text("\n".join(lines)), title=caption, title_align="left", width=view_wide + _FRAME)
    yield Panel(values, width=values_wide)


def render(state: MonitorState, ended: str | None = None, size: tuple[int, int] = (110, 100)) -> Group:
    """What rich shows of a MonitorState. size: letters wide and lines high; on a small terminal the view
    shrinks, and the last events are fewer."""
    width, height = size
    label = Text(
        " %s " % (state.state or ("SILENT" if state.is_silent else "WAITING")),
        style=_COLOURS.get(state.state or "", "bold white on blue"),
    )
    title = Text.assemble(label, "  larics monitor  ", (state.source, "dim"))
    info = state.info
    if info:
        title.append("  %s, %dx%d px" % (info.board, info.width, info.height), style="dim")
    values = [_grid(_marker_rows(state))]
    if state.pose:
        values += [Text(), _grid(_pose_rows(state))]
    health = _grid(_health_rows(state))
    end = Text("ended: %s" % ended, style="bold") if ended else Text("Ctrl-C ends", style="dim")
    left = height - sum(_rows(part, width) for part in (title, health, end))
    boxes = list(_boxes(state, Group(*values), width, left - 1))
    left -= sum(_rows(box, width) for box in boxes)
    events = ["%9.2f s  %s" % event for event in list(state.events)[-max(1, min(4, left)) :]]
    return Group(title, *boxes, health, Text("\n".join(events), style="dim"), end)
