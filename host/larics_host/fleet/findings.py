"""From the tallies of all vehicles: a row for each vehicle and each marker, and what is wrong with them.

Margins, radii and distances are compared with what the same marker, the same pair or the same vehicle had
before and has elsewhere, so that neither a faint marker makes its vehicles suspect nor a dirty lens the
markers. The numbers behind each finding are in the tables.
"""

from __future__ import annotations

import datetime
import math
import statistics
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from larics.wire import messages as m
from larics_host.fleet.tally import NO_DATE, Tally
from larics_host.fleet.track import Landmark
from larics_host.mapping.links import wrapped
from larics_host.wire_names import ENUMS
from larics_host.wording import counted

_READINGS = 30  # that a mean rests on at least
_PERIODS = 4  # that a trend rests on at least
_SURE = 4.0  # standard errors
_MARGIN_SHARE, _MARGIN = 0.15, 8.0  # fall over the time of the logs
_LENGTH_SHARE = 0.01  # change of the scale of a calibration
_MARKERS = 3  # that must agree before a vehicle is suspect
_MOVED_MM, _MOVED_DEG = 50.0, 3.0
_LEAST_OFFS = 3
_WRONG_LEAST = 3
_WRONG_SHARE = 0.001  # of the readings of a plate
_LOST_SHARE = 0.01
_FRAMES_LEAST, _ALIKE_SHARE = 10, 0.9  # of recorded frames, that read as they were reported


KINDS = (
    "wrong ID",
    "moved marker",
    "not as the map",
    "not as its frames",
    "worn or dirty marker",
    "dirty lens",
    "calibration",
    "fault",
    "line",
)


class Finding(NamedTuple):
    """kind, whom it is about (None: no one of that sort alone), a number, and a line for people."""

    kind: str
    vehicle: str | None
    marker: int | None
    value: float | None
    text: str


class Fleet(NamedTuple):
    """Rows as dicts, in the order of their names, and findings."""

    vehicles: list[dict[str, Any]]
    markers: list[dict[str, Any]]
    findings: list[Finding]


class Trend(NamedTuple):
    """A straight line through means of periods: first and last value, and how sure its slope is."""

    first: float
    last: float
    sure: float

    @property
    def change(self) -> float:
        return self.last - self.first


def trend(points: Sequence[tuple[str, float, int]]) -> Trend | None:
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


def examine(
    tallies: Mapping[str, Tally], logs: Mapping[str, int], landmarks: Sequence[Landmark] = ()
) -> Fleet:
    """The Fleet of {vehicle: Tally} and {vehicle: number of logs}."""
    findings: list[Finding] = []
    names = sorted(tallies)
    means = _means(tallies, 1, 1.0)
    radii = _means(tallies, 3, 256.0)
    lens = {vehicle: _common(means, vehicle, relative=False) for vehicle in names}
    scale = {vehicle: _common(radii, vehicle, relative=True) for vehicle in names}
    apart = _apart(tallies, landmarks)
    vehicles = [
        _vehicle(
            name, tallies[name], logs[name], trend(lens[name]), trend(scale[name]), apart.get(name), findings
        )
        for name in names
    ]
    moved = _moved(tallies, landmarks)
    markers = [
        _marker(marker, tallies, means, lens, moved, findings)
        for marker in sorted({key[0] for tally in tallies.values() for key in tally.readings})
    ]
    _wrong(tallies, findings)
    _tell_moved(moved, landmarks, findings)
    order = {kind: k for k, kind in enumerate(KINDS)}
    findings.sort(
        key=lambda one: (order[one.kind], one.vehicle or "", -1 if one.marker is None else one.marker)
    )
    return Fleet(vehicles, markers, findings)


KINDS = (
    "wrong ID",
    "moved marker",
    "not as the map",
    "not as its frames",
    "worn or dirty marker",
    "dirty lens",
    "calibration",
    "fault",
    "line",
)


