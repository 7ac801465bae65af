"""The blur-model reader: a candidate that the direct reader rejects, compared with a blurred marker's model.

    candidates -> blur -> rings -> lines -> verdict

for one candidate a frame. It takes blur, defocus, tiny rings, tilt and faintness, not damage: what a sharp
picture shows to be hidden stays hidden.

On a Cortex-M7 it takes 5 to 6 million instructions of a marker, up to 11 where other candidates come
first. Where there was no marker for six frames, a frame takes 1.0 to 2.7 million with all searches, with
look-alikes up to 6.8; from 10 to 60 px, where scales take turns, 4 to 9, up to 13.1. Before that it is up to
7.0, after a frame with a marker 7.5, and from 10 to 60 px 14.4 and 14.8: `larics.detect.statistics` says what
a frame may spend.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import Parts, atan2_turn16, cdeg_from_turn16, cos_q14, log_grey, sin_q14
from larics.blurred import candidates as items
from larics.blurred import uncertainty
from larics.blurred.acceptance import RIVAL_MOST, Acceptance
from larics.blurred.blur_model import BlurModel
from larics.blurred.candidates import Candidates
from larics.blurred.line_fit import BlurredLines
from larics.blurred.places import READ, REJECTED
from larics.blurred.ring_fit import LOST_FOR_GOOD, LOST_ON_THE_WAY, BlurredRings
from larics.direct.uncertainty import sigma_q12
from larics.marker import verdicts

_BIAS = const(1 << 24)  # items as in kernels.layouts
_ALONG = const(408)

_TURNS = const(3)
_TURNS_AGAIN = const(2)  # with the lines taken out
_TRIES = const(2)  # the candidate that looks most like rings, and another when it is no marker at all
_FITS = const(4)  # of both together
_FEW_FITS = const(2)  # of one, where another one was read in the last frame or little is to be done
NO_BUDGET = const(536870912)
EXAMINATION_EFFORT = const(3900)  # thousands of instructions that most candidates take
_NEXT_EFFORT = const(2300)  # thousands of instructions: a fit and the search for a line,
_SECOND_FIT_EFFORT = const(1000)  # so much more the second fit of a candidate may take than others,
_FAINT_FIT_EFFORT = const(1900)  # each but the first in a faint frame,
_FAINT_FIT_EFFORT_SEVERAL = const(1150)  # less where the radius is not known,
_VIEW_EFFORT = const(0)  # another view of its rings,
_VIEW_EFFORT_SEVERAL = const(700)
_AGAIN_EFFORT = const(2200)  # and another measure of the light for rings in motion,
_AGAIN_EFFORT_SEVERAL = const(2900)
_LINE_EFFORT = const(500)  # that one alone,
_LOOK_EFFORT = const(450)  # a look
_GOOD_OF_MOTION = const(13)  # where motion led a fit astray, fewer sectors look like rings;
_VOTED_LEAST_Q8 = const(3072)  # of smaller rings the votes tell the centre less exactly
_LARGE_Q8 = const(5120)  # rings from that size on are not fitted again otherwise
_DEPTH_FIRST = const(130)
_SHARP_SIGMA = const(8)  # entry of blur.SIGMAS: up to here a picture without motion is sharp,
_SHARP_RADIUS_Q8 = const(3072)  # unless the rings are as small as this
_SHARP_NOISE = const(64)  # or the noise as strong as that
_TILTED_Q14 = const(1000)  # an ellipse of 28 degrees: from there on the direct reader errs, and what it took
_TILTED_MARGIN = const(128)  # for hidden is seen after all where the margin is as large as this
_CELL_UNITS_Q8 = const(983)  # a cell's length along the radius, 24 mm of 150,
_BESIDE = const(5)  # units to where the white beside it is looked at
_HIDDEN = (verdicts.ID_UNCERTAIN, verdicts.TWO_ORIENTATIONS, verdicts.NOT_EMPTY)


class BlurModelReader:
    """Judges one candidate a frame: `candidates` gets those that the direct reader rejects, then `examine`.

    x_q8, y_q8, heading_cdeg   of the one accepted, as in detection.Detection; the ID is its `acceptance`'s
    blur, rings, lines         what was measured
    """

    def __init__(self, width, height, family, line_mm10, allowed, margin_min, cells, scales, idle=None):
        """cells: coded.CellReader, None of the plain family; scales: of detect.scales.cut; idle: words
        that nobody else looks at during `examine` and `tell`, of fixed.Parts."""
        self.candidates = Candidates(len(scales) > 1)
        parts = Parts(idle)
        self.blur = BlurModel(family, line_mm10, parts)
        self.rings = BlurredRings(width, height, self.blur, parts)
        self.lines = BlurredLines(family, self.blur, parts)
        self.scratch = parts.used  # words of `idle`
        self.acceptance = Acceptance(family, allowed, margin_min)
        self._cells = cells
        self._least_q8 = scales[0].radius_min_q8 * 7 >> 3
        self._most_q8 = scales[-1].radius_max_q8 * 9 >> 3
        self._fits_left = 0
        self._recognizes = False  # a candidate was read in the last frame
        self._settled = False  # the rings have been fitted without the lines
        self._postponed = False  # what the last frame had no time for
        self._fitted = 0  # how often the rings of this candidate were
        self._is_cut = False  # there was no time for all that can be done with it
        self._effort_most = 0
        self._hidden = False  # a sharp picture may show that something hides a bit
        self.x_q8 = self.y_q8 = self.heading_cdeg = 0

    @staticmethod
    def knows(family):
        """Whether there is a model of a family: those whose rings' radii are 2 to 3."""
        return abs(3 * family.inner_mm10 - 2 * family.outer_mm10) * 100 <= family.outer_mm10

    def memory(self):
        """Bytes of the buffers."""
        return self.blur.memory() + self.rings.memory() + self.lines.memory() + self.candidates.memory()

    def begin(self):
        """Begins to examine the candidates of a frame that follows the one before."""
        self._recognizes = self.candidates.recognize()

    def examine(self, frame, sparing, few_fits=False, budget=NO_BUDGET):
        """The verdict on the candidate whose rings look most like rings, of those that were not read last.

        sparing: one is examined and no more, and what was rejected lately is passed over; it is fitted twice
        at most where the frame has contrast, or with few_fits. budget: what the frame may take, as
        `rings.effort`; no look nor fit but the first begins that would take more, and what was examined gives
        way to the others in the next frame. ACCEPTED, ID_UNCERTAIN or what speaks against it; NO_RADIUS
        without a candidate."""
        candidates = self.candidates
        rings = self.rings
        verdict = verdicts.NO_RADIUS
        self.blur.forget()
        has_read = self._recognizes
        self._fits_left = _FEW_FITS if few_fits or sparing and candidates.clear else _FITS
        passes_over = sparing or self._postponed
        self._effort_most = budget - _NEXT_EFFORT
        self._postponed = False
        for _ in range(1 if sparing else _TRIES):
            slot = candidates.best(frame, rings, passes_over, self._effort_most - _LOOK_EFFORT)
            if slot < 0:
                if candidates.is_cut and verdict == verdicts.NO_RADIUS:
                    candidates.note_looked()
                    self._postponed = True
                break
            self._fitted = 0
            self._is_cut = False
            if has_read:
                # what was read in the last frame is not to go short
                self._fits_left = _FITS if candidates.was_read(slot) else _FEW_FITS
            self._settled = False
            verdict = self._examine_candidate(frame, slot)
            radius_q8 = rings.radius_q8
            if verdict == verdicts.ACCEPTED:
                candidates.note(slot, radius_q8, READ)
                candidates.dismiss_judged(slot, radius_q8)
                break
            if not self._is_cut and (verdict == verdicts.NO_ORIENTATION or rings.lost == LOST_FOR_GOOD):
                candidates.note(slot, radius_q8, REJECTED)
            if not has_read and (self._settled or verdict == verdicts.NOT_EMPTY):
                break
            over = rings.effort - self._effort_most
            views = over > (_VIEW_EFFORT_SEVERAL if candidates.several else _VIEW_EFFORT)
            if over > 0 - _LOOK_EFFORT and candidates.postpone_others(slot, verdict, views):
                candidates.note(slot, radius_q8, REJECTED)
                self._postponed = True
            candidates.dismiss_ghosts(slot)
            if verdict >= verdicts.NO_ORIENTATION:
                candidates.dismiss_judged(slot, radius_q8)
        return verdict

    def _examine_candidate(self, frame, slot):
        rings = self.rings
        candidate = self.candidates.items
        x_q10 = candidate[slot + items.X_Q10]
        y_q10 = candidate[slot + items.Y_Q10]
        radius_q8 = candidate[slot + items.RADIUS_Q8]
        e1 = candidate[slot + items.E1]
        e2 = candidate[slot + items.E2]
        if not (
            self._fit_rings(frame, x_q10, y_q10, radius_q8, e1, e2)
            # motion looks like a smaller ellipse at first
            or rings.lost == LOST_ON_THE_WAY
            and self._fit_rings(frame, x_q10, y_q10, radius_q8 * 26 // 25, 0, 0)
            or rings.lost != LOST_FOR_GOOD
            and self._fit_again(frame, slot)
        ):
            return verdicts.NO_FIT
        if not self._least_q8 <= rings.radius_q8 <= self._most_q8:
            return verdicts.OUT_OF_RANGE
        self._hidden = candidate[slot + items.VERDICT] in _HIDDEN and self._sharp()
        self.lines.prepare()
        if not self.blur.still:
            # what motion blurs differently in each direction says less about the light
            rings.measure_light(0)
            verdict = self._examine_lines(frame)
            if verdict == verdicts.ACCEPTED or verdict == verdicts.NO_FIT:
                return verdict
            most = _AGAIN_EFFORT_SEVERAL if self.candidates.several else _AGAIN_EFFORT
            if rings.effort - self._effort_most > most:
                self._is_cut = True
                return verdict
            rings.measure_light(1)
        return self._examine_lines(frame)

    def _fit_again(self, frame, slot):
        """Fits the rings from the centre that was voted for, which motion shifts less than a coarse look.

        Where they are faint or small, from where the last fit of motion led to; when still, after another
        coarse look."""
        rings = self.rings
        candidate = self.candidates.items
        if candidate[slot + items.LEAST_Q8] >= _VOTED_LEAST_Q8 and not rings.is_faint():
            x_q10 = candidate[slot + items.X_Q8] - _BIAS << 2
            y_q10 = candidate[slot + items.Y_Q8] - _BIAS << 2
            return self._fit_rings(frame, x_q10, y_q10, candidate[slot + items.RADIUS_Q8], 0, 0)
        if self.blur.still:
            if not rings.coarse(
                frame, candidate[slot + items.X_Q10] >> 2, candidate[slot + items.Y_Q10] >> 2,
                candidate[slot + items.LEAST_Q8], candidate[slot + items.MOST_Q8], 0,
            ):  # fmt: skip
                return False
            return self._fit_rings(frame, rings.x_q10, rings.y_q10, rings.radius_q8, rings.e1, rings.e2)
        return self._fit_rings(frame, rings.x_q10, rings.y_q10, rings.radius_q8, 0, 0)

    def _examine_lines(self, frame):
        """Reads the lines and judges, after the rings have been fitted once more without them."""
        rings = self.rings
        lines = self.lines
        acceptance = self.acceptance
        rings.effort += _LINE_EFFORT
        if not lines.find_orientation(frame, rings) or lines.depth < _DEPTH_FIRST:
            return verdicts.NO_ORIENTATION
        hidden = self._hidden and lines.noise <= _SHARP_NOISE
        if hidden and rings.e1 * rings.e1 + rings.e2 * rings.e2 < _TILTED_Q14 * _TILTED_Q14:
            return verdicts.NOT_EMPTY
        rival = lines.rival * 100 // lines.depth
        if self.blur.still and rival > RIVAL_MOST:
            return verdicts.TWO_ORIENTATIONS  # as it would be told in the end
        if not self._settled:
            if (
                not lines.refine_orientation(frame, rings, 1)
                or not lines.measure_residual(frame, rings)
                or acceptance.is_no_line(lines)
                or not lines.read_code(frame, rings)
            ):
                return verdicts.NO_ORIENTATION
            if acceptance.too_uneven(lines):
                return verdicts.NOT_EMPTY
            if not rings.fit(frame, _TURNS_AGAIN, lines):
                return verdicts.NO_FIT
        if not acceptance.rings(rings, 1, 1):
            return verdicts.POOR_RINGS
        self._settled = True
        if not lines.refine_orientation(frame, rings, 2):
            return verdicts.NO_ORIENTATION
        lines.measure_orientation(rings)
        if self._sharp():
            lines.measure_beyond(frame, rings)
        if not lines.read_code(frame, rings):
            return verdicts.NO_ORIENTATION
        cells = self._cells
        if cells is not None:
            cells.measure(
                frame, (rings.x_q10 + 2) >> 2, (rings.y_q10 + 2) >> 2, rings.radius_q8, rings.e1, rings.e2,
                rings.hx, rings.hy, lines.angle_turn16, self._cell_depth(),
                lines.noise > _SHARP_NOISE,
            )  # fmt: skip
            cells.fade(rings.amplitude, rings.local_depths(), lines.angle_turn16, True)
        verdict = acceptance.lines(lines, rival, rings.radius_q8, cells)
        if verdict == verdicts.ACCEPTED:
            if hidden and acceptance.margin < _TILTED_MARGIN:
                return verdicts.NOT_EMPTY
            self._tell()
        return verdict

    def _fit_rings(self, frame, x_q10, y_q10, radius_q8, e1, e2):
        """Fits the rings from this pose, if a fit is left; returns whether they may be a marker's."""
        if not self._fits_left:
            return False
        if self._fitted:
            if self.rings.effort - self._effort_most > self._more_effort():
                return False
        self._fitted += 1
        self._fits_left -= 1
        rings = self.rings
        rings.start(x_q10, y_q10, radius_q8, e1, e2)
        if not rings.fit(frame, _TURNS, None):
            return False
        if self.acceptance.rings(rings, 8, 10):
            return True
        if rings.blur.still and rings.good > _GOOD_OF_MOTION and radius_q8 >= _LARGE_Q8:
            rings.lost = LOST_FOR_GOOD
        return False

    def _more_effort(self):
        """How much more another fit of this candidate may take than others, thousands of instructions."""
        if self.candidates.clear:
            return _SECOND_FIT_EFFORT if self._fitted == 1 else 0
        return _FAINT_FIT_EFFORT_SEVERAL if self.candidates.several else _FAINT_FIT_EFFORT

    def _cell_depth(self):
        """How dark a cell must look against the white beside it in this blur, log units."""
        blur = self.blur
        white = self.rings.background >> 4
        amplitude = 0
        for rel in (0,) if blur.still else (0, 16):
            # along the radius, which blurs it more than across
            blur.put_along(_CELL_UNITS_Q8, rel)
            amplitude += blur.bars[_ALONG] - blur.bars[_ALONG + _BESIDE]
        if not blur.still:
            amplitude >>= 1
        amplitude = self.rings.amplitude * max(0, amplitude) >> 14
        return log_grey(white) - log_grey(max(0, white - amplitude))

    def _sharp(self):
        blur = self.blur
        return blur.still and blur.sigma <= _SHARP_SIGMA and self.rings.radius_q8 > _SHARP_RADIUS_Q8

    def tell(self, found):
        """Puts what was read of the accepted candidate into a Detection, all but its flags."""
        found.marker_id = self.acceptance.marker_id
        found.x_q8 = self.x_q8
        found.y_q8 = self.y_q8
        found.radius_q8 = self.rings.radius_q8
        found.heading_cdeg = self.heading_cdeg
        found.margin = self.acceptance.margin
        uneven = uncertainty.uneven_square(self.rings)
        found.sigma_q12 = sigma_q12(uncertainty.centre_variance(self.rings, self.lines.noise, uneven))
        found.sigma_mdeg = uncertainty.sigma_mdeg(self.rings, self.lines, uneven)

    def _tell(self):
        """Puts down the pose that is reported of an accepted marker."""
        rings = self.rings
        cosine = cos_q14(self.lines.angle_turn16)
        sine = sin_q14(self.lines.angle_turn16)
        x = cosine + ((rings.e1 * cosine + rings.e2 * sine) >> 14)
        y = sine + ((rings.e2 * cosine - rings.e1 * sine) >> 14)
        self.heading_cdeg = cdeg_from_turn16(-atan2_turn16(y, x))
        self.x_q8 = (rings.x_q10 + 2) >> 2
        self.y_q8 = (rings.y_q10 + 2) >> 2
