"""What vehicles and markers did, as rows of tables."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from larics.wire import messages as m
from larics_host.fleet.places import Moved
from larics_host.fleet.tally import Tally
from larics_host.fleet.trends import Trend


def mean_margin(tally: Tally) -> float | None:
    """Of all readings of a vehicle; None without one."""
    total = sum(sums[0] for sums in tally.readings.values())
    return sum(sums[1] for sums in tally.readings.values()) / total if total else None


def vehicle_row(
    name: str, tally: Tally, logs: int, lens: Trend | None, scale: Trend | None, apart: float | None
) -> dict[str, Any]:
    """The row of a vehicle by its Tally and number of logs: lens, scale: how its margins and lengths change;
    apart: the share by which it sees markers too far apart. None where that is not known."""
    total = sum(sums[0] for sums in tally.readings.values())
    margin = mean_margin(tally)
    return {
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
        "distance_error_pct": None if apart is None else round(100 * apart, 3),
    }  # fmt: skip


def _share(part, whole):
    """In percent; None of nothing."""
    return round(100 * part / whole, 3) if whole else None


def marker_row(
    marker: int, tallies: Mapping[str, Tally], change: Trend | None, moved: Sequence[Moved]
) -> dict[str, Any]:
    """The row of a marker's ID by the Tallies of all vehicles: change: of its margin; moved: all markers that
    are off their places."""
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
    margin = sums[1] / sums[0]
    offs = [one for one in moved if one.id == marker]
    return {
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
