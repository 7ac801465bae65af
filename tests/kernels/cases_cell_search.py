"""Calls of the kernels in larics.kernels.cell_search."""

from array import array

from inputs import ints, random_bytes

from larics.arith import fixed
from larics.kernels.cell_search import SCRATCH
from larics.kernels.layouts import BIAS
from larics.marker import golay


def likeliest_words(random):
    everything = bytearray(b"\xff" * 512)
    for marker_id in (0, 9, 1261, 4094, 2222):
        dark = golay.cells(marker_id)
        for noise in (0, 50, 80, 140, 1000):
            for erased in (0, 3, 7, 12, 24):
                weights = array("i", [0] * 24)
                for cell in range(24):
                    sign = 64 if dark >> cell & 1 else -64
                    weight = max(-1023, min(1023, sign + random.between(-noise, noise)))
                    weights[cell] = BIAS + (weight if cell >= erased else 0)
                lines = ints(4, random, BIAS - 64, BIAS + 64)
                lines[3] = random.below(24)
                allowed = everything if random.below(2) else random_bytes(512, random)
                scratch, result = ints(SCRATCH, random), ints(3, random)
                yield (scratch, 0, 0, weights, fixed.CELL_ROWS, lines, allowed, result)


def certain_word(random):
    for scratch, _, _, weights, generator, lines, _, result in likeliest_words(random):
        for line in range(3):
            if random.below(3) == 0:
                lines[line] = BIAS
        yield (0, 0, scratch, weights, generator, lines, result)


CASES = {
    "certain_word": certain_word,
    "likeliest_words": likeliest_words,
}
