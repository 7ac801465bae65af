"""What is really to be seen in a frame: the record that renderer, validation and demo share, as CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from larics.wire.messages import ID_NONE
from larics_host.addresses import is_address, list_remote
from larics_host.errors import UserError, report
from larics_host.files import GrowingFile
from larics_host.tables import read_rows, whole

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


@dataclass
class Truth:
    """One marker in one frame; a frame without a marker has one record whose `id` is None.

    frame               name of the frame's file
    time_us             mid-exposure of the row on which the marker's centre lies (no marker: the middle row)
    id                  0..7 plain, 9..4094 coded, or None
    x_px, y_px          projected marker centre
    heading_deg         image angle from the projected centre to the projected middle of the orientation line,
                        counterclockwise as seen, 0..360 (a lens bends what lies between them);
                        of a tag: of its bitmap's middle row, from the left side to the right
    radius_px           outer ring in the image: geometric mean of the ellipse's half axes
    vehicle_*           vehicle in the map at time_us
    marker_*            marker in the map, its heading that of the orientation line
    offset_x_mm, offset_y_mm   marker minus vehicle, in the vehicle frame
    visible             share of the outer ring inside the frame, 0..1

    x, y, heading and radius are those of the picture as captured, the shear of a rolling shutter included.
    """

    frame: str = ""
    time_us: int = 0
    id: int | None = None
    x_px: float | None = None
    y_px: float | None = None
    heading_deg: float | None = None
    radius_px: float | None = None
    vehicle_x_mm: float | None = None
    vehicle_y_mm: float | None = None
    vehicle_heading_deg: float | None = None
    marker_x_mm: float | None = None
    marker_y_mm: float | None = None
    marker_heading_deg: float | None = None
    offset_x_mm: float | None = None
    offset_y_mm: float | None = None
    visible: float | None = None


COLUMNS = tuple(field.name for field in fields(Truth))
_DIGITS = {"x_px": 5, "y_px": 5, "heading_deg": 5, "radius_px": 5, "visible": 4}


def _text(name, value):
    if value is None:
        return ""
    if isinstance(value, float):
        return "%.*f" % (_DIGITS.get(name, 3), value)
    return str(value)


class TruthWriter:
    """Writes records to a CSV as they come, so that an interrupted run keeps what it has."""

    def __init__(self, path: StrPath) -> None:
        self._file = GrowingFile(path)
        self._add([COLUMNS])

    def _add(self, rows):
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows(rows)
        self._file.append(text.getvalue().encode())

    def write(self, truths: Iterable[Truth]) -> None:
        """Append the records of one frame, all or none of them. CannotWrite when there is no room."""
        self._add([[_text(name, getattr(truth, name)) for name in COLUMNS] for truth in truths])

    def close(self) -> None:
        """End the file."""
        self._file.close()

    def discard(self) -> None:
        """Remove the file."""
        self._file.discard()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def write_truth(path: StrPath, truths: Iterable[Truth]) -> None:
    """Write all records to one CSV file."""
    with TruthWriter(path) as writer:
        writer.write(truths)


def _value(name, text):
    if text == "":
        return "" if name == "frame" else None
    if name == "frame":
        return text
    value = whole(text) if name in ("time_us", "id") else float(text)
    if not math.isfinite(value):
        raise ValueError
    return value


def read_truth(path: StrPath) -> list[Truth]:
    """The records of a truth CSV, in its order; `path` is the file or the folder that holds truth.csv.

    Raises UserError for a file that is missing, empty, lacks a column, has a cell that is no number or cannot
    be, or a marker twice; headings that look like radians are told.
    """
    if is_address(path):
        address = str(path) if str(path).endswith(".csv") else str(path).rstrip("/") + "/truth.csv"
        with list_remote(address)[0][0].local() as copy:
            return read_truth(copy)
    path = Path(path)
    if path.is_dir():
        path = path / "truth.csv"
    truths: list[Truth] = []
    places: dict[tuple[Any, ...], int] = {}  # line of each marker
    for number, row in read_rows(path, COLUMNS, COLUMNS, "a truth table", texts=("frame",)):
        try:
            truths.append(Truth(**{name: _value(name, row.get(name, "")) for name in COLUMNS}))
        except ValueError:
            raise UserError("%s line %d: a cell is not a number" % (path, number)) from None
        one = truths[-1]
        if not one.frame:
            raise UserError("%s line %d: frame is missing" % (path, number))
        if one.id is not None and not 0 <= one.id < ID_NONE:
            raise UserError(
                "%s line %d: %d is no ID; without a marker it is left empty" % (path, number, one.id)
            )
        before = places.setdefault((one.frame, one.id, one.x_px, one.y_px), number)
        if before != number:
            raise UserError("%s line %d: the marker of line %d once more" % (path, number, before))
    if not truths:
        raise UserError("%s names no frame" % path)
    _doubt_radians(path, [one.heading_deg for one in truths if one.heading_deg is not None])
    return truths


def _doubt_radians(path, headings):
    low, high = min(headings, default=0), max(headings, default=0)
    if -math.pi - 0.01 <= low and high <= 2 * math.pi + 0.01 and high - low > math.pi:
        report("%s: all headings lie within %.4g to %.4g degrees: are they radians?" % (path, low, high))


def by_frame(truths: Iterable[Truth]) -> dict[str, list[Truth]]:
    """{frame name: list of its markers' records (empty for a frame without a marker)}, in file order."""
    frames: dict[str, list[Truth]] = {}
    for truth in truths:
        markers = frames.setdefault(truth.frame, [])
        if truth.id is not None:
            markers.append(truth)
    return frames
