"""The direct reader: a candidate judged by what a sharp picture must show.

rings -> decode -> verdict
"""

from array import array

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith.fixed import cdeg_from_turn16
from larics.coded.cell_reader import CellReader
from larics.direct import uncertainty
from larics.direct.acceptance import Acceptance
from larics.direct.line_reader import LineReader
from larics.direct.ring_fit import RingFit
from larics.direct.robust_centre import RobustCentre
from larics.marker import ID_COUNT, verdicts
from larics.marker.detection import NO_SIGMA

TINY_Q8 = const(2304)  # rings below this are too small for sharp rules,
_FAINT_Q8 = const(56)  # rings less dark than this too faint, log units: noise may look like a line
_DEVIATION_FIRST_Q10 = const(1300)  # of the rings after the first pass; of tilted markers up to 1100
_DEVIATION_Q10 = const(480)  # after the first passes
_LINES_COARSE = const(6)  # crossings a quarter ring: in the first passes,
_LINES_COARSE_SMALL = const(12)
_LINES = const(16)  # and in the last ones;
_LINES_COARSE_TRACKED = const(4)  # near a good prediction fewer will do,
_LINES_COARSE_TRACKED_LARGE = const(3)  # of rings from
_LARGE_Q8 = const(7168)  # this radius on
_LINES_TRACKED = const(12)
_FAR_OFF_Q10 = const(400)  # a first pass that moves the rings by more, and by 1/51, is followed by others,
_COARSE_PASSES = const(3)  # at most that many
_SETTLED_Q10 = const(120)  # a last pass that moves the rings by more is repeated
_LINE_LEAST = const(125)  # depth of an inner position that is a line, 256 = as the rings',
_EMPTY_MOST = const(40)  # and of one that is empty; what they weigh against a cell's 64:
_LINE_SEEN = const(64)
_NO_LINE_SEEN = const(16)  # it may be hidden
_WHITE = const(40)  # log units: a place that differs less from the white plate
_BESIDE_LEAST_Q8 = const(179)  # of the rings' area: a sector with less is hidden, in part
_CENTRE_MOVED_Q10 = const(40)  # by the robust fit: the orientation line is measured twice
_SURE_MARGIN = const(128)  # an ID with less is held against all evidence
_CODED_MARGIN = const(64)  # cells need that where all evidence told the orientation line
_WEIGHED_MOST = const(1)  # places of a frame whose directions are weighed in vain
_BENT = const(43)  # 1/1024: by so much of the radius on average
_SMALL_Q8 = const(4096)  # smaller rings take one pass more to settle


