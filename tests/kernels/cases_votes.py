"""Calls of the kernels in larics.kernels.votes."""

from array import array

from inputs import ints, words, zeros16, zeros32

from larics.arith import tables
from larics.detect.edges import SINES
from larics.kernels import layouts

DIRECTIONS = 48
ALL_BITS = (1 << 24) - 1


def sparse_cells(count, random, density):
    """Cells of which one in `density` holds any directions, some of them all."""
    cells = zeros32(count)
    for i in range(count):
        if random.below(density) == 0:
            cells[i] = random.below(1 << 24) | (ALL_BITS if random.below(4) == 0 else 0)
    return cells


def cells_grid(**items):
    """A grid of cells: items by their names in lower case."""
    found = zeros32(layouts.CELLS_ITEMS)
    for name in items:
        found[getattr(layouts, "CELLS_" + name.upper())] = items[name]
    return found


def cast_votes(random):
    for width, height, step, outer, inner, count in (
        (60, 40, 2, 6, 4, 80),
        (64, 48, 4, 2, 2, 300),
        (50, 50, 1, 8, 2, 0),
    ):
        row = width // step + 20
        cells = zeros32(row * (height // step + 20))
        half = step // 2
        farthest = len(cells) - 1 - ((height - 1 + half) // step * row + (width - 1 + half) // step)
        offsets = words(DIRECTIONS * (outer + inner) * 2, random, 0, farthest)
        edges = zeros32(count + 1)
        for i in range(count):
            edges[i] = random.below(width * height) | random.below(DIRECTIONS) << 20
        bits = zeros32(DIRECTIONS * 4)
        for i in range(len(bits)):
            bits[i] = 1 << random.below(24)
        grid = cells_grid(width=width, step=step, row=row, outer=outer, inner=inner)
        for first, every in ((0, 1), (count // 3, 2)):
            yield 0, 0, array("i", cells), offsets, edges, first, count, every, grid, bits
    # the last pixel of the largest frame, in one cell grid of step 8
    row = 140
    edges = zeros32(1)
    edges[0] = (1024 * 1024 - 1) | 47 << 20
    offsets = words(DIRECTIONS * 8, random, 0, row * 12)
    grid = cells_grid(width=1024, step=8, row=row, outer=2, inner=2)
    yield 0, 0, zeros32(row * 141), offsets, edges, 0, 1, 1, grid, zeros32(DIRECTIONS * 4)


def list_runs(random):
    for step, row, padding in ((3, 130, 20), (8, 56, 12), (4, 110, 22)):
        grid = cells_grid(step=step, row=row, padding=padding)
        half_line_q8 = random.between(200, 600)
        for first_q8, last_q8 in ((1536, 1900), (2560, 4200), (8000, 9000)):
            count = max(2, (last_q8 - first_q8) // (step * 128) + 1)
            for run in range(4):
                runs, lengths = zeros16(4 * DIRECTIONS * count), bytearray(4 * DIRECTIONS)
                yield runs, 0, 0, SINES, lengths, run, count, first_q8, last_q8, count, half_line_q8, grid


def join_runs(random):
    for most, outer, inner in ((6, 6, 4), (30, 2, 12), (1, 2, 2)):
        lengths = bytearray(4 * DIRECTIONS)
        for run in range(len(lengths)):
            lengths[run] = random.between(1, min(most, inner if run & 2 else outer))
        grid = cells_grid(outer=outer, inner=inner)
        offsets = words(2 * DIRECTIONS * (outer + inner), random)
        yield words(4 * DIRECTIONS * most, random), 0, 0, lengths, most, grid, offsets


def clear_cells(random):
    for first, end, count in ((0, 0, 4), (4, 17, 24), (0, 40, 40)):
        yield ints(count, random, 0, 1 << 24), first, end


def find_windows(random):
    row, rows = 36, 24
    limits = ((1, 9, 6), (2, 15, 96), (3, 20, 3), (1000, 15, 96), (1, 24, 1), (9, 9, 9))
    for density, least, capacity in limits:
        for left, right, top, bottom in ((1, 16, 1, 10), (0, 17, 0, 11), (3, 9, 2, 4), (5, 5, 6, 6)):
            cells = sparse_cells(row * rows, random, density)
            windows = words(3 * capacity + 3, random)
            yield (
                left, 0, cells, row, right, top, bottom, zeros32(18), tables.BIT_COUNT, least, windows,
                capacity,
            )  # fmt: skip


def directions(cells, row, x, y):
    """How many directions a window of 4x4 cells holds."""
    joined = 0
    for place in range(16):
        joined |= cells[(y + (place >> 2)) * row + x + (place & 3)]
    return bin(joined).count("1")


def rank_centres(random):
    row, rows = 40, 30
    for density, count, capacity, padding, step in (
        (1, 30, 6, 8, 2),
        (3, 96, 6, 20, 4),
        (2, 5, 1, 0, 1),
        (4, 40, 12, 4, 3),
    ):
        cells = sparse_cells(row * rows, random, density)
        windows = zeros16(3 * count)
        for i in range(0, 3 * count, 3):
            windows[i + 1] = random.between(1, row // 2 - 3)
            windows[i + 2] = random.between(1, rows // 2 - 3)
            windows[i] = directions(cells, row, 2 * windows[i + 1], 2 * windows[i + 2])
        centres = ints(3 * capacity + 3, random, 0, 1 << 20)
        grid = cells_grid(row=row, padding=padding, step=step)
        yield 0, 0, cells, grid, windows, count, tables.BIT_COUNT, centres, capacity
    # the far corner of the largest grid
    row = 1100
    cells = sparse_cells(row * 8, random, 2)
    windows = zeros16(3)
    windows[0], windows[1], windows[2] = 24, 547, 1
    grid = cells_grid(row=row, padding=60, step=1)
    yield 0, 0, cells, grid, windows, 1, tables.BIT_COUNT, zeros32(9), 2


CASES = {
    "list_runs": list_runs,
    "join_runs": join_runs,
    "cast_votes": cast_votes,
    "clear_cells": clear_cells,
    "find_windows": find_windows,
    "rank_centres": rank_centres,
}
