"""The bench's tables as text."""

from . import methods, targets

_COLUMNS = (
    # title, width, how a row is printed
    ("frames", 7, lambda r: "%d" % r["frames"]),
    ("detected", 9, lambda r: _number(r["detected_pct"], "%.2f%%")),
    ("read", 8, lambda r: _number(r["read_pct"], "%.2f%%")),
    ("wrong", 6, lambda r: _number(r["wrong"], "%d")),
    ("unsure", 7, lambda r: _number(r["uncertain"], "%d")),
    ("false+", 7, lambda r: "%d" % r["false_positives"]),
    ("centre med/p95", 16, lambda r: _pair(r["centre_median_px"], r["centre_p95_px"])),
    ("heading med/p95", 17, lambda r: _pair(r["heading_median_deg"], r["heading_p95_deg"])),
)
_LABEL = 40


def _number(value, form):
    return "-" if value is None else form % value


def _pair(median, p95):
    return "-" if median is None else "%.3f / %.3f" % (median, p95)


def heading(first):
    """The title line of a table of rows."""
    return first.ljust(_LABEL) + "".join(title.rjust(width) for title, width, _ in _COLUMNS)


def line(label, row):
    """One row of `Tally.row()` as text."""
    return label.ljust(_LABEL) + "".join(text(row).rjust(width) for _, width, text in _COLUMNS)


def quality(results):
    """{preset: {method: row}} as a table."""
    lines = [heading("preset / method (errors: px, deg)")]
    for preset, rows in results.items():
        for name, row in rows.items():
            if name in methods.WITHOUT_ID:
                row = dict(row, read_pct=None, wrong=None, uncertain=None)
            lines.append(line("%s  %s" % (preset, methods.label(name)), row))
        lines.append("")
    return "\n".join(lines)


def sweep(condition, rows_of):
    """Two tables by value and method: what was found, and how exactly.

    condition: plan.Sweep; rows_of: {method: one Tally.row() for each value}."""
    lines = []
    if condition.tells_tilt:
        lines += ["LARICS is told to allow the tilt of each row (max_tilt_deg); the others know no tilt.", ""]
    labels = [methods.label(name) for name in rows_of]
    widths = [max(len(label), 20) + 3 for label in labels]
    tables = (
        ("detected %, ID read %, wrong IDs + false positives", _found_cell),
        ("centre error, median and 95th percentile, px", _error_cell),
    )
    for title, cell in tables:
        lines += [title, condition.axis.ljust(15) + _cells(labels, widths)]
        for index, value in enumerate(condition.values):
            cells = [cell(rows[index]) for rows in rows_of.values()]
            lines.append(("%g" % value).ljust(15) + _cells(cells, widths))
        lines.append("")
    return "\n".join(lines[:-1])


def _cells(cells, widths):
    return "".join(cell.rjust(width) for cell, width in zip(cells, widths, strict=True))


def _found_cell(row):
    shares = "%s %6s" % (_number(row["detected_pct"], "%.1f"), _number(row["read_pct"], "%.1f"))
    return "%s %6s" % (shares, "%d+%d" % (row["wrong"], row["false_positives"]))


def _error_cell(row):
    if row["centre_median_px"] is None:
        return "-      -"
    return "%.3f  %.3f" % (row["centre_median_px"], row["centre_p95_px"])


def risk(rows, order):
    """(lower edge, detections, wrong) by margin as a table."""
    lines = ["margin from  detections   wrong  wrong %"]
    for low, total, wrong in rows:
        share = "-" if not total else "%.3f" % (100 * wrong / total)
        lines.append("%11d %11d %7d %8s" % (low, total, wrong, share))
    if order is not None:
        lines.append("a wrong ID has a smaller margin than a right one in %.1f %% of pairs" % (100 * order))
    return "\n".join(lines)


def least_margin(rows):
    """(margin_min, IDs read in %, wrong IDs) as a table."""
    lines = ["margin_min   read %   wrong"]
    lines += ["%10d %8.1f %7d" % row for row in rows]
    return "\n".join(lines)


