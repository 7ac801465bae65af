"""Which candidates the blur-model reader looks at, in which order, and where it looks no more."""

from larics.blurred.candidates import LOOKED, SCORE, Candidates
from larics.blurred.places import READ, REJECTED, UNKNOWN, Places
from larics.kernels.layouts import BIAS, CANDIDATE_ITEMS
from larics.marker import verdicts


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
        taken = candidates.best(None, Scores((9500,)), False)
        assert candidates.postpone_others(taken, verdict, False) != left
        assert bool(candidates.items[CANDIDATE_ITEMS + LOOKED]) != left, (x, verdict, kind)
        # unless there is no time for views, but always for what was read
        assert candidates.postpone_others(taken, verdict, True) == (left and kind != READ)


def test_a_budget_ends_looks_without_a_candidate_where_the_radius_is_not_known():
    for several, budget, looks in ((True, 149, 2), (True, 200, 3), (False, -10000, 4)):
        candidates = Candidates(several)
        for index in range(4):
            candidates.remember(index << 14, 0, 5000, 9000, verdicts.NO_FIT, 9 - index, True)
        rings = Scores((0, 0, 0, 0))
        # of 450 each, and up to 700 more than once there is one
        assert candidates.best(None, rings, False, budget) == -1
        assert 4 - len(rings.scores) == looks and candidates.is_cut == (looks < 4), (several, budget)
        candidates.note_looked()  # they give way to the others
        candidates.recognize()
        kinds = [candidates.items[index * CANDIDATE_ITEMS + 13] for index in range(4)]
        assert kinds == [REJECTED] * looks + [UNKNOWN] * (4 - looks)
