"""Detections against truth: which belong together, and the rates and errors that follow."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

FULLY_VISIBLE = 0.999  # share of the outer ring inside the frame from which a miss counts


class Found(NamedTuple):
    """A detection of any method, in the units of the truth table."""

    marker_id: int | None  # None: the method reports a pose but no certain ID
    x_px: float
    y_px: float
    heading_deg: float | None  # None: the method has no heading
    margin: int = 0
    flags: tuple = ()


class Expected(NamedTuple):
    """The part of a rendered marker's truth that scoring needs."""

    marker_id: int | None
    x_px: float
    y_px: float
    heading_deg: float | None
    radius_px: float
    visible: float


def match(truths: Sequence[Expected], founds: Sequence[Found]) -> list[tuple[int, int]]:
    """Pairs (truth index, found index), nearest first, each used once, centres within half a radius."""
    distances = sorted(
        (np.hypot(found.x_px - truth.x_px, found.y_px - truth.y_px), i, j)
        for i, truth in enumerate(truths)
        for j, found in enumerate(founds)
        if np.hypot(found.x_px - truth.x_px, found.y_px - truth.y_px) <= truth.radius_px / 2
    )
    pairs, used_truths, used_founds = [], set(), set()
    for _, i, j in distances:
        if i not in used_truths and j not in used_founds:
            used_truths.add(i)
            used_founds.add(j)
            pairs.append((i, j))
    return pairs


def heading_error(found_deg: float, truth_deg: float) -> float:
    """Absolute difference of two angles in degrees, 0..180."""
    return abs((found_deg - truth_deg + 180.0) % 360.0 - 180.0)


class Tally:
    """Counts and errors of one method over many frames.

    A marker counts as detected when its pose is reported, with or without an ID. A wrong ID is a certain
    ID that differs from the truth. Markers cut off by the border need not be found, but an ID reported
    for one is scored like any other. A detection that belongs to no marker is a false positive.
    """

    def __init__(self) -> None:
        self.frames = self.markers = self.cut = self.detected = self.read = 0
        self.wrong = self.uncertain = self.false_positives = 0
        self.centre_px: list[float] = []
        self.heading_deg: list[float] = []
        self.margins: list[tuple[int, bool]] = []  # (margin, ID is right) of each certain detection
        self.misses: list[Hashable] = []  # keys of the frames with a missed marker
        self.wrongs: list[Hashable] = []
        self.false_keys: list[Hashable] = []

    def add(self, truths: Sequence[Expected], founds: Sequence[Found], key: Hashable = None) -> None:
        """Scores one frame; `key` names it in the lists of failures."""
        self.frames += 1
        pairs = match(truths, founds)
        matched = {i for i, _ in pairs}
        missed = False
        for i, truth in enumerate(truths):
            if truth.visible >= FULLY_VISIBLE:
                self.markers += 1
                missed |= i not in matched
            else:
                self.cut += 1
        if missed:
            self.misses.append(key)
        for i, j in pairs:
            truth, found = truths[i], founds[j]
            whole = truth.visible >= FULLY_VISIBLE
            self.detected += whole
            self.centre_px.append(float(np.hypot(found.x_px - truth.x_px, found.y_px - truth.y_px)))
            if found.heading_deg is not None and truth.heading_deg is not None:
                self.heading_deg.append(heading_error(found.heading_deg, truth.heading_deg))
            if found.marker_id is None:
                self.uncertain += 1
                continue
            right = found.marker_id == truth.marker_id
            self.margins.append((found.margin, right))
            if right:
                self.read += whole
            else:
                self.wrong += 1
                self.wrongs.append(key)
        if len(founds) > len(pairs):
            self.false_positives += len(founds) - len(pairs)
            self.false_keys.append(key)

    def merge(self, other: Tally) -> None:
        """Adds another tally to this one."""
        for name, value in vars(other).items():
            setattr(self, name, getattr(self, name) + value)

    def row(self) -> dict[str, Any]:
        """Rates and errors as a dictionary; None where nothing was measured.

        Rates are per cent of the whole markers, that of wrong IDs of all markers."""
        return {
            "frames": self.frames,
            "markers": self.markers,
            "detected_pct": _share(self.detected, self.markers),
            "read_pct": _share(self.read, self.markers),
            "wrong": self.wrong,
            "wrong_pct": _share(self.wrong, self.markers + self.cut),
            "uncertain": self.uncertain,
            "false_positives": self.false_positives,
            "centre_median_px": _percentile(self.centre_px, 50),
            "centre_p95_px": _percentile(self.centre_px, 95),
            "heading_median_deg": _percentile(self.heading_deg, 50),
            "heading_p95_deg": _percentile(self.heading_deg, 95),
        }


def _share(part, whole):
    return 100.0 * part / whole if whole else None


def _percentile(values, percent):
    return float(np.percentile(values, percent)) if values else None


def risk_by_margin(margins: Iterable[tuple[int, bool]], edges: Sequence[int]) -> list[tuple[int, int, int]]:
    """(lower edge, detections, wrong IDs) for each bin of margin between neighbouring `edges`."""
    rows = []
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        inside = [right for margin, right in margins if low <= margin < high]
        rows.append((low, len(inside), len(inside) - sum(inside)))
    return rows


def by_least_margin(
    margins: Iterable[tuple[int, bool]], markers: int, limits: Iterable[int]
) -> list[tuple[int, float, int]]:
    """What a least margin trades: (limit, IDs read in % of `markers`, wrong IDs) for each of the limits."""
    rows = []
    for limit in limits:
        kept = [right for margin, right in margins if margin >= limit]
        rows.append((limit, 100.0 * sum(kept) / markers, len(kept) - sum(kept)))
    return rows


def ordering(margins: Sequence[tuple[int, bool]]) -> float | None:
    """Chance that a wrong detection has a smaller margin than a right one (ties count half).

    1.0: margin orders detections by risk perfectly, 0.5: it says nothing; None without both kinds."""
    right = np.array([margin for margin, good in margins if good])
    wrong = np.array([margin for margin, good in margins if not good])
    if not len(right) or not len(wrong):
        return None
    below = (wrong[:, None] < right[None, :]).sum() + 0.5 * (wrong[:, None] == right[None, :]).sum()
    return float(below / (len(right) * len(wrong)))
