"""Robust harmonics of the two rings over their sectors, and how a pass moves the pose by them.

Sectors as in kernels.rings.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_FIT_X_Q8 = const(0)
_FIT_Y_Q8 = const(1)
_FIT_RADIUS_Q8 = const(6)
_FIT_INNER_Q8 = const(7)
_FIT_BULGE_COS = const(8)
_FIT_BULGE_SIN = const(9)
_FIT_X_Q10 = const(10)
_FIT_Y_Q10 = const(11)
_FIT_TRUE_X_Q10 = const(12)
_FIT_TRUE_Y_Q10 = const(13)
_FIT_AREA = const(14)
_FIT_MOVED_Q10 = const(15)
_FIT_INNER_Q10 = const(16)
_FIT_BEYOND_Q8 = const(19)
_RING_CONSTANT = const(0)
_RING_COS = const(1)
_RING_SIN = const(2)
_RING_COS_2 = const(3)
_RING_SIN_2 = const(4)
_RING_DEVIATION = const(5)
_RING_USED = const(6)
_RING_INSIDE = const(7)
_RING_MEAN_AREA = const(8)

_OUTLIER = const(4)  # mean deviations from the harmonics, from where on a sector is left out
_USED_LEAST = const(5)  # sectors of a ring, and half of those with crossings
_APART_Q10 = const(3000)  # the rings' centres differ by less, or they are not one marker's
_NOISE = const(50)  # variance of that difference, in 128ths of the deviations' squares
_PRIOR = const(230400)  # the smaller, the farther apart the rings' centres are expected anyway


@micropython.viper
def ring_harmonics(
    work: int, i: int, residual: int, sectors: ptr32, outer_means: ptr32, inner_means: ptr32, units: ptr8,
    rounds: int, floor: int, outer: ptr32, inner: ptr32,
) -> int:  # fmt: skip
    """Harmonics 0..2 of both rings' residuals over 16 sectors, with outliers left out; clears the sectors.

    Sectors without crossings, and those farther than `floor` (1/1024 px) and four times the mean deviation
    from the harmonics, are left out; repeated projection (at most `rounds` times, 1..8) makes up for the
    gaps. sectors: as in `ring_crossings`, up to 255 crossings each; *_means: 32 items of scratch space each
    (second half: mean area of each sector + 1, or 0 where there was none); units: tables.HARMONICS_4.
    outer, inner: RING; work: a register for what is used at once. Returns 1, or 0 when of either ring fewer
    than five or half of the sectors with crossings were used."""
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
            crossings = int(sectors[slot])
            if crossings > 0:
                inside += 1
                means[i + 16] = int(sectors[slot + 1]) // crossings + 1
                if int(sectors[slot + 2]) * 2 >= crossings:
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
                    if residual:
                        residual = residual - a0 - ((model1 + model2) >> 7)
                        work = residual
                        if work >> 31:
                            work = 0 - work
                        if (work - limit) >> 31:
                            used += 1
                            s0 += residual
                            deviation += work
                            if (largest - work) >> 31:
                                largest = work
                        else:
                            residual = 0
                    work = fold_a
                    fold_a = residual - fold_b
                    fold_b = work
                    fold_2 = residual - fold_2
                    work = model1
                    model1 = next1
                    next1 = 0 - work
                    model2 = 0 - model2
                    i -= 4
                sa1 += fold_a * ca1 - fold_b * cb1
                sb1 += fold_a * cb1 + fold_b * ca1
                sa2 += fold_2 * ca2
                sb2 += fold_2 * cb2
                unit += 4
            if used > 0:
                a0 += s0 // used
                units_used = used << 6
                a1 += sa1 // units_used
                b1 += sb1 // units_used
                a2 += sa2 // units_used
                b2 += sb2 // units_used
                deviation = deviation // used
            limit = deviation * _OUTLIER
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
        result[_RING_CONSTANT] = a0 - 32768 + _BIAS
        result[_RING_COS] = a1 + _BIAS
        result[_RING_SIN] = b1 + _BIAS
        result[_RING_COS_2] = a2 + _BIAS
        result[_RING_SIN_2] = b2 + _BIAS
        result[_RING_DEVIATION] = deviation
        result[_RING_USED] = used
        result[_RING_INSIDE] = inside
        result[_RING_MEAN_AREA] = area // counted
        if used < _USED_LEAST or used + used < inside:
            holds = 0
        ring += 1
    return holds


@micropython.viper
def end_pass(fit: ptr32, outer: ptr32, inner: ptr32) -> int:
    """Moves the pose by the harmonics of both rings (`ring_harmonics`) and corrects for perspective.

    Both rings weigh the same. The true centre lies beyond the mean of the rings' centres, by a factor of
    their difference which is weighted by how sure the difference is. fit: FIT; outer, inner: RING. Returns 1,
    or 0 when the rings' centres are so far apart that they cannot be one marker's."""
    fit[_FIT_AREA] = (int(outer[_RING_MEAN_AREA]) + int(inner[_RING_MEAN_AREA])) >> 1
    dx = int(outer[_RING_COS]) + int(inner[_RING_COS]) - _BIAS - _BIAS
    dy = int(outer[_RING_SIN]) + int(inner[_RING_SIN]) - _BIAS - _BIAS
    x = (int(fit[_FIT_X_Q8]) << 2) + (dx >> 1)
    y = (int(fit[_FIT_Y_Q8]) << 2) + (dy >> 1)
    fit[_FIT_X_Q10] = x + _BIAS
    fit[_FIT_Y_Q10] = y + _BIAS
    growth = int(outer[_RING_CONSTANT]) - _BIAS
    moved = growth << 1
    if moved < 0:
        moved = 0 - moved
    if dx < 0:
        dx = 0 - dx
    if dy < 0:
        dy = 0 - dy
    if dx > moved:
        moved = dx
    if dy > moved:
        moved = dy
    fit[_FIT_MOVED_Q10] = moved >> 1
    radius = int(fit[_FIT_RADIUS_Q8]) + ((growth + 2) >> 2)
    fit[_FIT_RADIUS_Q8] = radius
    fit[_FIT_INNER_Q8] = int(fit[_FIT_INNER_Q8]) + ((int(inner[_RING_CONSTANT]) - (_BIAS - 2)) >> 2)
    ratio = int(fit[_FIT_INNER_Q10])
    bulge = int(outer[_RING_COS_2]) - _BIAS + ((int(inner[_RING_COS_2]) - _BIAS) << 10) // ratio
    fit[_FIT_BULGE_COS] = int(fit[_FIT_BULGE_COS]) + (bulge >> 1)
    bulge = int(outer[_RING_SIN_2]) - _BIAS + ((int(inner[_RING_SIN_2]) - _BIAS) << 10) // ratio
    fit[_FIT_BULGE_SIN] = int(fit[_FIT_BULGE_SIN]) + (bulge >> 1)
    apart_x = int(outer[_RING_COS]) - int(inner[_RING_COS])
    apart_y = int(outer[_RING_SIN]) - int(inner[_RING_SIN])
    if apart_x >= _APART_Q10 or apart_x <= 0 - _APART_Q10:
        return 0
    if apart_y >= _APART_Q10 or apart_y <= 0 - _APART_Q10:
        return 0
    off_outer = int(outer[_RING_DEVIATION])
    off_inner = int(inner[_RING_DEVIATION])
    if off_outer > 3200:
        off_outer = 3200
    if off_inner > 3200:
        off_inner = 3200
    noise = (((off_outer * off_outer + off_inner * off_inner) * _NOISE) >> 7) + 4
    # the distance of the centres that is expected anyway
    prior = ((radius >> 4) * (radius >> 4) << 5) // _PRIOR
    signal = apart_x * apart_x + apart_y * apart_y - noise
    if signal < prior * prior:
        signal = prior * prior + 1
    signal = (signal >> 4) + 1
    beyond = (signal << 8) // (signal + (noise >> 4)) * int(fit[_FIT_BEYOND_Q8])
    fit[_FIT_TRUE_X_Q10] = x - ((apart_x * beyond + 32768) >> 16) + _BIAS
    fit[_FIT_TRUE_Y_Q10] = y - ((apart_y * beyond + 32768) >> 16) + _BIAS
    return 1
