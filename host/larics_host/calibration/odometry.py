"""What a vehicle's odometry leaves out, from a log of a drive by markers: scale, turn and drift, and noise.

The log has POSE and MOTION of the same frames, as a camera sends them that has a map and is told of the
wheels. Between frames with a marker, from one marker to the next or along one, the way by the markers is
compared with that by odometry.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from larics.wire import messages as m
from larics_host.connection.receiver import Receiver
from larics_host.errors import UserError
from larics_host.logs.log_reader import read_pieces
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics_host.annotations import StrPath

_WINDOW_MM, _LEAST_MM = 600.0, 300.0  # along one marker; from one to another
_TURN_DEG = 60.0  # on the spot
_LONGEST_MM = 20000.0
_LEGS_LEAST = 4  # from marker to marker
_TURNS_LEAST = 4
_SAME_MM, _SAME_DEG = 0.5, 0.05  # scatter along one marker
_SCALE_LEAST_PPM, _DRIFT_LEAST_MDEG_M = 300, 50  # no drive tells it better for the next one
_MOST_SHARE = 0.1
_MOST_DRIFT_DEG_M = 15.0


@dataclass
class Window:
    """turned_deg, forward_mm, way_mm: by odometry (turn, the ways with and without sign), and its steps,
    (N, 3): forward mm, left mm, turn deg; driven_mm, more_deg: the distance by the markers, how much larger
    the turn was; sigma_mm, sigma_deg: how well they say it."""

    steps: np.ndarray
    turned_deg: float
    forward_mm: float
    way_mm: float
    driven_mm: float
    more_deg: float
    sigma_mm: float
    sigma_deg: float
    along_one: bool  # along one marker: there the camera's own scale decides, not that of the map

    def told_mm(self, turn: float, drift_deg_m: float) -> float:
        """The distance by odometry, its turns put right."""
        forward, left, turned = self.steps.T
        turns = turned * (1 + turn) + drift_deg_m * forward / 1000
        middles = np.radians(np.cumsum(turns) - turns / 2)
        x = np.sum(forward * np.cos(middles) - left * np.sin(middles))
        return float(math.hypot(x, np.sum(forward * np.sin(middles) + left * np.cos(middles))))


@dataclass
class Shares:
    """scale, turn (shares), drift_deg_m, each with its standard deviation; turn_sigma None when the drive
    does not tell; noise_mm2_km: variance of a wheel's way; windows: how many were compared."""

    scale: float
    scale_sigma: float
    turn: float
    turn_sigma: float | None
    drift_deg_m: float
    drift_sigma: float
    noise_mm2_km: float
    windows: int

    def settings(self) -> dict[str, int]:
        """The settings that say so; what is not told is left out."""
        found = {
            "odometry_scale_ppm": round(self.scale * 1e6),
            "odometry_scale_sigma_ppm": max(_SCALE_LEAST_PPM, round(self.scale_sigma * 1e6)),
            "odometry_drift_mdeg_m": round(self.drift_deg_m * 1000),
            "odometry_drift_sigma_mdeg_m": max(_DRIFT_LEAST_MDEG_M, round(self.drift_sigma * 1000)),
            "odometry_noise_mm2_km": min(250000, max(100, round(self.noise_mm2_km))),
        }
        if self.turn_sigma is not None:
            found["odometry_turn_ppm"] = round(self.turn * 1e6)
            found["odometry_turn_sigma_ppm"] = max(_SCALE_LEAST_PPM, round(self.turn_sigma * 1e6))
        return found


def _wrapped(degrees):
    return (degrees + 180) % 360 - 180


def frames_of(path: StrPath) -> Iterator[tuple[Any, Any]]:
    """(POSE or None, MOTION) records of the frames of a log that have a MOTION, in order."""
    receiver, pose = Receiver(), None
    for piece in read_pieces(path):
        for message in receiver.feed(piece.data, piece.time_s or 0.0):
            if message.name == "POSE":
                pose = message.fields
            elif message.name == "MOTION" and message.fields.state != m.MOTION_NONE:
                same = pose is not None and pose.frame == message.fields.frame
                yield (pose if same else None), message.fields


