"""The cells of a marker, through the pose that the direct or the blur-model reader has fitted.

depths -> weights -> the two likeliest words -> an ID, "plain", or neither

What a cell tells is weighed, the word that contradicts the least is taken, and it is believed when the second
would contradict so much more. An ID is told by cells and lines together: lines that were read must agree.

On a Cortex-M7 that adds 50,000 to 60,000 instructions to a frame with a marker whose cells leave no doubt,
about 37,000 more where rivals have to be looked for, which ends after some 100 of them, some 6,000 where
dark cells may be strokes across a plain marker, and nothing to one without a marker.
"""

from array import array

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith.fixed import CELL_AXES, CELL_ROWS, COSINE, LOG_GREY, cos_q14, sin_q14
from larics.kernels import cell_search, cell_strokes, cell_words
from larics.kernels import cells as kernels
from larics.marker import BITS, ID_COUNT, mirrored_lines

_BIAS = const(1 << 24)  # items as in kernels.layouts
_PLACE_X_Q8 = const(0)
_PLACE_Y_Q8 = const(1)
_PLACE_RADIUS_Q8 = const(2)
_PLACE_E1_Q14 = const(3)
_PLACE_E2_Q14 = const(4)
_PLACE_HX_Q14 = const(5)
_PLACE_HY_Q14 = const(6)
_PLACE_COSINE_Q14 = const(7)
_PLACE_SINE_Q14 = const(8)
_PLACE_DEPTH = const(9)
_PLACE_RADII_Q10 = const(10)
_PLACE_WIDTH = const(14)
_PLACE_HEIGHT = const(15)
_PLACE_ITEMS = const(16)
_WORD_ID = const(0)
_WORD_COST = const(1)
_WORD_SECOND = const(2)
_WORD_ITEMS = const(3)

# for an outer ring of 150 mm, where the reference studies read them: beside the cells, and in them
_RADII_MM = (190, 205, 228, 236)
_SHAPE_MOST_Q14 = 4096


# share of the way from white to dark at which a cell tells nothing: fading ink and light make dark cells
# paler, while white stays white, unless noise strays as far
_NEUTRAL_Q8 = const(90)
_NEUTRAL_NOISY_Q8 = const(128)
PLAIN = const(0)  # no cell is dark: the lines tell the ID
UNKNOWN = const(-1)

# the second word must cost so much more than the first where the orientation line is not seen, and the first
_GAP_LEAST_TURNED = const(78)  # at most that much
_COST_MOST_TURNED = const(80)
_NEVER = const(1 << 20)
_LINE_DARK = const(64)  # weights of a coding line: one that is seen,
_LINE_WHITE = const(32)  # and one that is not, which may be hidden