def tracking(by_preset):
    """{preset: tracking.compare()} as a table."""
    lines = ["preset".ljust(12) + "frames  tracked  other ID   centre med/max, px   heading med/max, deg"]
    for preset, row in by_preset.items():
        lines.append(
            "%-12s%6d%9s%10d%21s%23s"
            % (
                *(preset, row["frames"], _number(row["tracked_pct"], "%.1f%%"), row["other_id"]),
                _pair(row["centre_median_px"], row["centre_max_px"]),
                _pair(row["heading_median_deg"], row["heading_max_deg"]),
            )
        )
    return "\n".join(lines)


def times(by_method):
    """{method: (ms, ratio)} as a table."""
    lines = ["method".ljust(28) + "ms a frame".rjust(12) + "ratio".rjust(9)]
    for name, (milliseconds, ratio) in by_method.items():
        lines.append(methods.label(name).ljust(28) + "%12.3f%9.2f" % (milliseconds, ratio))
    return "\n".join(lines)


def cost(by_job):
    """{job: interpreter.measure()} as tables."""
    width = max(len(job) for job in by_job) + 2
    lines = ["job".ljust(width) + "unit   frames  found     mean   median      max    memory"]
    for job, row in by_job.items():
        counts = "%-*s%-6s%7d%7d" % (width, job, row["unit"], row["frames"], row["found"])
        lines.append(
            counts + "%9.3f%9.3f%9.3f%10s" % (row["mean"], row["median"], row["max"], row["memory"] or "-")
        )
    lines += ["", *_second_opinion(targets.second_opinion(by_job))]
    job, row = next(iter(by_job.items()))
    if row["unit"] == "Minsn":  # a clock is too coarse for single kernels
        lines += ["", "%s: mean a frame by kernel (%s, calls)" % (job, row["unit"])]
        lines += ["  %-34s%8.3f%8.1f" % (name, *cost) for name, cost in row["kernels"].items()]
        rest = row["mean"] - sum(cost for cost, _ in row["kernels"].values())
        lines.append("  %-34s%8.3f" % ("everything else", rest))
    return "\n".join(lines)


def _second_opinion(added):
    """targets.second_opinion() as lines of a table."""
    width = max(len(job) for job in added) + 2
    title = "blur-model reader adds, where asked"
    yield title.ljust(width) + "unit   frames  asked   median      max   found off, on     memory off, on"
    for job, row in added.items():
        yield "%-*s%-6s%7d%7d%9s%9s%16s%19s" % (
            *(width, job, row["unit"], row["frames"], row["asked"]),
            *(_number(row["median"], "%.3f"), _number(row["max"], "%.3f")),
            *("%d, %d" % row["found"], "%d, %d" % row["memory"]),
        )


def target_table(rows):
    """A list of targets.Target as a table."""
    width = max(len(row.label) for row in rows) + 2
    lines = ["".ljust(width) + "measured     must      aim   frames"]
    for row in rows:
        text = "%-*s%8.4g%9s%9s%9s" % (
            *(width, row.label, row.value),
            *(_number(row.must, "%g"), _number(row.aim, "%g"), _number(row.frames, "%d")),
        )
        wrong = ", %d wrong" % row.wrong if row.wrong else ""
        lines.append("%s   %s%s" % (text, row.verdict(), wrong))
    return "\n".join(lines)


def comparison(before, after, path=""):
    """Every number that two result files share and that differs, as lines `path: before -> after`."""
    if isinstance(before, dict) and isinstance(after, dict):
        lines = []
        for key in before:
            if key in after:
                lines.extend(comparison(before[key], after[key], "%s / %s" % (path, key) if path else key))
        return lines
    if isinstance(before, list) and isinstance(after, list):
        if len(before) != len(after):
            return ["%s: %d -> %d values" % (path, len(before), len(after))]
        lines = []
        for i, (old, new) in enumerate(zip(before, after, strict=True)):
            lines.extend(comparison(old, new, "%s[%d]" % (path, i)))
        return lines
    if before == after or isinstance(before, str):
        return []
    return ["%s: %s -> %s" % (path, _short(before), _short(after))]


def _short(value):
    return "%.4g" % value if isinstance(value, float) else str(value)
