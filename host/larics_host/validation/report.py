"""The report of a validation as one HTML file: pictures inside, nothing loaded from anywhere."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from larics_host import plots
from larics_host.files import write_file
from larics_host.html_page import escape, page, picture, table

if TYPE_CHECKING:
    from larics_host.annotations import StrPath
    from larics_host.validation.outcome import Outcome


_MATRIX_MOST = 24  # rows and columns that a page still shows; of more, only the mistakes
_MISTAKES_MOST = 60

# heading, figure, format
_FIGURES = (
    ("frames", "frames", "%d"),
    ("markers wholly in view", "markers", "%d"),
    ("detected", "detected_pct", "%.3f %%"),
    ("ID read right", "read_pct", "%.3f %%"),
    ("wrong IDs", "wrong", "%d"),
    ("uncertain IDs", "uncertain", "%d"),
    ("false detections", "false_positives", "%d"),
    ("centre error, median", "centre_median_px", "%.4f px"),
    ("centre error, 95 % below", "centre_p95_px", "%.4f px"),
    ("centre error, largest", "centre_max_px", "%.3f px"),
    ("heading error, median", "heading_median_deg", "%.4f deg"),
    ("heading error, 95 % below", "heading_p95_deg", "%.4f deg"),
    ("heading error, largest", "heading_max_deg", "%.3f deg"),
    ("time a frame, median, one process", "median_ms", "%.2f ms"),
    ("frames without a result", "frames_missing", "%d"),
)


def figure_rows(all_figures: Sequence[dict[str, Any]]) -> list[tuple[str, list[str]]]:
    """[(heading, text of each column)] for dicts of Outcome.figures."""
    return [
        (heading, [layout % f[name] if f[name] is not None else "-" for f in all_figures])
        for heading, name, layout in _FIGURES
    ]


def _matrix(outcome):
    rows, columns, counts = outcome.matrix()
    if max(len(rows), len(columns)) > _MATRIX_MOST:
        return _mistakes(rows, columns, counts)
    parts = ["<table><thead><tr><th>true \\ reported</th>"]
    parts += ["<th>%s</th>" % escape(column) for column in columns]
    parts.append("</tr></thead><tbody>")
    for row, line in zip(rows, counts, strict=True):
        parts.append("<tr><th>%s</th>" % escape(row))
        for column, count in zip(columns, line, strict=True):
            kind = "zero" if not count else "right" if row == column else "wrong"
            parts.append('<td class="%s">%d</td>' % (kind, count))
        parts.append("</tr>")
    return "".join(parts) + "</tbody></table>"


def _mistakes(rows, columns, counts):
    """Hundreds of IDs: how many were read right, and every pair that was taken for each other."""
    pairs = [
        (count, row, column)
        for row, line in zip(rows, counts, strict=True)
        for column, count in zip(columns, line, strict=True)
        if count
    ]
    right = [pair for pair in pairs if pair[1] == pair[2]]
    wrong = sorted((pair for pair in pairs if pair[1] != pair[2]), key=lambda pair: (-pair[0], str(pair[1:])))
    lines = [
        "<p>%d IDs: %d markers of %d IDs read right. All others, most frequent first:</p>"
        % (len(rows), sum(pair[0] for pair in right), len(right))
    ]
    shown = [(row, [column, count]) for count, row, column in wrong[:_MISTAKES_MOST]]
    lines.append(table(("true", "reported", "markers"), shown) if shown else "<p>none</p>")
    if len(wrong) > _MISTAKES_MOST:
        lines.append("<p>and %d pairs more</p>" % (len(wrong) - _MISTAKES_MOST))
    return "".join(lines)


def _comparison(result):
    lines = ["<h2>%s against %s</h2>" % (escape(result["second"]), escape(result["first"]))]
    rows = [(row["first"], [row["second"], row["count"]]) for row in result["markers"]]
    lines.append(table((result["first"], result["second"], "markers"), rows))
    for key, name in (("read_only_by_first", "first"), ("read_only_by_second", "second")):
        frames = result[key]
        text = ", ".join(frames[:40]) + (" and %d more" % (len(frames) - 40) if len(frames) > 40 else "")
        lines.append("<p>Read right only by %s: %s</p>" % (escape(result[name]), escape(text or "none")))
    if result["same_within_1px"]:
        lines.append(
            "<p>%(same_within_1px)d detections of both lie within 1 px of each other; 95 %% of them within "
            "%(apart_p95_px).4f px and %(apart_p95_deg).4f deg.</p>" % result
        )
    return "".join(lines)


def _board(result):
    lines = ["<h2>Board against this computer, message by message</h2>"]
    lines.append("<p>%s</p>" % escape(result["summary"]))
    if result["differences"]:
        rows = [
            (d["frame"], [d["index"], d["field"], d["board"], d["host"]]) for d in result["differences"][:100]
        ]
        lines.append(table(("frame", "marker", "field", "board", "here"), rows))
    return "".join(lines)


def _thresholds(judged):
    rows = "".join(
        '<tr><th>%s %g</th><td>%s</td><td class="%s">%s</td></tr>'
        % (
            escape(one["option"]),
            one["limit"],
            "-" if one["value"] is None else "%.5g" % one["value"],
            "passed" if one["passed"] else "failed",
            "passed" if one["passed"] else "FAILED",
        )
        for one in judged
    )
    return "<h2>Thresholds</h2><table><tbody>%s</tbody></table>" % rows


def write_report(
    path: StrPath,
    title: str,
    note: str,
    outcomes: Sequence[Outcome],
    judged: Sequence[dict[str, Any]] = (),
    comparison: dict[str, Any] | None = None,
    board: dict[str, Any] | None = None,
    pictures: Iterable[tuple[bytes, str]] = (),
) -> None:
    """Writes the HTML file.

    outcomes   list of Outcome;  judged  of outcome.judge;  comparison  of outcome.compare
    board      of board.compare_messages;  pictures  [(JPEG bytes, caption)] of the worst frames
    UserError when it cannot be written, and without matplotlib.
    """
    parts = ["<h1>%s</h1><p class=note>%s</p>" % (escape(title), escape(note))]
    if judged:
        parts.append(_thresholds(judged))
    if outcomes:
        parts.append("<h2>Rates and errors</h2>")
        parts.append(table(["", *(o.label for o in outcomes)], figure_rows([o.figures() for o in outcomes])))
        centre = [(o.label, o.tally.centre_px) for o in outcomes]
        heading = [(o.label, o.tally.heading_deg) for o in outcomes]
        parts.append('<h2>Errors</h2><div class="pictures">')
        parts.append(picture(plots.shares(centre, "centre error, px"), "png", ""))
        parts.append(picture(plots.shares(heading, "heading error, deg"), "png", ""))
        parts.append("</div>")
    for outcome in outcomes:
        parts.append("<h2>Who was taken for whom: %s</h2>%s" % (escape(outcome.label), _matrix(outcome)))
    if comparison:
        parts.append(_comparison(comparison))
    if board:
        parts.append(_board(board))
    if pictures:
        parts.append(
            "<h2>Worst frames</h2><p class=note>green: detected; amber: ID uncertain; blue: true</p>"
        )
        parts.append('<div class="pictures">%s</div>' % "".join(picture(d, "jpeg", c) for d, c in pictures))
    write_file(path, page(title, "".join(parts)))
