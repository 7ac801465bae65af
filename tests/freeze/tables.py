"""Reads the frozen tables: lines of cells between bars, the first one with the names of the columns."""

from pathlib import Path

FOLDER = Path(__file__).resolve().parent


def rows(name):
    """[{column: text}] of a table of this folder; lines that begin with # are for people."""
    lines = (FOLDER / name).read_text().splitlines()
    cells = [[cell.strip() for cell in line.split("|")] for line in lines if line and line[0] != "#"]
    return [dict(zip(cells[0], row, strict=True)) for row in cells[1:]]


def line(row):
    """A row as it stands in its table."""
    return " | ".join(row.values())


def changes(frozen, now, key):
    """What is another than in a frozen table, line by line.

    frozen, now    rows; all cells of `now` are texts. key: the columns by which a row is known
    """
    before, after = ({tuple(row[name] for name in key): row for row in table} for table in (frozen, now))
    found = []
    for place, row in before.items():
        known = " ".join(place)
        if place not in after:
            found.append("gone: " + line(row))
        else:
            found += [
                "%s: %s was %r, is %r" % (known, column, row[column], after[place][column])
                for column in row
                if row[column] != after[place][column]
            ]
    found += ["not in the table yet: " + line(row) for place, row in after.items() if place not in before]
    order = [place for place in after if place in before]
    if not found and order != list(before):
        found.append("in another order")
    return found
