"""The bench's figures in docs/stress.md: plots of the sweeps, tables, what the blur-model reader costs.

The text of the page is written by hand; a part between "<!-- NAME:begin -->" and "<!-- NAME:end -->" is
replaced when the run holds what it shows.
"""

from PIL import Image

from . import methods, plan, targets

_COLOURS = 64  # of a plot, which is smaller so and looks the same


def write(results, plots, page):
    """Brings `page` (its Path) up to date with `results`; plots of the sweeps lie in the folder `plots`.

    The pictures are put beside the page. Returns the names of the parts that were written. ValueError when
    the page lacks the marks of one."""
    parts = {}
    if "sweeps" in results:
        parts["targets"] = _targets(targets.stresses(results["sweeps"]))
        parts["sweeps"] = _sweeps(results)
        for key in results["sweeps"]:
            _copy_small(plots / ("sweep_%s.png" % key), page.with_name("stress_%s.png" % key))
    if "risk" in results:
        parts["margins"] = _margins(results["risk"])
    if "micropython" in results:
        costs = results["micropython"]
        parts["costs"] = _costs(targets.second_opinion(costs.get("given") or costs["unix"]))
    text = page.read_text(encoding="utf-8")
    for name, lines in parts.items():
        text = _replaced(text, name, "\n".join(lines))
    page.write_text(text, encoding="utf-8")
    return list(parts)


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