class CellReader:
    """Measures the cells of one candidate at a time.

    depths    array of 48: darkness of each cell, 256 = as dark as expected, + _BIAS, 0 outside the
              frame; then the brightness in each and beside each, log units
    margin    of the last decision, 0..255
    """

    def __init__(self, width, height, allowed, scratch, mirrored):
        """allowed: marker.id_set of the IDs that may be told; scratch: array of cell_search.SCRATCH items
        that nobody needs while a reader decides."""
        self.depths = array("i", bytes(4 * 72))
        self.pose = array("i", bytes(4 * _PLACE_ITEMS))
        for ring in range(4):
            self.pose[_PLACE_RADII_Q10 + ring] = _RADII_MM[ring] * 1024 // 150
        self.pose[_PLACE_WIDTH] = width
        self.pose[_PLACE_HEIGHT] = height
        self._allowed = allowed
        self._scratch = scratch
        self._mirrored = mirrored
        self._weights = array("i", bytes(4 * cell_words.WEIGHTS))
        self._lines = array("i", bytes(16))
        # by the ID that the lines tell, 0 for none: what each weighs, and the first cell
        self._lines_of = [array("i", (_BIAS, _BIAS, _BIAS, 0))]
        for lines_id in range(1, ID_COUNT):
            weights = [_BIAS + (_LINE_DARK if lines_id >> bit & 1 else -_LINE_WHITE) for bit in range(BITS)]
            self._lines_of.append(array("i", weights + [0]))
        self._result = array("i", bytes(4 * _WORD_ITEMS))
        self._frame = b""
        self._hidden = 0
        self._neutral_q8 = _NEUTRAL_Q8
        self.margin = 0

    def memory(self):
        """Bytes of the buffers."""
        return 4 * (len(self.depths) + len(self.pose) + len(self._weights) + 8 + 4 * ID_COUNT)

    @micropython.native
    def decide(self, lines_id, is_turned=False):
        """Which ID the cells measured last tell: above 7, PLAIN, or UNKNOWN; sets `margin`.

        lines_id: 1..7 as the coding lines were read, which must agree; 0 when in doubt, or plus eight times
        the lines in doubt, when the others must. is_turned: the code alone says where the orientation line
        is."""
        if not self._weigh():
            self.margin = 0
            return UNKNOWN
        if self._mirrored:
            lines_id = mirrored_lines(lines_id & 7) | mirrored_lines(lines_id >> 3) << 3
        lines = self._lines_of[lines_id & 7]
        doubt = lines_id >> 3
        if doubt:
            lines = self._lines
            for bit in range(BITS):
                weight = _LINE_DARK if lines_id >> bit & 1 else -_LINE_WHITE
                lines[bit] = _BIAS if doubt >> bit & 1 else _BIAS + weight
            lines[3] = 0
        weights = self._weights
        result = self._result
        certain = cell_search.certain_word(0, 0, self._scratch, weights, CELL_ROWS, lines, result)
        if 0 < lines_id < ID_COUNT and not (certain and result[_WORD_ID]):
            self._weigh_strokes()  # no stroke looks like a word that is certain
        if not certain:
            self._search(lines)
        told = cell_words.believed_word(lines_id, 0, is_turned, weights, result)
        self.margin = told >> 12
        return (told & 4095) - 1

    def find_turn(self, seen, possible):
        """By how many quarter turns, counterclockwise as seen, the orientation line lies beyond the direction
        through which the cells were measured last; -1 when the code does not make that certain.

        seen: for each of four quarter turns what the inner position there says, above 0 for a line, below for
        none, as much as that is to weigh; possible: bit k: the orientation line may lie there."""
        if not self._weigh():
            return -1
        lines = self._lines
        result = self._result
        found = -1
        best = _NEVER
        second = _NEVER
        for turn in range(4):
            if not possible >> turn & 1:
                continue
            for bit in range(3):
                side = 1 + bit if self._mirrored else 3 - bit
                lines[bit] = seen[(turn + side) & 3] + _BIAS
            lines[3] = (24 - 6 * turn) % 24 if self._mirrored else 6 * turn
            if not cell_search.certain_word(0, 0, self._scratch, self._weights, CELL_ROWS, lines, result):
                self._search(lines)
            cost = result[_WORD_COST]
            if cost < best:
                second = min(best, result[_WORD_SECOND])
                best = cost
                found = turn if result[_WORD_ID] else -1  # the empty word is the same in all turns
            else:
                second = min(second, cost)
        gap = second - best
        return found if gap >= _GAP_LEAST_TURNED and best <= _COST_MOST_TURNED else -1

    def white(self):
        """The white of the plate beside the cells that `decide` or `find_turn` weighed last, log units."""
        return self._weights[24]

    def beside(self, turn, side):
        """The white beside the orientation line's place, that many quarter turns counterclockwise, log units.

        side: 0 counterclockwise of it, 23 clockwise. 0 where that lies outside the frame."""
        cell = (6 * turn + side) % 24
        return self.depths[48 + cell] if self.depths[cell] else 0

    @micropython.native
    def _weigh(self):
        """Weighs the cells measured last; False when too few tell anything."""
        weights = self._weights
        if not cell_words.cell_weights(
            self._neutral_q8, 0, self._scratch, self.depths, self._hidden, weights
        ):
            return False
        if self._mirrored:
            self._mirror()
        return True

    def _mirror(self):
        """Exchanges left and right of the weights."""
        weights = self._weights
        for cell in range(12):
            weight = weights[cell]
            weights[cell] = weights[23 - cell]
            weights[23 - cell] = weight

    def _weigh_strokes(self):
        """Writes what the dark cells cost a plain marker."""
        if self._mirrored:
            self._mirror()  # as they were seen
        self._weights[25] = cell_strokes.stroke_cost(
            0, 0, self._frame, LOG_GREY, self.pose, self.depths, self._weights, self._scratch
        )
        if self._mirrored:
            self._mirror()

    def _search(self, lines):
        """Looks for the words that cost least, where none is certain; lines: as in `likeliest_words`."""
        cell_search.likeliest_words(
            self._scratch, 0, 0, self._weights, CELL_ROWS, lines, self._allowed, self._result
        )

    def measure(self, frame, x_q8, y_q8, radius_q8, e1, e2, hx, hy, turn16, depth, noisy):
        """Measures the cells of a marker; False when its shape is none that a pose can have.

        e1, e2, hx, hy: ellipse and perspective * 2**14 as in kernels.polar.polar_samples; turn16: clockwise
        angle of the orientation line in the plane of the marker; depth: of a dark cell, log units; noisy:
        white strays towards it as far as faded ink does."""
        if max(max(abs(e1), abs(e2)), max(abs(hx), abs(hy))) > _SHAPE_MOST_Q14:
            return False
        pose = self.pose
        pose[_PLACE_X_Q8] = x_q8
        pose[_PLACE_Y_Q8] = y_q8
        pose[_PLACE_RADIUS_Q8] = radius_q8
        pose[_PLACE_E1_Q14] = e1 + _BIAS
        pose[_PLACE_E2_Q14] = e2 + _BIAS
        pose[_PLACE_HX_Q14] = hx + _BIAS
        pose[_PLACE_HY_Q14] = hy + _BIAS
        pose[_PLACE_COSINE_Q14] = cos_q14(turn16) + _BIAS
        pose[_PLACE_SINE_Q14] = sin_q14(turn16) + _BIAS
        pose[_PLACE_DEPTH] = max(1, depth)
        self._hidden = 0
        self._neutral_q8 = _NEUTRAL_NOISY_Q8 if noisy else _NEUTRAL_Q8
        self._frame = frame
        kernels.cell_depths(0, 0, 0, frame, LOG_GREY, CELL_AXES, pose, self.depths)
        return True

    @micropython.native
    def fade(self, depth, local, turn16, is_faint):
        """Puts what was measured in proportion to how dark the rings are before each cell.

        depth, local: of the rings, and of their 16 sectors, as in kernels.cells.local_depths; is_faint: where
        the rings show less than elsewhere they are faint, as behind dirt, and not hidden."""
        self._hidden = kernels.local_depths(depth, 0, turn16, is_faint, local, self.depths)

    @micropython.native
    def measure_direct(self, frame, rings, lines, is_faint):
        """Measures through the pose of `direct.ring_fit.RingFit` and `direct.line_reader.LineReader`.

        is_faint: as in `fade`."""
        angle_turn16 = lines.angle_turn16
        if not kernels.direct_place(rings.fit, 0, 0, COSINE, angle_turn16, self.pose):
            return False
        self._neutral_q8 = _NEUTRAL_Q8
        self._frame = frame
        kernels.cell_depths(0, 0, 0, frame, LOG_GREY, CELL_AXES, self.pose, self.depths)
        self.fade(rings.area, rings.outer_means, angle_turn16, is_faint)
        return True
