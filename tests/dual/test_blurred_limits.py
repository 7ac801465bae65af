"""Limits of the blur-model reader beside its acceptance: which candidates it looks at, how often it fits."""

from larics.arith.fixed import Parts, cos_q14
from larics.blurred import uncertainty
from larics.blurred.candidates import LOOKED, RADIUS_Q8, SCORE, Candidates
from larics.blurred.places import READ, REJECTED, UNKNOWN, Places
from larics.blurred.reader import NO_BUDGET, BlurModelReader
from larics.blurred.ring_fit import LOST_FOR_GOOD, LOST_IN_NOISE, LOST_ON_THE_WAY, BlurredRings
from larics.detect.detector import Detector
from larics.detect.scales import cut
from larics.kernels.layouts import BIAS, CANDIDATE_ITEMS
from larics.marker import LARICS3, verdicts


class Scores:
    """Stands for rings: a coarse look at the candidates gives these scores, if they reach the least."""

    def __init__(self, scores, shade=100, dark_around=0):
        self.scores = list(scores)
        self.shade = shade
        self.dark_around = dark_around
        self.effort = 0
        self.x_q10 = self.y_q10 = self.e1 = self.e2 = 0
        self.radius_q8 = 6000

    def coarse(self, *arguments):
        self.effort += 450
        score = self.scores.pop(0)
        return score if score >= arguments[-1] else 0

    def line_shade(self, frame):
        return self.shade


def looked_at(
    scores,
    least_q8=5000,
    clear=False,
    shade=100,
    said=verdicts.NO_FIT,
    dark_around=0,
    several=False,
    passes_over=False,
):
    """The candidate that is chosen of those with these scores, -1 for none, and how many were looked at."""
    candidates = Candidates(several)
    for index in range(len(scores)):
        candidates.remember(index << 14, 0, least_q8, 9000, said, 100 - index, clear)
    rings = Scores(scores, shade, dark_around)
    slot = candidates.best(None, rings, passes_over)
    return slot // CANDIDATE_ITEMS if slot >= 0 else slot, len(scores) - len(rings.scores)


def test_scores_of_candidates():
    assert looked_at((5199, 5200)) == (1, 2)
    assert looked_at((7199, 7200), clear=True) == (1, 2)
    assert looked_at((4299, 4300), 2303) == looked_at((4299, 4300), 2303, True) == (1, 2)
    assert looked_at((4300, 5200), 2304) == (1, 2)
    assert looked_at((8999, 9500)) == (1, 2)
    assert looked_at((9000, 9500)) == (0, 1)  # good enough
    for score, least_q8, clear in ((5199, 2304, False), (7199, 2304, True), (4299, 2303, False)):
        assert looked_at((score,), least_q8, clear) == (-1, 1), score
        assert looked_at((score + 1,), least_q8, clear) == (0, 1), score


def test_where_several_scales_are_searched_more_is_good_enough():
    assert looked_at((11499, 12000), several=True) == (1, 2)
    assert looked_at((11500, 12000), several=True) == (0, 1)
    assert looked_at((8999, 9500), several=True, passes_over=True) == (1, 2)
    assert looked_at((9000, 9500), several=True, passes_over=True) == (0, 1)


def test_rings_without_a_line_are_none():
    for shade, least_q8, found in (
        (35, 5000, -1),
        (36, 5000, 0),
        (2000, 3072, 0),
        (2001, 3072, -1),
        (2001, 3071, 0),
    ):
        assert looked_at((9000,), least_q8, shade=shade)[0] == found, (shade, least_q8)


def test_rings_that_defocus_has_molten_into_one():
    for score, shade, dark_around, found in (
        (5999, 100, 64, -1),
        (6000, 100, 64, 0),
        (6000, 100, 54, 0),
        (7199, 100, 53, -1),
        (7200, 8191, 53, -1),
        (7200, 8191, 54, 0),
        (7200, 35, 64, -1),
    ):
        seen = looked_at((score,), 5000, True, shade, dark_around=dark_around)
        assert seen == (found, 1), (score, shade, dark_around)
    assert looked_at((5200,), shade=8191, dark_around=54)[0] == 0
    assert looked_at((5200,), shade=8191, dark_around=53)[0] == -1


