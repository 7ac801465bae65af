"""Step 2: candidate centres, by direction-mask voting of the edges.

Like the Hough transform of the paper's equations 1 to 3, but each cell remembers which directions voted,
not how many edges did, and only the two radii of the rings are voted for.
"""

from array import array

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith import tables
from larics.arith.fixed import Parts, words
from larics.detect.edges import DIRECTIONS, SINES
from larics.kernels import votes as kernels

_CELLS_WIDTH = const(0)  # items as in kernels.layouts
_CELLS_STEP = const(1)
_CELLS_ROW = const(2)
_CELLS_PADDING = const(3)
_CELLS_OUTER = const(4)
_CELLS_INNER = const(5)
_CELLS_ITEMS = const(6)

LEAST_DIRECTIONS = const(15)  # of 24; the weakest true centre seen in thousands of frames had 15
_LEAST_SCORE = const(180)  # the weakest true centre had 194, half of all others have less
CENTRES = const(6)
LEAST_WORDS = const(2532)  # once all have voted, the blur-model reader works there
WINDOWS = const(96)
_FINE_STEP = const(3)  # px between the cells of the smallest rings,
_FINE_PADDING = const(5)  # and their largest radius in cells
_SMALL_Q8 = const(3072)  # rings below this show fewer directions,
_FEWER = const(4)  # by so many
_MASK_BITS = const(12)


def direction_bits():
    """The bits of the four vote runs of each direction, as `cast_votes` takes them."""
    bits = words(DIRECTIONS * 4, "keys")
    for direction in range(DIRECTIONS):
        for run in range(4):
            seen_from = direction + 1 + (DIRECTIONS // 2 if run & 1 else 0)
            bit = seen_from * _MASK_BITS // DIRECTIONS % _MASK_BITS
            bits[direction * 4 + run] = 1 << (bit + (_MASK_BITS if run > 1 else 0))
    return bits


class CellGrid:
    """The size of the vote grid of one scale: cells of `step` px with a padding that takes every vote."""

    def __init__(self, width, height, step, radius_max_q8):
        # the finest grids are alike, so that other radii need no longer buffer
        padding = max((radius_max_q8 >> 8) // step, _FINE_PADDING if step == _FINE_STEP else 0) + 4
        self.width = width
        self.step = step
        self.padding = padding + (padding & 1)
        self.row = (width // step + 1 + 2 * self.padding + 1) & ~1
        self.rows = (height // step + 1 + 2 * self.padding + 1) & ~1
        self.cells = self.row * self.rows + 3 & ~3


class VoteBuffers:
    """What the scales share: the largest grid's cells, and the lists of windows and centres.

    centres   array('i') of (score, x, y), x and y in 1/256 px plus 32768
    beside    array('i') of so many items, for what the scales keep while they vote whose grid is not of the
              finest: on a board behind their cells, where only the finest one's are
    """

    def __init__(self, grids, beside):
        finest = min([grid.step for grid in grids])
        coarse = max([0] + [grid.cells for grid in grids if grid.step > finest])
        self.cells = words(max([LEAST_WORDS, coarse + beside] + [grid.cells for grid in grids]), "cells")
        self.beside = Parts(self.cells, coarse).of32(beside)
        self.above = words(max([grid.row for grid in grids]) // 2)
        self.windows = words(3 * WINDOWS + 3, "items", "H")
        self.centres = array("i", bytes(4 * (3 * CENTRES + 3)))
        self.bits = direction_bits()

    def clear(self, first, end):
        """Sets at least the cells first .. end - 1 to 0."""
        kernels.clear_cells(self.cells, first & ~3, min(end, len(self.cells)))

    def memory(self):
        """Bytes of the buffers."""
        items = len(self.cells) + len(self.above) + len(self.centres) + len(self.bits)
        return 4 * items + 2 * len(self.windows)


class CentreVotes:
    """Finds candidate centres for one scale of marker.

    grid                          CellGrid
    radius_min_q8, radius_max_q8  outer radius, 1/256 px
    inner_q10                     ratio of the rings * 1024
    half_line_q8                  half the line's width, 1/256 px
    step                          px between cells, also between the edges' grid points
    per_edge                      votes of each edge
    least_score                   centres below that are not worth examining
    buffers                       VoteBuffers; its `centres` receive the result
    """

    def __init__(self, grid, radius_min_q8, radius_max_q8, inner_q10, half_line_q8, step, buffers):
        self.grid = grid
        self.step = step
        self.votes = 0
        self._buffers = buffers
        small = radius_max_q8 < _SMALL_Q8
        self._least = LEAST_DIRECTIONS - (_FEWER if small else 0)
        self.least_score = 0 if small else _LEAST_SCORE
        cells = array("i", bytes(4 * _CELLS_ITEMS))
        cells[_CELLS_WIDTH] = grid.width
        cells[_CELLS_STEP] = step
        cells[_CELLS_ROW] = grid.row
        cells[_CELLS_PADDING] = grid.padding
        self._cells = cells
        ranges = []
        for ratio_q10 in (1024, inner_q10):
            first_q8, last_q8 = radius_min_q8 * ratio_q10 >> 10, radius_max_q8 * ratio_q10 >> 10
            ranges.append((first_q8, last_q8, max(2, (last_q8 - first_q8) // (step * 128) + 1)))
        most = max(ranges[0][2], ranges[1][2])
        runs = Parts(buffers.cells).of16(4 * DIRECTIONS * most)  # no votes are there yet
        lengths = bytearray(4 * DIRECTIONS)
        for run in range(4):
            first_q8, last_q8, count = ranges[run >> 1]
            longest = kernels.list_runs(
                runs, 0, 0, SINES, lengths, run, most, first_q8, last_q8, count, half_line_q8, cells
            )
            item = _CELLS_INNER if run > 1 else _CELLS_OUTER
            cells[item] = max(cells[item], longest + (longest & 1))
        both = cells[_CELLS_OUTER] + cells[_CELLS_INNER]
        self.per_edge = 2 * both
        self._offsets = words(DIRECTIONS * both * 2, code="H")
        kernels.join_runs(runs, 0, 0, lengths, most, cells, self._offsets)

    def memory(self):
        """Bytes of the tables."""
        return 2 * len(self._offsets) + 4 * _CELLS_ITEMS

    @micropython.native
    def find(self, edges, first, count, every, left, right, top, bottom):
        """Votes with every so-manyth edge from `first` to before `count` and ranks the centres inside the
        rectangle (px).

        With first > 0 those before have voted already, and nothing else since. Returns the number of
        centres."""
        grid = self.grid
        buffers = self._buffers
        cells = buffers.cells
        step = self.step
        half_padding = grid.padding // 2
        block_left = half_padding + left // step // 2 - 1
        block_right = half_padding + right // step // 2 + 1
        block_top = half_padding + top // step // 2 - 1
        block_bottom = half_padding + bottom // step // 2 + 1
        if not first:
            buffers.clear((block_top * 2 - 2) * grid.row, (block_bottom * 2 + 4) * grid.row)
        self.votes = kernels.cast_votes(
            0, 0, cells, self._offsets, edges, first, count, every, self._cells, buffers.bits
        )  # fmt: skip
        windows = kernels.find_windows(
            block_left, 0, cells, grid.row, block_right, block_top, block_bottom, buffers.above,
            tables.BIT_COUNT, self._least, buffers.windows, WINDOWS,
        )  # fmt: skip
        return kernels.rank_centres(
            0, 0, cells, self._cells, buffers.windows, windows, tables.BIT_COUNT, buffers.centres, CENTRES
        )
