"""Step 1: edges of thin dark lines, on a sparse grid, with a threshold that follows the frame."""

from array import array

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith import tables
from larics.arith.fixed import sin_q14
from larics.kernels import edges as kernels

DIRECTIONS = 48
_QUARTER = DIRECTIONS // 4

_GRID_WIDTH = const(0)  # items as in kernels.layouts
_GRID_REACH = const(1)
_GRID_LEFT = const(2)
_GRID_RIGHT = const(3)
_GRID_TOP = const(4)
_GRID_BOTTOM = const(5)
_GRID_STEP = const(6)
_GRID_FIRST = const(7)
_GRID_END = const(8)
_GRID_ITEMS = const(9)

_THRESHOLD_FLOOR = const(3)  # grey levels over 2 * reach px
_MEDIAN_Q4 = const(40)  # threshold = 2.5 medians of the gradient,
_SHARE_MIN = const(60)  # but at least that many 1024ths of the pixels pass
_SHARE_MAX = const(92)  # and at most that many,
_MARKER_SHARE = const(2152)  # and what a marker's own edges may be of the frame, by its lines' width
_SAMPLED = const(4)  # every so-manyth column and row of the grid tells the threshold
_CLEAR_THRESHOLD = const(11)  # with a lower one, faint rings may need one that is lower still
_FINE_STEP = const(3)  # px; so small rings have enough edges for the usual threshold


