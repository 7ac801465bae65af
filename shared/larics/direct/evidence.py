"""Where the rules on line and bits refuse a plain marker: all that was measured, weighed together.

The rules ask of each quantity alone whether it is beyond doubt. On a worn print or under a lamp's reflection
one of them often is not, while the others leave no choice. So what was measured is put into two tables that
were learnt from frames (tools/learn_evidence.py): one for the directions that may be the orientation line's,
one for the bits.
"""

from array import array

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith.fixed import COSINE, LOG_GREY, table16
from larics.direct import evidence_tables as tables
from larics.direct.line_reader import DIRECTIONS
from larics.kernels import code_rules, directions
from larics.kernels import evidence as kernels

_BIT_TABLE = table16(tables.BIT)
_LINE_TABLE = table16(tables.LINE)
_ITEMS = const(20)
_ITEM_SHALLOWER = const(1)  # of both halves of a position
_BIAS = const(1 << 24)
_LIGHT_STRAY_HALF = const(4)  # items as in kernels.layouts
_SHAPE_AROUND_FIRST = const(7)
_SHAPE_AROUND_LAST = const(8)
_SHAPE_AROUND_SAMPLES = const(9)
_STROKE_HALF_Q10 = const(20)  # half the distance of the two samples of a circle, 1/1024 of the radius
_STROKE_SIDE = const(10)  # 1/256 turn: from a stroke to what lies beside it
_LIGHT_ITEMS = const(6)
_LEAST = const(-(1 << 20))
# how surely, 256 = a factor of e:
_SECOND_MOST = const(0)  # a second direction may be the orientation line's, at most,
_LINE_LEAST = const(768)  # the first one is,
_AREA_LEAST = const(96)  # how dark a direction is that is looked at more closely, 256 = as the rings
_BIT_LEAST = const(900)  # and each bit is what it is taken for, at least
_BELIEVED_LEAST = const(400)  # what a bit that the rules tell must have, where they are hardly kept
_HALF_FADED = const(15)  # depth of the shallower half of a 0, beyond what halves stray where no bit is
_SURE = const(6)  # more than that, for each step of the margin
_APART = const(20)  # 1/256 turn: between two strokes


