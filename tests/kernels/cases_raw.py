"""Calls of the kernels in larics.kernels.raw."""

from inputs import frames, random_bytes

WIDTH, HEIGHT = 33, 27
MOST, SIZE = 505, 64


def predict(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for first, left, width in ((0, 0, 16), (5, 16, 16), (21, 32, 1), (16, 3, 7)):
            place = first // width * WIDTH + left + first % width
            count = min(MOST, width * HEIGHT - first)
            yield frame, bytearray(MOST), place, 1, count, first % width, width, WIDTH, 8 * SIZE, 0
    yield bytearray([0, 255] * 200), bytearray(MOST), 0, 1, 400, 0, 16, 16, 8 * SIZE, 0
    yield bytearray(MOST), bytearray(MOST), 0, 1, MOST, 0, 16, 16, 8 * SIZE, 0


def errors_of(random, k):
    errors = random_bytes(MOST, random)
    for n in range(MOST):
        errors[n] >>= 7 - k
    return errors


def fitting(random):
    for k in range(8):
        for other in (k, min(7, k + 1)):
            yield errors_of(random, other), 1, MOST, k, 8 * SIZE
    yield bytearray(MOST), 1, MOST, 0, 8 * SIZE
    yield bytearray(1), 1, 1, 0, 8 * SIZE


def pack(random):
    for k in range(8):
        # the longest code of an error has 20 bits, the shortest for such errors more than k
        for count in (1, 2, (8 * SIZE - 8) // 20 + 1):
            yield errors_of(random, 7), random_bytes(SIZE, random), 1, count, k, SIZE, 1
    yield bytearray(MOST), random_bytes(SIZE, random), 1, MOST, 0, SIZE, 1


def gather(random):
    for frame in frames(WIDTH, HEIGHT, random):
        yield frame, bytearray(SIZE), 5 * WIDTH + 9, 0, SIZE, 9, 16, WIDTH, SIZE
        yield frame, random_bytes(SIZE, random), WIDTH - 1, 0, 7, 0, 1, WIDTH, SIZE


CASES = {"predict": predict, "fitting": fitting, "pack": pack, "gather": gather}