class DirectReader:
    """Judges one candidate at a time.

    rings, robust, lines, cells, acceptance   what was measured of the last one, and the decision on it
                                              (cells: None for the plain family)
    is_turned   the code, not the orientation line, told how the last one is turned
    is_weighed  all evidence on that line together told it, where a rule refuses it
    """

    def __init__(
        self, width, height, family, line_mm10, radius_max_q8, allowed, margin_min, mirrored, weighs=True
    ):
        """weighs: all evidence is weighed where the rules refuse a plain marker."""
        outer = family.outer_mm10
        self.rings = RingFit(
            width, height, (family.inner_mm10 * 1024 + outer // 2) // outer, line_mm10 * 1024 // outer,
            radius_max_q8,
        )  # fmt: skip
        # where the edges' distances lie, nothing lies any more once the coarse radius is known
        self.robust = RobustCentre(self.rings.distances)
        self.lines = LineReader(family, line_mm10)
        self.evidence = None
        if weighs:
            # a board with little memory does without
            from larics.direct.evidence import Evidence

            self.evidence = Evidence(family, self.lines)
        self.acceptance = Acceptance(allowed, margin_min)
        self.is_turned = self.is_weighed = False
        self._in_vain = 0  # places weighed in this frame that are no marker
        self._seen = array("i", bytes(16))
        self.cells = None
        if family.coded:
            self.cells = CellReader(width, height, allowed, self.rings.distances, mirrored)

    def begin(self):
        """Begins a frame."""
        self.rings.crossings = 0
        self._in_vain = 0

    def memory(self):
        """Bytes of the buffers."""
        cells = self.cells.memory() if self.cells else 0
        evidence = self.evidence.memory() if self.evidence else 0
        return self.rings.memory() + self.lines.memory() + cells + evidence

    def decides(self):
        """Whether the last candidate has pixels and contrast enough for these rules to decide alone."""
        rings = self.rings
        if self.tiny():
            return False
        return (rings.area << 8) >= (rings.radius_q8 * rings.line_q10 >> 10) * _FAINT_Q8

    def tiny(self):
        """Whether its rings have too few pixels for these rules."""
        return self.rings.radius_q8 < TINY_Q8

    def tell(self, found):
        """Puts what was read of an accepted candidate into a Detection, all but its flags."""
        rings = self.rings
        lines = self.lines
        found.marker_id = self.acceptance.marker_id
        found.x_q8 = (rings.true_x_q10 + 2) >> 2
        found.y_q8 = (rings.true_y_q10 + 2) >> 2
        # where rows and columns cross a ring obliquely, their middle lies within it: by (width / radius) ** 2
        bent_q8 = (rings.radius_q8 * rings.line_q10 >> 10) * rings.line_q10 * _BENT >> 20
        found.radius_q8 = rings.radius_q8 + bent_q8
        found.heading_cdeg = cdeg_from_turn16(-lines.angle_turn16)
        found.margin = self.acceptance.margin
        variance = uncertainty.centre_variance(self.robust, rings, None if self.is_turned else lines)
        found.sigma_q12 = uncertainty.sigma_q12(variance)
        found.sigma_mdeg = NO_SIGMA  # of what the code alone tells
        if not self.is_turned:
            found.sigma_mdeg = uncertainty.sigma_mdeg(variance, lines, rings.radius_q8)

    @micropython.native
    def examine(self, frame, scale, edges, x_q8, y_q8, radius_q8):
        """Fits and reads one candidate and returns the verdict.

        edges: number of edges listed for the scale, which tell the radius; 0: it is not worth that.
        radius_q8: as predicted, then no edges are needed; 0 without a prediction."""
        verdict = self._examine(frame, scale, edges, x_q8, y_q8, radius_q8)
        if self.is_weighed and verdict != verdicts.ACCEPTED:
            self._in_vain += 1
            return verdicts.NO_ORIENTATION  # as by the rules: a place without an ID must be sure
        return verdict

    @micropython.native
    def _examine(self, frame, scale, edges, x_q8, y_q8, radius_q8):
        rings = self.rings
        lines = self.lines
        acceptance = self.acceptance
        self.is_weighed = False
        coarse_lines = _LINES_COARSE
        fine_lines = _LINES
        if radius_q8:
            coarse_lines = _LINES_COARSE_TRACKED if radius_q8 < _LARGE_Q8 else _LINES_COARSE_TRACKED_LARGE
            fine_lines = _LINES_TRACKED
            rings.start(x_q8 << 2, y_q8 << 2, radius_q8)
        elif not edges or not rings.coarse(scale.edges.edges, edges, x_q8, y_q8, scale.radii):
            return verdicts.NO_RADIUS
        if not rings.refine(frame, coarse_lines, 3, 192):
            return verdicts.NO_FIT
        if not acceptance.first_look(rings, _DEVIATION_FIRST_Q10):
            return verdicts.POOR_RINGS
        more = _COARSE_PASSES
        while rings.moved_q10 > max(_FAR_OFF_Q10, rings.radius_q8 * 5 >> 6) or (
            more == _COARSE_PASSES and rings.radius_q8 < _SMALL_Q8
        ):
            if rings.radius_q8 < _SMALL_Q8:
                coarse_lines = _LINES_COARSE_SMALL
            if not more or not rings.refine(frame, coarse_lines, 3, 192):
                return verdicts.NO_FIT
            more -= 1
        if not acceptance.first_look(rings, _DEVIATION_Q10):
            return verdicts.POOR_RINGS
        rivals = lines.find_orientation(frame, rings)
        self.is_turned = rivals != 1
        if self.is_turned and not self._turn_by_code(frame):
            if not self._weigh_lines(frame):
                return verdicts.TWO_ORIENTATIONS if rivals else verdicts.NO_ORIENTATION
            self.is_turned = False
            self.is_weighed = True
        lines.read_code(frame, rings)
        rings.skip_lines(lines)
        if not rings.refine(frame, fine_lines, 4, 48):
            return verdicts.NO_FIT
        if rings.moved_q10 > _SETTLED_Q10:
            if not rings.refine(frame, fine_lines, 4, 96) or rings.moved_q10 > _SETTLED_Q10:
                return verdicts.NO_FIT
        verdict = acceptance.rings(rings, scale.radius_min_q8, scale.radius_max_q8)
        uneven = covered = False
        if verdict == verdicts.POOR_RINGS:
            verdict = acceptance.rings(rings, scale.radius_min_q8, scale.radius_max_q8, True)
            if verdict == verdicts.ACCEPTED:
                uneven = self._uneven(frame)
                # what hides an arc of both hides few cells: they tell whether it is a marker
                covered = not uneven
                if covered and self.cells is None:
                    return verdicts.POOR_RINGS
                if not rings.refine(frame, 16, 4, 96 if uneven else 48):
                    return verdicts.NO_FIT
                verdict = acceptance.rings(rings, scale.radius_min_q8, scale.radius_max_q8, True)
        if verdict != verdicts.ACCEPTED:
            return verdict
        moved_q10 = rings.take_centre(self.robust) if self.robust.fit(rings) else 0
        if not self.is_turned:
            lines.refine(frame, rings, 2 if moved_q10 > _CENTRE_MOVED_Q10 else 1)
            margin = acceptance.margin
            verdict = acceptance.orientation(lines, rings)
            if verdict != verdicts.ACCEPTED:
                acceptance.margin = margin
                if not self.is_weighed and self._turn_by_code(frame):
                    self.is_turned = True
                    lines.read_code(frame, rings)
                elif self._weigh_lines(frame):
                    self.is_weighed = True
                else:
                    return verdict
        else:
            lines.refine_quarter(frame, rings)
        cells = self.cells
        if cells is not None and not cells.measure_direct(frame, rings, lines, uneven):
            return verdicts.POOR_RINGS
        lines.follow_code(frame, rings)
        verdict = acceptance.code(lines, rings, cells, self.is_turned)
        if self.evidence and not (self.is_turned or uneven or covered):
            verdict = self._weigh_bits(frame, verdict)
        if uneven and verdict == verdicts.ID_UNCERTAIN or covered and acceptance.marker_id < ID_COUNT:
            return verdicts.POOR_RINGS
        return verdict

    def _weigh_lines(self, frame):
        """Whether all evidence tells the orientation line."""
        if self.evidence is None or self._in_vain >= _WEIGHED_MOST:
            return False
        if self.evidence.find_line(frame, self.rings, self.lines):
            return True
        self._in_vain += 1
        return False

    def _weigh_bits(self, frame, verdict):
        """The verdict on all evidence together, after one by the rules.

        It counts where these refuse a plain marker, where all evidence told its orientation line, and against
        an ID where a rule is hardly kept."""
        acceptance = self.acceptance
        if verdict == verdicts.ACCEPTED:
            if acceptance.marker_id >= ID_COUNT:
                if self.is_weighed and acceptance.margin < _CODED_MARGIN:
                    return verdicts.NOT_EMPTY
                return verdict
            if acceptance.margin >= _SURE_MARGIN and not self.is_weighed:
                return verdict
        evidence = self.evidence
        if not evidence.weigh_bits(frame, self.rings, self.lines):
            return verdicts.NOT_EMPTY if self.is_weighed else verdict
        if verdict == verdicts.ACCEPTED and not self.is_weighed:
            return acceptance.deny() if evidence.denies(acceptance.marker_id) else verdict
        return acceptance.weighed(evidence.told(), evidence.margin, self.lines, self.cells, verdict)

    def _turn_by_code(self, frame):
        """Finds the orientation by the code, where the line is hidden or has rivals; False in doubt."""
        cells = self.cells
        lines = self.lines
        if (
            cells is None
            or self.rings.radius_q8 < _SMALL_Q8  # the blur-model reader sees more in so few pixels
            or not lines.find_quarter(frame, self.rings)
            or not cells.measure_direct(frame, self.rings, lines, False)
        ):
            return False
        seen = self._seen
        possible = 0
        for turn in range(4):
            depth = lines.quarter_depth(turn)
            seen[turn] = 0
            if depth >= _LINE_LEAST:
                seen[turn] = _LINE_SEEN
            elif depth < _EMPTY_MOST:
                seen[turn] = -_NO_LINE_SEEN
            if depth < _LINE_LEAST:
                possible |= 1 << turn
        turn = cells.find_turn(seen, possible)
        if turn < 0 or not self._line_hidden(turn):
            return False
        lines.angle_turn16 = lines.angle_turn16 - turn * 16384 & 65535
        return True

    def _line_hidden(self, turn):
        """Whether there are signs that something hides an orientation line that many quarter turns on."""
        cells = self.cells
        outside = self.lines.outside(turn)
        if not outside:
            return True  # beyond the frame
        # where the plate is seen to be white, no line is hidden
        off = outside - cells.white()
        if -_WHITE < off < _WHITE:
            return False
        # a line begins at the ring, and what hides the one hides some of the other
        border = (self.lines.angle_turn16 - turn * 16384 + 2048 & 65535) >> 12
        if self._ring_hidden(border) or self._ring_hidden(border + 15 & 15):
            return True
        # of another tone than the plate on both sides; a shadow's edge differs on one
        before = cells.beside(turn, 23)
        after = cells.beside(turn, 0)
        if not before or not after:
            return True  # beyond the frame
        before = outside - before
        after = outside - after
        return min(before, after) > _WHITE or max(before, after) < -_WHITE

    def _ring_hidden(self, sector):
        """Whether something hides a part of the outer ring in a sector."""
        return 0 < self.rings.outer_means[16 + sector] < self.rings.area * _BESIDE_LEAST_Q8 >> 8

    def _uneven(self, frame):
        """Whether rings too much of which does not count are faint there: a dirty lens may blur one side."""
        return self.rings.refine_faint(frame, 8, 4, 128) and self.acceptance.uneven(self.rings)
