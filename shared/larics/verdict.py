"""Step 5: whether a candidate is believed, which ID it has, and by what margin.

Every rule compares a measured quantity with a limit and turns the distance into a margin of 0..255; the
weakest rule's is the marker's. The rules on rings and orientation line decide whether there is a marker,
those on the code whether its ID is told.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.detection import NO_ID
from larics.kernels import rings as kernels

ACCEPTED = const(0)
ID_UNCERTAIN = const(1)
NO_RADIUS = const(2)  # the candidate's edges do not lie on two rings
NO_FIT = const(3)  # the rings do not hold under the fit
POOR_RINGS = const(4)  # coverage, ratio, depth or residual are not those of a marker
OUT_OF_RANGE = const(5)
NO_ORIENTATION = const(6)
TWO_ORIENTATIONS = const(7)
NOT_EMPTY = const(8)  # something where nothing is printed, or too doubtful altogether
NO_CODE = const(9)  # ID 0 while it is not enabled
VERDICT_NAMES = (
    "accepted", "id_uncertain", "no_radius", "no_fit", "poor_rings", "out_of_range", "no_orientation",
    "two_orientations", "not_empty", "no_code",
)  # fmt: skip

_BITS = (2, 4, 6)  # positions, most significant first
_EMPTY = (0, 5, 15, 25, 35)  # items of LineReader.code of the other positions
_LINE_MOST = const(520)
_POSE_MARGIN = const(72)  # a pose without an ID needs at least that margin
_GUARD_MOST = const(70)  # areas, 256 = as the rings'
_ONE_LEAST = const(125)
_ZERO_MOST = const(85)
_SMALL_Q8 = const(4096)  # in rings smaller than this, the limits of a bit are farther apart
_SMALL_DOUBT = const(25)
_GLARE = const(90)  # log units: a position that much brighter than the mean may have lost its line
_WEAK_Q8 = const(66)  # a 0 is believed when the ring beside it has this share of the rings' mean area


class Judge:
    """Judges one candidate at a time.

    marker_id, margin   of the last one
    """

    def __init__(self, inner_q10, allowed_ids):
        self.inner_q10 = inner_q10
        self.allowed = bytearray(8)
        for marker_id in allowed_ids:
            self.allowed[marker_id] = 1
        self.marker_id = NO_ID
        self.margin = 255

    def _rule(self, distance, scale):
        """Counts a rule: `distance` from the limit, `scale` = a distance without any doubt. False below 0."""
        if distance < 0:
            return False
        margin = distance * 255 // scale
        if margin < self.margin:
            self.margin = margin
        return True

    def first_look(self, rings):
        """Whether the rings are worth another look after their first passes."""
        weaker = min(rings.outer_area, rings.inner_area)
        stronger = max(rings.outer_area, rings.inner_area)
        ratio_off = abs((rings.inner_q8 << 10) // rings.radius_q8 - self.inner_q10)
        residual = rings.deviation_outer_q10 + rings.deviation_inner_q10
        return weaker * 2 > stronger and ratio_off < 60 and residual < (rings.radius_q8 >> 5) + 480

    def rings(self, rings, radius_min_q8, radius_max_q8):
        """The verdict on the fitted rings alone; begins a new candidate."""
        self.margin = 255
        self.marker_id = NO_ID
        radius_q8 = rings.radius_q8
        if radius_q8 * 8 < radius_min_q8 * 7 or radius_q8 * 8 > radius_max_q8 * 9:
            return OUT_OF_RANGE
        outer = rings.used_outer * 64 // max(1, rings.inside_outer)
        inner = rings.used_inner * 64 // max(1, rings.inside_inner)
        ratio_off = abs((rings.inner_q8 << 10) // radius_q8 - self.inner_q10)
        weaker = min(rings.outer_area, rings.inner_area)
        stronger = max(rings.outer_area, rings.inner_area)
        # with few pixels a ring and a line deviate more than in proportion
        ratio_most = 16 + 76800 // radius_q8
        residual = rings.deviation_outer_q10 + rings.deviation_inner_q10
        residual_most = (radius_q8 >> 5) + 320
        bulge = max(abs(rings.bulge_cos), abs(rings.bulge_sin))
        if (
            rings.inside_outer * 2 + rings.skipped_outer >= 20
            and rings.inside_inner * 2 + rings.skipped_inner >= 24
            and self._rule(outer - 36, 20)
            and self._rule(inner - 36, 20)
            and self._rule(outer + inner - 80, 36)
            and self._rule(ratio_most - ratio_off, 20)
            and self._rule(weaker * 10 - stronger * 6, stronger * 3)
            and self._rule(residual_most - residual, residual_most >> 1)
            and bulge * 2 < radius_q8
        ):
            return ACCEPTED
        return POOR_RINGS

    def orientation(self, lines, rings):
        """The verdict on the orientation line."""
        if not self._rule(250 - lines.second_q8, 150):
            return TWO_ORIENTATIONS
        if (
            self._rule(lines.line_q8 - 96, 110)
            and self._rule(_LINE_MOST - lines.line_q8, 120)
            and self._rule((rings.radius_q8 >> 6) + 200 - lines.deviation_q10, 150)
            and self._rule(90 - lines.gap_q8, 80)
            and self._rule(lines.slope_most_q10 - abs(lines.slope_q10), lines.slope_most_q10)
        ):
            return ACCEPTED
        return NO_ORIENTATION

    def code(self, lines, rings):
        """The verdict on the eight inner positions: five must be empty, three carry the bits."""
        if not lines.code_inside:
            return ID_UNCERTAIN if self.margin >= _POSE_MARGIN else NOT_EMPTY
        code = lines.code
        guard = 0
        for slot in _EMPTY:
            area = code[slot] + code[slot + 1]
            if area > guard:
                guard = area
        if not self._rule(_GUARD_MOST - (guard >> 1), 50):
            return NOT_EMPTY
        level = 0
        for position in range(8):
            level += code[5 * position + 4]
        level >>= 3
        one_least = _ONE_LEAST
        zero_most = _ZERO_MOST
        if rings.radius_q8 < _SMALL_Q8:
            one_least += _SMALL_DOUBT
            zero_most -= _SMALL_DOUBT
        marker_id = 0
        certain = True
        for position in _BITS:
            depth = (code[5 * position + 2] + code[5 * position + 3]) >> 1
            glare = max(0, code[5 * position + 4] - level)
            most = zero_most - (glare >> 1)  # light that is added to a line makes it shallower
            marker_id <<= 1
            if depth >= one_least:
                marker_id |= 1
                self._rule(depth - one_least, 80)
            elif depth > most or glare > _GLARE or self._erased(lines, rings, position):
                certain = False
            else:
                self._rule(most - depth, 50)
        if certain and self.allowed[marker_id]:
            self.marker_id = marker_id
            return ACCEPTED
        if certain and marker_id == 0:
            return NO_CODE
        return ID_UNCERTAIN if self.margin >= _POSE_MARGIN else NOT_EMPTY

    def _erased(self, lines, rings, position):
        """Whether a missing line may be hidden by glare, shadow or dirt: the inner ring beside it is, too."""
        sector = (lines.angle_turn16 - position * 8192 >> 12) & 15
        return kernels.weak_sectors(rings.inner_means, 0, 0, sector + 15, 3, rings.area * _WEAK_Q8 >> 8) > 0