def direction_sines():
    """Sine of each direction * 2**14, plus 32768; 12 items on it is the cosine, so that the first follow."""
    angles = [direction * 65536 // DIRECTIONS for direction in range(DIRECTIONS // 2)]
    sines = [sin_q14(angle) for angle in angles]
    return array("H", [32768 + sine for sine in sines + [-sine for sine in sines] + sines[:_QUARTER]])


SINES = direction_sines()


class EdgeFinder:
    """Finds edges for one scale of marker, in frames of width x height px, of lines of line_q8/256 px.

    step, reach     grid pitch, and distance of the pixels whose difference is the gradient, px
    edges           array('i') that receives position | direction << 20; its length caps the number of edges;
                    of `list_steep`, positions alone
    histogram       array('H') of 128 items, scratch space
    listed          number of the last edges listed and of the other steep points that follow them
    """

    def __init__(self, width, height, line_q8, step, reach, edges, histogram):
        self.step = step
        self.reach = reach
        self.edges = edges
        self.half_line_q8 = line_q8 // 2
        self.threshold = 0  # not measured yet
        self.steep = self.listed = 0
        self.lowered = False
        self._capacity = len(edges) - 1
        self._share_max = min(512, _SHARE_MAX + _MARKER_SHARE * line_q8 // (width * height))
        self._histogram = histogram
        dark_q8 = max(line_q8 // 2, 256)
        light_q8 = max(line_q8 * 4 // 7, 300)
        beyond_q8 = line_q8 + light_q8
        self._probes = array("H", bytes(DIRECTIONS * 6))
        lengths_q8 = (-beyond_q8, -dark_q8, light_q8)
        for direction in range(DIRECTIONS):
            cosine, sine = SINES[direction + _QUARTER] - 32768, SINES[direction] - 32768
            for slot in range(3):
                dy = lengths_q8[slot] * sine + (1 << 21) >> 22
                dx = lengths_q8[slot] * cosine + (1 << 21) >> 22
                self._probes[direction * 3 + slot] = dy * width + dx + 32768
        margin = max((beyond_q8 + 511) >> 8, reach)
        self._grid = grid = array("i", bytes(4 * _GRID_ITEMS))
        grid[_GRID_WIDTH] = width
        grid[_GRID_REACH] = reach
        grid[_GRID_LEFT] = grid[_GRID_TOP] = (margin + step - 1) // step * step
        grid[_GRID_RIGHT] = width - margin
        grid[_GRID_BOTTOM] = height - margin
        grid[_GRID_STEP] = step
        grid[_GRID_FIRST] = margin * width + margin  # from here on, all probes lie inside the frame
        grid[_GRID_END] = (height - margin) * width - margin
        self._window = array("i", grid)  # the part of it that `find` looks at

    def memory(self):
        """Bytes of the tables."""
        return DIRECTIONS * 6 + 8 * _GRID_ITEMS

    @micropython.native
    def measure_threshold(self, frame):
        """Adapts the threshold to the gradients of the whole frame."""
        samples = kernels.gradient_histogram(0, 0, frame, self._grid, _SAMPLED, self._histogram)
        self.threshold = kernels.edge_threshold(
            self._histogram, 0, 0, samples, _THRESHOLD_FLOOR, _MEDIAN_Q4, _SHARE_MIN, self._share_max
        )

    def find(self, frame, left, right, top, bottom):
        """Lists the edges within the rectangle (px, cut to the frame) and returns their number."""
        step = self.step
        grid = self._grid
        window = self._window
        window[_GRID_LEFT] = max(grid[_GRID_LEFT], left // step * step)
        window[_GRID_TOP] = max(grid[_GRID_TOP], top // step * step)
        window[_GRID_RIGHT] = min(grid[_GRID_RIGHT], right)
        window[_GRID_BOTTOM] = min(grid[_GRID_BOTTOM], bottom)
        self.steep = self._steep(frame, window, 0, self.threshold * self.threshold, 0, self._capacity)
        return self.choose(frame, self.edges, self.steep, False)

    def find_blurred(self, frame):
        """Lists all edges of the frame, whether of thin lines or not, and returns their number."""
        self.list_steep(frame, 0, self.needs_lower())
        self.choose(frame, self.edges, self.steep, False)
        return self.listed

    def is_clear(self):
        """Whether the frame has so much contrast that what is steeper than the threshold holds all rings."""
        return self.threshold >= _CLEAR_THRESHOLD

    def needs_lower(self):
        """Whether blurred edges may be fainter than the threshold: not of rings that have edges enough."""
        return self.step > _FINE_STEP

    def finds_alike(self, other):
        """Whether the other one's `find_blurred` lists the same edges."""
        return self.step == other.step and self.reach == other.reach

    @micropython.native
    def list_steep(self, frame, alternate, lower):
        """Lists the points of the whole frame that may be edges, for `choose`.

        With alternate > 0, every second one of the grid, as the fields of one colour on a chessboard, comes
        first, at most so many. lower: those, too, that only blurred edges need, unless these are too many.
        Returns the number of alternate ones; that of all points is in `steep`, and `lowered` tells whether
        there are fainter ones among them."""
        threshold2 = self.threshold * self.threshold
        if lower:
            threshold2 = threshold2 * 9 >> 4
        first = 0
        if alternate:
            first = self._steep(frame, self._grid, 1, threshold2, 0, alternate)
        field = 2 if alternate else 0
        self.steep = self._steep(frame, self._grid, field, threshold2, first, self._capacity)
        self.lowered = lower
        if lower and (self.steep >= self._capacity or first and first >= alternate):
            return self.list_steep(frame, alternate, False)
        return first

    @micropython.native
    def choose(self, frame, positions, count, lowered):
        """Lists the edges among the first positions that a finder of the same reach listed, and after them
        the others; returns the number of edges, that of all is in `listed`.

        lowered: whether there are points among them that are too faint for edges of thin lines."""
        threshold = self.threshold
        listed = kernels.thin_line_edges(
            frame, 0, 0, 0, positions, count, self.edges, self._grid, threshold, tables.DIRECTION_48,
            self._probes, threshold * threshold if lowered else 0,
        )  # fmt: skip
        self.listed = listed >> 15
        return listed & 32767

    @micropython.native
    def _steep(self, frame, grid, field, threshold2, listed, capacity):
        return kernels.steep_positions(
            0, 0, frame, grid, field, threshold2, self.edges, listed, capacity
        )  # fmt: skip
