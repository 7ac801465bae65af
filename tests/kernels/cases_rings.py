"""Calls of the kernels in larics.kernels.rings."""

from inputs import frames, ints, pixels, random_bytes, view, zeros32

from larics.arith import fixed
from larics.kernels import layouts


def fit(width=72, height=60, **items):
    """A pose: items by their names in lower case, what may be negative without its bias."""
    pose = zeros32(layouts.FIT_ITEMS)
    for name in ("BULGE_COS", "BULGE_SIN", "X_Q10", "Y_Q10", "TRUE_X_Q10", "TRUE_Y_Q10"):
        pose[getattr(layouts, "FIT_" + name)] = layouts.BIAS
    pose[layouts.FIT_INNER_Q10] = 683
    pose[layouts.FIT_LINE_Q10] = 119
    pose[layouts.FIT_GAP_Q10] = 170
    pose[layouts.FIT_BEYOND_Q8] = 333
    pose[layouts.FIT_WIDTH] = width
    pose[layouts.FIT_HEIGHT] = height
    for name in items:
        pose[getattr(layouts, "FIT_" + name.upper())] += items[name]
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
        yield fit(x_q10=x, y_q10=y, radius_q8=radius, area=area), limit


def ring_crossings(random):
    width, height = 72, 60
    for frame in frames(width, height, random):
        for cx, cy, radius, window, lines, clip, bulge, limit, least, skipped in (
            (36 * 256, 30 * 256, 25 * 256, 1600, 40, 0, 0, 4096, 0, 1),
            (0, 59 * 256 + 255, 20480, 5120, 40, 20, 8192, 32767, 50, 4),
            (40 * 256 + 77, 20 * 256 + 200, 1536, 256, 16, 5, -8192, 1024, 300, 2),
        ):
            pose = fit(
                x_q8=cx, y_q8=cy, radius_q8=radius, inner_q8=max(1024, radius * 2 // 3), window_q8=window,
                clip=clip, bulge_cos=bulge, bulge_sin=-bulge, limit_q10=limit, least_area=least,
            )  # fmt: skip
            yield (
                0, 0, 0, frame, fixed.LOG_GREY, pose, lines, fixed.ROOT,
                random_bytes(32, random, skipped), ints(128, random, 0, 4000000),
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
        x_q8=105 * 256, y_q8=105 * 256, radius_q8=20480, inner_q8=20480, window_q8=5120, bulge_cos=8192,
        bulge_sin=8192, limit_q10=32767, width=size, height=size,
    )  # fmt: skip
    yield 0, 0, 0, view(frame), fixed.LOG_GREY, pose, 28, fixed.ROOT, bytearray(32), zeros32(128)


def skip_half_sectors(random):
    code = ints(40, random, layouts.BIAS - 20, layouts.BIAS + 300)
    for bits, least, angle, reach in ((0, 0, 0, 1640), (1, 0, 65535, 8192), (1, 9, 9, 0), (1, 2, 4, 1640)):
        yield random_bytes(32, random), 0, bits, code, least, angle, reach, 1, 2


CASES = {
    "begin_pass": begin_pass,
    "ring_crossings": ring_crossings,
    "skip_half_sectors": skip_half_sectors,
}
