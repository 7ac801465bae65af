"""The blur-model reader's model of blur: a gaussian and a straight motion, found from the rings.

The gaussian stands for optics and pixels, the motion for that during the exposure.
A blurred line's profile is the line's width, the motion's component across it and the gaussian folded with
each other: the second difference of the gaussian integrated twice, which is one small table. A line at angle
phi is blurred across exactly as the rings are at phi + 90 degrees, so what fits the rings is what a line must
look like.
"""

from array import array

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith import tables
from larics.arith.fixed import COSINE, table16, words
from larics.kernels import blur as kernels

_RELS = const(17)  # as in kernels.layouts
_BAR = const(24)
_ALONG = const(408)
_STILL = const(32)

_RAMP = table16(tables.RAMP_Q12)
_RINGS_BAR = const(13)  # items that the rings alone need
_UNITS = const(24)  # of length in the outer radius
_SECTORS = const(16)
_FLOOR = const(512)  # of a sector's match, 1/1024: what is covered must not count more
_MOTION_COST = const(96)  # a motion must explain more than that, 1/1024
_STILL_SCORE = const(15600)  # with so good a match nothing moves
# smallest score of what may be rings: before any motion is tried, the first time, and again; 8192 is nothing
_LEAST_STILL = const(8500)
_LEAST_FIRST = const(9100)
_LEAST_AGAIN = const(10000)
_ANY = const(34)  # one of the directions 2, 6, 10, ...
_FARTHEST_MOTION = const(96)  # motion^2 / sigma^2, where sigma fits the rings without any motion

# what is tried, 1/256 unit
SIGMAS = (
    128, 143, 160, 179, 200, 224, 250, 279, 312, 349, 391, 437, 488, 546, 610, 682, 763, 853, 953, 1066,
    1191, 1332,
)  # fmt: skip
MOTIONS = (0, 768, 1024, 1280, 1536, 1792, 2176, 2560, 3072)


