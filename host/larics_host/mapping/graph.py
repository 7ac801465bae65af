"""The pose graph of a map, solved by GTSAM.

Unknown are the vehicle's pose in each passage, the pose of each marker, and the shares that a log's odometry
has in common, see wheels. Factors are the legs of odometry between passages, the readings of
passages, markers seen in one frame, distances and places that are given. Readings and what was seen together
are under a robust noise model (Huber's); which of them count at all is tested from outside, see `surprises`.
"""

from __future__ import annotations

import copy
import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from larics_host.errors import UserError, missing_package
from larics_host.mapping.association import READING_SIGMA
from larics_host.mapping.covariance import Covariance
from larics_host.mapping.poses import axes
from larics_host.mapping.wheels import SHARES, SHARES_SIGMA, Leg

Linear = Iterable[tuple[list, np.ndarray]]  # see Graph._linear
gtsam: Any
try:
    import gtsam
except ImportError:
    gtsam = None

LINK_SIGMA = (1.5, 1.5, 0.0025)  # of what some frames show together: mm, mm, rad
DISTANCE_SIGMA_MM = 3.0
PLACE_SIGMA = (3.0, 3.0, 0.01)
_ANCHOR_SIGMA = (0.01, 0.01, 1e-5)
_UNKNOWN_RAD = 1e3
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
    """Of a place, in the vehicle frame of a passage; both by number. used: whether it counts; is_misread:
    whether another ID was read there."""

    passage: int
    place: int
    pose: tuple
    used: bool = True
    is_misread: bool = False


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
    noise      of wheels that do not slip, see wheels
    noises     {passage: noise of the leg that begins there}, where it is another
    expected   the same on average over what may have been on it, slips or none
    slipped    {passage: how likely a wheel slipped on the leg that begins there}
    link_noise variance of links against LINK_SIGMA's
    read_noise variance of readings, and of what markers tell of legs, against READING_SIGMA's
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
    noises: dict = field(default_factory=dict)
    expected: dict = field(default_factory=dict)
    slipped: dict = field(default_factory=dict)
    link_noise: float = 1.0
    read_noise: float = 1.0

    def copy(self) -> Graph:
        """One that is solved, and whose readings and links are set aside, apart from this one."""
        kept = {one.name: copy.copy(getattr(self, one.name)) for one in fields(self)}
        kept["readings"], kept["links"] = (
            [replace(one) for one in kept[name]] for name in ("readings", "links")
        )
        return Graph(**kept)

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

    def marginals(self) -> Covariance:
        return Covariance(self, self._linear())

    def place_covariance(self, marginals: Covariance, numbers: list) -> np.ndarray:
        """(3 N, 3 N) covariance of places (x mm, y mm, rad) in the axes of the map."""
        size = 3 * len(numbers)
        turn = np.zeros((size, size))
        for k, number in enumerate(numbers):
            turn[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = axes(self.places[number][2])
        return turn @ marginals.places(numbers) @ turn.T

    def surprises(self, marginals: Covariance) -> np.ndarray:
        """For each reading the chi-squared (three degrees of freedom) by which it contradicts all others; 0
        where that is little, NaN where nothing else tells of its place."""
        noise = self.read_noise * np.diag(np.square(READING_SIGMA))
        found = np.full(len(self.readings), np.nan)
        for k, one in enumerate(self.readings):
            off, slope = _reading_error(self.poses[one.passage], self.places[one.place], one.pose)
            if one.used and np.sum(np.square(off / READING_SIGMA)) < _DOUBTED * self.read_noise:
                found[k] = 0.0
                continue
            fitted = slope @ marginals.reading(one.passage, one.place) @ slope.T
            spread = noise - fitted if one.used else noise + fitted
            if (
                one.used
                and np.linalg.eigvalsh(spread / np.sqrt(np.outer(np.diag(noise), np.diag(noise))))[0] < 1e-4
            ):
                continue
            found[k] = off @ np.linalg.solve(spread, off)
        return found

    def leg_noise(self, a: int) -> float:
        """Of the leg that begins at a passage."""
        return self.noises.get(a, self.noise)

    def leg_spreads(self, marginals: Covariance) -> tuple[list, list]:
        """(what odometry is off by on each leg, the covariance that is left of it)."""
        offs, spreads = [], []
        for log, a, b, leg in self.legs:
            off, by_first, by_second = _leg_error(self.poses[a], self.poses[b], leg.carried(self.shares[log]))
            slope = np.hstack([by_first, by_second, -leg.by_shares])
            offs.append(off)
            spreads.append(slope @ marginals.leg(a, b, log) @ slope.T)
        return offs, spreads

    def reading_fit(self, marginals: Covariance) -> tuple[float, float]:
        """(chi-squared of the readings that count, degrees of freedom of these)."""
        weight = _weight(READING_SIGMA) / self.read_noise
        squares = freedom = 0.0
        for one in self.readings:
            if one.used:
                off, slope = _reading_error(self.poses[one.passage], self.places[one.place], one.pose)
                fitted = slope @ marginals.reading(one.passage, one.place) @ slope.T
                squares += float(off @ weight @ off)
                freedom += 3 - float(np.sum(weight * fitted))
        return squares, freedom

    def loudness(self) -> float:
        """Noise of the legs as a whole, slips included."""
        ways = sum(leg.way_mm for *_, leg in self.legs)
        return sum(self.leg_noise(a) * leg.way_mm for _, a, _, leg in self.legs) / max(ways, 1.0)

    def squares(self) -> tuple[float, int]:
        """(chi-squared of readings and links that count, degrees of freedom of all)."""
        read = [self.reading_error(one) for one in self.readings if one.used]
        links = [square for one, square in zip(self.links, self.link_squares(), strict=True) if one.used]
        squares = sum(float(np.sum(np.square(off / READING_SIGMA))) for off in read)
        freedom = 3 * (len(self.legs) + len(read) + len(links) - len(self.poses) - len(self.places) + 1)
        return squares + sum(links) / self.link_noise, freedom + len(self.distances)

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

    def distance(self, a: int, b: int) -> tuple[float, np.ndarray]:
        """(mm between two places, its slope (1, 6) by them in their own axes); where they coincide, it is as
        long in any direction: that of x is taken."""
        off = np.subtract(self.places[b], self.places[a])
        mm = math.hypot(*off[:2])
        along = np.array([[*(off[:2] / mm), 0.0]] if mm else [[1.0, 0.0, 0.0]])
        return mm, np.hstack([-along @ axes(self.places[a][2]), along @ axes(self.places[b][2])])

    def link_squares(self) -> list[float]:
        """By how much each link is off, in squares of LINK_SIGMA."""
        return [float(np.sum(np.square(self.link_error(one) / LINK_SIGMA))) for one in self.links]

    def _linear(self):
        """The factors as `_factors` has them, not robust: yields ([(kind, number, slope)], weight)."""
        for log in self.shares:
            yield [("s", log, np.eye(SHARES))], _weight(SHARES_SIGMA)
        for log, a, b, leg in self.legs:
            _, by_a, by_b = _leg_error(self.poses[a], self.poses[b], leg.carried(self.shares[log]))
            weight = np.linalg.inv(leg.covariance(self.leg_noise(a), self.read_noise))
            yield [("x", a, by_a), ("x", b, by_b), ("s", log, -leg.by_shares)], weight
        weight = _weight(READING_SIGMA) / self.read_noise
        for one in self.readings:
            if one.used:
                slope = _reading_error(self.poses[one.passage], self.places[one.place], one.pose)[1]
                yield [("x", one.passage, slope[:, :3]), ("m", one.place, slope[:, 3:])], weight
        weight = _weight(LINK_SIGMA) / self.link_noise
        for one in self.links:
            if one.used:
                slope = _reading_error(self.places[one.first], self.places[one.second], one.pose)[1]
                yield [("m", one.first, slope[:, :3]), ("m", one.second, slope[:, 3:])], weight
        for a, b, _ in self.distances:
            _, slope = self.distance(a, b)
            yield [("m", a, slope[:, :3]), ("m", b, slope[:, 3:])], _weight([DISTANCE_SIGMA_MM])
        for place, (_, _, heading) in self.given:
            known = *PLACE_SIGMA[:2], PLACE_SIGMA[2] if heading is not None else _UNKNOWN_RAD
            yield [("m", place, np.eye(3))], _weight(known)
        if self.anchor is not None:
            yield [("m", self.anchor, np.eye(3))], _weight(_ANCHOR_SIGMA)

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
            model = noise.Gaussian.Covariance(leg.covariance(self.leg_noise(a), self.read_noise))
            keys = [gtsam.symbol("x", a), gtsam.symbol("x", b), gtsam.symbol("s", log)]
            factors.add(gtsam.CustomFactor(model, keys, _leg_factor(leg)))
        readings = sigmas(math.sqrt(self.read_noise) * np.array(READING_SIGMA))
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
            known = sigmas((*PLACE_SIGMA[:2], PLACE_SIGMA[2] if heading is not None else _UNKNOWN_RAD), False)
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


def _weight(sigmas):
    return np.diag(1 / np.square(sigmas))


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
