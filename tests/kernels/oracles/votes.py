"""The votes for centres and their windows."""

import math

import numpy as np

from larics.kernels import layouts as at

from .compare import close, numbers, same


def cast_votes(before, after, result):
    _, _, cells, offsets, edges, first, count, every, grid, bits = before
    width, step, row = (grid[k] for k in (at.CELLS_WIDTH, at.CELLS_STEP, at.CELLS_ROW))
    outer, inner = grid[at.CELLS_OUTER], grid[at.CELLS_INNER]
    expected = list(cells)
    for edge in edges[first:count:every]:
        direction, position = edge >> 20, edge & 0xFFFFF
        y, x = divmod(position, width)
        origin = (y + step // 2) // step * row + (x + step // 2) // step
        place = direction * 2 * (outer + inner)
        for run, length in enumerate((outer, outer, inner, inner)):
            for offset in offsets[place : place + length]:
                expected[origin + offset] |= bits[4 * direction + run]
            place += length
    same(after[2], expected)
    assert result == len(edges[first:count:every]) * 2 * (outer + inner)


def list_runs(before, after, result):
    """Cells at the ends of arrows of the radii's lengths, rounded to whole cells."""
    _, _, _, _, _, run, most, first_q8, last_q8, count, half_line_q8, grid = before
    step, row, padding = (grid[k] for k in (at.CELLS_STEP, at.CELLS_ROW, at.CELLS_PADDING))
    side = 1 if run & 1 else -1
    lengths = (side * np.linspace(first_q8, last_q8, count) - half_line_q8) / step / 256
    found = numbers(after[0])
    longest = 0
    for direction in range(48):
        first = (4 * direction + run) * most
        length = after[4][4 * direction + run]
        entries = list(found[first : first + length])
        assert len(set(entries)) == length
        rows = np.round((np.array(entries) - padding * (row + 1)) / row)
        columns = np.array(entries) - padding * (row + 1) - rows * row
        turn = 2 * np.pi * direction / 48
        ends = lengths * np.exp(1j * turn)
        off = np.abs(ends[:, None] - (columns + 1j * rows)[None, :])
        close(off.min(1), np.zeros(count), 0.75)  # half a cell each way, and the roundings before
        close(off.min(0), np.zeros(length), 0.75)
        longest = max(longest, length)
    assert result == longest


def join_runs(before, after, result):
    runs, _, _, lengths, most, grid, _ = before
    expected = []
    for run in range(192):
        entries = list(runs[run * most : run * most + lengths[run]])
        wanted = grid[at.CELLS_INNER] if run & 2 else grid[at.CELLS_OUTER]
        expected += entries + entries[-1:] * (wanted - len(entries))
    same(after[6], expected)


def clear_cells(before, after, result):
    cells, first, end = before
    expected = list(cells)
    expected[first:end] = [0] * (end - first)
    for k in range(end, end + 3):  # may be cleared as well
        if k < len(cells):
            assert after[0][k] in (0, cells[k])
            expected[k] = after[0][k]
    same(after[0], expected)


def _directions(cell):
    return bin(int(cell)).count("1")


def find_windows(before, after, result):
    left, _, cells, row, right, top, bottom, _, _, least, _, capacity = before
    windows = {}
    for y in range(top, bottom):
        for x in range(left, right):
            all16 = [cells[(2 * y + dy) * row + 2 * x + dx] for dy in range(4) for dx in range(4)]
            windows[x, y] = _directions(np.bitwise_or.reduce(all16))
    listed = numbers(after[10], 3 * result).reshape(-1, 3)
    for count, x, y in listed:
        assert windows[x, y] == count >= least
    all_of_them = [(count, *place) for place, count in windows.items() if count >= least]
    if len(all_of_them) < capacity:
        assert [tuple(one) for one in listed] == all_of_them
    else:  # a full list has dropped the weaker ones
        assert result <= capacity


def rank_centres(before, after, result):
    _, _, cells, grid, windows, count, _, _, capacity = before
    row, padding, step = grid[at.CELLS_ROW], grid[at.CELLS_PADDING], grid[at.CELLS_STEP]

    def around(x, y):
        return [cells[(y + dy) * row + x + dx] for dy in (-1, 0, 1) for dx in (-1, 0, 1)]

    def score(x, y):
        nine = around(x, y)
        return 8 * _directions(np.bitwise_or.reduce(nine)) + sum(map(_directions, nine))

    def place(x, y):
        weights = [_directions(cell) ** 2 for cell in around(x, y)]
        total = sum(weights) or 1
        dx = math.floor(256 * sum(w * (k % 3 - 1) for k, w in enumerate(weights)) / total)
        dy = math.floor(256 * sum(w * (k // 3 - 1) for k, w in enumerate(weights)) / total)
        return ((x - padding) * 256 + dx) * step + 32768, ((y - padding) * 256 + dy) * step + 32768

    best = {}
    for k in range(count):
        x, y = 2 * windows[3 * k + 1] + 1, 2 * windows[3 * k + 2] + 1
        for corner in ((x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)):
            best[corner] = score(*corner)
    known = {(best[corner], *place(*corner)) for corner in best}
    found = [tuple(one) for one in numbers(after[7], 3 * result).reshape(-1, 3)]
    assert set(found) <= known
    assert [one[0] for one in found] == sorted((one[0] for one in found), reverse=True)
    assert 1 <= result <= capacity and found[0][0] == max(best.values())


ORACLES = {
    "votes": (
        cast_votes,
        list_runs,
        join_runs,
        clear_cells,
        find_windows,
        rank_centres,
    ),
}