def test_what_was_seen_well_is_not_looked_at_again():
    assert looked_at((9000,), said=verdicts.NO_CODE) == (-1, 0)


def dismissed(x, y, least_q8, clear):
    """Whether a candidate counts as a view of the one taken before, at the same place in its own range."""
    candidates = Candidates()
    candidates.remember(0, 0, 5000, 9000, verdicts.NO_FIT, 2, clear)
    candidates.remember(x, y, least_q8, 9000, verdicts.NO_FIT, 1, clear)
    slot = candidates.best(None, Scores((9000,)), False)
    candidates.dismiss_ghosts(slot)
    return bool(candidates.items[CANDIDATE_ITEMS + LOOKED])


def test_views_from_beside_are_dismissed_where_there_is_contrast():
    assert dismissed(4999, -4999, 5000, True)
    assert not dismissed(4999, -4999, 5000, False)  # noise may show the better view second
    assert not dismissed(5000, 0, 5000, True)
    assert not dismissed(4999, 0, 5001, True)  # other rings


def test_rings_that_were_judged_are_dismissed_at_other_scales():
    for x, radius_q8, left in ((1499, 6700, 0), (1500, 6700, 9000), (0, 5250, 9000), (0, 6749, 0)):
        candidates = Candidates()
        candidates.remember(0, 0, 4000, 6000, verdicts.NO_FIT, 2, False)
        candidates.remember(x, 0, 6000, 9000, verdicts.NO_FIT, 1, False)
        slot = candidates.best(None, Scores((8000, 7000)), False)
        candidates.items[CANDIDATE_ITEMS + SCORE] = 9000
        candidates.items[CANDIDATE_ITEMS + 10] = radius_q8
        candidates.dismiss_judged(slot, 6000)
        assert candidates.items[CANDIDATE_ITEMS + SCORE] == left, (x, radius_q8)


def test_places_are_remembered_for_a_while():
    places = Places()
    places.note(1000, 2000, 500, READ)
    places.note(5000, 2000, 500, REJECTED)
    assert not places.are_noted  # in an earlier frame
    for age in range(1, 7):
        places.begin()
        assert places.kind(1499, 1501) == (READ if age < 2 else UNKNOWN)
        assert places.kind(1500, 2000) == UNKNOWN
        assert places.kind(5030, 1970) == (REJECTED if age < 5 else UNKNOWN)
        assert places.kind(5031, 2000) == places.kind(5000, 1969) == UNKNOWN  # it has moved
        assert places.are_noted == (age < 5)
    for index in range(5):
        places.note(index << 12, 0, 500, READ)
        places.begin()
        places.note(index << 12, 0, 500, REJECTED)
    assert [places.kind(index << 12, 0) for index in range(5)] == [UNKNOWN] + 4 * [REJECTED]


def in_turns(kind, scores, passes_over=False):
    """Which of two candidates is chosen when the first one's place was noted with this kind."""
    candidates = Candidates()
    candidates.places.note(BIAS, BIAS, 5000, kind)
    for x, votes in ((0, 9), (20000, 8)):
        candidates.remember(x, 0, 5000, 9000, verdicts.NO_FIT, votes, False)
    read = candidates.recognize()
    assert read == (kind == READ)
    return candidates.best(None, Scores(scores), passes_over) // CANDIDATE_ITEMS


def test_several_are_read_in_turns():
    assert in_turns(READ, (9500, 6000)) == 1
    assert in_turns(READ, (9500, 5000)) == 0  # there is no other
    assert in_turns(REJECTED, (9500, 6000)) == 0
    assert in_turns(REJECTED, (6000,), True) == 1


