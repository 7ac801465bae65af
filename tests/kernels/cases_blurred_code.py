"""Calls of the kernels in larics.kernels.blurred_code."""

from array import array

from blurred import BLURS, bars_of, fan
from inputs import ints, words

from larics.arith.fixed import COSINE
from larics.kernels import blurred_lines

REACH = 31
BIAS = 65536
CODE = fan(64, 4, 0, 4, 9)
ZONES = array("i", (0, 4, 0, 4, 5, 0))


def code_templates(sigma, motion):
    """Templates of 4 axes in 2 zones."""
    bars = bars_of(sigma, motion)
    templates = array("H", bytes(2 * 33 * 8))
    for axis in range(4):
        for zone in range(2):
            blurred_lines.line_template(
                bars, 0, 0, axis * 96, 2150, COSINE, CODE, ZONES, 3 * zone, templates, 33 * (2 * axis + zone)
            )  # fmt: skip
    return templates


def fit_code(random):
    for sigma, motion in BLURS:
        for low, high in ((32768 - 8191, 32768 + 8191), (32700, 33500)):
            for axes, reach in ((1, REACH), (4, REACH), (4, 9)):
                yield (
                    words(128, random, low, high), 0, 0, code_templates(sigma, motion), axes, reach,
                    ints(81, random), ints(9, random), 16, ints(10, random),
                )  # fmt: skip


def code_residuals(random):
    for sigma, motion in BLURS:
        for low, high in ((32768 - 2047, 32768 + 2047), (32700, 33500)):
            for axes, reach in ((1, REACH), (4, REACH), (4, 1)):
                yield (
                    words(128, random, low, high), 0, 0, code_templates(sigma, motion), axes, reach,
                    ints(9, random, BIAS - 1023, BIAS + 1023), ints(9, random),
                )  # fmt: skip


CASES = {"fit_code": fit_code, "code_residuals": code_residuals}
