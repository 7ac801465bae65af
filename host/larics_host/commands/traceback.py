"""`larics traceback`: what a board with a small-heap build says, in the names of the sources."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from larics_host import files

NAME = "traceback"
HELP = "translate a traceback of a board with little memory into the names of the sources"
EXAMPLE = """
larics traceback console.txt       # what the board said; by the names of the build flashed last
larics traceback < console.txt
larics traceback console.txt --names ~/.config/larics/programs/0123456789ab.json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", nargs="?", help="what the board said; standard input without")
    parser.add_argument(
        "--names", metavar="FILE", help="of the build; default: that of the last one flashed from here"
    )


def run(args: argparse.Namespace) -> int:
    from larics_host.flash import tracebacks

    said = None
    if args.file:  # a serial line's log has the line ends of the board
        said = files.read_bytes(args.file).decode(errors="replace").replace("\r\n", "\n")
    names = tracebacks.load(Path(args.names) if args.names else None)
    sys.stdout.write(tracebacks.translate(sys.stdin.read() if said is None else said, names))
    return 0
