"""Calls of the kernels in larics.kernels.evidence."""

from cases_rules import poses
from inputs import ints, words, zeros32

from larics.kernels.layouts import BIAS, CROSSING_ITEMS, LIGHT_ITEMS, POSITION_ITEMS

ZERO = 1 << 15


def profiles(random):
    """Profiles of 64 and 128 directions: noise, with strokes, with places beyond the frame."""
    for count in (64, 128):
        for kind in range(4):
            profile = words(count, random, 900, 940)
            for k in range(count):
                if kind == 1 and k % 23 < 3:
                    profile[k] -= 400
                elif kind == 2 and k % 29 == 5:
                    profile[k] += 700
                elif kind == 3 and k % 31 == 7:
                    profile[k] = 0
            yield count, profile


def stroke_depths(random):
    for count, profile in profiles(random):
        for unit in (1, 300):
            yield profile, 0, 0, count, 5, unit, words(count, random, 0, 65535)


def second_strokes(random):
    for count, _ in profiles(random):
        depths = words(count, random, ZERO - 50, ZERO + 50)
        yield depths, 0, 0, count, 10, ints(2, random)
    yield words(64, random, ZERO, ZERO), 0, 0, 64, 10, ints(2, random)


def positions(random, most):
    code = zeros32(8 * POSITION_ITEMS)
    for i in range(8 * POSITION_ITEMS):
        code[i] = (
            BIAS + random.between(-most, most) if i % POSITION_ITEMS in (2, 3) else random.below(most + 1)
        )
    return code


def bit_items(random):
    for pose, _, _ in poses(random):
        for most in (300, 65535):
            for bit in (1, 2, 3):
                yield (
                    zeros32(20), positions(random, most), ints(LIGHT_ITEMS, random, 0, 1000), pose,
                    ints(32, random, 0, 60000), words(64, random, 0, 65535),
                    words(64, random, 0, 65535), ints(2, random, 0, 4096), 64, random.below(65536), bit,
                )  # fmt: skip


def line_items(random):
    for pose, _, _ in poses(random):
        for most in (300, 65535):
            yield (
                zeros32(20), ints(CROSSING_ITEMS, random, 0, 1024), positions(random, most),
                ints(LIGHT_ITEMS, random, 0, 1000), pose, ints(32, random, 0, 60000),
                ints(32, random, 0, 60000), random.below(65536), random.below(1025),
            )  # fmt: skip


def weigh(random):
    for pairs in (0, 1, 5):
        items = ints(20, random, BIAS - 300, BIAS + 300)
        table = words(7 * max(1, pairs), random, 3796, 4396)
        for pair in range(pairs):
            table[7 * pair] = random.below(20) | random.below(20) << 8
        yield items, table, pairs


CASES = {
    "stroke_depths": stroke_depths,
    "second_strokes": second_strokes,
    "bit_items": bit_items,
    "line_items": line_items,
    "weigh": weigh,
}
