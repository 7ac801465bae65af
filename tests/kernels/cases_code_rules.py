"""Calls of the kernels in larics.kernels.code_rules."""

from cases_rules import poses
from inputs import ints, zeros32

from larics.kernels import code_rules as kernels
from larics.kernels.layouts import BIAS, LIGHT_ITEMS, POSITION_ITEMS


def code_rules(random):
    for pose, _, _ in poses(random):
        for area in (100, 300, 8000000):
            code = zeros32(8 * POSITION_ITEMS)
            for i in range(8 * POSITION_ITEMS):
                code[i] = (
                    BIAS + random.between(-area, area) if i % POSITION_ITEMS in (2, 3) else random.below(area)
                )
            light = zeros32(LIGHT_ITEMS)
            kernels.code_light(light, code)
            yield zeros32(12), code, light, pose, ints(32, random, 0, 60000), random.below(65536)


def code_light(random):
    for largest in (0, 300, 1060, 8000000):
        code = zeros32(8 * POSITION_ITEMS)
        for i in range(8 * POSITION_ITEMS):
            code[i] = (
                BIAS + random.between(-largest, largest)
                if i % POSITION_ITEMS in (2, 3)
                else random.below(largest + 1)
            )
        yield ints(LIGHT_ITEMS, random), code


CASES = {
    "code_light": code_light,
    "code_rules": code_rules,
}
