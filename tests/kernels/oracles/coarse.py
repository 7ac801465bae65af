"""A candidate at a first look: coarse radius, dark directions, light behind the code."""

import math

import numpy as np

from larics.kernels import layouts as at

from .compare import BIAS, LOG, close, numbers, same


def edge_distances(before, after, result):
    _, _, edges, _, count, radii, cx, cy, axes, _ = before
    width, reach = radii[at.RADII_WIDTH], radii[at.RADII_REACH_Q4]
    half_line, slack = radii[at.RADII_HALF_LINE_Q4], radii[at.RADII_SLACK_Q4]
    least, most = [], []  # what surely belongs, and what may by rounding
    for edge in edges[:count]:
        direction = edge >> 20
        y, x = divmod(edge & 0xFFFFF, width)
        x, y = 16 * x - cx, 16 * y - cy
        angle = 2 * math.pi * direction / 48
        along = x * math.cos(angle) + y * math.sin(angle)
        off = abs(x * math.sin(angle) - y * math.cos(angle))
        if along < 0:
            along, direction = half_line - along, (direction + 24) % 48
        else:
            along -= half_line
        near = max(abs(x), abs(y))
        if near < reach and off < slack - 2 and 2 < along < reach - 2:
            least.append((along, direction))
        if near < reach and off < slack + 2 and -2 < along < reach + 2:
            most.append((along, direction))
    found = [(value & 0xFFFF, value >> 16) for value in after[9][:result]]
    if result < radii[at.RADII_CAPACITY]:
        assert len(least) <= result <= len(most)
        for distance, direction in least:
            assert any(abs(one - distance) <= 2 and other == direction for one, other in found)
    for distance, direction in found:
        assert any(abs(one - distance) <= 2 and other == direction for one, other in most)


