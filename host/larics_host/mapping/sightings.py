"""What a log tells of markers and of the vehicle's way, frame by frame, as arrays.

Frame numbers begin anew when the camera does; here each frame of a log has an index of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from larics.wire import messages as m
from larics_host import files
from larics_host.errors import UserError
from larics_host.logs.columns import read_columns

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


_UNUSABLE = m.MARKER_NONE | m.MARKER_NO_OFFSET | m.MARKER_ID_UNCERTAIN | m.MARKER_UNCONFIRMED
_SLACK_MM, _SLACK_DEG = 20.0, 1.0  # by which a step may be longer than the way that was counted ...
_SLACK_SHARE = 1.02  # ... with what the wire's rounding makes of it
_LEAST_FRAMES = 2  # of a stretch with odometry


class Sighting(NamedTuple):
    """A marker in a frame: ID, place and direction in the vehicle frame."""

    id: int
    x_mm: float
    y_mm: float
    heading_deg: float
    height_mm: float


class Stretch(NamedTuple):
    """Frames through which the odometry never jumped: their indices in the log, ascending, and the vehicle's
    pose in the odometry frame, mm and radians, headings unwrapped."""

    frames: np.ndarray
    x_mm: np.ndarray
    y_mm: np.ndarray
    heading: np.ndarray


class Seen(NamedTuple):
    """numbers: the camera's number of each frame; frames: the index of the frame that each of the usable
    `sightings` is in, ascending; stretches: those with odometry."""

    numbers: np.ndarray
    frames: np.ndarray
    sightings: list[Sighting]
    stretches: list[Stretch]


def read_sightings(path: StrPath, progress: Callable[[int], object] = files.unwatched) -> Seen:
    """The Seen of a log of larics log; progress is told the bytes read. UserError without a marker message or
    with markers that have no offsets."""
    columns = read_columns(path, ("MARKER", "MOTION"), progress)
    markers, motions = columns["MARKER"], columns["MOTION"]
    if not len(markers):
        raise UserError("%s has no marker message" % path)
    if (markers["flags"] & m.MARKER_NO_OFFSET).any():
        raise UserError("%s has markers without offsets: calibrate the camera first" % path)
    marker_frames, motion_frames, numbers = _indexed(markers, motions)
    usable = ((markers["flags"] & _UNUSABLE) == 0) & (markers["id"] != m.ID_NONE)
    kept = markers[usable]
    values = [kept["id"], *(kept[name] / 10 for name in ("x_mm10", "y_mm10")), kept["heading_cdeg"] / 100]
    sightings = [
        Sighting(*row) for row in zip(*(v.tolist() for v in [*values, kept["z_mm10"] / 10]), strict=True)
    ]
    return Seen(numbers, marker_frames[usable], sightings, _stretches(motions, motion_frames))


def _indexed(markers, motions):
    """(index of the frame of each MARKER, of each MOTION, number of each frame)."""
    order = np.concatenate([markers["order"], motions["order"]])
    numbers = np.concatenate([markers["frame"], motions["frame"]])
    sorting = np.argsort(order, kind="stable")
    steps = np.diff(numbers[sorting], prepend=numbers[sorting][:1])
    indices = np.empty(len(order), int)
    indices[sorting] = np.cumsum(steps != 0)  # a step back is a camera that began anew
    of_frames = np.empty(indices.max() + 1, numbers.dtype)
    of_frames[indices] = numbers
    return indices[: len(markers)], indices[len(markers) :], of_frames


def _stretches(motions, frames):
    known = motions["state"] != m.MOTION_NONE
    motions, frames = motions[known], frames[known]
    if not len(motions):
        return []
    x, y = motions["x_mm10"] / 10, motions["y_mm10"] / 10
    heading = np.unwrap(np.radians(motions["heading_cdeg"] / 100))
    counted = [(np.diff(motions[name]) & m.COUNT_MAX) for name in ("way_mm10", "turn_cdeg")]
    jump = np.hypot(np.diff(x), np.diff(y)) > _SLACK_SHARE * counted[0] / 10 + _SLACK_MM
    jump |= np.degrees(np.abs(np.diff(heading))) > _SLACK_SHARE * counted[1] / 100 + _SLACK_DEG
    jump |= np.diff(motions["epoch"]) != 0
    # a camera that began anew, or another log behind this one
    jump |= (np.diff(motions["frame"]) & m.COUNT_MAX) > m.COUNT_MAX // 2
    cuts = [0, *(np.flatnonzero(jump) + 1), len(motions)]
    return [
        Stretch(frames[a:b], x[a:b], y[a:b], heading[a:b])
        for a, b in zip(cuts[:-1], cuts[1:], strict=True)
        if b - a >= _LEAST_FRAMES
    ]
