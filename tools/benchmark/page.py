"""The bench's figures in docs: stress.md has plots and tables of the sweeps and what the blur-model reader
costs, peers.md has what each method makes of each preset.

The text of the pages is written by hand; a part between "<!-- NAME:begin -->" and "<!-- NAME:end -->" is
replaced when the run holds what it shows.
"""

from PIL import Image

from . import evaluate, methods, plan, targets

_READ_PCT = 90  # of the IDs, for a size to count as read
_COLOURS = 64  # of a plot, which is smaller so and looks the same


def write(results, plots, folder):
    """Brings the pages in `folder` (a Path) up to date with `results`; plots of the sweeps lie in the folder
    `plots`.

    The pictures are put beside the pages. Returns the names of the parts that were written. ValueError when
    a page lacks the marks of one."""
    stress, peers = {}, {}
    if "sweeps" in results:
        stress["targets"] = _targets(targets.stresses(results["sweeps"]))
        stress["sweeps"] = _sweeps(results)
        for key in results["sweeps"]:
            _copy_small(plots / ("sweep_%s.png" % key), folder / ("stress_%s.png" % key))
        if "radius" in results["sweeps"]:
            peers["sizes"] = _sizes(results["sweeps"]["radius"])
    if "risk" in results:
        stress["margins"] = _margins(results["risk"])
    if "micropython" in results:
        costs = results["micropython"]
        stress["costs"] = _costs(targets.second_opinion(costs.get("given") or costs["unix"]))
    if "quality" in results:
        peers["quality"] = _quality(results)
    for name, parts in (("stress.md", stress), ("peers.md", peers)):
        if parts:
            text = (folder / name).read_text(encoding="utf-8")
            for part, lines in parts.items():
                text = _replaced(text, part, "\n".join(lines))
            (folder / name).write_text(text, encoding="utf-8")
    return [*stress, *peers]


def _replaced(text, name, content):
    begin, end = "<!-- %s:begin -->" % name, "<!-- %s:end -->" % name
    head, begin_found, rest = text.partition(begin)
    _, end_found, tail = rest.partition(end)
    if not begin_found or not end_found:
        raise ValueError("the marks %s and %s are missing" % (begin, end))
    return "%s%s\n\n%s\n\n%s%s" % (head, begin, content, end, tail)


def _copy_small(source, target):
    with Image.open(source) as image:
        image.convert("RGB").quantize(_COLOURS, dither=Image.Dither.NONE).save(target, optimize=True)


def _table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(str(cell) for cell in line) + " |" for line in lines]


def _targets(rows):
    cells = [
        (row.label.partition(":")[0], "%.1f" % row.value, row.wrong, row.frames, row.verdict())
        for row in rows
    ]
    return _table(("stress", "found, %", "wrong", "frames", ""), cells)


def _sweeps(results):
    lines = []
    for key, measured in results["sweeps"].items():
        sweep, rows_of = plan.SWEEPS[key], measured["methods"]
        count = next(iter(rows_of.values()))[0]["frames"]
        head = (sweep.axis, *("%g" % value for value in measured["values"]))
        rows = [(methods.label(name), *map(_cell, rows)) for name, rows in rows_of.items()]
        lines += [
            "## %s" % sweep.title,
            "",
            "![%s: found, wrong IDs and centre error](stress_%s.png)" % (sweep.title, key),
            "",
            "Found / read, %%; %d frames of `%s` a point%s." % (
                count, sweep.preset,
                ", LARICS set to allow the tilt of each (`max_tilt_deg`)" if sweep.tells_tilt else "",
            ),
            "",
            *_table(head, rows),
            "",
        ]  # fmt: skip
    return lines[:-1]


def _quality(results):
    """What a buyer compares: IDs read and wrong reports, then errors, by preset and method."""
    rows_of = results["quality"]
    drawn = {p: rows for p, rows in rows_of.items() if p not in evaluate.NEGATIVES}
    names = [name for name in next(iter(drawn.values())) if name not in methods.WITHOUT_ID]
    labels = [methods.label(name) for name in names]
    frames = next(iter(next(iter(drawn.values())).values()))["frames"]
    lines = [
        "IDs read, %%, of %d frames each; in brackets: wrong IDs and detections where no marker is." % frames,
        "",
    ]
    body = [(preset, *(_read_cell(rows[name]) for name in names)) for preset, rows in drawn.items()]
    body += [
        (
            "%s, %d frames" % (p, rows[names[0]]["frames"]),
            *("(%d)" % rows[n]["false_positives"] for n in names),
        )
        for p, rows in rows_of.items()
        if p in evaluate.NEGATIVES
    ]
    lines += [*_table(("preset", *labels), body), ""]
    for what, unit, median, p95 in (
        ("centre", "px", "centre_median_px", "centre_p95_px"),
        ("heading", "degrees", "heading_median_deg", "heading_p95_deg"),
    ):
        body = [
            (preset, *(_error_cell(rows[name], median, p95) for name in names))
            for preset, rows in drawn.items()
        ]
        lines += [
            "Error of the %s, median / 95 %%, %s." % (what, unit),
            "",
            *_table(("preset", *labels), body),
            "",
        ]
    return lines[:-1]


def _read_cell(row):
    wrong = row["wrong"] + row["false_positives"]
    return "%.1f" % row["read_pct"] + (" (%d)" % wrong if wrong else "")


def _error_cell(row, median, p95):
    return "-" if row[median] is None else "%.3f / %.3f" % (row[median], row[p95])


def _sizes(measured):
    """The smallest ring at which a method still reads nine of ten."""
    rows = []
    for name, by_value in measured["methods"].items():
        read = [
            value
            for value, row in zip(measured["values"], by_value, strict=True)
            if row["read_pct"] >= _READ_PCT
        ]
        rows.append((methods.label(name), "%g" % min(read) if read else "-"))
    return _table(("", "smallest outer ring read in 90 %, px"), rows)


def _cell(row):
    found, read = "%.1f" % row["detected_pct"], "%.1f" % row["read_pct"]
    wrong = row["wrong"] + row["false_positives"]
    return (found if read == found else found + " / " + read) + (" (%d)" % wrong if wrong else "")


def _margins(risk):
    rows = [(limit, "%.1f" % read, wrong) for limit, read, wrong in risk["least"]]
    return _table(("`margin_min`", "read, %", "wrong IDs of %d" % risk["markers"]), rows)


def _costs(added):
    unit = {"Minsn": "million instructions", "ms": "ms"}[next(iter(added.values()))["unit"]]
    rows = []
    for job, row in added.items():
        cost = ("%.1f" % row["median"], "%.1f" % row["max"]) if row["asked"] else ("-", "-")
        asked = "%d of %d" % (row["asked"], row["frames"])
        memory = " / ".join("%.1f" % (size / 1024) for size in row["memory"])
        rows.append((job, asked, *cost, "%d / %d" % row["found"], memory))
    head = ("frames", "asked in", "median, " + unit, "most", "found off / on", "memory off / on, KiB")
    return _table(head, rows)
