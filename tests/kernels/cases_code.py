"""Calls of the kernels in larics.kernels.code."""

from inputs import frames, ints

from larics.arith import fixed

WIDTH, HEIGHT = 72, 60


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
    "code_positions": code_positions,
}
