"""Votes of edges for ring centres: each cell of the grid collects the directions it was seen from.

A cell is 24 bits: 12 directions of the outer ring (bits 0..11), 12 of the inner one (12..23). Setting bits
instead of counting means that a long line or a lamp, which send many votes from few directions, cannot win.
Cells lie in rows of `row` cells with a padding around the frame's, so that no vote needs a bounds test.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_CELLS_WIDTH = const(0)  # items as in kernels.layouts
_CELLS_STEP = const(1)
_CELLS_ROW = const(2)
_CELLS_PADDING = const(3)
_CELLS_OUTER = const(4)
_CELLS_INNER = const(5)


@micropython.viper
def cast_votes(
    cell: int, entry: int, cells: ptr32, offsets: ptr16, edges: ptr32, first: int, count: int, every: int,
    grid: ptr32, bits: ptr32,
) -> int:  # fmt: skip
    """Sets, for every so-manyth edge (position | direction << 20) from `first` to before `count`, its
    direction's bit in the cells where centres may be, as seen from the nearest cell's corner.

    grid: layouts.CELLS. `offsets`: for each of 48 directions, two runs of its outer and two of its inner
    entries, cell offsets (all >= 0, the caller has added the padding); `bits`: the four runs' bits. Every
    offset + cell of an edge must lie inside `cells`. Returns the number of votes."""
    width = int(grid[_CELLS_WIDTH])
    step = int(grid[_CELLS_STEP])
    row = int(grid[_CELLS_ROW])
    outer_entries = int(grid[_CELLS_OUTER])
    inner_entries = int(grid[_CELLS_INNER])
    per_direction = (outer_entries + inner_entries) * 2
    half = step >> 1
    i = first
    while i < count:
        position = int(edges[i])
        i += every
        direction = position >> 20
        position = position & 1048575
        y = position // width
        origin = ((y + half) // step) * row + (position - y * width + half) // step
        entry = direction * per_direction
        # the four runs one after the other: a loop over them costs as much as a vote each
        direction = direction << 2
        bit = int(bits[direction])
        end = entry + outer_entries
        while entry - end:
            cell = int(offsets[entry]) + origin
            cells[cell] = int(cells[cell]) | bit
            cell = int(offsets[entry + 1]) + origin
            cells[cell] = int(cells[cell]) | bit
            entry += 2
        bit = int(bits[direction + 1])
        end += outer_entries
        while entry - end:
            cell = int(offsets[entry]) + origin
            cells[cell] = int(cells[cell]) | bit
            cell = int(offsets[entry + 1]) + origin
            cells[cell] = int(cells[cell]) | bit
            entry += 2
        bit = int(bits[direction + 2])
        end += inner_entries
        while entry - end:
            cell = int(offsets[entry]) + origin
            cells[cell] = int(cells[cell]) | bit
            cell = int(offsets[entry + 1]) + origin
            cells[cell] = int(cells[cell]) | bit
            entry += 2
        bit = int(bits[direction + 3])
        end += inner_entries
        while entry - end:
            cell = int(offsets[entry]) + origin
            cells[cell] = int(cells[cell]) | bit
            cell = int(offsets[entry + 1]) + origin
            cells[cell] = int(cells[cell]) | bit
            entry += 2
    return (count - first + every - 1) // every * per_direction


@micropython.viper
def list_runs(
    runs: ptr16, first: int, end: int, sines: ptr16, lengths: ptr8, run: int, most: int, first_q8: int,
    last_q8: int, count: int, half_line_q8: int, grid: ptr32,
) -> int:  # fmt: skip
    """Lists, for each of 48 directions, the cells where the centre of an edge's ring may be, each once.

    run: which of a direction's four, 0 and 1 of the outer ring, the odd ones on the edge's dark side.
    `count` radii from first_q8 to last_q8, at least 2, at most `most`, which is the room of each run in
    `runs`; sines: as of detect.edges; `lengths`: of all runs, of which this run's are set; grid:
    layouts.CELLS. Returns the longest run's length."""
    step = int(grid[_CELLS_STEP])
    row = int(grid[_CELLS_ROW])
    middle = int(grid[_CELLS_PADDING]) * (row + 1)
    longest = 0
    direction = 0
    while direction < 48:
        sine = int(sines[direction]) - 32768
        cosine = int(sines[direction + 12]) - 32768
        first = ((direction << 2) + run) * most
        end = first
        index = 0
        while index < count:
            length_q8 = first_q8 + (last_q8 - first_q8) * index // (count - 1)
            if run & 1:
                length_q8 = (length_q8 - half_line_q8) // step
            else:
                length_q8 = 0 - (length_q8 + half_line_q8 + step - 1) // step  # rounded down, too
            offset = ((length_q8 * sine + 2097152) >> 22) * row
            offset += ((length_q8 * cosine + 2097152) >> 22) + middle
            place = first
            while place < end and int(runs[place]) != offset:
                place += 1
            if place == end:
                runs[end] = offset
                end += 1
            index += 1
        lengths[(direction << 2) + run] = end - first
        if end - first > longest:
            longest = end - first
        direction += 1
    return longest


