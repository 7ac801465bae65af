"""The bird's-eye view as text: vehicle, markers and trail in Braille dots, two by four a letter."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from larics.marker import LARICS3

if TYPE_CHECKING:
    from larics_host.monitor.state import MonitorState


_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
_RING_MM = LARICS3.outer_mm10 / 10
_LINE_MM = LARICS3.orientation_end_mm10 / 10
_SPANS_MM = (500, 1000, 2000, 3000, 5000, 8000, 12000, 20000, 40000, 80000, 160000, 320000)


class Canvas:
    """`columns` x `rows` letters over a square-pixelled window of the plane; x right, y up, in mm."""

    def __init__(self, columns: int, rows: int, center: tuple[float, float], mm_per_dot: float) -> None:
        self._columns, self._rows = columns, rows
        self._center = center
        self._scale = mm_per_dot
        self._cells = [[0] * columns for _ in range(rows)]
        self._letters: dict[tuple[int, int], str] = {}

    def _dot(self, x_mm, y_mm):
        column = self._columns + (x_mm - self._center[0]) / self._scale
        row = 2 * self._rows - (y_mm - self._center[1]) / self._scale
        return math.floor(column), math.floor(row)

    def point(self, x_mm: float, y_mm: float) -> None:
        column, row = self._dot(x_mm, y_mm)
        if 0 <= column < 2 * self._columns and 0 <= row < 4 * self._rows:
            self._cells[row // 4][column // 2] |= _BITS[row % 4][column % 2]

    def line(self, x1: float, y1: float, x2: float, y2: float) -> None:
        steps = max(1, min(500, round(math.hypot(x2 - x1, y2 - y1) / self._scale)))
        for k in range(steps + 1):
            self.point(x1 + (x2 - x1) * k / steps, y1 + (y2 - y1) * k / steps)

    def circle(self, x_mm: float, y_mm: float, radius_mm: float) -> None:
        steps = max(8, min(200, round(7 * radius_mm / self._scale)))
        for k in range(steps):
            angle = 2 * math.pi * k / steps
            self.point(x_mm + radius_mm * math.cos(angle), y_mm + radius_mm * math.sin(angle))

    def text(self, x_mm: float, y_mm: float, text: str) -> None:
        column, row = self._dot(x_mm, y_mm)
        for k, letter in enumerate(text):
            if 0 <= row // 4 < self._rows and 0 <= column // 2 + k < self._columns:
                self._letters[row // 4, column // 2 + k] = letter

    def lines(self) -> list[str]:
        """The drawing, one string a row."""
        return [
            "".join(
                self._letters.get((r, c)) or (chr(0x2800 + cell) if cell else " ")
                for c, cell in enumerate(row)
            )
            for r, row in enumerate(self._cells)
        ]


def _marker(canvas, marker_id, x_mm, y_mm, heading_deg):
    turn = math.radians(heading_deg)
    canvas.circle(x_mm, y_mm, _RING_MM)
    ends = [(x_mm + r * math.cos(turn), y_mm + r * math.sin(turn)) for r in (_RING_MM, 1.3 * _LINE_MM)]
    canvas.line(*ends[0], *ends[1])
    canvas.text(x_mm, y_mm, "?" if marker_id is None else str(marker_id))


def _vehicle(canvas, x_mm, y_mm, heading_deg, size_mm):
    turn = math.radians(heading_deg)
    corners = []
    for forward, left in ((1.0, 0.0), (-0.7, 0.6), (-0.4, 0.0), (-0.7, -0.6), (1.0, 0.0)):
        u, v = forward * size_mm, left * size_mm
        corners.append(
            (x_mm + u * math.cos(turn) - v * math.sin(turn), y_mm + u * math.sin(turn) + v * math.cos(turn))
        )
    for a, b in zip(corners, corners[1:], strict=False):
        canvas.line(*a, *b)


def _mm_per_dot(columns, rows, reach_x_mm, reach_y_mm):
    """A round scale at which the window shows this far to each side of its centre."""
    for span_mm in _SPANS_MM:
        scale = span_mm / (2 * rows)
        if reach_x_mm <= columns * scale and reach_y_mm <= 2 * rows * scale:
            return scale
    return scale


def draw_view(state: MonitorState, columns: int, rows: int) -> tuple[str, list[str]]:
    """(caption, lines): the map with the trail when there are poses, else what is above the vehicle."""
    if state.trail:
        return _draw_map(state, columns, rows)
    known = [marker for marker in state.markers if marker["x_mm"] is not None]
    # the vehicle's forward is up and its left is left: plane x = -left, plane y = forward
    reach_x = max([abs(marker["y_mm"]) + 300 for marker in known], default=0)
    reach_y = max([abs(marker["x_mm"]) + 300 for marker in known], default=0)
    scale = _mm_per_dot(columns, rows, reach_x, reach_y)
    canvas = Canvas(columns, rows, (0.0, 0.0), scale)
    _vehicle(canvas, 0.0, 0.0, 90.0, max(120.0, 4 * scale))
    for marker in known:
        _marker(canvas, marker["id"], -marker["y_mm"], marker["x_mm"], marker["heading_deg"] + 90)
    return "from above, forward is up; %.1f m high" % (4 * rows * scale / 1000), canvas.lines()


def _draw_map(state, columns, rows):
    places = [place for known in state.landmarks.values() for place in known]
    xs = [point[1] for point in state.trail] + [place[0] for place in places]
    ys = [point[2] for point in state.trail] + [place[1] for place in places]
    center = ((min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2)
    scale = _mm_per_dot(columns, rows, (max(xs) - min(xs)) / 2 + 350, (max(ys) - min(ys)) / 2 + 350)
    canvas = Canvas(columns, rows, center, scale)
    for point in state.trail:
        canvas.point(point[1], point[2])
    for marker_id, known in state.landmarks.items():
        for x_mm, y_mm, heading_deg, _ in known:
            _marker(canvas, marker_id, x_mm, y_mm, heading_deg)
    pose = state.pose
    if pose["x_mm"] is None:  # LOST: where it was last
        canvas.text(state.trail[-1][1], state.trail[-1][2], "?")
    else:
        _vehicle(canvas, pose["x_mm"], pose["y_mm"], pose["heading_deg"], max(120.0, 4 * scale))
    return "map; %.1f m high" % (4 * rows * scale / 1000), canvas.lines()
