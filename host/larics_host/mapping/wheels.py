"""The way that odometry tells, with what all of it shares: scale, drift and track, and its noise.

Two wheels: noise in proportion to the way of a wheel (variance `noise`, mm^2 a mm) moves the vehicle by half
of it and turns it by 2/track^2 of it. Systematic are three shares: of the distance (scale), of the turn per
way (drift, rad a mm: wheels of unequal size), of the turn (track). What a calibration leaves is systematic,
too: the camera takes the vehicle to be a little aside and turned (ahead mm, left mm, rad). Legs are told of
the vehicle as the camera takes it, so that all that is shared is in them, and readings have noise alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from larics_host.mapping.poses import Pose, after, axes, inverse

TRACK_MM = 300.0
# standard deviations that are expected of scale, drift (rad/mm), track, and what a calibration leaves
SHARES_SIGMA = (0.007, 4.7e-5, 0.01, 3.0, 3.0, 0.0015)
SHARES = len(SHARES_SIGMA)
_STEPS = (1e-4, 1e-6, 1e-4)  # for derivatives
_FLOOR_MM, _FLOOR_RAD = 0.7, 0.0005  # what times and roundings add to each leg
_HERE: Pose = (0.0, 0.0, 0.0)
_VIEW_SIGMA = (0.7, 0.7, 0.0007)  # of a View: mm, mm, rad


class View(NamedTuple):
    """Where the vehicle is in a frame of the stretch as a marker tells: in the axes of another frame."""

    frame: int
    pose: Pose


def wheels_mm(x: np.ndarray, y: np.ndarray, heading: np.ndarray, track_mm: float = TRACK_MM) -> np.ndarray:
    """(N - 1,) way of the wheel that goes farther, from each of N poses to the next."""
    return np.maximum(np.hypot(np.diff(x), np.diff(y)), track_mm / 2 * np.abs(np.diff(heading)))


class Leg(NamedTuple):
    """From one frame to another, in the axes of the first: pose (x mm, y mm, rad) with shares as in `at`, its
    derivatives (3, 6) by the shares, its covariance by noise of 1, and that by all else; way_mm of a wheel
    that odometry alone tells of."""

    pose: np.ndarray
    by_shares: np.ndarray
    by_noise: np.ndarray
    floor: np.ndarray
    at: np.ndarray
    way_mm: float

    def carried(self, shares: np.ndarray) -> np.ndarray:
        """The pose with other shares."""
        return self.pose + self.by_shares @ (shares - self.at)

    def covariance(self, noise: float, floor: float = 1.0) -> np.ndarray:
        """With noise of the wheels; floor: variance of all else, against what is expected."""
        return noise * self.by_noise + floor * self.floor


class Way:
    """A stretch's way, driven_mm of a wheel and ahead_mm since its start; x, y, heading: the vehicle in
    the odometry frame, mm and radians, unwrapped."""

    def __init__(self, x: np.ndarray, y: np.ndarray, heading: np.ndarray, track_mm: float = TRACK_MM) -> None:
        turn = np.diff(heading)
        middle = heading[:-1] + turn / 2
        dx, dy = np.diff(x), np.diff(y)
        self._ahead = np.cos(middle) * dx + np.sin(middle) * dy
        self._left = np.cos(middle) * dy - np.sin(middle) * dx
        self._turn = turn
        self._wheels_mm = wheels_mm(x, y, heading, track_mm)
        self.track_mm = track_mm
        self.driven_mm = np.concatenate([[0.0], np.cumsum(self._wheels_mm)])
        self.ahead_mm = np.concatenate([[0.0], np.cumsum(self._ahead)])

    def poses(self, shares: np.ndarray) -> np.ndarray:
        """(N, 3) poses from (0, 0, 0) on, with these shares of scale, drift and track taken into account."""
        scale, drift, track = shares[:3]
        ahead, left = (1 + scale) * self._ahead, (1 + scale) * self._left
        turn = (1 + track) * self._turn + drift * self._ahead
        heading = np.concatenate([[0.0], np.cumsum(turn)])
        middle = heading[:-1] + turn / 2
        poses = np.zeros((len(heading), 3))
        poses[1:, 0] = np.cumsum(np.cos(middle) * ahead - np.sin(middle) * left)
        poses[1:, 1] = np.cumsum(np.sin(middle) * ahead + np.cos(middle) * left)
        poses[:, 2] = heading
        return poses

    def legs(
        self,
        frames: np.ndarray,
        shares: np.ndarray,
        leaving: Sequence[View | None] = (),
        entries: Sequence[View | None] = (),
    ) -> list[Leg]:
        """The Legs between frames, each and the next, ascending indices of the stretch.

        leaving, entries: for each leg the View from its begin after which odometry tells the way, and that
        from its end up to which it does; None, or no list, where it tells all of the way."""
        out, into = _open_ways(frames, leaving, entries)
        begins, ends = (np.array([view.frame for view in views], int) for views in (out, into))
        poses = self.poses(shares)
        relative = _relative(poses[begins], poses[ends])
        slopes = []
        for k, step in enumerate(_STEPS):
            moved = self.poses(np.asarray(shares) + step * np.eye(SHARES)[k])
            slopes.append((_relative(moved[begins], moved[ends]) - relative) / step)
        relative, aside = _seen_aside(relative, shares[3:])
        by_shares = np.concatenate([np.stack(slopes, axis=2), aside], axis=2)
        noise = self._noise(poses, begins, ends)
        shares = np.array(shares, float)
        ways = (self.driven_mm[ends] - self.driven_mm[begins]).tolist()
        told = zip(relative, by_shares, noise, ways, out, into, strict=True)
        return [_leg(pose, slope, loud, shares, way, one, two) for pose, slope, loud, way, one, two in told]

    def _noise(self, poses, begins, ends):
        """(M, 3, 3): what each step's noise makes of the end, summed up, in the axes of the begin."""
        moved, turned = self._wheels_mm / 2, 2 * self._wheels_mm / self.track_mm**2
        origin = poses[begins]
        x, y = ((poses[1:, k] + poses[:-1, k]) / 2 for k in (0, 1))
        sums = [
            np.concatenate([[0.0], np.cumsum(v)])
            for v in (moved, turned, turned * x, turned * y, turned * x * x, turned * y * y, turned * x * y)
        ]
        way, t, tx, ty, txx, tyy, txy = (one[ends] - one[begins] for one in sums)
        ex, ey = poses[ends, 0], poses[ends, 1]
        found = np.empty((len(begins), 3, 3))
        found[:, 0, 0] = way + ey * ey * t - 2 * ey * ty + tyy
        found[:, 1, 1] = way + ex * ex * t - 2 * ex * tx + txx
        found[:, 0, 1] = found[:, 1, 0] = -(ex * ey * t - ex * ty - ey * tx + txy)
        found[:, 0, 2] = found[:, 2, 0] = -(ey * t - ty)
        found[:, 1, 2] = found[:, 2, 1] = ex * t - tx
        found[:, 2, 2] = t
        cos, sin, zero = np.cos(origin[:, 2]), np.sin(origin[:, 2]), np.zeros(len(begins))
        back = np.array([[cos, sin, zero], [-sin, cos, zero], [zero, zero, zero + 1]]).transpose(2, 0, 1)
        return back @ found @ back.transpose(0, 2, 1)


