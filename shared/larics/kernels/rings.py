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

# items as in kernels.layouts
_BIAS = const(1 << 24)
_FIT_X_Q8 = const(0)
_FIT_Y_Q8 = const(1)
_FIT_WINDOW_Q8 = const(2)
_FIT_CLIP = const(3)
_FIT_LEAST_AREA = const(4)
_FIT_LIMIT_Q10 = const(5)
_FIT_RADIUS_Q8 = const(6)
_FIT_BULGE_COS = const(8)
_FIT_BULGE_SIN = const(9)
_FIT_X_Q10 = const(10)
_FIT_Y_Q10 = const(11)
_FIT_AREA = const(14)
_FIT_INNER_Q10 = const(16)
_FIT_LINE_Q10 = const(17)
_FIT_GAP_Q10 = const(18)
_FIT_WIDTH = const(20)
_FIT_HEIGHT = const(21)
_POSITION_NEAR_MEAN = const(2)
_POSITION_FAR_MEAN = const(3)
_POSITION_ITEMS = const(6)


@micropython.viper
def begin_pass(fit: ptr32, limit: int) -> int:
    """Sets what a pass over both rings takes from the pose so far; `limit` as in `RingFit.refine`.

    fit: FIT, radii up to 20480, area 0..2**20. Returns 1, or 0 when the outer radius is below 6 px or the
    centre outside the frame."""
    x = (int(fit[_FIT_X_Q10]) - (_BIAS - 2)) >> 2
    y = (int(fit[_FIT_Y_Q10]) - (_BIAS - 2)) >> 2
    if x < 0 or y < 0 or (x >> 8) >= int(fit[_FIT_WIDTH]) or (y >> 8) >= int(fit[_FIT_HEIGHT]):
        return 0
    radius = int(fit[_FIT_RADIUS_Q8])
    if radius < 1536:
        return 0
    fit[_FIT_X_Q8] = x
    fit[_FIT_Y_Q8] = y
    # to the middle of the gap between the rings; with large rings, less of it will do
    window = (radius * int(fit[_FIT_GAP_Q10])) >> 10
    if window < 300:
        window = 300
    if window > 640:
        window = (window * 7) >> 3
        if window < 640:
            window = 640
        if window > 3584:
            window = 3584
    fit[_FIT_WINDOW_Q8] = window
    fit[_FIT_LIMIT_Q10] = (window * limit) >> 6
    line = (radius * int(fit[_FIT_LINE_Q10])) >> 10
    area = int(fit[_FIT_AREA])
    if area > 0:
        # later passes clip an eighth of the depth
        fit[_FIT_CLIP] = (area << 5) // line
        fit[_FIT_LEAST_AREA] = (area * 3) >> 3
    else:
        fit[_FIT_CLIP] = 8
        fit[_FIT_LEAST_AREA] = (line * 12) >> 8  # about 4 of 100 grey levels deep
    return 1


