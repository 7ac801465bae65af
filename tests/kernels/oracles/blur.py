"""The model of blur: blurred bars, templates of rings, their matches."""

import math

import numpy as np

from larics.kernels import layouts as at

from .compare import close, numbers, same


def _line_through(width, motion, sigma, distances):
    """Darkness (of 1024) at distances from the middle of a blurred line, by summing up a fine picture."""
    step = 4.0
    x = np.arange(-8192, 8193) * step
    line = (np.abs(x) <= width / 2).astype(float)
    for box in (max(1.0, motion / step),):
        cells = max(1, round(box))
        line = np.convolve(line, np.ones(cells) / cells, "same")
    reach = int(4 * sigma / step) + 1
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) * step / sigma) ** 2)
    line = np.convolve(line, kernel / kernel.sum(), "same")
    return 1024 * np.interp(distances, x, line)


def blurred_bars(before, after, result):
    _, _, _, width, motion, sigma, _, rel, step, count, slot, bars = before
    expected = numbers(bars)
    for number, one in enumerate(range(rel, 17, step)):
        across = max(256, motion * math.cos(math.pi * one / 32))
        place = slot + 24 * step * number
        profile = _line_through(width, across, sigma, np.arange(count) * 256.0)
        wide = width >= 64 and sigma >= 64  # finer than the oracle's own picture otherwise
        close(after[11][place : place + count], profile, 14 if wide else 1024)
        expected[place : place + count] = after[11][place : place + count]
    same(after[11], expected)  # nothing else is written


def _rings(bar):
    """Darkness of both rings at the units 13..28, and the derivatives of the outer and the inner one."""
    units = np.arange(13, 29)

    def ring(place, shift=0):
        return bar[np.abs(units - place + shift)]

    both = ring(24) + ring(16)
    outer = (ring(24, 1) - ring(24, -1)) // 2
    inner = (ring(16, 1) - ring(16, -1)) // 2
    return both, outer, inner


def ring_templates(before, after, result):
    bars, _, _, rel, step, _, _ = before
    for one in range(rel, 17, step):
        bar = numbers(bars)[24 * one : 24 * one + 24]
        found = numbers(after[5])[48 * one : 48 * one + 48].reshape(3, 16) - 32768
        for kind, profile in enumerate(_rings(bar)):
            close(found[kind], profile - profile.mean(), 1)
            assert found[kind].sum() == 0
            assert after[6][8 * one + kind] == (found[kind] ** 2).sum()
        assert after[6][8 * one + 3] == (found[1] * found[2]).sum() + (1 << 28)
        assert after[6][8 * one + 4] == _rings(bar)[0].sum() // 16


def fold_templates(before, after, result):
    bars, _, _, rel, step, _, _ = before
    for one in range(rel, 17, step):
        bar = numbers(bars)[24 * one : 24 * one + 24]
        both = _rings(bar)[0]
        # the unit 20 + d looks like 20 - d; 28 has no counterpart
        same(after[5][48 * one : 48 * one + 9], both[7:])
        assert after[6][8 * one + 5] == both.sum() and after[6][8 * one + 6] == both[7:].sum()
        assert abs(after[6][8 * one] - ((both - both.mean()) ** 2).sum()) <= 1


def fold_sectors(before, after, result):
    _, _, means, sectors, _, _ = before
    pairs = numbers(means, 32 * sectors).reshape(sectors, 2, 16).sum(axis=1) - 65536
    for sector in range(sectors):
        pair = pairs[sector]
        expected = [pair[7] + 16384]
        expected += [pair[7 + k] + pair[7 - k] + 16384 for k in range(1, 8)]
        expected += [pair[15] + 16384, pair.sum()]
        same(numbers(after[4])[10 * sector : 10 * sector + 9], [value & 65535 for value in expected[:9]])
        assert after[4][10 * sector + 9] == expected[9] & 65535
        assert after[5][sector] == ((pair // 2) ** 2).sum() + 16


def _match(fold, power, template, square):
    """Squared correlation (of 1024) of a folded sector with a folded template; 0 for bright rings."""
    fold = np.asarray(fold, float) - 16384
    template = np.asarray(template, float)
    weights = np.array([1] + [2] * 7 + [1])
    mean = (template * weights).sum() / 16
    # a fold adds up what belongs to the same item
    product = -(fold * (template - mean)).sum() / 2
    if product <= 0 or square <= 0:
        return 0
    return min(1024, 1024 * product * product / (square * power))


def match_sectors(before, after, result):
    _, _, folds, templates, sectors, powers, sums, rel, step, _ = before
    for one in range(rel, 17, step):
        for sector in range(sectors):
            found = after[9][one * sectors + sector]
            fold = folds[10 * sector : 10 * sector + 9]
            template = templates[48 * one : 48 * one + 9]
            expected = _match(fold, powers[sector], template, sums[8 * one])
            assert abs(found - expected) <= 24 + expected / 20, (one, sector, found, expected)


def best_direction(before, after, result):
    _, _, matches, sectors, step, offset, floor, direction, pitch, _ = before
    best = (-1, None)
    for one in range(direction, 32, pitch):
        rels = [(offset + sector * step - one) % 32 for sector in range(sectors)]
        rels = [min(rel, 32 - rel) for rel in rels]
        total = sum(max(floor, matches[rel * sectors + sector]) for sector, rel in enumerate(rels))
        if total > best[0]:
            best = total, one
    assert (result, after[9][0]) == best


def match_direction(before, after, result):
    folds, _, _, templates, sectors, powers, sums, step, offset, motion_axis, floor = before
    expected = 0
    for sector in range(sectors):
        rel = (offset + sector * step - motion_axis) % 32 if motion_axis < at.STILL else 0
        rel = min(rel, 32 - rel)
        fold = folds[10 * sector : 10 * sector + 9]
        match = _match(fold, powers[sector], templates[48 * rel : 48 * rel + 9], sums[8 * rel])
        expected += max(floor, match)
    assert abs(result - expected) <= 8 * sectors + expected / 20


ORACLES = {
    "blur": (
        blurred_bars,
        ring_templates,
        fold_templates,
        fold_sectors,
        match_sectors,
        best_direction,
        match_direction,
    ),
}
