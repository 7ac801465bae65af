"""Limits of the search for a blur and of a step of the rings' fit, on scores and shifts made up at each."""

from array import array

from larics.arith.fixed import Parts
from larics.blurred import blur_model, ring_fit
from larics.blurred.blur_model import BlurModel
from larics.blurred.ring_fit import LOST_FOR_GOOD, LOST_ON_THE_WAY, BlurredRings
from larics.marker import LARICS3

ZERO = 1 << 20


class Told(BlurModel):
    """A blur model whose first blur has this score; no other is better."""

    def __init__(self, score, sigma=0):
        super().__init__(LARICS3, 175, Parts())
        self.told, self.fits = score, sigma
        self.tried = []

    def _try(self, sigma, motion, direction):
        self.tried.append((sigma, motion))
        if len(self.tried) > 1:
            return False
        self.score, self.sigma = self.told, self.fits
        return True

    def prepare(self, *arguments):
        pass


def searched(score, again=False, sigma=0):
    """Whether a search succeeds, and what it tried."""
    blur = Told(score, sigma)
    return blur.search(array("H", bytes(2 * 544)), again), blur.tried


def motions(score, sigma=0):
    """The motions that are tried in all directions."""
    return [motion for _, motion in searched(score, False, sigma)[1] if motion]


def test_scores_that_a_search_needs():
    assert len(searched(8499)[1]) == 2  # nothing is tried beside what is still
    assert len(searched(8500)[1]) > 2
    for score, again, found in (
        (9099, False, False),
        (9100, False, True),
        (9999, True, False),
        (10000, True, True),
    ):
        assert searched(score, again)[0] == found, (score, again)
    # sharper rings are not tried in vain once there is more than nothing
    assert [len(searched(score)[1]) for score in (8192, 8193)] == [6, 2]


def test_which_motions_are_tried():
    assert motions(15599, 21) == [1, 3, 5, 7]
    assert motions(15600, 21) == []
    # 768, 1280, 1792 and 2560; at most the root of 96, 9.8 times the blur that fits without motion
    for sigma, expected in ((0, [1]), (1, [1, 3]), (2, [1, 3]), (3, [1, 3]), (4, [1, 3, 5]), (6, [1, 3, 5])):
        assert motions(9000, sigma) == expected, sigma


class Matches:
    """Stands for the kernels of a blur model: everything matches so well."""

    def __init__(self, score):
        self.score = score

    def blurred_bars(self, *arguments):
        pass

    fold_templates = blurred_bars

    def match_direction(self, *arguments):
        return self.score


def test_what_a_motion_must_explain():
    kept = blur_model.kernels
    try:
        for motion, score, is_better in ((0, 9000, 0), (0, 9001, 1), (1, 9096, 0), (1, 9097, 1)):
            blur = BlurModel(LARICS3, 175, Parts())
            blur.score = 9000
            blur_model.kernels = Matches(score)
            assert blur._try(4, motion, 8) == is_better, (motion, score)
    finally:
        blur_model.kernels = kept


class Shifts:
    """Stands for the kernels of a step: so many sectors look like rings, which are shifted like this."""

    def __init__(self, good=32, used=(32, 32), outer=(0, 0, 0, 0, 0), inner=(0, 0, 0, 0, 0)):
        self.good = good
        self.rings = [(used[0], outer), (used[1], inner)]

    def ring_shifts(self, *arguments):
        return self.good

    def shift_harmonics(self, a, b, shifts, circle, count, floor, result):
        assert floor == 96
        used, shift = self.rings.pop(0)
        for index in range(5):
            result[index] = ZERO + shift[index]
        result[5] = 0
        return used


def rings_of(kind=BlurredRings):
    return kind(136, 128, BlurModel(LARICS3, 175, Parts()), Parts())


def stepped(shifts, radius_q8=7680, perspective=False, hx=0):
    """Whether the step is believed, and how else it was lost."""
    rings = rings_of()
    rings.start(68 << 10, 64 << 10, radius_q8, 0, 0)
    rings.hx = hx
    kept = ring_fit.sector_kernels
    ring_fit.sector_kernels = shifts
    try:
        return rings._step(2048, 450, perspective), rings.lost
    finally:
        ring_fit.sector_kernels = kept


HELD, ASTRAY, NO_RINGS = (True, LOST_ON_THE_WAY), (False, LOST_ON_THE_WAY), (False, LOST_FOR_GOOD)


def test_sectors_that_a_step_needs():
    for good, used, expected in (
        (16, (32, 32), HELD),
        (15, (32, 32), ASTRAY),
        (32, (12, 12), HELD),
        (32, (11, 32), ASTRAY),
        (32, (32, 11), ASTRAY),
    ):
        assert stepped(Shifts(good, used)) == expected, (good, used)


