"""Print-ready markers, true to scale: PDF (tiled over A4 or A3), SVG and PNG."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from larics.marker import ids_in_words
from larics_host.errors import UserError
from larics_host.files import refuse_existing, write_file
from larics_host.marker_ids import ranges_of
from larics_host.printing import layout

if TYPE_CHECKING:
    from larics.marker import Family
    from larics_host.annotations import StrPath


FORMATS = (".pdf", ".svg", ".png")


def _numbered(path, marker_id):
    """The file of one of several IDs: marker.svg -> marker-3.svg."""
    return path.with_name("%s-%d%s" % (path.stem, marker_id, path.suffix))


def _title(marker_ids):
    if len(marker_ids) == 1:
        return "LARICS-3 ID %d" % marker_ids[0]
    return "LARICS-3 ID " + ranges_of(marker_ids).replace(",", ", ")


def _targets(path, marker_ids):
    """The files that these markers go to."""
    if path.suffix.lower() == ".pdf" or len(marker_ids) == 1:
        return [path]
    return [_numbered(path, marker_id) for marker_id in marker_ids]


def _rendered(family, marker_ids, path, paper, dpi, sheet):
    """(path, bytes) of each file."""
    # imported here so that an SVG needs no PDF library
    kind = path.suffix.lower()
    if kind == ".pdf":
        from larics_host.printing.pdf import pdf_bytes

        sheets = layout.many_on_sheets(family, marker_ids, paper) if sheet else []
        for marker_id in () if sheet else marker_ids:
            if paper == "plate":
                sheets.append(layout.plate_sheet(family, marker_id))
            else:
                sheets += layout.paper_sheets(family, marker_id, paper)
        yield path, pdf_bytes(sheets, _title(marker_ids))
        return
    for marker_id in marker_ids:
        sheet = layout.plate_sheet(family, marker_id)
        target = path if len(marker_ids) == 1 else _numbered(path, marker_id)
        if kind == ".svg":
            from larics_host.printing.svg import svg_bytes

            yield target, svg_bytes(sheet, layout.describe(family, marker_id))
        else:
            from larics_host.printing.png import png_bytes

            yield target, png_bytes(sheet, dpi)


def write_markers(
    family: Family,
    marker_ids: Sequence[int],
    path: StrPath,
    paper: str = "a4",
    dpi: float = 300,
    sheet: bool = False,
    force: bool = False,
) -> list[Path]:
    """Writes markers to `path`, whose extension says the format; returns the paths written.

    PDF: all IDs in one file, on `paper` a4 or a3 (in tiles where larger) or plate (one page each).
    SVG and PNG: one file per ID, with the ID as suffix when there are several.
    sheet: PDF only, as many markers on a page as fit, for tests.
    force: overwrite files that are there, which is refused otherwise.
    Raises UserError for an unknown format or ID and when a file cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise UserError("cannot tell the format of %s: use one of %s" % (path, ", ".join(FORMATS)))
    for marker_id in marker_ids:
        if not family.has(marker_id):
            words = ids_in_words(family.coded, family.allow_id0)
            raise UserError("unknown marker ID %d: %s" % (marker_id, words))
    for target in _targets(path, marker_ids):
        refuse_existing(target, force)
    written = []
    for target, data in _rendered(family, marker_ids, path, paper, dpi, sheet):
        write_file(target, data)
        written.append(target)
    return written
