"""Calls of the kernels in larics.kernels.robust."""

from cases_rings import fit
from inputs import ints, zeros32

from larics.arith import tables
from larics.kernels import robust
from larics.kernels.layouts import (
    BIAS,
    ROBUST_ITEMS,
    ROBUST_PARAMETERS,
)

RATIOS = (683, 512, 900)


def _means(random, largest, missing):
    """Residuals of 16 sectors, and their areas, some of them missing."""
    means = zeros32(32)
    for i in range(16):
        if random.below(100) >= missing:
            means[i] = 32768 + random.between(-largest, largest)
            means[16 + i] = 1 + random.below(1200)
    return means


def _begun(random, largest, missing):
    work = ints(ROBUST_ITEMS, random)
    robust.begin_robust(
        work, fit(area=400), _means(random, largest, missing), _means(random, largest, missing)
    )
    return work


def _weighed(random, largest, missing, ratio, turn):
    work = _begun(random, largest, missing)
    for i in range(8):
        work[ROBUST_PARAMETERS + i] = BIAS + random.between(-4 * largest, 4 * largest)
    robust.weigh_sectors(0, 0, 0, work, tables.SECTOR_WAVES, ratio, turn)
    return work


def _factored(random, largest, missing, ratio):
    work = _weighed(random, largest, missing, ratio, 2)
    robust.normal_equations(work, 0, 0, ratio, 300, 4000)
    robust.factor_matrix(0, 0, 0, work)
    return work


def begin_robust(random):
    for area in (0, 1, 400, 60000):
        for missing in (0, 30, 100):
            yield (
                ints(ROBUST_ITEMS, random),
                fit(area=area),
                _means(random, 500, missing),
                _means(random, 32767, missing),
            )


def weigh_sectors(random):
    for largest in (0, 40, 511, 32767):
        for missing, turn in ((0, 0), (20, 1), (50, 2), (100, 2)):
            work = _begun(random, largest, missing)
            for i in range(8):
                # eight steps of half a pixel at most
                work[ROBUST_PARAMETERS + i] = BIAS + random.between(-65536, 65536)
            yield 0, 0, 0, work, tables.SECTOR_WAVES, RATIOS[turn], turn


def normal_equations(random):
    for largest, missing in ((40, 0), (511, 30), (32767, 100)):
        for ratio in RATIOS:
            for weight in (0, 4095, 8191):
                yield _weighed(random, largest, missing, ratio, 0), 0, 0, ratio, weight >> 1, weight


def factor_matrix(random):
    for largest, missing in ((40, 0), (511, 30), (511, 60), (32767, 100)):
        for ratio in RATIOS:
            work = _weighed(random, largest, missing, ratio, 2)
            robust.normal_equations(work, 0, 0, ratio, 100, 0)
            yield 0, 0, 0, work


def solve_step(random):
    for largest, missing in ((40, 0), (511, 20), (511, 0)):
        for ratio in RATIOS:
            yield 0, 0, 0, _factored(random, largest, missing, ratio)


def variance_of(random):
    for missing in (0, 20):
        for first in (2, 3, 4):
            for beyond in (0, 333, 1000):
                yield 0, 0, 0, _factored(random, 100, missing, 683), first, beyond if first < 4 else 0


def uneven_depths(random):
    for area in (1, 400, 60000):
        for missing in (0, 30, 100):
            yield (
                0,
                0,
                0,
                tables.WAVES,
                area,
                _means(random, 100, missing),
                _means(random, 100, missing),
            )


def root(random):
    for value in (0, 1, 2, 3, 4, 15, 16, 17, 32767**2 - 1, 32767**2, (1 << 30) - 1):
        yield value, 0, 0
    for _ in range(40):
        yield random.below(1 << 30) >> random.below(28), 0, 0


CASES = {
    "begin_robust": begin_robust,
    "weigh_sectors": weigh_sectors,
    "normal_equations": normal_equations,
    "factor_matrix": factor_matrix,
    "solve_step": solve_step,
    "variance_of": variance_of,
    "uneven_depths": uneven_depths,
    "root": root,
}
