"""Pictures of a drive: the path over the map, and a strip of frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from larics.wire import messages as m
from larics_host.plots import new_figure
from larics_vehicle.approach import STATE_NAMES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from larics_host.drive.simulation import Trace


_COLOURS = {m.TRACKING: "#1b7837", m.COASTING: "#e08214", m.CARRIED: "#2166ac", m.LOST: "#b2182b"}
_WORDS = {m.TRACKING: "tracking", m.COASTING: "coasting", m.CARRIED: "carried by odometry", m.LOST: "lost"}


def path_figure(trace: Trace, title: str) -> Figure:
    """The driven path over the map, coloured by the state of the reported pose; a matplotlib Figure."""
    plot = new_figure(7.6, 6.6)
    axes = plot.add_subplot()
    frames = trace.frames
    x = np.array([frame.x_mm for frame in frames]) / 1000
    y = np.array([frame.y_mm for frame in frames]) / 1000
    states = np.array([frame.state for frame in frames])
    axes.plot(x, y, color="0.8", linewidth=0.8, zorder=1)
    for state, colour in _COLOURS.items():
        chosen = states == state
        if chosen.any():
            axes.scatter(x[chosen], y[chosen], s=5, color=colour, label=_WORDS[state], zorder=2)
    reported = np.array([frame.pose[:2] for frame in frames if frame.state == m.TRACKING])
    if len(reported):
        axes.plot(
            *(reported.T / 1000), ".", color="black", label="reported while tracking", markersize=1, zorder=3
        )
    for time_s in trace.pushes:
        frame = min(frames, key=lambda f: abs(f.time_s - time_s))
        axes.plot(frame.x_mm / 1000, frame.y_mm / 1000, "x", color="black", markersize=7, zorder=4)
    for marker_id, (mx, my, heading) in trace.field.markers.items():
        gone = marker_id == trace.field.condition.missing
        _draw_marker(axes, marker_id, mx / 1000, my / 1000, math.radians(heading), gone)
    axes.margins(0.12)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.set_title(title)
    plot.legend(loc="outside lower center", ncols=5, fontsize=8, markerscale=3)
    return plot


def _draw_marker(axes, marker_id, x, y, heading, gone):
    from matplotlib.patches import Circle

    style = "--" if gone else "-"
    for radius in (0.15, 0.1):
        axes.add_patch(Circle((x, y), radius, fill=False, linestyle=style, linewidth=1.2, zorder=5))
    cos, sin = math.cos(heading), math.sin(heading)
    axes.plot([x + 0.15 * cos, x + 0.23 * cos], [y + 0.15 * sin, y + 0.23 * sin], color="black", zorder=5)
    axes.annotate(
        "%d%s" % (marker_id, " (gone)" if gone else ""),
        (x - 0.22 * cos, y - 0.22 * sin),
        ha="center",
        va="center",
        fontsize=12,
        fontweight="bold",
        zorder=6,
    )


def keep_changes(most: int = 8) -> Callable[..., str | None]:
    """For Simulation(keep=...): keeps the first frame some time after each change of behaviour."""
    seen: list[float] = []

    def keep(simulation, index):
        state = simulation.controller.state
        # the middle of a phase shows it best: half a second in, or the frame after at a low rate
        changes = simulation.trace.behaviours
        if not changes or len(seen) >= most:
            return None
        at, _ = changes[-1]
        now = simulation.trace.frames[-1].time_s
        if now - at < 0.5 or (seen and seen[-1] == at):
            return None
        seen.append(at)
        return STATE_NAMES[state]

    return keep


def strip(
    trace: Trace, pictures: Sequence[Any] | None = None, columns: int = 4, scale: float = 0.75
) -> np.ndarray:
    """The kept frames (or these) side by side with what was seen in them, as the paper's figure 9.

    Returns (H, W, 3) uint8, BGR."""
    from larics_host.detection.camera_view import CameraView

    camera = trace.field.camera
    view = CameraView(trace.field.settings, camera.width, camera.height)
    tiles = []
    for time_s, picture, caption in trace.pictures if pictures is None else pictures:
        tile = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR)
        for found in view.detect(picture):
            _draw_detection(tile, found)
        tile = cv2.resize(tile, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        label = "%.1f s  %s" % (time_s, caption)
        tile = cv2.copyMakeBorder(tile, 22, 6, 3, 3, cv2.BORDER_CONSTANT, value=(255, 255, 255))
        cv2.putText(tile, label, (4, 16), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (0, 0, 0), 1, cv2.LINE_AA)
        tiles.append(tile)
    while tiles and len(tiles) % columns:
        tiles.append(np.full_like(tiles[0], 255))
    rows = [np.hstack(tiles[k : k + columns]) for k in range(0, len(tiles), columns)]
    return np.vstack(rows) if rows else np.full((40, 40, 3), 255, np.uint8)


def _draw_detection(tile, found):
    x, y, radius = found["x"], found["y"], found["radius"]
    angle = math.radians(found["heading"])
    colour = (0, 140, 255) if found["id"] is None else (60, 180, 0)
    middle = (round(x * 16), round(y * 16))
    cv2.circle(tile, middle, round(radius * 16), colour, 1, cv2.LINE_AA, 4)
    end = (round((x + 2 * radius * math.cos(angle)) * 16), round((y - 2 * radius * math.sin(angle)) * 16))
    cv2.line(tile, middle, end, colour, 1, cv2.LINE_AA, 4)
    text = "?" if found["id"] is None else str(found["id"])
    place = (round(x + 1.2 * radius), round(y + 1.2 * radius))
    cv2.putText(tile, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.8, colour, 2, cv2.LINE_AA)
