"""How margins and lengths of rings change over the time of the logs, and what a vehicle's markers have in
common in it: so that neither a faint marker makes its vehicles suspect nor a dirty lens the markers."""

from __future__ import annotations

import datetime
import math
import statistics
from collections import defaultdict
from collections.abc import Mapping
from typing import NamedTuple

from larics_host.fleet.tally import NO_DATE, Tally

_READINGS = 30  # that a mean rests on at least
_PERIODS = 4  # that a trend rests on at least
MARKERS = 3  # that must agree before a vehicle is suspect

Means = dict[str, dict[int, dict[str, tuple[float, int]]]]
Points = list[tuple[str, float, int]]  # (period, mean, readings)


class Trend(NamedTuple):
    """A straight line through means of periods: first and last value, and how sure its slope is."""

    first: float
    last: float
    sure: float

    @property
    def change(self) -> float:
        return self.last - self.first


def trend(points: Points) -> Trend | None:
    """Of [(period, mean, readings)]; None with too few. All periods weigh alike."""
    points = [point for point in sorted(points) if point[0] != NO_DATE and point[2] >= _READINGS]
    if len(points) < _PERIODS:
        return None
    hours = [_hours(point[0]) for point in points]
    values = [point[1] for point in points]
    mean_h, mean = statistics.fmean(hours), statistics.fmean(values)
    spread = sum((h - mean_h) ** 2 for h in hours)
    slope = sum((h - mean_h) * (v - mean) for h, v in zip(hours, values, strict=True)) / spread
    first, last = (mean + slope * (h - mean_h) for h in (hours[0], hours[-1]))
    rest = sum((v - mean - slope * (h - mean_h)) ** 2 for h, v in zip(hours, values, strict=True))
    error = math.sqrt(rest / (len(points) - 2) / spread)
    return Trend(first, last, abs(slope) / error if error else math.inf if slope else 0.0)


def _hours(period):
    return datetime.datetime.fromisoformat(period + (":00" if len(period) > 10 else "")).timestamp() / 3600


def means_of(tallies: Mapping[str, Tally], item: int, unit: float) -> Means:
    """{vehicle: {marker: {period: (mean, count)}}} of an item of the readings over `unit`; means of few are
    left out."""
    means: Means = {}
    for vehicle, tally in tallies.items():
        by_marker = means.setdefault(vehicle, defaultdict(dict))
        for (marker, period), sums in sorted(tally.readings.items()):
            if sums[0] >= _READINGS:
                by_marker[marker][period] = sums[item] / sums[0] / unit, sums[0]
    return means


def _mean_of(periods):
    return statistics.fmean(mean for mean, _ in periods.values())


def common_to(means: Means, vehicle: str, relative: bool) -> Points:
    """[(period, what most markers deviate by from their own mean in it, readings)] of a vehicle."""
    by_period = defaultdict(list)
    for periods in means[vehicle].values():
        usual = _mean_of(periods)
        for period, (mean, count) in periods.items():
            by_period[period].append((mean / usual - 1 if relative and usual else mean - usual, count))
    return [
        (period, statistics.median(value for value, _ in values), sum(count for _, count in values))
        for period, values in sorted(by_period.items())
        if len(values) >= MARKERS
    ]


def without_lens(marker: int, means: Means, lens: Mapping[str, Points]) -> Points:
    """[(period, margin of a marker without what its vehicles' other markers have in common, readings)]."""
    by_period = defaultdict(list)
    for vehicle, by_marker in means.items():
        common = {period: value for period, value, _ in lens[vehicle]}
        for period, (mean, count) in by_marker.get(marker, {}).items():
            by_period[period].append((mean - common.get(period, 0.0), count))
    found = []
    for period, values in sorted(by_period.items()):
        count = sum(n for _, n in values)
        found.append((period, sum(value * n for value, n in values) / count, count))
    return found
