"""`larics validate`: a method, or the log of an earlier run, held against the truth."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from larics_host.addresses import is_address
from larics_host.detection import detectors
from larics_host.detection import options as detection_options
from larics_host.errors import UserError
from larics_host.files import PAGE, refuse_existing, refuse_other, write_file
from larics_host.wording import counted

NAME = "validate"
HELP = "hold detections against the truth: rates, errors, confusion, worst frames"
EXAMPLE = """
larics validate frames --radius-px 25:36 --report report.html    # frames of larics simulate -o frames
larics validate frames --radius-px 25:36 --against paper --min-detected 99 --max-wrong 0
larics validate frames --detections new.jsonl --against old.jsonl
larics validate seen --board seen/messages.jsonl --settings seen/settings.json
"""

EXIT_FAILED = 1
_WORST_ZOOM = 2
_DIFFERENCES_SHOWN = 10


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "folder",
        metavar="FOLDER",
        help="frames with truth.csv, as of larics simulate; or an address of fsspec",
    )
    detection_options.add_arguments(parser)
    detection_options.add_jobs(parser)
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="detect on this Dask cluster, as tcp://127.0.0.1:8786"
    )
    parser.add_argument(
        "--detections",
        metavar="FILE.jsonl",
        help="take these, of an earlier larics detect --json, instead of detecting",
    )
    parser.add_argument(
        "--against", metavar="WHAT", help="compare with another method, or with another such FILE.jsonl"
    )
    parser.add_argument(
        "--board",
        metavar="LOG.jsonl",
        help="compare the board's messages about these frames, of larics log or record, with those that this "
        "computer makes of them; takes no truth; exit code 1 when any differs",
    )
    parser.add_argument("--settings", metavar="FILE.json", help="the board's settings at that time")
    parser.add_argument("--report", metavar="FILE.html", help="write a report with pictures, in one file")
    parser.add_argument("--json", metavar="FILE", help="write all figures as JSON, - for standard output")
    parser.add_argument("--force", action="store_true", help="overwrite an existing file of figures")
    parser.add_argument("--worst", metavar="N", type=int, default=12, help="frames shown in the report (12)")
    limits = parser.add_argument_group("thresholds: exit code 1 when one is missed")
    limits.add_argument("--min-detected", metavar="PCT", type=float, help="markers in view that are found")
    limits.add_argument("--min-read", metavar="PCT", type=float, help="... with the right ID")
    limits.add_argument("--max-wrong", metavar="N", type=float, help="wrong IDs")
    limits.add_argument("--max-false", metavar="N", type=float, help="detections where no marker is")
    limits.add_argument("--max-centre-px", metavar="PX", type=float, help="95 %% of the centres are as near")
    limits.add_argument("--max-heading-deg", metavar="DEG", type=float, help="95 %% of the headings too")


def run(args: argparse.Namespace) -> int:
    options = detection_options.from_args(args)
    if args.worst < 0:
        raise UserError("--worst %d: give 0 or more" % args.worst)
    thresholds = _thresholds(args)
    if args.report:
        refuse_other(args.report, PAGE)
    if args.json and args.json != "-":
        refuse_existing(args.json, args.force)
    if args.settings and not args.board:
        raise UserError("--settings are those of the board: they go with --board")
    board = _compare_with_board(args) if args.board else None
    outcomes, judged, comparison, truths = [], [], None, {}
    if not args.board or is_address(args.folder) or (Path(args.folder) / "truth.csv").exists():
        outcomes, judged, comparison, truths = _validate(args, options, thresholds)
    elif any(limit is not None for limit in thresholds.values()) or args.against or args.detections:
        raise UserError("%s has no truth.csv: only --board can be done without" % args.folder)
    if args.json:
        _write_json(args, outcomes, judged, comparison, board)
    if args.report:
        _write_report(args, outcomes, judged, comparison, board, truths)
    _print(outcomes, judged, board, sys.stderr if args.json == "-" else sys.stdout)
    passed = all(one["passed"] for one in judged) and not (board and board["differences"])
    return 0 if passed else EXIT_FAILED


def _validate(args, options, thresholds):
    from larics_host.truth import by_frame, read_truth
    from larics_host.validation import outcome

    truths = by_frame(read_truth(args.folder))
    outcomes = [outcome.Outcome(detections, truths) for detections in _gather(args, options)]
    comparison = outcome.compare(*outcomes) if len(outcomes) > 1 else None
    return outcomes, outcome.judge(outcomes[0].figures(), thresholds), comparison, truths


def _compare_with_board(args):
    from larics_host.connection.camera_settings import checked, read_file
    from larics_host.validation.board import compare_messages

    if not args.settings:
        raise UserError("--board needs the --settings that the board had: larics settings export writes them")
    return compare_messages(args.folder, args.board, checked(read_file(args.settings)))


def _thresholds(args):
    from larics_host.validation.outcome import LIMITS

    return {limit.option: _threshold(args, limit.option) for limit in LIMITS}


def _threshold(args, option):
    value = getattr(args, option.lstrip("-").replace("-", "_"))
    if value is not None and not value >= 0:
        raise UserError("%s %g: give a number from 0 on" % (option, value))
    if value is not None and option.startswith("--min") and value > 100:
        raise UserError("%s %g: give a share of at most 100 %%" % (option, value))
    return value


def _gather(args, options):
    """The one or two sets of detections, with labels that differ."""
    from larics_host.validation import sources

    if args.detections:
        found = [sources.read_log(args.detections)]
    else:
        found = [sources.run_method(args.folder, options, args.jobs, args.scheduler)]
    if args.against in detectors.METHODS:
        other = options._replace(method=args.against)
        if args.against == "paper":
            other = other._replace(allowed_ids=None)
        found.append(sources.run_method(args.folder, other, args.jobs, args.scheduler))
    elif args.against:
        found.append(sources.read_log(args.against))
    if len(found) > 1 and found[0].label == found[1].label:
        found[0].label += " (first)"
        found[1].label += " (second)"
    return found


def _write_json(args, outcomes, judged, comparison, board):
    methods = []
    for one in outcomes:
        rows, columns, counts = one.matrix()
        confusion = {"true": rows, "reported": columns, "counts": counts}
        worst = [{"frame": place.frame, "why": place.why} for place in one.worst(args.worst)]
        methods.append(dict(one.figures(), confusion=confusion, worst=worst))
    result = {"version": 1, "folder": args.folder, "methods": methods, "thresholds": judged}
    if comparison:
        result["comparison"] = comparison
    if board:
        result["board"] = board
    text = json.dumps(result, indent=1) + "\n"
    if args.json == "-":
        sys.stdout.write(text)
        return
    write_file(args.json, text)


def _pictures(args, outcome, truths):
    """The worst frames as JPEG with detections and truth drawn in."""
    import cv2

    from larics_host.images.drawing import draw_detections
    from larics_host.images.frame_sources import open_frames
    from larics_host.validation.sources import base_name

    wanted = {place.frame: place for place in outcome.worst(args.worst)}
    drawn = {}
    for name, frame in open_frames([args.folder], on_error=lambda error: None) if wanted else ():
        name = base_name(name)
        if name in wanted:
            image = draw_detections(frame, outcome.by_frame[name], _WORST_ZOOM, truths=truths[name])
            data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 88])[1].tobytes()
            drawn[name] = (data, "%s: %s" % (name, wanted[name].why))
    return [drawn[name] for name in wanted if name in drawn]


def _write_report(args, outcomes, judged, comparison, board, truths):
    from larics import __version__
    from larics_host.validation.report import write_report

    frames = outcomes[0].tally.frames if outcomes else board["frames"]
    note = "%s of %s, larics %s" % (counted(frames, "frame"), args.folder, __version__)
    pictures = _pictures(args, outcomes[0], truths) if outcomes else ()
    write_report(args.report, "Validation", note, outcomes, judged, comparison, board, pictures)


def _print(outcomes, judged, board, file):
    if outcomes:
        _print_figures(outcomes, judged, file)
    if board:
        print("board: " + board["summary"], file=file)
        for one in board["differences"][:_DIFFERENCES_SHOWN]:
            print("  %(frame)s marker %(index)d %(field)s: board %(board)s, here %(host)s" % one, file=file)


def _print_figures(outcomes, judged, file):
    from larics_host.validation.report import figure_rows

    print(("%-36s" + "%18s" * len(outcomes)) % ("", *(one.label for one in outcomes)), file=file)
    for heading, cells in figure_rows([one.figures() for one in outcomes]):
        print(("%-36s" + "%18s" * len(cells)) % (heading, *cells), file=file)
    for one in judged:
        value = "nothing was measured" if one["value"] is None else "%.5g" % one["value"]
        state = "passed" if one["passed"] else "FAILED"
        print("%-36s%18s  %s" % ("%s %g" % (one["option"], one["limit"]), value, state), file=file)
