"""The two rings: what a pass takes from their pose, and how they cross pixel rows and columns.

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
    lines: int, roots: ptr16, skip: ptr8, sectors: ptr32,
) -> int:  # fmt: skip
    """Where pixel rows (within 45 degrees of x) and columns (the others) cross the dark lines of both rings.

    Each crossing is the centroid of what is darker than the straight line between the window's ends by more
    than a clip; no pixel is interpolated. `fit` as `begin_pass` left it: centre inside the frame, radii
    (1024..20480) and window (half width, 256..radius / 4) in 1/256 px, bulge (+-8192) and largest residual
    that counts in 1/1024 px, clip and smallest darkness times width that counts (log units * px). lines:
    crossings a quarter ring, about; roots: tables.ROOT. sectors: 16 of the outer and 16 of the inner ring x
    (crossings inside the frame, their area, those that count, sum of residual + 32768 in 1/1024 px) are
    added to. Returns the number of crossings tried."""
    cx = int(fit[X_Q8])
    cy = int(fit[Y_Q8])
    window = int(fit[WINDOW_Q8])
    clip = int(fit[CLIP])
    limit = int(fit[LIMIT_Q10])
    least_area = int(fit[LEAST_AREA])
    measured = 0
    ring = 0
    while ring < 2:
        radius = int(fit[RADIUS_Q8 + ring])
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
        radius2 = radius * radius
        swap = 0
        while swap < 2:
            if swap:
                along = width
                line_pitch = 1
                centre = cx
                centre_along = cy
                rows = width
                pixels = height
            else:
                along = 1
                line_pitch = width
                centre = cy
                centre_along = cx
                rows = height
                pixels = width
            last = (radius * 181) >> 16
            line = ((centre + 128) >> 8) - last
            last = line + last + last
            while line < 0:
                line += step
            if last >= rows:
                last = rows - 1
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
                        end = position + (half + half) * along
                        near = int(log[int(image[position])]) + int(log[int(image[position + along])])
                        far = int(log[int(image[end])]) + int(log[int(image[end - along])])
                        slope = ((far - near) << 7) // (half + half - 1)
                        base = (near << 7) - (slope >> 1) - (clip << 8)
                        area = 0
                        moment = 0
                        value = (base >> 8) - int(log[int(image[position])])
                        if value > 0:
                            area = value
                            moment = value
                        while position < end:
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
                        base = ((sector >> 1) << 2) + (ring << 6)
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
        ring += 1
    return measured


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
