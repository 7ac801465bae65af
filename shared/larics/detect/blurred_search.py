"""Step 7, its search: centres among blurred edges, which are candidates for the blur-model reader alone.

Blurred lines need not look like thin lines, so that all steep points vote, and a lower threshold tells which
these are. After a frame without a marker, which is likely to be followed by another one, they are listed for
both searches at once, and those that are no thin lines go on voting where these have voted.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.marker import verdicts

_LEAST_SCORE = const(140)  # of a centre among blurred edges of a faint frame,
_LEAST_SCORE_CLEAR = const(200)  # and where the frame has contrast
_EMPTY_LONG = const(6)  # after so many frames without a marker one scale a frame is searched, in turns,
_TOGETHER = const(2)  # where there are more than these
_EVERY_CLEAR = const(2)  # there, after so long, every so-manyth steep point votes: blurred edges have enough


def least_score(scale):
    """The score of a centre of this scale that is worth a look of the blur-model reader."""
    if not scale.votes.least_score:
        return 0  # small rings show fewer directions
    return _LEAST_SCORE_CLEAR if scale.edges.is_clear() else _LEAST_SCORE


def all_searched(group):
    """Whether none of these scales is left to be searched in this frame."""
    for scale in group:
        if not scale.is_searched:
            return False
    return True


class BlurredSearch:
    """Lists the centres among blurred edges of one frame after the other.

    scales                 as of scales.cut, with edges and votes
    centres                array('i') that CentreVotes fills: (score, x, y)
    candidates             blurred.candidates.Candidates that receives them
    width, height          of the frame, px
    statistics             counts edges and votes
    effort_most            of the statistics, with which the scales left are not searched but in turns
    in_turns               whether one scale of many is searched in this frame
    """

    def __init__(self, scales, centres, candidates, width, height, statistics, effort_most):
        self._scales = scales
        self._centres = centres
        self._candidates = candidates
        self._width = width
        self._height = height
        self._statistics = statistics
        self._effort_most = effort_most
        self.in_turns = False
        self._empty = 1  # frames without a marker in a row; the first one is taken to be likely empty

    def begin(self):
        """Begins a frame."""
        scales = self._scales
        self.in_turns = len(scales) > _TOGETHER and self.is_sparing()
        for scale in scales:
            scale.is_searched = self.in_turns
        scales[self._empty % len(scales)].is_searched = False

    def end(self, found):
        """Ends a frame in which some marker was found, or none."""
        if found:
            self._empty = 0
        elif self._empty < _EMPTY_LONG + max(2, len(self._scales)) - 1:
            self._empty += 1
        else:
            self._empty = _EMPTY_LONG

    def is_sparing(self):
        """Whether there was no marker for so long that less is done in each frame."""
        return self._empty >= _EMPTY_LONG

    def wants_lower(self, group):
        """Whether a group of scales is listed with the lower threshold at once."""
        return self._empty > 0 and group[0].edges.needs_lower() and not all_searched(group)

    def is_due(self, scale):
        """Whether a scale is to be searched at once, while its votes are there.

        Those of a single scale that needs no lower threshold stay."""
        if scale.is_searched:
            return False
        return self._empty > 0 or len(self._scales) == 1 and not scale.edges.needs_lower()

    def go_on(self, scale, edges):
        """Lists the centres of a scale of which so many edges of thin lines have voted last."""
        every = _EVERY_CLEAR if self.is_sparing() and scale.edges.is_clear() else 1
        self._list(scale, scale.edges.edges, edges, scale.edges.listed, every)

    def find(self, frame):
        """Lists the centres of all scales that have none yet."""
        finder = None
        edges = 0
        for index in range(len(self._scales) - 1, -1, -1):
            scale = self._scales[index]
            if scale.is_searched:
                continue
            if self._statistics.effort() > self._effort_most:
                break  # no votes of those left would be cast
            if finder is None or not finder.finds_alike(scale.edges):
                finder = scale.edges
                edges = finder.find_blurred(frame)
                self._statistics.steep += finder.steep
            self._list(scale, finder.edges, 0, edges, 1)

    def _list(self, scale, listed, first, edges, every):
        scale.is_searched = True
        statistics = self._statistics
        votes = (edges - first) // every * scale.votes.per_edge
        if statistics.effort(votes) > self._effort_most:
            return
        centres = self._centres
        least = least_score(scale)
        clear = scale.edges.is_clear()
        count = scale.votes.find(listed, first, edges, every, 0, self._width, 0, self._height)
        statistics.edges += edges - first
        statistics.votes += scale.votes.votes
        statistics.cells += scale.votes.grid.cells
        for index in range(0, 3 * count, 3):
            if centres[index] < least:
                break
            self._candidates.remember(
                centres[index + 1] - 32768, centres[index + 2] - 32768, scale.radius_min_q8,
                scale.radius_max_q8, verdicts.NO_RADIUS, centres[index], clear,
            )  # fmt: skip
