"""What the kernels of the blur-model reader hand to each other, made by the kernels themselves."""

from array import array

from inputs import words

from larics.arith.fixed import COSINE, table16
from larics.arith.tables import RAMP_Q12
from larics.kernels import blur, polar
from larics.kernels.layouts import ALONG, BAR, RELS

RAMP = table16(RAMP_Q12)
LINE_Q8 = 717
BLURS = ((128, 0), (610, 0), (1332, 3072), (200, 2176))  # sigma, motion


def bars_of(sigma, motion):
    """Bars for 17 rels and the one along a line."""
    bars = array("H", bytes(2 * (ALONG + BAR)))
    blur.blurred_bars(0, 0, RAMP, LINE_Q8, motion, sigma, COSINE, 0, 1, BAR, 0, bars)
    blur.blurred_bars(0, 0, RAMP, 2253, motion, sigma, COSINE, 5, RELS, BAR, ALONG, bars)
    return bars


def templates_of(bars):
    """Templates and their sums for 17 rels."""
    templates = array("H", bytes(2 * 48 * RELS))
    sums = array("i", bytes(4 * 8 * RELS))
    blur.ring_templates(bars, 0, 0, 0, 1, templates, sums)
    return templates, sums


def folded_of(bars):
    """The same, folded."""
    templates = array("H", bytes(2 * 48 * RELS))
    sums = array("i", bytes(4 * 8 * RELS))
    blur.fold_templates(bars, 0, 0, 0, 1, templates, sums)
    return templates, sums


def fan(directions, step, start, first, count):
    """layouts.FAN"""
    return array("i", (directions, step, start, first, count))


def grey_samples(kind, count, random):
    """array('H') of `count` greys * 16: noise, extremes, flat, or two rings of 16 samples a direction."""
    if kind == "noise":
        return words(count, random, 0, 4080)
    if kind == "extremes":
        return array("H", [4080 * random.below(2) for _ in range(count)])
    if kind == "flat":
        return array("H", [2000] * count)
    dark = (8, 40, 80, 40, 8, 0, 0, 0, 0, 8, 40, 80, 40, 8, 0, 0)
    return array("H", [4080 - 50 * dark[i & 15] + random.below(80) for i in range(count)])


KINDS = ("noise", "extremes", "flat", "rings")


def means_of(kind, sectors, random):
    """Means of `sectors` sectors of 2 directions, as polar.mean_samples writes them."""
    samples = grey_samples(kind, sectors * 32, random)
    means = array("H", bytes(2 * (sectors * 17)))
    polar.mean_samples(0, 0, samples, 16, sectors, 16, means)
    return means


def folds_of(kind, random):
    """Pairs of 32 sectors folded, and their powers."""
    folds = array("H", bytes(2 * 160))
    powers = array("i", bytes(4 * 16))
    blur.fold_sectors(0, 0, means_of(kind, 32, random), 16, folds, powers)
    return folds, powers
