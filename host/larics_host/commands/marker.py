"""`larics marker`: print-ready markers."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from larics.marker import LARICS3
from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics.marker import Family


NAME = "marker"
HELP = "print markers true to scale as PDF, SVG or PNG"
EXAMPLE = """
larics marker 3 -o marker3.pdf                        # radius 150 mm, in tiles on A4
larics marker 1 2 5 -o markers.pdf --radius-mm 50     # a page each
larics marker 1 2 -o m.svg                            # m-1.svg and m-2.svg
"""

MIN_RADIUS_MM, MAX_RADIUS_MM = 5, 2000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("ids", metavar="ID", nargs="+", type=int, help="1 to 7, and 0 with --allow-id0")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        required=True,
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
        choices=("a4", "a3", "plate"),
        help="PDF only: a4 (default), a3, or plate: one page as large as the marker, for a print shop",
    )
    parser.add_argument("--dpi", type=float, help="PNG only: pixels an inch (default 300)")
    parser.add_argument(
        "--allow-id0", action="store_true", help="allow ID 0, which clutter imitates most easily"
    )


def _tenths(name, value, low, high):
    """Millimetres as integer tenths. Raises UserError outside low..high or finer than 0.1 mm."""
    if not low <= value <= high:  # also refuses NaN
        raise UserError("%s %g is out of range: use %g to %g mm" % (name, value, low, high))
    if abs(value * 10 - round(value * 10)) > 1e-6:
        raise UserError("%s %g is too fine: use steps of 0.1 mm" % (name, value))
    return round(value * 10)


def chosen_family(args: argparse.Namespace) -> Family:
    """The marker family of --radius-mm, --line-mm and --allow-id0."""
    radius_mm10 = _tenths("--radius-mm", args.radius_mm, MIN_RADIUS_MM, MAX_RADIUS_MM)
    line_mm10 = 0
    if args.line_mm is not None:
        line_mm10 = _tenths("--line-mm", args.line_mm, 0.1, args.radius_mm)
    try:
        return LARICS3.scaled(radius_mm10, line_mm10, args.allow_id0)
    except ValueError as error:
        raise UserError(
            "--line-mm %g does not fit an outer ring radius of %g mm" % (args.line_mm, args.radius_mm)
        ) from error


def run(args: argparse.Namespace) -> int:
    from larics_host import printing

    family = chosen_family(args)
    kind = args.output.lower()
    if args.paper and kind.endswith((".svg", ".png")):
        raise UserError("--paper is for PDF; SVG and PNG hold the whole marker")
    if args.dpi is not None and not kind.endswith(".png"):
        raise UserError("--dpi is for PNG; PDF and SVG are vectors")
    dpi = 300.0 if args.dpi is None else args.dpi
    if not 1 <= dpi <= 10000:
        raise UserError("--dpi %g is out of range: use 1 to 10000" % dpi)
    for path in printing.write_markers(family, args.ids, args.output, args.paper or "a4", dpi):
        print("wrote %s" % path)
    return 0
