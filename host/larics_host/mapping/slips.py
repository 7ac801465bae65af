"""On which legs a wheel slipped.

A slip is a way of one wheel that the other did not go and the encoders did not see. It adds to the noise of
its leg as much as its square, wherever on the leg it was. Whether there was one, and how large, is told by
all else: what a leg is off by, as the others and the readings have it without that leg, is likely under one
size or another. A leg counts as much as what is likely makes it.
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
        within = leg.covariance(before)
        noises = graph.noise + _SIZES_MM**2 / max(leg.way_mm, 1.0)
        some = 1 - math.exp(-rate * leg.way_mm / 1000)
        likely = np.array([1 - some, *(some * _OF_SIZE)])
        likely = likely * _likelihoods(off, within, spread, [leg.covariance(noise) for noise in noises])
        likely /= likely.sum()
        graph.slipped[a] = 1 - float(likely[0])
        graph.noises[a] = math.exp(float(likely @ np.log(noises)))  # where it is not certain, in between
        changed += abs(math.log(graph.noises[a] / before)) > _CHANGED
        squares += likely[0] * float(off @ np.linalg.solve(within, off))
        freedom += likely[0] * (3 - float(np.trace(np.linalg.solve(within, spread))))
    return Weighed(changed > _FEW * len(graph.legs), squares, freedom)


def _likelihoods(off, within, spread, others):
    """How likely a leg is, up to a factor, with each of other covariances than that within which it
    counted: by what all but the leg itself says. off, spread: what is left of it where it counts, and the
    covariance of that."""
    root = np.linalg.cholesky(within)
    back = np.linalg.inv(root)
    shares, sides = np.linalg.eigh(back @ spread @ back.T)
    shares = np.clip(shares, 0.0, _BOUND)
    alone = sides.T @ back @ off / (1 - shares)
    rest = np.diag(shares / (1 - shares))
    found = []
    for other in others:
        covariance = rest + sides.T @ back @ other @ back.T @ sides
        square = alone @ np.linalg.solve(covariance, alone)
        found.append(-0.5 * (square + np.linalg.slogdet(covariance)[1]))
    return np.exp(np.array(found) - max(found))
