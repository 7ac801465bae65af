"""Limits of the search: how radii are cut into scales, what counts as an edge, which cells become centres."""

from array import array

from larics.detect import edges as edges_module
from larics.detect.centre_votes import CellGrid, CentreVotes, VoteBuffers
from larics.detect.confirmation import Confirmation
from larics.detect.detector import Detector
from larics.detect.edges import EdgeFinder
from larics.detect.scales import Scale, cut, grouped, tilted_px
from larics.kernels import edges as kernels
from larics.marker.detection import FLAG_UNCONFIRMED, NO_ID, Detection
from marker_drawing import draw


def pixels(scales):
    """The ranges of scales in px."""
    return [(scale.radius_min_q8 >> 8, scale.radius_max_q8 >> 8) for scale in scales]


def test_how_far_one_scale_reaches():
    for least, most, count in (
        (20, 29, 1),
        (20, 30, 2),  # more than 378/256
        (20, 43, 2),
        (20, 44, 3),
        (6, 10, 1),  # up to 10 px a scale reaches further,
        (6, 11, 2),
        (7, 11, 2),  # others do not
        (5, 9, 2),  # and not beyond 450/256
        (6, 72, 7),
    ):
        scales = cut(least, most)
        assert len(scales) == count, (least, most)
        assert scales[0].radius_min_q8 == least << 8 and scales[-1].radius_max_q8 == most << 8
        for index in range(1, count):
            assert scales[index].radius_min_q8 == scales[index - 1].radius_max_q8


