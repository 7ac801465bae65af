"""Calls of the kernels in larics.kernels.rules."""

from cases_rings import fit
from inputs import ints, zeros32

from larics.kernels.layouts import BIAS, RING_DEVIATION, RING_INSIDE, RING_MEAN_AREA, RING_USED


def weakest_rule(random):
    for low in (-1, 0, 1, 3000):
        for count in (0, 1, 6):
            written = zeros32(12)
            for i in range(6):
                written[2 * i] = BIAS + low + random.below(8000000 if low == 3000 else 100)
                written[2 * i + 1] = 1 + random.below(200)
            yield written, 255, count


def _harmonics(random, inside):
    ring = ints(9, random, BIAS - 3000, BIAS + 3000)
    ring[RING_DEVIATION] = random.below(600)
    ring[RING_USED] = random.below(inside + 1)
    ring[RING_INSIDE] = inside
    ring[RING_MEAN_AREA] = random.below(60000)
    return ring


def poses(random):
    for radius in (1536, 7680, 20480):
        for inside in (0, 9, 16):
            pose = fit(
                radius_q8=radius, inner_q8=radius * 2 // 3, area=30000,
                bulge_cos=random.between(-radius, radius), bulge_sin=random.between(-300, 300),
            )  # fmt: skip
            yield pose, _harmonics(random, inside), _harmonics(random, inside)


def rings_plausible(random):
    for pose, outer, inner in poses(random):
        yield pose, outer, inner, 480


def rings_rules(random):
    for pose, outer, inner in poses(random):
        yield zeros32(12), pose, outer, inner, 2, 6, 94, 30


def line_rules(random):
    for radius in (1536, 20480):
        yield zeros32(14), ints(10, random, 0, 600), random.below(256), radius, 0
        yield zeros32(14), ints(10, random, 0, 8000000), 256, radius, 1024


CASES = {
    "weakest_rule": weakest_rule,
    "rings_plausible": rings_plausible,
    "rings_rules": rings_rules,
    "line_rules": line_rules,
}
