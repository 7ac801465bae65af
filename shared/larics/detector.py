"""The detector: grey frame in, markers out. It owns every buffer and allocates nothing after its first frame.

    edges -> hough -> rings -> decode -> verdict -> Detection
    the best of those rejected -> model -> Detection

for each scale of marker that the range of radii needs, and for each candidate of a scale.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics import verdict as verdicts
from larics.decode import LineReader
from larics.detection import (
    FLAG_BORDER,
    FLAG_ID_UNCERTAIN,
    FLAG_MODEL,
    FLAG_TRACKED,
    FLAG_UNCONFIRMED,
    Detection,
)
from larics.edges import EdgeFinder
from larics.fixed import cdeg_from_turn16, frame_view
from larics.hough import CellGrid, CentreVotes, VoteBuffers
from larics.marker import LARICS3
from larics.rings import RingFit
from larics.scales import RADIUS_LEAST_PX, RADIUS_MOST_PX, cut, grouped, tilted_px

MARKERS = const(8)  # reported in one frame at most

_TRACK_SLACK_PX = const(12)  # or half the radius: how far a marker may be from its prediction
_DEVIATION_FIRST_Q10 = const(1300)  # of the rings after the first pass; of tilted markers up to 1100
_DEVIATION_Q10 = const(480)  # after the first passes
_FAR_OFF_Q10 = const(400)  # a first pass that moves the rings by more, and by 1/51, is followed by others,
_COARSE_PASSES = const(3)  # at most that many
_SETTLED_Q10 = const(120)  # a last pass that moves the rings by more is repeated
_SMALL_Q8 = const(4096)  # smaller rings take one pass more to settle
_DEFAULT_LINE_MM10 = const(175)  # reads 15 to 20 mm alike
_FAMILY_MM10 = const(1500)
_TINY_Q8 = const(2304)  # rings below this are too small for the sharp rules


class Counts:
    """What the last frame cost and how its candidates ended, for debugging.

    steep, edges    grid points with a steep gradient, and those that are edges of thin dark lines
    votes           cells voted for
    candidates      centres looked at; one whose score is too low ends as no_radius without more
    crossings       of rings with pixel rows and columns
    verdicts        array of the number of candidates by verdict, see verdict.VERDICT_NAMES
    second          verdict of the second opinion; -1 when it was not asked
    """

    __slots__ = ("steep", "edges", "votes", "candidates", "crossings", "verdicts", "second")

    def __init__(self):
        self.verdicts = array("H", bytes(2 * len(verdicts.VERDICT_NAMES)))
        self.clear()

    def clear(self):
        self.steep = self.edges = self.votes = self.candidates = self.crossings = 0
        self.second = -1
        for index in range(len(self.verdicts)):
            self.verdicts[index] = 0


class Detector:
    """Finds markers in grey frames of one size.

    width, height    px, 64..1024
    radius_min_px, radius_max_px   range of the outer ring's radius, 6..72
    line_mm          width of the lines for an outer radius of 150 mm; None reads 15 to 20 mm
    family           marker.Family: the geometry
    allowed_ids      IDs that may be reported; None: all that the family uses
    allow_id0        also report ID 0, which has no coding line
    second_opinion   judge the best rejected candidate by a model of blur when no marker has been read
    margin_min       0..255: no marker of a smaller margin is reported. More makes wrong IDs rarer and misses
                     more of what is covered, dirty or badly lit
    max_tilt_deg     of the camera, 0..40: widens the range of radii by what tilt shortens
    confirm          (n, m): an ID seen in fewer than n of the last m frames has FLAG_UNCONFIRMED; None: off

    `counts` tells what the last frame took. ValueError for arguments out of range.
    """

    def __init__(
        self, width, height, radius_min_px=25, radius_max_px=35, line_mm=None, family=LARICS3,
        allowed_ids=None, allow_id0=False, confirm=None, second_opinion=True,
        max_tilt_deg=0, margin_min=verdicts.MARGIN_MIN,
    ):  # fmt: skip
        if not (64 <= width <= 1024 and 48 <= height <= 1024):
            raise ValueError("frames are 64x48 to 1024x1024 px, not %dx%d" % (width, height))
        if not RADIUS_LEAST_PX <= radius_min_px < radius_max_px <= RADIUS_MOST_PX:
            raise ValueError(
                "radii are %d to %d px and the first below the second, not %s:%s"
                % (RADIUS_LEAST_PX, RADIUS_MOST_PX, radius_min_px, radius_max_px)
            )
        if not 0 <= max_tilt_deg <= 40:
            raise ValueError("the tilt is 0 to 40 degrees, not %s" % max_tilt_deg)
        if not 0 <= margin_min <= 255:
            raise ValueError("the margin is 0 to 255, not %s" % margin_min)
        self.width = width
        self.height = height
        self.family = family
        self.counts = Counts()
        outer = family.outer_mm10
        inner_q10 = (family.inner_mm10 * 1024 + outer // 2) // outer
        line_mm10 = (_DEFAULT_LINE_MM10 if line_mm is None else line_mm * 10) * outer // _FAMILY_MM10
        line_q10 = line_mm10 * 1024 // outer
        self._plate_q10 = family.plate_mm10 * 1024 // outer
        self._scales = cut(tilted_px(radius_min_px, max_tilt_deg), radius_max_px)
        self._groups = grouped(self._scales)

        smallest = min([scale.step for scale in self._scales])
        edges_capacity = max(400, width * height // (smallest * smallest) // 4)
        self._edges = array("i", bytes(4 * (edges_capacity + 1)))
        # for the scales that take every second point of a finer grid
        shared = len(self._groups) < len(self._scales)
        self._fewer = array("i", bytes(4 * (edges_capacity // 2 + 1) if shared else 0))
        self._histogram = array("H", bytes(256))
        grids = [CellGrid(width, height, scale.step, scale.radius_max_q8) for scale in self._scales]
        self._votes = VoteBuffers(grids)
        self._centres = self._votes.centres
        for scale, grid in zip(self._scales, grids):
            line_q8 = scale.radius_q8 * line_q10 >> 10
            scale.edges = EdgeFinder(
                width, height, line_q8, scale.step, scale.reach,
                self._edges if any([group[-1] is scale for group in self._groups]) else self._fewer,
                self._histogram,
            )  # fmt: skip
            scale.votes = CentreVotes(
                grid, scale.radius_min_q8, scale.radius_max_q8, inner_q10, line_q8 // 2, scale.step,
                self._votes
            )

        radius_max_q8 = self._scales[-1].radius_max_q8
        self.rings = RingFit(width, height, inner_q10, line_q10, radius_max_q8)
        self.lines = LineReader(width, height, family, line_mm10)
        if allowed_ids is None:
            allowed_ids = range(8)
        allowed_ids = [i for i in allowed_ids if i or allow_id0 or family.allow_id0]
        self.judge = verdicts.Judge(allowed_ids, margin_min)
        self.second = None
        if second_opinion:
            from larics.model import SecondOpinion  # a board with little memory does without

            if SecondOpinion.knows(family):
                self.second = SecondOpinion(
                    width, height, family, line_mm10, self.judge.allowed, margin_min
                )
        self._confirm_least, frames = confirm or (0, 0)
        if confirm and not 1 <= self._confirm_least <= frames <= 255:
            raise ValueError("confirm is (n, m) with 1 <= n <= m <= 255, not %s" % (confirm,))
        self._history = bytearray(frames)
        self._history_next = 0
        detections = [Detection() for _ in range(MARKERS)]
        self._found = [detections[:count] for count in range(MARKERS + 1)]
        self._all = detections
        self._count = 0
        self._seen = False
        self._x_q8 = self._y_q8 = self._radius_q8 = self._motion_x_q8 = self._motion_y_q8 = 0

    def memory(self):
        """Bytes of all buffers and tables in RAM, the frame excepted."""
        total = 4 * (len(self._edges) + len(self._fewer)) + 2 * len(self._histogram) + self._votes.memory()
        total += self.rings.memory() + self.lines.memory()
        if self.second is not None:
            total += self.second.memory()
        for scale in self._scales:
            total += scale.edges.memory() + scale.votes.memory()
        return total

    def detect(self, frame):
        """The markers in a frame: a buffer of width * height bytes, rows from the top.

        Returns a list of Detection, best first, that is reused: copy what must outlive the next frame.
        ValueError when the frame has another size."""
        frame = self._begin(frame)
        self._search(frame)
        self._ask_again(frame)
        return self._finish()

    def track(self, frame, x_q8=None, y_q8=None, radius_q8=None):
        """The marker near a predicted place (1/256 px), fitted at once or searched for in a window only.

        Without a prediction, the first marker of the last frame is expected where its motion between the last
        two frames takes it. When there is nothing in the window, or nothing to expect, the whole frame is
        searched. Returns and raises as `detect`; markers found in the window have FLAG_TRACKED."""
        frame = self._begin(frame)
        if x_q8 is None and self._seen:
            x_q8 = self._x_q8 + self._motion_x_q8
            y_q8 = self._y_q8 + self._motion_y_q8
            radius_q8 = self._radius_q8
        if x_q8 is not None:
            self._search_window(frame, x_q8, y_q8, radius_q8)
        if not self._count:
            self._search(frame)
            self._ask_again(frame)
        return self._finish()

    def _begin(self, frame):
        frame = frame_view(frame)
        if len(frame) != self.width * self.height:
            raise ValueError(
                "a frame of %dx%d px has %d bytes, not %d"
                % (self.width, self.height, self.width * self.height, len(frame))
            )
        self._count = 0
        self.counts.clear()
        self.rings.crossings = 0
        if self.second is not None:
            self.second.candidates.forget()
        return frame

    def _finish(self):
        """Remembers what the next frames need and returns the detections."""
        count = self._count
        self.counts.crossings = self.rings.crossings
        if count:
            first = self._all[0]
            if self._seen:
                self._motion_x_q8 = first.x_q8 - self._x_q8
                self._motion_y_q8 = first.y_q8 - self._y_q8
            self._x_q8 = first.x_q8
            self._y_q8 = first.y_q8
            self._radius_q8 = first.radius_q8
        if not count or not self._seen:
            self._motion_x_q8 = self._motion_y_q8 = 0
        self._seen = count > 0
        if self._history:
            self._confirm()
        return self._found[count]

    def _confirm(self):
        """Flags the IDs that too few of the last frames agree on."""
        ids = 0
        for index in range(self._count):
            if self._all[index].marker_id >= 0:
                ids |= 1 << self._all[index].marker_id
        self._history[self._history_next] = ids
        self._history_next = (self._history_next + 1) % len(self._history)
        for index in range(self._count):
            found = self._all[index]
            if found.marker_id >= 0:
                agreeing = 0
                for ids in self._history:
                    agreeing += ids >> found.marker_id & 1
                if agreeing < self._confirm_least:
                    found.flags |= FLAG_UNCONFIRMED

    def _search(self, frame):
        """Searches the whole frame for markers of all scales."""
        for group in self._groups:
            finest = group[-1].edges
            finest.measure_threshold(frame)
            for scale in group:
                scale.edges.threshold = finest.threshold
            if self._tiny(group[0]):
                continue
            alternate = finest.list_steep(frame, len(self._fewer) - 1 if len(group) > 1 else 0)
            self.counts.steep += finest.steep
            for scale in group:
                if not self._tiny(scale):
                    count = finest.steep if scale.edges is finest else alternate
                    edges = scale.edges.choose(frame, finest.edges, count)
                    centres = self._vote(scale, scale.edges.edges, edges)
                    self._examine_all(frame, scale, edges, centres, 0)

    def _search_blurred(self, frame):
        """Finds candidates for the second opinion alone: lines that are blurred need not look like lines."""
        finder = None
        for scale in self._scales:
            if finder is None or not finder.finds_alike(scale.edges):
                finder = scale.edges
                edges = finder.find_blurred(frame)
                self.counts.steep += finder.steep
            for index in range(0, 3 * self._vote(scale, finder.edges, edges), 3):
                self.second.candidates.remember(
                    self._centres[index + 1] - 32768, self._centres[index + 2] - 32768, scale.radius_min_q8,
                    scale.radius_max_q8, verdicts.NO_RADIUS, self._centres[index],
                )  # fmt: skip

    def _vote(self, scale, listed, edges):
        """Lists the centres that the listed edges of the whole frame vote for; returns their number."""
        centres = scale.votes.find(listed, edges, self.width, 0, self.width, 0, self.height)
        self.counts.edges += edges
        self.counts.votes += scale.votes.votes
        return centres

    def _tiny(self, scale):
        """Whether rings have too few pixels for the sharp rules, so that the second opinion decides alone."""
        return self.second is not None and scale.radius_min_q8 < _TINY_Q8

    def _search_window(self, frame, x_q8, y_q8, radius_q8):
        """Searches for a marker of about that radius around a place."""
        for scale in self._scales:
            if radius_q8 <= scale.radius_max_q8:
                break
        slack = max(_TRACK_SLACK_PX, radius_q8 >> 9)
        left = max(0, (x_q8 >> 8) - slack)
        right = min(self.width, (x_q8 >> 8) + slack)
        top = max(0, (y_q8 >> 8) - slack)
        bottom = min(self.height, (y_q8 >> 8) + slack)
        if left >= right or top >= bottom:
            return
        reach = (radius_q8 + (radius_q8 >> 3) >> 8) + 4
        # a good prediction is all that the fit needs; no edges are looked for
        radius_q8 = min(max(radius_q8, scale.radius_min_q8), scale.radius_max_q8)
        if self._candidate(frame, scale, 0, x_q8, y_q8, radius_q8, FLAG_TRACKED):
            return
        if not scale.edges.threshold:
            scale.edges.measure_threshold(frame)
        edges = scale.edges.find(frame, left - reach, right + reach, top - reach, bottom + reach)
        self.counts.steep += scale.edges.steep
        self.counts.edges += edges
        centres = scale.votes.find(scale.edges.edges, edges, self.width, left, right, top, bottom)
        self.counts.votes += scale.votes.votes
        self._examine_all(frame, scale, edges, centres, FLAG_TRACKED)

    def _examine_all(self, frame, scale, edges, centres, flags):
        """Examines the candidate centres of one scale, best first, and reports the markers among them."""
        found = self._centres
        for index in range(0, 3 * centres, 3):
            x_q8 = found[index + 1] - 32768
            y_q8 = found[index + 2] - 32768
            if self._count < MARKERS and not (self._count and self._taken(x_q8, y_q8)):
                promising = found[index] >= scale.votes.least_score
                self._candidate(frame, scale, edges if promising else 0, x_q8, y_q8, 0, flags)

    def _candidate(self, frame, scale, edges, x_q8, y_q8, radius_q8, flags):
        """Examines one candidate, with a predicted radius or with edges, and reports it when it is a marker.

        Returns whether it is."""
        counts = self.counts
        counts.candidates += 1
        verdict = self._examine(frame, scale, edges, x_q8, y_q8, radius_q8)
        if verdict <= verdicts.ID_UNCERTAIN and self.second is not None and self.rings.radius_q8 < _TINY_Q8:
            verdict = verdicts.POOR_RINGS
        counts.verdicts[verdict] += 1
        if verdict and self.second is not None:
            self.second.candidates.remember(
                x_q8, y_q8, scale.radius_min_q8, scale.radius_max_q8, verdict, 0
            )
        if verdict > verdicts.ID_UNCERTAIN:
            return False
        self._report(verdict, flags)
        return True

    def _ask_again(self, frame):
        """Asks the second opinion when no marker has been read."""
        second = self.second
        if second is None:
            return
        for index in range(self._count):
            if not self._all[index].flags & FLAG_ID_UNCERTAIN:
                return
        self._search_blurred(frame)
        verdict = second.examine(frame)
        self.counts.second = verdict
        if verdict != verdicts.ACCEPTED:
            return
        # in the place of a marker whose ID was uncertain, or of its own
        index = 0
        while index < self._count and not self._all[index].covers(second.x_q8, second.y_q8):
            index += 1
        if index == self._count:
            if self._count == MARKERS:
                return
            self._count += 1
        found = self._all[index]
        found.marker_id = second.judge.marker_id
        found.x_q8 = second.x_q8
        found.y_q8 = second.y_q8
        found.radius_q8 = second.rings.radius_q8
        found.heading_cdeg = second.heading_cdeg
        found.margin = second.judge.margin
        found.flags = FLAG_MODEL | self._border(found)

    def _taken(self, x_q8, y_q8):
        """Whether a marker found already covers this place."""
        for index in range(self._count):
            if self._all[index].covers(x_q8, y_q8):
                return True
        return False

    def _examine(self, frame, scale, edges, x_q8, y_q8, radius_q8):
        """Fits and reads one candidate and returns the verdict. Radius 0: the `edges` tell it,
        0 edges: it is not worth that."""
        rings = self.rings
        lines = self.lines
        judge = self.judge
        deviation_q10 = _DEVIATION_FIRST_Q10
        if radius_q8:
            rings.start(x_q8 << 2, y_q8 << 2, radius_q8)
            deviation_q10 = _DEVIATION_Q10
        elif not edges or not rings.coarse(
            scale.edges.edges, edges, x_q8, y_q8, scale.radius_min_q8, scale.radius_max_q8,
            scale.edges.half_line_q8,
        ):
            return verdicts.NO_RADIUS
        if not rings.refine(frame, 6, 3, 192):
            return verdicts.NO_FIT
        if not judge.first_look(rings, deviation_q10):
            return verdicts.POOR_RINGS
        more = _COARSE_PASSES
        while rings.moved_q10 > max(_FAR_OFF_Q10, rings.radius_q8 * 5 >> 6) or (
            more == _COARSE_PASSES and rings.radius_q8 < _SMALL_Q8
        ):
            if not more or not rings.refine(frame, 12 if rings.radius_q8 < _SMALL_Q8 else 6, 3, 192):
                return verdicts.NO_FIT
            more -= 1
        if not judge.first_look(rings, _DEVIATION_Q10):
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
        verdict = judge.rings(rings, scale.radius_min_q8, scale.radius_max_q8)
        if verdict != verdicts.ACCEPTED:
            return verdict
        lines.refine(frame, rings)
        verdict = judge.orientation(lines, rings)
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
        found.flags = flags | self._border(found)

    def _border(self, found):
        """FLAG_BORDER when the plate of a marker leaves the frame, else 0."""
        plate_q8 = found.radius_q8 * self._plate_q10 >> 10
        if (
            plate_q8 <= found.x_q8 <= (self.width << 8) - plate_q8
            and plate_q8 <= found.y_q8 <= (self.height << 8) - plate_q8
        ):
            return 0
        return FLAG_BORDER
