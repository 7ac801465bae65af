"""Which passages are of the same marker: a first map, grown passage by passage along each drive.

An extended Kalman filter over the vehicle's pose, the shares that all of its odometry has in common, and the
markers met so far: its covariance says where a marker may be that was met before. A reading belongs to the
known place of its ID that it fits best, or to a new one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from larics_host.mapping.passages import Drive
from larics_host.mapping.poses import axes, wrapped
from larics_host.mapping.wheels import SHARES, SHARES_SIGMA, Leg, Way

GATE = 21.0  # chi-squared with three degrees of freedom: one in 10,000
NEAR_MM = 700.0  # no other marker of this ID is so near
OVERLAP_MM = 900.0  # of another ID neither
READING_SIGMA = (1.5, 1.5, 0.0015)  # of a passage: mm, mm, rad
_FIRST = 3 + SHARES  # state of the first place
_VOTE_MM = 2000.0  # of way, at least, between two passages whose headings are compared
_VOTE_TO_MM = ((60000.0, 241), (200000.0, 801))  # at most, and drifts that are tried; the second where ...
_VOTES_LEAST, _VOTES_MOST = 3, 5000  # ... the first has not convinced: who comes back late alone has those
_VOTED_SIGMA = (3e-6, 0.004)  # of drift and track, as voted


@dataclass
class Found:
    """A place of a drive: ID, pose (x mm, y mm, rad) in the drive's axes, indices of its passages, and of
    those that agree with it beyond doubt."""

    id: int
    pose: np.ndarray
    passages: list
    sure: list


class _Filter:
    """State: the vehicle's pose, the shares, then three numbers a place."""

    def __init__(self, shares, sigma):
        self._x = np.zeros(64)
        self._p = np.zeros((64, 64))
        self._x[3:_FIRST] = shares
        self._p[3:_FIRST, 3:_FIRST] = np.diag(np.square(sigma))
        self._size = _FIRST

    @property
    def places(self):
        return (self._size - _FIRST) // 3

    def pose(self):
        return self._x[:3].copy()

    def place(self, k):
        return self._x[_FIRST + 3 * k : _FIRST + 3 * k + 3].copy()

    def drive(self, leg: Leg, noise: float) -> None:
        """Carries the pose on."""
        n = self._size
        step = leg.carried(self._x[3:_FIRST])
        turn = axes(self._x[2])
        moved = turn @ step
        slope = np.eye(3)
        slope[:2, 2] = -moved[1], moved[0]
        shares = turn @ leg.by_shares
        self._x[:3] += moved
        covariance = self._p[:n, :n]
        covariance[:3, :] = slope @ covariance[:3, :] + shares @ covariance[3:_FIRST, :]
        covariance[:, :3] = covariance[:, :3] @ slope.T + covariance[:, 3:_FIRST] @ shares.T
        covariance[:3, :3] += turn @ leg.covariance(noise) @ turn.T

    def add(self, reading: np.ndarray) -> int:
        """A new place from a reading (x, y, rad) at the pose; returns its number."""
        n = self._size
        if n + 3 > len(self._x):
            self._x = np.concatenate([self._x, np.zeros(len(self._x))])
            larger = np.zeros((len(self._x),) * 2)
            larger[:n, :n] = self._p[:n, :n]
            self._p = larger
        turn = axes(self._x[2])
        seen = turn @ reading
        slope = np.eye(3)
        slope[:2, 2] = -seen[1], seen[0]
        self._x[n : n + 3] = self._x[:3] + seen
        self._p[n : n + 3, :n] = slope @ self._p[:3, :n]
        self._p[:n, n : n + 3] = self._p[n : n + 3, :n].T
        noise = turn @ np.diag(np.square(READING_SIGMA)) @ turn.T
        self._p[n : n + 3, n : n + 3] = slope @ self._p[:3, :3] @ slope.T + noise
        self._size = n + 3
        return (n - _FIRST) // 3

    def innovation(self, k, reading):
        """(innovation, its covariance, slope (3, 6) by pose and place) of a reading of place k."""
        at = _FIRST + 3 * k
        pose, place = self._x[:3], self._x[at : at + 3]
        back = axes(pose[2]).T
        seen = back @ (place - pose)
        off = reading - seen
        off[2] = wrapped(off[2])
        slope = np.hstack([-back, back])
        slope[:2, 2] += seen[1], -seen[0]
        rows = np.r_[0:3, at : at + 3]
        covariance = slope @ self._p[np.ix_(rows, rows)] @ slope.T + np.diag(np.square(READING_SIGMA))
        return off, covariance, slope

    def update(self, k, off, covariance, slope):
        n = self._size
        rows = np.r_[0:3, _FIRST + 3 * k : _FIRST + 3 * k + 3]
        crossed = self._p[:n, rows] @ slope.T
        gain = np.linalg.solve(covariance, crossed.T).T
        self._x[:n] += gain @ off
        self._p[:n, :n] -= gain @ crossed.T


