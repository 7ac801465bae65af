"""The direct reader: a candidate judged by what a sharp picture must show.

rings -> decode -> verdict
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.coded.cell_reader import CellReader
from larics.direct.acceptance import Acceptance
from larics.direct.line_reader import LineReader
from larics.direct.ring_fit import RingFit
from larics.marker import verdicts

TINY_Q8 = const(2304)  # rings below this are too small for sharp rules,
_FAINT_Q8 = const(56)  # rings less dark than this too faint, log units: noise may look like a line
_DEVIATION_FIRST_Q10 = const(1300)  # of the rings after the first pass; of tilted markers up to 1100
_DEVIATION_Q10 = const(480)  # after the first passes
_FAR_OFF_Q10 = const(400)  # a first pass that moves the rings by more, and by 1/51, is followed by others,
_COARSE_PASSES = const(3)  # at most that many
_SETTLED_Q10 = const(120)  # a last pass that moves the rings by more is repeated
_SMALL_Q8 = const(4096)  # smaller rings take one pass more to settle


class DirectReader:
    """Judges one candidate at a time.

    rings, lines, cells, acceptance   what was measured of the last one, and the decision on it
                                      (cells: None for the plain family)
    """

    def __init__(self, width, height, family, line_mm10, radius_max_q8, allowed, margin_min, mirrored):
        outer = family.outer_mm10
        self.rings = RingFit(
            width, height, (family.inner_mm10 * 1024 + outer // 2) // outer, line_mm10 * 1024 // outer,
            radius_max_q8,
        )  # fmt: skip
        self.lines = LineReader(family, line_mm10)
        self.acceptance = Acceptance(allowed, margin_min)
        # where the edges' distances lie, nothing lies any more when the cells are read
        self.cells = None
        if family.coded:
            self.cells = CellReader(width, height, allowed, self.rings.distances, mirrored)

    def memory(self):
        """Bytes of the buffers."""
        return self.rings.memory() + self.lines.memory() + (self.cells.memory() if self.cells else 0)

    def decides(self):
        """Whether the last candidate has pixels and contrast enough for these rules to decide alone."""
        rings = self.rings
        if rings.radius_q8 < TINY_Q8:
            return False
        return (rings.area << 8) >= (rings.radius_q8 * rings.line_q10 >> 10) * _FAINT_Q8

    def examine(self, frame, scale, edges, x_q8, y_q8, radius_q8):
        """Fits and reads one candidate and returns the verdict.

        edges: number of edges listed for the scale, which tell the radius; 0: it is not worth that.
        radius_q8: as predicted, then no edges are needed; 0 without a prediction."""
        rings = self.rings
        lines = self.lines
        acceptance = self.acceptance
        deviation_q10 = _DEVIATION_FIRST_Q10
        if radius_q8:
            rings.start(x_q8 << 2, y_q8 << 2, radius_q8)
            deviation_q10 = _DEVIATION_Q10
        elif not edges or not rings.coarse(scale.edges.edges, edges, x_q8, y_q8, scale.radii):
            return verdicts.NO_RADIUS
        if not rings.refine(frame, 6, 3, 192):
            return verdicts.NO_FIT
        if not acceptance.first_look(rings, deviation_q10):
            return verdicts.POOR_RINGS
        more = _COARSE_PASSES
        while rings.moved_q10 > max(_FAR_OFF_Q10, rings.radius_q8 * 5 >> 6) or (
            more == _COARSE_PASSES and rings.radius_q8 < _SMALL_Q8
        ):
            if not more or not rings.refine(frame, 12 if rings.radius_q8 < _SMALL_Q8 else 6, 3, 192):
                return verdicts.NO_FIT
            more -= 1
        if not acceptance.first_look(rings, _DEVIATION_Q10):
            return verdicts.POOR_RINGS
        rivals = lines.find_orientation(frame, rings)
        if rivals != 1:
            return verdicts.TWO_ORIENTATIONS if rivals else verdicts.NO_ORIENTATION
        lines.read_code(frame, rings)
        rings.skip_lines(lines)
        if not rings.refine(frame, 16, 4, 48):
            return verdicts.NO_FIT
        if rings.moved_q10 > _SETTLED_Q10:
            if not rings.refine(frame, 16, 4, 96) or rings.moved_q10 > _SETTLED_Q10:
                return verdicts.NO_FIT
        verdict = acceptance.rings(rings, scale.radius_min_q8, scale.radius_max_q8)
        if verdict != verdicts.ACCEPTED:
            return verdict
        lines.refine(frame, rings)
        verdict = acceptance.orientation(lines, rings)
        if verdict != verdicts.ACCEPTED:
            return verdict
        cells = self.cells
        if cells is not None and not cells.measure_direct(frame, rings, lines):
            return verdicts.POOR_RINGS
        return acceptance.code(lines, rings, cells)
