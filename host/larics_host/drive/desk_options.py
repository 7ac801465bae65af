"""The options of a camera on the desk."""

from __future__ import annotations

import argparse


def add_desk_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of a camera on the desk."""
    group = parser.add_argument_group("a camera on the desk (--desk): the firmware on a pseudo-terminal")
    group.add_argument("--desk", metavar="DIR", help="folder of frames (.pgm of one size) that it sees")
    group.add_argument(
        "--settings", metavar="FILE", help="of the camera (DIR/settings.json, where there is one)"
    )
    group.add_argument("--fps", type=int, default=15, metavar="N", help="frames per second (15)")
    group.add_argument("--link", metavar="NAME", help="also make this name for its port, until it ends")
    group.add_argument("--detach", action="store_true", help="go on in the background; needs --link")