@micropython.viper
def join_runs(
    runs: ptr16, place: int, slot: int, lengths: ptr8, most: int, grid: ptr32, offsets: ptr16
):  # fmt: skip
    """Writes the runs of `list_runs` one after the other, as `cast_votes` takes them: those of a ring alike
    long, filled up with their last entry. `slot`: 0."""
    run = 0
    while run < 192:
        length = int(lengths[run])
        entries = int(grid[_CELLS_INNER]) if run & 2 else int(grid[_CELLS_OUTER])
        index = 0
        while index < entries:
            place = index
            if place >= length:
                place = length - 1
            offsets[slot] = int(runs[run * most + place])
            slot += 1
            index += 1
        run += 1


@micropython.viper
def clear_cells(cells: ptr32, i: int, end: int):
    """Sets the cells from i to before `end` to 0, and up to three more; i is a multiple of 4."""
    last = end - 15
    while i < last:
        cells[i] = 0
        cells[i + 1] = 0
        cells[i + 2] = 0
        cells[i + 3] = 0
        cells[i + 4] = 0
        cells[i + 5] = 0
        cells[i + 6] = 0
        cells[i + 7] = 0
        cells[i + 8] = 0
        cells[i + 9] = 0
        cells[i + 10] = 0
        cells[i + 11] = 0
        cells[i + 12] = 0
        cells[i + 13] = 0
        cells[i + 14] = 0
        cells[i + 15] = 0
        i += 16
    while i < end:
        cells[i] = 0
        cells[i + 1] = 0
        cells[i + 2] = 0
        cells[i + 3] = 0
        i += 4


@micropython.viper
def find_windows(
    x: int, i: int, cells: ptr32, row: int, right: int, top: int, bottom: int, above: ptr32, ones: ptr8,
    least: int, windows: ptr16, capacity: int,
) -> int:  # fmt: skip
    """Lists the windows of 4x4 cells that hold at least `least` of the 24 directions, as (directions, x, y).

    From the given x to before right, top <= y < bottom, in blocks of 2x2 cells, of which a window has 2x2;
    `cells` has rows of `row` cells; `above`: scratch space for the blocks of a row, right + 1 items; `ones`:
    256 bit counts; `windows`: 3 * capacity + 3 items. A full list raises the limit and drops the weaker ones.
    Returns the number of windows."""
    listed = 0
    full = capacity * 3
    left = x
    i = (top * row + left) << 1
    while x <= right:
        above[x] = int(cells[i]) | int(cells[i + 1]) | int(cells[i + row]) | int(cells[i + row + 1])
        i += 2
        x += 1
    y = top
    while y < bottom:
        y += 1
        i = (y * row + left) << 1
        x = left
        before = int(cells[i]) | int(cells[i + 1]) | int(cells[i + row]) | int(cells[i + row + 1])
        joined = before | int(above[x])
        above[x] = before
        before = joined
        while x - right:
            i += 2
            x += 1
            joined = int(cells[i]) | int(cells[i + 1]) | int(cells[i + row]) | int(cells[i + row + 1])
            here = joined | int(above[x])
            above[x] = joined
            joined = before | here
            before = here
            if joined >> 14:
                joined = int(ones[joined & 255]) + int(ones[(joined >> 8) & 255]) + int(ones[joined >> 16])
                if joined >= least:
                    windows[listed] = joined
                    windows[listed + 1] = x - 1
                    windows[listed + 2] = y - 1
                    listed += 3
                    if listed >= full:
                        least += 1
                        source = 0
                        listed = 0
                        while source < full:
                            if int(windows[source]) >= least:
                                windows[listed] = int(windows[source])
                                windows[listed + 1] = int(windows[source + 1])
                                windows[listed + 2] = int(windows[source + 2])
                                listed += 3
                            source += 3
                        if listed >= full:
                            listed = 0
    return listed // 3