def choose_radius(before, after, result):
    _, _, _, radii, distances, count, _, rounds, _ = before
    if not count:
        assert result == 0
        return
    found = numbers(after[8])
    angles = 2 * np.pi * (numbers(distances, count) >> 16) / 48
    lengths = numbers(distances, count) & 0xFFFF
    if rounds == 1:  # no shift has been taken into account
        bins = np.bincount(lengths // 8, minlength=radii[at.RADII_BINS] + 3)
        kernel = (1, 1, 2, 1, 1)

        def edges_near(place):
            return int(np.minimum(255, bins[place - 2 : place + 3]) @ kernel)

        best, radius = -1, 0
        for place in range(radii[at.RADII_FIRST], radii[at.RADII_LAST] + 1):
            outer = edges_near(place)
            inner = edges_near((place * radii[at.RADII_INNER_Q10] + 512) >> 10)
            score = outer + (inner if inner <= outer else outer + (inner - outer) // 4)
            if score > best:
                best, radius = score, 8 * place + 4
        inner = (radius * radii[at.RADII_INNER_Q10] + 512) >> 10
        off = np.where(np.abs(lengths - radius) <= 40, lengths - radius, lengths - inner)
        on_outer = np.abs(lengths - radius) <= 40
        on_inner = ~on_outer & (np.abs(lengths - inner) < 32)
        on = on_outer | on_inner
        assert (found[3], found[4]) == (on_outer.sum(), on_inner.sum()) and result == on.sum()
        assert abs(found[0] - radius - off[on].mean()) <= 1
        close(
            found[1:3],
            (2 * (off[on] * np.cos(angles[on])).mean(), 2 * (off[on] * np.sin(angles[on])).mean()),
            2,
        )
    assert result == found[3] + found[4] <= count


def annulus_profile(before, after, result):
    _, _, image, _, _, _, fit, shape, profile = before
    width, height = fit[at.FIT_WIDTH], fit[at.FIT_HEIGHT]
    cx, cy = ((fit[k] - BIAS) / 1024 for k in (at.FIT_TRUE_X_Q10, at.FIT_TRUE_Y_Q10))
    if not (0 <= cx < width and 0 <= cy < height):
        assert result == 0
        return
    stride, samples = shape[at.SHAPE_AROUND_STRIDE], shape[at.SHAPE_AROUND_SAMPLES]
    radius = fit[at.FIT_RADIUS_Q8] / 256
    first, last = (radius * shape[k] / 1024 for k in (at.SHAPE_AROUND_FIRST, at.SHAPE_AROUND_LAST))
    found = numbers(after[8])
    assert result == np.count_nonzero(found)
    picture = LOG[numbers(image).reshape(height, width)]
    for slot, k in enumerate(range(0, 256, stride)):
        angle = 2 * math.pi * k / 256
        low = high = 1
        for distance in np.linspace(first, last, samples):
            x, y = cx + distance * math.cos(angle), cy + distance * math.sin(angle)
            if not (1.1 <= x < width - 2.1 and 1.1 <= y < height - 2.1):
                low = None
                break
            # rounding may take the next pixel
            columns = {math.floor(x + 0.5 + e) for e in (-0.06, 0.06)}
            rows = {math.floor(y + 0.5 + e) for e in (-0.06, 0.06)}
            seen = [picture[row, column] for row in rows for column in columns]
            low += min(seen)
            high += max(seen)
        if low is not None and found[slot]:
            assert low <= found[slot] <= high, (k, low, found[slot], high)


def dark_directions(before, after, result):
    profile, _, _, directions, near, far, apart, _, capacity, _ = before
    values = numbers(profile, directions)
    right = np.roll(values, -near) + np.roll(values, -far)
    left = np.roll(values, near) + np.roll(values, far)
    depths = np.where(values > 0, np.maximum(0, np.minimum(left, right) // 2 - values), 0)
    expected, least = [], 1
    while len(expected) < capacity and depths.max() >= least:
        where = int(np.argmax(depths))
        if not expected:
            least = 3 * int(depths[where]) // 8 + 1
        expected.append((where, int(depths[where])))
        depths[np.arange(where - apart, where + apart + 1) % directions] = 0
    assert result == len(expected)
    same(after[9][: 2 * result], [value for pick in expected for value in pick])


def quarter_phase(before, after, result):
    profile, _, _, _, directions, _ = before
    values = numbers(profile, directions)
    assert result == np.count_nonzero(values)
    wave = np.exp(-4j * 2 * np.pi * np.arange(directions) / directions)  # angles are clockwise, y points down
    expected = 16 * (values * wave).sum()
    found = complex(after[5][0] - BIAS, after[5][1] - BIAS)
    # each of the products is rounded down; which way the sine counts does not matter here
    off = min(abs(found - expected), abs(found - expected.conjugate()))
    assert off <= 2 * directions + abs(expected) / 100


def take_sample(before, after, result):
    frame, kept, _, _, step, count, _ = before
    seen = numbers(frame)[: step * (count - 1) + 1 : step]
    different = np.count_nonzero(seen != numbers(kept, count))
    same(after[6], (different, seen.min(), seen.max(), seen.sum()))
    same(after[1][:count], seen)


def code_light(before, after, result):
    positions = numbers(before[1], 8 * at.POSITION_ITEMS).reshape(8, at.POSITION_ITEMS)
    levels = positions[:, at.POSITION_LEVEL]
    between = positions[1::2, 2:4] - BIAS  # where neither line nor bit is
    guards = positions[[0, 1, 3, 5, 7], :2].sum(axis=1)
    expected = [0] * at.LIGHT_ITEMS
    expected[at.LIGHT_LEVEL] = levels.sum() // 8
    expected[at.LIGHT_THIRD] = sorted(levels)[-3]
    expected[at.LIGHT_GUARD] = max(0, guards.max())
    expected[at.LIGHT_STRAY] = np.abs(between.sum(axis=1)).max()
    expected[at.LIGHT_STRAY_HALF] = np.abs(between).max()
    expected[at.LIGHT_ROUGH] = sorted(positions[[0, 1, 3, 5, 7], at.POSITION_ROUGH])[2]
    same(after[0], expected)


ORACLES = {
    "coarse": (
        edge_distances,
        choose_radius,
    ),
    "directions": (
        annulus_profile,
        dark_directions,
        quarter_phase,
    ),
    "grey": (take_sample,),
    "code_rules": (code_light,),
}
