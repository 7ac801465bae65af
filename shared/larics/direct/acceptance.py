"""Step 5: whether a candidate is believed, which ID it has, and by what margin.

Every rule compares a measured quantity with a limit and turns the distance into a margin of 0..255; the
weakest rule's is the marker's. The rules on rings and orientation line decide whether there is a marker,
those on the code whether its ID is told.
"""

from array import array

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.coded.cell_reader import PLAIN
from larics.kernels import code_rules as code_kernels
from larics.kernels import rules as kernels
from larics.marker.detection import NO_ID
from larics.marker.id_set import holds
from larics.marker.verdicts import (
    ACCEPTED,
    ID_UNCERTAIN,
    NO_CODE,
    NO_ORIENTATION,
    NOT_EMPTY,
    OUT_OF_RANGE,
    POOR_RINGS,
)  # fmt: skip

_RULES = const(7)  # of one step, at most
_POSE_MARGIN = const(112)  # a pose without an ID needs at least that margin
_COVERED_LEAST = const(94)  # of 128: sectors of both rings that agree; half hidden rings are look-alikes
_COVERED_DOUBT = const(30)
_COVERED_UNEVEN = const(64)  # where the others are only fainter
_COVERED_UNEVEN_DOUBT = const(120)
_UNEVEN_USED = const(29)  # of both rings' 32 sectors, that agree when faint ones count
_UNEVEN_DEVIATION = const(160)  # of both rings together, 1/1024 px, and 1/64 of the radius's 1/256 px
_RING_DEVIATION = const(5)
_RING_USED = const(6)
_LIGHT_ITEMS = const(6)  # items as in kernels.layouts
_STROKE_MOST = const(200)  # what goes on between the rings beyond a coding line, 256 = as dark as they
_IN_DOUBT = const(8)  # times the bits in doubt: instead of an ID from here on,
_ALL_IN_DOUBT = const(56)  # or of anything


class Acceptance:
    """Accepts or rejects one candidate at a time.

    allowed             marker.id_set of those that may be told; margin_min: smallest margin that is believed
    marker_id, margin   of the last one; lines_margin: as far as rings and lines tell, without cells
    """

    def __init__(self, allowed, margin_min):
        self._margin_min = margin_min
        self._pose_margin = max(_POSE_MARGIN, margin_min)
        self._allowed = allowed
        self.marker_id = NO_ID
        self.margin = self.lines_margin = self.pose_margin = 255
        self._rules = array("i", bytes(8 * _RULES))
        self._light = array("i", bytes(4 * _LIGHT_ITEMS))

    def _hold(self, count):
        """Whether the first `count` rules hold far enough; the margin becomes that of the weakest."""
        self.margin = kernels.weakest_rule(self._rules, self.margin, count)
        return self.margin >= self._margin_min

    def first_look(self, rings, deviation_q10):
        """Whether the rings are worth another look after their first passes, which left that deviation at
        most."""
        return kernels.rings_plausible(rings.fit, rings.outer, rings.inner, deviation_q10)

    @micropython.native
    def rings(self, rings, radius_min_q8, radius_max_q8, uneven=False):
        """The verdict on the fitted rings alone; begins a new candidate.

        uneven: they may be faint on one side, see `uneven`; then only a marker with an ID is accepted."""
        self.margin = 255
        self.marker_id = NO_ID
        radius_q8 = rings.radius_q8
        if radius_q8 * 8 < radius_min_q8 * 7 or radius_q8 * 8 > radius_max_q8 * 9:
            return OUT_OF_RANGE
        count = kernels.rings_rules(
            self._rules, rings.fit, rings.outer, rings.inner, rings.skipped_outer, rings.skipped_inner,
            _COVERED_UNEVEN if uneven else _COVERED_LEAST,
            _COVERED_UNEVEN_DOUBT if uneven else _COVERED_DOUBT,
        )  # fmt: skip
        return ACCEPTED if count and self._hold(count) else POOR_RINGS

    def uneven(self, rings):
        """Whether a pass that takes faint sectors, too, shows both rings all around: blurred on one side."""
        outer = rings.outer
        inner = rings.inner
        return (
            outer[_RING_USED] + inner[_RING_USED] >= _UNEVEN_USED
            and outer[_RING_DEVIATION] + inner[_RING_DEVIATION] < (rings.radius_q8 >> 6) + _UNEVEN_DEVIATION
        )

    def orientation(self, lines, rings):
        """The verdict on the orientation line."""
        count = kernels.line_rules(self._rules, lines.line, lines.second_q8, rings.radius_q8, lines.end_q8)
        return ACCEPTED if self._hold(count) else NO_ORIENTATION

    @micropython.native
    def code(self, lines, rings, cells, is_turned):
        """The verdict on the eight inner positions, of which five must be empty, and on the cells.

        cells: the `coded.cell_reader.CellReader` that has measured them, None for the plain family;
        is_turned: they alone say where the orientation line is."""
        pose_margin = self.pose_margin = self.margin
        marker_id = _ALL_IN_DOUBT
        is_clean = True
        if lines.code_inside:
            code_kernels.code_light(self._light, lines.code)
            marker_id = code_kernels.code_rules(
                self._rules, lines.code, self._light, rings.fit, rings.inner_means, lines.angle_turn16
            )
            if lines.stroke_q8 > _STROKE_MOST:
                marker_id = _ALL_IN_DOUBT
            is_clean = self._hold(4)
            self.lines_margin = self.margin
        if cells is not None:
            told = cells.decide(marker_id if is_clean else _ALL_IN_DOUBT, is_turned)
            if told > PLAIN and holds(self._allowed, told):
                margin = min(pose_margin, cells.margin)
                if margin >= self._margin_min:
                    self.margin = margin
                    self.marker_id = told
                    return ACCEPTED
            if is_turned:
                return NO_ORIENTATION
            if told != PLAIN:
                marker_id = _ALL_IN_DOUBT
            elif marker_id < _IN_DOUBT and is_clean:
                if cells.margin < self._margin_min:
                    marker_id = _ALL_IN_DOUBT
                else:
                    self.margin = min(self.margin, cells.margin)
        if not is_clean:
            return NOT_EMPTY
        if marker_id < _IN_DOUBT and holds(self._allowed, marker_id):
            self.marker_id = marker_id
            return ACCEPTED
        if marker_id == 0:
            return NO_CODE
        return ID_UNCERTAIN if self.margin >= self._pose_margin else NOT_EMPTY

    @micropython.native
    def weighed(self, lines_id, margin, lines, cells, verdict):
        """The verdict on an ID that `direct.evidence` tells, with that margin; 0: none.

        verdict: that of `code`, which stays where this one is not believed.

        Only of a plain marker: the cells must be seen to be white."""
        told = NO_ID
        if lines_id and lines.stroke_q8 <= _STROKE_MOST and holds(self._allowed, lines_id):
            margin = min(margin, self.pose_margin)
            if cells is None:
                told = lines_id
            elif cells.decide(lines_id) == PLAIN:
                told = lines_id
                margin = min(margin, cells.margin)
        if told == NO_ID or margin < self._margin_min:
            self.marker_id = NO_ID
            return NOT_EMPTY if verdict == ACCEPTED else verdict
        self.margin = margin
        self.marker_id = told
        return ACCEPTED

    def deny(self):
        """The verdict on a marker whose ID is not believed."""
        self.marker_id = NO_ID
        return ID_UNCERTAIN if self.margin >= self._pose_margin else NOT_EMPTY