def _open_ways(frames, leaving, entries):
    """(Views at the begin of what odometry tells of each leg, Views at its end)."""
    out, into = ([View(int(frame), _HERE) for frame in side] for side in (frames[:-1], frames[1:]))
    for k, (one, other) in enumerate(zip(leaving, entries, strict=True)):
        one, other = one or out[k], other or into[k]
        if one.frame < other.frame:  # else both markers are in view in between
            out[k], into[k] = one, other
    return out, into


def _leg(odometry, by_shares, by_noise, shares, way, out, into):
    """The Leg of odometry from the View out to the View into."""
    floor = np.diag([_FLOOR_MM**2, _FLOOR_MM**2, _FLOOR_RAD**2])
    if out.pose is _HERE and into.pose is _HERE:
        return Leg(odometry, by_shares, by_noise, floor, shares, way)
    rest = inverse(into.pose)  # from where odometry ends
    pose = after(out.pose, after(odometry, rest))
    turn, end = axes(out.pose[2]), axes(out.pose[2] + odometry[2])
    on = turn @ _swung(np.subtract(after(odometry, rest), odometry))  # what the end of odometry moves
    floor = on @ floor @ on.T
    seen = np.diag(np.square(_VIEW_SIGMA))
    if out.pose is not _HERE:
        across = turn @ _swung(after(odometry, rest))
        floor = floor + across @ seen @ across.T
    if into.pose is not _HERE:
        across = end @ _swung(rest)
        floor = floor + across @ seen @ across.T
    return Leg(np.array(pose), on @ by_shares, on @ by_noise @ on.T, floor, shares, way)


def _swung(off):
    """(3, 3): how a pose at an offset moves with what is moved and turned in its origin."""
    return np.array([[1.0, 0.0, -off[1]], [0.0, 1.0, off[0]], [0.0, 0.0, 1.0]])


def _relative(begins, ends):
    """(M, 3): poses in the axes of others."""
    dx, dy = ends[:, 0] - begins[:, 0], ends[:, 1] - begins[:, 1]
    cos, sin = np.cos(begins[:, 2]), np.sin(begins[:, 2])
    return np.column_stack([cos * dx + sin * dy, cos * dy - sin * dx, ends[:, 2] - begins[:, 2]])


def _seen_aside(relative, shift):
    """(M, 3) legs of a vehicle that is taken to be aside and turned by a shift (x mm, y mm, rad), and their
    derivatives (M, 3, 3) by it, where it is small."""
    cos, sin = np.cos(relative[:, 2]), np.sin(relative[:, 2])
    slope = np.zeros((len(relative), 3, 3))
    slope[:, 0, 0] = slope[:, 1, 1] = cos - 1
    slope[:, 0, 1], slope[:, 1, 0] = -sin, sin
    slope[:, 0, 2], slope[:, 1, 2] = relative[:, 1], -relative[:, 0]
    return relative + slope @ np.asarray(shift), slope
