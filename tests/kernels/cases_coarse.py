"""Calls of the kernels in larics.kernels.coarse."""

from inputs import ints, random_bytes, zeros32

from larics.arith import fixed
from larics.kernels import layouts

DIRECTIONS = 48


def radii(**items):
    """A range of radii: items by their names in lower case."""
    found = zeros32(layouts.RADII_ITEMS)
    for name in items:
        found[getattr(layouts, "RADII_" + name.upper())] = items[name]
    return found


def edge_distances(random):
    for width, height, cx, cy, reach, half_line, slack in (
        (80, 60, 640, 480, 500, 16, 24),
        (80, 60, 0, 959, 4096, 256, 400),
        (1024, 1024, 16384, 16384, 4096, 0, 64),
        (1024, 1024, 0, 0, 1, 1, 1),
    ):
        count = 250
        edges = zeros32(count)
        for i in range(count):
            # half of them near the corner where the farthest centre is
            position = width * height - 1 - random.below(width) if i & 1 else random.below(width * height)
            edges[i] = position | random.below(DIRECTIONS) << 20
        for capacity in (count, 20):
            scale = radii(
                width=width, reach_q4=reach, half_line_q4=half_line, slack_q4=slack, capacity=capacity
            )  # fmt: skip
            yield 0, 0, edges, 0, count, scale, cx, cy, fixed.AXES, ints(capacity, random)


def choose_radius(random):
    for first, last, bins, inner_q10, count, rounds in (
        (6, 29, 32, 683, 300, 1),
        (20, 117, 120, 640, 40, 4),
        (6, 6, 9, 700, 0, 2),
    ):
        distances = zeros32(count + 1)
        for i in range(count):
            distances[i] = random.below(8 * bins) | random.below(DIRECTIONS) << 16
        scale = radii(first=first, last=last, bins=bins, inner_q10=inner_q10)
        yield 0, 0, random_bytes(bins, random), scale, distances, count, fixed.AXES, rounds, ints(5, random)
    # a frame has far fewer edges of one direction at one distance than this
    for direction in (0, 12, 24, 36):
        distances = zeros32(1000)
        for i in range(1000):
            distances[i] = (60 * 8 + 4 + 40) | direction << 16
        scale = radii(first=30, last=90, bins=100, inner_q10=683)
        yield 0, 0, bytearray(100), scale, distances, 1000, fixed.AXES, 4, zeros32(5)


CASES = {
    "edge_distances": edge_distances,
    "choose_radius": choose_radius,
}
