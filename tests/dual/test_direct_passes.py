"""Limits of the passes of the direct reader: how often rings are measured, and what it makes of that."""

from larics.direct.reader import DirectReader
from larics.marker import LARICS3, verdicts


class Scripted:
    """Stands for rings, lines and acceptance of a reader: passes move the rings as told, all is noted."""

    def __init__(self, radius_q8, moves):
        self.radius_q8 = radius_q8
        self.moves = list(moves)
        self.moved_q10 = 0
        self.passes = []
        self.looks = []
        self.code = self.angle_turn16 = 0
        self.line_q10 = 119
        self.area = 1

    def start(self, x_q10, y_q10, radius_q8):
        pass

    def coarse(self, edges, count, x_q8, y_q8, radii):
        return True

    def refine(self, frame, *rest):
        if not rest:
            return None
        self.passes.append(rest)
        self.moved_q10 = self.moves.pop(0) if self.moves else 0
        return True

    def first_look(self, rings, deviation_q10):
        self.looks.append(deviation_q10)
        return True

    def find_orientation(self, frame, rings):
        return 1

    def read_code(self, frame, rings):
        pass

    def skip_lines(self, lines):
        pass

    def rings(self, *measured):
        return verdicts.POOR_RINGS  # so far and no farther


class Scale:
    radii = None
    radius_min_q8 = radius_max_q8 = 0

    class edges:
        edges = None


def examined(radius_q8, moves, predicted=0):
    """The verdict on scripted rings, and the script."""
    reader = DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None, False)
    script = Scripted(radius_q8, moves)
    reader.rings = reader.lines = reader.acceptance = script
    return reader.examine(None, Scale, 1, 0, 0, predicted), script


def test_rings_too_small_or_too_faint_are_left_to_the_blur_model():
    reader = DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None, False)
    line_px256 = 7680 * reader.rings.line_q10 >> 10
    reader.rings.radius_q8, reader.rings.area = 7680, (56 * line_px256 + 255) // 256
    assert reader.decides()
    reader.rings.area -= 1
    assert not reader.decides()
    for radius_q8 in (2303, 2304):
        reader.rings.radius_q8, reader.rings.area = radius_q8, 100000
        assert reader.decides() == (radius_q8 == 2304)


def test_deviations_of_the_first_passes():
    assert examined(8000, (0,))[1].looks == [1300, 480]
    assert examined(8000, (0,), 8000)[1].looks == [1300, 480]  # a prediction may be off as a tilt is


def test_a_prediction_saves_crossings():
    for predicted, asked in ((0, [6, 6, 16, 16]), (7167, [4, 4, 12, 12]), (7168, [3, 3, 12, 12])):
        script = examined(8000, (626, 0, 121, 0), predicted)[1]
        assert [one[0] for one in script.passes] == asked


def test_rings_that_are_far_off_take_more_passes():
    for radius_q8, moves, passes in (
        (4096, (400,), 2),  # one more for the pose without the lines
        (4096, (401, 400), 3),
        (4096, (401, 401, 400), 4),
        (4096, (401, 401, 401, 400), 5),
        (8000, (625,), 2),  # 1/51 of the radius
        (8000, (626, 625), 3),
        (4095, (0, 0), 3),  # small rings take one more
    ):
        verdict, script = examined(radius_q8, moves)
        assert verdict == verdicts.POOR_RINGS and len(script.passes) == passes, (radius_q8, moves)
        lines_first = [one[0] for one in script.passes[1:-1]]
        assert lines_first == [12 if radius_q8 < 4096 else 6] * (passes - 2)
    verdict, script = examined(4096, (401, 401, 401, 401))
    assert verdict == verdicts.NO_FIT and len(script.passes) == 4


def test_the_last_pass_must_settle():
    for moves, verdict, passes in (
        ((0, 120), verdicts.POOR_RINGS, 2),
        ((0, 121, 120), verdicts.POOR_RINGS, 3),
        ((0, 121, 121), verdicts.NO_FIT, 3),
    ):
        found, script = examined(8000, moves)
        assert (found, len(script.passes)) == (verdict, passes), moves


class Moved(Scripted):
    """A script whose robust fit moves the centre by so much; no orientation line is believed after that."""

    margin = 255

    def fit(self, rings):
        return True

    def take_centre(self, robust):
        return self.robust_q10

    def rings(self, *measured):
        return verdicts.ACCEPTED

    def orientation(self, lines, rings):
        return verdicts.NO_ORIENTATION


def test_a_centre_that_was_moved_lets_the_line_be_measured_twice():
    for moved_q10, times in ((40, 1), (41, 2)):
        reader = DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None, False)
        script = Moved(8000, (0,))
        script.robust_q10 = moved_q10
        reader.rings = reader.lines = reader.acceptance = reader.robust = script
        reader._turn_by_code = lambda frame: False
        assert reader.examine(None, Scale, 1, 0, 0, 0) == verdicts.NO_ORIENTATION
        assert script.passes[-1] == (script, times)


class Covered(Scripted):
    """... whose rings are poor in too many sectors, which are faint there or not; told: verdict and ID."""

    def __init__(self, faint, told):
        super().__init__(7680, ())
        self.faint = faint
        self.marker_id = told[1]
        self.margin = 0
        self.code = lambda *arguments: told[0]

    def rings(self, *measured):
        return verdicts.ACCEPTED if len(measured) > 3 else verdicts.POOR_RINGS

    def refine_faint(self, *arguments):
        return self.faint

    def uneven(self, rings):
        return True

    def fit(self, rings):
        return False

    def orientation(self, *arguments):
        return verdicts.ACCEPTED

    def measure_direct(self, frame, rings, lines, is_faint):
        assert is_faint == self.faint
        return True

    def follow_code(self, *arguments):
        pass


def covered(faint, told, marker_id, coded=True):
    """The verdict, and the last pass of the rings."""
    reader = DirectReader(136, 128, LARICS3, 175, 7680, bytearray(512), 16, None, False)
    script = Covered(faint, (told, marker_id))
    reader.rings = reader.lines = reader.acceptance = reader.robust = script
    reader.cells = script if coded else None
    verdict = reader.examine(None, Scale, 1, 0, 0, 0)
    return verdict, [rest for rest in script.passes if len(rest) == 3][-1]


def test_rings_much_of_which_is_covered_are_those_of_a_marker_whose_cells_tell():
    poor, good, unsure = verdicts.POOR_RINGS, verdicts.ACCEPTED, verdicts.ID_UNCERTAIN
    for faint, told, marker_id, coded, expected in (
        (False, good, 8, True, (good, (16, 4, 48))),
        (False, good, 7, True, (poor, (16, 4, 48))),  # the lines tell it, not the cells
        (False, unsure, -1, True, (poor, (16, 4, 48))),
        (False, good, 7, False, (poor, (16, 4, 48))),
        (True, good, 7, False, (good, (16, 4, 96))),  # a lens is dirty on that side
        (True, good, 7, True, (good, (16, 4, 96))),
        (True, unsure, -1, True, (poor, (16, 4, 96))),
    ):
        verdict, last = covered(faint, told, marker_id, coded)
        assert verdict == expected[0], (faint, told, marker_id, coded)
        assert not (coded or faint) or last == expected[1], (faint, last)
