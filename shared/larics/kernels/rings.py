"""The two rings: crossings with pixel rows and columns, robust harmonics, and the passes of a fit.

Angles of the rings are counted clockwise from x, because y points down; a ring is divided into 16 sectors of
22.5 degrees, sector 0 beginning at x, and into 32 half sectors. Darkness is measured in units of
tables.LOG_GREY_Q8 (256 per octave of grey + 16), so that it does not depend on the light.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

# FIT: items of the array that holds the pose of a candidate and what a pass takes from it
X_Q8 = const(0)  # centre used for the last pass
Y_Q8 = const(1)
WINDOW_Q8 = const(2)  # to both sides of a ring
CLIP = const(3)  # log units
LEAST_AREA = const(4)  # that a crossing must have to count
LIMIT_Q10 = const(5)  # largest residual that counts
RADIUS_Q8 = const(6)
INNER_Q8 = const(7)
BULGE_COS = const(8)  # second harmonic of the outer radius, 1/1024 px; + BIAS
BULGE_SIN = const(9)
X_Q10 = const(10)  # centre, mean of the rings'; + BIAS
Y_Q10 = const(11)
TRUE_X_Q10 = const(12)  # centre with the correction for perspective; + BIAS
TRUE_Y_Q10 = const(13)
AREA = const(14)  # darkness times width of the rings' line, log units * px; 0 before the first pass
MOVED_Q10 = const(15)  # by the last pass
INNER_Q10 = const(16)  # the marker's geometry, outer radius 1024: radius of the inner ring,
LINE_Q10 = const(17)  # width of the lines,
GAP_Q10 = const(18)  # half the gap between the rings
BEYOND_Q8 = const(19)  # of the rings' centres' difference, how far the true centre is beyond their mean
FIT_ITEMS = const(20)

BIAS = const(1 << 24)  # what may be negative is stored with this added: ptr32 loads differ in their sign

# items of a ring's harmonics, after the five coefficients (+ BIAS)
DEVIATION = const(5)
USED = const(6)
INSIDE = const(7)
MEAN_AREA = const(8)

APART_Q10 = const(3000)  # the rings' centres differ by less, or they are not one marker's


@micropython.viper
def begin_pass(fit: ptr32, window: int, area: int, limit: int, width: int, height: int) -> int:
    """Sets what a pass over both rings takes from the pose so far; `limit` as in `RingFit.refine`.

    fit: see `FIT`; radii up to 20480, area 0..2**20. Returns 1, or 0 when the outer radius is below 6 px or
    the centre outside the frame."""
    window = (int(fit[X_Q10]) - (BIAS - 2)) >> 2
    area = (int(fit[Y_Q10]) - (BIAS - 2)) >> 2
    if window < 0 or area < 0 or (window >> 8) >= width or (area >> 8) >= height:
        return 0
    if int(fit[RADIUS_Q8]) < 1536:
        return 0
    fit[X_Q8] = window
    fit[Y_Q8] = area
    # to the middle of the gap between the rings; with large rings, less of it will do
    window = (int(fit[RADIUS_Q8]) * int(fit[GAP_Q10])) >> 10
    if window < 300:
        window = 300
    if window > 640:
        window = (window * 7) >> 3
        if window < 640:
            window = 640
        if window > 3584:
            window = 3584
    fit[WINDOW_Q8] = window
    fit[LIMIT_Q10] = (window * limit) >> 6
    window = (int(fit[RADIUS_Q8]) * int(fit[LINE_Q10])) >> 10
    area = int(fit[AREA])
    if area > 0:
        # later passes clip an eighth of the depth
        fit[CLIP] = (area << 5) // window
        fit[LEAST_AREA] = (area * 3) >> 3
    else:
        fit[CLIP] = 8
        fit[LEAST_AREA] = (window * 12) >> 8  # about 4 of 100 grey levels deep
    return 1


@micropython.viper
def ring_crossings(
    position: int, value: int, base: int, image: ptr8, log: ptr16, width: int, height: int, fit: ptr32,
    ring: int, lines: int, roots: ptr16, skip: ptr8, sectors: ptr32,
) -> int:  # fmt: skip
    """Where pixel rows (within 45 degrees of x) and columns (the others) cross a dark ring line.

    Each crossing is the centroid of what is darker than the straight line between the window's ends by more
    than a clip; no pixel is interpolated. `fit` as `begin_pass` left it: centre inside the frame, radius
    1536..20480 and window (half width, 256..radius / 4) in 1/256 px, bulge (+-8192) and largest residual that
    counts in 1/1024 px, clip and smallest darkness times width that counts (log units * px). ring: 0 the
    outer, 1 the inner one; lines: crossings a quarter ring, about; roots: tables.ROOT. sectors: 32 x
    (crossings inside the frame, their area, those that count, sum of residual + 32768 in 1/1024 px) are
    added to. Returns the number of crossings tried."""
    cx = int(fit[X_Q8])
    cy = int(fit[Y_Q8])
    radius = int(fit[RADIUS_Q8 + ring])
    window = int(fit[WINDOW_Q8])
    clip = int(fit[CLIP])
    limit = int(fit[LIMIT_Q10])
    least_area = int(fit[LEAST_AREA])
    bulge_cos = int(fit[BULGE_COS]) - BIAS
    bulge_sin = int(fit[BULGE_SIN]) - BIAS
    if ring:
        value = int(fit[INNER_Q10])
        bulge_cos = (bulge_cos * value) >> 10
        bulge_sin = (bulge_sin * value) >> 10
    step = ((radius * 362) >> 16) // lines
    if step < 1:
        step = 1
    skip_bit = 1 << ring
    measured = 0
    radius2 = radius * radius
    swap = 0
    while swap < 2:
        if swap:
            along = width
            line_pitch = 1
            centre = cx
            centre_along = cy
            lines = width
            pixels = height
        else:
            along = 1
            line_pitch = width
            centre = cy
            centre_along = cx
            lines = height
            pixels = width
        last = (radius * 181) >> 16
        line = ((centre + 128) >> 8) - last
        last = line + last + last
        while line < 0:
            line += step
        if last >= lines:
            last = lines - 1
        while line <= last:
            offset = (line << 8) - centre
            value = offset
            if value < 0:
                value = 0 - value
            height_q8 = (radius * int(roots[(value << 7) // radius])) >> 14
            height_q8 = (height_q8 + (radius2 - offset * offset) // height_q8) >> 1
            half = ((window * radius) // height_q8 + 128) >> 8
            across_q10 = (offset << 10) // radius
            along_q10 = (height_q8 << 10) // radius
            value = across_q10
            if value < 0:
                value = 0 - value
            sector = 0
            if value >= 200:
                sector = 1
                if value >= 392:
                    sector = 2
                    if value >= 569:
                        sector = 3
            cos2 = (along_q10 * along_q10 - across_q10 * across_q10) >> 10
            sin2 = (along_q10 * across_q10) >> 9
            if swap:
                cos2 = 0 - cos2
                sector = 7 - sector
                if across_q10 < 0:
                    sector = 15 - sector
            elif across_q10 < 0:
                sector = 31 - sector
            crossing = centre_along + height_q8
            side = 0
            while side < 2:
                pixel = (crossing + 128) >> 8
                if (int(skip[sector]) & skip_bit) == 0 and pixel - half >= 0 and pixel + half < pixels:
                    measured += 1
                    position = line * line_pitch + (pixel - half) * along
                    value = position + (half + half) * along
                    near = int(log[int(image[position])]) + int(log[int(image[position + along])])
                    far = int(log[int(image[value])]) + int(log[int(image[value - along])])
                    slope = ((far - near) << 7) // (half + half - 1)
                    base = (near << 7) - (slope >> 1) - (clip << 8)
                    area = 0
                    moment = 0
                    value = (base >> 8) - int(log[int(image[position])])
                    if value > 0:
                        area = value
                        moment = value
                    i = half
                    while i > 0:
                        position += along
                        base += slope
                        value = (base >> 8) - int(log[int(image[position])])
                        if value > 0:
                            area += value
                        moment += area
                        position += along
                        base += slope
                        value = (base >> 8) - int(log[int(image[position])])
                        if value > 0:
                            area += value
                        moment += area
                        i -= 1
                    base = (sector >> 1) << 2
                    position = (area * along_q10) >> 10
                    sectors[base] = int(sectors[base]) + 1
                    sectors[base + 1] = int(sectors[base + 1]) + position
                    if position > least_area:
                        value = (((half + 1) * area - moment) << 10) // area
                        value += ((pixel << 8) - crossing) << 2
                        value = value * along_q10
                        if side:
                            value = 0 - value
                        value = ((value + 512) >> 10) - ((cos2 * bulge_cos + sin2 * bulge_sin) >> 10)
                        if value < limit and 0 - limit < value:
                            sectors[base + 2] = int(sectors[base + 2]) + 1
                            sectors[base + 3] = int(sectors[base + 3]) + value + 32768
                # the other side of the ring
                sector = 15 - sector
                if swap:
                    sector += 16
                elif sector < 0:
                    sector += 32
                sin2 = 0 - sin2
                crossing = centre_along - height_q8
                side += 1
            line += step
        swap += 1
    return measured


@micropython.viper
def ring_harmonics(
    slot: int, i: int, residual: int, sectors: ptr32, means: ptr32, units: ptr8, rounds: int, floor: int,
    result: ptr32
) -> int:
    """Harmonics 0..2 of the residual over the 16 sectors, with outliers left out; the sectors are cleared.

    Sectors without crossings, and those farther than `floor` (1/1024 px) and four times the mean deviation
    from the harmonics, are left out; repeated projection (`rounds` times, 1..8) makes up for the gaps.
    sectors: as in `ring_crossings`, up to 255 crossings each; means: 32 items of scratch space (second half:
    mean area of each sector + 1, or 0 where there was none); units: tables.HARMONICS_4.
    result: constant, cos, sin, cos 2, sin 2 (1/1024 px, + BIAS), mean deviation (1/1024 px), sectors used,
    sectors with crossings, mean area of the used ones. Returns the number of sectors used."""
    inside = 0
    i = 0
    slot = 0
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
    while rounds > 0:
        used = 0
        deviation = 0
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
                    if residual < limit and 0 - limit < residual:
                        used += 1
                        s0 += residual
                        if residual < 0:
                            deviation -= residual
                        else:
                            deviation += residual
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
        rounds -= 1
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
    return used


@micropython.viper
def end_pass(fit: ptr32, value: int, radius: int, outer: ptr32, inner: ptr32) -> int:
    """Moves the pose by the harmonics of both rings (`ring_harmonics`) and corrects for perspective.

    Both rings weigh the same. The true centre lies beyond the mean of the rings' centres, by a factor of
    their difference which is weighted by how sure the difference is. Returns 1, or 0 when the rings' centres
    are so far apart that they cannot be one marker's."""
    radius = int(fit[RADIUS_Q8])
    fit[AREA] = (int(outer[MEAN_AREA]) + int(inner[MEAN_AREA])) >> 1
    dx = int(outer[1]) + int(inner[1]) - BIAS - BIAS
    dy = int(outer[2]) + int(inner[2]) - BIAS - BIAS
    x = (int(fit[X_Q8]) << 2) + (dx >> 1)
    y = (int(fit[Y_Q8]) << 2) + (dy >> 1)
    fit[X_Q10] = x + BIAS
    fit[Y_Q10] = y + BIAS
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
    fit[MOVED_Q10] = value >> 1
    radius += (growth + 2) >> 2
    fit[RADIUS_Q8] = radius
    fit[INNER_Q8] = int(fit[INNER_Q8]) + ((int(inner[0]) - (BIAS - 2)) >> 2)
    ratio = int(fit[INNER_Q10])
    value = int(outer[3]) - BIAS + ((int(inner[3]) - BIAS) << 10) // ratio
    fit[BULGE_COS] = int(fit[BULGE_COS]) + (value >> 1)
    value = int(outer[4]) - BIAS + ((int(inner[4]) - BIAS) << 10) // ratio
    fit[BULGE_SIN] = int(fit[BULGE_SIN]) + (value >> 1)
    dx = int(outer[1]) - int(inner[1])
    dy = int(outer[2]) - int(inner[2])
    if dx >= APART_Q10 or dx <= 0 - APART_Q10 or dy >= APART_Q10 or dy <= 0 - APART_Q10:
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
    value = value * int(fit[BEYOND_Q8])
    fit[TRUE_X_Q10] = x - ((dx * value + 32768) >> 16) + BIAS
    fit[TRUE_Y_Q10] = y - ((dy * value + 32768) >> 16) + BIAS
    return 1


