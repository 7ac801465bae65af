"""Calls of the kernels in larics.kernels.rings."""

from inputs import frames, ints, pixels, random_bytes, view, zeros32

from larics import fixed, tables
from larics.kernels import rings


def fit(**items):
    """A pose: items by their names in lower case, what may be negative without its bias."""
    pose = zeros32(rings.FIT_ITEMS)
    for name in ("BULGE_COS", "BULGE_SIN", "X_Q10", "Y_Q10", "TRUE_X_Q10", "TRUE_Y_Q10"):
        pose[getattr(rings, name)] = rings.BIAS
    pose[rings.INNER_Q10] = 683
    pose[rings.LINE_Q10] = 119
    pose[rings.GAP_Q10] = 170
    pose[rings.BEYOND_Q8] = 333
    for name in items:
        pose[getattr(rings, name.upper())] += items[name]
    return pose


def begin_pass(random):
    for x, y, radius, area, limit in (
        (0, 0, 1536, 0, 192),
        (71 * 1024, 59 * 1024 + 1023, 20480, 1 << 20, 256),
        (-3, 500, 8000, 700, 48),
        (40000, 500, 1535, 700, 48),
        (40000, 61000, 7680, 700, 48),
        (40000, 21000, 7680, 700, 48),
    ):
        yield fit(x_q10=x, y_q10=y, radius_q8=radius, area=area), 0, 0, limit, 72, 60


def end_pass(random):
    for span, deviation in ((0, 0), (1000, 100), (1499, 4096), (4000, 500), (4096, 4096)):
        harmonics = []
        for sign in (1, -1):
            ring = zeros32(9)
            for i in range(5):
                ring[i] = rings.BIAS + sign * span
            ring[rings.DEVIATION] = deviation
            ring[rings.MEAN_AREA] = 60000
            harmonics.append(ring)
        for radius in (1536, 20480):
            pose = fit(x_q8=2560, y_q8=0, radius_q8=radius, inner_q8=radius * 2 // 3, bulge_cos=-8192)
            yield pose, 0, 0, harmonics[0], harmonics[1]
            yield fit(radius_q8=radius), 0, 0, harmonics[1], harmonics[1]


def ring_crossings(random):
    width, height = 72, 60
    for frame in frames(width, height, random):
        for cx, cy, radius, window, lines, clip, bulge, limit, least, skipped in (
            (36 * 256, 30 * 256, 25 * 256, 1600, 40, 0, 0, 4096, 0, 1),
            (0, 59 * 256 + 255, 20480, 5120, 40, 20, 8192, 32767, 50, 4),
            (40 * 256 + 77, 20 * 256 + 200, 1536, 256, 16, 5, -8192, 1024, 300, 2),
        ):
            for ring in (0, 1):
                pose = fit(
                    x_q8=cx, y_q8=cy, radius_q8=radius, inner_q8=radius, window_q8=window, clip=clip,
                    bulge_cos=bulge, bulge_sin=-bulge, limit_q10=limit, least_area=least,
                )  # fmt: skip
                yield (
                    0, 0, 0, frame, fixed.LOG_GREY, width, height, pose, ring, lines, fixed.ROOT,
                    random_bytes(32, random, skipped), ints(64, random, 0, 4000000),
                )  # fmt: skip
    # the largest ring with the widest window, over dark and light halves of the window
    size = 210
    frame = pixels("white", size, size, random)
    for y in range(size):
        for x in range(size):
            radius2 = (x - 105) * (x - 105) + (y - 105) * (y - 105)
            if 62 * 62 < radius2 < 80 * 80 or (80 * 80 < radius2 < 97 * 97 and x < y):
                frame[y * size + x] = 0
    pose = fit(
        x_q8=105 * 256, y_q8=105 * 256, radius_q8=20480, window_q8=5120, bulge_cos=8192, bulge_sin=8192,
        limit_q10=32767,
    )  # fmt: skip
    yield (
        0, 0, 0, view(frame), fixed.LOG_GREY, size, size, pose, 0, 28, fixed.ROOT, bytearray(32), zeros32(64)
    )


def ring_harmonics(random):
    for largest, rounds, floor in (
        (300, 1, 100),
        (4096, 8, 300),
        (32767, 5, 1),
        (32767, 8, 40000),
        (0, 3, 1),
    ):
        sectors = zeros32(64)
        for sector in range(16):
            tried = random.between(0, 255)
            counted = random.between(0, tried)
            residual = random.between(-largest, largest)
            if sector & 1:  # a wave of the first two harmonics
                residual = largest if sector % 8 < 4 else -largest
                counted = tried
            sectors[4 * sector] = tried
            sectors[4 * sector + 1] = tried * random.between(0, 60000)
            sectors[4 * sector + 2] = counted
            sectors[4 * sector + 3] = counted * (32768 + residual)
        yield 0, 0, 0, sectors, ints(32, random), tables.HARMONICS_4, rounds, floor, ints(9, random)
    # square waves of each harmonic, which make the largest sums
    for period in (8, 4):
        sectors = zeros32(64)
        for sector in range(16):
            sectors[4 * sector] = sectors[4 * sector + 2] = 1
            sectors[4 * sector + 3] = 65535 if sector // period & 1 else 1
        yield 0, 0, 0, sectors, zeros32(32), tables.HARMONICS_4, 8, 40000, zeros32(9)
    yield 0, 0, 0, zeros32(64), zeros32(32), tables.HARMONICS_4, 4, 100, zeros32(9)


def mean_area(random):
    for first, count in ((0, 16), (14, 5), (1000, 0), (17, 3)):
        yield ints(32, random, 0, 70000), 0, 0, first, count
    yield zeros32(32), 0, 0, 14, 5


def skip_half_sectors(random):
    code = ints(40, random, rings.BIAS - 20, rings.BIAS + 300)
    for bits, least, angle, reach in ((0, 0, 0, 1640), (1, 0, 65535, 8192), (1, 9, 9, 0), (1, 2, 4, 1640)):
        yield random_bytes(32, random), 0, bits, code, least, angle, reach, 1, 2


CASES = {
    "begin_pass": begin_pass,
    "end_pass": end_pass,
    "ring_crossings": ring_crossings,
    "ring_harmonics": ring_harmonics,
    "mean_area": mean_area,
    "skip_half_sectors": skip_half_sectors,
}
