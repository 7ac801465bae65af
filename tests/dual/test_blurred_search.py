"""The search for blurred edges: what it lists, when, and for which scales."""

from larics.detect.blurred_search import BlurredSearch, least_score
from larics.detect.detector import Detector
from larics.detect.statistics import Statistics


class Edges:
    """Stands for an edge finder; a list of 10 edges of thin lines and 5 other points, or of 7 in all."""

    edges = listed = None

    def __init__(self, clear, needs_lower=None):
        self.clear = clear
        self.lower = not clear if needs_lower is None else needs_lower
        self.listed, self.steep = 15, 3

    def is_clear(self):
        return self.clear

    def needs_lower(self):
        return self.lower

    def finds_alike(self, other):
        return False

    def find_blurred(self, frame):
        return 7


class Votes:
    """Notes how edges vote; finds three centres."""

    votes = 1
    per_edge = 80000

    class grid:
        cells = 24000

    def __init__(self, least, centres):
        self.least_score = least
        self.centres = centres
        self.asked = []

    def find(self, edges, first, count, every, left, right, top, bottom):
        self.asked.append((first, count, every))
        for index, score in enumerate((300, 199, 139)):
            self.centres[3 * index : 3 * index + 3] = [score, 40000, 40000]
        return 3


class Scale:
    radius_min_q8, radius_max_q8 = 5000, 9000
    is_searched = False

    def __init__(self, clear=True, least=180, centres=None, needs_lower=None):
        self.edges = Edges(clear, needs_lower)
        self.votes = Votes(least, centres)


class Kept:
    def __init__(self):
        self.votes = []

    def remember(self, *arguments):
        self.votes.append(arguments[5])


def searching(scales, effort_most=1 << 29):
    centres = [0] * 9
    for scale in scales:
        scale.votes.centres = centres
    return BlurredSearch(scales, centres, Kept(), 360, 296, Statistics(), effort_most)


def test_least_scores():
    assert least_score(Scale()) == 200
    assert least_score(Scale(clear=False)) == 140
    assert least_score(Scale(least=0)) == least_score(Scale(clear=False, least=0)) == 0
    for scale, kept in (
        (Scale(), [300]),
        (Scale(clear=False), [300, 199]),
        (Scale(least=0), [300, 199, 139]),
    ):
        search = searching([scale])
        search.begin()
        search.go_on(scale, 10)
        assert search._candidates.votes == kept


def test_after_a_while_every_other_point_goes_on_voting_where_there_is_contrast():
    for clear, empty, every in ((True, 5, 2), (False, 5, 1), (True, 4, 1)):
        scale = Scale(clear)
        search = searching([scale])
        for _ in range(empty):
            search.end(False)
        search.begin()
        search.go_on(scale, 10)
        assert scale.votes.asked == [(10, 15, every)]
        search.find(None)  # there is nothing left to do
        assert len(scale.votes.asked) == 1
        search.begin()
        search.find(None)
        assert scale.votes.asked[1:] == [(0, 7, 1)]


def test_a_scale_that_would_take_too_much_is_not_searched():
    for effort_most, searched in ((25000, True), (24999, False)):
        scale = Scale(clear=False)
        search = searching([scale], effort_most)
        search.begin()
        search.go_on(scale, 10)  # 5 edges of 80,000 votes each, 16 of which are a thousand instructions
        assert bool(scale.votes.asked) == searched and scale.is_searched
        assert search._statistics.effort() == (1000 if searched else 0)  # of the grid


def test_nothing_is_listed_for_scales_that_would_not_vote():
    for steep, listed in ((100, 3), (101, 0)):
        search = searching([Scale()], 100)
        search.begin()
        search._statistics.steep = steep
        search.find(None)
        assert search._statistics.steep == steep + listed


def test_when_a_search_goes_on_at_once():
    one, two = Scale(), Scale()
    for scales, found, due in (([one], True, True), ([one, two], True, False), ([one, two], False, True)):
        search = searching(scales)
        search.end(found)
        search.begin()
        assert search.is_due(one) == due
    search = searching([Scale(needs_lower=True)])
    assert search.wants_lower(search._scales) and search.is_due(search._scales[0])
    search.end(True)
    search.begin()
    # listing anew with the lower threshold is for frames in which nothing was found
    assert not search.wants_lower(search._scales) and not search.is_due(search._scales[0])
    for _ in range(10):
        search.end(False)
        search.begin()
        assert search.wants_lower(search._scales) and search.is_due(search._scales[0])


def test_after_a_while_without_a_marker_scales_take_turns():
    for count, together in ((1, True), (2, True), (3, False), (5, False)):
        scales = [Scale() for _ in range(count)]
        search = searching(scales)
        seen = []
        for frame in range(30):
            search.begin()
            seen.append([index for index in range(count) if not scales[index].is_searched])
            assert search.is_sparing() == (frame > 4)
            assert search.in_turns == (frame > 4 and not together)
            search.end(False)
        everything = list(range(count))
        assert seen[:5] == 5 * [everything]
        if together:
            assert seen == 30 * [everything]
        else:
            assert all([len(one) == 1 for one in seen[5:]])
            for first in range(5, 30 - 2 * count):
                assert {one[0] for one in seen[first : first + count]} == set(everything)
        search.end(True)
        search.begin()
        assert not search.is_sparing() and not any([scale.is_searched for scale in scales])


def test_a_frame_is_clear_from_some_contrast_on():
    finder = Detector(136, 128, 23, 30)._scales[0].edges
    finder.threshold = 10
    assert not finder.is_clear()
    finder.threshold = 11
    assert finder.is_clear() and finder.needs_lower()
    assert not Detector(136, 128, 8, 12)._scales[0].edges.needs_lower()  # small rings have edges enough


def test_fainter_points_are_left_out_when_they_are_too_many():
    finder = Detector(136, 128, 23, 30)._scales[0].edges
    frame = bytearray(136 * 128)
    for y in range(40):
        for x in range(136):
            frame[136 * y + x] = x if x < 60 else min(255, 2 * x)  # 4 and 8 levels over 4 px
    finder.threshold = 4
    few = finder.list_steep(frame, 0, False)
    assert few == 0 and not finder.lowered
    steep = finder.steep
    finder.list_steep(frame, 0, True)
    assert finder.lowered and finder.steep > steep
    finder._capacity = finder.steep
    finder.list_steep(frame, 0, True)
    assert not finder.lowered and finder.steep == steep
