"""Detections against truth: rates, errors, who was taken for whom, and the frames that went worst."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from larics_host.errors import UserError
from larics_host.validation.scoring import FULLY_VISIBLE, Expected, Found, Tally, heading_error, match

if TYPE_CHECKING:
    from larics_host import truth as truth_table
    from larics_host.validation.sources import Detections


MISSED = "missed"
UNCERTAIN = "?"
NOTHING = "none"

# kinds of failure, the gravest first, as ranks for the list of worst frames
_WRONG, _FALSE, _MISSED, _UNCERTAIN, _FINE = range(5)
_WHY = ("wrong ID", "false detection", "missed", "ID uncertain", "centre error")


class Place(NamedTuple):
    """How a frame ranks among the worst: `grade` orders, `why` says what happened."""

    frame: str
    grade: tuple
    why: str


class Outcome:
    """What one method made of all frames; `truths` is {frame: list of larics_host.truth.Truth}."""

    def __init__(self, detections: Detections, truths: dict[str, list[truth_table.Truth]]) -> None:
        self.label = detections.label
        self.by_frame = detections.by_frame
        self.times_ms = detections.times_ms
        self.tally = Tally()
        self.confusion: Counter[tuple[Any, Any]] = (
            Counter()
        )  # (true ID or NOTHING, reported ID, UNCERTAIN or MISSED)
        self.places: list[Place] = []
        # (frame, true ID, which of several with that ID): right, wrong, uncertain or missed
        self.found: dict[tuple[str, int, int], str] = {}
        self.missing = [name for name in truths if name not in self.by_frame]
        for name, markers in truths.items():
            if name in self.by_frame:
                self._add(name, markers, self.by_frame[name])
        if not self.tally.frames:
            named = "".join(", such as %s" % name for name in self.missing[:1])
            raise UserError("%s has none of the frames that the truth names%s" % (self.label, named))
        self.places.sort(key=lambda place: place.grade)

    def _add(self, name, markers, dicts):
        truths = [Expected(t.id, t.x_px, t.y_px, t.heading_deg, t.radius_px, t.visible) for t in markers]
        founds = _founds(dicts)
        self.tally.add(truths, founds, name)
        pairs = dict(match(truths, founds))
        rank, worst_px = _FINE, 0.0
        repeats = Counter()
        for i, truth in enumerate(truths):
            key = (name, truth.marker_id, repeats[truth.marker_id])
            repeats[truth.marker_id] += 1
            if i not in pairs:
                if truth.visible >= FULLY_VISIBLE:
                    rank = min(rank, _MISSED)
                    self._note(key, MISSED, "missed")
                continue
            found = founds[pairs[i]]
            error_px = float(np.hypot(found.x_px - truth.x_px, found.y_px - truth.y_px))
            worst_px = max(worst_px, error_px)
            if found.marker_id is None:
                rank = min(rank, _UNCERTAIN)
                self._note(key, UNCERTAIN, "uncertain")
            elif found.marker_id == truth.marker_id:
                self._note(key, found.marker_id, "right")
            else:
                rank = _WRONG
                self._note(key, found.marker_id, "wrong")
        for j in set(range(len(founds))) - set(pairs.values()):
            rank = min(rank, _FALSE)
            reported = founds[j].marker_id
            self.confusion[NOTHING, UNCERTAIN if reported is None else reported] += 1
        why = _WHY[rank] if rank != _FINE else "%s %.3f px" % (_WHY[rank], worst_px)
        self.places.append(Place(name, (rank, -worst_px), why))

    def _note(self, key, reported, result):
        self.confusion[key[1], reported] += 1
        self.found[key] = result

    def worst(self, count: int) -> list[Place]:
        """The `count` worst frames, those without any marker or error left out."""
        return [place for place in self.places if place.grade != (_FINE, 0.0)][:count]

    def figures(self) -> dict[str, Any]:
        """Rates, errors and times as a JSON-able dict."""
        figures = dict(self.tally.row(), label=self.label, frames_missing=len(self.missing))
        figures["centre_max_px"] = max(self.tally.centre_px, default=None)
        figures["heading_max_deg"] = max(self.tally.heading_deg, default=None)
        figures["median_ms"] = float(np.median(self.times_ms)) if self.times_ms else None
        return figures

    def matrix(self) -> tuple[list[Any], list[Any], list[list[int]]]:
        """(true IDs, reported IDs, rows of counts) of the confusion matrix."""
        rows = sorted({truth for truth, _ in self.confusion}, key=_order)
        columns = sorted({reported for _, reported in self.confusion}, key=_order)
        return rows, columns, [[self.confusion[row, column] for column in columns] for row in rows]


def _founds(dicts):
    return [Found(d["id"], d["x"], d["y"], d["heading"], d["margin"]) for d in dicts]


def _order(name):
    return (isinstance(name, str), name)


def compare(first: Outcome, second: Outcome) -> dict[str, Any]:
    """Where two outcomes differ, as a JSON-able dict: the markers that only one read right, and by how much
    the centres and headings of those that both found differ between the two."""
    both = set(first.found) & set(second.found)
    pairs = Counter((first.found[key], second.found[key]) for key in both)
    gained = sorted(k[0] for k in both if second.found[k] == "right" != first.found[k])
    lost = sorted(k[0] for k in both if first.found[k] == "right" != second.found[k])
    apart_px, apart_deg = [], []
    for name in set(first.by_frame) & set(second.by_frame):
        a, b = (
            [Found(d["id"], d["x"], d["y"], d["heading"]) for d in o.by_frame[name]] for o in (first, second)
        )
        near = [Expected(f.marker_id, f.x_px, f.y_px, f.heading_deg, 2.0, 1.0) for f in a]  # within 1 px
        for i, j in match(near, b):
            apart_px.append(float(np.hypot(a[i].x_px - b[j].x_px, a[i].y_px - b[j].y_px)))
            ours, theirs = a[i].heading_deg, b[j].heading_deg
            if ours is not None and theirs is not None:
                apart_deg.append(heading_error(ours, theirs))
    return {
        "first": first.label,
        "second": second.label,
        "markers": [{"first": a, "second": b, "count": n} for (a, b), n in sorted(pairs.items())],
        "read_only_by_first": lost,
        "read_only_by_second": gained,
        "same_within_1px": len(apart_px),
        "apart_p95_px": float(np.percentile(apart_px, 95)) if apart_px else None,
        "apart_p95_deg": float(np.percentile(apart_deg, 95)) if apart_deg else None,
    }


class Limit(NamedTuple):
    """A threshold of the user: `figure` of Outcome.figures must not be below (`least`) or above it."""

    option: str
    figure: str
    least: bool


LIMITS = (
    Limit("--min-detected", "detected_pct", True),
    Limit("--min-read", "read_pct", True),
    Limit("--max-wrong", "wrong", False),
    Limit("--max-false", "false_positives", False),
    Limit("--max-centre-px", "centre_p95_px", False),
    Limit("--max-heading-deg", "heading_p95_deg", False),
)


def judge(figures: dict[str, Any], thresholds: dict[str, float]) -> list[dict[str, Any]]:
    """[{option, limit, value, passed}] for thresholds {option: number}; what was not measured fails."""
    judged = []
    for limit in LIMITS:
        if thresholds.get(limit.option) is None:
            continue
        wanted, value = thresholds[limit.option], figures[limit.figure]
        passed = value is not None and (value >= wanted if limit.least else value <= wanted)
        judged.append({"option": limit.option, "limit": wanted, "value": value, "passed": bool(passed)})
    return judged
