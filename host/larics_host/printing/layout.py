"""What is on a printed sheet, as primitives in millimetres: the marker, crop marks, ruler and labels.

Coordinates: x right, y up, origin at the bottom left. The orientation line points right. A writer
(pdf.py, svg.py, png.py) only draws the primitives of a `Sheet`, so all formats agree.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from larics import marker as geometry
from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics.marker import Family


PAPERS_MM = {
    "a4": (210.0, 297.0),
    "a3": (297.0, 420.0),
    "letter": (215.9, 279.4),
    "legal": (215.9, 355.6),
    "tabloid": (279.4, 431.8),
}
MARGIN_MM = 10.0  # left, right and top of a page
FOOT_MM = 20.0  # bottom of a page: ruler and labels
CROP_GAP_MM = 2.0
CROP_LENGTH_MM = 5.0
OVERLAP_MM = 10.0  # of neighbouring tiles
RULER_MM = 100.0
RULER_UP_MM = 14.5  # 8.8 mm are lost when A4 is centred on Letter, and 4 to 5 mm where no printer prints
HAIRLINE_MM = 0.15
MAX_TILES = 400
MAX_PAGE_MM = 5080.0  # the largest page a PDF can have


@dataclass(frozen=True)
class Ring:
    x: float
    y: float
    radius: float
    width: float
    grey: float = 0.0  # 0 black .. 1 white
    dash: float = 0.0  # length of dashes, 0 for none


@dataclass(frozen=True)
class Line:
    """A straight line with butt ends."""

    x1: float
    y1: float
    x2: float
    y2: float
    width: float
    grey: float = 0.0


@dataclass(frozen=True)
class Arc:
    """A part of a ring with butt ends, counterclockwise from `first` to `last` degrees."""

    x: float
    y: float
    radius: float
    width: float
    first: float
    last: float
    grey: float = 0.0


@dataclass(frozen=True)
class Text:
    """`size` is the height of the font; `anchor` says which end of the base line (x, y) is."""

    x: float
    y: float
    size: float
    text: str
    anchor: str = "start"  # start, middle, end


@dataclass(frozen=True)
class Sheet:
    """One page. `content` is drawn shifted by (dx, dy) and cut to `window` (x, y, width, height on the
    page); `furniture` is drawn on the page as it is."""

    width: float
    height: float
    window: tuple
    dx: float
    dy: float
    content: list
    furniture: list


def content_side_mm(family: Family) -> float:
    """Side of the square that holds the plate and its crop marks."""
    return family.plate_mm10 / 5 + 2 * (CROP_GAP_MM + CROP_LENGTH_MM)


def marker_content(family: Family, marker_id: int) -> list[Ring | Arc | Line | Text]:
    """The marker in a square of `content_side_mm`: strokes, cut line of the plate, crop marks, small ID."""
    side = content_side_mm(family)
    middle, plate = side / 2, family.plate_mm10 / 10
    items: list[Ring | Arc | Line | Text] = [Ring(middle, middle, plate, HAIRLINE_MM, grey=0.6, dash=2.0)]
    for kind, *values in family.strokes(marker_id):
        if kind == geometry.RING:
            radius, width = (value / 10 for value in values)
            items.append(Ring(middle, middle, radius, width))
        elif kind == geometry.ARC:
            start, end = values[2] / 10, values[3] / 10
            items.append(
                Arc(middle, middle, (start + end) / 2, end - start, values[0] / 100, values[1] / 100)
            )
        else:
            angle = math.radians(values[0] / 100)
            start, end, width = (value / 10 for value in values[1:])
            c, s = math.cos(angle), math.sin(angle)
            ends = (middle + start * c, middle + start * s, middle + end * c, middle + end * s)
            items.append(Line(*ends, width))
    low, high = middle - plate, middle + plate
    for edge in (low, high):
        for first, last in ((0.0, CROP_LENGTH_MM), (side - CROP_LENGTH_MM, side)):
            items.append(Line(edge, first, edge, last, HAIRLINE_MM))
            items.append(Line(first, edge, last, edge, HAIRLINE_MM))
    # the square around the plate leaves 0.29 of its radius free in each corner
    size = min(5.0, 0.1 * plate)
    items.append(Text(low + size / 2, low + size / 2, size, "ID %d" % marker_id))
    # and what a print that was cut out can be checked by
    small = min(3.0, 0.036 * plate)
    check = "print at 100 %%, ring %g mm" % (family.outer_mm10 / 10)
    items.append(Text(high - small / 2, low + small / 2, small, check, "end"))
    return items


def _moved(items, dx, dy):
    for item in items:
        if isinstance(item, Line):
            yield replace(item, x1=item.x1 + dx, y1=item.y1 + dy, x2=item.x2 + dx, y2=item.y2 + dy)
        else:
            yield replace(item, x=item.x + dx, y=item.y + dy)


def many_on_sheets(family: Family, marker_ids: Sequence[int], paper: str) -> list[Sheet]:
    """As many whole markers on each page of a paper size as fit, in rows from the top left."""
    side = content_side_mm(family)
    width, height = PAPERS_MM[paper]
    room_x, room_y = width - 2 * MARGIN_MM, height - MARGIN_MM - FOOT_MM
    columns, rows = int(room_x // side), int(room_y // side)
    if not columns or not rows:
        raise UserError(
            "a marker of this size does not fit a page of %s: choose a smaller --radius-mm, or no --sheet"
            % paper.upper()
        )
    sheets = []
    for first in range(0, len(marker_ids), columns * rows):
        ids = marker_ids[first : first + columns * rows]
        content = []
        for number, marker_id in enumerate(ids):
            row, column = divmod(number, columns)
            place = (column * room_x / columns, room_y - (row + 1) * room_y / rows)
            content += _moved(marker_content(family, marker_id), *place)
        smallest = min(family.smallest_mm10(marker_id) for marker_id in ids) / 10
        size = "outer ring radius %g mm, smallest feature %g mm" % (family.outer_mm10 / 10, smallest)
        title = "LARICS-3, %d markers, %s" % (len(ids), size)
        lines = [title, "print at 100 %: the ruler must measure 100 mm"]
        window = (MARGIN_MM, FOOT_MM, room_x, room_y)
        sheets.append(Sheet(width, height, window, MARGIN_MM, FOOT_MM, content, _furniture(width, lines)))
    return sheets


def _ruler(middle_x, y):
    left = middle_x - RULER_MM / 2
    items = [Line(left, y, left + RULER_MM, y, HAIRLINE_MM)]
    for step in range(0, 101, 5):
        height = 3.0 if step % 50 == 0 else 2.0 if step % 10 == 0 else 1.2
        items.append(Line(left + step, y, left + step, y + height, HAIRLINE_MM))
    items.append(Text(left - 1.5, y, 2.5, "0", "end"))
    items.append(Text(left + RULER_MM + 1.5, y, 2.5, "100 mm"))
    return items


def _furniture(page_width, lines):
    """Ruler and labels in the foot of a page; the ruler above what is lost when A4 is centred on Letter."""
    items = _ruler(page_width / 2, RULER_UP_MM)
    for number, line in enumerate(lines):
        items.append(Text(page_width / 2, RULER_UP_MM - 4.0 - 4.0 * number, 2.6, line, "middle"))
    return items


def describe(family: Family, marker_id: int) -> str:
    """One line about a marker, for its sheets."""
    coded = marker_id > geometry.PLAIN_ID_MOST
    return "LARICS-3 %sID %d, outer ring radius %g mm, line width %g mm, smallest feature %g mm" % (
        "coded " if coded else "",
        marker_id,
        family.outer_mm10 / 10,
        family.line_mm10 / 10,
        family.smallest_mm10(marker_id) / 10,
    )


def plate_sheet(family: Family, marker_id: int) -> Sheet:
    """One page just large enough for the marker and the ruler, in one piece."""
    side = content_side_mm(family)
    width = max(side, RULER_MM + 30.0) + 2 * MARGIN_MM
    height = side + MARGIN_MM + FOOT_MM
    if max(width, height) > MAX_PAGE_MM:
        raise UserError("a marker of this size is larger than a page can be: choose a smaller --radius-mm")
    left = (width - side) / 2
    lines = [describe(family, marker_id), "print at 100 %: the ruler must measure 100 mm"]
    return Sheet(
        width,
        height,
        (left, FOOT_MM, side, side),
        left,
        FOOT_MM,
        marker_content(family, marker_id),
        _furniture(width, lines),
    )


def _count(length, window):
    return max(1, math.ceil((length - OVERLAP_MM) / (window - OVERLAP_MM)))


def _cut_marks(window, column, row, columns, rows):
    """Marks outside the window at the middle of each overlap; neighbours carry them at the same place."""
    x, y, width, height = window
    near, far, half = CROP_GAP_MM / 2, CROP_GAP_MM / 2 + CROP_LENGTH_MM, OVERLAP_MM / 2
    items = []
    across = [x + half] * (column > 0) + [x + width - half] * (column < columns - 1)
    along = [y + height - half] * (row > 0) + [y + half] * (row < rows - 1)
    for at in across:
        items.append(Line(at, y + height + near, at, y + height + far, HAIRLINE_MM))
        items.append(Line(at, y - near, at, y - far, HAIRLINE_MM))
    for at in along:
        items.append(Line(x - near, at, x - far, at, HAIRLINE_MM))
        items.append(Line(x + width + near, at, x + width + far, at, HAIRLINE_MM))
    return items


def paper_sheets(family: Family, marker_id: int, paper: str) -> list[Sheet]:
    """The marker on pages of a paper size: one page, or overlapping tiles, whichever way needs fewer."""
    side = content_side_mm(family)
    best: Any = None
    short, long = PAPERS_MM[paper]
    for page_width, page_height in ((short, long), (long, short)):
        width, height = page_width - 2 * MARGIN_MM, page_height - MARGIN_MM - FOOT_MM
        count = (_count(side, width), _count(side, height))
        if best is None or count[0] * count[1] < best[0][0] * best[0][1]:
            best = (count, page_width, page_height, width, height)
    (columns, rows), page_width, page_height, width, height = best
    if columns * rows > MAX_TILES:
        raise UserError(
            "a marker of this size takes %d %s pages: choose a smaller --radius-mm, or --paper plate"
            % (columns * rows, paper.upper())
        )
    content = marker_content(family, marker_id)
    window = (MARGIN_MM, FOOT_MM, width, height)
    # the grid is larger than the content: centre it
    spare_x = columns * (width - OVERLAP_MM) + OVERLAP_MM - side
    spare_y = rows * (height - OVERLAP_MM) + OVERLAP_MM - side
    sheets = []
    for row in range(rows):
        for column in range(columns):
            lines = [describe(family, marker_id), "print at 100 %: the ruler must measure 100 mm"]
            if columns * rows > 1:
                place = "row %d of %d, column %d of %d" % (row + 1, rows, column + 1, columns)
                lines[1] = "print at 100 %; " + place
                lines[1] += "; cut one sheet at its marks and glue it onto the marks of the next"
            sheets.append(
                Sheet(
                    page_width,
                    page_height,
                    window,
                    MARGIN_MM + spare_x / 2 - column * (width - OVERLAP_MM),
                    FOOT_MM + spare_y / 2 - (rows - 1 - row) * (height - OVERLAP_MM),
                    content,
                    _furniture(page_width, lines) + _cut_marks(window, column, row, columns, rows),
                )
            )
    return sheets
