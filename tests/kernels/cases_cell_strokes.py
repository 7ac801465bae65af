"""Calls of the kernels in larics.kernels.cell_strokes."""

from cases_cells import HEIGHT, WIDTH, _poses
from inputs import frames, ints

from larics.arith import fixed
from larics.kernels.layouts import BIAS


def stroke_cost(random):
    for number, frame in enumerate(frames(WIDTH, HEIGHT, random)):
        for pose in _poses(random):
            weights = ints(28, random, BIAS - 64, BIAS + 64)
            weights[24] = 700
            weights[25] = random.below(1536)
            weights[26] = random.below(1 << 24) & random.below(1 << 24) & random.below(1 << 24)
            if number == 0:
                weights[26] = random.below(2) * 511
            depths = ints(72, random, 500, 900)
            for cell in range(24):
                depths[cell] = random.below(5) and BIAS + random.between(-100, 400)
            yield 0, 0, frame, fixed.LOG_GREY, pose, depths, weights, ints(24, random)


CASES = {"stroke_cost": stroke_cost}
