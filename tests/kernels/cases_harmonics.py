"""Calls of the kernels in larics.kernels.harmonics."""

from cases_rings import fit
from inputs import ints, zeros32

from larics.arith import tables
from larics.kernels import layouts


def end_pass(random):
    for span, deviation in ((0, 0), (1000, 100), (1499, 4096), (4000, 500), (4096, 4096)):
        found = []
        for sign in (1, -1):
            ring = zeros32(9)
            for i in range(5):
                ring[i] = layouts.BIAS + sign * span
            ring[layouts.RING_DEVIATION] = deviation
            ring[layouts.RING_MEAN_AREA] = 60000
            found.append(ring)
        for radius in (1536, 20480):
            pose = fit(x_q8=2560, y_q8=0, radius_q8=radius, inner_q8=radius * 2 // 3, bulge_cos=-8192)
            yield pose, found[0], found[1]
            yield fit(radius_q8=radius), found[1], found[1]


def ring_harmonics(random):
    def call(sectors, rounds, floor):
        return (
            0, 0, 0, sectors, ints(32, random), ints(32, random), tables.HARMONICS_4, rounds, floor,
            ints(9, random), ints(9, random),
        )  # fmt: skip

    for largest, rounds, floor in (
        (300, 1, 100),
        (4096, 8, 300),
        (32767, 5, 1),
        (32767, 8, 40000),
        (0, 3, 1),
    ):
        sectors = zeros32(128)
        for sector in range(32):
            tried = random.between(0, 255)
            counted = random.between(0, tried)
            residual = random.between(-largest, largest)
            if sector & 1:  # a wave of the first two harmonics
                residual = largest if sector % 8 < 4 else -largest
                counted = tried
            sectors[4 * sector] = tried
            sectors[4 * sector + 1] = tried * random.between(0, 60000)
            sectors[4 * sector + 2] = counted
            sectors[4 * sector + 3] = counted * (32768 + residual)
        yield call(sectors, rounds, floor)
    # square waves of each harmonic, which make the largest sums
    for period in (8, 4):
        sectors = zeros32(128)
        for sector in range(32):
            sectors[4 * sector] = sectors[4 * sector + 2] = 1
            sectors[4 * sector + 3] = 65535 if sector // period & 1 else 1
        yield call(sectors, 8, 40000)
    # sectors that agree, where the second round is the last; and none
    sectors = zeros32(128)
    for sector in range(32):
        sectors[4 * sector] = sectors[4 * sector + 2] = 3
        sectors[4 * sector + 3] = 3 * (32768 + random.between(-40, 40))
    yield call(sectors, 4, 96)
    yield call(zeros32(128), 4, 100)


CASES = {
    "end_pass": end_pass,
    "ring_harmonics": ring_harmonics,
}
