"""Step 2: candidate centres, by direction-mask voting of the edges.

Like the Hough transform of the paper's equations 1 to 3, but each cell remembers which directions voted,
not how many edges did, and only the two radii of the rings are voted for.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics import tables
from larics.edges import DIRECTIONS, offset_px
from larics.kernels import votes as kernels

LEAST_DIRECTIONS = const(15)  # of 24; the weakest true centre seen in thousands of frames had 15
CENTRES = const(6)
WINDOWS = const(96)
_MASK_BITS = const(12)


def direction_bits():
    """The bits of the four vote runs of each direction, as `cast_votes` takes them."""
    bits = array("i", bytes(DIRECTIONS * 16))
    for direction in range(DIRECTIONS):
        for run in range(4):
            seen_from = direction + 1 + (DIRECTIONS // 2 if run & 1 else 0)
            bit = seen_from * _MASK_BITS // DIRECTIONS % _MASK_BITS
            bits[direction * 4 + run] = 1 << (bit + (_MASK_BITS if run > 1 else 0))
    return bits


class CellGrid:
    """The size of the vote grid of one scale: cells of `step` px with a padding that takes every vote."""

    def __init__(self, width, height, step, radius_max_q8):
        padding = (radius_max_q8 >> 8) // step + 4
        self.padding = padding + (padding & 1)
        self.row = (width // step + 1 + 2 * self.padding + 1) & ~1
        self.rows = (height // step + 1 + 2 * self.padding + 1) & ~1
        self.cells = self.row * self.rows + 8  # clearing runs in steps of 8
        self.blocks = self.cells // 4 + 2


class CentreVotes:
    """Finds candidate centres for one scale of marker.

    grid                          CellGrid
    radius_min_q8, radius_max_q8  outer radius, 1/256 px
    inner_q10                     ratio of the rings * 1024
    half_line_q8                  half the line's width, 1/256 px
    step                          px between cells, also between the edges' grid points
    cells, blocks                 array('i') of at least grid.cells, grid.blocks items
    windows                       array('H') of 3 * WINDOWS + 3 items
    bits                          direction_bits()
    centres                       array('i') of 3 * CENTRES + 3 items: receives (score, x, y), x and y
                                  in 1/256 px plus 32768
    """

    def __init__(
        self, grid, radius_min_q8, radius_max_q8, inner_q10, half_line_q8, step, cells, blocks, windows,
        bits, centres
    ):  # fmt: skip
        self.grid = grid
        self.step = step
        self.centres = centres
        self.votes = 0
        self._cells = cells
        self._blocks = blocks
        self._windows = windows
        self._bits = bits
        runs = []
        longest = [0, 0]
        for direction in range(DIRECTIONS):
            for ring, ratio_q10 in enumerate((1024, inner_q10)):
                first_q8 = radius_min_q8 * ratio_q10 >> 10
                last_q8 = radius_max_q8 * ratio_q10 >> 10
                for side in (-1, 1):
                    run = self._run(direction, first_q8, last_q8, side, half_line_q8)
                    runs.append(run)
                    longest[ring] = max(longest[ring], len(run) + (len(run) & 1))
        self._outer_entries, self._inner_entries = longest
        self._offsets = array("H", bytes(DIRECTIONS * (self._outer_entries + self._inner_entries) * 4))
        slot = 0
        for index, run in enumerate(runs):
            for entry in range(longest[index >> 1 & 1]):
                self._offsets[slot] = run[min(entry, len(run) - 1)]
                slot += 1

    def memory(self):
        """Bytes of the tables."""
        return 2 * len(self._offsets)

    def _run(self, direction, first_q8, last_q8, side, half_line_q8):
        """Cell offsets of the centres that an edge may belong to, for one ring and polarity."""
        grid = self.grid
        count = max(2, (last_q8 - first_q8) // (self.step * 128) + 1)
        run = []
        for index in range(count):
            radius_q8 = first_q8 + (last_q8 - first_q8) * index // (count - 1)
            dx, dy = offset_px((side * radius_q8 - half_line_q8) // self.step, direction)
            offset = (dy + grid.padding) * grid.row + dx + grid.padding
            if offset not in run:
                run.append(offset)
        return run

    def find(self, edges, count, width, left, right, top, bottom):
        """Votes with `count` edges and ranks the centres inside the rectangle (px); returns their number."""
        grid = self.grid
        cells = self._cells
        step = self.step
        half_padding = grid.padding // 2
        block_left = half_padding + left // step // 2 - 1
        block_right = half_padding + right // step // 2 + 1
        block_top = half_padding + top // step // 2 - 1
        block_bottom = half_padding + bottom // step // 2 + 1
        kernels.clear_cells(cells, (block_top * 2 - 2) * grid.row, (block_bottom * 2 + 4) * grid.row)
        self.votes = kernels.cast_votes(
            cells, 0, 0, self._offsets, 0, edges, count, width, step, grid.row, self._outer_entries,
            self._inner_entries, self._bits,
        )  # fmt: skip
        block_row = grid.row // 2
        kernels.join_cells(
            cells, 0, 0, self._blocks, grid.row, block_row, block_left, block_right, block_top, block_bottom
        )
        windows = kernels.find_windows(
            self._blocks, 0, 0, block_row, block_left, block_right, block_top, block_bottom, tables.BIT_COUNT,
            LEAST_DIRECTIONS, self._windows, WINDOWS,
        )  # fmt: skip
        return kernels.rank_centres(
            cells, 0, 0, grid.row, self._windows, windows, tables.BIT_COUNT, self.centres, CENTRES,
            grid.padding, step
        )