def shares_of(drive: Drive, way: Way, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """(shares, standard deviations) of them before there is a map.

    Each two passages that read the same ID tell how far the vehicle has turned between them, if they are of
    one marker. Those that are agree about drift and track; the others agree about nothing."""
    passages = drive.passages
    poses, nothing = way.poses(np.zeros(SHARES)), (np.zeros(SHARES), np.array(SHARES_SIGMA))
    frames = [passage.frame for passage in passages]
    heading = poses[frames, 2] + [passage.heading for passage in passages]
    driven, ahead = way.driven_mm[frames], way.ahead_mm[frames]
    by_id: dict[int, list[int]] = {}
    pairs = []
    for k, passage in enumerate(passages):
        for before in by_id.setdefault(passage.id, []):
            if driven[k] - driven[before] > _VOTE_MM:
                pairs.append((before, k))
        by_id[passage.id].append(k)
    pairs.sort(key=lambda pair: driven[pair[1]] - driven[pair[0]])
    for most_mm, tried in _VOTE_TO_MM:
        some = [pair for pair in pairs if driven[pair[1]] - driven[pair[0]] < most_mm][:_VOTES_MOST]
        if len(some) < _VOTES_LEAST:
            continue
        first, second = np.array(some).T
        sigma = np.sqrt(
            2 * noise / way.track_mm**2 * (driven[second] - driven[first]) + 2 * READING_SIGMA[2] ** 2
        )
        went, turned = ahead[second] - ahead[first], poses[frames, 2][second] - poses[frames, 2][first]
        voted = _voted(heading[second] - heading[first], sigma, went, turned, tried)
        if voted is not None:
            shares = np.array([0.0, *voted, 0.0, 0.0, 0.0])
            return shares, np.array([SHARES_SIGMA[0], *_VOTED_SIGMA, *SHARES_SIGMA[3:]])
    return nothing


def _voted(off, sigma, went, turned, tried):
    """(drift, track) of which most pairs of headings, off by so much to sigma over a way and a turn, are
    explained; tried: how many drifts. None where chance does as well."""
    drifts = np.linspace(-3, 3, tried) * SHARES_SIGMA[1]
    tracks = np.linspace(-3, 3, 25) * SHARES_SIGMA[2]
    best = 0.0, 0.0, 0.0
    expected = np.exp(-0.5 * np.square(drifts / SHARES_SIGMA[1]) / _VOTES_LEAST)
    for track in tracks:
        rest = off + track * turned
        votes = np.exp(-0.5 * (wrapped(rest[:, None] + np.outer(went, drifts)) / sigma[:, None]) ** 2).sum(
            axis=0
        )
        votes = votes * expected * math.exp(-0.5 * (track / SHARES_SIGMA[2]) ** 2 / _VOTES_LEAST)
        k = int(np.argmax(votes))
        best = max(best, (float(votes[k]), float(drifts[k]), float(track)))
    by_chance = float(np.minimum(1.0, sigma * math.sqrt(2 / math.pi) / 2).sum())
    if best[0] < by_chance + _VOTES_LEAST * math.sqrt(1 + by_chance):
        return None
    return best[1:]


def places_of(drive: Drive, legs: Sequence[Leg], sigma: np.ndarray, noise: float) -> list[Found]:
    """The Founds of a drive; legs: from each passage to the next one; sigma: to which the shares are known
    with which they are taken; noise: see wheels."""
    state = _Filter(legs[0].at if legs else np.zeros(SHARES), sigma)
    found: list[Found] = []
    for index, passage in enumerate(drive.passages):
        if index:
            state.drive(legs[index - 1], noise)
        reading = np.array([passage.x_mm, passage.y_mm, passage.heading])
        best = None
        for k, place in enumerate(found):
            if place.id != passage.id:
                continue
            off, covariance, slope = state.innovation(k, reading)
            square = float(off @ np.linalg.solve(covariance, off))
            if (square < GATE or math.hypot(off[0], off[1]) < NEAR_MM) and (best is None or square < best[0]):
                best = square, k, off, covariance, slope
        if best is None:
            state.add(reading)
            found.append(Found(passage.id, np.zeros(3), [index], [index]))
            continue
        square, k, off, covariance, slope = best
        found[k].passages.append(index)
        if square < GATE:
            found[k].sure.append(index)
        else:  # a slip, a moved marker or a wrong reading: it may only say so much
            covariance = covariance * (square / GATE)
        state.update(k, off, covariance, slope)
    for k, place in enumerate(found):
        place.pose = state.place(k)
    return found
