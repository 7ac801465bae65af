"""The second opinion: a candidate that the sharp rules reject, compared with a model of the blurred marker.

    blur -> rings -> lines -> verdict

for one candidate a frame. It takes blur, defocus, tiny rings, tilt and faintness, not damage: what a sharp
picture shows to be hidden stays hidden.

On a Cortex-M7 it takes 7 to 10 million instructions of a still picture, 10 to 12 of one smeared by motion,
and 3 to 7 where there is no marker.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics import verdict as verdicts
from larics.blur import BlurModel
from larics.blurred_lines import BITS, POSITIONS, BlurredLines
from larics.blurred_rings import BlurredRings
from larics.detection import NO_ID
from larics.fixed import atan2_turn16, cdeg_from_turn16, cos_q14, sin_q14

_TURNS = const(3)
_TURNS_AGAIN = const(2)  # with the lines taken out
_CANDIDATES = const(4)  # looked at coarsely, of which one is examined
_ITEMS = const(6)  # of each: promise, centre, range of radii, sharp verdict
_PROMISE = (0, 5, 1, 2, 3, 3, 4, 4, 4, 5)  # by sharp verdict: how far the candidate came
_SHARP_SIGMA = const(8)  # entry of blur.SIGMAS: up to here a picture without motion is sharp
_SHARP_RADIUS_Q8 = const(3072)  # unless the rings are as small as this

_MATCH_LEAST = const(700)  # squared correlation with the model's rings, 1/1024, median of the sectors
_GOOD_LEAST = const(24)  # sectors of 32: rings that something covers are not for this judge
_RATIO_MOST = const(20)  # of the radii, off the family's, 1/1024
_DEVIATION_MOST = const(36)  # 1/1000 of the radius
_DEPTH_LEAST = const(150)  # of lines, 256 = as deep as the rings
_DEPTH_MOST = const(420)
_DEPTH_FIRST = const(130)
_HALF_LEAST = const(120)
_RIVAL_MOST = const(72)  # percent of the line
_COMMON_MOST = const(170)  # what the empty positions share
_EMPTY_MOST = const(90)
_EMPTY_LEAST = const(-135)
_ZERO_MOST = const(85)
_ONE_LEAST = const(150)
_ONE_MOST = const(420)
_RESIDUAL_MOST = const(260)  # beside a bit, 1024 = as deep as the rings
_HIDDEN = (verdicts.ID_UNCERTAIN, verdicts.TWO_ORIENTATIONS, verdicts.NOT_EMPTY)


class SecondOpinion:
    """Judges one candidate a frame: `forget`, `remember` those that the sharp rules reject, `examine`.

    marker_id, margin, x_q8, y_q8, heading_cdeg   of the one accepted, as in detection.Detection
    blur, rings, lines   what was measured
    """

    def __init__(self, width, height, family, line_mm10, allowed):
        self.blur = BlurModel(family, line_mm10)
        self.rings = BlurredRings(width, height, self.blur)
        self.lines = BlurredLines(family, self.blur)
        self._inner_q10 = (family.inner_mm10 * 1024 + family.outer_mm10 // 2) // family.outer_mm10
        self._allowed = allowed
        self._candidates = array("i", bytes(4 * _ITEMS * (_CANDIDATES + 1)))
        self._count = 0
        self._settled = False  # the rings have been fitted without the lines
        self.marker_id = NO_ID
        self.margin = self.x_q8 = self.y_q8 = self.heading_cdeg = 0

    @staticmethod
    def knows(family):
        """Whether there is a model of a family: those whose rings' radii are 2 to 3."""
        return abs(3 * family.inner_mm10 - 2 * family.outer_mm10) * 100 <= family.outer_mm10

    def memory(self):
        """Bytes of the buffers."""
        return self.blur.memory() + self.rings.memory() + self.lines.memory() + 4 * len(self._candidates)

    def forget(self):
        """Begins a new frame."""
        self._count = 0

    def remember(self, x_q8, y_q8, radius_min_q8, radius_max_q8, verdict):
        """Keeps a candidate that the sharp rules rejected, the more promising before the others."""
        candidates = self._candidates
        rank = _PROMISE[verdict]
        near_q8 = radius_min_q8 >> 2
        for index in range(self._count):
            first = _ITEMS * index
            if (
                abs(candidates[first + 1] - x_q8) < near_q8
                and abs(candidates[first + 2] - y_q8) < near_q8
                and candidates[first] >= rank
            ):
                return
        slot = self._count
        while slot and candidates[_ITEMS * (slot - 1)] < rank:
            for item in range(_ITEMS):
                candidates[_ITEMS * slot + item] = candidates[_ITEMS * (slot - 1) + item]
            slot -= 1
        slot *= _ITEMS
        candidates[slot] = rank
        candidates[slot + 1] = x_q8
        candidates[slot + 2] = y_q8
        candidates[slot + 3] = radius_min_q8
        candidates[slot + 4] = radius_max_q8
        candidates[slot + 5] = verdict
        if self._count < _CANDIDATES:
            self._count += 1

    def examine(self, frame):
        """The verdict on the candidate whose rings look most like rings.

        ACCEPTED, ID_UNCERTAIN or what speaks against it; NO_RADIUS without a candidate."""
        rings = self.rings
        candidates = self._candidates
        self.marker_id = NO_ID
        best = 0
        slot = radius_q8 = x_q10 = y_q10 = e1 = e2 = 0
        for index in range(self._count):
            first = _ITEMS * index
            score = rings.coarse(
                frame, candidates[first + 1], candidates[first + 2], candidates[first + 3],
                candidates[first + 4],
            )  # fmt: skip
            if score > best:
                best = score
                slot = first
                x_q10 = rings.x_q10
                y_q10 = rings.y_q10
                radius_q8 = rings.radius_q8
                e1 = rings.e1
                e2 = rings.e2
        if not best:
            return verdicts.NO_RADIUS
        rings.start(x_q10, y_q10, radius_q8, e1, e2)
        if not self._fit_rings(frame):
            # motion looks like an ellipse at first: once more from a circle
            rings.start(x_q10, y_q10, radius_q8, 0, 0)
            if not self._fit_rings(frame):
                return verdicts.NO_FIT
        radius_min_q8 = candidates[slot + 3]
        radius_max_q8 = candidates[slot + 4]
        sharp_verdict = candidates[slot + 5]
        if rings.radius_q8 * 8 < radius_min_q8 * 7 or rings.radius_q8 * 8 > radius_max_q8 * 9:
            return verdicts.OUT_OF_RANGE
        if self._sharp() and sharp_verdict in _HIDDEN:
            return sharp_verdict
        self.lines.prepare()
        self._settled = False
        if self.blur.still:
            return self._examine_lines(frame)
        # what motion blurs differently in each direction says less about the light
        rings.measure_light(0)
        verdict = self._examine_lines(frame)
        if verdict != verdicts.ACCEPTED and verdict != verdicts.NO_FIT:
            rings.measure_light(1)
            verdict = self._examine_lines(frame)
        return verdict

    def _examine_lines(self, frame):
        """Reads the lines and judges, after the rings have been fitted once more without them."""
        rings = self.rings
        lines = self.lines
        if not lines.find_orientation(frame, rings) or lines.depth < _DEPTH_FIRST:
            return verdicts.NO_ORIENTATION
        rival = lines.rival * 100 // lines.depth
        if not self._settled:
            if not lines.refine_orientation(frame, rings, 1) or not lines.read_code(frame, rings):
                return verdicts.NO_ORIENTATION
            if not rings.fit(frame, _TURNS_AGAIN, lines):
                return verdicts.NO_FIT
        if not self._rings_hold(1, 1):
            return verdicts.POOR_RINGS
        self._settled = True
        if not lines.refine_orientation(frame, rings, 2):
            return verdicts.NO_ORIENTATION
        lines.measure_orientation(rings)
        if not lines.read_code(frame, rings):
            return verdicts.NO_ORIENTATION
        return self._judge(rival)

    def _fit_rings(self, frame):
        return self.rings.fit(frame, _TURNS, None) and self._rings_hold(8, 10)

    def _sharp(self):
        blur = self.blur
        return blur.still and blur.sigma <= _SHARP_SIGMA and self.rings.radius_q8 > _SHARP_RADIUS_Q8

    def _rule(self, distance, scale):
        """Counts a rule: `distance` from the limit, `scale` = a distance without any doubt. False below 0."""
        if distance < 0:
            return False
        self.margin = min(self.margin, distance * 255 // scale)
        return True

    def _rings_hold(self, share, whole):
        """Whether the rings are a marker's; the first time with limits of share / whole."""
        rings = self.rings
        ratio_off = abs(rings.ratio_q10 - self._inner_q10)
        deviation = rings.deviation_q10 * 250 // rings.radius_q8
        self.margin = 255
        return (
            self._rule(rings.match - _MATCH_LEAST * share // whole, 200)
            and self._rule(rings.good - _GOOD_LEAST * share // whole, 8)
            and self._rule(_RATIO_MOST * whole // share - ratio_off, 16)
            and self._rule(_DEVIATION_MOST * whole // share - deviation, 28)
        )

    def _judge(self, rival):
        """The verdict on the lines, with a rival of that many percent of the orientation line."""
        lines = self.lines
        if not (
            self._rule(lines.depth - _DEPTH_LEAST, 70)
            and self._rule(_DEPTH_MOST - lines.depth, 100)
            and self._rule(min(lines.near, lines.far) - _HALF_LEAST, 80)
        ):
            return verdicts.NO_ORIENTATION
        if not self._rule(_RIVAL_MOST - rival, 40):
            return verdicts.TWO_ORIENTATIONS
        if not self._rule(_COMMON_MOST - abs(lines.common), 80):
            return verdicts.NOT_EMPTY
        marker_id = 0
        certain = True
        # depths are told in units of the rings', which blur makes the least certain; the line's own is known
        unit = max(256, lines.depth)
        empty_most = _EMPTY_MOST * unit >> 8
        zero_most = _ZERO_MOST * unit >> 8
        one_most = _ONE_MOST * unit >> 8
        for position in range(POSITIONS):
            amount = lines.amounts[position]
            if position not in BITS and not (
                self._rule(empty_most - amount, 60) and self._rule(amount - _EMPTY_LEAST, 80)
            ):
                return verdicts.NOT_EMPTY
        for position in BITS:
            amount = lines.amounts[position]
            marker_id <<= 1
            if amount >= _ONE_LEAST:
                marker_id |= 1
                certain = certain and self._rule(one_most - amount, 100)
                certain = certain and self._rule(amount - _ONE_LEAST, 80)
            else:
                certain = certain and self._rule(zero_most - amount, 60)
                certain = certain and self._rule(amount - _EMPTY_LEAST, 80)
            certain = certain and self._rule(_RESIDUAL_MOST - lines.residuals[position], 200)
        if certain and self._allowed[marker_id]:
            self._tell(marker_id)
            return verdicts.ACCEPTED
        if certain and marker_id == 0:
            return verdicts.NO_CODE
        return verdicts.ID_UNCERTAIN

    def _tell(self, marker_id):
        """Puts down what is reported of an accepted marker."""
        rings = self.rings
        cosine = cos_q14(self.lines.angle_turn16)
        sine = sin_q14(self.lines.angle_turn16)
        x = cosine + ((rings.e1 * cosine + rings.e2 * sine) >> 14)
        y = sine + ((rings.e2 * cosine - rings.e1 * sine) >> 14)
        self.heading_cdeg = cdeg_from_turn16(-atan2_turn16(y, x))
        self.marker_id = marker_id
        self.x_q8 = (rings.x_q10 + 2) >> 2
        self.y_q8 = (rings.y_q10 + 2) >> 2
