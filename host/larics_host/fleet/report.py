"""What was found out about a fleet, as tables for programs and as one page for people."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from larics_host.errors import UserError, missing_package
from larics_host.files import write_file
from larics_host.fleet.findings import KINDS, Finding, Fleet
from larics_host.html_page import escape, page, table
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics_host.annotations import StrPath

FORMATS = ("csv", "parquet")
_TABLES = ("vehicles", "markers", "findings")
_SHOWN = 500  # rows of a table on the page; all are in the files


def tables(fleet: Fleet) -> dict[str, tuple[list[str], list[dict[str, Any]]]]:
    """{name: (columns, rows)} of all tables."""
    found = [one._asdict() for one in fleet.findings]
    told = [
        (list(fleet.vehicles[0]) if fleet.vehicles else ["vehicle"], fleet.vehicles),
        (list(fleet.markers[0]) if fleet.markers else ["marker"], fleet.markers),
        (list(Finding._fields), found),
    ]
    return dict(zip(_TABLES, told, strict=True))


def table_paths(folder: StrPath, kind: str) -> list[Path]:
    """The paths that `write_tables` writes."""
    return [Path(folder) / ("%s.%s" % (name, kind)) for name in _TABLES]


def write_tables(folder: StrPath, fleet: Fleet, kind: str) -> list[Path]:
    """Writes vehicles, markers and findings into a folder; returns the paths. UserError when that fails."""
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError("cannot make the folder %s: %s" % (folder, error.strerror)) from None
    written = table_paths(folder, kind)
    for path, (columns, rows) in zip(written, tables(fleet).values(), strict=True):
        write_file(path, _parquet(columns, rows) if kind == "parquet" else _csv(columns, rows))
    return written


def _csv(columns, rows):
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _parquet(columns, rows):
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise missing_package("--format parquet", "pyarrow") from None
    content = pyarrow.table({name: [row[name] for row in rows] for name in columns})
    file = io.BytesIO()
    pyarrow.parquet.write_table(content, file)
    return file.getvalue()


def html(fleet: Fleet, note: str, errors: Sequence[str]) -> str:
    """The page."""
    parts = ["<h1>Fleet</h1><p class=note>%s</p>" % escape(note), "<h2>Findings</h2>"]
    counts = Counter(one.kind for one in fleet.findings)
    if counts:
        parts.append(table(("", "findings"), [(kind, [counts[kind]]) for kind in KINDS if counts[kind]]))
        parts.append(_findings(fleet.findings))
    else:
        parts.append("<p>none</p>")
    if errors:
        parts.append("<h2>Not read</h2><ul>%s</ul>" % "".join("<li>%s</li>" % escape(one) for one in errors))
    for name in ("vehicles", "markers"):
        columns, rows = tables(fleet)[name]
        parts.append("<h2>%s</h2>" % name.capitalize())
        cells = [
            (row[columns[0]], ["-" if row[c] is None else row[c] for c in columns[1:]])
            for row in rows[:_SHOWN]
        ]
        parts.append(
            '<div style="overflow-x:auto">%s</div>' % table([c.replace("_", " ") for c in columns], cells)
        )
        if len(rows) > _SHOWN:
            parts.append("<p>and %s more, in the table</p>" % counted(len(rows) - _SHOWN, name[:-1]))
    return page("Fleet", "".join(parts))


def _findings(findings):
    items = "".join(
        "<li><b>%s</b>: %s</li>" % (escape(one.kind), escape(one.text)) for one in findings[:_SHOWN]
    )
    more = "<p>and %d more, in the table</p>" % (len(findings) - _SHOWN) if len(findings) > _SHOWN else ""
    return "<ul>%s</ul>%s" % (items, more)
