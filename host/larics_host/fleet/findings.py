"""What is wrong with the vehicles and markers of a fleet, by the tallies of all its vehicles.

Margins, radii and distances are compared with what the same marker, the same pair or the same vehicle had
before and has elsewhere. The numbers behind each finding are in the tables.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from larics_host.fleet.places import distance_errors, moved_markers
from larics_host.fleet.rows import marker_row, mean_margin, vehicle_row
from larics_host.fleet.tally import Tally
from larics_host.fleet.track import Landmark
from larics_host.fleet.trends import common_to, means_of, trend, without_lens
from larics_host.wire_names import ENUMS
from larics_host.wording import counted

_SURE = 4.0  # standard errors
_MARGIN_SHARE, _MARGIN = 0.15, 8.0  # fall over the time of the logs
_LENGTH_SHARE = 0.01  # change of the scale of a calibration
_WRONG_LEAST = 3  # readings, of one pair of IDs
_WRONG_SHARE = 0.001  # of the readings of a plate
_LOST_SHARE = 0.01  # of the messages
_FRAMES_LEAST, _ALIKE_SHARE = 10, 0.9  # of recorded frames, that read as they were reported
_FAULTS = {number: name for group, items in ENUMS if group == "Fault" for name, number, _ in items}

# in the order in which they are told
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


def examine(
    tallies: Mapping[str, Tally], logs: Mapping[str, int], landmarks: Sequence[Landmark] = ()
) -> Fleet:
    """The Fleet of {vehicle: Tally} and {vehicle: number of logs}."""
    findings: list[Finding] = []
    names = sorted(tallies)
    margins = means_of(tallies, 1, 1.0)
    radii = means_of(tallies, 3, 256.0)
    lens = {name: common_to(margins, name, relative=False) for name in names}
    apart = distance_errors(tallies, landmarks)
    vehicles = []
    for name in names:
        changes = trend(lens[name]), trend(common_to(radii, name, relative=True))
        error = apart.get(name)
        vehicles.append(vehicle_row(name, tallies[name], logs[name], *changes, error and error[0]))
        _tell_vehicle(name, tallies[name], *changes, error, findings)
    moved = moved_markers(tallies, landmarks)
    markers = []
    for marker in sorted({key[0] for tally in tallies.values() for key in tally.readings}):
        change = trend(without_lens(marker, margins, lens))
        markers.append(marker_row(marker, tallies, change, moved))
        _tell_marker(marker, change, findings)
    _tell_wrong(tallies, findings)
    _tell_moved(moved, landmarks, findings)
    order = {kind: k for k, kind in enumerate(KINDS)}
    findings.sort(
        key=lambda one: (order[one.kind], one.vehicle or "", -1 if one.marker is None else one.marker)
    )
    return Fleet(vehicles, markers, findings)


def _tell_vehicle(name, tally, lens, scale, apart, findings):
    """lens, scale: Trends of margins and lengths; apart: of `distance_errors`. None where not known."""
    margin = mean_margin(tally)
    messages = tally.lines - tally.damaged
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


def _listed(ids):
    return " ".join(map(str, ids))


def _tell_marker(marker, change, findings):
    if change and -change.change > max(_MARGIN, _MARGIN_SHARE * change.first) and change.sure > _SURE:
        text = "marker %d: its margin falls from %.0f to %.0f: worn, dirty, or its light fails"
        value = text % (marker, change.first, change.last)
        findings.append(Finding("worn or dirty marker", None, marker, change.change, value))


def _tell_wrong(tallies, findings):
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


def _tell_moved(moved, landmarks, findings):
    places = {landmark.number: landmark for landmark in landmarks}
    for one in moved:
        place = places[one.number]
        text = "marker %d, by the map at %.0f, %.0f mm, hangs %.0f mm and %.1f deg off, as seen from %s"
        away_mm = math.hypot(one.x_mm, one.y_mm)
        others = counted(one.partners, "other marker")
        values = one.id, place.x_mm, place.y_mm, away_mm, one.heading_deg, others
        findings.append(Finding("moved marker", None, one.id, away_mm, text % values))
