"""The bench's figures."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (the backend comes first)
import numpy as np  # noqa: E402
from matplotlib.ticker import LogLocator, NullLocator  # noqa: E402

from . import methods  # noqa: E402

_COLOURS = {
    "larics": "#0b5fa5",
    "paper": "#8a8a8a",
    "aruco": "#f0b46c",
    "aruco_subpix": "#d97b1a",
    "apriltag": "#2e8b57",
    "apriltag2": "#93c9a8",
    "hough": "#b06ab3",
}
_STYLE = {"paper": ":"}


def _save(figure, path):
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return path


def _plain(value, position):
    return "%g" % value


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
    error.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    error.yaxis.set_major_formatter(_plain)
    error.yaxis.set_minor_locator(NullLocator())
    error.set_title("%s: centre error" % title, fontsize=10)
    for axes in (rate, error):
        axes.set_xlabel(axis)
        if values[0] > 0 and values[-1] >= 10 * values[0]:
            axes.set_xscale("log")
            axes.set_xticks(values, ["%g" % value for value in values])
            axes.xaxis.set_minor_locator(NullLocator())
        axes.grid(alpha=0.3)
    rate.legend(fontsize=8)
    return _save(figure, path)


def quality(results, path):
    """By preset: bars of detected and wrong IDs, centre and heading error as median with a line to the 95th
    percentile. results: {preset: {method: row}}."""
    names = list(next(iter(results.values())))
    figure, axes = plt.subplots(4, 1, figsize=(1.6 + 1.3 * len(results), 12), sharex=True)
    width = 0.85 / len(names)
    for i, name in enumerate(names):
        look = dict(color=_COLOURS[name], label=methods.label(name))
        places = np.arange(len(results)) + (i - (len(names) - 1) / 2) * width
        rows = [results[preset][name] for preset in results]
        axes[0].bar(places, _values(rows, "detected_pct"), width, **look)
        axes[1].bar(places, _values(rows, "wrong_pct"), width, **look)
        for panel, key in ((axes[2], "centre_%s_px"), (axes[3], "heading_%s_deg")):
            median, p95 = (np.array(_values(rows, key % part)) for part in ("median", "p95"))
            panel.errorbar(
                places, median, [np.zeros_like(median), p95 - median], fmt="o", markersize=4, **look
            )
    texts = (
        "detected, %",
        "wrong IDs, %",
        "centre error, median to p95, px",
        "heading error, median to p95, deg",
    )
    for panel, text in zip(axes, texts, strict=True):
        panel.set_ylabel(text, fontsize=9)
        panel.grid(axis="y", alpha=0.3)
    for panel in axes[2:]:
        panel.set_yscale("log")
        panel.yaxis.set_major_formatter(_plain)
    axes[0].set_ylim(0, 105)
    axes[1].set_ylim(0, max(1.0, axes[1].get_ylim()[1]))
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
    axes.margins(x=0.35)
    return _save(figure, path)
