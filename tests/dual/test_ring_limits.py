"""Limits of the fit of rings: of edges, sectors, harmonics, the robust centre, and what is unsure of them."""

from array import array

from larics.arith import fixed, tables
from larics.direct import ring_fit, robust_centre, uncertainty
from larics.direct.ring_fit import RingFit
from larics.direct.robust_centre import RobustCentre
from larics.kernels import coarse, harmonics, layouts, robust

BIAS = layouts.BIAS


class CoarseResult:
    """Stands for the kernels of the coarse fit: so many edges on the outer and the inner ring."""

    def __init__(self, outer, inner):
        self.found = outer, inner

    def edge_distances(self, *arguments):
        return 20

    def choose_radius(self, *arguments):
        result = arguments[-1]
        self.rounds = arguments[-2]
        result[0], result[1], result[2] = 480, 0, 0
        result[3], result[4] = self.found


def test_edges_that_must_agree_on_a_radius():
    rings = RingFit(136, 128, 683, 119, 8000)
    for radius_max_q8, outer, inner, expected in (
        (3072, 7, 4, True),
        (3072, 6, 4, False),
        (3072, 7, 3, False),
        (3071, 5, 3, True),
        (3071, 4, 3, False),
        (3071, 5, 2, False),
    ):
        ring_fit.coarse = stand_in = CoarseResult(outer, inner)
        try:
            found = rings.coarse(None, 30, 68 << 8, 64 << 8, rings.radii(2000, radius_max_q8, 300))
        finally:
            ring_fit.coarse = coarse
        assert found == expected, (radius_max_q8, outer, inner)
        assert stand_in.rounds == 2


class HarmonicsCall:
    """Stands for the kernels of the harmonics: notes how they are called."""

    def ring_harmonics(self, *arguments):
        self.rounds, self.floor = arguments[7], arguments[8]
        return False


def test_a_sector_within_a_tenth_of_a_pixel_is_never_an_outlier():
    rings = RingFit(136, 128, 683, 119, 8000)
    rings.start(68 << 10, 64 << 10, 6000)
    ring_fit.harmonics = stand_in = HarmonicsCall()
    try:
        assert not rings.refine(fixed.frame_view(bytearray(136 * 128)), 6, 3, 192)
    finally:
        ring_fit.harmonics = harmonics
    assert (stand_in.rounds, stand_in.floor) == (3, 96)


def harmonics_of(residuals, rounds=2, floor=1):
    """What is found in 16 sectors of the outer ring (None: nothing seen) with a flawless inner one."""
    sectors = array("i", [0] * 128)
    for ring in range(2):
        for k in range(16):
            residual = residuals[k] if ring == 0 else 0
            if residual is not None:
                slot = 64 * ring + 4 * k
                sectors[slot] = sectors[slot + 2] = 1
                sectors[slot + 3] = 32768 + residual
    outer = array("i", [0] * layouts.RING_ITEMS)
    inner = array("i", [0] * layouts.RING_ITEMS)
    means = array("i", [0] * 32), array("i", [0] * 32)
    holds = harmonics.ring_harmonics(
        0, 0, 0, sectors, means[0], means[1], tables.HARMONICS_4, rounds, floor, outer, inner
    )
    return holds, outer


def test_a_sector_four_mean_deviations_off_is_an_outlier():
    waves = [10 if k & 1 else -10 for k in range(16)]  # no harmonic that is looked for
    for off, used in ((50, 16), (150, 15)):
        residuals = list(waves)
        residuals[1] += off
        assert harmonics_of(residuals)[1][layouts.RING_USED] == used, off
    for floor, used in ((200, 16), (20, 15)):  # one close enough never is
        residuals = list(waves)
        residuals[1] += 150
        assert harmonics_of(residuals, 2, floor)[1][layouts.RING_USED] == used, floor


