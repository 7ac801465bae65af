"""Calls of the kernels in larics.kernels.lines."""

from cases_rings import fit
from inputs import frames, ints, words, zeros32

from larics import fixed

WIDTH, HEIGHT = 72, 60


def annulus_profile(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for cx, cy, first, pitch, samples, stride in (
            (36 * 256, 30 * 256, 20 * 256, 200, 8, 1),
            (10 * 256 + 17, 50 * 256 + 240, 3000, 333, 16, 2),
            (0, 0, 32767, 256, 1, 4),
        ):
            yield (
                frame, 0, 0, 0, fixed.LOG_GREY, fixed.COSINE, WIDTH, HEIGHT, cx, cy, first, pitch, samples,
                stride, words(256 // stride, random),
            )  # fmt: skip


def dark_directions(random):
    for directions, near, far, apart, capacity, low, high in (
        (256, 10, 14, 10, 3, 1, 16800),
        (128, 5, 7, 5, 4, 0, 65535),
        (64, 2, 3, 63, 1, 0, 1),
        (64, 2, 3, 2, 30, 500, 500),
    ):
        yield (
            words(directions, random, low, high), 0, 0, directions, near, far, apart,
            words(directions, random), capacity, ints(2 * capacity, random),
        )  # fmt: skip


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
            pose = fit(true_x_q10=cx * 4, true_y_q10=cy * 4, radius_q8=radius)
            shape = zeros32(4)
            for i, value in enumerate((first, last, gap, line)):
                shape[i] = value
            yield (
                0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, WIDTH, HEIGHT, pose, shape, turn16, area,
                ints(10, random),
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


def code_positions(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for cx, cy, turn16, first, pitch, radii, window, opening, clip in (
            (36 * 256, 30 * 256, 0, 2000, 300, 8, 700, 100, 20),
            (36 * 256 + 50, 29 * 256 + 200, 12345, 1500, 150, 16, 1500, 90, 0),
            (10 * 256, 50 * 256, 33000, 256, 40, 2, 256, 256, 200),
            (71 * 256, 30 * 256, 60000, 3000, 900, 10, 500, 60, 5),
        ):
            for unit in (1, 700, 65535):
                yield (
                    0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, WIDTH, HEIGHT, cx, cy, turn16, first, pitch,
                    radii, window, opening, clip, unit, ints(40, random),
                )  # fmt: skip


CASES = {
    "annulus_profile": annulus_profile,
    "dark_directions": dark_directions,
    "line_crossings": line_crossings,
    "line_end": line_end,
    "code_positions": code_positions,
}
