"""`larics detect`: markers in recorded frames."""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

from larics_host.detection import options as detection_options
from larics_host.errors import UserError, report
from larics_host.local_server import DEFAULT_PORT, PERIOD_S
from larics_host.wording import counted

NAME = "detect"
HELP = "find markers in images, folders, videos and OpenMV streams"
EXAMPLE = """
larics detect frame.png
larics detect recorded/ --radius-px 25:35 --draw drawn/
larics detect clip.bin --json > detections.jsonl
larics detect http://192.168.0.20:8080/stream --web     # a camera, live; prints the address of a page
"""

EXIT_BAD_SOURCE = 2
_HEADINGS = ("id", "x px", "y px", "heading deg", "radius px", "margin", "flags")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "frames",
        metavar="FRAME",
        nargs="+",
        help=".pgm .png .jpg, a folder of them, a video file, an OpenMV ImageIO .bin stream, an address that "
        "fsspec opens, or a camera: /dev/video0, http://, rtsp://",
    )
    detection_options.add_arguments(parser)
    detection_options.add_jobs(parser)
    parser.add_argument("--json", action="store_true", help="one JSON object a frame on standard output")
    parser.add_argument("--draw", metavar="DIR", help="write each frame as PNG with its detections drawn in")
    parser.add_argument(
        "--web",
        metavar="PORT",
        nargs="?",
        type=int,
        const=DEFAULT_PORT,
        help="show the newest frame with its detections on a page of this computer only (%d)" % DEFAULT_PORT,
    )


class _Drawings:
    """Writes one PNG a frame into a folder, named after the frame; not over the frames themselves."""

    def __init__(self, folder, frames):
        self.folder = Path(folder)
        self.names = set()
        for path in map(Path, frames):
            target = self.folder / (path.stem + ".png") if path.is_file() else self.folder
            if path.exists() and target.exists() and path.samefile(target):
                raise UserError("--draw %s would overwrite the frames: choose another folder" % folder)
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

        from larics_host.files import write_file
        from larics_host.images.drawing import draw_detections

        data = cv2.imencode(".png", draw_detections(frame, found))[1].tobytes()
        write_file(self._path(name), data)


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


class _Errors:
    """Reports what could not be read or processed, frames of an unsuitable size only once."""

    def __init__(self):
        self.any = False
        self.sizes = set()

    def report(self, result):
        self.any = True
        size = (result.width, result.height)
        if size not in self.sizes:
            report(result.error)
        if result.width:
            self.sizes.add(size)


def _summary(frames, with_marker, ids, skipped, times_ms):
    parts = [counted(frames, "frame"), "%d with a marker" % with_marker]
    if ids:
        order = sorted(ids, key=lambda marker_id: (marker_id is None, marker_id))
        counts = ["ID %s: %d" % ("?" if key is None else key, ids[key]) for key in order]
        parts[1] += " (%s)" % ", ".join(counts)
    if skipped:
        parts.append("%d skipped" % skipped)
    if times_ms:
        parts.append("median %.2f ms a frame" % statistics.median(times_ms))
    return "; ".join(parts)


def _live(args):
    """The camera that is to be looked at, None when there are files."""
    from larics_host.images.live import is_live

    if args.web is not None and not 0 <= args.web <= 65535:
        raise UserError("--web %d: give a port from 0 (any free one) to 65535" % args.web)
    if not any(map(is_live, args.frames)):
        return None
    if len(args.frames) > 1:
        raise UserError("one camera at a time, and no files beside it")
    return args.frames[0]


class _View:
    """The page of --web, or nothing."""

    def __init__(self, args):
        self.on = args.web is not None
        self._stopped = False
        if self.on:
            from larics_host.detection.live_page import LiveView, serve

            self._view = LiveView(", ".join(args.frames))
            self._server = serve(self._view, args.web)
            address = "http://127.0.0.1:%d/  (Ctrl-C ends)" % self._server.server_port
            print(address, file=sys.stderr if args.json else sys.stdout, flush=True)

    def is_stopped(self):
        return self._stopped

    def until_stopped(self, results, live):
        """Ctrl-C ends a live picture or a page, and what was found is told; otherwise it interrupts."""
        if live:
            yield from self._live(results)
            return
        try:
            yield from results
        except KeyboardInterrupt:
            if not self.on:
                raise
            self._stopped = True

    def _live(self, results):
        """A flag and no exception, which compiled code that called back may swallow."""
        from larics_host.connection.byte_sources import stop_on_signals

        def note():
            self._stopped = True

        with stop_on_signals(live=True, note=note):
            for result in results:
                yield result
                if self._stopped:
                    return

    def show(self, result):
        if self.on:
            self._view.show(result.name, result.frame, result.found)

    def close(self, text):
        """The page stays until Ctrl-C."""
        if not self.on:
            return
        from larics_host.connection.byte_sources import stop_on_signals

        self._view.end(text)
        sys.stdout.flush()
        with stop_on_signals(live=True) as stopped:
            while not (self._stopped or stopped()):
                time.sleep(PERIOD_S)
        self._server.shutdown()
        self._server.server_close()


def run(args: argparse.Namespace) -> int:
    from larics_host.detection import batch
    from larics_host.images.live import live_frames
    from larics_host.progress import watched

    options = detection_options.from_args(args)
    drawings = _Drawings(args.draw, args.frames) if args.draw else None
    errors = _Errors()
    live = _live(args)
    total, width = (None, len(live) + 8) if live else batch.count_frames(args.frames)
    table = None
    frames = with_marker = skipped = 0
    ids: Counter[Any] = Counter()
    times_ms = []
    view = _View(args)
    if live:
        results = batch.detect_live(live_frames(live, view.is_stopped), options)
    else:
        keep = bool(drawings) or args.web is not None
        results = batch.detect_all(args.frames, options, args.jobs, keep_frames=keep)
    for result in view.until_stopped(watched(results, total), live):
        name, found = result.name, result.found
        if found is None:
            errors.report(result)
            skipped += bool(result.width)
            continue
        if args.json:
            size = {"width": result.width, "height": result.height}
            print(json.dumps({"frame": name, **size, "detections": found}))
        else:
            table = table or _Table(width)
            table.frame(name, found)
        if drawings:
            drawings.write(name, result.frame, found)
        view.show(result)
        frames += 1
        with_marker += bool(found)
        ids.update(one["id"] for one in found)
        if result.ms is not None:
            times_ms.append(result.ms)
    if frames or skipped:
        line = _summary(frames, with_marker, ids, skipped, times_ms)
        print(line, file=sys.stderr if args.json else sys.stdout)
    view.close(line if frames or skipped else "no frame")
    return EXIT_BAD_SOURCE if errors.any else 0
