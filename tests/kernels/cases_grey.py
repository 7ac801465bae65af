"""Calls of the kernels in larics.kernels.grey."""

from inputs import frames, pixels, view, words

WIDTH, HEIGHT = 33, 27


def count_greys(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for left, top, right, bottom, step in (
            (0, 0, WIDTH, HEIGHT, 1),
            (3, 5, 20, 21, 3),
            (32, 26, 33, 27, 9),
            (4, 4, 4, 9, 1),
        ):
            yield frame, words(64, random), 0, 0, WIDTH, left, top, right, bottom, step
    yield view(pixels("noise", 1024, 60, random)), words(64, random), 0, 0, 1024, 0, 0, 1024, 60, 1


def take_sample(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for step, count in ((1, 1), (1, 20), (3, 251), (7, 100)):
            yield frame, bytearray(251), 0, 0, step, count, words(4, random)
            same = bytearray([frame[k * step] for k in range(count)])  # as the frame before
            yield frame, same, 0, 0, step, count, words(4, random)


CASES = {"count_greys": count_greys, "take_sample": take_sample}
