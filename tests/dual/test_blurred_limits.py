"""Limits of the blur-model reader beside its acceptance: which candidates it looks at, how often it fits."""

from larics.blurred.candidates import Candidates
from larics.blurred.reader import BlurModelReader
from larics.marker import LARICS3, verdicts


class Scores:
    """Stands for rings: a coarse look at the candidates gives these scores."""

    def __init__(self, scores):
        self.scores = list(scores)
        self.x_q10 = self.y_q10 = self.radius_q8 = self.e1 = self.e2 = 0

    def coarse(self, *arguments):
        return self.scores.pop(0)


def looked_at(scores):
    """The candidate that is chosen of those with these scores, -1 for none, and how many were looked at."""
    candidates = Candidates()
    for index in range(len(scores)):
        candidates.remember(index << 14, 0, 5000, 9000, verdicts.NO_FIT, 100 - index)
    rings = Scores(scores)
    slot = candidates.best(None, rings)
    return slot // 12 if slot >= 0 else slot, len(scores) - len(rings.scores)


def test_scores_of_candidates():
    assert looked_at((4300, 4300)) == (-1, 2)
    assert looked_at((4301, 4300)) == (0, 2)
    assert looked_at((8999, 9500)) == (1, 2)
    assert looked_at((9000, 9500)) == (0, 1)  # good enough


class NoFit:
    """Stands for rings that never hold."""

    def __init__(self):
        self.turns = []
        self.x_q10 = self.y_q10 = self.radius_q8 = self.e1 = self.e2 = 0

    def start(self, *pose):
        pass

    def coarse(self, *arguments):
        return 1

    def fit(self, frame, turns, lines):
        self.turns.append(turns)
        return False


class Endless:
    """Candidates without an end."""

    def __init__(self, items):
        self.items = items
        self.asked = 0

    def best(self, frame, rings):
        self.asked += 1
        return 0


class FirstLook:
    """Lines that are found at once."""

    depth, noise, rival = 256, 0, 0

    def find_orientation(self, *arguments):
        return True

    refine_orientation = read_code = find_orientation


def test_how_often_it_fits_and_for_how_many_candidates():
    reader = BlurModelReader(136, 128, LARICS3, 175, bytearray(512), 16, None)
    reader.candidates = candidates = Endless(reader.candidates.items)
    reader.rings = rings = NoFit()
    assert reader.examine(None) == verdicts.NO_FIT
    assert candidates.asked == 2
    assert rings.turns == [3, 3, 3, 3]  # three ways to begin for the first, one is left for the second
    # once the lines are known, the rings are fitted again without them
    reader.lines = FirstLook()
    assert reader._examine_lines(None) == verdicts.NO_FIT
    assert rings.turns[4:] == [2]
