"""Whether the blur-model reader accepts a candidate: rules on blurred rings and lines, with a margin."""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.blurred.line_fit import BITS, POSITIONS
from larics.coded.cell_reader import PLAIN
from larics.marker import verdicts
from larics.marker.detection import NO_ID
from larics.marker.id_set import holds

_MATCH_LEAST = const(700)  # squared correlation with the model's rings, 1/1024, median of the sectors
_GOOD_LEAST = const(24)  # sectors of 32: rings that something covers are not for this judge
_GOOD_LEAST_MOVING = const(20)  # where motion washes the rings out they look like nothing
_FAINT = const(160)  # 1/16 grey level: less deep rings drown in noise, and may look less like rings
_MATCH_LEAST_FAINT = const(560)
_GOOD_LEAST_FAINT = const(18)
_RATIO_MOST = const(20)  # of the radii, off the family's, 1/1024
_DEVIATION_MOST = const(36)  # 1/1000 of the radius
_DEPTH_LEAST = const(150)  # of lines, 256 = as deep as the rings
_DEPTH_MOST = const(420)
_HALF_LEAST = const(120)
_LINE_RESIDUAL_MOST = const(200)  # what is no line leaves more, 1024 = as deep as the rings
_LINE_RESIDUAL_MOST_FIRST = const(230)  # before the rings are fitted without the lines; of markers up to 191
_BEYOND_MOST = const(110)  # a cable goes on where the line ends
RIVAL_MOST = const(72)  # percent of the line
_COMMON_MOST = const(170)  # what the empty positions share
_EMPTY_MOST = const(90)
_EMPTY_LEAST = const(-135)
_ZERO_MOST = const(85)
_ZERO_LEAST = const(-60)  # lighter than this, less the noise: something white lies on the plate
_ONE_SHARE = const(10)  # 16ths of the orientation line: less is dirt, or blur beside a line
_ONE_MOST = const(420)
_RESIDUAL_MOST = const(190)  # beside a bit, 1024 = as deep as the rings, and so much more for the noise:
_OF_NOISE = const(2)
_RESIDUAL_MOST_FIRST = const(320)  # before the rings are fitted without the lines; of markers up to 269
_SMALL_Q8 = const(3072)  # radius of rings on which a speck of dirt may be as large as a line,
_ONE_LEAST_SMALL = const(212)  # but is seldom as dark
_DIRTY_MOST = const(200)  # of one position that must be empty, at most
_WASHING = const(7)  # entry of blur_model.MOTIONS: from 5/12 of the outer radius on it may wash out cells;
_PLAIN_LEAST = const(31)  # blur hides cells, and where print is patchy it is taken for blur: that there are
_PLAIN_MOVING = const(151)  # none is believed only with this margin, and this one where motion is as long


