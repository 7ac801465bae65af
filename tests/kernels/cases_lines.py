"""Calls of the kernels in larics.kernels.lines."""

from cases_rings import fit
from inputs import frames, ints, zeros32

from larics.arith import fixed

WIDTH, HEIGHT = 72, 60


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
            shape = zeros32(4)
            for i, value in enumerate((first, last, gap, line)):
                shape[i] = value
            yield (
                0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, WIDTH, HEIGHT, pose, shape, turn16,
                1 + (turn16 & 1), ints(32, random, 0, 2 * area), ints(11, random),
            )  # fmt: skip


def line_end(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for x, y, turn16, radius, shape in (
            (36 * 1024, 30 * 1024, 0, 4000, (1300, 1638, 126)),
            (36 * 1024 + 700, 30 * 1024 + 9, 11111, 3000, (1100, 1200, 100)),
            (0, 59 * 1024, 65535, 20480, (2047, 2047, 511)),
            (-300, -5, 40000, 20480, (2047, 2047, 511)),
        ):
            sizes = zeros32(7)
            for i in range(3):
                sizes[4 + i] = shape[i]
            pose = fit(true_x_q10=x, true_y_q10=y, radius_q8=radius)
            yield 0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, WIDTH, HEIGHT, pose, sizes, turn16


CASES = {
    "line_crossings": line_crossings,
    "line_end": line_end,
}
