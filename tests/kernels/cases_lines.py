"""Calls of the kernels in larics.kernels.lines."""

from inputs import frames, ints, words

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
        for cx, cy, turn16, first, last, window, half_line, clip, least in (
            (36 * 256, 30 * 256, 0, 2560, 6000, 900, 128, 10, 100),
            (36 * 256 + 99, 30 * 256 + 3, 8192, 3600, 7000, 3584, 500, 0, 0),
            (71 * 256, 0, 40000, 2000, 32768, 256, 0, 40, 0),
            (20 * 256, 59 * 256, 16384, 1500, 9000, 512, 64, 0, 2000),
            (36 * 256, 10 * 256, 50000, 1600, 6000, 1500, 300, 3, 5),
            (36 * 256, 30 * 256, 60001, 4000, 256, 600, 100, 3, 5),
        ):
            yield (
                0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, WIDTH, HEIGHT, cx, cy, turn16, first, last,
                window, half_line, clip, least, ints(7, random),
            )  # fmt: skip


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
    "code_positions": code_positions,
}