@micropython.viper
def ring_crossings(
    position: int, value: int, base: int, image: ptr8, log: ptr16, fit: ptr32, lines: int, roots: ptr16,
    skip: ptr8, sectors: ptr32,
) -> int:  # fmt: skip
    """Where pixel rows (within 45 degrees of x) and columns (the others) cross the dark lines of both rings.

    Each crossing is the centroid of what is darker than the straight line between the window's ends by more
    than a clip; no pixel is interpolated. fit: FIT as `begin_pass` left it: centre inside the frame, radii
    (1024..20480) and window (half width, 256..radius / 4) in 1/256 px, bulge (+-8192) and largest residual
    that counts in 1/1024 px, clip and smallest darkness times width that counts (log units * px). lines:
    crossings a quarter ring, about; roots: tables.ROOT. sectors: 16 of the outer and 16 of the inner ring x
    (crossings inside the frame, their area, those that count, sum of residual + 32768 in 1/1024 px) are
    added to. Returns the number of crossings tried."""
    width = int(fit[_FIT_WIDTH])
    height = int(fit[_FIT_HEIGHT])
    cx = int(fit[_FIT_X_Q8])
    cy = int(fit[_FIT_Y_Q8])
    window = int(fit[_FIT_WINDOW_Q8])
    clip = int(fit[_FIT_CLIP]) << 8
    limit = int(fit[_FIT_LIMIT_Q10])
    least_area = int(fit[_FIT_LEAST_AREA])
    measured = 0
    ring = 0
    while ring < 2:
        radius = int(fit[_FIT_RADIUS_Q8 + ring])
        bulge_cos = int(fit[_FIT_BULGE_COS]) - _BIAS
        bulge_sin = int(fit[_FIT_BULGE_SIN]) - _BIAS
        if ring:
            bulge_cos = (bulge_cos * int(fit[_FIT_INNER_Q10])) >> 10
            bulge_sin = (bulge_sin * int(fit[_FIT_INNER_Q10])) >> 10
        step = ((radius * 362) >> 16) // lines
        if step < 1:
            step = 1
        skip_bit = 1 << ring
        radius2 = radius * radius
        wide = window * radius
        first_slot = ring << 6
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
            reach = (radius * 181) >> 16
            line = ((centre + 128) >> 8) - reach
            last = line + reach + reach
            while line < 0:
                line += step
            if last >= rows:
                last = rows - 1
            while line <= last:
                offset = (line << 8) - centre
                value = offset
                if value >> 31:
                    value = 0 - value
                height_q8 = (radius * int(roots[(value << 7) // radius])) >> 14
                height_q8 = (height_q8 + (radius2 - offset * offset) // height_q8) >> 1
                half = (wide // height_q8 + 128) >> 8
                across_q10 = (offset << 10) // radius
                along_q10 = (height_q8 << 10) // radius
                value = across_q10
                if value >> 31:
                    value = 0 - value
                sector = 0
                if value >= 200:
                    sector = 1
                    if value >= 392:
                        sector = 2
                        if value >= 569:
                            sector = 3
                bulge = ((along_q10 * along_q10 - across_q10 * across_q10) >> 10) * bulge_cos
                skewed = ((along_q10 * across_q10) >> 9) * bulge_sin
                if swap:
                    bulge = 0 - bulge
                    sector = 7 - sector
                    if across_q10 >> 31:
                        sector = 15 - sector
                elif across_q10 >> 31:
                    sector = 31 - sector
                line_start = line * line_pitch
                gaps = half + half
                length = gaps * along
                gaps -= 1
                crossing = centre_along + height_q8
                side = 0
                while side < 2:
                    pixel = (crossing + 128) >> 8
                    value = pixel - half
                    if not int(skip[sector]) & skip_bit and not (value | (pixels - 1 - half - pixel)) >> 31:
                        measured += 1
                        position = line_start + value * along
                        end = position + length
                        value = int(log[int(image[position])])
                        near = value + int(log[int(image[position + along])])
                        far = int(log[int(image[end])]) + int(log[int(image[end - along])])
                        slope = ((far - near) << 7) // gaps
                        base = (near << 7) - (slope >> 1) - clip
                        area = 0
                        # minus the darkness
                        value -= base >> 8
                        if value >> 31:
                            area = 0 - value
                        # the sum of the areas up to each pixel, by those of two and of four at once
                        moment = area
                        if half & 1:
                            position += along
                            base += slope
                            value = int(log[int(image[position])]) - (base >> 8)
                            if value >> 31:
                                area -= value
                            position += along
                            base += slope
                            value = int(log[int(image[position])]) - (base >> 8)
                            if value >> 31:
                                area -= value
                                moment += value
                            moment += area << 1
                        while position < end:
                            position += along
                            base += slope
                            value = int(log[int(image[position])]) - (base >> 8)
                            if value >> 31:
                                area -= value
                            position += along
                            base += slope
                            value = int(log[int(image[position])]) - (base >> 8)
                            if value >> 31:
                                area -= value
                                moment += value
                            position += along
                            base += slope
                            value = int(log[int(image[position])]) - (base >> 8)
                            if value >> 31:
                                area -= value
                                moment += value + value
                            position += along
                            base += slope
                            value = int(log[int(image[position])]) - (base >> 8)
                            if value >> 31:
                                area -= value
                                moment += value * 3
                            moment += area << 2
                        position = ((sector & 30) << 1) + first_slot
                        value = (area * along_q10) >> 10
                        sectors[position] = int(sectors[position]) + 1
                        sectors[position + 1] = int(sectors[position + 1]) + value
                        if value > least_area:
                            value = (((half + 1) * area - moment) << 10) // area
                            value += ((pixel << 8) - crossing) << 2
                            value = value * along_q10
                            if side:
                                value = 0 - value
                            value = ((value + 512) >> 10) - ((bulge + skewed) >> 10)
                            if value < limit and 0 - limit < value:
                                sectors[position + 2] = int(sectors[position + 2]) + 1
                                sectors[position + 3] = int(sectors[position + 3]) + value + 32768
                    # the other side of the ring
                    sector = 15 - sector
                    if swap:
                        sector += 16
                    elif sector < 0:
                        sector += 32
                    skewed = 0 - skewed
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
        marks = bits
        if line and bits:
            slot = line * 2 * _POSITION_ITEMS
            value = int(code[slot + _POSITION_NEAR_MEAN]) + int(code[slot + _POSITION_FAR_MEAN])
            if value - (_BIAS + _BIAS) <= least:
                marks = 0
        if marks:
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
