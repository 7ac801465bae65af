"""The published experiment again, in closed loop: tables, figures and what lies beyond it.

    python tools/reproduce.py [-o build/reproduce] [--on micropython|cpython] [--only NAME,NAME] [--seconds N]
                              [--controller c|python]

Drives the published field (three markers, 2.8 frames/s, 7 minutes, cloudy, sunny and double speed) with the
firmware on MicroPython, shows the same frames to the published method, lets the published method drive as
well, and then asks more of ours than the publication did. Writes report.md, scores.json and pictures.
"""

import argparse
import json
import sys
import time
from dataclasses import fields as fields_of
from dataclasses import replace
from pathlib import Path

import cv2

from larics_host.drive import field as fields
from larics_host.drive import figures
from larics_host.drive.encoders import Encoders
from larics_host.drive.score import Score, score
from larics_host.drive.simulation import Simulation
from larics_host.errors import UserError, report
from larics_host.plots import png
from tools import method_figures
from tools.reproduce_report import write_report
from tools.reproduce_survey import survey

SEED = 5000
_SURVEY = "survey"  # beside the conditions: see tools/reproduce_survey.py
_FIGURES = {one.name for one in fields_of(Score)}
_DRIVERS = {"larics": "ours", "paper": "the published method", "odometry": "ours, with odometry"}
# (condition, method at the wheel, methods that look at the same frames); "odometry": ours, and the vehicle
# tells of its wheels
DRIVES = (
    ("cloudy", "larics", ("larics", "paper")),
    ("sunny", "larics", ("larics", "paper")),
    ("double", "larics", ("larics", "paper")),
    ("cloudy" + fields.CODED, "larics", ("larics",)),
    ("sunny" + fields.CODED, "larics", ("larics",)),
    ("double" + fields.CODED, "larics", ("larics",)),
    ("cloudy", "paper", ()),
    ("sunny", "paper", ()),
    ("double", "paper", ()),
    ("steady", "larics", ("paper",)),
    ("fast-1", "larics", ("paper",)),
    ("fast-2", "larics", ("paper",)),
    ("lights", "larics", ("paper",)),
    ("dirty", "larics", ("paper",)),
    ("missing", "larics", ()),
    ("pushed", "larics", ()),
    ("steady", "odometry", ()),
    ("fast-1", "odometry", ()),
    ("fast-2", "odometry", ()),
    ("missing", "odometry", ()),
    ("pushed", "odometry", ()),
    ("calibration", "larics", ()),
)


def drive(name, driver, compare, args, folder):
    """Runs one drive, writes its pictures, returns its score as a dict."""
    field = fields.draw_field(name, SEED)
    if args.seconds:
        field.condition = replace(field.condition, seconds=args.seconds)
    keep = figures.keep_changes() if driver == "larics" else None
    began = time.monotonic()
    encoders = Encoders() if driver == "odometry" else None
    method = "paper" if driver == "paper" else "larics"
    simulation = Simulation(field, SEED, args.on, method, compare, keep, args.controller, encoders)
    record = simulation.run(_progress(name, driver))
    summary = field.condition.summary
    stem = folder / ("%s-%s" % (name, driver))
    plot = figures.path_figure(record, "%s; %s at the wheel" % (summary, _DRIVERS[driver]))
    stem.with_suffix(".png").write_bytes(png(plot))
    if record.pictures:
        cv2.imwrite(str(folder / ("strip-%s.jpg" % name)), figures.strip(record))
    if record.suspects:
        cv2.imwrite(
            str(folder / ("suspects-%s-%s.jpg" % (name, driver))), figures.strip(record, record.suspects)
        )
    result = score(record).as_dict()
    result.update(condition=name, driver=driver, summary=summary, seconds=field.condition.seconds)
    result.update(rate_hz=field.condition.rate_hz, on=args.on, wall_s=round(time.monotonic() - began, 1))
    return result


def _progress(name, driver):
    quiet = not sys.stderr.isatty()

    def tell(record):
        if not quiet and len(record.frames) % 20 == 0:
            seconds = record.field.condition.seconds
            done = record.frames[-1].time_s / seconds
            sys.stderr.write("\r%-12s %-7s %3.0f %%" % (name, driver, 100 * done))

    return tell


def _read(path):
    return json.loads(path.read_text()) if path.exists() else None


def main(argv=None):
    """Returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    names = [*fields.CONDITIONS, _SURVEY]
    parser.add_argument("-o", "--output", default="build/reproduce", metavar="DIR")
    parser.add_argument("--on", default="micropython", choices=("micropython", "cpython"))
    parser.add_argument("--controller", default="c", choices=("c", "python"), help="what drives")
    parser.add_argument("--only", metavar="NAME,NAME", help="conditions: " + ", ".join(names))
    parser.add_argument(
        "--seconds", type=float, metavar="S", help="length of every drive, instead of its own"
    )
    args = parser.parse_args(argv)
    only = args.only.split(",") if args.only else names
    try:
        for name in only:
            if name not in names:
                raise UserError("unknown condition %s: choose from %s" % (name, ", ".join(names)))
        folder = Path(args.output)
        folder.mkdir(parents=True, exist_ok=True)
        stored = folder / "scores.json"
        scores = json.loads(stored.read_text()) if stored.exists() and args.only else []
        scores = [one for one in scores if one.keys() >= _FIGURES]  # an older build's had others
        method_figures.write(folder)
        for name, driver, compare in DRIVES:
            if name not in only:
                continue
            result = drive(name, driver, compare, args, folder)
            scores = [s for s in scores if (s["condition"], s["driver"]) != (name, driver)] + [result]
            order = [(row[0], row[1]) for row in DRIVES]
            scores.sort(key=lambda s: order.index((s["condition"], s["driver"])))
            stored.write_text(json.dumps(scores, indent=1) + "\n")
            write_report(folder / "report.md", scores, None)
            wire = result["methods"]["wire"]
            print(
                "%-12s %-7s %5d frames  %d of %d IDs right  laps %d of %d  %.0f s"
                % (
                    *(name, driver, wire["frames"], wire["right"], wire["markers"]),
                    *(result["laps_completed"], result["laps_begun"], result["wall_s"]),
                ),
                flush=True,
            )
        surveyed = folder / "survey.json"
        if _SURVEY in only:
            surveyed.write_text(json.dumps(survey(SEED, args, folder), indent=1) + "\n")
        if scores or surveyed.exists():
            write_report(folder / "report.md", scores, _read(surveyed))
    except UserError as error:
        report(error)
        return 2
    print("report: %s" % (folder / "report.md"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
