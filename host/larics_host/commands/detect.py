"""`larics detect`: markers in recorded frames."""

import argparse
import json
import re
import statistics
import sys
import time
from collections import Counter
from pathlib import Path

from larics_host import detectors
from larics_host.errors import UserError, report

NAME = "detect"
HELP = "find markers in images, folders, videos and OpenMV streams"
EXAMPLE = """
larics detect frame.png
larics detect recorded/ --radius-px 25:35 --draw drawn/
larics detect clip.bin --json > detections.jsonl
"""

EXIT_BAD_SOURCE = 2
_HEADINGS = ("id", "x px", "y px", "heading deg", "radius px", "margin", "flags")


def _radius_range(text):
    match = re.fullmatch(r"(\d{1,4}):(\d{1,4})", text)
    if not match or not 0 < int(match.group(1)) <= int(match.group(2)):
        raise argparse.ArgumentTypeError("%r is not MIN:MAX in whole pixels, such as 25:35" % text)
    return int(match.group(1)), int(match.group(2))


def _id_list(text):
    if not re.fullmatch(r"[0-7](,[0-7])*", text):
        raise argparse.ArgumentTypeError("%r is not a list of IDs from 0 to 7, such as 1,3,6" % text)
    return sorted({int(item) for item in text.split(",")})


def add_arguments(parser):
    parser.add_argument(
        "frames",
        metavar="FRAME",
        nargs="+",
        help=".pgm .png .jpg, a folder of them, a video file, or an OpenMV ImageIO .bin stream",
    )
    parser.add_argument(
        "--radius-px",
        metavar="MIN:MAX",
        type=_radius_range,
        help="smallest and largest radius of the outer ring in the image (default %d:%d, slower)"
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
        "--ids", metavar="ID,ID...", type=_id_list, help="the IDs in use, such as 1,3,6 (default: 1 to 7)"
    )
    parser.add_argument("--allow-id0", action="store_true", help="ID 0 is in use too")
    parser.add_argument("--json", action="store_true", help="one JSON object a frame on standard output")
    parser.add_argument("--draw", metavar="DIR", help="write each frame as PNG with its detections drawn in")


def _check(args):
    """Raises UserError for options that do not fit each other."""
    if args.line_mm is not None and not 5 <= args.line_mm <= 30:
        raise UserError("--line-mm %d is out of range: use 5 to 30" % args.line_mm)
    if args.ids and args.method == "paper":
        raise UserError("--ids is not for --method paper, which reads any ID")
    if args.ids and 0 in args.ids and not args.allow_id0:
        raise UserError("--ids has 0, which is off: give --allow-id0 too")


class _Drawings:
    """Writes one PNG a frame into a folder, named after the frame."""

    def __init__(self, folder):
        self.folder = Path(folder)
        self.names = set()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError("cannot write to %s: %s" % (folder, error.strerror)) from error

    def _path(self, name):
        path, _, index = name.partition("#")
        stem = Path(path).stem + ("-%06d" % int(index) if index.isdigit() else "")
        unique, number = stem, 1
        while unique in self.names:  # frames of the same name from several folders
            number += 1
            unique = "%s-%d" % (stem, number)
        self.names.add(unique)
        return self.folder / (unique + ".png")

    def write(self, name, frame, found):
        import cv2

        from larics_host.drawing import draw_detections

        data = cv2.imencode(".png", draw_detections(frame, found))[1].tobytes()
        path = self._path(name)
        try:
            path.write_bytes(data)
        except OSError as error:
            raise UserError("cannot write %s: %s" % (path, error.strerror)) from error


class _Table:
    """Human-readable lines, one a detection."""

    def __init__(self, width):
        self.layout = "%%-%ds  %%3s %%9s %%9s %%11s %%9s %%6s  %%s" % width
        print((self.layout % ("frame", *_HEADINGS)).rstrip())

    def frame(self, name, found):
        rows = [
            (
                "?" if one["id"] is None else one["id"],
                "%.2f" % one["x"],
                "%.2f" % one["y"],
                "%.2f" % one["heading"],
                "%.2f" % one["radius"],
                one["margin"],
                " ".join(one["flags"]),
            )
            for one in found
        ]
        for row in rows or [("-",) + ("",) * 6]:
            print((self.layout % (name, *row)).rstrip())


class _Detecting:
    """One detector for each frame size, made when the first frame of that size comes."""

    def __init__(self, args):
        self.args = args
        self.by_size = {}
        self.times_ms = []
        self.failed = False

    def fail(self, error):
        self.failed = True
        report(error)

    def detect(self, name, frame):
        """The detections as dicts, or None when frames of that size cannot be processed."""
        height, width = frame.shape
        fresh = (width, height) not in self.by_size
        if fresh:
            try:
                self.by_size[width, height] = detectors.make_detector(
                    self.args.method,
                    width,
                    height,
                    self.args.radius_px,
                    self.args.line_mm,
                    self.args.ids,
                    self.args.allow_id0,
                )
            except UserError as error:
                self.by_size[width, height] = None
                self.fail("%s: %s" % (name, error))  # once for all frames of this size
        detector = self.by_size[width, height]
        if detector is None:
            return None
        start = time.perf_counter()
        found = [detectors.as_dict(one) for one in detector.detect(frame)]
        if not fresh:  # the first frame also pays for loading the compiled kernels
            self.times_ms.append(1000 * (time.perf_counter() - start))
        return found


def _sources(paths):
    """How many frames there are, None when unknown, and the width of the longest name."""
    from larics_host.frames import STILL_EXTENSIONS, list_sources

    found = []
    for path in paths:
        try:
            found += list_sources(path)
        except UserError:  # reported when its turn comes
            continue
    stills = all(path.suffix.lower() in STILL_EXTENSIONS for path in found)
    width = max([5] + [len(str(path)) for path in found])
    return (len(found), width) if stills else (None, width + 6)


def _summary(frames, with_marker, ids, skipped, times_ms):
    parts = ["%d frames" % frames if frames != 1 else "1 frame", "%d with a marker" % with_marker]
    if ids:
        order = sorted(ids, key=lambda marker_id: (marker_id is None, marker_id))
        counts = ["ID %s: %d" % ("?" if key is None else key, ids[key]) for key in order]
        parts[1] += " (%s)" % ", ".join(counts)
    if skipped:
        parts.append("%d skipped" % skipped)
    if times_ms:
        parts.append("median %.2f ms a frame" % statistics.median(times_ms))
    return "; ".join(parts)


def run(args):
    from larics_host.frames import open_frames
    from larics_host.progress import watched

    _check(args)
    drawings = _Drawings(args.draw) if args.draw else None
    work = _Detecting(args)
    total, width = _sources(args.frames)
    table = None
    frames = with_marker = skipped = 0
    ids = Counter()
    for name, frame in watched(open_frames(args.frames, work.fail), total):
        found = work.detect(name, frame)
        if found is None:
            skipped += 1
            continue
        if args.json:
            size = {"width": frame.shape[1], "height": frame.shape[0]}
            print(json.dumps({"frame": name, **size, "detections": found}))
        else:
            table = table or _Table(width)
            table.frame(name, found)
        if drawings:
            drawings.write(name, frame, found)
        frames += 1
        with_marker += bool(found)
        ids.update(one["id"] for one in found)
    if frames or skipped:
        line = _summary(frames, with_marker, ids, skipped, work.times_ms)
        print(line, file=sys.stderr if args.json else sys.stdout)
    return EXIT_BAD_SOURCE if work.failed else 0