class Evidence:
    """Weighs one candidate at a time.

    weights   of its three bits, above 0 for a line, 256 = a factor of e
    margin    of the last ID that was told, 0..255
    items     kernels.evidence: of the last bit or direction that was weighed, + BIAS
    """

    def __init__(self, family, lines):
        """lines: the `LineReader` of the same family that it is asked about."""
        stride = lines.stride
        outer = family.outer_mm10
        shapes = []
        for radius_mm10 in (
            (outer + family.inner_mm10) >> 1,  # between the rings,
            (family.code_start_mm10 + family.code_end_mm10) >> 1,  # across the coding lines
        ):
            shape = array("i", lines.shape)
            shape[_SHAPE_AROUND_FIRST] = (radius_mm10 << 10) // outer - _STROKE_HALF_Q10
            shape[_SHAPE_AROUND_LAST] = (radius_mm10 << 10) // outer + _STROKE_HALF_Q10
            shape[_SHAPE_AROUND_SAMPLES] = 2
            shapes.append(shape)
        self._shapes = shapes
        self._profile = lines.profile
        self.items = array("i", bytes(4 * _ITEMS))
        self._light = array("i", bytes(4 * _LIGHT_ITEMS))
        self._crossing = array("i", bytes(8))
        self._gap = array("H", bytes(512 // stride))
        self._inside = array("H", bytes(512 // stride))
        self.weights = [0, 0, 0]
        self.faded = False
        self.margin = 0

    def memory(self):
        """Bytes of the buffers."""
        return 4 * (_ITEMS + _LIGHT_ITEMS + 2 + len(self._gap) + 2 * len(self._shapes[0]))

    @micropython.native
    def weigh_line(self, lines, rings):
        """How surely the direction that was measured last is the orientation line's, 256 = a factor of e."""
        code_rules.code_light(self._light, lines.code)
        kernels.line_items(
            self.items, lines.line, lines.code, self._light, rings.fit, rings.outer_means, rings.inner_means,
            lines.angle_turn16, lines.end_q8,
        )  # fmt: skip
        return kernels.weigh(self.items, _LINE_TABLE, tables.LINE_PAIRS)

    @micropython.native
    def look_around(self, frame, rings, lines):
        """Looks for strokes between the rings and across the coding lines; False where the frame ends."""
        code_rules.code_light(self._light, lines.code)
        if not self._strokes(frame, rings, 0, self._gap) or not self._strokes(frame, rings, 1, self._inside):
            return False
        count = len(self._gap)
        kernels.second_strokes(self._gap, 0, 0, count, _APART * count >> 8, self._crossing)
        return True

    def _strokes(self, frame, rings, circle, depths):
        """Fills `depths` with `stroke_depths` of one of both circles; False where the frame ends."""
        profile = self._profile
        count = len(depths)
        shape = self._shapes[circle]
        if directions.annulus_profile(0, 0, frame, 0, LOG_GREY, COSINE, rings.fit, shape, profile) < count:
            return False
        unit = 2 * (rings.area << 8) // ((rings.radius_q8 * rings.line_q10 >> 10) + 1)
        kernels.stroke_depths(profile, 0, 0, count, _STROKE_SIDE * count >> 8, unit + 1, depths)
        return True

    @micropython.native
    def weigh_bit(self, lines, rings, bit):
        """How surely a coding line lies at a position, 1..3, below 0 that none does; after `look_around`."""
        kernels.bit_items(
            self.items, lines.code, self._light, rings.fit, rings.inner_means, self._gap, self._inside,
            self._crossing, len(self._gap), lines.angle_turn16, bit,
        )  # fmt: skip
        return kernels.weigh(self.items, _BIT_TABLE, tables.BIT_PAIRS)

    @micropython.native
    def find_line(self, frame, rings, lines):
        """Turns `lines` to the one direction that is surely the orientation line's; False without any."""
        best = second = _LEAST
        best_index = 0
        for index in range(lines.list_directions(frame, rings, DIRECTIONS)):
            weight = _LEAST
            if lines.measure_direction(frame, rings, index) >= _AREA_LEAST:
                if not lines.measure_around(frame, rings):
                    return False
                weight = self.weigh_line(lines, rings)
            if weight > best:
                second = best
                best = weight
                best_index = index
            elif weight > second:
                second = weight
        if best < _LINE_LEAST or second > _SECOND_MOST:
            return False
        lines.measure_direction(frame, rings, best_index)
        return lines.measure_around(frame, rings)

    @micropython.native
    def weigh_bits(self, frame, rings, lines):
        """Weighs all three bits; False where the frame ends."""
        lines.read_code(frame, rings)
        if not lines.code_inside or not self.look_around(frame, rings, lines):
            return False
        self.faded = False
        deepest = _BIAS + _HALF_FADED + self._light[_LIGHT_STRAY_HALF]
        for bit in range(3):
            weight = self.weigh_bit(lines, rings, bit + 1)
            self.weights[bit] = weight
            # a line that has nearly faded is no 0; few of those that were learnt from had
            if weight < 0 and self.items[_ITEM_SHALLOWER] > deepest:
                self.faded = True
        return True

    def told(self):
        """The ID that the bits tell, 1..7; 0 where one is in doubt, or none is set. Sets `margin`."""
        least = 255 * _SURE + _BIT_LEAST
        marker_id = 0
        for weight in self.weights:
            marker_id += marker_id + (weight > 0)
            least = min(least, abs(weight))
        self.margin = max(0, (least - _BIT_LEAST) // _SURE)
        return marker_id if least >= _BIT_LEAST and not self.faded else 0

    def denies(self, marker_id):
        """Whether a bit of an ID that the rules tell is not believed."""
        for bit in range(3):
            weight = self.weights[bit]
            if (weight if marker_id >> 2 - bit & 1 else -weight) < _BELIEVED_LEAST:
                return True
        return False
