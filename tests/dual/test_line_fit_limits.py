"""Where the blur-model reader looks for lines, and what it asks of the kernels that measure them."""

from array import array

from larics.arith.fixed import Parts
from larics.blurred import line_fit
from larics.blurred.blur_model import BlurModel
from larics.blurred.line_fit import BlurredLines
from larics.marker import LARICS3

ZERO = 32768


class Rings:
    """Rings whose samples are noted, by the fan: directions, step, start, first unit, units of 6.25 mm."""

    levels = samples = None
    amplitude = 100

    def __init__(self, radius_q8=7680):
        self.radius_q8 = radius_q8
        self.fans = []

    def sample(self, frame, fan, cosine, sine):
        self.fans.append(tuple(fan))
        return True


class Kernels:
    """Stands for the kernels: a line has this depth everywhere, and templates this reach; asked: by whom."""

    def __init__(self, depth=0, reach=3, turn=0):
        self.depth, self.reach, self.turn = depth, reach, turn
        self.zones = []
        self.asked = []

    def ink_profile(self, samples, i, value, fan, zones, zone, *rest):
        self.zones.append(tuple(zones[zone : zone + 3]))

    def line_template(self, bars, i, value, across, middle, cosines, fan, zones, zone, *rest):
        self.zones.append(tuple(zones[zone : zone + 3]))
        return self.reach

    def ink_noise(self, ink, k, total, directions, apart):
        self.asked.append(("noise", directions, apart))
        return 40

    def line_depths(self, i, j, ink, fan, templates, angle, motion_axis, first, last, depths):
        self.asked.append(("depths", first, last))
        for k in range(first, last + 1):
            depths[k] = ZERO + self.depth

    def deepest(self, depths, k, value, directions, apart, result):
        self.asked.append(("deepest", directions, apart))
        result[0], result[1], result[2] = 5, ZERO + 250, ZERO - 20

    def line_turn(self, ink, i, value, templates, base, half, middle, result):
        self.asked.append(("turn", half, middle))
        result[0] = 1048576 + self.turn

    def line_residual(self, ink, k, total, templates, base, half, middle, depth):
        self.asked.append(("residual", half, middle, depth))
        return 7

    def erase_line(self, samples, i, value, across, middle, bars, cosines, fan, cosine, sine, *rest):
        self.asked.append((cosine, sine))

    def fit_code(self, ink, k, value, templates, axes, reach, gram, side, rounds, solution):
        self.asked.append(("fit", axes, reach, rounds))
        for position in range(8):
            solution[position] = 65536 + 10 * position
        solution[9] = 65536 + 25

    def code_residuals(self, *arguments):
        pass


def with_kernels(kernels, act, *arguments):
    kept = line_fit.kernels, line_fit.code_kernels
    line_fit.kernels = line_fit.code_kernels = kernels
    try:
        act(*arguments)
    finally:
        line_fit.kernels, line_fit.code_kernels = kept


def lines_of(kernels, radius_q8=7680):
    return BlurredLines(LARICS3, BlurModel(LARICS3, 175, Parts()), Parts()), Rings(radius_q8)


def test_the_orientation_line_is_looked_for_all_around():
    for radius_q8, apart in ((2560, 4), (2561, 2), (5120, 2), (5121, 1)):  # 10 and 20 px
        kernels = Kernels()
        lines, rings = lines_of(kernels, radius_q8)
        with_kernels(kernels, lines.find_orientation, None, rings)
        assert rings.fans == [(128, 2, 0, 28, 6)]  # from 175 to 206 mm: beyond are cells
        assert kernels.zones == [(0, 6, 0)]
        assert kernels.asked == [("noise", 128, apart), ("depths", 0, 127), ("deepest", 128, 10)]
        assert (lines.angle_turn16, lines.depth, lines.rival, lines.noise) == (5 << 9, 250, -20, 40)


def test_it_is_turned_to_a_fraction_of_a_direction():
    kernels = Kernels(turn=-300)
    lines, rings = lines_of(kernels)
    with_kernels(kernels, lines.refine_orientation, None, rings, 2)
    assert rings.fans == 2 * [(29, 2, 228, 28, 6)]  # 14 directions to either side
    assert kernels.zones == 2 * [(0, 6, 0)] and kernels.asked == 2 * [("turn", 13, 14)]
    assert lines.angle_turn16 == 65536 - 1200


def test_its_halves_are_measured_and_what_goes_on_beyond_its_end():
    kernels = Kernels(depth=200)
    lines, rings = lines_of(kernels)
    with_kernels(kernels, lines.measure_orientation, rings)
    assert kernels.zones == [(0, 6, 0), (0, 3, 0), (3, 3, 0)]
    assert kernels.asked == [("depths", 14, 14), ("residual", 13, 14, 200)] + 2 * [("depths", 14, 14)]
    assert (lines.depth, lines.near, lines.far, lines.residual) == (200, 200, 200, 7)
    del kernels.zones[:], kernels.asked[:]
    with_kernels(kernels, lines.measure_beyond, None, rings)
    assert rings.fans == [(29, 2, 228, 38, 2)] and kernels.zones == [(0, 2, 0)]  # 238 to 244 mm
    assert kernels.asked == [("depths", 14, 14)] and 0 < lines.beyond <= 200


def test_the_code_is_read_in_two_zones_of_a_line():
    for reach, most in ((3, 3), (31, 31), (32, 31)):  # items of a template
        kernels = Kernels(reach=reach)
        lines, rings = lines_of(kernels)
        with_kernels(kernels, lines.read_code, None, rings)
        assert rings.fans == [(64, 4, 0, 4, 9)]  # from 25 to 75 mm
        assert kernels.zones == 2 * [(0, 4, 0), (4, 5, 64)]
        assert kernels.asked == [("fit", 1, most, 16)]
        assert lines.common == 25 and list(lines.amounts) == [10 * k - 25 for k in range(8)]


def test_templates_are_as_far_apart_as_kernels_look_for_them():
    kernels = Kernels()
    lines, _ = lines_of(kernels)
    with_kernels(kernels, lines.prepare)
    assert kernels.zones == [(0, 6, 0)]
    kernels = Kernels()
    lines, _ = lines_of(kernels)
    lines.blur.still = 0
    with_kernels(kernels, lines.prepare)
    assert kernels.zones == 9 * [(0, 6, 0)] and len(lines._templates) == 9 * 15


def test_lines_are_taken_out_where_there_is_half_of_one():
    for amount, erased in ((128, [(16384, 0)]), (129, [(16384, 0), (0, 16384)])):
        kernels = Kernels()
        lines, rings = lines_of(kernels)
        lines.amounts[2] = amount
        with_kernels(kernels, lines.erase, rings, array("i", (64, 4, 2, 13, 16)))
        assert kernels.asked == erased, amount
