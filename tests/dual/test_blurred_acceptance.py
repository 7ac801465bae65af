"""The blur-model reader's decision on measurements made up at each limit and just beyond it."""

from larics.blurred.acceptance import Acceptance
from larics.coded.cell_reader import PLAIN
from larics.detect.detector import Detector
from larics.marker import LARICS3, verdicts
from larics.marker.detection import FLAG_BLUR_MODEL
from larics.marker.id_set import id_set
from marker_drawing import draw

ALL = (1, 2, 3, 4, 5, 6, 7)
RADIUS_Q8 = 7500


class Blur:
    def __init__(self):
        self.still = 1
        self.motion = 0


class Rings:
    """Flawless rings."""

    def __init__(self):
        self.blur = Blur()
        self.radius_q8 = RADIUS_Q8
        self.ratio_q10 = 683
        self.deviation_q10 = 0
        self.match = 1024
        self.good = 32
        self.amplitude = 1000


class Lines:
    """Flawless lines that tell the ID 5."""

    def __init__(self):
        self.blur = Blur()
        self.depth = self.near = self.far = 256
        self.residual = self.beyond = self.noise = self.common = 0
        self.amounts = [0] * 8
        self.amounts[6] = self.amounts[2] = 256
        self.residuals = [0] * 9


class Cells:
    """What cells have told: an ID, or PLAIN, and their margin."""

    def __init__(self, told, margin=255):
        self.told, self.margin = told, margin

    def decide(self, marker_id):
        return self.told


def acceptance(margin_min=0, ids=ALL):
    return Acceptance(LARICS3, id_set(ids, True, 0 in ids), margin_min)


