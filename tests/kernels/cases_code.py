"""Calls of the kernels in larics.kernels.code."""

from cases_lines import shape
from cases_rings import fit
from inputs import frames, ints

from larics.arith import fixed
from larics.kernels import layouts

WIDTH, HEIGHT = 72, 60


def code_positions(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for cx, cy, turn16, radius, first, last, radii, window, line, opening in (
            (36 * 256, 30 * 256, 0, 4000, 200, 700, 8, 170, 119, 100),
            (36 * 256 + 50, 29 * 256 + 200, 12345, 4000, 100, 900, 16, 400, 119, 90),
            (10 * 256, 50 * 256, 33000, 1536, 170, 200, 2, 170, 34, 256),
            (71 * 256, 30 * 256, 60000, 20480, 170, 547, 4, 170, 200, 60),
        ):
            for area in (1, 700, 65535, 1 << 20):
                pose = fit(true_x_q10=cx * 4, true_y_q10=cy * 4, radius_q8=radius, area=area)
                lines = shape(
                    code_first=first, code_last=last, code_radii=radii, code_opening=opening, window=window,
                    line=line,
                )  # fmt: skip
                yield 0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, pose, lines, turn16, ints(48, random)


def seen(random):
    """Positions, most of which are as dark as a line."""
    return ints(48, random, layouts.BIAS + 60, layouts.BIAS + 400)


def stroke_beyond(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for cx, cy, turn16, radius, beyond, line in (
            (36 * 256, 30 * 256, 0, 4000, 853, 119),
            (36 * 256 + 50, 29 * 256 + 200, 12345, 3000, 853, 200),
            (-300, 50 * 256, 65535, 1536, 800, 34),
            (71 * 256, 30 * 256, 33000, 20480, 400, 119),
        ):
            for area in (0, 1, 700, 1 << 20):
                pose = fit(true_x_q10=cx * 4, true_y_q10=cy * 4, radius_q8=radius, area=area)
                lines = shape(beyond=beyond, line=line)
                yield 0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, pose, lines, turn16, seen(random)


CASES = {
    "code_positions": code_positions,
    "stroke_beyond": stroke_beyond,
}
