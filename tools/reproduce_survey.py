"""Surveying by one drive, as part of tools/reproduce.py: a drive is logged, its log becomes a map, and the
vehicle drives by that map.

At 1 m/s under three markers 4 m apart, of which no two are ever in view at once. In the first drive the
reference behaviour holds the wheel with the true map, in place of a person; the log of the camera's bytes is
all that `larics map build` gets, with one distance and the place of one marker.
"""

import contextlib
import io
import math
from dataclasses import replace

from larics_host import cli
from larics_host.drive import field as fields
from larics_host.drive import figures
from larics_host.drive.encoders import Encoders
from larics_host.drive.score import score
from larics_host.drive.simulation import Simulation
from larics_host.errors import UserError
from larics_host.mapping.mapfile import read_map
from larics_host.plots import png

CONDITION = "fast-1"


def survey(seed, args, folder):
    """Runs both drives, writes survey.bin, survey-map.json and pictures; returns the figures as a dict."""
    found = {}
    true = fields.draw_field(CONDITION, seed).markers
    rows = None
    for name in ("survey", "by-the-map"):
        field = fields.draw_field(CONDITION, seed)
        if args.seconds:
            field.condition = replace(field.condition, seconds=args.seconds)
        if rows:
            field.settings["map"] = rows
        simulation = Simulation(field, seed, args.on, "larics", (), None, args.controller, Encoders())
        trace = simulation.run(lambda record: None)
        plot = figures.path_figure(trace, "%s: %s" % (name, field.condition.summary))
        (folder / ("survey-%s.png" % name)).write_bytes(png(plot))
        found[name] = score(trace).as_dict()
        if rows is None:
            (folder / "survey.bin").write_bytes(trace.wire)
            rows = _build(folder, true).rows()
            found["markers"] = [_off(row, true) for row in rows]
    return found


def _build(folder, true):
    (first, anchor), (second, other) = list(true.items())[:2]
    words = ["map", "build", folder / "survey.bin", "-o", folder / "survey-map.json", "--force"]
    words += ["--anchor", "%d,%s,%s,%s" % (first, *anchor), "--png", folder / "survey-map.png"]
    words += ["--distance", "%d,%d,%.0f" % (first, second, math.dist(anchor[:2], other[:2]))]
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        code = cli.main([str(word) for word in words])
    if code:
        raise UserError("the survey gave no map: %s" % said.getvalue().strip())
    return read_map(folder / "survey-map.json")


def _off(row, true):
    x, y, heading = true[row[0]]
    turned = (row[3] / 100 - heading + 180) % 360 - 180
    return {"id": row[0], "mm": round(math.hypot(row[1] - x, row[2] - y), 1), "deg": round(turned, 2)}


def section(found):
    """Lines of the report."""
    laps = found["by-the-map"]
    lines = ["## Surveyed by one drive", ""]
    lines += [__doc__.split("\n\n")[1].replace("\n", " "), ""]
    for marker in found["markers"]:
        lines.append("- marker %(id)d of the map is off by %(mm).1f mm and %(deg)+.2f degrees" % marker)
    lines += ["", "Driving by that map: %d of %d laps." % (laps["laps_completed"], laps["laps_begun"]), ""]
    lines += ["![the map, with error ellipses](survey-map.png) ![driven by it](survey-by-the-map.png)", ""]
    return lines
