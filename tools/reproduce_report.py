"""The report of tools/reproduce.py as Markdown: published, published method here, and ours, side by side."""

from larics.wire import messages as m
from larics.wire.codec import frame_size
from larics_host.drive.field import ASSUMED, CODED
from larics_host.drive.simulation import BAUD, LATENCY_S
from tools.reproduce_survey import section

# rates of correct IDs that the publication gives for its tables 1 to 3
PUBLISHED = {"cloudy": (1, 92), "sunny": (2, 96), "double": (3, 93)}
_DRIVEN = {"paper": ", published method", "odometry": ", with odometry"}
BEYOND = ("steady", "fast-1", "fast-2", "lights", "dirty", "missing", "pushed", "calibration")


def _percent(part, whole):
    return "%.1f %%" % (100 * part / whole) if whole else "-"


def _row(*cells):
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def _table(head, rows):
    return [_row(*head), _row(*["---"] * len(head)), *[_row(*row) for row in rows], ""]


def _spread(values, digits=2):
    if not values["count"]:
        return "-"
    return " / ".join("%.*f" % (digits, values[key]) for key in ("median", "p95", "max"))


def _method_row(title, result):
    return (
        title,
        result["frames"],
        result["markers"],
        "%d (%s)" % (result["detected"], _percent(result["detected"], result["markers"])),
        "%d (%s)" % (result["right"], _percent(result["right"], result["markers"])),
        result["other"],
        result["unsure"],
        result["cut_wrong"],
        result["false"],
    )


def published_tables(scores):
    """Tables 1 to 3, each as published, with the published method here, and with ours."""
    head = ("", "frames", "with a marker", "detected", "IDs right", "other ID", "ID uncertain",
            "other ID, cut by the border", "no marker there")  # fmt: skip
    lines = []
    for name, (number, rate) in PUBLISHED.items():
        ours = _find(scores, name, "larics")
        if ours is None:
            continue
        lines += ["### Table %d: %s" % (number, ours["summary"].replace(", as published", "")), ""]
        rows = [("as published", "", "", "", "%d %%" % rate, "", "", "", "")]
        rows.append(_method_row("published method, on these frames", ours["methods"]["paper"]))
        rows.append(_method_row("ours, on these frames", ours["methods"]["larics"]))
        rows.append(_method_row("ours, as sent by the firmware", ours["methods"]["wire"]))
        theirs = _find(scores, name, "paper")
        coded = _find(scores, name + CODED, "larics")
        if coded:
            rows.append(_method_row("ours, coded markers, on their frames", coded["methods"]["larics"]))
            rows.append(_method_row("ours, coded markers, as sent", coded["methods"]["wire"]))
        if theirs:
            rows.append(_method_row("published method at the wheel", theirs["methods"]["wire"]))
        lines += _table(head, rows)
    return lines


def _by_axis(text, values, scale=1.0):
    return " / ".join(text % (scale * value) for value in values) or "-"


def _find(scores, name, driver):
    for entry in scores:
        if (entry["condition"], entry["driver"]) == (name, driver):
            return entry
    return None


def _drive_rows(scores, names):
    for name in names:
        for driver in ("larics", "odometry", "paper"):
            entry = _find(scores, name, driver)
            if entry:
                wire, states = entry["methods"]["wire"], entry["states"]
                yield (
                    entry["summary"] + _DRIVEN.get(driver, ""),
                    "%.0f s, %.0f m" % (entry["seconds"], entry["way_m"]),
                    "%d (%s)" % (wire["right"], _percent(wire["right"], wire["markers"])),
                    "%.0f" % entry["wrong_per_hour"],
                    _spread(entry["tracking_mm"], 1),
                    _spread(entry["tracking_deg"], 3),
                    _spread(entry["coasting_mm"], 0),
                    *(
                        ", ".join(
                            _by_axis(text, entry[key][state], scale) for state in ("tracking", "coasting")
                        )
                        for key, text, scale in (("covered", "%.0f", 100.0), ("pulls", "%.1f", 1.0))
                    ),
                    "%.0f / %.0f / %.0f"
                    % tuple(
                        100 * share
                        for share in (
                            states["tracking"],
                            states["coasting"] + states["carried"],
                            states["lost"],
                        )
                    ),
                    "%d of %d" % (entry["laps_completed"], entry["laps_begun"]),
                    _spread(entry["centred_mm"], 0),
                    _spread(entry["pose_regained_s"], 1),
                    _spread(entry["route_regained_s"], 1),
                )