def test_shapes_and_places_that_a_step_may_lead_to():
    for inner, expected in ((-920, HELD), (-921, NO_RINGS), (969, HELD), (970, NO_RINGS)):
        # beside radii of 20480 and 30720, 1/1024 px: a ratio of 651/1024 is too small, of 715 too large
        assert stepped(Shifts(inner=(inner, 0, 0, 0, 0))) == expected, inner
    for radius_q8, expected in ((1024, HELD), (1023, ASTRAY), (24000, HELD), (24001, ASTRAY)):
        assert stepped(Shifts(), radius_q8) == expected, radius_q8
    for shift, expected in ((13128, HELD), (13129, ASTRAY), (-13125, HELD), (-13126, ASTRAY)):
        assert stepped(Shifts(outer=(0, 0, 0, shift, 0))) == expected, shift  # 3500/16384 of ellipse
        assert stepped(Shifts(outer=(0, 0, 0, 0, shift))) == expected, shift
    for hx, expected in ((3501, HELD), (3502, ASTRAY)):
        assert stepped(Shifts(), hx=hx) == expected, hx
    for apart, expected in ((10000, HELD), (10001, ASTRAY), (-10000, HELD), (-10001, ASTRAY)):
        assert stepped(Shifts(outer=(0, apart, 0, 0, 0)), 24000, True) == expected, apart
        assert stepped(Shifts(outer=(0, 0, apart, 0, 0)), 24000, True) == expected, apart


def test_how_much_of_the_distance_of_the_centres_is_believed():
    rings = rings_of()
    rings.radius_q8 = 7680
    assert rings._perspective_weight(0, 0, 0, 0) == 255
    assert rings._perspective_weight(0, 0, 128, 128) == 161  # a thirtieth of the radius against the noise


class Steps(BlurredRings):
    """Rings whose steps are noted."""

    def sample(self, *arguments):
        return True

    def _step(self, *arguments):
        self.steps.append(arguments)
        return True


class Found:
    def __init__(self, still=True):
        self.still = still

    def search(self, means, again):
        return True


def test_what_the_steps_ask_of_sectors():
    rings = rings_of(Steps)
    rings.steps, rings.blur = [], Found()
    assert rings.fit(None, 3, None)
    assert rings.steps == [(3072, 300, False), (2048, 450, True), (1536, 450, True)]
    assert rings.effort == 3 * 600
    rings.blur, rings.effort = Found(still=False), 0
    assert rings.fit(None, 3, None)
    assert rings.effort == 3 * 600 + 2 * 300  # motion is searched for in the first two


class Looks(Shifts):
    """Stands for the kernels of a coarse look that sees so many of 16 sectors, shifted like this."""

    def __init__(self, used, outer=(0, 0, 0, 0, 0)):
        self.used, self.outer = used, outer

    def circle_samples(self, *arguments):
        pass

    def sector_radii(self, *arguments):
        assert arguments[7] == 150
        return 16384

    def shift_harmonics(self, a, b, shifts, circle, count, farthest, result):
        for index in range(5):
            result[index] = ZERO + self.outer[index]
        return self.used


class Prepared(Found):
    """Stands for a blur model: what it prepares is noted."""

    templates = sums = None

    def prepare(self, sigma, *arguments):
        self.sigma = sigma


def looked(looks, radius_q8=5000, least=0):
    """The rings after a coarse look at a radius, and its score, which has to be so much."""
    rings = rings_of()
    rings.blur = Prepared()
    kept = ring_fit.kernels, ring_fit.sector_kernels
    ring_fit.kernels = ring_fit.sector_kernels = looks
    try:
        return rings, rings.coarse(None, 68 << 8, 64 << 8, radius_q8, radius_q8, least)
    finally:
        ring_fit.kernels, ring_fit.sector_kernels = kept


def test_a_coarse_look():
    rings, score = looked(Looks(6))
    assert score == 16384 and rings.effort == 900 // 8 + 900 // 8 + 900 // 4
    assert looked(Looks(5))[1] == 0  # too few sectors agree
    for radius_q8, sigma in ((2999, 12), (3000, 10)):
        assert looked(Looks(16), radius_q8)[0].blur.sigma == sigma, radius_q8


class Agrees(Looks):
    """... in which so much of the greatest score has been reached after each look."""

    def __init__(self, *scores):
        super().__init__(16)
        self.scores = list(scores)

    def sector_radii(self, *arguments):
        return self.scores.pop(0)


def test_a_coarse_look_ends_when_its_directions_do_not_agree():
    for scores, efforts, told in (
        ((1500, 3500, 8000), (8, 8, 4), 8000),  # 12, 28 and all of 64ths of what is to be reached
        ((1499, 3500, 8000), (8,), 0),
        ((1500, 3499, 8000), (8, 8), 0),
        ((1500, 3500, 7999), (8, 8, 4), 0),
    ):
        rings, score = looked(Agrees(*scores), least=8000)
        assert (score, rings.effort) == (told, sum([900 // hop for hop in efforts])), scores


def light(match, others=()):
    """The rings after their light was measured, which match so well everywhere but in other sectors.

    It is 1000 in all of them but in sector 5, and so much more behind it."""
    rings = rings_of()
    rings.amplitude, rings.background = 400, 2000
    for sector in range(32):
        rings._sectors[sector] = 400
        rings._sectors[32 + sector] = 1000 + (900 if sector == 5 else 0)
        rings._sectors[64 + sector] = 0 if sector in others else match
    rings.measure_light(1)
    return rings


def test_which_sectors_tell_of_light_and_how_far():
    assert light(640).good == 32 and light(639).good == 0
    levels = light(640).levels[32:]
    assert list(levels) == [1000] + 9 * [1100] + 22 * [1000]  # four to either side, and itself
    levels = light(640, (1, 2, 3, 4)).levels[32:]
    assert levels[5] == 1000 + 900 // 5  # five of nine will do
    assert light(640, (1, 2, 3, 4, 6)).levels[32 + 5] == 2000
    assert list(light(639).levels) == 32 * [400] + 32 * [2000]
