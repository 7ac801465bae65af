"""The orientation line: how pixel rows and columns cross it, and whether it ends where it must.

Angles count clockwise from x, because y points down. Darkness is in units of tables.LOG_GREY_Q8.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_BIAS = const(1 << 24)  # what may be negative is stored with this added: ptr32 loads differ in their sign
_RADIUS_Q8 = const(6)  # items as in kernels.rings: FIT
_TRUE_X_Q10 = const(12)
_TRUE_Y_Q10 = const(13)
_AREA = const(14)


@micropython.viper
def line_crossings(
    position: int, value: int, base: int, image: ptr8, log: ptr16, circle: ptr16, width: int, height: int,
    fit: ptr32, shape: ptr32, angle: int, rounds: int, means: ptr32, result: ptr32,
) -> int:  # fmt: skip
    """How the pixel rows (or columns) outside the rings cross a dark radial line from their centre.

    fit: kernels.rings: FIT, centre inside the frame, area 0..2**20; angle: clockwise, 0..65535 of a turn,
    which is measured and corrected `rounds` times (1..8); circle: fixed.COSINE; means: 32 items, of the outer
    ring, as `ring_harmonics` left them: the areas beside the line say what it must show in this light, at
    least half and at most the whole of the rings' own; shape: for an outer radius of 1024 the radii where
    the line's measuring begins and ends (below 2048), half the window, the line's width.
    Where rows cross obliquely, the radii are narrowed so that a window touches neither the line's end nor
    what lies within. result: crossings inside the frame, outside, their area, crossings with at least 3/8
    of the rings' area, rotation (1/65536 turn, to be added to the clockwise angle), steepness of the
    centroids against the radius (1/1024), their mean distance from the line (1/1024 px), mean area of a
    crossing and share of those with less (256 = as the rings', 256 = all), largest steepness to be
    expected, corrected angle. Returns the number of crossings inside the frame."""
    cx = (int(fit[_TRUE_X_Q10]) - (_BIAS - 2)) >> 2
    cy = (int(fit[_TRUE_Y_Q10]) - (_BIAS - 2)) >> 2
    area_unit = 0
    seen = 0
    i = 0
    while i < 5:
        value = int(means[16 + (((angle >> 12) + 14 + i) & 15)])
        if value > 0 and i != 2:
            area_unit += value
            seen += 1
        i += 1
    value = int(fit[_AREA])
    if seen > 0:
        area_unit = area_unit // seen
        if area_unit < value >> 1:
            area_unit = value >> 1
        if area_unit < value:
            value = area_unit
    area_unit = value
    radius = int(fit[_RADIUS_Q8])
    result[9] = 65 + 294912 // radius  # short lines are less straight
    first = (radius * int(shape[0])) >> 10
    last = (radius * int(shape[1])) >> 10
    window = (radius * int(shape[2])) >> 10
    if window < 300:
        window = 300
    if window > 3584:
        window = 3584
    half_line = (radius * int(shape[3])) >> 10
    clip = (area_unit << 5) // half_line
    half_line = half_line >> 1
    least_area = (area_unit * 3) >> 3
    inside = 0
    while rounds > 0:
        rounds -= 1
        index = angle >> 8
        fraction = angle & 255
        cosine = int(circle[index])
        cosine = cosine + (((int(circle[index + 1]) - cosine) * fraction) >> 8) - 32768
        index = (index + 64) & 255
        sine = int(circle[index])
        sine = 32768 - sine - (((int(circle[index + 1]) - sine) * fraction) >> 8)
        major = cosine
        oblique = sine
        if major < 0:
            major = 0 - major
        if oblique < 0:
            oblique = 0 - oblique
        along = width
        line_pitch = 1
        centre = cx
        centre_along = cy
        lines = width
        pixels = height
        minor = sine
        sign = cosine
        forward = sign
        if major < oblique:
            value = major
            major = oblique
            oblique = value
            along = 1
            line_pitch = width
            centre = cy
            centre_along = cx
            lines = height
            pixels = width
            minor = cosine
            forward = sine
            sign = 0 - sine
        ratio = (minor << 14) // major
        half = ((window << 14) // major + 128) >> 8
        value = first + window * oblique // major
        end = last - half_line * oblique // major
        value = (value * major) >> 14
        end = (end * major) >> 14
        if forward < 0:
            forward = 0 - 1
            line = (centre - value) >> 8
        else:
            forward = 1
            line = (centre + value + 255) >> 8
        inside = 0
        outside = 0
        counted = 0
        area_sum = 0
        sum_d = 0
        sum_r = 0
        sum_dr = 0
        sum_rr = 0
        sum_abs = 0
        offset = ((line << 8) - centre) * forward
        while offset <= end:
            radius = (offset << 14) // major
            crossing = centre_along + ((offset * ratio) >> 14)
            pixel = (crossing + 128) >> 8
            if line < 0 or line >= lines or pixel - half < 0 or pixel + half >= pixels:
                outside += 1
            else:
                position = line * line_pitch + (pixel - half) * along
                value = position + (half + half) * along
                near = int(log[int(image[position])]) + int(log[int(image[position + along])])
                far = int(log[int(image[value])]) + int(log[int(image[value - along])])
                slope = ((far - near) << 7) // (half + half - 1)
                base = (near << 7) - (slope >> 1) - (clip << 8)
                area = 0
                moment = 0
                i = half + half
                while i >= 0:
                    value = (base >> 8) - int(log[int(image[position])])
                    if value > 0:
                        area += value
                    moment += area
                    position += along
                    base += slope
                    i -= 1
                value = (area * major) >> 14
                inside += 1
                area_sum += value
                if value > least_area:
                    counted += 1
                    value = (((half + 1) * area - moment) << 10) // area + (((pixel << 8) - crossing) << 2)
                    value = ((value >> 1) * sign) >> 13
                    radius = radius >> 5
                    sum_d += value
                    sum_r += radius
                    sum_dr += value * radius
                    sum_rr += radius * radius
                    if value < 0:
                        value = 0 - value
                    sum_abs += value
            line += forward
            offset += 256
        result[0] = inside
        result[1] = outside
        result[2] = area_sum
        result[3] = counted
        if counted < 1:
            counted = 1
        value = sum_dr // ((sum_rr >> 8) + 1)
        value = (value * 10430) >> 15
        result[4] = value
        angle = (angle + value) & 65535
        result[10] = angle
        radius = sum_r // counted
        value = ((sum_rr - radius * sum_r) >> 3) + 1
        value = (sum_dr - radius * sum_d) // value
        if value < 0:
            value = 0 - value
        result[5] = value
        result[6] = sum_abs // counted
        result[7] = 0
        result[8] = 256
        if inside >= 2 and inside >= outside:
            result[7] = (area_sum << 8) // (inside * area_unit + 1)
            result[8] = ((inside - int(result[3])) << 8) // inside
    return inside


@micropython.viper
def line_end(
    x: int, y: int, sine: int, image: ptr8, log: ptr16, circle: ptr16, width: int, height: int, fit: ptr32,
    shape: ptr32, angle: int,
) -> int:  # fmt: skip
    """How dark it is beyond a line's end against the lighter side there, 256 = as dark as the line itself.

    fit, angle, circle as in `line_crossings`; shape: items 4, 5, 6 are, for an outer radius of 1024, the
    radius of samples in the line, of those beyond its end, and the distance of samples beside (below 512).
    0..1024; 0 where a sample would lie outside the frame or the line is not dark."""
    radius = int(fit[_RADIUS_Q8])
    index = angle >> 8
    fraction = angle & 255
    cosine = int(circle[index])
    cosine = cosine + (((int(circle[index + 1]) - cosine) * fraction) >> 8) - 32768
    index = (index + 64) & 255
    sine = int(circle[index])
    sine = 32768 - sine - (((int(circle[index + 1]) - sine) * fraction) >> 8)
    side = (radius * int(shape[6])) >> 10
    in_line = 0
    depth = 0
    place = 0
    while place < 2:
        in_line = depth
        distance = (radius * int(shape[4 + place])) >> 10
        place += 1
        lighter = 0
        depth = 0
        index = 0
        while index < 3:
            # beside, beside, in the line
            x = distance * cosine
            y = distance * sine
            if index == 0:
                x -= side * sine
                y += side * cosine
            elif index == 1:
                x += side * sine
                y -= side * cosine
            x = (((int(fit[_TRUE_X_Q10]) - (_BIAS - 514)) >> 2) + (x >> 14)) >> 8
            y = (((int(fit[_TRUE_Y_Q10]) - (_BIAS - 514)) >> 2) + (y >> 14)) >> 8
            if x < 1 or y < 1 or x + 1 >= width or y + 1 >= height:
                return 0
            x = y * width + x
            depth = int(log[int(image[x])]) << 1
            depth += int(log[int(image[x - 1])]) + int(log[int(image[x + 1])])
            depth += int(log[int(image[x - width])]) + int(log[int(image[x + width])])
            if index < 2 and depth > lighter:
                lighter = depth
            index += 1
        depth = lighter - depth
    if in_line <= 0 or depth <= 0:
        return 0
    depth = (depth << 8) // in_line
    if depth > 1024:
        depth = 1024
    return depth