def test_scales_of_one_range_have_about_the_same_ratio():
    ratios = [(scale.radius_max_q8 << 8) // scale.radius_min_q8 for scale in cut(6, 72)]
    assert max(ratios) - min(ratios) <= 8, ratios


def test_radii_that_can_be_asked_for():
    for least, most, is_taken in ((6, 8, True), (5, 8, False), (70, 72, True), (70, 73, False)):
        try:
            Detector(64, 48, least, most, second_opinion=False)
            assert is_taken, (least, most)
        except ValueError:
            assert not is_taken, (least, most)


def test_tilt_shortens_radii_but_not_below_the_least():
    assert [tilted_px(40, tilt_deg) for tilt_deg in (0, 30, 40)] == [40, 30, 23]
    assert tilted_px(7, 40) == tilted_px(6, 0) == 6


def test_grids_follow_the_radius():
    for radius_px, step, reach in (
        (14, 3, 1),
        (15, 4, 1),
        (19, 4, 1),
        (20, 4, 2),
        (21, 4, 2),
        (22, 4, 2),
        (25, 5, 2),
        (44, 8, 2),
        (45, 8, 3),
        (72, 8, 3),
    ):
        scale = Scale(radius_px << 8, radius_px << 8)
        assert (scale.step, scale.reach) == (step, reach), radius_px


def test_scales_that_share_the_gradients_of_the_finest():
    for radii, groups in (
        ((10, 14), [[0], [1]]),  # every second point of its grid would be fewer than the other's own
        ((10, 16), [[1, 0]]),
        ((16, 21), [[0], [1]]),  # other reaches
        ((22, 46), [[1, 0]]),  # from two pixels on they are all the same
        ((22, 30, 46), [[2, 1, 0]]),
        ((10, 16, 19, 30), [[2, 1, 0], [3]]),
    ):
        scales = [Scale(radius << 8, radius << 8) for radius in radii]
        found = [[scales.index(scale) for scale in group] for group in grouped(scales)]
        assert found == groups, (radii, found)
        for group in grouped(scales):
            assert all([scale.reach == group[-1].reach for scale in group])


class Gradients:
    """Stands for the kernel that measures gradients: so many samples in a bin of 2 grey levels, the rest in
    another."""

    edge_threshold = staticmethod(kernels.edge_threshold)

    def __init__(self, usual, steep, count):
        self.usual, self.steep, self.count = usual, steep, count

    def gradient_histogram(self, across, position, image, grid, every, histogram):
        self.every = every
        histogram[self.usual] = 1024 - self.count
        histogram[self.steep] += self.count
        return 1024


def threshold(usual, steep, count, line_q8=512, width=1024, height=1024):
    """The threshold of a frame in which so many 1024ths of the gradients are steep."""
    finder = EdgeFinder(width, height, line_q8, 4, 2, array("i", bytes(40)), array("H", bytes(256)))
    stand_in = Gradients(usual, steep, count)
    edges_module.kernels = stand_in
    try:
        finder.measure_threshold(None)
    finally:
        edges_module.kernels = kernels
    assert stand_in.every == 4
    return finder.threshold


def test_the_threshold_follows_the_gradients():
    assert threshold(0, 0, 0) == 3  # of a frame that is all alike
    assert threshold(4, 50, 80) == 20  # 2.5 medians, which are 8 levels
    for count, expected in ((60, 41), (61, 100)):  # too few would be steeper than 2.5 medians
        assert threshold(20, 50, count) == expected, count
    for count, expected in ((92, 5), (93, 101)):  # too many
        assert threshold(1, 50, count, 256) == expected, count
    # a marker's own edges are more of a small frame, but never more than half
    for count, expected in ((108, 5), (109, 101)):
        assert threshold(1, 50, count, 512, 256, 256) == expected, count
    for count, expected in ((512, 5), (513, 101)):
        assert threshold(1, 50, count, 1536, 64, 48) == expected, count


def edges_of(line_q8, is_dark, step=1, rectangle=(0, 64, 0, 64)):
    """The number of edges of a frame of 64 x 64 px, and where they are."""
    frame = bytearray(64 * 64)
    for k in range(len(frame)):
        frame[k] = 50 if is_dark(k % 64, k // 64) else 200
    found = array("i", bytes(4 * 1001))
    finder = EdgeFinder(64, 64, line_q8, step, 1, found, array("H", bytes(256)))
    finder.threshold = 20
    count = finder.find(frame, *rectangle)
    return [((one & 1048575) % 64, (one & 1048575) // 64) for one in found[:count]]


def test_lines_have_white_on_both_sides():
    for line_q8, width, is_line in (
        (256, 1, True),  # thinner than two pixels, too
        (1024, 4, True),
        (1024, 5, True),
        (1024, 7, False),
        (1024, 40, False),  # the edge of a panel
    ):
        found = edges_of(line_q8, lambda x, y, end=20 + width: 20 <= x < end)
        assert bool(found) == is_line, (line_q8, width, len(found))
    assert not edges_of(256, lambda x, y: x < 30)
    assert not edges_of(1024, lambda x, y: not 28 <= x < 32)  # a light line is none


def test_edges_lie_on_the_grid_within_the_rectangle():
    def stripes(x, y):
        return x % 8 < 2

    everywhere = edges_of(512, stripes, 2)
    assert everywhere and all([x % 2 == y % 2 == 0 for x, y in everywhere])
    # 5 px from the border at least, so that all pixels that are looked at lie in the frame
    assert min([y for x, y in everywhere]) == 6 and max([y for x, y in everywhere]) == 58
    inside = edges_of(512, stripes, 2, (17, 41, 30, 45))
    assert inside == [(x, y) for x, y in everywhere if 16 <= x < 41 and 30 <= y < 45]


def voting(radius_max_q8):
    """Votes on a frame of 136 x 64 px."""
    grid = CellGrid(136, 64, 4, radius_max_q8)
    return CentreVotes(grid, 2000, radius_max_q8, 683, 60, 4, VoteBuffers([grid], 0))


def centres(votes, seen):
    """How many centres there are when cells, all apart, have been seen from so many directions each."""
    grid = votes.grid
    buffer = votes._buffers.cells
    for index in range(len(buffer)):
        buffer[index] = 0
    for index, directions in enumerate(seen):
        row, column = grid.padding + 4 * (index // 8), grid.padding + 4 * (index % 8)
        buffer[row * grid.row + column] = ((1 << directions) - 1) << (24 - directions)
    return votes.find(array("i", [0, 0]), 1, 1, 1, 0, 136, 0, 64)  # all votes have come in already


def test_directions_that_a_centre_needs():
    for radius_max_q8, least in ((3072, 15), (3071, 11)):  # small rings show fewer
        votes = voting(radius_max_q8)
        assert centres(votes, [least]) and not centres(votes, [least - 1]), radius_max_q8


def test_as_many_centres_as_are_examined_and_windows_as_are_ranked():
    votes = voting(3072)
    assert centres(votes, [15]) < centres(votes, 23 * [15]) == 6
    # four windows of each make 96: then the weakest are left out
    assert centres(votes, 24 * [15]) == 0
    assert centres(votes, 23 * [15] + [16]) == centres(votes, [16]) > 0


def test_centres_with_a_low_score_are_not_fitted():
    finder = Detector(64, 48, 6, 20, second_opinion=False)
    asked = []
    finder._candidate = lambda frame, scale, edges, *rest: asked.append(edges)
    scores = (181, 180, 179, 1)
    for index, score in enumerate(scores):
        finder._centres[3 * index] = score
    finder._examine_all(None, finder._scales[-1], 9, 4, 0)
    assert asked == [9, 9, 0, 0]
    finder._examine_all(None, finder._scales[0], 9, 4, 0)  # but of small rings all are
    assert asked[4:] == [9, 9, 9, 9]


def test_the_finest_grids_are_alike():
    """Other radii need no longer buffer on a board whose memory is full."""
    assert CellGrid(360, 296, 3, 8 << 8).cells == CellGrid(360, 296, 3, 17 << 8).cells
    assert CellGrid(360, 296, 3, 17 << 8).padding == 10
    assert CellGrid(360, 296, 4, 12 << 8).padding == 8
    assert CellGrid(360, 296, 6, 24 << 8).padding == 8


def confirmed(confirmation, *ids):
    """Which of the detections of a frame are not flagged."""
    found = [Detection() for _ in ids]
    for one, marker_id in zip(found, ids):
        one.marker_id, one.flags = marker_id, 0
    confirmation.update(found, len(found))
    return [not one.flags & FLAG_UNCONFIRMED for one in found]


def test_an_id_counts_once_in_a_frame_and_not_where_it_is_uncertain():
    confirmation = Confirmation(2, 3, 4)
    assert confirmed(confirmation, 5, 5, NO_ID) == [False, False, True]
    assert confirmed(confirmation, 6, 5) == [False, True]
    assert confirmed(confirmation) == []
    assert confirmed(confirmation, 5, 6) == [True, True]
    assert confirmed(confirmation) == confirmed(confirmation) == []
    assert confirmed(confirmation, 5, 6) == [False, False]  # of three frames
    assert confirmed(confirmation, NO_ID) == [True]
    for least, frames in ((0, 3), (4, 3), (1, 256)):
        try:
            Confirmation(least, frames, 4)
            raise AssertionError((least, frames))
        except ValueError:
            pass


def steep_finder(capacity=1000):
    """A finder on 64 x 64 px, and a frame of stripes whose gradients are 40, and 34 in its lower half."""
    frame = bytearray(64 * 64)
    for k in range(len(frame)):
        dark = 140 if k < 32 * 64 else 146
        frame[k] = dark if k % 64 % 8 < 3 else 180
    found = array("i", bytes(4 * (capacity + 1)))
    finder = EdgeFinder(64, 64, 768, 4, 1, found, array("H", bytes(256)))
    finder.threshold = 36
    return finder, frame


def test_every_second_point_comes_first_for_the_scales_that_share_them():
    finder, frame = steep_finder()
    assert finder.list_steep(frame, 0, False) == 0 and not finder.lowered
    everywhere = sorted(finder.edges[: finder.steep])
    assert everywhere
    first = finder.list_steep(frame, 500, False)
    listed = list(finder.edges[: finder.steep])
    assert sorted(listed) == everywhere and 0 < first < finder.steep
    colours = [(position % 64 // 4 + position // 64 // 4) & 1 for position in listed]
    assert all([(colour == colours[0]) == (index < first) for index, colour in enumerate(colours)])
    assert finder.list_steep(frame, first - 1, False) == first - 1  # as many as there is room for


def test_fainter_points_are_listed_while_there_is_room_and_are_no_edges_of_thin_lines():
    finder, frame = steep_finder()
    finder.list_steep(frame, 0, False)
    few = finder.steep
    first = finder.list_steep(frame, 500, True)
    many = finder.steep
    assert finder.lowered and many > few
    edges = finder.choose(frame, finder.edges, many, True)
    assert 0 < edges <= few and finder.listed == many
    assert all([one & 1048575 < 33 * 64 for one in finder.edges[:edges]])
    finder.list_steep(frame, 500, True)
    assert finder.choose(frame, finder.edges, many, False) > few  # only where they are wanted
    assert finder.list_steep(frame, first + 1, True) == first and finder.lowered
    assert finder.list_steep(frame, first, True) < first and not finder.lowered  # there is no room for more
    finder, frame = steep_finder(many)
    finder.list_steep(frame, 0, True)
    assert not finder.lowered and finder.steep == few


def test_votes_meet_in_the_middle_of_both_rings():
    frame = draw(96, 88, 3, 50 * 16, 42 * 16, 22 * 16, 1000)
    edges = EdgeFinder(96, 88, 650, 4, 1, array("i", bytes(4 * 601)), array("H", bytes(256)))
    edges.measure_threshold(frame)
    count = edges.find(frame, 0, 96, 0, 88)
    grid = CellGrid(96, 88, 4, 26 << 8)
    buffers = VoteBuffers([grid], 0)
    votes = CentreVotes(grid, 18 << 8, 26 << 8, 683, 325, 4, buffers)
    found = votes.find(edges.edges, 0, count, 1, 0, 96, 0, 88)
    best = list(buffers.centres[:3])
    assert found and best[0] > 250, best
    assert abs(best[1] - 32768 - (50 << 8)) < 512 and abs(best[2] - 32768 - (42 << 8)) < 512, best
    votes.find(edges.edges, 0, count // 2, 1, 0, 96, 0, 88)
    votes.find(edges.edges, count // 2, count, 1, 0, 96, 0, 88)  # goes on
    assert list(buffers.centres[:3]) == best
    votes.find(edges.edges, 0, count, 1, 0, 96, 0, 88)  # begins anew
    assert list(buffers.centres[:3]) == best
    assert votes.find(edges.edges, 0, count, 1, 0, 24, 0, 24) == 0  # not in this corner