class Blur:
    """Stands for a blur model whose search ends with this score, in a frame that is faint or not."""

    sigma = motion = 0
    still = 1
    motion_axis = 32

    def __init__(self, score, faint):
        self.score = score
        self.faint = faint

    def search(self, means, again):
        return False

    def is_faint(self, power):
        return power == 60000 and self.faint


def test_how_a_fit_is_lost():
    for score, faint, lost in (
        (8599, False, LOST_FOR_GOOD),
        (8599, True, LOST_IN_NOISE),
        (8600, False, LOST_ON_THE_WAY),
    ):
        rings = BlurredRings(136, 128, Blur(score, faint), Parts())
        rings.start(68 << 10, 64 << 10, 20 << 8, 0, 0)
        assert not rings.fit(bytearray(136 * 128), 3, None)
        assert rings.lost == lost


class NoFit:
    """Stands for rings that never hold."""

    def __init__(self, lost=(LOST_ON_THE_WAY,)):
        self.turns = []
        self.effort = 0
        self.losses = list(lost)
        self.lost = LOST_ON_THE_WAY
        self.x_q10 = self.y_q10 = self.radius_q8 = self.e1 = self.e2 = 0

    def start(self, *pose):
        pass

    def coarse(self, *arguments):
        return 1

    def fit(self, frame, turns, lines):
        self.turns.append(turns)
        self.effort += 600
        self.lost = self.losses.pop(0) if len(self.losses) > 1 else self.losses[0]
        return False


class Endless:
    """Candidates without an end."""

    def __init__(self, items, clear=False):
        self.items = items
        self.clear = clear
        self.asked = 0
        self.passed_over = []
        self.postponed = False

    def best(self, frame, rings, passes_over, effort_most):
        self.passed_over.append(passes_over)
        self.effort_most = effort_most
        if self.postponed:
            return -1
        self.asked += 1
        return 0

    def postpone_others(self, taken, verdict):
        self.postponed = True
        return True

    def note(self, *arguments):
        pass

    dismiss_ghosts = dismiss_judged = note

    def was_read(self, slot):
        return self.asked > 1


class FirstLook:
    """Lines that are found at once."""

    depth, noise, rival = 256, 0, 0
    residuals = [320] * 8

    def find_orientation(self, *arguments):
        return True

    refine_orientation = read_code = find_orientation


class Prepared:
    def prepare(self):
        pass


def test_radii_in_the_range_of_any_scale_are_in_range():
    reader = BlurModelReader(136, 128, LARICS3, 175, bytearray(512), 16, None, cut(16, 35))
    reader._fit_rings = lambda *pose: True
    reader._examine_lines = lambda frame: verdicts.ACCEPTED
    reader.lines = Prepared()
    reader.candidates.remember(0, 0, 16 << 8, 23 << 8, verdicts.NO_FIT, 0, True)
    for radius_q8, verdict in (
        (3583, verdicts.OUT_OF_RANGE),
        (3584, verdicts.ACCEPTED),
        (10080, verdicts.ACCEPTED),
        (10081, verdicts.OUT_OF_RANGE),
    ):
        reader.rings.radius_q8 = radius_q8
        assert reader._examine_candidate(None, 0) == verdict, radius_q8


def test_how_often_it_fits_and_for_how_many_candidates():
    reader = BlurModelReader(136, 128, LARICS3, 175, bytearray(512), 16, None, cut(25, 35))
    reader.candidates = candidates = Endless(reader.candidates.items)
    reader.rings = rings = NoFit()
    assert reader.examine(None, False) == verdicts.NO_FIT
    assert candidates.asked == 2
    assert rings.turns == [3, 3, 3, 3]  # three ways to begin for the first, one is left for the second
    # once the lines are known, the rings are fitted again without them
    reader.lines = FirstLook()
    assert reader._examine_lines(None) == verdicts.NO_FIT
    assert rings.turns[4:] == [2]
    # unless there is much beside a bit
    for position, verdict in ((2, verdicts.NOT_EMPTY), (3, verdicts.NO_FIT)):
        reader.lines.residuals = [320] * 8
        reader.lines.residuals[position] = 321
        assert reader._examine_lines(None) == verdict


