"""Calls of the kernels in larics.kernels.polar."""

from array import array

from blurred import BLURS, KINDS, bars_of, fan, grey_samples, templates_of
from inputs import frames, ints, words

from larics.arith.fixed import COSINE
from larics.kernels.layouts import BIAS

WIDTH, HEIGHT = 72, 60


def pose(x_q8, y_q8, radius_q8, e1=0, e2=0, hx=0, hy=0):
    """layouts.CIRCLE"""
    x_q8, y_q8, e1, e2, hx, hy = [value + BIAS for value in (x_q8, y_q8, e1, e2, hx, hy)]
    return array("i", (x_q8, y_q8, radius_q8, e1, e2, hx, hy, WIDTH, HEIGHT))


def scan(first, pitch, count, least=0, last=0, reference=0):
    """layouts.SCAN"""
    return array("i", (first, pitch, count, least, last, reference))


def polar_samples(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for cx, cy, radius, e1, e2, hx, hy, first, count, directions, step in (
            (36 * 256, 30 * 256, 14 * 256, 0, 0, 0, 0, 13, 16, 64, 4),
            (36 * 256 + 77, 30 * 256 + 201, 13 * 256 + 9, 3500, -2000, -3500, 900, 28, 8, 29, 2),
            (36 * 256, 30 * 256, 5 * 256, -4096, 4096, 4096, -4096, 4, 9, 64, 4),
            (36 * 256, 30 * 256, 96 * 256, 0, 0, 0, 0, 13, 16, 64, 4),
            (100, 30 * 256, 14 * 256, 0, 0, 0, 0, 0, 20, 64, 4),
        ):
            samples = words(directions * count, random)
            place = pose(cx, cy, radius, e1, e2, hx, hy)
            where = fan(directions, step, 228, first, count)
            yield 0, 0, frame, 0, place, where, COSINE, 15137, 6270, samples


def circle_samples(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for cx, cy, least, last in (
            (36 * 256, 30 * 256, 2000, 4800),
            (27 * 256 + 77, 31 * 256 + 201, 300, 400),
        ):
            samples = words(32 * 256, random)
            for wanted in (255, 0b10000011):
                sizes = scan(0, 0, 0, least, last)
                yield 0, 0, frame, WIDTH, cx, cy, COSINE, 32, wanted, sizes, array("H", samples)


def mean_samples(random):
    for kind in KINDS:
        for sectors, count, apart in ((32, 16, 16), (8, 24, 24), (32, 16, 0)):
            samples = grey_samples(kind, 2 * sectors * count, random)
            yield 0, 0, samples, apart, sectors, count, words((count + 1) * sectors, random)


def sector_radii(random):
    for kind in KINDS:
        for sigma, motion in BLURS:
            templates, sums = templates_of(bars_of(sigma, motion))
            for sector, hop, whole in ((0, 2, 0), (4, 8, 500)):
                yield (
                    0, 0, words(48, random), grey_samples(kind, 32 * 48, random),
                    scan(12 * 64, 64, 48, 24 * 64, 36 * 64, 30 * 64), templates, sums, 150, ints(32, random),
                    sector, hop, whole,
                )  # fmt: skip


def line_shade(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for place in (
            pose(36 * 256, 30 * 256, 20 * 256),
            pose(36 * 256 + 77, 30 * 256 + 201, 16 * 256 + 9, 1500, -2000),
            pose(34 * 256, 29 * 256, 5 * 256, -3500, 3500),
            pose(300, 30 * 256, 14 * 256),
        ):
            yield frame, 0, 0, place, COSINE, ints(128, random)


CASES = {
    "polar_samples": polar_samples,
    "circle_samples": circle_samples,
    "mean_samples": mean_samples,
    "sector_radii": sector_radii,
    "line_shade": line_shade,
}
