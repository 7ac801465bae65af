"""The detector: grey frame in, markers out. It owns every buffer and allocates nothing after its first frame.

    edges -> centre votes -> direct reader -> blur-model reader -> Detection
    the best of those rejected -> model -> Detection

for each scale of marker that the range of radii needs, and for each candidate of a scale.
"""

from array import array

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith.fixed import frame_view, words
from larics.detect.blurred_search import BlurredSearch, least_score
from larics.detect.centre_votes import CellGrid, CentreVotes, VoteBuffers
from larics.detect.confirmation import Confirmation
from larics.detect.edges import EdgeFinder
from larics.detect.scales import RADIUS_LEAST_PX, RADIUS_MOST_PX, cut, grouped, tilted_px
from larics.detect.statistics import Statistics
from larics.direct.reader import TINY_Q8, DirectReader
from larics.marker import CODED, RADIUS_MAX_PX, RADIUS_MIN_PX, verdicts
from larics.marker.detection import FLAG_BLUR_MODEL, FLAG_BORDER, FLAG_ID_UNCERTAIN, FLAG_TRACKED, Detection
from larics.marker.id_set import id_set

MARKERS = const(8)  # reported in one frame at most
_FAINT_MARGIN = const(96)  # of a faint marker that the direct reader reads and the other one does not

# what a frame may take, thousands of instructions, before the blur-model reader leaves the rest to the next
_BUDGET = const(5900)
_BUDGET_MANY = const(13800)  # with several scales or small rings
_COARSE_STEP = const(4)  # finer grids take more, and the first fit of small rings often fails

_TRACK_SLACK_PX = const(12)  # or half the radius: how far a marker may be from its prediction
_DEFAULT_LINE_MM10 = const(175)  # reads 15 to 20 mm alike
_FAMILY_MM10 = const(1500)


