"""Calls of the kernels in larics.kernels.cell_words."""

from array import array

from inputs import ints, zeros32

from larics.kernels.layouts import BIAS
from larics.marker import golay


def _depths(random, marker_id, noise, hidden, shade):
    """What `cells.cell_depths` may tell of a marker, some of whose cells something of another tone hides."""
    dark = golay.cells(marker_id)
    depths = array("i", [0] * 72)
    for cell in range(24):
        covered = cell < hidden
        depth = 0 if covered else 360 * (dark >> cell & 1)
        depths[cell] = BIAS + depth + random.between(-noise, noise)
        depths[24 + cell] = random.between(200, 1100)
        depths[48 + cell] = 990 - (shade if covered else 0) + random.between(-9, 9)
    depths[23 - random.below(12)] *= random.below(2)
    return depths


def cell_weights(random):
    for marker_id in (0, 9, 1261, 4094):
        for noise in (1, 60, 400, 40000):
            for hidden in (0, 5, 11, 24):
                depths = _depths(random, marker_id, noise, hidden, 40 * hidden)
                yield (
                    (90, 128)[random.below(2)],
                    0,
                    ints(48, random),
                    depths,
                    random.below(1 << 24),
                    zeros32(29),
                )
    yield (128, 0, ints(48, random), zeros32(72), 0, zeros32(29))


def believed_word(random):
    for marker_id in (0, 9, 1261, 4094, 4096):
        for lines_id in (0, 1, 5, 6, 7, 13, 20, 32, 56):
            for most in (1, 80, 400, 1 << 20):
                for turned in (0, 1):
                    cost = 1 << 20 if marker_id == 4096 else random.between(0, min(most, 1024))
                    result = ints(3, random)
                    result[0], result[1] = marker_id, cost
                    result[2] = cost + random.between(0, most)
                    weights = ints(29, random, BIAS - 64, BIAS + 64)
                    weights[27] = random.between(0, 24)
                    weights[28] = random.between(0, 24)
                    weights[25] = random.between(0, min(most, 1536))
                    yield (lines_id, 0, turned, weights, result)
    for _ in range(200):  # about what is just believed
        cost = random.between(0, 40)
        weights = ints(29, random, BIAS - 64, BIAS + 64)
        weights[25], weights[27], weights[28] = 900, random.between(2, 8), random.between(8, 14)
        result = ints(3, random)
        result[0], result[1], result[2] = 1261, cost, cost + random.between(40, 160)
        yield (5, 0, 0, weights, result)


CASES = {
    "believed_word": believed_word,
    "cell_weights": cell_weights,
}
