"""The direct reader's rings."""

import numpy as np

from larics.kernels import layouts as at

from .compare import BIAS, close, numbers, same


def begin_pass(before, after, result):
    fit, limit = before
    x, y = ((fit[k] - BIAS + 2) // 4 for k in (at.FIT_X_Q10, at.FIT_Y_Q10))
    radius = fit[at.FIT_RADIUS_Q8]
    inside = 0 <= x < 256 * fit[at.FIT_WIDTH] and 0 <= y < 256 * fit[at.FIT_HEIGHT]
    assert result == (inside and radius >= 1536)
    if not result:
        return
    found = after[0]
    gap = radius * fit[at.FIT_GAP_Q10] / 1024
    window = found[at.FIT_WINDOW_Q8]
    # at least 300 and at most the gap, from 640 on an eighth less, at most 14 px
    expected = max(300, gap) if gap <= 640 else min(3584, max(640, gap * 7 / 8))
    assert abs(window - expected) <= 2
    assert (found[at.FIT_X_Q8], found[at.FIT_Y_Q8]) == (x, y)
    assert abs(found[at.FIT_LIMIT_Q10] - window * limit / 64) <= 1
    line = radius * fit[at.FIT_LINE_Q10] / 1024
    area = fit[at.FIT_AREA]
    if area:
        assert abs(found[at.FIT_LEAST_AREA] - area * 3 / 8) <= 1
        assert abs(found[at.FIT_CLIP] - 32 * area / line) <= 1 + area / line
    else:
        assert found[at.FIT_CLIP] == 8 and abs(found[at.FIT_LEAST_AREA] - line * 12 / 256) <= 1


def skip_half_sectors(before, after, result):
    _, _, bits, code, least, angle, reach, outer, inner = before
    expected = [0] * 32
    marked = {outer: 0, inner: 0}
    for line in range(4 if bits else 0):
        near, far = (code[2 * line * at.POSITION_ITEMS + k] - BIAS for k in (2, 3))
        if line and near + far <= least:
            continue
        turned = (angle - line * 16384) % 65536  # counterclockwise as seen
        for k in range((turned - reach) // 2048, (turned + reach) // 2048 + 1):
            expected[k % 32] |= inner if line else outer
            marked[inner if line else outer] += 1
    same(after[0], expected)
    assert result == marked[outer] + 64 * marked[inner]


def _ring_model(ring, angles):
    a0, a1, b1, a2, b2 = (ring[k] - BIAS for k in range(5))
    model = a0 + a1 * np.cos(angles) + b1 * np.sin(angles)
    return model + a2 * np.cos(2 * angles) + b2 * np.sin(2 * angles)


def ring_harmonics(before, after, result):
    _, _, _, sectors, _, _, _, rounds, floor, _, _ = before
    angles = 2 * np.pi * (np.arange(16) + 0.5) / 16
    holds = True
    for ring, found in enumerate((after[9], after[10])):
        tried, areas, counted, sums = numbers(sectors)[64 * ring : 64 * ring + 64].reshape(16, 4).T
        inside = tried > 0
        usable = inside & (2 * counted >= tried) & (sums // np.maximum(1, counted) > 0)
        assert found[at.RING_INSIDE] == inside.sum()
        means = np.where(usable, sums // np.maximum(1, counted) - 32768, 0)
        mean_areas = np.where(inside, areas // np.maximum(1, tried) + 1, 0)
        if usable.any():
            assert found[at.RING_MEAN_AREA] == mean_areas[usable].sum() // usable.sum()
        holds = holds and found[at.RING_USED] >= 5 and 2 * found[at.RING_USED] >= inside.sum()
        assert found[at.RING_USED] <= usable.sum()
        if not usable.all() or rounds < 3:
            continue
        design = np.stack(
            (np.ones(16), np.cos(angles), np.sin(angles), np.cos(2 * angles), np.sin(2 * angles))
        )
        expected = np.linalg.lstsq(design.T, means, rcond=None)[0]
        off = np.abs(means - expected @ design)
        if off.max() < max(floor, 3.5 * off.mean()) and np.abs(means).max() < 8000:  # nothing is left out
            assert found[at.RING_USED] == 16
            scale = max(4, np.abs(means).max() // 100)  # units are 1/128, so the fit is within a percent
            close([found[k] - BIAS for k in range(5)], expected, scale)
            close(found[at.RING_DEVIATION], off.mean(), scale)
    assert result == holds
    assert not any(after[3])


def end_pass(before, after, result):
    fit, outer, inner = before
    found = after[0]
    x, y = ((outer[k] + inner[k]) / 2 - BIAS for k in (at.RING_COS, at.RING_SIN))
    assert abs(found[at.FIT_X_Q10] - BIAS - 4 * fit[at.FIT_X_Q8] - x) <= 1
    assert abs(found[at.FIT_Y_Q10] - BIAS - 4 * fit[at.FIT_Y_Q8] - y) <= 1
    growth = outer[at.RING_CONSTANT] - BIAS
    assert abs(found[at.FIT_RADIUS_Q8] - fit[at.FIT_RADIUS_Q8] - growth / 4) <= 1
    inner_growth = inner[at.RING_CONSTANT] - BIAS
    assert abs(found[at.FIT_INNER_Q8] - fit[at.FIT_INNER_Q8] - inner_growth / 4) <= 1
    assert abs(found[at.FIT_MOVED_Q10] - max(abs(growth), abs(x), abs(y))) <= 1
    assert found[at.FIT_AREA] == (outer[at.RING_MEAN_AREA] + inner[at.RING_MEAN_AREA]) // 2
    ratio = fit[at.FIT_INNER_Q10] / 1024
    for item, bulge in ((at.RING_COS_2, at.FIT_BULGE_COS), (at.RING_SIN_2, at.FIT_BULGE_SIN)):
        expected = (outer[item] - BIAS + (inner[item] - BIAS) / ratio) / 2
        assert abs(found[bulge] - fit[bulge] - expected) <= 2
    apart = [outer[k] - inner[k] for k in (at.RING_COS, at.RING_SIN)]
    assert result == (max(map(abs, apart)) < 3000)
    if not result:
        return
    deviations = [min(3200, ring[at.RING_DEVIATION]) for ring in (outer, inner)]
    noise = sum(d * d for d in deviations) * 50 / 128 + 4
    prior = (found[at.FIT_RADIUS_Q8] / 16) ** 2 * 32 / 230400
    signal = max(sum(d * d for d in apart) - noise, prior * prior)
    weight = fit[at.FIT_BEYOND_Q8] / 256 * signal / (signal + noise)
    for k, true, mean in (
        (0, at.FIT_TRUE_X_Q10, at.FIT_X_Q10),
        (1, at.FIT_TRUE_Y_Q10, at.FIT_Y_Q10),
    ):
        expected = -apart[k] * weight
        assert abs(found[true] - found[mean] - expected) <= 3 + abs(expected) / 25


ORACLES = {
    "rings": (
        begin_pass,
        skip_half_sectors,
    ),
    "harmonics": (
        ring_harmonics,
        end_pass,
    ),
}
