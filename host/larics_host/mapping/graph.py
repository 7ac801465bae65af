"""The pose graph of a map, solved by GTSAM.

Unknown are the vehicle's pose in each passage, the pose of each marker, and the shares that a log's odometry
has in common, see wheels. Factors are the legs of odometry between passages, the readings of
passages, markers seen in one frame, distances and places that are given. Readings and what was seen together
are under a robust noise model (Huber's); which of them count at all is tested from outside, see `surprises`.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from larics_host.errors import UserError, missing_package
from larics_host.mapping.association import READING_SIGMA
from larics_host.mapping.poses import axes
from larics_host.mapping.wheels import SHARES, SHARES_SIGMA, Leg

gtsam: Any
try:
    import gtsam
except ImportError:
    gtsam = None

LINK_SIGMA = (1.5, 1.5, 0.0025)  # of what some frames show together: mm, mm, rad
DISTANCE_SIGMA_MM = 3.0
PLACE_SIGMA = (3.0, 3.0, 0.01)
_ANCHOR_SIGMA = (0.01, 0.01, 1e-5)
_HUBER = 1.345  # 95 % efficient where there is nothing wrong
_ITERATIONS = 40
_AT_REST = 1e-5
_DOUBTED = 0.2  # squares of a reading, in those of its sigma, from which on it is looked into


def needed() -> Any:
    """The module gtsam; UserError in one line where it is missing."""
    try:
        import gtsam
    except ImportError:
        if sys.platform == "win32":
            raise UserError(
                "larics map build needs GTSAM, which there is not for Windows: use Linux or macOS for it"
            ) from None
        raise missing_package("larics map build", "gtsam") from None
    return gtsam


@dataclass
class Reading:
    """Of a place, in the vehicle frame of a passage; both by number. used: whether it counts."""

    passage: int
    place: int
    pose: tuple
    used: bool = True


@dataclass
class Link:
    """Of two places, by number: the pose of the second in the axes of the first. used: whether it counts."""

    first: int
    second: int
    pose: tuple
    used: bool = True


@dataclass
class Graph:
    """poses {number: (x, y, rad)} of the vehicle in passages, places {number: (x, y, rad)} of markers, shares
    {log: see wheels}: to begin with, and after `solve` as they fit best.

    legs       [(log, passage, passage, Leg)]
    readings   [Reading]
    links      [Link]
    distances  [(place, place, mm)]
    given      [(place, (x, y, rad or None))]
    anchor     the place that stays where it is, or None
    noise      of the wheels, see wheels; link_noise: variance of links against LINK_SIGMA's
    """

    poses: dict = field(default_factory=dict)
    places: dict = field(default_factory=dict)
    shares: dict = field(default_factory=dict)
    legs: list = field(default_factory=list)
    readings: list = field(default_factory=list)
    links: list = field(default_factory=list)
    distances: list = field(default_factory=list)
    given: list = field(default_factory=list)
    anchor: int | None = None
    noise: float = 0.001
    link_noise: float = 1.0

    def solve(self, robust: bool = True) -> float:
        """Moves poses, places and shares to where all that counts fits best; returns half its squares."""
        gtsam = needed()
        factors = self._factors(robust)
        values = _optimum(factors, self._values())
        for kept, name in ((self.poses, "x"), (self.places, "m")):
            for number in kept:
                pose = values.atPose2(gtsam.symbol(name, number))
                kept[number] = (pose.x(), pose.y(), pose.theta())
        for log in self.shares:
            self.shares[log] = values.atVector(gtsam.symbol("s", log))
        return factors.error(values)

    def marginals(self) -> Any:
        return needed().Marginals(self._factors(False), self._values())

    def place_covariance(self, marginals: Any, numbers: list) -> np.ndarray:
        """(3 N, 3 N) covariance of places (x mm, y mm, rad) in the axes of the map."""
        gtsam = needed()
        keys = [gtsam.symbol("m", number) for number in numbers]
        joint = marginals.jointMarginalCovariance(keys)
        order = {key: k for k, key in enumerate(sorted(keys))}
        size = 3 * len(keys)
        full = np.asarray(joint.fullMatrix()).reshape(size, size)
        rows = np.concatenate([3 * order[key] + np.arange(3) for key in keys])
        full = full[np.ix_(rows, rows)]
        turn = np.zeros((size, size))
        for k, number in enumerate(numbers):
            turn[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = axes(self.places[number][2])
        return turn @ full @ turn.T

    def surprises(self, marginals: Any) -> np.ndarray:
        """For each reading the chi-squared (three degrees of freedom) by which it contradicts all others; 0
        where that is little, NaN where nothing else tells of its place."""
        gtsam = needed()
        noise = np.diag(np.square(READING_SIGMA))
        found = np.full(len(self.readings), np.nan)
        for k, one in enumerate(self.readings):
            off, slope = _reading_error(self.poses[one.passage], self.places[one.place], one.pose)
            if one.used and np.sum(np.square(off / READING_SIGMA)) < _DOUBTED:
                found[k] = 0.0
                continue
            keys = [gtsam.symbol("x", one.passage), gtsam.symbol("m", one.place)]
            joint = marginals.jointMarginalCovariance(keys)
            blocks = [[joint.at(a, b) for b in keys] for a in keys]
            fitted = slope @ np.block(blocks) @ slope.T
            spread = noise - fitted if one.used else noise + fitted
            if (
                one.used
                and np.linalg.eigvalsh(spread / np.sqrt(np.outer(np.diag(noise), np.diag(noise))))[0] < 1e-4
            ):
                continue
            found[k] = off @ np.linalg.solve(spread, off)
        return found

    def squares(self, most: float = math.inf) -> tuple[float, float, int]:
        """(chi-squared of the legs, each at most so much, of all else that counts, degrees of freedom of
        all)."""
        legs = other = 0.0
        count = 0
        for one in self.legs:
            off, leg = self.leg_error(one), one[3]
            legs += min(most, float(off @ np.linalg.solve(leg.covariance(self.noise), off)))
            count += 3
        for one in self.readings:
            if one.used:
                other += np.sum(np.square(self.reading_error(one) / READING_SIGMA))
                count += 3
        links = self.link_squares()
        other += (
            sum(square for one, square in zip(self.links, links, strict=True) if one.used) / self.link_noise
        )
        count += 3 * sum(one.used for one in self.links)
        count += len(self.distances) - 3 * (len(self.poses) + len(self.places) - 1)
        return legs, other, count

    def leg_error(self, one: tuple[int, int, int, Leg]) -> np.ndarray:
        """What odometry is off by on one of the legs: mm, mm, rad in the axes of its begin."""
        log, a, b, leg = one
        return _leg_error(self.poses[a], self.poses[b], leg.carried(self.shares[log]))[0]

    def reading_error(self, one: Reading) -> np.ndarray:
        """What a reading is off by: mm, mm, rad in the axes of the vehicle."""
        return _reading_error(self.poses[one.passage], self.places[one.place], one.pose)[0]

    def link_error(self, one: Link) -> np.ndarray:
        """What a link is off by: mm, mm, rad in the axes of its first place."""
        return _reading_error(self.places[one.first], self.places[one.second], one.pose)[0]

    def link_squares(self) -> list[float]:
        """By how much each link is off, in squares of LINK_SIGMA."""
        return [float(np.sum(np.square(self.link_error(one) / LINK_SIGMA))) for one in self.links]

    def _values(self):
        gtsam = needed()
        values = gtsam.Values()
        for kept, name in ((self.poses, "x"), (self.places, "m")):
            for number, pose in kept.items():
                values.insert(gtsam.symbol(name, number), gtsam.Pose2(*pose))
        for log, shares in self.shares.items():
            values.insert(gtsam.symbol("s", log), np.asarray(shares, float))
        return values

    def _factors(self, robust):
        gtsam = needed()
        noise = gtsam.noiseModel
        factors = gtsam.NonlinearFactorGraph()

        def sigmas(values, huber=robust):
            model = noise.Diagonal.Sigmas(np.array(values, float))
            return noise.Robust.Create(noise.mEstimator.Huber.Create(_HUBER), model) if huber else model

        def marker(number):
            return gtsam.symbol("m", number)

        for log in self.shares:
            factors.add(
                gtsam.PriorFactorVector(gtsam.symbol("s", log), np.zeros(SHARES), sigmas(SHARES_SIGMA, False))
            )
        for log, a, b, leg in self.legs:
            model = noise.Gaussian.Covariance(leg.covariance(self.noise))
            keys = [gtsam.symbol("x", a), gtsam.symbol("x", b), gtsam.symbol("s", log)]
            factors.add(gtsam.CustomFactor(model, keys, _leg_factor(leg)))
        readings = sigmas(READING_SIGMA)
        for one in self.readings:
            if one.used:
                keys = gtsam.symbol("x", one.passage), marker(one.place)
                factors.add(gtsam.BetweenFactorPose2(*keys, gtsam.Pose2(*one.pose), readings))
        links = sigmas(math.sqrt(self.link_noise) * np.array(LINK_SIGMA))
        for one in self.links:
            if one.used:
                keys = marker(one.first), marker(one.second)
                factors.add(gtsam.BetweenFactorPose2(*keys, gtsam.Pose2(*one.pose), links))
        taped = sigmas([DISTANCE_SIGMA_MM], False)
        for a, b, mm in self.distances:
            factors.add(gtsam.RangeFactorPose2(marker(a), marker(b), mm, taped))
        for place, (x, y, heading) in self.given:
            known = sigmas((*PLACE_SIGMA[:2], PLACE_SIGMA[2] if heading is not None else 1e3), False)
            pose = gtsam.Pose2(x, y, heading if heading is not None else self.places[place][2])
            factors.add(gtsam.PriorFactorPose2(marker(place), pose, known))
        if self.anchor is not None:
            pose = gtsam.Pose2(*self.places[self.anchor])
            factors.add(gtsam.PriorFactorPose2(marker(self.anchor), pose, sigmas(_ANCHOR_SIGMA, False)))
        return factors


def _optimum(factors, values):
    """Newton's steps; where they do not come to rest, Levenberg's and Marquardt's. (The latter alone would
    do: but called from within GTSAM's threads the legs' factors, which are Python, take ten times as
    long.)"""
    gtsam = needed()
    before = factors.error(values)
    moved = values
    for _ in range(_ITERATIONS):
        moved = moved.retract(factors.linearize(moved).optimize())
        error = factors.error(moved)
        if not math.isfinite(error):
            break
        if abs(before - error) < _AT_REST * (1 + error):
            return moved
        before = error
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setMaxIterations(_ITERATIONS)
    return gtsam.LevenbergMarquardtOptimizer(factors, values, parameters).optimize()


def _leg_factor(leg: Leg):
    def error(this, values, jacobians):
        a, b, s = this.keys()
        one, other = values.atPose2(a), values.atPose2(b)
        carried = leg.carried(values.atVector(s))
        first, second = (one.x(), one.y(), one.theta()), (other.x(), other.y(), other.theta())
        off, by_first, by_second = _leg_error(first, second, carried)
        if jacobians is not None:
            jacobians[0], jacobians[1], jacobians[2] = by_first, by_second, -leg.by_shares
        return off

    return error


def _leg_error(a, b, carried):
    """(error, its slopes by the two poses in their own axes): where b is from a, minus where odometry
    says."""
    cos, sin = math.cos(a[2]), math.sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    ahead, left = cos * dx + sin * dy, cos * dy - sin * dx
    turn = math.remainder(b[2] - a[2] - carried[2], 2 * math.pi)
    off = np.array([ahead - carried[0], left - carried[1], turn])
    by_first = np.array([[-1.0, 0.0, left], [0.0, -1.0, -ahead], [0.0, 0.0, -1.0]])
    return off, by_first, axes(b[2] - a[2])


def _reading_error(pose, place, read):
    """(error, its slope (3, 6) by pose and place in their own axes) of a reading, in the axes of the pose."""
    off, by_pose, by_place = _leg_error(pose, place, read)
    return off, np.hstack([by_pose, by_place])
