"""The bench's figures."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402 (the backend comes first)
import numpy as np  # noqa: E402
from matplotlib.ticker import LogLocator, NullLocator  # noqa: E402

from . import methods  # noqa: E402

_COLOURS = {
    "larics": "#0b5fa5",
    "larics_sharp": "#0b5fa5",
    "larics_coded": "#c2407a",
    "paper": "#8a8a8a",
    "aruco": "#f0b46c",
    "aruco_subpix": "#d97b1a",
    "apriltag": "#2e8b57",
    "apriltag2": "#93c9a8",
    "hough": "#b06ab3",
}
_WRONG_PCT = (0, 0.2, 1, 5, 20, 100)  # ticks
_PAD = 16  # of a title above other words
_LINE = dict(marker="o", markersize=4)
_STYLE = {  # what differs from _LINE; before and after have one colour
    "larics": dict(zorder=4),
    "larics_sharp": dict(linestyle="--", markersize=8, markerfacecolor="none", zorder=3),
    "larics_coded": dict(marker="s"),
    "paper": dict(linestyle=":"),
    "apriltag": dict(marker="^", markersize=5),
}


def _save(figure, path, room_below=0.0):
    figure.tight_layout(rect=(0, room_below, 1, 1))
    figure.savefig(path, dpi=110)
    plt.close(figure)
    return path


def _plain(value, position):
    return "%g" % value


def _values(rows, key):
    return [float("nan") if row[key] is None else row[key] for row in rows]


def sweep(condition, rows_of, path):
    """Detected share, wrong reports and centre error over one condition.

    condition: plan.Sweep; rows_of: {method: one Tally.row() for each value}."""
    figure, (rate, wrong, error) = plt.subplots(1, 3, figsize=(12.5, 3.9))
    for name, rows in rows_of.items():
        look = dict(_LINE, color=_COLOURS[name], label=methods.label(name), **_STYLE.get(name, {}))
        rate.plot(condition.values, _values(rows, "detected_pct"), **look)
        reports = [100 * (row["wrong"] + row["false_positives"]) / row["frames"] for row in rows]
        wrong.plot(condition.values, reports, **look)
        error.plot(condition.values, _values(rows, "centre_median_px"), **look)
    rate.set_title("found, %", fontsize=10, pad=_PAD)
    rate.set_ylim(-4, 104)
    wrong.set_title("wrong IDs and false positives, % of frames", fontsize=10, pad=_PAD)
    wrong.set_yscale("symlog", linthresh=_WRONG_PCT[1])  # a single one is seen beside many
    wrong.set_yticks(_WRONG_PCT, ["%g" % share for share in _WRONG_PCT])
    wrong.yaxis.set_minor_locator(NullLocator())
    wrong.set_ylim(-0.04, 130)
    error.set_title("centre error, median, px", fontsize=10, pad=_PAD)
    error.set_yscale("log")
    error.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    error.yaxis.set_major_formatter(_plain)
    error.yaxis.set_minor_locator(NullLocator())
    for text, value in (("must", condition.must), ("aim", condition.aim)):
        if value is not None:
            rate.axvline(value, color="black", linewidth=0.8, linestyle=":", zorder=0)
            rate.text(value, 105, text, fontsize=8, ha="center", va="bottom")
    for axes in (rate, wrong, error):
        axes.set_xlabel("%s: %s" % (condition.title, condition.axis))
        if condition.values[0] > 0 and condition.values[-1] >= 10 * condition.values[0]:
            axes.set_xscale("log")
        axes.set_xticks(condition.values, ["%g" % value for value in condition.values])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xlim(rate.get_xlim())
        axes.grid(alpha=0.3)
    handles, labels = rate.get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=9, ncols=len(labels), loc="lower center", frameon=False)
    return _save(figure, path, room_below=0.08)


def quality(results, path):
    """By preset: bars of detected and wrong IDs, centre and heading error as median with a line to the 95th
    percentile. results: {preset: {method: row}}."""
    names = list(next(iter(results.values())))
    figure, axes = plt.subplots(4, 1, figsize=(1.6 + 1.3 * len(results), 12), sharex=True)
    width = 0.85 / len(names)
    for i, name in enumerate(names):
        fill = dict(color=_COLOURS[name], label=methods.label(name))
        look = dict(fill)
        if name == "larics_sharp":
            fill = dict(
                facecolor="white", edgecolor=_COLOURS[name], linewidth=0, hatch="/////", label=fill["label"]
            )
            look["markerfacecolor"] = "white"
        places = np.arange(len(results)) + (i - (len(names) - 1) / 2) * width
        rows = [results[preset][name] for preset in results]
        axes[0].bar(places, _values(rows, "detected_pct"), width, **fill)
        axes[1].bar(places, _values(rows, "wrong_pct"), width, **fill)
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