class _Anchor:
    """A frame with a marker, and what odometry told since."""

    def __init__(self, pose, motion):
        self.pose, self.motion = pose, motion
        self.forward_mm = self.way_mm = self.turned_deg = 0.0
        self.steps: list[tuple[float, float, float]] = []

    def go_on(self, before, now):
        dx, dy = (now.x_mm10 - before.x_mm10) / 10, (now.y_mm10 - before.y_mm10) / 10
        turned = _wrapped((now.heading_cdeg - before.heading_cdeg) / 100)
        middle = math.radians(before.heading_cdeg / 100 + turned / 2)
        forward, left = (
            dx * math.cos(middle) + dy * math.sin(middle),
            dy * math.cos(middle) - dx * math.sin(middle),
        )
        self.steps.append((forward, left, turned))
        self.forward_mm += forward
        self.way_mm += math.hypot(dx, dy)
        self.turned_deg += turned

    def window(self, pose, motion):
        first, same = self.pose, self.pose.id == pose.id
        driven = math.hypot(pose.x_mm10 - first.x_mm10, pose.y_mm10 - first.y_mm10) / 10
        turned = (pose.heading_cdeg - first.heading_cdeg) / 100
        sigmas_mm = [max(one.sigma_x_mm10, one.sigma_y_mm10) / 10 for one in (first, pose)]
        sigmas_deg = [one.sigma_cdeg / 100 for one in (first, pose)]
        return Window(
            np.array(self.steps),
            self.turned_deg,
            self.forward_mm,
            self.way_mm,
            driven,
            _wrapped(turned - self.turned_deg),
            _SAME_MM if same else math.hypot(*sigmas_mm),
            _SAME_DEG if same else math.hypot(*sigmas_deg),
            same,
        )


def windows_of(frames: Iterable[tuple[Any, Any]]) -> Iterator[Window]:
    """The Windows of the frames of `frames_of`."""
    anchor = before = None
    for pose, motion in frames:
        if before is not None and before.epoch != motion.epoch:
            anchor = None
        if anchor is not None and before is not None:
            anchor.go_on(before, motion)
        before = motion
        if pose is None or pose.state != m.TRACKING:
            continue
        if anchor is not None and anchor.way_mm < _LONGEST_MM:
            long = anchor.way_mm >= (_WINDOW_MM if pose.id == anchor.pose.id else _LEAST_MM)
            spot = pose.id == anchor.pose.id and abs(anchor.turned_deg) >= _TURN_DEG
            if not long and not spot and pose.id == anchor.pose.id:
                continue
            if long or spot:
                yield anchor.window(pose, motion)
        anchor = _Anchor(pose, motion)


def _fit(told, missed, sigmas):
    """(slopes, standard deviations, residuals) of missed = told @ slopes, with slips as outliers."""
    from scipy.optimize import least_squares

    def residuals(slopes):
        return (missed - told @ slopes) / sigmas

    found = least_squares(residuals, np.zeros(told.shape[1]), loss="soft_l1", f_scale=2.0)
    left = residuals(found.x)
    spread = max(1.0, 1.4826 * float(np.median(np.abs(left))))
    weighted = told / sigmas[:, None]
    variances = np.linalg.pinv(weighted.T @ weighted).diagonal()
    return found.x, spread * np.sqrt(variances), left * sigmas


def fit(windows: Iterable[Window], track_mm: float) -> Shares:
    """The Shares of the windows. UserError when they are too few, or contradict each other."""
    ways = [one for one in windows if one.way_mm < _LONGEST_MM]
    legs = [one for one in ways if not one.along_one and one.driven_mm >= _LEAST_MM]
    if len(legs) < _LEGS_LEAST:
        raise UserError(
            "%s from marker to marker, of %d at least: drive on, with the map and odometry in use"
            % (counted(len(legs), "way"), _LEGS_LEAST)
        )
    turns = sum(abs(one.turned_deg) >= _TURN_DEG for one in ways) >= _TURNS_LEAST
    columns = [[one.forward_mm / 1000, one.turned_deg if turns else 0.0] for one in ways]
    sigmas = np.array([math.hypot(one.sigma_deg, 0.1 * math.sqrt(one.way_mm / 1000)) for one in ways])
    slopes, spreads, left = _fit(np.array(columns), np.array([one.more_deg for one in ways]), sigmas)
    told = np.array([one.told_mm(slopes[1], slopes[0]) for one in legs])
    scale, scale_sigma, _ = _fit(
        told[:, None],
        np.array([one.driven_mm for one in legs]) - told,
        np.array([math.hypot(one.sigma_mm, 0.002 * one.way_mm) for one in legs]),
    )
    wheels = [
        (math.radians(off) ** 2 - math.radians(one.sigma_deg) ** 2) * track_mm**2 / 2 / one.way_mm
        for off, one in zip(left, ways, strict=True)
        if one.way_mm >= _LEAST_MM
    ]
    # 0.455: the median of the square of a normal value
    noise_mm2_km = 1e6 * max(0.0, float(np.median(wheels)) / 0.455)
    shares = Shares(
        float(scale[0]), float(scale_sigma[0]), float(slopes[1]), float(spreads[1]) if turns else None,
        float(slopes[0]), float(spreads[0]), noise_mm2_km, len(ways),
    )  # fmt: skip
    wrong = max(abs(shares.scale), abs(shares.turn)) > _MOST_SHARE
    if wrong or abs(shares.drift_deg_m) > _MOST_DRIFT_DEG_M:
        raise UserError(
            "odometry and markers differ by %.0f %% of the way, %.0f %% of the turn, %.1f degrees a metre: "
            "check its unit, sign and axes" % (100 * shares.scale, 100 * shares.turn, shares.drift_deg_m)
        )
    return shares
