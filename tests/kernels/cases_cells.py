"""Calls of the kernels in larics.kernels.cells."""

from array import array

from cases_rings import fit
from inputs import frames, ints, zeros32

from larics.arith import fixed
from larics.kernels.layouts import BIAS

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


def local_depths(random):
    for angle in (0, 7641, 12345, 65535):
        for share in (0, 0, 0, 0, 100, 200, 300):
            means = ints(32, random, 0, 300)
            for sector in range(16):
                means[16 + sector] = random.between(share, 300) * random.below(2)
            depths = ints(24, random, BIAS - 300, BIAS + 155 + random.below(200))
            depths[random.below(24)] = random.below(2)
            yield 200, 0, angle, int(share == 200), means, depths
    yield 0, 0, 0, 0, zeros32(32), ints(24, random, 0, BIAS)
    yield 1 << 20, 0, 0, 0, ints(32, random, 0, 1 << 20), ints(24, random, 0, BIAS + 300000)


CASES = {"cell_depths": cell_depths, "direct_place": direct_place, "local_depths": local_depths}
