"""How well a solved pose graph knows what it knows: the covariances that its factors leave.

A drive is a chain of passages: given the places and the shares, a passage knows of the next one and of the
one before alone. So the chain is taken out block by block, what remains is as small as the map, and any
passage's part is found from that: a thousand passages take a moment, where a covariance of all would not fit.
Axes are those of each pose, as in the factors.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from larics_host.mapping.wheels import SHARES

if TYPE_CHECKING:
    from larics_host.mapping.graph import Graph, Linear


class Covariance:
    """Of a graph as it stands, robust models left out; linear: its factors there."""

    def __init__(self, graph: Graph, linear: Linear) -> None:
        self._row = {number: k for k, number in enumerate(sorted(graph.poses))}
        self._place = {number: slice(3 * k, 3 * k + 3) for k, number in enumerate(sorted(graph.places))}
        begin = 3 * len(graph.places)
        self._shares = {
            log: slice(begin + SHARES * k, begin + SHARES * (k + 1))
            for k, log in enumerate(sorted(graph.shares))
        }
        self._size = begin + SHARES * len(graph.shares)
        self._take_out(*self._information(linear))

    def _information(self, linear):
        """(blocks of each passage, of it and the next, of it and all that is global, of that itself)."""
        count = len(self._row)
        own, after = np.zeros((count, 3, 3)), np.zeros((count, 3, 3))
        crossed, common = np.zeros((count, 3, self._size)), np.zeros((self._size, self._size))
        for parts, weight in linear:
            for k, (kind, number, slope) in enumerate(parts):
                weighed = slope.T @ weight
                for other, another, tilt in parts[k:]:
                    block = weighed @ tilt
                    if kind != "x":
                        one, two = self._where(kind, number), self._where(other, another)
                        common[one, two] += block
                        if (kind, number) != (other, another):
                            common[two, one] += block.T
                    elif other != "x":
                        crossed[self._row[number], :, self._where(other, another)] += block
                    elif number == another:
                        own[self._row[number]] += block
                    else:
                        after[self._row[number]] += block
        return own, after, crossed, common

    def _where(self, kind, number):
        return self._place[number] if kind == "m" else self._shares[number]

    def _take_out(self, own, after, crossed, common):
        count = len(own)
        inverse = np.zeros_like(own)
        gains = np.zeros_like(own)
        reduced = crossed.copy()
        for k in range(count):
            block = own[k]
            if k:
                block = block - gains[k - 1].T @ after[k - 1]
                reduced[k] -= gains[k - 1].T @ reduced[k - 1]
            inverse[k] = np.linalg.inv((block + block.T) / 2)
            gains[k] = inverse[k] @ after[k]
        solved, alone = np.zeros_like(crossed), np.zeros_like(own)
        beside = np.zeros_like(own)
        for k in range(count - 1, -1, -1):
            solved[k], alone[k] = inverse[k] @ reduced[k], inverse[k]
            if k + 1 < count:
                solved[k] -= gains[k] @ solved[k + 1]
                beside[k] = -gains[k] @ alone[k + 1]
                alone[k] -= beside[k] @ gains[k].T
        left = common - np.einsum("nix,niy->xy", crossed, solved)
        self._common = np.linalg.inv((left + left.T) / 2)
        self._solved, self._alone, self._beside = solved, alone, beside

    def places(self, numbers: list[int]) -> np.ndarray:
        """(3 N, 3 N) of places."""
        rows = np.concatenate([np.arange(self._place[k].start, self._place[k].stop) for k in numbers])
        return self._common[np.ix_(rows, rows)]

    def reading(self, passage: int, place: int) -> np.ndarray:
        """(6, 6) of a passage and a place."""
        return self._joint((self._row[passage],), self._place[place])

    def leg(self, first: int, second: int, log: int) -> np.ndarray:
        """(6 + SHARES, ...) of a passage, the next one and the shares of a log."""
        return self._joint((self._row[first], self._row[second]), self._shares[log])

    def _joint(self, rows, where):
        solved = np.concatenate([self._solved[row] for row in rows])
        crossed = solved @ self._common
        poses = crossed @ solved.T
        for k, row in enumerate(rows):
            poses[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] += self._alone[row]
        if len(rows) > 1:
            poses[:3, 3:] += self._beside[rows[0]]
            poses[3:, :3] += self._beside[rows[0]].T
        aside = -crossed[:, where]
        return np.block([[poses, aside], [aside.T, self._common[where, where]]])
