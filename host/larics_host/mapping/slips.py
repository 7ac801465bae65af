"""On which legs a wheel slipped.

A slip is a way of one wheel that the other did not go and the encoders did not see. It adds to the noise of
its leg as much as its square, wherever on the leg it was. Whether there was one, and how large, is told by
all else: what a leg is off by, as the others and the readings have it without that leg, is likely under one
size or another. A leg counts as much as what is likely makes it; what is known in the end, it carries as that
is on average, since where nothing tells of a slip there may have been one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from larics_host.mapping.covariance import Covariance
from larics_host.mapping.graph import Graph

_SIZES_MM = np.array([0.0, 5.0, 12.0, 30.0])  # of a slip, standard deviations; none first
_OF_SIZE = np.array([0.4, 0.4, 0.2])  # shares of the slips
_PRIOR_M = 50.0  # of way with one slip, which is what is thought before
_CHANGED, _FEW = 0.4, 0.01  # of a leg's noise, and so many legs, that is worth solving anew
_STEP = 0.5  # of the way to it: legs that explain the same swing to and fro together at once
_BOUND = 1 - 1e-6  # of a leg that nothing else tells of


class Weighed(NamedTuple):
    """Whether the noise of legs changed so much that a graph has to be solved anew; of the legs on which no
    wheel slipped, the squares that they are off by and the degrees of freedom of these."""

    changed: bool
    squares: float
    freedom: float


def weigh(graph: Graph, marginals: Covariance) -> Weighed:
    """Gives each leg of a solved graph its noise, by what likely was on it."""
    metres = sum(leg.way_mm for *_, leg in graph.legs) / 1000
    rate = (1 + sum(graph.slipped.values())) / (_PRIOR_M + metres)
    changed = 0
    squares = freedom = 0.0
    offs, spreads = graph.leg_spreads(marginals)
    for (_, a, _, leg), off, spread in zip(graph.legs, offs, spreads, strict=True):
        before = graph.leg_noise(a)
        noises = graph.noise + _SIZES_MM**2 / max(leg.way_mm, 1.0)
        some = 1 - math.exp(-rate * leg.way_mm / 1000)
        likely = np.array([1 - some, *(some * _OF_SIZE)])
        alone = _alone(off, leg.covariance(before, graph.read_noise), spread)
        told = [alone.under(leg.covariance(noise, graph.read_noise)) for noise in noises]
        scores = np.log(likely) + [one.score for one in told]
        likely = np.exp(scores - scores.max())
        likely /= likely.sum()
        graph.slipped[a] = 1 - float(likely[0])
        wanted = float(likely @ np.log(noises)) - math.log(before)  # where it is not certain, in between
        graph.noises[a] = before * math.exp(_STEP * wanted)
        graph.expected[a] = float(likely @ noises)
        changed += abs(wanted) > _CHANGED
        squares += likely[0] * told[0].squares
        freedom += likely[0] * told[0].freedom
    return Weighed(changed > _FEW * len(graph.legs), squares, freedom)


class _Told(NamedTuple):
    """Of a leg with some covariance: log likelihood, up to a summand; the squares that it would be off by as
    it is settled with the others, and the degrees of freedom of these."""

    score: float
    squares: float
    freedom: float


class _Alone(NamedTuple):
    """What a leg is off by as all others and the readings have it without that leg, and the covariance of
    that, both in axes in which the latter is diagonal; into: turns into these."""

    off: np.ndarray
    rest: np.ndarray
    into: np.ndarray

    def under(self, within: np.ndarray) -> _Told:
        own = self.into @ within @ self.into.T
        covariance = np.diag(self.rest) + own
        weighed = np.linalg.solve(covariance, self.off)
        score = -0.5 * (float(self.off @ weighed) + np.linalg.slogdet(covariance)[1])
        freedom = np.trace(np.linalg.solve(covariance, own))
        return _Told(score, float(weighed @ own @ weighed), float(freedom))


def _alone(off, within, spread):
    """An _Alone of what is left of a leg where it counts with the covariance within, and the covariance of
    that."""
    back = np.linalg.inv(np.linalg.cholesky(within))
    shares, sides = np.linalg.eigh(back @ spread @ back.T)
    shares = np.clip(shares, 0.0, _BOUND)
    into = sides.T @ back
    return _Alone(into @ off / (1 - shares), shares / (1 - shares), into)