class Detector:
    """Finds markers in grey frames of one size.

    width, height    px, 64..1024; detect.thinned takes more
    radius_min_px, radius_max_px   range of the outer ring's radius, 6..72
    line_mm          width of the lines for an outer radius of 150 mm; None reads 15 to 20 mm
    family           marker.Family: geometry, and whether cells are read; the plain one reads a coded marker
                     as its ID mod 8
    allowed_ids      IDs that may be reported, or (first, last) of ranges; None: all that the family uses. Of
                     cells only these are rivals: the fewer IDs, the more may be covered
    allow_id0        also report ID 0, which has no coding line
    second_opinion   judge the best rejected candidate by a model of blur when no marker has been read; rings
                     below 9 px and faint ones are left to it altogether, so one of these a frame is reported
    weigh_all        with the second opinion: where a rule refuses a plain marker, all that was measured of
                     it is weighed together; a board with little memory does without
    margin_min       0..255: no marker of a smaller margin is reported. More makes wrong IDs rarer and misses
                     more of what is covered, dirty or badly lit
    max_tilt_deg     of the camera, 0..40: widens the range of radii by what tilt shortens
    mirrored         the sensor shows left and right exchanged: cells are read the other way round; the ID of
                     a plain marker is reported as it is seen
    thorough         all that the blur-model reader can read is looked for in every frame, each by itself;
                     else it reads one marker a frame, and less is done after frames without a marker
    confirm          (n, m): an ID seen in fewer than n of the last m frames has FLAG_UNCONFIRMED; None: off

    `statistics` tells what the last frame took. ValueError for arguments out of range.
    """

    def __init__(
        self, width, height, radius_min_px=RADIUS_MIN_PX, radius_max_px=RADIUS_MAX_PX, line_mm=None,
        family=CODED, allowed_ids=None, allow_id0=False, confirm=None, second_opinion=True,
        max_tilt_deg=0, margin_min=verdicts.MARGIN_MIN, mirrored=False, thorough=False,
        weigh_all=True,
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
        self.statistics = Statistics()
        outer = family.outer_mm10
        inner_q10 = (family.inner_mm10 * 1024 + outer // 2) // outer
        line_mm10 = (_DEFAULT_LINE_MM10 if line_mm is None else line_mm * 10) * outer // _FAMILY_MM10
        line_q10 = line_mm10 * 1024 // outer
        self._plate_q10 = family.plate_mm10 * 1024 // outer
        self._scales = cut(tilted_px(radius_min_px, max_tilt_deg), radius_max_px)
        self._groups = grouped(self._scales)
        self._groups.reverse()  # the finest grid last, which may have to wait for the next frame

        smallest = min([scale.step for scale in self._scales])
        edges_capacity = max(400, width * height // (smallest * smallest) // 4)
        self._edges = words(edges_capacity + 1, "edges")
        self._histogram = array("H", bytes(256))
        grids = [CellGrid(width, height, scale.step, scale.radius_max_q8) for scale in self._scales]
        # the scales that take every second point of a finer grid list them behind their own cells
        shared = len(self._groups) < len(self._scales)
        self._votes = VoteBuffers(grids, edges_capacity // 2 + 1 if shared else 0)
        self._centres = self._votes.centres
        for scale, grid in zip(self._scales, grids):
            line_q8 = scale.radius_q8 * line_q10 >> 10
            scale.edges = EdgeFinder(
                width, height, line_q8, scale.step, scale.reach,
                self._edges if any([group[-1] is scale for group in self._groups]) else self._votes.beside,
                self._histogram,
            )  # fmt: skip
            scale.votes = CentreVotes(
                grid,
                scale.radius_min_q8,
                scale.radius_max_q8,
                inner_q10,
                line_q8 // 2,
                scale.step,
                self._votes,
            )

        self.allowed = id_set(allowed_ids, family.coded, allow_id0 or family.allow_id0)
        self.direct = DirectReader(
            width, height, family, line_mm10, self._scales[-1].radius_max_q8, self.allowed, margin_min,
            mirrored, second_opinion and weigh_all,
        )  # fmt: skip
        for scale in self._scales:
            scale.radii = self.direct.rings.radii(
                scale.radius_min_q8, scale.radius_max_q8, scale.edges.half_line_q8
            )
        self._thorough = thorough
        self.blur_reader = None
        self._blurred_search = None
        if second_opinion:
            # a board with little memory does without
            from larics.blurred.reader import EXAMINATION_EFFORT, NO_BUDGET, BlurModelReader

            self._budget = NO_BUDGET if thorough else _BUDGET_MANY
            if not thorough and len(self._scales) == 1 and smallest >= _COARSE_STEP:
                self._budget = _BUDGET
            if BlurModelReader.knows(family):
                self.blur_reader = BlurModelReader(
                    width, height, family, line_mm10, self.allowed, margin_min, self.direct.cells,
                    self._scales, self._votes.cells,
                )  # fmt: skip
                self._blurred_search = BlurredSearch(
                    self._scales, self._centres, self.blur_reader.candidates, width, height, self.statistics,
                    self._budget - EXAMINATION_EFFORT if len(self._scales) > 1 else NO_BUDGET,
                )  # fmt: skip
        self._confirmation = Confirmation(confirm[0], confirm[1], MARKERS) if confirm else None
        detections = [Detection() for _ in range(MARKERS)]
        self._found = [detections[:count] for count in range(MARKERS + 1)]
        self._all = detections
        self._turned = bytearray(MARKERS)  # whether the code alone told the orientation of each
        self._kept = Detection()
        self._count = 0
        self._seen = False
        self._missed = False  # nothing was in the last frame's window
        self._x_q8 = self._y_q8 = self._radius_q8 = self._motion_x_q8 = self._motion_y_q8 = 0

    def memory(self):
        """Bytes of all buffers and tables in RAM, the frame excepted."""
        total = 4 * len(self._edges) + 2 * len(self._histogram) + self._votes.memory()
        total += self.direct.memory() + len(self.allowed)
        if self.blur_reader is not None:
            total += self.blur_reader.memory()
        for scale in self._scales:
            total += scale.edges.memory() + scale.votes.memory()
        return total

    def detect(self, frame):
        """The markers in a frame: a buffer of width * height bytes, rows from the top; also an OpenMV image,
        or a dense array of numpy or ulab.

        Returns a list of Detection, best first, that is reused: copy what must outlive the next frame.
        ValueError when the frame has another size."""
        frame = self._begin(frame)
        self._search(frame)
        self._ask_again(frame)
        return self._finish()

    def track(self, frame, x_q8=None, y_q8=None, radius_q8=None):
        """The marker near a predicted place (1/256 px), fitted at once or searched for in a window only.

        Without a prediction, the first marker of the last frame is expected where its motion between the last
        two frames takes it. When there is nothing in the window, nothing is reported of this frame, and the
        next one is searched as a whole, as is one with nothing to expect: no frame pays for both. Returns and
        raises as `detect`; markers found in the window have FLAG_TRACKED."""
        frame = self._begin(frame)
        if x_q8 is None and self._seen:
            x_q8 = self._x_q8 + self._motion_x_q8
            y_q8 = self._y_q8 + self._motion_y_q8
            radius_q8 = self._radius_q8
        if x_q8 is None or self._missed:
            self._search(frame)
            self._ask_again(frame)
        else:
            self._search_window(frame, x_q8, y_q8, radius_q8)
            if self._kept.margin:
                self._report_kept()
            self._missed = not self._count
        return self._finish()

    def _begin(self, frame):
        frame = frame_view(frame)
        if len(frame) != self.width * self.height:
            raise ValueError(
                "a frame of %dx%d px has %d bytes, not %d"
                % (self.width, self.height, self.width * self.height, len(frame))
            )
        self._count = 0
        self._kept.margin = 0
        self.statistics.clear()
        self.direct.begin()
        if self.blur_reader is not None:
            self.blur_reader.candidates.forget()
            self._blurred_search.begin()
        return frame

    def _finish(self):
        """Remembers what the next frames need and returns the detections."""
        count = self._count
        self.statistics.crossings = self.direct.rings.crossings
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
        if self._blurred_search is not None and not self._thorough:
            self._blurred_search.end(self._seen)
        if self._confirmation is not None:
            self._confirmation.update(self._all, count)
        return self._found[count]

    @micropython.native
    def _search(self, frame):
        """Searches the whole frame for markers of all scales."""
        self._missed = False
        blurred = self._blurred_search
        for group in self._groups:
            finest = group[-1].edges
            finest.measure_threshold(frame)
            for scale in group:
                scale.edges.threshold = finest.threshold
            if self._tiny(group[0]):
                continue
            # what blurred edges need is best done while a scale's edges and votes are there
            lower = blurred is not None and blurred.wants_lower(group)
            alternate = finest.list_steep(frame, len(self._votes.beside) - 1 if len(group) > 1 else 0, lower)
            self.statistics.steep += finest.steep
            for scale in group:
                if not self._tiny(scale):
                    count = finest.steep if scale.edges is finest else alternate
                    edges = scale.edges.choose(frame, finest.edges, count, finest.lowered)
                    centres = self._vote(scale, scale.edges.edges, edges)
                    self._examine_all(frame, scale, edges, centres, 0)
                    if blurred is not None and blurred.is_due(scale) and self._wants_second_opinion():
                        blurred.go_on(scale, edges)

    def _vote(self, scale, listed, edges):
        """Lists the centres that the listed edges of the whole frame vote for; returns their number."""
        centres = scale.votes.find(listed, 0, edges, 1, 0, self.width, 0, self.height)
        self.statistics.edges += edges
        self.statistics.votes += scale.votes.votes
        self.statistics.cells += scale.votes.grid.cells
        return centres

    def _tiny(self, scale):
        """Whether rings have too few pixels for the direct reader: the blur-model reader decides alone."""
        return self.blur_reader is not None and scale.radius_min_q8 < TINY_Q8

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
        if self._candidate(frame, scale, 0, x_q8, y_q8, radius_q8, FLAG_TRACKED, 0):
            return
        if not scale.edges.threshold:
            scale.edges.measure_threshold(frame)
        edges = scale.edges.find(frame, left - reach, right + reach, top - reach, bottom + reach)
        self.statistics.steep += scale.edges.steep
        self.statistics.edges += edges
        centres = scale.votes.find(scale.edges.edges, 0, edges, 1, left, right, top, bottom)
        self.statistics.votes += scale.votes.votes
        self._examine_all(frame, scale, edges, centres, FLAG_TRACKED)

    @micropython.native
    def _examine_all(self, frame, scale, edges, centres, flags):
        """Examines the candidate centres of one scale, best first, and reports the markers among them."""
        found = self._centres
        for index in range(0, 3 * centres, 3):
            x_q8 = found[index + 1] - 32768
            y_q8 = found[index + 2] - 32768
            if self._count < MARKERS and not (self._count and self._taken(x_q8, y_q8)):
                promising = found[index] >= scale.votes.least_score
                self._candidate(frame, scale, edges if promising else 0, x_q8, y_q8, 0, flags, found[index])
        self.statistics.crossings = self.direct.rings.crossings

    @micropython.native
    def _candidate(self, frame, scale, edges, x_q8, y_q8, radius_q8, flags, score):
        """Examines one candidate, with a predicted radius or with edges, and reports it when it is a marker.

        score: of the votes for it. Returns whether it is."""
        statistics = self.statistics
        direct = self.direct
        verdict = direct.examine(frame, scale, edges, x_q8, y_q8, radius_q8)
        if verdict <= verdicts.ID_UNCERTAIN and self.blur_reader is not None and not direct.decides():
            if verdict == verdicts.ACCEPTED and not direct.tiny():
                self._keep(flags)
            verdict = verdicts.POOR_RINGS
        statistics.candidates += 1
        statistics.verdicts[verdict] += 1
        is_turned = verdict == verdicts.ACCEPTED and direct.is_turned
        if (verdict or is_turned) and self.blur_reader is not None:
            clear = scale.edges.is_clear()
            if verdict == verdicts.NO_RADIUS and (scale.is_searched or clear and score < least_score(scale)):
                return False
            if verdict != verdicts.NO_RADIUS or not clear:
                score = 0
            self.blur_reader.candidates.remember(
                x_q8, y_q8, scale.radius_min_q8, scale.radius_max_q8,
                verdicts.NO_ORIENTATION if is_turned else verdict, score, clear,
            )  # fmt: skip
        if verdict > verdicts.ID_UNCERTAIN:
            return False
        self._turned[self._count] = is_turned
        self._report(verdict, flags)
        return True

    def _keep(self, flags):
        """Keeps the surest marker that is too faint for the direct reader to decide alone."""
        acceptance = self.direct.acceptance
        if acceptance.lines_margin >= _FAINT_MARGIN and acceptance.margin > self._kept.margin:
            self.direct.tell(self._kept)
            self._kept.flags = flags | self._border(self._kept)

    def _report_kept(self):
        """Reports the faint marker kept, where the blur-model reader has not accepted one."""
        kept = self._kept
        if kept.margin and self._count < MARKERS and not self._taken(kept.x_q8, kept.y_q8):
            self._all[self._count].take(kept)
            self._count += 1

    def _ask_again(self, frame):
        """Asks the blur-model reader when no marker has been read, or none with its orientation line."""
        reader = self.blur_reader
        if reader is None or not self._wants_second_opinion():
            return
        self._blurred_search.find(frame)
        if not self._thorough:
            reader.begin()
        reader.rings.effort = self.statistics.effort()
        for _ in range(MARKERS if self._thorough else 1):
            verdict = reader.examine(
                frame, self._blurred_search.is_sparing(), self._blurred_search.in_turns, self._budget
            )
            if self.statistics.blur_verdict != verdicts.ACCEPTED:
                self.statistics.blur_verdict = verdict
            if verdict != verdicts.ACCEPTED:
                break
            self._report_blurred(reader)
        self._report_kept()

    def _wants_second_opinion(self):
        """Whether no marker was read so far, or none with its orientation line."""
        for index in range(self._count):
            if not (self._all[index].flags & FLAG_ID_UNCERTAIN or self._turned[index]):
                return False
        return True

    def _report_blurred(self, reader):
        # in the place of a marker whose ID was uncertain, or of its own
        index = 0
        while index < self._count and not self._all[index].covers(reader.x_q8, reader.y_q8):
            index += 1
        if index == self._count:
            if self._count == MARKERS:
                return
            self._count += 1
        found = self._all[index]
        reader.tell(found)
        found.flags = FLAG_BLUR_MODEL | self._border(found)

    def _taken(self, x_q8, y_q8):
        """Whether a marker found already covers this place."""
        for index in range(self._count):
            if self._all[index].covers(x_q8, y_q8):
                return True
        return False

    def _report(self, verdict, flags):
        found = self._all[self._count]
        self._count += 1
        self.direct.tell(found)
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