def fits(lost, sparing=False, few_fits=False, recognizes=False, clear=False):
    """How many candidates and fits it takes when each fit is lost like this."""
    reader = BlurModelReader(136, 128, LARICS3, 175, bytearray(512), 16, None, cut(25, 35))
    reader.candidates = candidates = Endless(reader.candidates.items, clear)
    reader.rings = rings = NoFit(lost)
    reader._recognizes = recognizes
    reader.examine(None, sparing, few_fits)
    return candidates.asked, len(rings.turns)


def test_how_often_it_fits_what_is_no_marker():
    assert fits((LOST_FOR_GOOD,)) == (2, 2)
    assert fits((LOST_IN_NOISE,)) == (2, 4)  # two ways to begin for each
    assert fits((LOST_ON_THE_WAY, LOST_FOR_GOOD)) == (2, 3)
    assert fits((LOST_ON_THE_WAY,), sparing=True) == (1, 3)
    assert fits((LOST_ON_THE_WAY,), sparing=True, few_fits=True) == (1, 2)
    assert fits((LOST_ON_THE_WAY,), sparing=True, clear=True) == (1, 2)
    assert fits((LOST_ON_THE_WAY,), clear=True) == fits((LOST_ON_THE_WAY,)) == (2, 4)
    assert fits((LOST_ON_THE_WAY,), recognizes=True) == (2, 5)  # what was read before is not to go short


class Starts(NoFit):
    """Rings that note where fits begin; a coarse look finds them at (2, 2)."""

    def __init__(self, faint):
        super().__init__((LOST_ON_THE_WAY,))
        self.faint = faint
        self.poses = []

    def start(self, *pose):
        self.poses.append(pose)

    def coarse(self, *arguments):
        self.x_q10 = self.y_q10 = 2048
        return 1

    def is_faint(self):
        return self.faint


def test_the_last_fit_begins_where_the_votes_were():
    for least_q8, faint, still, expected in (
        (3072, False, 1, (320, 240)),
        (3072, False, 0, (320, 240)),
        (3071, False, 1, (2048, 2048)),
        (3072, True, 1, (2048, 2048)),
        (3072, True, 0, (0, 0)),  # where the fit of motion led to
    ):
        reader = BlurModelReader(136, 128, LARICS3, 175, bytearray(512), 16, None, cut(25, 35))
        reader.candidates.remember(80, 60, least_q8, 9000, verdicts.NO_FIT, 0, False)
        reader.candidates.items[RADIUS_Q8] = 7000
        reader.rings = rings = Starts(faint)
        reader.blur.still, reader._fits_left = still, 4
        assert reader._examine_candidate(None, 0) == verdicts.NO_FIT
        assert len(rings.poses) == 3 and rings.poses[2][:2] == expected, (least_q8, faint, still)
        assert rings.poses[2][2] == (7000 if expected == (320, 240) else 0)


def budgeted(budget, clear=True):
    """How many candidates and fits it takes within a budget of thousands of instructions; the reader."""
    reader = BlurModelReader(136, 128, LARICS3, 175, bytearray(512), 16, None, cut(25, 35))
    reader.candidates = candidates = Endless(reader.candidates.items, clear)
    reader.rings = rings = NoFit((LOST_ON_THE_WAY,))
    reader.examine(None, False, False, budget)
    return candidates.asked, len(rings.turns), reader


