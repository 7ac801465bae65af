"""The bench's figures."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (the backend comes first)

from . import methods  # noqa: E402

_COLOURS = {
    "larics": "#0b5fa5",
    "larics_sharp": "#7fb2dd",
    "paper": "#8a8a8a",
    "aruco": "#f0b46c",
    "aruco_subpix": "#d97b1a",
    "apriltag": "#2e8b57",
    "apriltag2": "#93c9a8",
    "hough": "#b06ab3",
}
_STYLE = {"larics_sharp": "--", "paper": ":"}


def _save(figure, path):
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return path


def _values(rows, key):
    return [float("nan") if row[key] is None else row[key] for row in rows]


def sweep(title, axis, values, rows_of, path):
    """Detected share and centre error over one condition; wrong IDs are written beside the points.

    rows_of: {method: one Tally.row() for each value}."""
    figure, (rate, error) = plt.subplots(1, 2, figsize=(11, 4.2))
    for name, rows in rows_of.items():
        look = dict(color=_COLOURS[name], linestyle=_STYLE.get(name, "-"), marker="o", markersize=4)
        detected = _values(rows, "detected_pct")
        rate.plot(values, detected, label=methods.label(name), **look)
        for value, share, row in zip(values, detected, rows, strict=True):
            if row["wrong"]:
                rate.annotate(
                    "%d" % row["wrong"], (value, share), color="crimson", fontsize=8,
                    textcoords="offset points", xytext=(3, 4),
                )  # fmt: skip
        error.plot(values, _values(rows, "centre_median_px"), label=methods.label(name), **look)
    rate.set_ylabel("detected, %")
    rate.set_ylim(-3, 105)
    rate.set_title("%s: detected (red: number of wrong IDs)" % title, fontsize=10)
    error.set_ylabel("centre error, median, px")
    error.set_yscale("log")
    error.set_title("%s: centre error" % title, fontsize=10)
    for axes in (rate, error):
        axes.set_xlabel(axis)
        axes.grid(alpha=0.3)
    rate.legend(fontsize=8)
    return _save(figure, path)


def quality(results, path):
    """Bars by preset: detected, wrong IDs, centre and heading error. results: {preset: {method: row}}."""
    names = list(next(iter(results.values())))
    panels = (
        ("detected_pct", "detected, %", False),
        ("wrong_pct", "wrong IDs, %", False),
        ("centre_p95_px", "centre error, 95th percentile, px", True),
        ("heading_p95_deg", "heading error, 95th percentile, deg", True),
    )
    figure, axes = plt.subplots(4, 1, figsize=(1.6 + 1.3 * len(results), 12), sharex=True)
    width = 0.85 / len(names)
    for panel, (key, text, logarithmic) in zip(axes, panels, strict=True):
        for i, name in enumerate(names):
            places = [x + (i - (len(names) - 1) / 2) * width for x in range(len(results))]
            rows = [results[preset][name] for preset in results]
            panel.bar(places, _values(rows, key), width, color=_COLOURS[name], label=methods.label(name))
        panel.set_ylabel(text, fontsize=9)
        panel.grid(axis="y", alpha=0.3)
        if logarithmic:
            panel.set_yscale("log")
    axes[0].set_ylim(0, 105)
    axes[0].legend(fontsize=8, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    axes[-1].set_xticks(range(len(results)), list(results), rotation=20)
    return _save(figure, path)


def risk(rows, order, path):
    """Wrong-ID rate and number of detections over margin. rows: (lower edge, detections, wrong)."""
    figure, (rate, count) = plt.subplots(2, 1, figsize=(7, 6), sharex=True)
    lows = [low for low, _, _ in rows]
    width = (lows[1] - lows[0]) * 0.9 if len(lows) > 1 else 1
    shares = [100.0 * wrong / total if total else float("nan") for _, total, wrong in rows]
    rate.bar(lows, shares, width, align="edge", color="crimson")
    rate.set_ylabel("wrong IDs, %")
    title = "no wrong ID" if order is None else "a wrong ID has the smaller margin in %.0f %%" % (100 * order)
    rate.set_title("Risk by margin: " + title, fontsize=10)
    count.bar(lows, [total for _, total, _ in rows], width, align="edge", color=_COLOURS["larics"])
    count.set_yscale("symlog")
    count.set_ylabel("detections with an ID")
    count.set_xlabel("margin")
    for axes in (rate, count):
        axes.grid(alpha=0.3)
    return _save(figure, path)


def times(by_method, path):
    """Median time a frame on the host. by_method: {method: (ms, ratio)}."""
    figure, axes = plt.subplots(figsize=(8, 0.6 + 0.5 * len(by_method)))
    names = sorted(by_method, key=lambda name: -by_method[name][0])
    bars = axes.barh(
        [methods.label(name) for name in names],
        [by_method[name][0] for name in names],
        color=[_COLOURS[name] for name in names],
    )
    axes.bar_label(bars, ["%.2f ms (x %.2f)" % by_method[name] for name in names], padding=4, fontsize=9)
    axes.set_xlabel("ms a frame, median, one thread (ratio to ours)")
    axes.margins(x=0.25)
    return _save(figure, path)
