"""Calls of the kernels in larics.kernels.sectors."""

from array import array

from blurred import BLURS, KINDS, bars_of, means_of, templates_of
from inputs import ints, words

from larics.arith.fixed import COSINE
from larics.kernels.layouts import STILL

ZERO = 1 << 20


def ring_shifts(random):
    for kind in KINDS:
        for sigma, motion in BLURS:
            templates, sums = templates_of(bars_of(sigma, motion))
            for radius, least_match in ((6 * 256, 300), (24000, 0)):
                yield (
                    0, 0, means_of(kind, 32, random), templates, sums, 7 if motion else STILL, radius, 3072,
                    least_match, ints(32, random), ints(32, random), words(96, random),
                )  # fmt: skip


def shift_harmonics(random):
    for reach in (10, 900, 30000):
        shifts = array("i", [ZERO - reach + random.below(2 * reach + 1) for _ in range(32)])
        yield 0, 0, shifts, COSINE, 5, 96, ints(7, random)
        gaps = array("i", [value if index & 1 else 0 for index, value in enumerate(shifts)])
        yield 0, 0, gaps, COSINE, 8, 0, ints(7, random)
    yield 0, 0, array("i", bytes(128)), COSINE, 5, 96, ints(7, random)


def median(random):
    for low, high in ((0, 65535), (7, 7), (100, 103)):
        yield words(96, random, low, high), 0, 0, 32, 32, words(32, random)


def sector_levels(random):
    for low, high, local in ((0, 65535, 1), (0, 65535, 0), (500, 1024, 1)):
        for amplitude in (0, 900, 16383):
            yield (
                words(96, random, low, high), 0, 0, amplitude, 2000, 640, 4, local, words(64, random)
            )  # fmt: skip


CASES = {
    "ring_shifts": ring_shifts,
    "shift_harmonics": shift_harmonics,
    "median": median,
    "sector_levels": sector_levels,
}
