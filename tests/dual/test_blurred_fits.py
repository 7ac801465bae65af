"""How often the blur-model reader fits rings, where fits begin, and what it spends on them."""

from larics.arith.fixed import Parts
from larics.blurred.candidates import RADIUS_Q8
from larics.blurred.reader import NO_BUDGET, BlurModelReader
from larics.blurred.ring_fit import LOST_FOR_GOOD, LOST_IN_NOISE, LOST_ON_THE_WAY, BlurredRings
from larics.detect.detector import Detector
from larics.detect.scales import cut
from larics.marker import LARICS3, verdicts


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


def blur_model_reader(least_px=25):
    """For frames of 136 x 128 and rings from so many to 35 px."""
    return BlurModelReader(136, 128, LARICS3, 175, bytearray(512), 16, None, cut(least_px, 35))


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

    is_cut = False

    def __init__(self, items, clear=False, several=False):
        self.items = items
        self.clear, self.several = clear, several
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

    def postpone_others(self, taken, verdict, views):
        self.postponed = True
        self.views = views
        return True

    def note(self, *arguments):
        pass

    dismiss_ghosts = dismiss_judged = note

    def was_read(self, slot):
        return self.asked > 1


class FirstLook:
    """Lines that are found at once."""

    depth, noise, rival = 256, 0, 0
    residual, residuals = 230, [320] * 8

    def find_orientation(self, *arguments):
        return True

    refine_orientation = read_code = measure_residual = find_orientation


class Prepared:
    def prepare(self):
        pass


def test_radii_in_the_range_of_any_scale_are_in_range():
    reader = blur_model_reader(16)
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
    reader = blur_model_reader()
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
    # or what was taken for the orientation line is none
    reader.lines.residual = 231
    assert reader._examine_lines(None) == verdicts.NO_ORIENTATION and len(rings.turns) == 6


def fits(lost, sparing=False, few_fits=False, recognizes=False, clear=False):
    """How many candidates and fits it takes when each fit is lost like this."""
    reader = blur_model_reader()
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
        reader = blur_model_reader()
        reader.candidates.remember(80, 60, least_q8, 9000, verdicts.NO_FIT, 0, False)
        reader.candidates.items[RADIUS_Q8] = 7000
        reader.rings = rings = Starts(faint)
        reader.blur.still, reader._fits_left = still, 4
        assert reader._examine_candidate(None, 0) == verdicts.NO_FIT
        assert len(rings.poses) == 3 and rings.poses[2][:2] == expected, (least_q8, faint, still)
        assert rings.poses[2][2] == (7000 if expected == (320, 240) else 0)


def budgeted(budget, clear=True, several=False):
    """How many candidates and fits it takes within a budget of thousands of instructions; the reader."""
    reader = blur_model_reader()
    reader.candidates = candidates = Endless(reader.candidates.items, clear, several)
    reader.rings = rings = NoFit((LOST_ON_THE_WAY,))
    reader.examine(None, False, False, budget)
    return candidates.asked, len(rings.turns), reader


def test_a_budget_leaves_fits_and_candidates_to_the_next_frame():
    for budget, clear, asked, count in (
        (4550, True, 2, 4),
        (4549, True, 1, 3),  # 1800 are more than 4549 less the 450 and 2300 of another one
        (3500, True, 1, 3),
        (3499, True, 1, 2),  # no third fit
        (1900, True, 1, 2),
        (1899, True, 1, 1),  # nor a second
        (1600, False, 1, 3),  # in a faint frame the first often fails
        (1599, False, 1, 2),
        (1000, False, 1, 2),
        (999, False, 1, 1),
    ):
        assert budgeted(budget, clear)[:2] == (asked, count), (budget, clear)
    # where the radius is not known a frame takes more before
    for budget, count in ((2350, 3), (2349, 2), (1750, 2), (1749, 1)):
        assert budgeted(budget, False, True)[1] == count, budget
    for several, budget, views in (
        (False, 4100, False),
        (False, 4099, True),
        (True, 2800, False),
        (True, 2799, True),
    ):
        assert budgeted(budget, True, several)[2].candidates.views == views, (several, budget)
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


class Held:
    """Rings that hold and look like a marker's in so many sectors, but are none."""

    def __init__(self, good):
        self.good = good
        self.lost = LOST_ON_THE_WAY
        self.ratio_q10, self.deviation_q10, self.radius_q8 = 900, 0, 256
        self.match, self.amplitude = 1024, 999

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
        reader = blur_model_reader()
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
        reader = blur_model_reader()
        reader.rings = NoFit()
        reader.lines = FirstLook()
        reader.lines.rival = rival
        reader.blur.still = still
        assert reader._examine_lines(None) == verdict


class Moving(FirstLook):
    """No line in either light."""

    def __init__(self):
        self.asked = 0

    def prepare(self):
        pass

    def find_orientation(self, *arguments):
        self.asked += 1
        return False


def test_the_light_on_moving_rings_is_measured_again_within_the_budget():
    for several, budget, lights in ((True, -100, 2), (True, -101, 1), (False, 600, 2), (False, 599, 1)):
        reader = blur_model_reader()
        reader.candidates.several = several
        reader.candidates.remember(0, 0, 5000, 9000, verdicts.NO_FIT, 0, True)
        reader._fit_rings = lambda *pose: True
        reader.lines, reader.blur.still = Moving(), 0
        reader.rings.radius_q8 = 7000
        reader.rings.measure_light = lambda local: None
        reader._effort_most, reader._is_cut = budget - 2300, False
        reader.rings.effort = 0
        # the search for a line counts 500
        assert reader._examine_candidate(None, 0) == verdicts.NO_ORIENTATION
        assert reader.lines.asked == lights and reader._is_cut == (lights == 1), (several, budget)


def test_what_there_was_no_time_for_is_not_noted_as_rejected():
    for is_cut in (True, False):
        reader = blur_model_reader()
        reader.candidates = candidates = Endless(reader.candidates.items)
        noted = []
        candidates.note = lambda *arguments, noted=noted: noted.append(arguments)

        def examine(frame, slot, reader=reader, is_cut=is_cut):
            reader._is_cut = is_cut
            return verdicts.NO_ORIENTATION

        reader._examine_candidate = examine
        reader.examine(None, True)
        assert len(noted) == (not is_cut)
