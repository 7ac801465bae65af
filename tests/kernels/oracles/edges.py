"""Edges, gradients and greys."""

import math

import numpy as np

from larics.kernels import layouts as at

from .compare import numbers, same


def _grid(grid):
    names = ("WIDTH", "REACH", "LEFT", "RIGHT", "TOP", "BOTTOM", "STEP", "FIRST", "END")
    return {name: grid[getattr(at, "GRID_" + name)] for name in names}


def _gradient(image, grid, position):
    reach, width = grid["REACH"], grid["WIDTH"]
    down = int(image[position + reach * width]) - int(image[position - reach * width])
    return int(image[position + reach]) - int(image[position - reach]), down


def gradient_histogram(before, after, result):
    _, _, image, grid, every, histogram = before
    grid = _grid(grid)
    step = grid["STEP"] * every
    expected = list(histogram)
    samples = shift = 0
    for y in range(grid["TOP"], grid["BOTTOM"], step):
        for x in range(grid["LEFT"] + shift, grid["RIGHT"], step):
            larger, smaller = sorted(map(abs, _gradient(image, grid, y * grid["WIDTH"] + x)), reverse=True)
            expected[min(127, (larger + 3 * smaller // 8) // 2)] += 1
            samples += 1
        shift = (shift + 5 * step // 8) % step
    same(after[5], expected)
    assert result == samples


def edge_threshold(before, after, result):
    histogram, _, _, samples, floor, median_q4, share_min, share_max = before
    seen = np.cumsum(numbers(histogram))

    def bin_with(count):
        """The first bin up to which so many were seen; as nothing is crossed by none, the default is 127."""
        reached = np.flatnonzero(seen >= count)
        return int(reached[0]) if count > 0 and len(reached) else None

    median = bin_with(samples // 2) or 0
    upper = bin_with(samples - samples * share_min // 1024)
    lower = bin_with(samples - samples * share_max // 1024)
    upper = 127 if upper is None else upper
    lower = 127 if lower is None else lower
    expected = max(floor, 2 * lower + 1, min(median * median_q4 // 8, 2 * upper + 1))
    assert result == expected
    assert not any(after[0])


def steep_positions(before, after, result):
    _, _, image, grid, field, threshold2, positions, listed, capacity = before
    grid = _grid(grid)
    step = grid["STEP"]
    expected = list(positions[:listed])
    for number, y in enumerate(range(grid["TOP"], grid["BOTTOM"], step)):
        shift = step if field and (number + field) % 2 == 0 else 0
        for x in range(grid["LEFT"] + shift, grid["RIGHT"], 2 * step if field else step):
            across, down = _gradient(image, grid, y * grid["WIDTH"] + x)
            if across * across + down * down > threshold2 and len(expected) < capacity:
                expected.append(y * grid["WIDTH"] + x)
    assert result == len(expected)
    same(after[6][:result], expected)


def thin_line_edges(before, after, result):
    image, _, _, _, positions, count, _, grid, threshold, _, probes, least2 = before
    grid = _grid(grid)
    width, reach = grid["WIDTH"], grid["REACH"]
    edges, listed = result & 32767, result >> 15
    kept = {edge & 0xFFFFF: edge >> 20 for edge in after[6][:edges]}
    others = {edge & 0xFFFFF: edge >> 20 for edge in after[6][edges:listed]}
    assert not set(kept) & set(others)
    inside = [position for position in positions[:count] if grid["FIRST"] <= position < grid["END"]]
    assert sorted(edge & 0xFFFFF for edge in after[6][:listed]) == sorted(inside)
    for position in inside:
        y, x = divmod(position, width)
        patch = [
            [int(image[(y + dy * reach) * width + x + dx * reach]) for dx in (-1, 0, 1)] for dy in (-1, 0, 1)
        ]
        patch = np.array(patch)
        gx = (patch[:, 2] - patch[:, 0]) @ (1, 2, 1)
        gy = (patch[2] - patch[0]) @ (1, 2, 1)
        direction = {**kept, **others}[position]
        turn = math.atan2(gy, gx) / (2 * math.pi) * 48 % 48 if gx or gy else 0
        off = abs((direction - turn + 24) % 48 - 24)
        assert off <= 0.75 or not (gx or gy), (position, off)
        beyond, dark, light = (
            int(image[position + probes[3 * direction + k] - 32768]) for k in range(3)
        )  # fmt: skip
        is_thin = 2 * (beyond - dark) > threshold and 3 * (beyond - dark) >= light - dark
        across, down = patch[1, 2] - patch[1, 0], patch[2, 1] - patch[0, 1]
        is_steep = not least2 or across**2 + down**2 > least2
        assert (position in kept) == (is_thin and is_steep), position


def count_greys(before, after, result):
    frame, _, _, _, width, left, top, right, bottom, step = before
    picture = numbers(frame).reshape(-1, width)[top:bottom:step, left:right:step]
    same(after[1], np.bincount(picture.ravel() >> 2, minlength=64))


ORACLES = {
    "edges": (
        gradient_histogram,
        edge_threshold,
        steep_positions,
        thin_line_edges,
    ),
    "grey": (count_greys,),
}