class BlurModel:
    """The blur of one candidate.

    sigma, motion   entries of SIGMAS and MOTIONS; still: whether there is no motion
    motion_axis     direction of the motion, 1/32 of half a turn, clockwise from x; 32 when still
    bars            array('H'): profile of a line for each rel, then the one along a line
    templates, sums   of both rings for each rel, as kernels.blur.ring_template writes them
    score           how well they match: sum over 16 sectors of at most 1024 each
    """

    def __init__(self, family, line_mm10, parts):
        """parts: fixed.Parts of words that nobody else looks at from `forget` on."""
        outer = family.outer_mm10
        self._line = line_mm10 * _UNITS * 256 // outer
        self.bars = words(_ALONG + _BAR, "values", "H")
        for k in range(len(self.bars)):
            self.bars[k] = 0
        self.templates = parts.of16(48 * _RELS)
        self.sums = parts.of32(8 * _RELS)
        self._folds = parts.of16(10 * _SECTORS)
        self._powers = array("i", bytes(4 * _SECTORS))
        self._matches = parts.of16(_SECTORS * _RELS)
        self._result = array("i", bytes(4))
        self._tried = -1  # whose folded templates are there
        self._prepared = -1  # whose templates without motion are there, unless folded ones are
        self.sigma = self.motion = self._direction = self.score = 0
        self.still = 1
        self.motion_axis = _STILL

    def memory(self):
        """Bytes of the buffers but the scratch space."""
        return 2 * len(self.bars) + 4 * (len(self._powers) + 1)

    def forget(self):
        """What was prepared may be gone."""
        self._tried = self._prepared = -1

    def prepare(self, sigma, motion, first, step, templates=True):
        """Bars, and templates, of the rels first, first + step, ...; of rel 0 alone when nothing moves."""
        if not motion:
            first = 0
            step = _RELS
            if templates and sigma == self._prepared and self._tried < 0:
                return  # they are still there, as for one coarse look after another
        self._prepared = sigma if templates and not motion else -1
        kernels.blurred_bars(
            0, 0, _RAMP, self._line, MOTIONS[motion], SIGMAS[sigma], COSINE, first, step, _BAR, first * _BAR,
            self.bars,
        )  # fmt: skip
        if templates:
            kernels.ring_templates(self.bars, 0, 0, first, step, self.templates, self.sums)
        self._tried = -1

    def search(self, means, again):
        """Finds the blur that explains 32 sectors' samples best: `means` as from kernels.polar.mean_samples.

        again: begin with what was found before. Leaves the templates of all 32 sectors' rels prepared, unless
        nothing explains them: then it returns False."""
        kernels.fold_sectors(0, 0, means, _SECTORS, self._folds, self._powers)
        self.score = 0
        if again:
            self._try(self.sigma, self.motion, self._direction)
        else:
            for sigma in range(0, len(SIGMAS), 4):
                if not self._try(sigma, 0, 0) and self.score > _FLOOR * _SECTORS:
                    break
            if self.score < _LEAST_STILL:
                self.still = 1
                self.motion_axis = _STILL
                return False
            if self.score < _STILL_SCORE:
                farthest = _FARTHEST_MOTION * SIGMAS[self.sigma] * SIGMAS[self.sigma]
                for motion in range(1, len(MOTIONS), 2):
                    if MOTIONS[motion] * MOTIONS[motion] > farthest:
                        break
                    self._try(4, motion, _ANY)
            self._try_motions()
        self._try_both(2, 0, 0)
        self._try_both(1, 0, 0)
        self._try_motions()
        self.still = 0 if self.motion else 1
        self.motion_axis = self._direction if self.motion else _STILL
        if self.score < (_LEAST_AGAIN if again else _LEAST_FIRST):
            return False
        self.prepare(self.sigma, self.motion, 1, 2)
        return True

    def is_faint(self, power):
        """Whether most sectors that `search` saw have a smaller sum of squares (1/16 grey level)."""
        count = 0
        for sector in range(_SECTORS):
            if self._powers[sector] < power:
                count += 1
        return 2 * count > _SECTORS

    def _try_motions(self):
        """Tries shorter, longer and otherwise directed motions, if there is one."""
        if self.motion:
            self._try_both(0, 1, 0)
            self._try_both(0, 0, 2)

    def _try_both(self, sigma, motion, direction):
        """Tries what differs by these steps from the best so far, to one side and else to the other."""
        if not self._try(self.sigma - sigma, self.motion - motion, self._direction - direction & 31):
            self._try(self.sigma + sigma, self.motion + motion, self._direction + direction & 31)

    def _try(self, sigma, motion, direction):
        """Tries a blur, in one even direction or in _ANY, and keeps it when it is better; whether it is."""
        if sigma < 0 or sigma >= len(SIGMAS) or motion < 0 or motion >= len(MOTIONS):
            return False
        templates = self.templates
        sums = self.sums
        first = 0
        step = _RELS
        if motion:
            first = 2 - direction & 3
            step = 4
        tried = (sigma << 4 | motion) << 2 | first
        if tried != self._tried:
            self._tried = tried
            kernels.blurred_bars(
                0, 0, _RAMP, self._line, MOTIONS[motion], SIGMAS[sigma], COSINE, first, step, _RINGS_BAR,
                first * _BAR, self.bars,
            )  # fmt: skip
            kernels.fold_templates(self.bars, 0, 0, first, step, templates, sums)
        if direction == _ANY:
            kernels.match_sectors(
                0, 0, self._folds, templates, _SECTORS, self._powers, sums, 0, 4, self._matches
            )  # fmt: skip
            score = kernels.best_direction(0, 0, self._matches, _SECTORS, 4, 2, _FLOOR, 2, 4, self._result)
            direction = self._result[0]
        else:
            score = kernels.match_direction(
                self._folds, 0, 0, templates, _SECTORS, self._powers, sums, 4, 2,
                direction if motion else _STILL, _FLOOR,
            )  # fmt: skip
        if motion:
            score -= _MOTION_COST
        if score <= self.score:
            return False
        self.score = score
        self.sigma = sigma
        self.motion = motion
        self._direction = direction
        return True

    def rel(self, angle_turn16):
        """The rel of a direction."""
        if self.still:
            return 0
        rel = ((angle_turn16 >> 7) - (self._direction << 3) + 4) >> 3 & 31
        return 32 - rel if rel > 16 else rel

    def across(self, rel):
        """The entry of the bar across a line in a direction of this rel."""
        return 0 if self.still else (16 - rel) * _BAR

    def reach(self):
        """How far from its middle a line is dark at most, 1/256 unit."""
        return min(5887, ((self._line + MOTIONS[self.motion]) >> 1) + 3 * SIGMAS[self.sigma])

    def put_along(self, length, rel):
        """Writes the bar along a line of that length (1/256 unit), at ALONG."""
        kernels.blurred_bars(
            0, 0, _RAMP, length, MOTIONS[self.motion], SIGMAS[self.sigma], COSINE, rel, _RELS, _BAR, _ALONG,
            self.bars,
        )  # fmt: skip