def margin_at(distance, doubt):
    return min(255, distance * 255 // doubt)


def test_limits_of_the_rings():
    for faint, still, share, whole, name, limit, beyond, doubt in (
        (False, 1, 1, 1, "match", 700, -1, 200),
        (True, 1, 1, 1, "match", 560, -1, 200),
        (False, 1, 8, 10, "match", 560, -1, 200),
        (False, 1, 1, 1, "good", 24, -1, 8),
        (False, 0, 1, 1, "good", 20, -1, 8),
        (True, 1, 1, 1, "good", 18, -1, 8),
        (False, 1, 8, 10, "good", 19, -1, 8),
        (False, 1, 1, 1, "ratio_q10", 683 + 20, 1, 16),
        (False, 1, 1, 1, "ratio_q10", 683 - 20, -1, 16),
        (False, 1, 8, 10, "ratio_q10", 683 + 25, 1, 16),
        (False, 1, 1, 1, "deviation_q10", 36 * 30, 30, 28),  # thousandths of the radius
        (False, 1, 8, 10, "deviation_q10", 45 * 30, 30, 28),
    ):
        for distance in (0, doubt // 2, -1):
            rings = Rings()
            rings.amplitude = 159 if faint else 160
            rings.blur.still = still
            setattr(rings, name, limit - beyond * distance)
            judge = acceptance()
            assert judge.rings(rings, share, whole) == (distance >= 0), (name, limit, distance)
            if distance >= 0:
                assert judge.margin == margin_at(distance, doubt), (name, limit, distance)


def lines_verdict(lines, rival=0, radius_q8=RADIUS_Q8, judge=None, cells=None):
    """The verdict, the ID and the margin."""
    judge = judge or acceptance()
    judge.rings(Rings(), 1, 1)
    verdict = judge.lines(lines, rival, radius_q8, cells)
    return verdict, judge.marker_id, judge.margin


def test_limits_of_the_orientation_line():
    assert lines_verdict(Lines()) == (verdicts.ACCEPTED, 5, 242)  # what is beside a bit is never sure
    for names, limit, beyond, doubt, worse, others in (
        (("depth",), 150, -1, 70, verdicts.NO_ORIENTATION, {}),
        (("depth",), 420, 1, 100, verdicts.NO_ORIENTATION, {"amounts": [0, 0, 300, 0, 0, 0, 300, 0]}),
        (("near",), 120, -1, 80, verdicts.NO_ORIENTATION, {}),
        (("far",), 120, -1, 80, verdicts.NO_ORIENTATION, {}),
        (("residual",), 200, 1, 120, verdicts.NO_ORIENTATION, {}),
        (("residual",), 230, 1, 120, verdicts.NO_ORIENTATION, {"noise": 30}),
        (("beyond",), 110, 1, 80, verdicts.NO_ORIENTATION, {}),
        (("common",), 170, 1, 80, verdicts.NOT_EMPTY, {}),
        (("common",), -170, -1, 80, verdicts.NOT_EMPTY, {}),
    ):
        for distance in (0, doubt // 2, -1):
            lines = Lines()
            for name in others:
                setattr(lines, name, others[name])
            for name in names:
                setattr(lines, name, limit - beyond * distance)
            verdict, _, margin = lines_verdict(lines)
            assert verdict == (verdicts.ACCEPTED if distance >= 0 else worse), (names, limit, distance)
            if distance == 0:
                assert margin == 0, (names, limit)
            elif distance > 0:
                assert margin == margin_at(distance, doubt), (names, limit, margin)
    for rival, expected, margin in (
        (72, verdicts.ACCEPTED, 0),
        (52, verdicts.ACCEPTED, 127),
        (73, verdicts.TWO_ORIENTATIONS, None),
    ):
        found = lines_verdict(Lines(), rival)
        assert found[0] == expected and margin in (None, found[2])


def test_positions_that_must_be_empty():
    for position in (0, 1, 3, 5, 7):
        for amount, margin in ((90, 0), (60, 127), (91, None), (-135, 0), (-95, 127), (-136, None)):
            lines = Lines()
            lines.amounts[position] = amount
            verdict, _, found = lines_verdict(lines)
            assert verdict == (verdicts.NOT_EMPTY if margin is None else verdicts.ACCEPTED), amount
            assert margin in (None, found), (position, amount)
    lines = Lines()  # in units of a line that is deeper than the rings
    lines.depth = 320
    lines.amounts[3] = 112
    assert lines_verdict(lines)[0] == verdicts.ACCEPTED
    lines.amounts[3] = 113
    assert lines_verdict(lines)[0] == verdicts.NOT_EMPTY
    # of a small marker, one may be dirty
    for radius_q8, first, second, expected in (
        (3071, 200, 90, verdicts.ACCEPTED),
        (3071, 201, 0, verdicts.NOT_EMPTY),
        (3071, 100, 91, verdicts.NOT_EMPTY),
        (3072, 91, 0, verdicts.NOT_EMPTY),
    ):
        lines = Lines()
        lines.amounts[1], lines.amounts[5] = first, second
        assert lines_verdict(lines, 0, radius_q8)[0] == expected, (radius_q8, first, second)


def test_limits_of_a_bit():
    doubt = verdicts.ID_UNCERTAIN
    for radius_q8, depth, amount, expected, marker_id, margin in (
        (3072, 256, 85, verdicts.ACCEPTED, 5, 0),
        (3072, 256, 55, verdicts.ACCEPTED, 5, 127),
        (3072, 256, 86, doubt, -1, None),
        (3072, 256, -60, verdicts.ACCEPTED, 5, 0),
        (3072, 256, -40, verdicts.ACCEPTED, 5, 127),
        (3072, 256, -61, doubt, -1, None),
        (3072, 320, -75, verdicts.ACCEPTED, 5, None),
        (3072, 320, -76, doubt, -1, None),
        (3072, 256, 160, verdicts.ACCEPTED, 7, 0),
        (3072, 256, 200, verdicts.ACCEPTED, 7, 127),
        (3072, 256, 159, doubt, -1, None),
        (3072, 256, 420, verdicts.ACCEPTED, 7, 0),
        (3072, 256, 370, verdicts.ACCEPTED, 7, 127),
        (3072, 256, 421, doubt, -1, None),
        (3072, 320, 200, verdicts.ACCEPTED, 7, None),  # 10/16 of the line
        (3072, 320, 199, doubt, -1, None),
        (3072, 320, 106, verdicts.ACCEPTED, 5, None),  # 85 in units of the line
        (3072, 320, 107, doubt, -1, None),
        (3072, 320, 525, verdicts.ACCEPTED, 7, 0),
        (3072, 320, 526, doubt, -1, None),
        (3071, 256, 212, verdicts.ACCEPTED, 7, 0),
        (3071, 256, 211, doubt, -1, None),
        (3071, 256, 85, verdicts.ACCEPTED, 5, 0),
    ):
        lines = Lines()
        lines.depth = depth
        lines.amounts[6] = lines.amounts[2] = 300  # far from every limit
        lines.amounts[4] = amount
        found = lines_verdict(lines, 0, radius_q8)
        assert found[:2] == (expected, marker_id), (radius_q8, depth, amount)
        assert margin in (None, found[2]), (radius_q8, depth, amount, found)


def test_noise_may_make_an_empty_bit_lighter():
    for noise, amount, margin in ((30, -90, 0), (30, -91, None), (30, -70, 127), (0, -60, 0), (0, -61, None)):
        lines = Lines()
        lines.noise = noise
        lines.amounts[4] = amount
        found = lines_verdict(lines)
        assert found[:2] == ((verdicts.ID_UNCERTAIN, -1) if margin is None else (verdicts.ACCEPTED, 5)), noise
        assert margin in (None, found[2])


def test_what_a_bit_leaves_of_the_ink():
    for position in (2, 4, 6):
        for noise, residual, margin in (
            (0, 190, 0),
            (0, 90, 127),
            (0, 191, None),
            (20, 230, 0),
            (20, 231, None),
        ):
            lines = Lines()
            lines.noise = noise
            lines.residuals[position] = residual
            verdict, _, found = lines_verdict(lines)
            assert verdict == (verdicts.ID_UNCERTAIN if margin is None else verdicts.ACCEPTED)
            assert margin in (None, found), (position, residual)


def test_what_may_be_told():
    lines = Lines()
    assert lines_verdict(lines, judge=acceptance(ids=(1, 4)))[0] == verdicts.ID_UNCERTAIN
    lines.amounts[4] = 85 - 30  # a margin of 127
    assert lines_verdict(lines, judge=acceptance(127))[:2] == (verdicts.ACCEPTED, 5)
    assert lines_verdict(lines, judge=acceptance(128))[0] == verdicts.ID_UNCERTAIN
    lines.amounts = [0] * 8
    assert lines_verdict(lines)[0] == verdicts.NO_CODE
    assert lines_verdict(lines, judge=acceptance(ids=(0, 1)))[:2] == (verdicts.ACCEPTED, 0)


def test_cells_tell_more_than_lines_or_take_their_belief():
    lines = Lines()
    assert lines_verdict(lines, cells=Cells(PLAIN))[:2] == (verdicts.ACCEPTED, 5)
    assert lines_verdict(lines, cells=Cells(PLAIN, 100))[2] == 100
    assert lines_verdict(lines, judge=acceptance(101), cells=Cells(PLAIN, 100))[0] == verdicts.ID_UNCERTAIN
    assert lines_verdict(lines, judge=acceptance(ids=(5, 21)), cells=Cells(21, 90)) == (
        verdicts.ACCEPTED, 21, 90
    )  # fmt: skip
    assert lines_verdict(lines, cells=Cells(21))[0] == verdicts.ID_UNCERTAIN  # not allowed
    judge = acceptance(91, (5, 21))
    assert lines_verdict(lines, judge=judge, cells=Cells(21, 90))[0] == verdicts.ID_UNCERTAIN


def test_what_a_first_reading_may_leave_around_the_orientation_line():
    for left, noise, is_no_line in ((230, 0, False), (231, 0, True), (250, 20, False), (251, 20, True)):
        lines = Lines()
        lines.residual, lines.noise = left, noise
        assert acceptance().is_no_line(lines) == is_no_line, (left, noise)


def test_what_a_first_reading_may_leave_beside_a_bit():
    for position in (2, 4, 6):
        for left, noise, too_uneven in ((320, 0, False), (321, 0, True), (330, 5, False), (331, 5, True)):
            lines = Lines()
            lines.noise = noise
            lines.residuals[position] = left
            assert acceptance().too_uneven(lines) == too_uneven, (position, left, noise)


def test_cells_that_motion_washes_out_look_like_none():
    lines = Lines()
    for motion, told, margin, expected in (
        (6, PLAIN, 31, 5),
        (6, PLAIN, 30, -1),
        (0, PLAIN, 30, -1),
        (6, 21, 30, 21),
        (7, PLAIN, 151, 5),
        (7, PLAIN, 150, -1),
        (7, 21, 150, 21),
    ):
        lines.blur.motion = motion
        found = lines_verdict(lines, judge=acceptance(ids=(5, 21)), cells=Cells(told, margin))
        assert found[1] == expected, (motion, told, margin)
        assert (found[0] == verdicts.ACCEPTED) == (expected > 0)


def with_glare(left, right, top, bottom, grey=255):
    """A sharp marker 7 with glare, or something of a grey, over the coding line above its centre."""
    frame = draw(136, 128, 7, 1085, 1022, 430, 0)
    for y in range(top, bottom):
        for x in range(left, right):
            frame[y * 136 + x] = grey
    return frame


def test_what_a_sharp_picture_hides_stays_hidden():
    finder = Detector(136, 128, 23, 30)
    found = finder.detect(with_glare(60, 76, 40, 60))
    # the direct reader finds the marker and leaves its ID open; then the rule decides
    assert finder.statistics.verdicts[verdicts.ID_UNCERTAIN] == 1
    assert len(found) == 1 and found[0].marker_id < 0 and not found[0].flags & FLAG_BLUR_MODEL
    assert finder.statistics.blur_verdict == verdicts.NOT_EMPTY


def test_the_rule_on_what_is_hidden_keeps_a_wrong_id_from_being_told():
    finder = Detector(136, 128, 23, 30)
    frame = with_glare(64, 72, 48, 60, 210)  # over the line alone: it looks like none
    finder.detect(frame)
    reader = finder.blur_reader
    for said, expected in (
        (verdicts.NO_FIT, verdicts.ACCEPTED),  # nothing is known to be hidden
        (verdicts.POOR_RINGS, verdicts.ACCEPTED),
        (verdicts.ID_UNCERTAIN, verdicts.NOT_EMPTY),
        (verdicts.TWO_ORIENTATIONS, verdicts.NOT_EMPTY),
        (verdicts.NOT_EMPTY, verdicts.NOT_EMPTY),
    ):
        reader.candidates.forget()
        reader.candidates.remember(1085 << 4, 1022 << 4, 23 << 8, 30 << 8, said, 0, False)
        assert reader.examine(frame, False) == expected, said
        if expected == verdicts.ACCEPTED:
            assert reader.acceptance.marker_id == 3  # which is wrong
    # glare is lighter than the plate, which is a sign by itself
    reader.candidates.forget()
    reader.candidates.remember(1085 << 4, 1022 << 4, 23 << 8, 30 << 8, verdicts.NO_RADIUS, 0, False)
    assert reader.examine(with_glare(64, 72, 48, 60), False) == verdicts.ID_UNCERTAIN


class FirstLook:
    """Lines after the first look at them, which the second one does not find."""

    def __init__(self, depth, noise):
        self.depth, self.noise, self.rival = depth, noise, 0

    def find_orientation(self, frame, rings):
        return True

    def refine_orientation(self, frame, rings, turns):
        return False


def test_what_counts_as_a_sharp_picture():
    reader = Detector(136, 128, 23, 30).blur_reader
    for still, sigma, radius_q8, expected in (
        (1, 8, 3073, True),
        (0, 8, 3073, False),
        (1, 9, 3073, False),
        (1, 8, 3072, False),
    ):
        reader.blur.still, reader.blur.sigma, reader.rings.radius_q8 = still, sigma, radius_q8
        assert bool(reader._sharp()) == expected, (still, sigma, radius_q8)
    for hidden, depth, noise, expected in (
        (True, 130, 64, verdicts.NOT_EMPTY),
        (True, 130, 65, verdicts.NO_ORIENTATION),  # in that much noise the rule is silent
        (True, 129, 64, verdicts.NO_ORIENTATION),  # there is no line
        (False, 130, 64, verdicts.NO_ORIENTATION),
    ):
        reader._hidden, reader.lines = hidden, FirstLook(depth, noise)
        assert reader._examine_lines(None) == expected, (hidden, depth, noise)


class Seen(FirstLook):
    """Lines that are seen well."""

    def refine_orientation(self, *arguments):
        return True

    read_code = measure_orientation = measure_beyond = refine_orientation


class Accepting:
    margin = 0

    def rings(self, *arguments):
        return True

    def lines(self, *arguments):
        return verdicts.ACCEPTED


def test_under_tilt_a_large_margin_tells_that_nothing_was_hidden():
    reader = Detector(136, 128, 23, 30).blur_reader
    reader._settled, reader._cells, reader._tell = True, None, lambda: None
    reader.lines, reader.acceptance = Seen(256, 64), Accepting()
    for hidden, e1, e2, margin, expected in (
        (True, -1000, 0, 128, verdicts.ACCEPTED),
        (True, 600, -800, 128, verdicts.ACCEPTED),
        (True, 999, 0, 128, verdicts.NOT_EMPTY),
        (True, 0, 1000, 127, verdicts.NOT_EMPTY),
        (False, 0, 1000, 127, verdicts.ACCEPTED),
    ):
        reader._hidden, reader.rings.e1, reader.rings.e2 = hidden, e1, e2
        reader.acceptance.margin = margin
        assert reader._examine_lines(None) == expected, (hidden, e1, e2, margin)
