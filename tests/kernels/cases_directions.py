"""Calls of the kernels in larics.kernels.directions."""

from cases_lines import shape
from cases_rings import fit
from inputs import frames, ints, words

from larics.arith import fixed

WIDTH, HEIGHT = 72, 60


def annulus_profile(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for cx, cy, radius, first, last, samples, stride in (
            (36 * 256, 30 * 256, 15 * 256, 1024, 1400, 8, 1),
            (10 * 256 + 17, 50 * 256 + 240, 3000, 1024, 2047, 16, 2),
            (0, 0, 20480, 1600, 1620, 2, 4),
            (-1, 30 * 256, 3000, 1024, 1100, 3, 4),
        ):
            pose = fit(true_x_q10=cx * 4, true_y_q10=cy * 4, radius_q8=radius)
            around = shape(
                around_first=first, around_last=last, around_samples=samples, around_stride=stride
            )  # fmt: skip
            profile = words(256 // stride, random)
            yield 0, 0, frame, 0, fixed.LOG_GREY, fixed.COSINE, pose, around, profile


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


def quarter_phase(random):
    for directions, low, high in ((256, 0, 16800), (128, 0, 4180), (64, 16800, 16800), (128, 1, 1)):
        profile = words(directions, random, low, high)
        yield profile, 0, 0, fixed.COSINE, directions, ints(2, random)


CASES = {
    "quarter_phase": quarter_phase,
    "annulus_profile": annulus_profile,
    "dark_directions": dark_directions,
}
