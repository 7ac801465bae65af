"""`larics marker`: print-ready markers."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from larics.marker import CODED, LARICS3, PLAIN_ID_MOST
from larics.marker.far_apart import FAR_APART_DISTANCE, FAR_APART_IDS
from larics.marker.golay import DISTANCE
from larics_host.errors import UserError
from larics_host.marker_ids import is_coded, parse_ids, ranges_of
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics.marker import Family


NAME = "marker"
HELP = "print markers true to scale as PDF, SVG or PNG"
EXAMPLE = """
larics marker 3 -o marker3.pdf                        # radius 150 mm, in tiles on A4
larics marker 1 2 5 -o markers.pdf --radius-mm 50     # a page each
larics marker 1 2 -o m.svg                            # m-1.svg and m-2.svg
larics marker 9-199 -o building.pdf --paper plate     # 167 coded markers, for a print shop
larics marker 1-7 122 245 -o test.pdf --sheet --radius-mm 25
larics marker --suggest 60                            # which to print for 60 places
"""

MIN_RADIUS_MM, MAX_RADIUS_MM = 5, 2000


_PAPERS = ("a4", "a3", "letter", "legal", "tabloid", "plate")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "ids",
        metavar="ID",
        nargs="*",
        help="numbers and ranges: 1 to 7 plain, to 4094 coded; of a range, those that there are",
    )
    parser.add_argument(
        "--suggest", metavar="N", type=int, help="say which family and IDs to print for N places, and why"
    )
    parser.add_argument(
        "--family", default="coded", help="coded (default): all IDs; plain: only those without cells, 1 to 7"
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="ends with .pdf (all IDs in one file), .svg or .png (several IDs: one file each, FILE-<ID>)",
    )
    parser.add_argument(
        "--radius-mm", metavar="R", type=float, default=150.0, help="of the outer ring (default 150)"
    )
    parser.add_argument(
        "--line-mm", metavar="W", type=float, help="width of the lines (default 20 mm at radius 150 mm)"
    )
    parser.add_argument(
        "--paper",
        choices=_PAPERS,
        help="PDF only: a4 (default), a3, letter, legal, tabloid, or plate: one page as large as the marker, "
        "for a print shop",
    )
    parser.add_argument("--force", action="store_true", help="overwrite an existing file")
    parser.add_argument("--dpi", type=float, help="PNG only: pixels an inch (default 300)")
    parser.add_argument(
        "--allow-id0", action="store_true", help="allow ID 0, which clutter imitates most easily"
    )
    parser.add_argument(
        "--sheet", action="store_true", help="PDF only: as many markers on a page as fit, for tests"
    )


def _tenths(name, value, low, high):
    """Millimetres as integer tenths. Raises UserError outside low..high or finer than 0.1 mm."""
    if not low <= value <= high:  # also refuses NaN
        raise UserError("%s %g is out of range: use %g to %g mm" % (name, value, low, high))
    if abs(value * 10 - round(value * 10)) > 1e-6:
        raise UserError("%s %g is too fine: use steps of 0.1 mm" % (name, value))
    return round(value * 10)


def chosen_family(args: argparse.Namespace) -> Family:
    """The markers of --family, --radius-mm, --line-mm and --allow-id0."""
    radius_mm10 = _tenths("--radius-mm", args.radius_mm, MIN_RADIUS_MM, MAX_RADIUS_MM)
    line_mm10 = 0
    if args.line_mm is not None:
        line_mm10 = _tenths("--line-mm", args.line_mm, 0.1, args.radius_mm)
    try:
        return LARICS3.scaled(radius_mm10, line_mm10, args.allow_id0, is_coded(args.family))
    except ValueError as error:
        raise UserError(
            "--line-mm %g does not fit an outer ring radius of %g mm" % (args.line_mm, args.radius_mm)
        ) from error


def suggestion(count: int) -> str:
    """Which family and IDs to print for so many places and what each gives, as lines."""
    coded = [i for i in CODED.ids() if i > PLAIN_ID_MOST]
    if not 1 <= count <= len(coded):
        raise UserError(
            "--suggest %d is out of range: one building can have 1 to %d IDs" % (count, len(coded))
        )
    lines = []
    if count <= len(FAR_APART_IDS):
        ids, distance = FAR_APART_IDS[:count], FAR_APART_DISTANCE
        why = "; up to %d places this list is the safest there is" % len(FAR_APART_IDS)
    else:
        ids, distance, why = coded[:count], DISTANCE, ""
    ids = ranges_of(ids)
    lines.append(
        "coded: any two IDs differ in at least %d of 24 cells%s. A covered cell is made up for, and an ID"
        " that is not certain is not told. No field is smaller than those of a plain marker."
        % (distance, why)
    )
    lines.append("  larics marker %s -o markers.pdf" % ids.replace(",", " "))
    lines.append("  in the camera: family coded, allowed_ids %s" % ids)
    if count <= PLAIN_ID_MOST:
        lines.append(
            "plain: IDs 1 to 7, read by every LARICS-3 decoder. Three lines have no redundancy: where one is"
            " covered, the ID may be wrong. For markers that hang already, or readers that know nothing else."
        )
        ids = ranges_of(range(1, count + 1))
        lines.append("  larics marker %s -o markers.pdf" % ids)
        lines.append("  in the camera: family plain, allowed_ids %s" % ids)
    return "\n".join(lines)


def run(args: argparse.Namespace) -> int:
    from larics_host import printing

    if args.suggest is not None:
        if args.ids or args.output:
            raise UserError("--suggest prints advice only: give it without IDs and without -o")
        print(suggestion(args.suggest))
        return 0
    if not args.output:
        raise UserError(
            "-o is missing: give the file to write, such as -o marker.pdf; see larics marker --help"
        )
    if not args.ids:
        raise UserError("which ID? Give numbers and ranges, or ask with --suggest N for N places")
    family = chosen_family(args)
    ids = parse_ids(args.ids, args.family, args.allow_id0)
    kind = args.output.lower()
    if args.sheet and (not kind.endswith(".pdf") or args.paper == "plate"):
        raise UserError("--sheet is for PDF on paper")
    if args.paper and kind.endswith((".svg", ".png")):
        raise UserError("--paper is for PDF; SVG and PNG hold the whole marker")
    if args.dpi is not None and not kind.endswith(".png"):
        raise UserError("--dpi is for PNG; PDF and SVG are vectors")
    dpi = 300.0 if args.dpi is None else args.dpi
    if not 1 <= dpi <= 10000:
        raise UserError("--dpi %g is out of range: use 1 to 10000" % dpi)
    for path in printing.write_markers(
        family, ids, args.output, args.paper or "a4", dpi, args.sheet, args.force
    ):
        print("wrote %s" % path)
    smallest = min(family.smallest_mm10(marker_id) for marker_id in ids) / 10
    print("%s, smallest printed feature %g mm" % (counted(len(ids), "marker"), smallest))
    return 0