@micropython.viper
def skip_half_sectors(
    skip: ptr8, i: int, bits: int, code: ptr32, least: int, angle: int, reach: int, outer: int, inner: int
) -> int:
    """Marks the half sectors within `reach` of the orientation line (`outer`) and of coding lines (`inner`).

    angle: of the orientation line, clockwise, 0..65535 of a turn, reach likewise, 0..8192; code: result of
    `code_positions`; a coding line has more than `least` in both halves together; bits: 1 or, to mark
    nothing, 0; skip: 32 items, cleared first.
    Returns outer sectors marked + 64 * inner sectors marked."""
    i = 0
    while i < 32:
        skip[i] = 0
        i += 1
    marked = 0
    line = 0
    while line < 4:
        if line and bits:
            i = line * 10 + 2
            if int(code[i]) + int(code[i + 1]) - (BIAS + BIAS) <= least:
                i = 0
        else:
            i = bits
        if i:
            i = (angle + 65536 - reach) >> 11
            last = (angle + 65536 + reach) >> 11
            while i <= last:
                if line:
                    skip[i & 31] = int(skip[i & 31]) | inner
                    marked += 64
                else:
                    skip[i & 31] = int(skip[i & 31]) | outer
                    marked += 1
                i += 1
        angle = (angle + 49152) & 65535
        line += 1
    return marked


@micropython.viper
def mean_area(means: ptr32, i: int, total: int, first: int, count: int) -> int:
    """Mean area of `count` sectors from `first` (any integer >= 0, modulo 16), the middle one left out.

    means: 32 items as `ring_harmonics` leaves them; sectors without crossings do not count; 0 without any."""
    total = 0
    seen = 0
    i = 0
    while i < count:
        area = int(means[16 + ((first + i) & 15)])
        if area > 0 and i != count >> 1:
            total += area
            seen += 1
        i += 1
    if seen > 0:
        total = total // seen
    return total