def drive_table(scores, names):
    """Pose, laps and recovery of the drives."""
    head = ("drive", "length", "IDs right", "wrong IDs per hour", "pose error while tracking, mm",
            "heading error, deg", "pose error while coasting, mm",
            "x / y / heading within 2 sigma, %, tracking and coasting",
            "error by sigma of x / y / heading, root mean square, tracking and coasting",
            "tracking / coasting / lost, %",
            "laps", "off the marker when left, mm", "pose regained, s", "route regained, s")  # fmt: skip
    return _table(head, _drive_rows(scores, names))


def _totals(scores):
    """Ours over all drives: hours, wrong and false readings; and the time that a report takes."""
    ours = [entry for entry in scores if entry["driver"] != "paper"]
    wires = [entry["methods"]["wire"] for entry in ours]
    line_ms = 1e4 * (frame_size(m.MARKER) + frame_size(m.POSE)) / BAUD
    return [
        "With ours at the wheel: %.2f hours, %d frames, %d wrong IDs, %d readings where no marker is. The "
        "published method answers nearly every frame, so that it also reads furniture, and markers that the "
        "border cuts; at the wheel that costs it laps."
        % (
            sum(entry["seconds"] for entry in ours) / 3600,
            sum(wire["frames"] for wire in wires),
            sum(wire["other"] + wire["cut_wrong"] for wire in wires),
            sum(wire["false"] for wire in wires),
        ),
        "",
        "From the exposure to the last byte on the line: %.0f ms for capture and detection (below), and "
        "%.1f ms for the %d bytes of one marker and the pose at %d baud."
        % (1000 * LATENCY_S, line_ms, frame_size(m.MARKER) + frame_size(m.POSE), BAUD),
        "",
    ]


def write_report(path, scores, surveyed=None):
    """Writes the report of these scores, with the pictures that lie beside it; surveyed: of
    reproduce_survey."""
    beside = "" if (path.parent / "method_votes.png").exists() else "../"
    lines = ["# The published experiment, driven again", ""]
    lines += [
        "Three values with slashes are median / 95th percentile / maximum. Frames are rendered; the firmware "
        "runs on %s; commands go through a model of a two-wheeled vehicle. Nothing here was measured on a "
        "physical board." % " and ".join(sorted({entry["on"] for entry in scores})),
        "",
        "## Tables 1 to 3",
        "",
        "Of the publication's tables only the rates of correct IDs are repeated here: 92 % cloudy, 96 % "
        "sunny, 93 % at double speed, at 2.8 frames/s. What they are shares of is not known here. Below, "
        '"with a marker" counts the frames that show one wholly, to the end of its orientation line; shares '
        "are of these.",
        "",
    ]
    lines += published_tables(scores)
    driven = [*PUBLISHED, *(name + CODED for name in PUBLISHED)]
    lines += ["## The drives", "", *drive_table(scores, driven), "## Beyond", ""]
    lines += drive_table(scores, BEYOND)
    lines += [
        '"Pose regained": from a push until the pose is tracked again within 50 mm. "Route regained": from a '
        "push until the next marker is left; without pushes, the time between two markers left that do not "
        "follow each other in the route.",
        "",
        "The last row is driven with settings that are off by as much as a good calibration may leave, and "
        "that say so. In all others settings and map are exact: the parts of sigma that stand for their "
        "errors have no error to answer for, and errors are small beside it.",
        "",
        *_totals(scores),
        *(section(surveyed) if surveyed else []),
        "## What was assumed where the publication is silent",
        "",
    ]
    lines += ["- %s" % text for text in ASSUMED]
    lines += [
        "- the published method itself: see the head of shared/larics/paper.py, which also names where the "
        "publication contradicts itself (the outer radius, N, the angle between coding lines)",
        "",
        "## Pictures",
        "",
        "The published method on one frame: votes for the centre (its figures 4 and 5) and the sums "
        "H(alpha) from which it reads direction and bits (figure 7).",
        "",
        "![Votes](%smethod_votes.png)" % beside,
        "",
        "![H(alpha)](%smethod_bits.png)" % beside,
        "",
    ]
    for entry in scores:
        names = ["%s-%s.png" % (entry["condition"], entry["driver"])]
        if entry["driver"] == "larics":
            names.append("strip-%s.jpg" % entry["condition"])
        for name in names:
            if (path.parent / name).exists():
                lines += ["![%s](%s)" % (entry["summary"], name), ""]
    path.write_text("\n".join(lines), encoding="utf-8")