def test_a_budget_leaves_fits_and_candidates_to_the_next_frame():
    for budget, clear, asked, count in (
        (4100, True, 2, 4),
        (4099, True, 1, 3),  # 1800 are more than 4099 less the 2300 of another one
        (3500, True, 1, 3),
        (3499, True, 1, 2),  # no third fit
        (1900, True, 1, 2),
        (1899, True, 1, 1),  # nor a second
        (0, False, 1, 3),  # in a faint frame the first often fails
    ):
        assert budgeted(budget, clear)[:2] == (asked, count), (budget, clear)
    reader = budgeted(0)[2]
    # what was examined gives way to the others in the next frame, and in that alone
    candidates = reader.candidates
    for passes_over in (True, False):
        candidates.postponed = False
        reader.examine(None, False)
        assert candidates.passed_over[-1] == passes_over


def test_a_look_and_a_search_for_a_line_count():
    assert budgeted(4100)[2].candidates.effort_most == 4100 - 2300 - 450
    reader = budgeted(0)[2]
    reader.lines = FirstLook()
    reader.rings.effort = 0
    reader._examine_lines(None)
    assert reader.rings.effort == 500 + 600  # and another fit


def test_more_than_one_scale_is_searched_while_a_candidate_can_be_examined():
    for least, most, effort_most in ((23, 30, NO_BUDGET), (15, 60, 13800 - 3900)):
        finder = Detector(320, 240, least, most)
        assert finder._blurred_search._effort_most == effort_most


def test_a_budget_ends_looks_once_there_is_a_candidate():
    better = (8000, 8500, 9500)
    for scores, effort_most, looks in ((better, 449, 1), (better, 450, 2), ((0, 0, 8000), 0, 3)):
        candidates = Candidates()
        for index in range(3):
            candidates.remember(index << 14, 0, 5000, 9000, verdicts.NO_FIT, 9 - index, True)
        rings = Scores(scores)
        assert candidates.best(None, rings, False, effort_most) == CANDIDATE_ITEMS * (looks - 1)
        assert len(rings.scores) == 3 - looks


def test_what_may_be_another_view_is_not_postponed():
    for x, verdict, kind, left in (
        (5000, verdicts.NO_FIT, UNKNOWN, True),
        (5001, verdicts.NO_FIT, UNKNOWN, False),
        (5000, verdicts.NO_ORIENTATION, UNKNOWN, False),  # these rings were judged
        (5001, verdicts.NO_FIT, READ, True),
    ):
        candidates = Candidates()
        candidates.places.note(BIAS + x, BIAS, 5000, kind)
        candidates.remember(0, 0, 5000, 9000, verdicts.NO_FIT, 9, True)
        candidates.remember(x, 0, 5000, 9000, verdicts.NO_FIT, 8, True)
        candidates.items[CANDIDATE_ITEMS + 13] = kind
        assert candidates.postpone_others(candidates.best(None, Scores((9500,)), False), verdict) != left
        assert bool(candidates.items[CANDIDATE_ITEMS + LOOKED]) != left, (x, verdict, kind)


class Held:
    """Rings that hold and look like a marker's in so many sectors, but are none."""

    def __init__(self, good):
        self.good = good
        self.lost = LOST_ON_THE_WAY
        self.ratio_q10, self.deviation_q10, self.radius_q8, self.match, self.amplitude = (
            900,
            0,
            256,
            1024,
            999,
        )

    def start(self, *pose):
        pass

    def fit(self, *arguments):
        return True


def test_rings_that_hold_and_are_none_are_not_fitted_again():
    for good, radius_q8, still, lost in (
        (14, 5120, 1, LOST_FOR_GOOD),
        (14, 5120, 0, LOST_ON_THE_WAY),
        (13, 5120, 1, LOST_ON_THE_WAY),
        (14, 5119, 1, LOST_ON_THE_WAY),
    ):
        reader = BlurModelReader(136, 128, LARICS3, 175, bytearray(512), 16, None, cut(25, 35))
        reader._fits_left = 1
        reader.rings = Held(good)
        reader.rings.blur = reader.blur
        reader.blur.still = still
        assert not reader._fit_rings(None, 0, 0, radius_q8, 0, 0)
        assert reader.rings.lost == lost