@micropython.viper
def rank_centres(
    value: int, i: int, cells: ptr32, grid: ptr32, windows: ptr16, count: int, ones: ptr8, centres: ptr32,
    capacity: int,
) -> int:  # fmt: skip
    """The best centres among the windows, best first, as (score, x_q8, y_q8) triples in `centres`.

    A score is 8 times the directions in 3x3 cells plus the sum of the single cells' own; of two centres
    less than 2.5 cells apart only the better stays. The position is the centroid of the squared counts; it
    may lie outside the frame by a cell: 128 px are added so that it never is negative. grid: layouts.CELLS;
    `centres`: 3 * capacity + 3 items. Returns the number of centres."""
    row = int(grid[_CELLS_ROW])
    padding = int(grid[_CELLS_PADDING])
    step = int(grid[_CELLS_STEP])
    kept = 0
    window = 0
    while window < count:
        x = int(windows[window * 3 + 1]) * 2 + 1
        y = int(windows[window * 3 + 2]) * 2 + 1
        window += 1
        # of a full list none gives way to less than its last; nine cells have nine times a window's at most
        if kept == capacity and int(windows[window * 3 - 3]) * 17 <= int(centres[capacity * 3 - 3]):
            continue
        i = (y - 1) * row + x - 1
        upper_left = 0
        upper_right = 0
        lower_left = 0
        lower_right = 0
        ones_upper_left = 0
        ones_upper_right = 0
        ones_lower_left = 0
        ones_lower_right = 0
        line = 0
        while line < 4:
            # a row of four cells is the left and the right part of two sets of nine
            value = int(cells[i])
            left = value
            ones_left = int(ones[value & 255]) + int(ones[(value >> 8) & 255]) + int(ones[value >> 16])
            value = int(cells[i + 3])
            right = value
            ones_right = int(ones[value & 255]) + int(ones[(value >> 8) & 255]) + int(ones[value >> 16])
            value = int(cells[i + 1])
            middle = value
            total = int(ones[value & 255]) + int(ones[(value >> 8) & 255]) + int(ones[value >> 16])
            value = int(cells[i + 2])
            middle = middle | value
            total += int(ones[value & 255]) + int(ones[(value >> 8) & 255]) + int(ones[value >> 16])
            left = left | middle
            right = right | middle
            ones_left += total
            ones_right += total
            if line < 3:
                upper_left = upper_left | left
                upper_right = upper_right | right
                ones_upper_left += ones_left
                ones_upper_right += ones_right
            if line > 0:
                lower_left = lower_left | left
                lower_right = lower_right | right
                ones_lower_left += ones_left
                ones_lower_right += ones_right
            i += row
            line += 1
        best_x = x
        best_y = y
        value = int(ones[upper_left & 255]) + int(ones[(upper_left >> 8) & 255]) + int(ones[upper_left >> 16])
        best = (value << 3) + ones_upper_left
        i = upper_right
        value = (
            (int(ones[i & 255]) + int(ones[(i >> 8) & 255]) + int(ones[i >> 16])) << 3
        ) + ones_upper_right
        if value > best:
            best = value
            best_x = x + 1
        i = lower_left
        value = ((int(ones[i & 255]) + int(ones[(i >> 8) & 255]) + int(ones[i >> 16])) << 3) + ones_lower_left
        if value > best:
            best = value
            best_x = x
            best_y = y + 1
        i = lower_right
        value = (
            (int(ones[i & 255]) + int(ones[(i >> 8) & 255]) + int(ones[i >> 16])) << 3
        ) + ones_lower_right
        if value > best:
            best = value
            best_x = x + 1
            best_y = y + 1
        # a near centre that is better wins; worse ones nearby are dropped
        slot = 0
        wins = 1
        while slot < kept:
            i = slot * 3
            dx = int(centres[i + 1]) - best_x
            dy = int(centres[i + 2]) - best_y
            if dx * dx + dy * dy <= 5:
                if int(centres[i]) >= best:
                    wins = 0
                    slot = kept
                else:
                    kept -= 1
                    while i < kept * 3:
                        centres[i] = int(centres[i + 3])
                        i += 1
            else:
                slot += 1
        if wins:
            slot = kept
            if kept < capacity:
                kept += 1
            elif int(centres[(capacity - 1) * 3]) < best:
                slot = capacity - 1
            else:
                slot = 0 - 1
            if slot >= 0:
                i = slot * 3
                while i > 0 and int(centres[i - 3]) < best:
                    centres[i] = int(centres[i - 3])
                    centres[i + 1] = int(centres[i - 2])
                    centres[i + 2] = int(centres[i - 1])
                    i -= 3
                centres[i] = best
                centres[i + 1] = best_x
                centres[i + 2] = best_y
    slot = 0
    while slot < kept * 3:
        best_x = int(centres[slot + 1])
        best_y = int(centres[slot + 2])
        i = (best_y - 1) * row + best_x - 1
        weight = 0
        sum_x = 0
        sum_y = 0
        y = 0 - 1
        while y < 2:
            x = 0 - 1
            while x < 2:
                value = int(cells[i])
                value = int(ones[value & 255]) + int(ones[(value >> 8) & 255]) + int(ones[value >> 16])
                value = value * value
                weight += value
                sum_x += value * x
                sum_y += value * y
                i += 1
                x += 1
            i += row - 3
            y += 1
        if weight == 0:
            weight = 1
        centres[slot + 1] = (((best_x - padding) << 8) + (sum_x << 8) // weight) * step + 32768
        centres[slot + 2] = (((best_y - padding) << 8) + (sum_y << 8) // weight) * step + 32768
        slot += 3
    return kept
