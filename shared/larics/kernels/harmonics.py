"""Robust harmonics of the two rings over their sectors, and how a pass moves the pose by them.

Sectors as in kernels.rings.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr32

BIAS = const(1 << 24)  # what may be negative is stored with this added: ptr32 loads differ in their sign

# items of a ring's harmonics, after the five coefficients (+ BIAS)
DEVIATION = const(5)
USED = const(6)
INSIDE = const(7)
MEAN_AREA = const(8)

_X_Q8 = const(0)  # items as in kernels.rings: FIT
_Y_Q8 = const(1)
_RADIUS_Q8 = const(6)
_INNER_Q8 = const(7)
_BULGE_COS = const(8)
_BULGE_SIN = const(9)
_X_Q10 = const(10)
_Y_Q10 = const(11)
_TRUE_X_Q10 = const(12)
_TRUE_Y_Q10 = const(13)
_AREA = const(14)
_MOVED_Q10 = const(15)
_INNER_Q10 = const(16)
_BEYOND_Q8 = const(19)

_APART_Q10 = const(3000)  # the rings' centres differ by less, or they are not one marker's


@micropython.viper
def ring_harmonics(
    slot: int, i: int, residual: int, sectors: ptr32, outer_means: ptr32, inner_means: ptr32, units: ptr8,
    rounds: int, floor: int, outer: ptr32, inner: ptr32,
) -> int:  # fmt: skip
    """Harmonics 0..2 of both rings' residuals over 16 sectors, with outliers left out; clears the sectors.

    Sectors without crossings, and those farther than `floor` (1/1024 px) and four times the mean deviation
    from the harmonics, are left out; repeated projection (at most `rounds` times, 1..8) makes up for the
    gaps. sectors: as in `ring_crossings`, up to 255 crossings each; *_means: 32 items of scratch space each
    (second half: mean area of each sector + 1, or 0 where there was none); units: tables.HARMONICS_4.
    outer, inner: constant, cos, sin, cos 2, sin 2 (1/1024 px, + BIAS), mean deviation (1/1024 px), sectors
    used, sectors with crossings, mean area of the used ones. Returns 1, or 0 when of either ring fewer than
    five or half of the sectors with crossings were used."""
    holds = 1
    ring = 0
    while ring < 2:
        means = outer_means
        result = outer
        if ring:
            means = inner_means
            result = inner
        inside = 0
        i = 0
        slot = ring << 6
        while i < 16:
            means[i] = 0
            means[i + 16] = 0
            residual = int(sectors[slot])
            if residual > 0:
                inside += 1
                means[i + 16] = int(sectors[slot + 1]) // residual + 1
                if int(sectors[slot + 2]) * 2 >= residual:
                    means[i] = int(sectors[slot + 3]) // int(sectors[slot + 2])
                sectors[slot] = 0
                sectors[slot + 1] = 0
                sectors[slot + 2] = 0
                sectors[slot + 3] = 0
            slot += 4
            i += 1
        a0 = 32768
        a1 = 0
        b1 = 0
        a2 = 0
        b2 = 0
        limit = 1048576
        deviation = 0
        used = 0
        turn = 0
        while turn < rounds:
            turn += 1
            used = 0
            deviation = 0
            largest = 0
            s0 = 0
            sa1 = 0
            sb1 = 0
            sa2 = 0
            sb2 = 0
            unit = 0
            while unit < 16:
                # four sectors a quarter turn apart share their harmonics but for signs: from the last to the
                # first
                ca1 = int(units[unit]) - 128
                cb1 = int(units[unit + 1]) - 128
                ca2 = int(units[unit + 2]) - 128
                cb2 = int(units[unit + 3]) - 128
                next1 = 0 - a1 * ca1 - b1 * cb1
                model1 = a1 * cb1 - b1 * ca1
                model2 = 0 - a2 * ca2 - b2 * cb2
                fold_a = 0
                fold_b = 0
                fold_2 = 0
                i = 12 + (unit >> 2)
                while i >= 0:
                    residual = int(means[i])
                    if residual > 0:
                        residual = residual - a0 - ((model1 + model2) >> 7)
                        slot = residual
                        if slot < 0:
                            slot = 0 - slot
                        if slot < limit:
                            used += 1
                            s0 += residual
                            deviation += slot
                            if slot > largest:
                                largest = slot
                        else:
                            residual = 0
                    slot = fold_a
                    fold_a = residual - fold_b
                    fold_b = slot
                    fold_2 = residual - fold_2
                    slot = model1
                    model1 = next1
                    next1 = 0 - slot
                    model2 = 0 - model2
                    i -= 4
                sa1 += fold_a * ca1 - fold_b * cb1
                sb1 += fold_a * cb1 + fold_b * ca1
                sa2 += fold_2 * ca2
                sb2 += fold_2 * cb2
                unit += 4
            if used > 0:
                a0 += s0 // used
                i = used << 6
                a1 += sa1 // i
                b1 += sb1 // i
                a2 += sa2 // i
                b2 += sb2 // i
                deviation = deviation // used
            limit = deviation * 4
            if limit < floor:
                limit = floor
            if used == 16 and largest < limit and turn > 1:
                turn = rounds  # nothing was left out and nothing will be: this is the least squares' solution
        area = 0
        counted = 0
        i = 0
        while i < 16:
            if int(means[i]) > 0:
                area += int(means[i + 16])
                counted += 1
            i += 1
        if counted < 1:
            counted = 1
        result[0] = a0 - 32768 + BIAS
        result[1] = a1 + BIAS
        result[2] = b1 + BIAS
        result[3] = a2 + BIAS
        result[4] = b2 + BIAS
        result[5] = deviation
        result[6] = used
        result[7] = inside
        result[8] = area // counted
        if used < 5 or used + used < inside:
            holds = 0
        ring += 1
    return holds


@micropython.viper
def end_pass(fit: ptr32, value: int, radius: int, outer: ptr32, inner: ptr32) -> int:
    """Moves the pose by the harmonics of both rings (`ring_harmonics`) and corrects for perspective.

    Both rings weigh the same. The true centre lies beyond the mean of the rings' centres, by a factor of
    their difference which is weighted by how sure the difference is. Returns 1, or 0 when the rings' centres
    are so far apart that they cannot be one marker's."""
    radius = int(fit[_RADIUS_Q8])
    fit[_AREA] = (int(outer[MEAN_AREA]) + int(inner[MEAN_AREA])) >> 1
    dx = int(outer[1]) + int(inner[1]) - BIAS - BIAS
    dy = int(outer[2]) + int(inner[2]) - BIAS - BIAS
    x = (int(fit[_X_Q8]) << 2) + (dx >> 1)
    y = (int(fit[_Y_Q8]) << 2) + (dy >> 1)
    fit[_X_Q10] = x + BIAS
    fit[_Y_Q10] = y + BIAS
    growth = int(outer[0]) - BIAS
    value = growth << 1
    if value < 0:
        value = 0 - value
    if dx < 0:
        dx = 0 - dx
    if dy < 0:
        dy = 0 - dy
    if dx > value:
        value = dx
    if dy > value:
        value = dy
    fit[_MOVED_Q10] = value >> 1
    radius += (growth + 2) >> 2
    fit[_RADIUS_Q8] = radius
    fit[_INNER_Q8] = int(fit[_INNER_Q8]) + ((int(inner[0]) - (BIAS - 2)) >> 2)
    ratio = int(fit[_INNER_Q10])
    value = int(outer[3]) - BIAS + ((int(inner[3]) - BIAS) << 10) // ratio
    fit[_BULGE_COS] = int(fit[_BULGE_COS]) + (value >> 1)
    value = int(outer[4]) - BIAS + ((int(inner[4]) - BIAS) << 10) // ratio
    fit[_BULGE_SIN] = int(fit[_BULGE_SIN]) + (value >> 1)
    dx = int(outer[1]) - int(inner[1])
    dy = int(outer[2]) - int(inner[2])
    if dx >= _APART_Q10 or dx <= 0 - _APART_Q10 or dy >= _APART_Q10 or dy <= 0 - _APART_Q10:
        return 0
    value = int(outer[DEVIATION])
    noise = int(inner[DEVIATION])
    if value > 3200:
        value = 3200
    if noise > 3200:
        noise = 3200
    noise = (((value * value + noise * noise) * 50) >> 7) + 4
    # the distance of the centres that is expected anyway
    prior = ((radius >> 4) * (radius >> 4) << 5) // 230400
    signal = dx * dx + dy * dy - noise
    if signal < prior * prior:
        signal = prior * prior + 1
    signal = (signal >> 4) + 1
    value = (signal << 8) // (signal + (noise >> 4))
    value = value * int(fit[_BEYOND_Q8])
    fit[_TRUE_X_Q10] = x - ((dx * value + 32768) >> 16) + BIAS
    fit[_TRUE_Y_Q10] = y - ((dy * value + 32768) >> 16) + BIAS
    return 1
