"""Figures of a drive: detection by method, pose error, laps, and how long it takes to recover."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from larics.wire import messages as m
from larics_host.wire_names import name_of

if TYPE_CHECKING:
    from larics_host.drive.simulation import Trace


_POSE_REGAINED_MM = 50.0


@dataclass
class Detection:
    """One method on the frames of one drive.

    frames     all; markers: shown whole, to the end of the orientation line, summed over the frames
    detected   of the markers; right, other, unsure: their IDs
    cut_wrong  wrong IDs of markers that the border cuts; false: detections where no marker is
    """

    frames: int
    markers: int
    detected: int
    right: int
    other: int
    unsure: int
    cut_wrong: int
    false: int

    @property
    def right_share(self) -> float:
        """Right IDs as a share of the markers in view; NaN without markers."""
        return self.right / self.markers if self.markers else float("nan")


@dataclass
class Spread:
    """count, median, 95th percentile and maximum; NaN for an empty set."""

    count: int
    median: float
    p95: float
    max: float


def spread(numbers: Iterable[float]) -> Spread:
    values = np.asarray(list(numbers), dtype=float)
    if not len(values):
        return Spread(0, float("nan"), float("nan"), float("nan"))
    return Spread(
        len(values), float(np.median(values)), float(np.percentile(values, 95)), float(values.max())
    )


@dataclass
class Score:
    """All figures of a drive; see the functions of this module. covered, pulls: by state, of x, y and
    heading the shares within two of their own standard deviations, and the root mean squares of error by
    sigma."""

    methods: dict
    tracking_mm: Spread
    tracking_deg: Spread
    coasting_mm: Spread
    sigma_ratio: float
    covered: dict
    pulls: dict
    states: dict
    laps_begun: int
    laps_completed: int
    visits: int
    wrong_visits: int
    centred_mm: Spread
    wrong_per_hour: float
    pose_regained_s: Spread
    route_regained_s: Spread
    faults: int
    fault_names: list
    line_errors: int
    way_m: float

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


STATES = (("tracking", m.TRACKING), ("coasting", m.COASTING), ("carried", m.CARRIED), ("lost", m.LOST))


def score(trace: Trace) -> Score:
    """The Score of a Trace."""
    frames = trace.frames
    tracking = [frame for frame in frames if frame.state == m.TRACKING]
    coasting = [frame for frame in frames if frame.state in (m.COASTING, m.CARRIED)]
    begun, completed = laps(trace)
    visited = [visit for visit in trace.visits if np.isfinite(visit[2])]
    pose_s, route_s = recoveries(trace)
    wire = detection(trace, "wire")
    hours = trace.field.condition.seconds / 3600
    ratios = [frame.error[0] / frame.sigma_mm for frame in tracking if frame.sigma_mm > 0]
    return Score(
        methods={name: detection(trace, name) for name in (frames[0].sights if frames else ())},
        tracking_mm=spread(frame.error[0] for frame in tracking),
        tracking_deg=spread(frame.error[1] for frame in tracking),
        coasting_mm=spread(frame.error[0] for frame in coasting),
        sigma_ratio=float(np.median(ratios)) if ratios else float("nan"),
        covered={"tracking": _covered(tracking), "coasting": _covered(coasting)},
        pulls={"tracking": _pulls(tracking), "coasting": _pulls(coasting)},
        states={
            name: sum(frame.state == number for frame in frames) / max(1, len(frames))
            for name, number in STATES
        },
        laps_begun=begun,
        laps_completed=completed,
        visits=len(trace.visits),
        wrong_visits=len(_out_of_order(trace)),
        centred_mm=spread(visit[2] for visit in visited),
        wrong_per_hour=(wire.other + wire.cut_wrong) / hours,
        pose_regained_s=spread(pose_s),
        route_regained_s=spread(route_s),
        faults=trace.faults,
        fault_names=[name_of("Fault", code) for code in sorted(trace.fault_codes)],
        line_errors=trace.line_errors,
        way_m=trace.way_mm / 1000,
    )


def _in_sigmas(frames):
    """Error by sigma, (frames, 3)."""
    off, sigmas = np.array([frame.off for frame in frames]), np.array([frame.sigmas for frame in frames])
    return off / sigmas


def _covered(frames):
    if not frames:
        return []
    return [float(share) for share in np.mean(np.abs(_in_sigmas(frames)) <= 2, axis=0)]


def _pulls(frames):
    if not frames:
        return []
    return [float(pull) for pull in np.sqrt(np.mean(_in_sigmas(frames) ** 2, axis=0))]


def detection(trace: Trace, name: str) -> Detection:
    """The Detection of a method (or of "wire", what the firmware sent) on the frames of a drive."""
    sights = [frame.sights[name] for frame in trace.frames]
    names = asdict(sights[0]) if sights else ()
    total = {key: sum(getattr(sight, key) for sight in sights) for key in names}
    get = total.get
    return Detection(
        frames=len(sights),
        markers=sum(frame.markers for frame in trace.frames),
        detected=get("right", 0) + get("wrong", 0) + get("unsure", 0),
        right=get("right", 0),
        other=get("wrong", 0),
        unsure=get("unsure", 0),
        cut_wrong=get("cut_wrong", 0),
        false=get("false", 0),
    )


def laps(trace: Trace) -> tuple[int, int]:
    """(begun, completed): a lap begins when the first marker of the route is left, and is completed when it
    is left again after all others that hang, in order. One that the drive's end cuts off does not count."""
    route = _hanging(trace)
    begun = completed = 0
    expected = None
    for _, marker_id, _ in trace.visits:
        if expected is not None and marker_id == route[expected]:
            if expected == 0:
                completed += 1
            expected = (expected + 1) % len(route)
        elif marker_id != route[0]:
            expected = None
        if marker_id == route[0]:
            begun += 1
            expected = 1
    return max(completed, begun - 1), completed


def _hanging(trace):
    """The markers of a lap, without one that has been taken down."""
    return [number for number in trace.field.route[:-1] if number != trace.field.condition.missing]


def _out_of_order(trace):
    """Pairs of markers left one after the other that do not follow each other in the route."""
    route = _hanging(trace)
    following = set(zip(route, route[1:] + route[:1], strict=True))
    pairs = zip(trace.visits[:-1], trace.visits[1:], strict=True)
    return [(before, after) for before, after in pairs if (before[1], after[1]) not in following]


def recoveries(trace: Trace) -> tuple[list[float], list[float]]:
    """(seconds from each push until the pose was right again, seconds until the route was): until the next
    marker was left, and without pushes the time between two that do not follow each other in the route."""
    if not trace.pushes:
        return [], [after[0] - before[0] for before, after in _out_of_order(trace)]
    pose_s, route_s = [], []
    for start in trace.pushes:
        right = [
            frame.time_s
            for frame in trace.frames
            if frame.time_s > start and frame.state == m.TRACKING and frame.error[0] < _POSE_REGAINED_MM
        ]
        left = [visit[0] for visit in trace.visits if visit[0] > start]
        pose_s += [right[0] - start] if right else []
        route_s += [left[0] - start] if left else []
    return pose_s, route_s
