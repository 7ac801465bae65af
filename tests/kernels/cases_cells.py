"""Calls of the kernels in larics.kernels.cells."""

from array import array

from cases_rings import fit
from inputs import frames, ints, random_bytes, zeros32

from larics.arith import fixed
from larics.kernels.cells import SCRATCH
from larics.kernels.layouts import BIAS
from larics.marker import golay

WIDTH, HEIGHT = 72, 60


def _poses(random):
    for x_q8, y_q8, radius_q8 in (
        (36 * 256, 30 * 256, 4500),
        (50 * 256 + 99, 20 * 256, 1024),
        (256, 14000, 20480),
    ):
        for bent in (0, 4096):
            for turn16 in (0, 20000, 51111):
                pose = [x_q8, y_q8, radius_q8]
                pose += [BIAS + random.between(-bent, bent) for _ in range(4)]
                pose += [BIAS + fixed.cos_q14(turn16), BIAS + fixed.sin_q14(turn16)]
                pose += [random.between(1, 1100), 1297, 1399, 1556, 1611, WIDTH, HEIGHT]
                yield array("i", pose)


def cell_depths(random):
    for frame in frames(WIDTH, HEIGHT, random):
        for pose in _poses(random):
            yield (0, 0, 0, frame, fixed.LOG_GREY, fixed.CELL_AXES, pose, ints(72, random))


def direct_place(random):
    for angle in (0, 12345, 65535):
        for bulge, bent in ((0, 0), (900, 300), (-900, -300), (20000, 0)):
            for radius in (1536, 7680, 20480):
                pose = fit(
                    true_x_q10=36000 + bent, true_y_q10=30000, x_q10=36000, y_q10=30000 + bent,
                    radius_q8=radius, bulge_cos=bulge, bulge_sin=-bulge, area=random.below(1 << 20),
                )  # fmt: skip
                yield pose, 0, 0, fixed.COSINE, angle, ints(16, random)


def _depths(random, marker_id, noise, hidden, shade):
    """What `cell_depths` may tell of a marker, some of whose cells something of another tone hides."""
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
                yield (ints(48, random), 0, 0, depths, zeros32(25))
    yield (ints(48, random), 0, 0, zeros32(72), zeros32(25))


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
                scratch, result = ints(SCRATCH, random), ints(5, random)
                yield (scratch, 0, 0, weights, fixed.CELL_ROWS, lines, allowed, result)


CASES = {
    "cell_depths": cell_depths,
    "direct_place": direct_place,
    "cell_weights": cell_weights,
    "likeliest_words": likeliest_words,
}
