"""Calls of the kernels in larics.kernels.lines."""

from cases_rings import fit
from inputs import frames, ints, zeros32

from larics.arith import fixed
from larics.kernels import layouts

WIDTH, HEIGHT = 72, 60


def shape(**items):
    """Where lines are looked for: items by their names in lower case."""
    lengths = zeros32(layouts.SHAPE_ITEMS)
    for name in items:
        lengths[getattr(layouts, "SHAPE_" + name.upper())] = items[name]
    return lengths


def line_crossings(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for cx, cy, turn16, radius, first, last, gap, line, area in (
            (36 * 256, 30 * 256, 0, 2560, 1024, 2047, 170, 120, 100),
            (36 * 256 + 99, 30 * 256 + 3, 8192, 5600, 1100, 1500, 170, 36, 1),
            (71 * 256, 0, 40000, 20480, 1100, 1600, 170, 205, 65535),
            (20 * 256, 59 * 256, 16384, 1536, 1100, 2000, 170, 120, 2000),
            (36 * 256, 10 * 256, 50000, 4000, 600, 1500, 300, 120, 5),
            (36 * 256, 30 * 256, 60001, 4000, 1024, 64, 150, 120, 700),
        ):
            pose = fit(true_x_q10=cx * 4, true_y_q10=cy * 4, radius_q8=radius, area=area)
            lengths = shape(line_first=first, line_last=last, window=gap, line=line)
            yield (
                0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, pose, lengths, turn16, 1 + (turn16 & 1),
                ints(32, random, 0, 2 * area), ints(11, random),
            )  # fmt: skip


def line_end(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for x, y, turn16, radius, in_line, beyond, beside in (
            (36 * 1024, 30 * 1024, 0, 4000, 1300, 1638, 126),
            (36 * 1024 + 700, 30 * 1024 + 9, 11111, 3000, 1100, 1200, 100),
            (0, 59 * 1024, 65535, 20480, 2047, 2047, 511),
            (-300, -5, 40000, 20480, 2047, 2047, 511),
        ):
            pose = fit(true_x_q10=x, true_y_q10=y, radius_q8=radius)
            lengths = shape(in_line=in_line, beyond=beyond, beside=beside)
            yield 0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, pose, lengths, turn16


CASES = {
    "line_crossings": line_crossings,
    "line_end": line_end,
}
