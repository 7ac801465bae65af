"""The map as a picture: plates true to scale, orientation lines, the route, and what was seen together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from larics.marker import LARICS3
from larics_host.plots import COLOURS, new_figure, png

if TYPE_CHECKING:
    from larics_host.mapping.mapfile import Map


_USUAL_MM = LARICS3.outer_mm10 / 10
_ROOM_PT = 14.0  # radius of a plate that has room for its ID
_ELLIPSE_MM = 900.0  # half the length of the largest one


def draw_map(
    hall: Map,
    links: Iterable[Any] = (),
    title: str = "",
    ellipses: Sequence[tuple[Any, np.ndarray]] = (),
    moves: Iterable[Any] = (),
    remarks: Iterable[tuple[Any, str]] = (),
) -> bytes:
    """PNG of a mapfile.Map; links: [((x, y), (x, y))] to draw as thin lines; ellipses: [(place, covariance
    (2, 2) in mm^2)] to draw with two standard deviations, so much larger than life as the title then says;
    moves: [((x, y) before, (x, y) now)]; remarks: [((x, y), text)] to write below what is there."""
    from matplotlib.patches import Circle

    remarks = list(remarks)
    xs = [marker.x_mm for marker in hall.markers] + [place[0] for place, _ in remarks]
    ys = [marker.y_mm for marker in hall.markers] + [place[1] for place, _ in remarks]
    beside = _ELLIPSE_MM + 100 if ellipses else 600
    width, height = max(xs) - min(xs) + 2 * beside, max(ys) - min(ys) + 2 * beside
    scale = 9 / max(width, height)
    figure = new_figure(max(4.0, width * scale) + 0.8, max(3.0, height * scale) + 0.6)
    axes = figure.subplots()
    for (x1, y1), (x2, y2) in links:
        axes.plot([x1, x2], [y1, y2], color="#9fb0c0", linewidth=0.7, zorder=1)
    _draw_route(axes, hall)
    if ellipses:
        title += "\nellipses: 2 standard deviations, %d times as large" % _draw_ellipses(axes, ellipses)
    for marker in hall.markers:
        ring = marker.radius_mm or _USUAL_MM
        x, y, turn = marker.x_mm, marker.y_mm, math.radians(marker.heading_deg)
        share = ring / _USUAL_MM
        plate = share * LARICS3.plate_mm10 / 10
        axes.add_patch(Circle((x, y), plate, facecolor="white", edgecolor="#9fb0c0", linewidth=0.8, zorder=2))
        for radius in (ring, share * LARICS3.inner_mm10 / 10):
            axes.add_patch(Circle((x, y), radius, fill=False, edgecolor="black", linewidth=1.3, zorder=3))
        end = share * LARICS3.orientation_end_mm10 / 10
        cos, sin = math.cos(turn), math.sin(turn)
        axes.plot([x + ring * cos, x + end * cos], [y + ring * sin, y + end * sin], color="black", zorder=3)
        small = 72 * plate * scale < _ROOM_PT
        axes.annotate(
            str(marker.id), (x, y), xytext=(0, 72 * plate * scale + 5 if small else 0),
            textcoords="offset points", ha="center", va="center", fontsize=7 if small else 9,
            weight="bold", zorder=4,
        )  # fmt: skip
    for before, now in moves:
        axes.plot(*before, "x", color=COLOURS[1], zorder=5)
        _arrow(axes, before, now)
    for place, text in remarks:
        axes.annotate(
            text, place, xytext=(0, -72 * _USUAL_MM * 2 * scale - 5), textcoords="offset points", ha="center",
            va="top", fontsize=7, color=COLOURS[1], zorder=6,
            bbox={"facecolor": "white", "alpha": 0.7, "edgecolor": "none", "pad": 1},
        )  # fmt: skip
    axes.set_xlim(min(xs) - beside, max(xs) + beside)
    axes.set_ylim(min(ys) - beside, max(ys) + beside)
    axes.set_aspect("equal")
    axes.grid(True, linewidth=0.3)
    axes.set_xlabel("x, mm")
    axes.set_ylabel("y, mm")
    axes.set_title(title, fontsize=10)
    return png(figure, dpi=110)


def _draw_ellipses(axes, ellipses):
    """Draws them; returns how much larger than life."""
    from matplotlib.colors import to_rgb
    from matplotlib.patches import Ellipse

    largest = 2 * max(math.sqrt(float(np.linalg.eigvalsh(covariance)[-1])) for _, covariance in ellipses)
    times = max(1, int(_ELLIPSE_MM / max(largest, 1.0)))
    for place, covariance in ellipses:
        values, vectors = np.linalg.eigh(covariance)
        width, height = 4 * times * np.sqrt(np.maximum(values, 0.0))
        angle = math.degrees(math.atan2(vectors[1, 0], vectors[0, 0]))
        axes.add_patch(
            Ellipse(
                place,
                width,
                height,
                angle=angle,
                facecolor=(*to_rgb(COLOURS[0]), 0.25),
                edgecolor=COLOURS[0],
                zorder=1.5,
            )
        )
    return times


def _draw_route(axes, hall):
    if not hall.route:
        return
    from larics.locate.marker_map import MarkerMap
    from larics.locate.route import resolve_entries

    entries = resolve_entries(hall.route, MarkerMap(hall.rows()))
    for a, b in zip(entries[:-1], entries[1:], strict=True):
        begin, end = hall.markers[a], hall.markers[b]
        _arrow(axes, (begin.x_mm, begin.y_mm), (end.x_mm, end.y_mm), 12)


def _arrow(axes, begin, end, free_pt=0):
    """From a place to another one, so far from both."""
    style = {"arrowstyle": "->", "color": COLOURS[1], "shrinkA": free_pt, "shrinkB": free_pt}
    axes.annotate("", end, begin, arrowprops=style, zorder=5)
