"""Calls of the kernels in larics.kernels.directions."""

from inputs import frames, ints, words

from larics.arith import fixed

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


CASES = {
    "annulus_profile": annulus_profile,
    "dark_directions": dark_directions,
}
