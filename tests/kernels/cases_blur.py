"""Calls of the kernels in larics.kernels.blur."""

from blurred import BLURS, KINDS, LINE_Q8, RAMP, bars_of, folded_of, folds_of, means_of
from inputs import ints, words

from larics.arith.fixed import COSINE
from larics.kernels.layouts import STILL


def blurred_bars(random):
    for width in (1, LINE_Q8, 3277, 16384):
        for sigma, motion in ((128, 0), (610, 0), (1332, 3072), (200, 2176), (16, 16384), (4096, 1)):
            yield 0, 0, RAMP, width, motion, sigma, COSINE, 0, 4, 14, 0, words(24 * 18, random)
            yield 0, 0, RAMP, width, motion, sigma, COSINE, 9, 17, 24, 17 * 24, words(24 * 18, random)


def ring_templates(random):
    for sigma, motion in BLURS:
        for first, step in ((0, 17), (1, 2)):
            bars = bars_of(sigma, motion)
            yield bars, 0, 0, first, step, words(48 * 17, random), ints(8 * 17, random)
    yield words(24, random, 0, 1024), 0, 0, 0, 17, words(48, random), ints(8, random)


def fold_templates(random):
    for sigma, motion in BLURS:
        bars = bars_of(sigma, motion)
        yield bars, 0, 0, 2, 4, words(48 * 17, random), ints(8 * 17, random)
    yield words(24, random, 0, 1024), 0, 0, 0, 17, words(48, random), ints(8, random)


def fold_sectors(random):
    for kind in KINDS:
        yield 0, 0, means_of(kind, 32, random), 16, words(160, random), ints(16, random)


def match_sectors(random):
    for kind in KINDS:
        folds, powers = folds_of(kind, random)
        for sigma, motion in BLURS:
            templates, sums = folded_of(bars_of(sigma, motion))
            yield 0, 0, folds, templates, 16, powers, sums, 0, 4, words(16 * 17, random)


def best_direction(random):
    for direction, pitch in ((2, 4), (0, 2), (5, 32)):
        yield 0, 0, words(16 * 17, random, 0, 1024), 16, 4, 2, 512, direction, pitch, ints(1, random)


def match_direction(random):
    for kind in KINDS:
        folds, powers = folds_of(kind, random)
        for sigma, motion in BLURS:
            templates, sums = folded_of(bars_of(sigma, motion))
            yield folds, 0, 0, templates, 16, powers, sums, 4, 2, 6 if motion else STILL, 512


CASES = {
    "blurred_bars": blurred_bars,
    "ring_templates": ring_templates,
    "fold_templates": fold_templates,
    "fold_sectors": fold_sectors,
    "match_sectors": match_sectors,
    "best_direction": best_direction,
    "match_direction": match_direction,
}
