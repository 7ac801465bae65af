"""Plots by matplotlib, an optional package: figures as PNG bytes."""

from __future__ import annotations

import io
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from larics_host.errors import missing_package

if TYPE_CHECKING:
    from matplotlib.figure import Figure


COLOURS = ("#0b5fa5", "#d97b1a", "#2e8b57", "#b03060")


def new_figure(width_in: float, height_in: float) -> Figure:
    """A matplotlib Figure; UserError when matplotlib is not installed."""
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise missing_package("a plot", "matplotlib") from None
    return Figure(figsize=(width_in, height_in), layout="constrained")


def png(figure: Figure, dpi: int = 100) -> bytes:
    """The figure as the bytes of a PNG."""
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=dpi)
    return file.getvalue()


def shares(curves: Iterable[tuple[str, Sequence[float]]], label: str) -> bytes:
    """Share of the values that are at most so large, over their size on a logarithmic axis, as PNG.

    curves: [(name, values)]."""
    import numpy as np

    figure = new_figure(5.6, 3.4)
    axes = figure.subplots()
    for (name, values), colour in zip(curves, COLOURS, strict=False):
        if not len(values):
            continue
        ordered = np.maximum(np.sort(values), 1e-4)
        axes.step(ordered, 100 * np.arange(1, len(ordered) + 1) / len(ordered), label=name, color=colour)
    axes.set_xscale("log")
    axes.set_ylim(0, 100.5)
    axes.set_xlabel(label)
    axes.set_ylabel("markers with at most this error, %")
    axes.grid(True, which="major", linewidth=0.4)
    if axes.lines:
        axes.legend(loc="lower right", fontsize=8)
    return png(figure)
