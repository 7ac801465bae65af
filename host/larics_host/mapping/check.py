"""What no map can be, and what no vehicle can drive: every problem, one line each."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from larics import settings as setting_rules
from larics.locate.marker_map import MarkerMap, map_reason
from larics.locate.route import resolve_entries, route_reason
from larics.marker import ids_in_words, is_used

if TYPE_CHECKING:
    from larics.settings import Settings
    from larics_host.mapping.mapfile import Map


_TOLERANCE_MM = 30.0
_ALIGNED_DEG = 1.0  # by which few are off where all are meant to be 0, and few radians are
_AROUND = 4.0  # radians
_HALL_M = 200.0  # no hall is longer, and no two markers hang so near to each other, in mm
_LEAST_MM = (("height_mm", 50.0), ("radius_mm", 5.0))  # metres, where it is less


def problems(
    hall: Map,
    reach_mm: float,
    distances: Iterable[tuple[int, int, float]] = (),
    settings: Settings | None = None,
) -> list[str]:
    """Lines about a mapfile.Map.

    reach_mm   the farthest that a vehicle drives from marker to marker
    distances  [(ID, ID, mm)] measured by hand, of IDs that stand in one place
    settings   larics.settings.Settings with the usual size, the lens's height and the IDs in use
    """
    settings = settings or setting_rules.Settings()
    rules = (settings.allowed_ids, settings.outer_mm10, settings.camera_z_mm10)
    rows = hall.rows()
    found = [] if rows else ["there is no marker in the map"]
    most = setting_rules.field("map").length
    if len(rows) > most:
        found.append("%d markers are more than the %d that a camera holds" % (len(rows), most))
    coded = settings.family == "coded"
    for marker_id in sorted({row[0] for row in rows if not is_used(row[0], coded, True)}):
        found.append("marker %d: no camera reads this ID, %s" % (marker_id, ids_in_words(coded, True)))
    alone = [map_reason([row], *rules) for row in rows]
    found += [reason for reason in alone if reason]
    sound = [row for row, reason in zip(rows, alone, strict=True) if not reason]
    overlaps = [
        "%s (at %d, %d and %d, %d mm)" % (reason, *other[1:3], *row[1:3])
        for index, row in enumerate(sound)
        for other in sound[:index]
        if (reason := map_reason([other, row], *rules))
    ]
    pairs = len(sound) * (len(sound) - 1) // 2
    found += (list(_metres(hall)) if len(overlaps) == pairs else []) or overlaps
    found += _radians(hall)
    found += _far_apart(rows, reach_mm)
    found += _wrong_distances(rows, distances)
    return found or _bad_route(hall.route, rows, rules, reach_mm)


def _metres(hall):
    """Places that only make sense as metres, of markers that all overlap."""
    spans = [
        max(places) - min(places)
        for places in ([one.x_mm for one in hall.markers], [one.y_mm for one in hall.markers])
        if places
    ]
    if 0 < max(spans, default=0) < _HALL_M:
        yield "all markers lie within %.4g x %.4g mm: are the places in metres?" % tuple(spans)


def _turned(hall):
    """The headings that are not 0, -180..180; [] unless all could be radians and some is no whole degree."""
    headings = [(marker.heading_deg + 180) % 360 - 180 for marker in hall.markers]
    # -pi..pi has become 0..pi and 356.8..360
    turned = [one for one in headings if abs(one) > 0.01]
    if not all(-3.15 <= one <= 6.3 for one in turned) or all(abs(one - round(one)) < 1e-6 for one in turned):
        return []
    return turned


def _radians(hall):
    """Headings that only make sense as radians: quarters and eighths of a turn of them."""
    turned = _turned(hall)
    quarters = sum(abs(one / (math.pi / 4) - round(one / (math.pi / 4))) < 0.005 for one in turned)
    if quarters > 1 and 2 * quarters >= len(turned):
        yield "all headings lie within %.4g to %.4g degrees: are they radians?" % (min(turned), max(turned))


def doubts(hall: Map) -> list[str]:
    """What a map may be, but seldom is; for maps that were written by hand, one line each."""
    return [*_sizes_in_metres(hall), *_perhaps_radians(hall)]


def _sizes_in_metres(hall):
    for name, least in _LEAST_MM:
        small = [one for one in hall.markers if 0 < (getattr(one, name) or 0) < least]
        if small:
            told = small[0].id, name, getattr(small[0], name)
            yield "marker %d: %s is %g: is it in metres?" % told


def _perhaps_radians(hall):
    turned = _turned(hall)
    aligned = sum(abs((marker.heading_deg + 180) % 360 - 180) < _ALIGNED_DEG for marker in hall.markers)
    if list(_radians(hall)) or not turned or 2 * aligned >= len(hall.markers):
        return []
    # markers that all hang alike, a few degrees off, are usual; radians go all around, counted in one way
    if min(turned) < 0 and max(turned) > math.pi or max(turned) - min(turned) <= _AROUND:
        return []
    return ["all headings lie within %.4g to %.4g degrees: are they radians?" % (min(turned), max(turned))]


def _apart(a, b):
    return math.hypot(a[1] - b[1], a[2] - b[2])


def _far_apart(rows, reach_mm):
    for row in rows:
        others = [_apart(row, other) for other in rows if other is not row]
        if others and min(others) > reach_mm:
            yield "marker %d is %.0f mm from the nearest other one, out of reach" % (row[0], min(others))


def _wrong_distances(rows, distances):
    for a, b, mm in distances:
        first, second = ([row for row in rows if row[0] == marker_id] for marker_id in (a, b))
        if len(first) != 1 or len(second) != 1:
            yield "the distance %d-%d: each of the IDs must be in the map once" % (a, b)
        elif abs(_apart(first[0], second[0]) - mm) > _TOLERANCE_MM:
            apart = _apart(first[0], second[0])
            yield "markers %d and %d are %.0f mm apart in the map, %.0f mm as measured" % (a, b, apart, mm)


def _bad_route(route, rows, rules, reach_mm):
    """Problems of the route, over a map that has none."""
    if not route:
        return []
    reason = route_reason(route, rows)
    if reason:
        return [reason]
    entries = resolve_entries(route, MarkerMap(rows, *rules))
    found = []
    for step, (a, b) in enumerate(zip(entries[:-1], entries[1:], strict=True), 1):
        way = _apart(rows[a], rows[b])
        if way > reach_mm:
            text = "route step %d: marker %d is %.0f mm from marker %d, out of reach"
            found.append(text % (step + 1, rows[b][0], way, rows[a][0]))
    return found
