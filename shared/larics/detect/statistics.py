"""What a detector counts of each frame."""

from array import array

from larics.marker.verdicts import VERDICT_NAMES


class Statistics:
    """What the last frame cost and how its candidates ended, for debugging.

    steep, edges    grid points with a steep gradient, and those that are edges of thin dark lines
    votes           cells voted for
    candidates      centres looked at; one whose score is too low ends as no_radius without more
    crossings       of rings with pixel rows and columns
    verdicts        array of the number of candidates by verdict, see verdict.VERDICT_NAMES
    blur_verdict    verdict of the blur-model reader; -1 when it was not asked
    """

    __slots__ = ("steep", "edges", "votes", "candidates", "crossings", "verdicts", "blur_verdict")

    def __init__(self):
        self.verdicts = array("H", bytes(2 * len(VERDICT_NAMES)))
        self.clear()

    def clear(self):
        self.steep = self.edges = self.votes = self.candidates = self.crossings = 0
        self.blur_verdict = -1
        for index in range(len(self.verdicts)):
            self.verdicts[index] = 0