class Acceptance:
    """Judges one candidate at a time.

    allowed             marker.id_set of those that may be told; margin_min: smallest margin that is believed
    marker_id, margin   of the last one, as in detection.Detection
    """

    def __init__(self, family, allowed, margin_min):
        self._margin_min = margin_min
        self._inner_q10 = (family.inner_mm10 * 1024 + family.outer_mm10 // 2) // family.outer_mm10
        self._allowed = allowed
        self.marker_id = NO_ID
        self.margin = 0

    def _rule(self, distance, scale):
        """Counts a rule: `distance` from the limit, `scale` = a distance without any doubt. False below 0."""
        if distance < 0:
            return False
        self.margin = min(self.margin, distance * 255 // scale)
        return True

    def rings(self, rings, share, whole):
        """Whether the rings are a marker's, with limits of share / whole; begins a new candidate."""
        ratio_off = abs(rings.ratio_q10 - self._inner_q10)
        deviation = rings.deviation_q10 * 250 // rings.radius_q8
        good_least = _GOOD_LEAST if rings.blur.still else _GOOD_LEAST_MOVING
        match_least = _MATCH_LEAST
        if rings.amplitude < _FAINT:
            good_least = _GOOD_LEAST_FAINT
            match_least = _MATCH_LEAST_FAINT
        self.marker_id = NO_ID
        self.margin = 255
        return (
            self._rule(rings.match - match_least * share // whole, 200)
            and self._rule(rings.good - good_least * share // whole, 8)
            and self._rule(_RATIO_MOST * whole // share - ratio_off, 16)
            and self._rule(_DEVIATION_MOST * whole // share - deviation, 28)
        )

    def lines(self, lines, rival, radius_q8, cells):
        """The verdict on the lines, with a rival of so many percent of the orientation line, and cells.

        cells: the `coded.cell_reader.CellReader` that has measured them; None for the plain family."""
        small = radius_q8 < _SMALL_Q8
        if not (
            self._rule(lines.depth - _DEPTH_LEAST, 70)
            and self._rule(_DEPTH_MOST - lines.depth, 100)
            and self._rule(min(lines.near, lines.far) - _HALF_LEAST, 80)
            and self._rule(_LINE_RESIDUAL_MOST + lines.noise - lines.residual, 120)
            and self._rule(_BEYOND_MOST - lines.beyond, 80)
        ):
            return verdicts.NO_ORIENTATION
        if not self._rule(RIVAL_MOST - rival, 40):
            return verdicts.TWO_ORIENTATIONS
        if not self._rule(_COMMON_MOST - abs(lines.common), 80):
            return verdicts.NOT_EMPTY
        # depths are told in units of the rings', which blur makes the least certain; the line's own is known
        unit = max(256, lines.depth)
        if not self._guards(lines, unit, small):
            return verdicts.NOT_EMPTY
        one_least = _ONE_LEAST_SMALL if small else unit * _ONE_SHARE >> 4
        return self._code(lines, unit, one_least, cells)

    def is_no_line(self, lines):
        """Whether so much is left around the orientation line, at first, that it would not be accepted."""
        return lines.residual > _LINE_RESIDUAL_MOST_FIRST + lines.noise

    def too_uneven(self, lines):
        """Whether so much is left beside the bits, at a first reading, that none would be accepted."""
        most = _RESIDUAL_MOST_FIRST + lines.noise * _OF_NOISE
        for position in BITS:
            if lines.residuals[position] > most:
                return True
        return False

    def _guards(self, lines, unit, small):
        """Whether the five positions that carry no bit are empty; of a small marker one may be dirty."""
        most = _EMPTY_MOST * unit >> 8
        dirty_most = (_DIRTY_MOST if small else _EMPTY_MOST) * unit >> 8
        for position in range(POSITIONS):
            if position not in BITS:
                amount = lines.amounts[position]
                limit = most
                if amount > most:
                    limit = dirty_most
                    dirty_most = most
                if not (self._rule(limit - amount, 60) and self._rule(amount - _EMPTY_LEAST, 80)):
                    return False
        return True

    def _code(self, lines, unit, one_least, cells):
        """The verdict on the three bits and the cells."""
        pose_margin = self.margin
        marker_id = 0
        certain = True
        zero_most = _ZERO_MOST * unit >> 8
        zero_least = _ZERO_LEAST * unit >> 8
        one_most = _ONE_MOST * unit >> 8
        residual_most = _RESIDUAL_MOST + lines.noise * _OF_NOISE
        for position in BITS:
            amount = lines.amounts[position]
            marker_id <<= 1
            if amount >= one_least:
                marker_id |= 1
                certain = certain and self._rule(one_most - amount, 100)
                certain = certain and self._rule(amount - one_least, 80)
            else:
                certain = certain and self._rule(zero_most - amount, 60)
                certain = certain and self._rule(amount + lines.noise - zero_least, 40)
            certain = certain and self._rule(residual_most - lines.residuals[position], 200)
        certain = certain and self.margin >= self._margin_min
        if cells is not None:
            told = cells.decide(marker_id if certain else 0)
            margin = min(pose_margin, cells.margin)
            if told > PLAIN and margin >= self._margin_min and holds(self._allowed, told):
                self.margin = margin
                self.marker_id = told
                return verdicts.ACCEPTED
            self.margin = min(self.margin, cells.margin)
            certain = certain and told == PLAIN and self.margin >= self._margin_min
            certain = certain and (
                cells.margin >= (_PLAIN_LEAST if lines.blur.motion < _WASHING else _PLAIN_MOVING)
            )
        if certain and holds(self._allowed, marker_id):
            self.marker_id = marker_id
            return verdicts.ACCEPTED
        if certain and marker_id == 0:
            return verdicts.NO_CODE
        return verdicts.ID_UNCERTAIN
