"""Calls of the kernels in larics.kernels.blurred_lines."""

from array import array

from blurred import BLURS, KINDS, bars_of, fan, grey_samples
from inputs import ints, words

from larics.arith.fixed import COSINE
from larics.kernels.layouts import STILL

TURN = fan(128, 2, 0, 28, 8)
AROUND = fan(29, 2, 228, 28, 8)
CODE = fan(64, 4, 0, 4, 9)
ZONES = array("i", (0, 8, 0, 0, 8, 2, 0, 4, 0, 4, 5, 0))


def line_template(random):
    for sigma, motion in BLURS:
        bars = bars_of(sigma, motion)
        yield bars, 0, 0, 5 * 24, 7782, COSINE, AROUND, ZONES, 0, words(40, random), 15
        yield bars, 0, 0, 0, 2150, COSINE, CODE, ZONES, 6, words(33, random), 0
        yield bars, 0, 0, 24, 2150, COSINE, CODE, ZONES, 9, words(33, random), 0


def erase_line(random):
    for kind in KINDS:
        for sigma, motion in BLURS:
            for cosine, sine in ((16384, 0), (-11585, 11585)):
                yield (
                    grey_samples(kind, 64 * 16, random), 0, 0, 3 * 24, 7782, bars_of(sigma, motion), COSINE,
                    fan(64, 4, 2, 13, 16), cosine, sine, 16383, 5887,
                )  # fmt: skip


def ink_profile(random):
    for kind in KINDS:
        for sigma, motion in BLURS:
            for levels in (words(64, random, 0, 16383), words(64, random, 1500, 2000)):
                yield (
                    grey_samples(kind, 128 * 8, random), 0, 0, TURN, ZONES, 3, levels, -31,
                    bars_of(sigma, motion), 15 if motion else STILL, words(130, random), words(17, random),
                )  # fmt: skip


def line_depths(random):
    for low, high in ((32768 - 8191, 32768 + 8191), (32700, 32900), (33768, 33768)):
        for motion_axis in (25, STILL):
            ink = words(128, random, low, high)
            templates = words(15 * 17, random, 0, 1024)
            yield 0, 0, ink, TURN, templates, 77, motion_axis, 0, 127, words(128, random)


def deepest(random):
    for low, high in ((0, 65535), (32768, 32768), (16385, 49151)):
        yield words(128, random, low, high), 0, 0, 128, 10, ints(3, random)


def line_residual(random):
    for low, high in ((32768 - 8191, 32768 + 8191), (32700, 32900), (33768, 33768)):
        for depth in (-16383, 0, 250, 16383):
            yield words(29, random, low, high), 0, 0, words(30, random, 0, 1024), 15, 14, 14, depth


def ink_noise(random):
    for low, high in ((32768 - 8191, 32768 + 8191), (32700, 32900), (33768, 33768)):
        yield words(128, random, low, high), 0, 0, 128, 1
        yield words(128, random, low, high), 0, 0, 128, 4


def line_turn(random):
    for low, high in ((32768 - 8191, 32768 + 8191), (32700, 32900), (33768, 33768)):
        yield words(29, random, low, high), 0, 0, words(30, random, 0, 1024), 15, 13, 14, ints(1, random)


CASES = {
    "line_template": line_template,
    "erase_line": erase_line,
    "ink_profile": ink_profile,
    "line_depths": line_depths,
    "deepest": deepest,
    "line_residual": line_residual,
    "ink_noise": ink_noise,
    "line_turn": line_turn,
}
