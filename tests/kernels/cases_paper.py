"""Calls of the kernels in larics.kernels.paper."""

from array import array

from inputs import frames, ints, pixels, random_bytes, view, words, zeros16, zeros32

from larics.arith.fixed import isqrt, sin_q14, turn16_from_cdeg

SINES = array("H", [32768 + sin_q14(turn16_from_cdeg(100 * angle)) for angle in range(450)])
EXTREME = (-1020, -765, -1, 0, 1, 256, 1020)


def clear16(random):
    for count in (0, 1, 17):
        yield words(20, random), count


def clear32(random):
    for count in (0, 1, 17):
        yield ints(20, random, -0x40000000), count


def sobel(random):
    width, height = 28, 20
    for frame in frames(width, height, random):
        for first_row, rows, floor in ((1, 18, 1), (3, 16, 24), (18, 1, 1000), (5, 3, 1442)):
            band = [words(rows * width, random) for _ in range(3)]
            yield frame, band[0], band[1], band[2], width, first_row, rows, floor * floor
    for pattern in ("salt", "blocks"):  # the largest frame there is
        frame = view(pixels(pattern, 1024, 3, random))
        yield frame, zeros16(1024), zeros16(1024), zeros16(1024), 1024, 1, 1, 1


def count_magnitudes(random):
    for count in (0, 1, 300):
        yield words(300, random, 0, 23080), ints(1443, random, 0, 1 << 20), count


def threshold_of_strongest(random):
    yield zeros32(1443), 1443, 0
    for keep in (0, 1, 5000, 50000, 1 << 20):
        yield ints(1443, random, 0, 100), 1443, keep
    yield ints(1443, random, 1 << 20, 1 << 20), 1443, 1 << 20


def gradient_band(width, rows, random, edges):
    """gx, gy and magnitude as `sobel` leaves them, with the largest values and one edge in `edges` pixels."""
    gx, gy, magnitude = zeros16(width * rows), zeros16(width * rows), zeros16(width * rows)
    for o in range(width * rows):
        if random.below(2):
            dx, dy = EXTREME[random.below(7)], EXTREME[random.below(7)]
        else:
            dx, dy = random.between(-1020, 1020), random.between(-1020, 1020)
        gx[o], gy[o] = dx + 1024, dy + 1024
        if 0 < o % width < width - 1 and random.below(edges) == 0:
            magnitude[o] = isqrt((dx * dx + dy * dy) << 8)
    return gx, gy, magnitude


def vote(random):
    for width, height, first_row, rows, nearest, farthest, threshold in (
        (40, 30, 1, 16, 1, 9, 16),
        (40, 30, 28, 1, 5, 60, 384),
        (33, 25, 3, 7, 20, 24, 4000),
        (16, 16, 1, 14, 1, 100, 23072),
    ):
        gx, gy, magnitude = gradient_band(width, rows, random, 2)
        cells = words(width * height, random, 0, 60000)
        yield cells, gx, gy, magnitude, width, height, first_row, rows, threshold, nearest, farthest
    for first_row in (1, 1022):  # the largest frame there is
        gx, gy, magnitude = gradient_band(1024, 1, random, 200)
        cells = zeros16(1024 * 1024)
        yield cells, gx, gy, magnitude, 1024, 1024, first_row, 1, 16, 1, 100


def argmax16(random):
    yield words(1, random), 1
    yield zeros16(50), 50
    yield array("H", [65535] * 50), 50
    for high in (1, 65535):
        yield words(50, random, 0, high), 50
    yield array("H", list(range(50))), 50


def count_radii(random):
    for width, first_row, rows, x0, y0, reach, threshold in (
        (40, 1, 16, 20, 9, 15, 16),
        (40, 10, 8, 0, 14, 30, 384),
        (40, 1, 5, 39, 100, 101, 16),
        (1024, 1000, 2, 1023, 1001, 101, 16),
        (1024, 1022, 1, 500, 921, 101, 16),
    ):
        gx, gy, magnitude = gradient_band(width, rows, random, 1)
        radii = words(4 * reach, random, 0, 60000)
        yield radii, gx, gy, magnitude, width, first_row, rows, threshold, x0, y0, reach
    # what points straight at the centre is counted, the centre itself included
    width, rows = 21, 21
    gx, gy, magnitude = zeros16(width * rows), zeros16(width * rows), zeros16(width * rows)
    for y in range(rows):
        for x in range(1, width - 1):
            dx, dy = 30 * (x - 10), 30 * (y - 10)
            gx[y * width + x], gy[y * width + x] = 1024 + dx, 1024 + dy
            magnitude[y * width + x] = max(16, isqrt((dx * dx + dy * dy) << 8))
    yield zeros16(48), gx, gy, magnitude, width, 40, rows, 16, 10, 50, 12


def binarise(random):
    width, height = 26, 22
    for frame in frames(width, height, random):
        for x0, y0, half, box, share in (
            (13, 11, 8, 3, 36),
            (0, 0, 5, 2, 0),
            (25, 21, 9, 30, 1),
            (20, 3, 0, 0, 255),
        ):
            window = random_bytes((2 * half + 1) * (2 * half + 1), random)
            yield frame, window, ints(width, random), width, height, x0, y0, half, box, share
    frame = view(pixels("white", 101, 101, random))  # the largest sum
    yield frame, bytearray(9), zeros32(101), 101, 101, 50, 50, 1, 50, 0
    frame = view(pixels("noise", 1024, 2, random))
    yield frame, bytearray(41 * 41), zeros32(1024), 1024, 2, 1020, 1, 20, 9, 8


def radial_sums(random):
    for half in (0, 1, 6, 30):
        yield random_bytes((2 * half + 1) * (2 * half + 1), random, 2), SINES, words(360, random), half
    half = 150
    yield bytearray([1] * ((2 * half + 1) * (2 * half + 1))), SINES, zeros16(360), half


CASES = {
    "clear16": clear16,
    "clear32": clear32,
    "sobel": sobel,
    "count_magnitudes": count_magnitudes,
    "threshold_of_strongest": threshold_of_strongest,
    "vote": vote,
    "argmax16": argmax16,
    "count_radii": count_radii,
    "binarise": binarise,
    "radial_sums": radial_sums,
}
