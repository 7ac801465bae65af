"""`larics simulate --drive loop`: one drive of the closed loop, its figures and pictures into a folder."""

from __future__ import annotations

import argparse
import contextlib
import csv
import io
import json
import math
from dataclasses import replace
from pathlib import Path

from larics_host import files
from larics_host.errors import EXIT_INTERRUPTED, UserError
from larics_host.wording import counted

METHODS = ("larics", "paper")
INTERPRETERS = ("micropython", "cpython")
CONTROLLERS = ("c", "python")
ODOMETRY = ("none", "encoders", "commands")
# named here as well, for a quick --help; a test compares them with those of the field
CONDITION_NAMES: tuple[str, ...] = (
    "cloudy",
    "sunny",
    "double",
    "cloudy-coded",
    "sunny-coded",
    "double-coded",
    "steady",
    "fast-1",
    "fast-2",
    "lights",
    "dirty",
    "missing",
)
CONDITION_NAMES += ("pushed", "calibration")
_LONGEST_S = 24 * 3600.0


def add_loop_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of a closed loop."""
    group = parser.add_argument_group("a closed loop (--drive loop): firmware, wire, controller and wheels")
    group.add_argument("--condition", default="sunny", metavar="NAME", help=", ".join(CONDITION_NAMES))
    group.add_argument("--seconds", type=float, metavar="S", help="how long (that of the condition)")
    group.add_argument("--on", default="micropython", metavar="NAME", help="micropython, or cpython")
    group.add_argument(
        "--controller", default="c", metavar="NAME", help="at the wheel: c, the vehicle's library, or python"
    )
    group.add_argument(
        "--odometry", default="none", metavar="NAME",
        help="told to the camera: none, of encoders, or of commands, which miss the noise of the wheels",
    )  # fmt: skip
    group.add_argument(
        "--odometry-late-ms", type=float, default=0.0, metavar="MS", help="its way to the camera (0 to 900)"
    )
    group.add_argument(
        "--clock-ppm", type=float, default=30.0, metavar="PPM",
        help="how much faster than the camera's the vehicle's clock runs (-20000 to 20000)",
    )  # fmt: skip
    group.add_argument("--method", default="larics", metavar="NAME", help="what detects: larics, or paper")


OUTPUTS = ("wire.bin", "frames.csv", "score.json")  # that are data; the pictures are drawn anew


def run_loop(args: argparse.Namespace, folder: Path) -> int:
    """Drives, writes wire.bin (all that the camera said), frames.csv, score.json, path.png and strip.png to
    the folder; returns the exit code."""
    for value, known, what in (
        (args.condition, CONDITION_NAMES, "condition"),
        (args.on, INTERPRETERS, "interpreter"),
        (args.method, METHODS, "method"),
        (args.controller, CONTROLLERS, "controller"),
        (args.odometry, ODOMETRY, "odometry"),
    ):
        if value not in known:
            raise UserError("unknown %s %s: choose from %s" % (what, value, ", ".join(known)))
    if args.seconds is not None and not 1.0 <= args.seconds <= _LONGEST_S:
        raise UserError("--seconds is %g: give a number from 1 to %g" % (args.seconds, _LONGEST_S))
    for option, value, low, high in (
        ("--odometry-late-ms", args.odometry_late_ms, 0.0, 900.0),
        ("--clock-ppm", args.clock_ppm, -20000.0, 20000.0),
    ):
        if not low <= value <= high:
            raise UserError("%s is %g: give a number from %g to %g" % (option, value, low, high))
    # imported here: they compile the renderer and load the plots
    import cv2

    from larics_host.connection.byte_sources import stop_on_signals
    from larics_host.drive import figures
    from larics_host.drive.encoders import Encoders
    from larics_host.drive.field import draw_field
    from larics_host.drive.score import score
    from larics_host.drive.simulation import Simulation
    from larics_host.plots import png
    from larics_host.progress import watched

    field = draw_field(args.condition, args.seed)
    if args.seconds is not None:
        field.condition = replace(field.condition, seconds=args.seconds)
    folder = Path(folder)
    expected = math.ceil(field.condition.seconds * field.condition.rate_hz)
    keep = figures.keep_changes()
    encoders = None
    if args.odometry != "none":
        seen, late_s = args.odometry == "encoders", args.odometry_late_ms / 1000
        encoders = Encoders(seen=seen, delay_s=late_s, clock_ppm=args.clock_ppm)
    simulation = Simulation(
        field,
        args.seed,
        args.on,
        args.method,
        keep=keep,
        controller=args.controller,
        encoders=encoders,
    )
    interrupted = False
    try:
        with stop_on_signals(live=False), contextlib.closing(simulation.frames()) as frames:
            for _ in watched(frames, expected, quiet_stdout=True):
                pass
    except KeyboardInterrupt:
        interrupted = True
    trace = simulation.trace
    if not trace.frames:
        with contextlib.suppress(OSError):
            folder.rmdir()
        raise KeyboardInterrupt
    result = score(trace)
    files.write_file(folder / "wire.bin", bytes(trace.wire))
    _write_frames(folder / "frames.csv", trace)
    text = json.dumps(_without_nan(result.as_dict()), indent=1, allow_nan=False) + "\n"
    files.write_file(folder / "score.json", text)
    files.write_file(folder / "path.png", png(figures.path_figure(trace, field.condition.summary)))
    files.write_file(folder / "strip.png", cv2.imencode(".png", figures.strip(trace))[1].tobytes())
    if interrupted:
        print("interrupted after %.1f s of the drive" % trace.frames[-1].time_s)
    _tell(result, folder)
    return EXIT_INTERRUPTED if interrupted else 0


def _write_frames(path, trace):
    columns = ("time_s", "true_x_mm", "true_y_mm", "true_heading_deg", "state", "x_mm", "y_mm", "heading_deg")
    columns += ("error_mm", "error_deg", "sigma_mm", "id", "route_position", "behaviour")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for frame in trace.frames:
        truth = [round(value, 3) for value in (frame.x_mm, frame.y_mm, frame.heading_deg % 360)]
        error = [round(value, 4) for value in frame.error]
        row = [
            *(round(frame.time_s, 3), *truth, frame.state, *frame.pose, *error, frame.sigma_mm),
            *(frame.marker_id, frame.route_position, frame.behaviour),
        ]
        writer.writerow(["" if value != value else value for value in row])  # nan: not known
    files.write_file(path, text.getvalue())


def _without_nan(value):
    """NaN is no JSON: what was not measured becomes null."""
    if isinstance(value, dict):
        return {name: _without_nan(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_without_nan(part) for part in value]
    return None if isinstance(value, float) and math.isnan(value) else value


def _tell(result, folder):
    wire = result.methods["wire"]
    print(
        "%s, %d of %s with the right ID, %d wrong"
        % (
            counted(wire.frames, "frame"),
            wire.right,
            counted(wire.markers, "whole marker"),
            wire.other + wire.cut_wrong,
        )
    )
    for name, values, unit in (
        ("pose", result.tracking_mm, "mm"),
        ("heading", result.tracking_deg, "deg"),
        ("coasting", result.coasting_mm, "mm"),
    ):
        if values.count:
            numbers = values.median, values.p95, values.max
            print("%-8s median %.2f, p95 %.2f, max %.2f %s" % (name, *numbers, unit))
        else:
            print("%-8s none" % name)
    print(
        "%s left, %d of %s, %.1f m; path.png, strip.png, wire.bin, frames.csv and score.json in %s"
        % (
            counted(result.visits, "marker"),
            result.laps_completed,
            counted(result.laps_begun, "lap"),
            result.way_m,
            folder,
        )
    )
