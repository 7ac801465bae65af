"""Tables as text."""

_COLUMNS = (
    # title, width, how a row is printed
    ("frames", 7, lambda r: "%d" % r["frames"]),
    ("detected", 9, lambda r: _number(r["detected_pct"], "%.2f%%")),
    ("read", 8, lambda r: _number(r["read_pct"], "%.2f%%")),
    ("wrong", 6, lambda r: "%d" % r["wrong"]),
    ("unsure", 7, lambda r: "%d" % r["uncertain"]),
    ("false+", 7, lambda r: "%d" % r["false_positives"]),
    ("centre med/p95", 16, lambda r: _pair(r["centre_median_px"], r["centre_p95_px"])),
    ("heading med/p95", 17, lambda r: _pair(r["heading_median_deg"], r["heading_p95_deg"])),
)
_LABEL = 34


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
