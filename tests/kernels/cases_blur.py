"""Calls of the kernels in larics.kernels.blur."""

from blurred import BLURS, KINDS, LINE_Q8, RAMP, bars_of, means_of, templates_of
from inputs import ints, words


def blurred_bar(random):
    for width in (1, LINE_Q8, 3277, 16384):
        for sigma, motion in ((128, 0), (610, 0), (1332, 3072), (200, 2176), (1, 16384), (16384, 1)):
            yield RAMP, 0, 0, width, motion, sigma, 3, 24, words(30, random)


def ring_template(random):
    for sigma, motion in BLURS:
        for kinds in (1, 3):
            yield bars_of(sigma, motion), 0, 0, 72, words(96, random), 48, ints(16, random), 8, kinds
    yield words(24, random, 0, 1024), 0, 0, 0, words(48, random), 0, ints(8, random), 0, 3


def match_sectors(random):
    for kind in KINDS:
        for sigma, motion in BLURS:
            templates, sums = templates_of(bars_of(sigma, motion))
            yield means_of(kind, 16, random), 0, 0, 16, templates, sums, 4, 17, words(16 * 17, random)


def best_direction(random):
    for direction, pitch in ((2, 4), (0, 2), (5, 32)):
        yield words(16 * 17, random, 0, 1024), 0, 0, 16, 4, 2, 512, direction, pitch, ints(1, random)


def match_direction(random):
    for kind in KINDS:
        for sigma, motion in BLURS:
            templates, sums = templates_of(bars_of(sigma, motion))
            yield means_of(kind, 16, random), 0, 0, 16, 4, 2, templates, sums, 6, 0 if motion else 1, 512


CASES = {
    "blurred_bar": blurred_bar,
    "ring_template": ring_template,
    "match_sectors": match_sectors,
    "best_direction": best_direction,
    "match_direction": match_direction,
}