def test_sectors_that_a_ring_needs():
    for seen, expected in ((5, 1), (4, 0)):
        residuals = [0 if k % 3 == 0 and k // 3 < seen else None for k in range(16)]
        assert residuals.count(0) == seen
        assert harmonics_of(residuals)[0] == expected, seen


def end_of_pass(apart_x, deviation, radius_q8=7680):
    """Whether rings whose centres are so far apart hold, and how far beyond their mean the true one lies."""
    fit = array("i", [0] * layouts.FIT_ITEMS)
    fit[layouts.FIT_RADIUS_Q8], fit[layouts.FIT_INNER_Q8] = radius_q8, radius_q8 * 2 // 3
    fit[layouts.FIT_INNER_Q10], fit[layouts.FIT_BEYOND_Q8] = 683, 333
    fit[layouts.FIT_BULGE_COS] = fit[layouts.FIT_BULGE_SIN] = BIAS
    rings = []
    for sign in (1, -1):
        ring = array("i", [BIAS] * 5 + [deviation, 16, 16, 1000])
        ring[layouts.RING_COS] += sign * apart_x // 2
        rings.append(ring)
    holds = harmonics.end_pass(fit, rings[0], rings[1])
    return holds, fit[layouts.FIT_X_Q10] - fit[layouts.FIT_TRUE_X_Q10]


def test_centres_of_the_rings_that_are_too_far_apart():
    assert end_of_pass(2998, 0)[0] == 1
    assert end_of_pass(3000, 0)[0] == 0
    assert end_of_pass(-2998, 0)[0] == 1
    assert end_of_pass(-3000, 0)[0] == 0


def test_perspective_is_believed_as_far_as_it_is_sure():
    for apart, deviation, radius_q8 in (
        (600, 100, 7680),
        (600, 300, 7680),
        (40, 100, 7680),
        (40, 100, 18000),
    ):
        noise = 2 * deviation * deviation * 50 // 128 + 4
        prior = (radius_q8 // 16) * (radius_q8 // 16) * 32 // 230400
        signal = max(apart * apart - noise, prior * prior)
        expected = apart * 333 * signal // ((signal + noise) * 256)
        found = end_of_pass(apart, deviation, radius_q8)[1]
        assert abs(found - expected) <= 2 + expected // 50, (apart, deviation, radius_q8, found, expected)


def counted(on_rings, extra):
    """Edges counted on the outer and inner ring when `extra` (1/16 px) joins those that lie exactly there."""
    scale = array("i", [0] * layouts.RADII_ITEMS)
    scale[layouts.RADII_FIRST], scale[layouts.RADII_LAST], scale[layouts.RADII_BINS] = 25, 35, 60
    scale[layouts.RADII_INNER_Q10] = 683
    distances = array("i", [radius | direction << 16 for radius in on_rings for direction in range(0, 48, 2)])
    distances.append(extra | 1 << 16)
    result = array("i", [0] * 5)
    coarse.choose_radius(0, 0, bytearray(60), scale, distances, len(distances), fixed.AXES, 1, result)
    return result[3], result[4]


def test_how_near_an_edge_lies_to_a_ring():
    outer = 30 * 8 + 4
    inner = (outer * 683 + 512) >> 10
    for extra, expected in (
        (outer, (25, 24)),
        (outer + 40, (25, 24)),
        (outer + 41, (24, 24)),
        (outer - 40, (25, 24)),
        (inner + 31, (24, 25)),
        (inner + 32, (24, 24)),
        (inner - 31, (24, 25)),
        (inner - 32, (24, 24)),
    ):
        assert counted((outer, inner), extra) == expected, extra


def test_small_rings_and_uneven_light_are_told_as_less_sure():
    for radius_px, expected in ((40, 1085), (30, 1155), (20, 1350), (10, 2400), (6, 4886)):
        assert abs(uncertainty.with_few_pixels(1000, radius_px << 8) - expected) <= 5, radius_px
    assert uncertainty.with_few_pixels(1 << 21, 1300) == 1 << 20

    class Lines:
        line = array("i", [0] * layouts.CROSSING_ITEMS)

    def turned(area):
        Lines.line[layouts.CROSSING_AREA] = area
        return uncertainty.sigma_mdeg(400, Lines, 7680)

    assert turned(276) == turned(236) == turned(256) < turned(290) < turned(336) < turned(400)
    # the square of what is darker counts five times that of what is paler: 60 * 60 * 5 = 134.2 * 134.2
    assert turned(236 - 134) < turned(276 + 60) < turned(236 - 135)


def sectors(left_q10, other_q10=0, depth=400, turn=2):
    """The work of a robust fit that has not moved yet: one sector is so far off, all others so far."""
    work, fit = array("i", bytes(4 * layouts.ROBUST_ITEMS)), array("i", bytes(4 * layouts.FIT_ITEMS))
    fit[layouts.FIT_AREA] = 400
    outer, inner = [array("i", [32768 + other_q10] * 16 + [depth] * 16) for _ in range(2)]
    outer[3] = 32768 + left_q10
    assert robust.begin_robust(work, fit, outer, inner) == 32
    robust.weigh_sectors(0, 0, 0, work, tables.SECTOR_WAVES, 683, turn)
    return work


def test_sectors_of_the_common_centre_count_by_their_distance():
    for other_q10, left_q10, scale, weight in (
        (0, 30, 8, 12),  # the least spread, five of them
        (0, 20, 8, 36),
        (0, 40, 8, 0),
        (20, 85, 34, 36),  # the spread is 1.7 medians
    ):
        work = sectors(left_q10, other_q10)
        assert (work[layouts.ROBUST_SCALE], work[layouts.ROBUST_WEIGHTS + 3]) == (scale, weight), left_q10
    for left_q10, believed in ((511, 511), (600, 511), (-600, -511)):
        assert sectors(left_q10)[layouts.ROBUST_LEFT + 3] - BIAS == believed
    for depth, weight in ((400, 64), (200, 16), (80, 2), (40, 1), (1, 1)):
        assert sectors(0, depth=depth)[layouts.ROBUST_BASES + 3] == weight, depth


def test_what_rings_cost_that_are_unevenly_deep():
    """With the square of their first harmonic, and of what jumps from sector to sector."""

    def variance(depths):
        means = array("i", bytes(64)) + array("i", depths)
        return robust.uneven_depths(0, 0, 0, tables.WAVES, 256, means, means)

    assert variance([256] * 16) == 0
    assert variance([256, 208] * 8) == 48 * 48 // 24
    waved = variance([256 + (100 * fixed.cos_q14(4096 * sector + 2048) >> 14) for sector in range(16)])
    assert abs(waved - 296) < 12, waved  # 870/16384 of twice 800 * 800 / 256, and 31 of steps


def test_sectors_that_determine_the_common_centre():
    class Seen:
        radius_q8 = 7680
        fit = array("i", bytes(4 * layouts.FIT_ITEMS))
        outer = inner = array("i", bytes(4 * layouts.RING_ITEMS))

    for outer, inner, is_determined in ((8, 6, True), (7, 7, True), (7, 6, False), (8, 5, False)):
        Seen.fit[layouts.FIT_AREA], Seen.fit[layouts.FIT_INNER_Q10] = 400, 682
        Seen.outer_means, Seen.inner_means = [array("i", [0] * 16 + [400] * 16) for _ in range(2)]
        for means, count in ((Seen.outer_means, outer), (Seen.inner_means, inner)):
            for k in range(count):
                means[16 * k // count] = 32768
        centre = RobustCentre(array("i", bytes(4 * layouts.ROBUST_ITEMS)))
        assert centre.fit(Seen) == is_determined, (outer, inner)


def matrix(slope):
    """Eight parameters, of which the first two are determined together by so much."""
    work = array("i", [BIAS] * 240)
    for row in range(8):
        work[layouts.ROBUST_MATRIX + row * 9] = BIAS + 2400
    work[layouts.ROBUST_MATRIX + 8] = BIAS + slope
    return work


def test_sectors_that_do_not_determine_the_robust_centre():
    # 102 and 100 of 2400 are left of the second parameter
    assert robust.factor_matrix(0, 0, 0, matrix(2349)) == 1
    assert robust.factor_matrix(0, 0, 0, matrix(2350)) == 0


def test_shares_of_a_variance_have_a_limit():
    def variance(beyond):
        return robust.variance_of(0, 0, 0, matrix(0), 0, beyond)

    own, most = 4096 * 256 // 2400, (30000 * 30000 >> 12) * 256 // 2400
    assert variance(937) == own + (29984 * 29984 >> 12) * 256 // 2400
    assert variance(938) == variance(1000) == variance(-1000) == own + most


class Moves:
    """Stands for the kernels of the robust centre: how far each step moves; kinds of weights are noted."""

    def __init__(self, *moves):
        self.moves = list(moves)
        self.kinds = []

    def begin_robust(self, *arguments):
        return 32

    def weigh_sectors(self, a, b, c, work, waves, ratio, kind):
        self.kinds.append(kind)
        work[layouts.ROBUST_SCALE], work[layouts.ROBUST_SQUARE] = 8, 64
        return 2048

    def normal_equations(self, *arguments):
        return 1

    factor_matrix = normal_equations

    def solve_step(self, *arguments):
        return self.moves.pop(0)

    def variance_of(self, *arguments):
        return 0


def test_how_many_steps_lead_to_the_robust_centre():
    class Seen:
        radius_q8 = 7680
        fit = array("i", bytes(4 * layouts.FIT_ITEMS))
        outer = inner = array("i", [100] * layouts.RING_ITEMS)
        outer_means = inner_means = None

    kept = robust_centre.kernels
    try:
        # two from which no outlier is left out, one or two from which they are, and what ends it
        for moves, kinds in (((0, 0, 64), [0, 1, 2, 2]), ((0, 0, 65, 9999), [0, 1, 2, 2, 2])):
            robust_centre.kernels = told = Moves(*moves, 0)
            centre = RobustCentre(array("i", [BIAS] * layouts.ROBUST_ITEMS))
            assert centre.fit(Seen)
            assert told.kinds == kinds and told.moves == [], moves
    finally:
        robust_centre.kernels = kept