def _means(tallies, item, unit):
    """{vehicle: {marker: {period: (mean, count)}}} of an item of the readings."""
    means: dict[str, dict[int, dict[str, tuple[float, int]]]] = {}
    for vehicle, tally in tallies.items():
        by_marker = means.setdefault(vehicle, defaultdict(dict))
        for (marker, period), sums in sorted(tally.readings.items()):
            if sums[0] >= _READINGS:
                by_marker[marker][period] = sums[item] / sums[0] / unit, sums[0]
    return means


def _mean_of(periods):
    return statistics.fmean(mean for mean, _ in periods.values())


def _common(means, vehicle, relative):
    """[(period, what most markers deviate by from their own mean in it, readings)] of a vehicle."""
    by_period = defaultdict(list)
    for periods in means[vehicle].values():
        usual = _mean_of(periods)
        for period, (mean, count) in periods.items():
            by_period[period].append((mean / usual - 1 if relative and usual else mean - usual, count))
    return [
        (period, statistics.median(value for value, _ in values), sum(count for _, count in values))
        for period, values in sorted(by_period.items())
        if len(values) >= _MARKERS
    ]


def _vehicle(name, tally, logs, lens, scale, apart, findings):
    total = sum(sums[0] for sums in tally.readings.values())
    margin = sum(sums[1] for sums in tally.readings.values()) / total if total else None
    messages = tally.lines - tally.damaged
    row: dict[str, Any] = {
        "vehicle": name,
        "cameras": ", ".join(sorted(tally.cameras)) or None,
        "logs": logs,
        "bytes": tally.bytes,
        "damaged_lines": tally.damaged,
        "hours": round(tally.seconds / 3600, 4),
        "frames": tally.frames,
        "rate_hz": round(tally.frames / tally.seconds, 2) if tally.seconds else None,
        "seen_pct": round(100 * tally.frames_seen / tally.frames, 3) if tally.frames else None,
        "uncertain": tally.uncertain,
        "readings": total,
        "visits": tally.visits,
        "wrong_ids": tally.wrong.total(),
        "against_the_map": tally.contradictions.total(),
        "tracking_pct": _share(tally.states[m.TRACKING], tally.told_s),
        "lost_pct": _share(tally.states[m.LOST], tally.told_s),
        "lost_messages": None if tally.mixed else tally.lost,
        "missed": tally.sums["missed"] if tally.statuses else None,
        "drops": tally.sums["drops"] if tally.statuses else None,
        "faults": tally.sums["faults"] if tally.statuses else None,
        "boots": tally.boots,
        "recorded_frames": tally.recorded,
        "recorded_alike_pct": _share(tally.recorded_alike, tally.recorded),
        "margin": None if margin is None else round(margin, 2),
        "margin_change": None if lens is None else round(lens.change, 2),
        "radius_change_pct": None if scale is None else round(100 * scale.change, 3),
        "distance_error_pct": None if apart is None else round(100 * apart[0], 3),
    }  # fmt: skip
    if lens and margin and -lens.change > max(_MARGIN, _MARGIN_SHARE * margin) and lens.sure > _SURE:
        text = "%s: the margins of most markers fall, by %.0f of %.0f: is its lens dirty or out of focus?"
        findings.append(Finding("dirty lens", name, None, lens.change, text % (name, -lens.change, margin)))
    if scale and abs(scale.change) > _LENGTH_SHARE and scale.sure > _SURE:
        text = "%s: rings of the same markers change by %+.1f %%: lens, height or calibration drifts"
        findings.append(Finding("calibration", name, None, scale.change, text % (name, 100 * scale.change)))
    if apart and abs(apart[0]) > _LENGTH_SHARE:
        text = "%s: markers are %+.1f %% farther apart than %s: calibrate it again"
        findings.append(Finding("calibration", name, None, apart[0], text % (name, 100 * apart[0], apart[1])))
    few_alike = tally.recorded >= _FRAMES_LEAST and tally.recorded_alike < _ALIKE_SHARE * tally.recorded
    if tally.conflicts or few_alike:
        text = "%s: of %s %d read here as they were reported, %d with another ID%s"
        shown = "".join(
            "; %s: told %s, here %s" % (frame, *map(_listed, ids)) for frame, *ids in tally.conflict_frames
        )
        numbers = counted(tally.recorded, "recorded frame"), tally.recorded_alike, tally.conflicts
        found = Finding("not as its frames", name, None, tally.conflicts, text % (name, *numbers, shown))
        findings.append(found)
    for code, seconds in sorted(tally.fault_seconds.items()):
        text = "%s: %s for %d s of %d" % (name, _FAULTS.get(code, "fault %d" % code), seconds, tally.told_s)
        findings.append(Finding("fault", name, None, seconds, text))
    if tally.mixed:
        findings.append(Finding("line", name, None, None, "%s: %s" % (name, tally.mixed)))
    elif messages and tally.lost > _LOST_SHARE * messages:
        text = "%s: %d messages of %d were lost on the line"
        findings.append(
            Finding("line", name, None, tally.lost, text % (name, tally.lost, messages + tally.lost))
        )
    return row