def test_of_two_lines_in_a_still_picture_none_is_measured_further():
    for rival, still, verdict in (
        (187, 1, verdicts.TWO_ORIENTATIONS),
        (186, 1, verdicts.NO_FIT),
        (187, 0, verdicts.NO_FIT),
    ):
        reader = BlurModelReader(136, 128, LARICS3, 175, bytearray(512), 16, None, cut(25, 35))
        reader.rings = NoFit()
        reader.lines = FirstLook()
        reader.lines.rival = rival
        reader.blur.still = still
        assert reader._examine_lines(None) == verdict


class Fitted:
    """Rings of 30 px and lines as a fit left them; one side of the rings is so much paler, or lighter."""

    def __init__(self, paler_q10=0, lighter_q10=0, still=1, sigma=5, deviation_q10=0, noise=0, residual=0):
        self.blur = self
        self.still = still
        self.sigma = sigma
        self.radius_q8 = 7680
        self.deviation_q10 = deviation_q10
        self.used_outer = self.used_inner = 32
        self.noise = noise
        self.residual = residual
        self.levels = []
        for uneven_q10 in (paler_q10, lighter_q10):
            for sector in range(32):
                self.levels.append(2000 + (2 * 2000 * uneven_q10 * cos_q14(2048 * sector + 300) >> 24))

    def heading(self):
        return uncertainty.sigma_mdeg(self, self, uncertainty.uneven_square(self))

    def variance(self):
        return uncertainty.centre_variance(self, self.noise, uncertainty.uneven_square(self))


def assert_heading(fitted, shift_q10):
    """100/1024 px turn a radius of 30 px by 0.187 degrees; 0.045 degrees at least."""
    turned = shift_q10 * 187 // 100
    expected = uncertainty.isqrt(45 * 45 + turned * turned)
    assert abs(fitted.heading() - expected) <= 1 + expected // 25, (shift_q10, fitted.heading(), expected)


def test_rings_that_look_paler_on_one_side_are_less_sure():
    for paler_q10, lighter_q10, still, expected in (
        (0, 0, 1, 0),
        (20, 10, 1, 0),
        (60, 0, 1, 40),
        (0, 60, 1, 100),  # 50 doubled
        (60, 60, 1, 108),
        (60, 60, 0, 0),  # motion blurs each direction differently
    ):
        fitted = Fitted(paler_q10, lighter_q10, still)
        assert abs(uncertainty.uneven_square(fitted) - expected * expected) <= 6 * expected + 1, expected
        assert fitted.variance() == uncertainty.uneven_square(fitted)
        assert_heading(fitted, expected)


def test_a_line_sharper_than_directions_are_apart_is_less_sure():
    for sigma, noise, deviation_q10, expected in (
        (2, 64, 100, 109),  # 0.1 degrees for 0.1 px, and 0.045
        (1, 64, 100, 282),  # twice as much, and 0.2
        (1, 65, 100, 109),
        (1, 64, 0, 200),
    ):
        found = Fitted(sigma=sigma, noise=noise, deviation_q10=deviation_q10).heading()
        assert abs(found - expected) <= 1, (sigma, noise, deviation_q10, found)
    assert_heading(Fitted(residual=125), 100)  # four fifths of what is no line
    fitted = Fitted(sigma=15)  # defocus: half of what it shifts the centre
    shift_q10 = uncertainty.isqrt(fitted.variance())
    assert shift_q10 > 60
    assert_heading(fitted, shift_q10 // 2)


def test_deviation_counts_as_noise_where_there_is_noise():
    for noise, expected in ((12, 4800), (28, 2400), (44, 0)):  # hundredths of 100, and what evens out
        known = expected // 100
        assert Fitted(noise=noise, deviation_q10=100).variance() == 468 + known * known, noise
