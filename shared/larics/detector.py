"""The detector: grey frame in, markers out. It owns every buffer and allocates nothing after its first frame.

    edges -> hough -> rings -> decode -> verdict -> Detection

for each scale of marker that the range of radii needs, and for each candidate of a scale.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics import verdict as verdicts
from larics.decode import LineReader
from larics.detection import FLAG_BORDER, FLAG_ID_UNCERTAIN, Detection
from larics.edges import EdgeFinder
from larics.fixed import cdeg_from_turn16, frame_view
from larics.hough import CENTRES, WINDOWS, CellGrid, CentreVotes, direction_bits
from larics.marker import LARICS3
from larics.rings import RingFit

MARKERS = const(8)  # reported in one frame at most
RADIUS_LEAST_PX = const(6)
RADIUS_MOST_PX = const(72)

_DEFAULT_LINE_MM10 = const(175)  # reads 15 to 20 mm alike
_SCALE_SPAN_Q8 = const(378)  # radii of one scale: largest / smallest
_FAMILY_MM10 = const(1500)


class Counts:
    """What the last frame cost and how its candidates ended, for debugging.

    steep, edges    grid points with a steep gradient, and those that are edges of thin dark lines
    votes           cells voted for
    candidates      centres examined
    crossings       of rings with pixel rows and columns
    verdicts        array of the number of candidates by verdict, see verdict.VERDICT_NAMES
    """

    __slots__ = ("steep", "edges", "votes", "candidates", "crossings", "verdicts")

    def __init__(self):
        self.verdicts = array("H", bytes(2 * len(verdicts.VERDICT_NAMES)))
        self.clear()

    def clear(self):
        self.steep = self.edges = self.votes = self.candidates = self.crossings = 0
        for index in range(len(self.verdicts)):
            self.verdicts[index] = 0


class _Scale:
    """What one range of radii needs: its edge finder and its vote tables."""

    def __init__(self, radius_min_q8, radius_max_q8):
        self.radius_min_q8 = radius_min_q8
        self.radius_max_q8 = radius_max_q8
        self.radius_q8 = (radius_min_q8 + radius_max_q8) // 2
        radius_px = (self.radius_q8 + 128) >> 8
        if radius_px < 20:
            self.step, self.reach = 3, 1
        else:
            self.step, self.reach = min(8, radius_px // 6), 2
        if radius_px >= 45:
            self.reach = 3


def _scales(radius_min_px, radius_max_px):
    """The range of radii cut into scales of about the same ratio."""
    low_q8, high_q8 = radius_min_px << 8, radius_max_px << 8
    count = 1
    while True:
        ratio_q8 = 256  # the largest ratio whose power covers the range
        while _power_q8(ratio_q8, count) < high_q8 * 256 // low_q8:
            ratio_q8 += 1
        if ratio_q8 <= _SCALE_SPAN_Q8:
            break
        count += 1
    scales = []
    for index in range(count):
        next_q8 = high_q8 if index == count - 1 else low_q8 * ratio_q8 >> 8
        scales.append(_Scale(low_q8, next_q8))
        low_q8 = next_q8
    return scales


def _power_q8(ratio_q8, exponent):
    power = 256
    for _ in range(exponent):
        power = power * ratio_q8 >> 8
    return power


class Detector:
    """Finds markers in grey frames of one size.

    width, height    px, 64..1024
    radius_min_px, radius_max_px   range of the outer ring's radius, 6..72
    line_mm          width of the lines for an outer radius of 150 mm; None reads 15 to 20 mm
    family           marker.Family: the geometry
    allowed_ids      IDs that may be reported; None: all that the family uses
    allow_id0        also report ID 0, which has no coding line
    confirm          (n, m): an ID seen in fewer than n of the last m frames has FLAG_UNCONFIRMED; None: off

    `counts` tells what the last frame took. ValueError for arguments out of range.
    """

    def __init__(
        self, width, height, radius_min_px=25, radius_max_px=35, line_mm=None, family=LARICS3,
        allowed_ids=None, allow_id0=False, confirm=None,
    ):  # fmt: skip
        if not (64 <= width <= 1024 and 48 <= height <= 1024):
            raise ValueError("frames are 64x48 to 1024x1024 px, not %dx%d" % (width, height))
        if not RADIUS_LEAST_PX <= radius_min_px < radius_max_px <= RADIUS_MOST_PX:
            raise ValueError(
                "radii are %d to %d px and the first below the second, not %s:%s"
                % (RADIUS_LEAST_PX, RADIUS_MOST_PX, radius_min_px, radius_max_px)
            )
        self.width = width
        self.height = height
        self.family = family
        self.counts = Counts()
        outer = family.outer_mm10
        inner_q10 = (family.inner_mm10 * 1024 + outer // 2) // outer
        line_mm10 = (_DEFAULT_LINE_MM10 if line_mm is None else line_mm * 10) * outer // _FAMILY_MM10
        line_q10 = line_mm10 * 1024 // outer
        self._plate_q10 = family.plate_mm10 * 1024 // outer
        self._scales = _scales(radius_min_px, radius_max_px)

        smallest = min([scale.step for scale in self._scales])
        edges_capacity = max(400, width * height // (smallest * smallest) * 3 // 8)
        self._edges = array("i", bytes(4 * (edges_capacity + 1)))
        self._histogram = array("H", bytes(256))
        grids = [CellGrid(width, height, scale.step, scale.radius_max_q8) for scale in self._scales]
        self._cells = array("i", bytes(4 * max([grid.cells for grid in grids])))
        self._blocks = array("i", bytes(4 * max([grid.blocks for grid in grids])))
        self._windows = array("H", bytes(2 * (3 * WINDOWS + 3)))
        self._centres = array("i", bytes(4 * (3 * CENTRES + 3)))
        bits = direction_bits()
        for scale, grid in zip(self._scales, grids):
            line_q8 = scale.radius_q8 * line_q10 >> 10
            scale.edges = EdgeFinder(width, height, line_q8, scale.step, scale.reach, self._edges,
            self._histogram)
            scale.votes = CentreVotes(
                grid, scale.radius_min_q8, scale.radius_max_q8, inner_q10, line_q8 // 2, scale.step,
                self._cells, self._blocks, self._windows, bits, self._centres,
            )  # fmt: skip

        self.rings = RingFit(width, height, inner_q10, line_q10, edges_capacity,
        self._scales[-1].radius_max_q8)
        self.lines = LineReader(width, height, family, line_mm10)
        if allowed_ids is None:
            allowed_ids = range(8)
        self.judge = verdicts.Judge(inner_q10, [i for i in allowed_ids if i or allow_id0 or family.allow_id0])
        self._confirm = confirm
        detections = [Detection() for _ in range(MARKERS)]
        self._found = [detections[:count] for count in range(MARKERS + 1)]
        self._all = detections
        self._count = 0

    def memory(self):
        """Bytes of all buffers and tables in RAM, the frame excepted."""
        total = 4 * (len(self._edges) + len(self._cells) + len(self._blocks) + len(self._centres))
        total += 2 * (len(self._histogram) + len(self._windows)) + self.rings.memory() + self.lines.memory()
        for scale in self._scales:
            total += scale.edges.memory() + scale.votes.memory()
        return total

    def detect(self, frame):
        """The markers in a frame: a buffer of width * height bytes, rows from the top.

        Returns a list of Detection, best first, that is reused: copy what must outlive the next frame.
        ValueError when the frame has another size."""
        frame = self._begin(frame)
        for scale in self._scales:
            scale.edges.measure_threshold(frame)
            self._search(frame, scale, 0, self.width, 0, self.height, 0)
        return self._finish()

    def _begin(self, frame):
        if len(frame) != self.width * self.height:
            frame = frame_view(frame)
            if len(frame) != self.width * self.height:
                raise ValueError("a frame of %dx%d has %d bytes, not %d" % (
                    self.width, self.height, self.width * self.height, len(frame)))
        self._count = 0
        self.counts.clear()
        return frame_view(frame)

    def _finish(self):
        return self._found[self._count]

    def _search(self, frame, scale, left, right, top, bottom, flags):
        """Searches a rectangle (px, inside the frame) for one scale's markers."""
        counts = self.counts
        finder = scale.edges
        edges = finder.find(frame, left, right, top, bottom)
        votes = scale.votes
        centres = votes.find(self._edges, edges, self.width, left, right, top, bottom)
        counts.steep += finder.steep
        counts.edges += edges
        counts.votes += votes.votes
        for index in range(centres):
            x_q8 = self._centres[3 * index + 1] - 32768
            y_q8 = self._centres[3 * index + 2] - 32768
            if self._taken(x_q8, y_q8) or self._count == MARKERS:
                continue
            counts.candidates += 1
            verdict = self._examine(frame, scale, edges, x_q8, y_q8)
            counts.verdicts[verdict] += 1
            if verdict <= verdicts.ID_UNCERTAIN:
                self._report(verdict, flags)

    def _taken(self, x_q8, y_q8):
        """Whether a marker found already covers this place."""
        for index in range(self._count):
            other = self._all[index]
            if abs(x_q8 - other.x_q8) < other.radius_q8 and abs(y_q8 - other.y_q8) < other.radius_q8:
                return True
        return False

    def _examine(self, frame, scale, edges, x_q8, y_q8):
        """Fits and reads one candidate and returns the verdict."""
        rings = self.rings
        lines = self.lines
        judge = self.judge
        if not rings.coarse(
            self._edges, edges, x_q8, y_q8, scale.radius_min_q8, scale.radius_max_q8, scale.edges.half_line_q8
        ):
            return verdicts.NO_RADIUS
        if not (rings.refine(frame, 6, 2, 192) and rings.refine(frame, 8, 3, 96)):
            return verdicts.NO_FIT
        verdict = judge.rings(rings, scale.radius_min_q8, scale.radius_max_q8)
        if verdict != verdicts.ACCEPTED:
            return verdict
        lines.find_orientation(frame, rings)
        verdict = judge.orientation(lines)
        if verdict != verdicts.ACCEPTED:
            return verdict
        lines.read_code(frame, rings)
        rings.skip_lines(lines)
        if not rings.refine(frame, 24, 5, 48):
            return verdicts.NO_FIT
        verdict = judge.rings(rings, scale.radius_min_q8, scale.radius_max_q8)
        if verdict != verdicts.ACCEPTED:
            return verdict
        lines.refine(frame, rings)
        verdict = judge.orientation(lines)
        if verdict != verdicts.ACCEPTED:
            return verdict
        return judge.code(lines, rings)

    def _report(self, verdict, flags):
        rings = self.rings
        found = self._all[self._count]
        self._count += 1
        found.marker_id = self.judge.marker_id
        found.x_q8 = (rings.true_x_q10 + 2) >> 2
        found.y_q8 = (rings.true_y_q10 + 2) >> 2
        found.radius_q8 = rings.radius_q8
        found.heading_cdeg = cdeg_from_turn16(-self.lines.angle_turn16)
        found.margin = self.judge.margin
        if verdict == verdicts.ID_UNCERTAIN:
            flags |= FLAG_ID_UNCERTAIN
        plate_q8 = rings.radius_q8 * self._plate_q10 >> 10
        if not (
            plate_q8 <= found.x_q8 <= (self.width << 8) - plate_q8
            and plate_q8 <= found.y_q8 <= (self.height << 8) - plate_q8
        ):
            flags |= FLAG_BORDER
        found.flags = flags
