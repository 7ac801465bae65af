"""Calls of the kernels in larics.kernels.edges."""

from inputs import frames, ints, pixels, view, words, zeros16, zeros32

from larics.arith import tables
from larics.kernels import layouts

WIDTH, HEIGHT = 33, 27
PROBE_PX = 5  # how far the probes of the tests reach


def grid(width, height, reach, step, first=0, end=0):
    """The points between margins of `reach`."""
    items = zeros32(layouts.GRID_ITEMS)
    items[layouts.GRID_WIDTH] = width
    items[layouts.GRID_REACH] = items[layouts.GRID_LEFT] = items[layouts.GRID_TOP] = reach
    items[layouts.GRID_RIGHT] = width - reach
    items[layouts.GRID_BOTTOM] = height - reach
    items[layouts.GRID_STEP] = step
    items[layouts.GRID_FIRST] = first
    items[layouts.GRID_END] = end
    return items


def gradient_histogram(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for reach, step, every in ((1, 1, 1), (2, 3, 1), (3, 3, 2)):
            yield 0, 0, frame, grid(WIDTH, HEIGHT, reach, step), every, words(128, random, 0, 100)
    frame = view(pixels("salt", 1024, 5, random))
    yield 0, 0, frame, grid(1024, 5, 1, 1), 1, zeros16(128)


def edge_threshold(random):
    for floor, median_q4, share_min, share_max in ((1, 0, 0, 0), (6, 40, 60, 180), (255, 255, 1024, 1024)):
        yield zeros16(128), 0, 0, 0, floor, median_q4, share_min, share_max
        for place in (0, 5, 127):
            histogram = zeros16(128)
            histogram[place] = 65535
            yield histogram, 0, 0, 65535, floor, median_q4, share_min, share_max
        for high in (1, 20, 500):
            histogram = words(128, random, 0, high)
            yield histogram, 0, 0, sum(histogram), floor, median_q4, share_min, share_max


def steep_positions(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for reach, step, field, threshold, listed, capacity in (
            (1, 1, 0, 0, 0, 2000),
            (2, 2, 1, 36, 3, 40),
            (3, 3, 0, 90000, 0, 5),
            (2, 1, 1, 0, 40, 40),
            (2, 3, 2, 100, 5, 200),
        ):
            points = grid(WIDTH, HEIGHT, reach, step)
            yield 0, 0, frame, points, field, threshold, ints(capacity + 1, random), listed, capacity
    frame = view(pixels("noise", 1024, 3, random))
    yield 0, 0, frame, grid(1024, 3, 1, 1), 0, 100, zeros32(1025), 0, 1024


def thin_line_edges(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for reach, threshold, least2 in ((1, 1, 0), (2, 12, 144), (3, 400, 0), (2, 12, 0)):
            count = 60
            edges = zeros32(count)
            for i in range(count):
                y = random.between(PROBE_PX, HEIGHT - 1 - PROBE_PX)
                edges[i] = y * WIDTH + random.between(PROBE_PX, WIDTH - 1 - PROBE_PX)
            probes = zeros16(48 * 3)
            for i in range(48 * 3):
                dy = random.between(-PROBE_PX, PROBE_PX)
                probes[i] = 32768 + dy * WIDTH + random.between(-PROBE_PX, PROBE_PX)
            first = (PROBE_PX + 1) * WIDTH if threshold > 1 else 0
            end = (HEIGHT - PROBE_PX - 3) * WIDTH if threshold > 1 else WIDTH * HEIGHT
            yield (
                frame, 0, 0, 0, edges, count, edges if reach == 2 else ints(count, random),
                grid(WIDTH, HEIGHT, reach, 1, first=first, end=end), threshold, tables.DIRECTION_48, probes,
                least2,
            )  # fmt: skip


CASES = {
    "gradient_histogram": gradient_histogram,
    "edge_threshold": edge_threshold,
    "steep_positions": steep_positions,
    "thin_line_edges": thin_line_edges,
}