def _listed(ids):
    return " ".join(map(str, ids))


def _share(part, whole):
    return round(100 * part / whole, 3) if whole else None


_FAULTS = {number: name for group, items in ENUMS if group == "Fault" for name, number, _ in items}


def _apart(tallies, landmarks):
    """{vehicle: (share by which it sees pairs of markers too far apart, compared with what)}."""
    once = defaultdict(list)
    for landmark in landmarks:
        once[landmark.id].append(landmark)
    seen: dict[tuple[int, int], dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for vehicle, tally in sorted(tallies.items()):
        for (a, b, _), values in sorted(tally.pairs.items()):
            seen[a, b][vehicle] += values
    shares = defaultdict(list)
    for (a, b), by_vehicle in seen.items():
        known = len(once[a]) == len(once[b]) == 1
        if known:
            one, other = once[a][0], once[b][0]
            usual = math.hypot(one.x_mm - other.x_mm, one.y_mm - other.y_mm)
        elif len(by_vehicle) >= _MARKERS:
            usual = statistics.median(statistics.median(values) for values in by_vehicle.values())
        else:
            continue
        for vehicle, values in by_vehicle.items():
            if len(values) >= _LEAST_OFFS and usual:
                shares[vehicle].append(statistics.median(values) / usual - 1)
    what = "in the map" if landmarks else "for the other vehicles"
    return {
        vehicle: (statistics.median(values), what)
        for vehicle, values in shares.items()
        if len(values) >= _MARKERS
    }


def _marker(marker, tallies, means, lens, moved, findings):
    sums = [0, 0, 0, 0]
    seen_by = set()
    for vehicle, tally in tallies.items():
        for (one, _), values in tally.readings.items():
            if one == marker:
                seen_by.add(vehicle)
                sums = [a + b for a, b in zip(sums, values, strict=True)]
    wrong = sum(
        count for tally in tallies.values() for (right, _), count in tally.wrong.items() if right == marker
    )
    change = trend(_without_lens(marker, means, lens))
    margin = sums[1] / sums[0]
    offs = [one for one in moved if one.id == marker]
    row = {
        "marker": marker,
        "vehicles": len(seen_by),
        "readings": sums[0],
        "read_wrong": wrong,
        "margin": round(margin, 2),
        "margin_sigma": round(math.sqrt(max(0.0, sums[2] / sums[0] - margin * margin)), 2),
        "margin_change": None if change is None else round(change.change, 2),
        "radius_px": round(sums[3] / sums[0] / 256, 3),
        "off_mm": round(max(math.hypot(one.x_mm, one.y_mm) for one in offs), 1) if offs else None,
        "off_deg": round(max(abs(one.heading_deg) for one in offs), 2) if offs else None,
    }
    if change and -change.change > max(_MARGIN, _MARGIN_SHARE * change.first) and change.sure > _SURE:
        text = "marker %d: its margin falls from %.0f to %.0f: worn, dirty, or its light fails"
        value = text % (marker, change.first, change.last)
        findings.append(Finding("worn or dirty marker", None, marker, change.change, value))
    return row


def _without_lens(marker, means, lens):
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


def _wrong(tallies, findings):
    readings: dict[tuple[str, int], int] = defaultdict(int)
    for vehicle, tally in tallies.items():
        for (marker, _), sums in tally.readings.items():
            readings[vehicle, marker] += sums[0]
    for vehicle, tally in sorted(tallies.items()):
        for (right, read), count in sorted(tally.wrong.items()):
            if count >= max(_WRONG_LEAST, _WRONG_SHARE * readings[vehicle, right]):
                text = "%s: marker %d was read as %d, %d of %d times"
                values = vehicle, right, read, count, readings[vehicle, right] + count
                findings.append(Finding("wrong ID", vehicle, right, count, text % values))
        for (read, there), count in sorted(tally.contradictions.items(), key=str):
            if count < _WRONG_LEAST:
                continue
            if there is not None:
                text = "%s: %d was read %d times where the map has marker %d"
                finding = Finding("wrong ID", vehicle, there, count, text % (vehicle, read, count, there))
            else:
                text = "%s: marker %d was read %d times where the map has none"
                finding = Finding("not as the map", vehicle, read, count, text % (vehicle, read, count))
            findings.append(finding)


class Moved(NamedTuple):
    """A marker off its place in the map: number, ID, median over those it was seen from, how many."""

    number: int
    id: int
    x_mm: float
    y_mm: float
    heading_deg: float
    partners: int


def _moved(tallies, landmarks):
    """Markers that most of their neighbours see off their place; the farthest is set right first, since it
    makes its neighbours look wrong as well."""
    samples: dict[tuple[int, int], list[tuple[float, float, float]]] = defaultdict(list)
    for _, tally in sorted(tallies.items()):
        for (marker, partner, _), values in sorted(tally.offs.items()):
            samples[marker, partner] += values
    off: dict[int, dict[int, tuple[float, ...]]] = defaultdict(dict)
    for (marker, partner), values in sorted(samples.items()):
        if len(values) >= _LEAST_OFFS:
            off[marker][partner] = tuple(statistics.median(value[k] for value in values) for k in range(3))
    moved = []
    ids = {landmark.number: landmark.id for landmark in landmarks}
    while off:
        found = []
        for marker, by_partner in off.items():
            x, y, heading = (statistics.median(value[k] for value in by_partner.values()) for k in range(3))
            size = max(math.hypot(x, y) / _MOVED_MM, abs(wrapped(heading)) / _MOVED_DEG)
            found.append(
                (size, len(by_partner), -marker, Moved(marker, ids[marker], x, y, heading, len(by_partner)))
            )
        size, _, _, worst = max(found)
        if size <= 1:
            break
        moved.append(worst)
        del off[worst.number]
        for by_partner in off.values():
            by_partner.pop(worst.number, None)
        off = defaultdict(dict, {marker: by_partner for marker, by_partner in off.items() if by_partner})
    return moved


def _tell_moved(moved, landmarks, findings):
    places = {landmark.number: landmark for landmark in landmarks}
    for one in moved:
        place = places[one.number]
        text = "marker %d, by the map at %.0f, %.0f mm, hangs %.0f mm and %.1f deg off, as seen from %s"
        away_mm = math.hypot(one.x_mm, one.y_mm)
        others = counted(one.partners, "other marker")
        values = one.id, place.x_mm, place.y_mm, away_mm, one.heading_deg, others
        findings.append(Finding("moved marker", None, one.id, away_mm, text % values))
