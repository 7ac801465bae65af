"""CSV tables as programs and spreadsheets of all countries write them.

Cells lie between commas, semicolons, tabs or bars; blanks, capitals and quotes in the header do not matter;
where the separator is no comma, numbers may have a decimal comma. Lines without any content are skipped.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from larics_host import files
from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics_host.annotations import StrPath

_SEPARATORS = ",;\t|"
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
_DECIMAL_POINT = re.compile(r"[-+]?\d*\.\d+(?:[eE][-+]?\d+)?")


def _cells(line, separator):
    return [cell.strip() for cell in next(csv.reader([line.rstrip("\r\n")], delimiter=separator), [])]


def whole(text: str) -> int:
    """The whole number that a cell holds, also as 3.0, as programs write columns in which cells are empty.
    ValueError for anything else."""
    try:
        return int(text)
    except ValueError:
        number = float(text)
    if not number.is_integer():
        raise ValueError("%s is no whole number" % text)
    return int(number)


def _column(name):
    return "_".join(name.lower().split())


class Layout:
    """What the header of a table says: `names` of its columns in their order, and the separator of cells."""

    def __init__(self, header: str, columns: Sequence[str], separator: str | None = None) -> None:
        """columns: the known names, by which the separator is told."""

        def known(candidate):
            return sum(_column(cell) in columns for cell in _cells(header, candidate))

        self.separator = separator or max(_SEPARATORS, key=known)
        self.names = [_column(cell) for cell in _cells(header, self.separator)]
        self._decimal = None  # "," or "." as soon as a number shows it

    def row(self, line: str, texts: Sequence[str] = ()) -> dict[str, str] | None:
        """{name: text} of a line, numbers with decimal points; None for a line without content.

        Cells that a line lacks at its end are not in the row: some spreadsheets leave empty ones out.
        texts: names of columns whose cells are no numbers. ValueError, in words for a person, where a line
        does not fit the header or is cut off.
        """
        try:
            cells = _cells(line, self.separator)
        except csv.Error as error:
            raise ValueError(str(error)) from None
        if not any(cells):
            return None
        if any(cells[len(self.names) :]):
            raise ValueError("%d cells under a header of %d" % (len(cells), len(self.names)))
        if len(cells) < len(self.names) and not line.endswith("\n"):
            raise ValueError("it ends after %d of %d cells, as if cut off" % (len(cells), len(self.names)))
        row = {}
        for name, cell in zip(self.names, cells, strict=False):
            if name or cell:
                row[name] = cell if name in texts or self.separator == "," else self._number(cell)
        return row

    def _number(self, cell):
        for sign, shape in ((",", _DECIMAL_COMMA), (".", _DECIMAL_POINT)):
            if shape.fullmatch(cell):
                if self._decimal not in (None, sign):
                    raise ValueError("%s, but other numbers have the decimal sign %s" % (cell, self._decimal))
                self._decimal = sign
        return cell.replace(",", ".") if _DECIMAL_COMMA.fullmatch(cell) else cell


def layout_of(
    lines: Iterator[tuple[int, str]],
    columns: Sequence[str],
    required: Sequence[str],
    path: StrPath,
    what: str,
) -> Layout:
    """The Layout of the first line with content, taken off the iterator `lines` of (number, line).

    UserError when a `required` column is missing; what: "a survey", for its text."""
    separator = None
    is_empty = True
    for _, line in lines:
        is_empty = False
        if not line.strip("\r\n \t,;|"):
            continue
        if match := re.fullmatch(r'"?sep=(.)"?\s*', line):  # as Excel takes it
            separator = match.group(1)
            continue
        try:
            layout = Layout(line, columns, separator)
        except csv.Error:
            break
        missing = [name for name in required if name not in layout.names]
        if len(missing) == len(required):
            raise UserError(
                "%s is not %s: its first line has to name the columns %s" % (path, what, ",".join(required))
            )
        if missing:
            raise UserError("%s is not %s: column %s is missing" % (path, what, missing[0]))
        twice = [name for name in layout.names if name and layout.names.count(name) > 1]
        if twice:
            raise UserError("%s has the column %s twice" % (path, twice[0]))
        return layout
    if is_empty:
        raise UserError("%s is empty" % path)
    raise UserError("%s is not %s: there is no line that names the columns" % (path, what))


def read_rows(
    path: StrPath, columns: Sequence[str], required: Sequence[str], what: str, texts: Sequence[str] = ()
) -> Iterator[tuple[int, dict[str, str]]]:
    """Yields (line number, {column: text}) of a CSV file, numbers with decimal points.

    UserError for a file that cannot be read, lacks a required column, or has a line that does not fit."""
    numbered = enumerate(io.StringIO(files.read_text(path), newline=None), 1)
    layout = layout_of(numbered, columns, required, path, what)
    for number, line in numbered:
        try:
            row = layout.row(line, texts)
        except ValueError as error:
            raise UserError("%s line %d: %s" % (path, number, error)) from None
        if row is not None:
            yield number, row
