"""The options that say how markers are looked for, the same in every command that detects."""

from __future__ import annotations

import argparse
import re
from typing import TYPE_CHECKING, NamedTuple

from larics.marker import FAMILY_NAMES, ids_in_words, is_used
from larics.marker.verdicts import MARGIN_MIN
from larics_host.detection import detectors
from larics_host.detection.mirrored import MirroredDetector
from larics_host.errors import UserError
from larics_host.marker_ids import parse_ids

if TYPE_CHECKING:
    from larics_host.annotations import AnyDetector


class DetectionOptions(NamedTuple):
    """What `detectors.make_detector` takes beside the size of the frames."""

    method: str = detectors.DEFAULT_METHOD
    radius_px: tuple | None = None
    line_mm: int | None = None
    allowed_ids: list | None = None
    allow_id0: bool = False
    max_tilt_deg: int = 0
    margin_min: int = MARGIN_MIN
    second_opinion: bool = True
    family: str = "coded"
    mirrored: bool = False

    def make(self, width: int, height: int) -> AnyDetector:
        """A detector for frames of this size; UserError when there cannot be one."""
        values = self._asdict()
        mirrored = values.pop("mirrored")
        detector = detectors.make_detector(width=width, height=height, **values)
        return MirroredDetector(detector, width, height) if mirrored else detector


def _radius_range(text):
    match = re.fullmatch(r"(\d{1,4}):(\d{1,4})", text)
    if not match or not 0 < int(match.group(1)) <= int(match.group(2)):
        raise argparse.ArgumentTypeError("%r is not MIN:MAX in whole pixels, such as 25:35" % text)
    return int(match.group(1)), int(match.group(2))


def _id_list(text):
    try:
        return sorted(parse_ids([text], allow_id0=True))
    except UserError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the options to a command's parser."""
    parser.add_argument(
        "--radius-px",
        metavar="MIN:MAX",
        type=_radius_range,
        help="smallest and largest radius of the outer ring in the image (default %d:%d and what is larger, "
        "slower); a board takes 6:72 in frames up to 1024 x 1024, here what is larger is reduced"
        % detectors.DEFAULT_RADIUS_PX,
    )
    parser.add_argument(
        "--method",
        choices=detectors.METHODS,
        default=detectors.DEFAULT_METHOD,
        help="larics (default), or paper: the published method as it stands, for comparison",
    )
    parser.add_argument(
        "--line-mm",
        metavar="W",
        type=int,
        help="line width of the markers at a ring radius of 150 mm, 5 to 30; 15 to 20 need no option",
    )
    parser.add_argument(
        "--ids", metavar="ID,ID-ID", type=_id_list, help="IDs in use, such as 1,3,9-99 (default: all)"
    )
    parser.add_argument(
        "--family",
        choices=FAMILY_NAMES,
        default="coded",
        help="coded (default): plain and coded markers; plain: IDs 1 to 7, by their lines alone",
    )
    parser.add_argument("--allow-id0", action="store_true", help="ID 0 is in use too")
    parser.add_argument(
        "--max-tilt",
        metavar="DEG",
        type=int,
        default=0,
        help="tilt of the camera to reckon with, up to 40: --radius-px is that of a level view",
    )
    parser.add_argument(
        "--margin-min",
        metavar="N",
        type=int,
        default=MARGIN_MIN,
        help="report no marker with a smaller margin, 0 to 255 (default %(default)s): more makes wrong IDs "
        "rarer and misses more markers in bad light",
    )
    parser.add_argument(
        "--no-second-opinion",
        dest="second_opinion",
        action="store_false",
        help="do not look again for markers that are blurred, tiny or faint",
    )

    parser.add_argument(
        "--mirrored", action="store_true", help="the camera shows left and right exchanged, as in a mirror"
    )


def add_jobs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--jobs", metavar="N", type=int, help="processes (default: all cores when there are many frames)"
    )


def from_args(args: argparse.Namespace) -> DetectionOptions:
    """The options of a parsed command line. Raises UserError when they do not fit each other."""
    if args.line_mm is not None and not 5 <= args.line_mm <= 30:
        raise UserError("--line-mm %d is out of range: use 5 to 30" % args.line_mm)
    if args.ids and args.method == "paper":
        raise UserError("--ids is not for --method paper, which reads any ID")
    if args.method == "paper" and (args.max_tilt or args.margin_min != MARGIN_MIN or not args.second_opinion):
        raise UserError("--max-tilt, --margin-min and --no-second-opinion are not for --method paper")
    if args.family == "plain" and args.method == "paper":
        raise UserError("--family is not for --method paper, which reads lines alone")
    if args.ids and not all(is_used(i, args.family == "coded", True) for i in args.ids):
        raise UserError("--ids has IDs of another family: %s" % ids_in_words(args.family == "coded"))
    if args.ids and 0 in args.ids and not args.allow_id0:
        raise UserError("--ids has 0, which is off: give --allow-id0 too")
    if not 0 <= args.max_tilt <= 40:
        raise UserError("--max-tilt %d is out of range: use 0 to 40" % args.max_tilt)
    if not 0 <= args.margin_min <= 255:
        raise UserError("--margin-min %d is out of range: use 0 to 255" % args.margin_min)
    if args.jobs is not None and not 1 <= args.jobs <= 256:
        raise UserError("--jobs %d: give a number from 1 to 256" % args.jobs)
    return DetectionOptions(
        args.method,
        args.radius_px,
        args.line_mm,
        args.ids,
        args.allow_id0,
        args.max_tilt,
        args.margin_min,
        args.second_opinion,
        args.family,
        args.mirrored,
    )
