"""Medians and other statistics."""

import numpy as np

from .compare import numbers, same


def median(before, after, result):
    values, _, _, first, count, _ = before
    assert result == sorted(values[first : first + count])[count // 2]


def deepest(before, after, result):
    depths, _, _, directions, apart, _ = before
    where = int(np.argmax(numbers(depths, directions)))
    others = [
        depths[k] for k in range(directions) if apart < (k - where) % directions < directions - apart
    ]  # fmt: skip
    same(after[5], (where, depths[where], max(others)))
    assert result == where


def ink_noise(before, after, result):
    ink, _, _, directions, apart = before
    values = numbers(ink, directions)
    second = np.abs(2 * values - np.roll(values, -apart) - np.roll(values, apart))
    limit = 1 << 20
    for _ in range(4):
        kept = second[second < limit]
        limit = 3 * kept.sum() // (len(kept) + 1) + 3
    assert result == kept.sum() // (len(kept) + 1)


def sector_levels(before, after, result):
    sectors, _, _, amplitude, background, least_match, wide, local, _ = before
    amplitudes, backgrounds, matches = numbers(sectors).reshape(3, 32)
    good = (matches >= least_match) & (5 * amplitudes >= 2 * amplitude) & (amplitudes <= 2 * amplitude)
    assert result == good.sum()
    for sector in range(32):
        window = np.arange(sector - wide, sector + wide + 1) % 32
        counted = window[good[window]]
        expected = (amplitude, background)
        if local and len(counted) > wide:
            expected = amplitudes[counted].sum() // len(counted), backgrounds[counted].sum() // len(counted)
        assert (after[8][sector], after[8][32 + sector]) == expected, sector


ORACLES = {
    "sectors": (
        median,
        sector_levels,
    ),
    "blurred_lines": (
        deepest,
        ink_noise,
    ),
}
