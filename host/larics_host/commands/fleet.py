"""`larics fleet`: the logs of many vehicles, and what they tell of cameras and markers."""

from __future__ import annotations

import argparse

from larics_host.errors import UserError, report, report_once
from larics_host.wording import counted

NAME = "fleet"
HELP = "logs of many vehicles: rates, faults, wrong IDs, worn and moved markers, calibrations that drift"
EXAMPLE = """
larics fleet logs/ --map hall.json --report fleet.html
larics fleet 's3://fleet/2026-11-*/*.jsonl' -o tables --format parquet --scheduler tcp://10.0.0.5:8786
larics fleet monday/*.jsonl tuesday/*.jsonl --by file --period hour
"""

_SHOWN = "hours", "frames", "seen_pct", "margin", "wrong_ids", "faults", "lost_messages"
_PERIODS = {"day": 10, "hour": 13}  # letters of an ISO date


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "logs",
        metavar="LOG",
        nargs="+",
        help="logs of larics log (.jsonl .csv .bin .mcap, also .gz), folders of them, patterns, or addresses "
        "that fsspec opens, as s3://",
    )
    parser.add_argument("--map", metavar="FILE.json", help="tells wrong IDs and markers that moved")
    parser.add_argument(
        "--by",
        choices=("folder", "file"),
        help="what a vehicle's name is (default: the folder, where the logs lie in several)",
    )
    parser.add_argument(
        "--period", choices=tuple(_PERIODS), default="day", help="means of which trends are made (day)"
    )
    parser.add_argument("--report", metavar="FILE.html", help="write one page with all of it")
    parser.add_argument("-o", "--output", metavar="DIR", help="write the tables into this folder")
    parser.add_argument("--force", action="store_true", help="overwrite tables that the folder holds")
    parser.add_argument("--format", choices=("csv", "parquet"), default="csv", help="of the tables (csv)")
    parser.add_argument("--jobs", metavar="N", type=int, help="processes here (default: all cores)")
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="work on this Dask cluster instead, as tcp://127.0.0.1:8786"
    )


def run(args: argparse.Namespace) -> int:
    from larics_host.detection.batch import cores
    from larics_host.files import PAGE, refuse_existing, refuse_other, write_file
    from larics_host.fleet import engine
    from larics_host.fleet.findings import examine
    from larics_host.fleet.recorded import FramesWork, do, with_frames
    from larics_host.fleet.report import html, table_paths, write_tables
    from larics_host.fleet.sources import Block, blocks, list_logs
    from larics_host.fleet.tally import Work, vehicles
    from larics_host.progress import watched

    if args.jobs is not None and not 1 <= args.jobs <= 256:
        raise UserError("--jobs %d: give a number from 1 to 256" % args.jobs)
    if args.report:
        refuse_other(args.report, PAGE)
    for path in table_paths(args.output, args.format) if args.output else ():
        refuse_existing(path, args.force)
    landmarks = _landmarks(args.map) if args.map else ()
    logs = list_logs(args.logs, args.by)
    recorded = list(with_frames(logs))
    work: list[Work | FramesWork] = [
        Work(block, landmarks, _PERIODS[args.period], block.source not in recorded) for block in blocks(logs)
    ]
    work += [FramesWork(Block(source, 0, None)) for source in recorded]
    jobs = min(args.jobs or cores(), len(work))
    answers = watched(engine.run(do, work, jobs, args.scheduler), len(work), "blocks", True)

    def told():
        for one, answer in zip(work, answers, strict=True):
            for about, text in answer.lines:
                report_once(about, text)
            yield one.block, answer

    tallies, counts, errors = vehicles(told())
    for error in errors:
        report(error)
    for vehicle, tally in tallies.items():
        if tally.damaged:
            report("%s: %s damaged; the rest is read" % (vehicle, counted(tally.damaged, "line")))
    if not tallies:
        raise UserError("none of the logs could be read")
    fleet = examine(tallies, counts, landmarks)
    size = sum(tally.bytes for tally in tallies.values())
    note = "%s of %s, %.1f MB" % (counted(len(logs), "log"), counted(len(tallies), "vehicle"), size / 1e6)
    if args.output:
        write_tables(args.output, fleet, args.format)
    if args.report:
        write_file(args.report, html(fleet, note, errors))
    _print(fleet, note)
    return 1 if errors else 0


def _landmarks(path):
    from larics_host.fleet.track import Landmark
    from larics_host.mapping.mapfile import read_map

    markers = read_map(path).markers
    return tuple(Landmark(k, one.id, one.x_mm, one.y_mm, one.heading_deg) for k, one in enumerate(markers))


def _print(fleet, note):
    print(note)
    layout = "%-20s %8s %10s %8s %8s %7s %7s %7s"
    print(layout % ("vehicle", "hours", "frames", "seen %", "margin", "wrong", "faults", "lost"))
    for row in fleet.vehicles:
        cells = [row[name] for name in _SHOWN]
        print(layout % (row["vehicle"], *("-" if cell is None else cell for cell in cells)))
    print("%s:" % counted(len(fleet.findings), "finding") if fleet.findings else "no finding")
    for one in fleet.findings:
        print("  %s: %s" % (one.kind, one.text))
