"""The orientation line: how pixel rows and columns cross it, and whether it ends where it must.

Angles count clockwise from x, because y points down. Darkness is in units of tables.LOG_GREY_Q8.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_FIT_RADIUS_Q8 = const(6)
_FIT_TRUE_X_Q10 = const(12)
_FIT_TRUE_Y_Q10 = const(13)
_FIT_AREA = const(14)
_FIT_WIDTH = const(20)
_FIT_HEIGHT = const(21)
_SHAPE_LINE_FIRST = const(0)
_SHAPE_LINE_LAST = const(1)
_SHAPE_WINDOW = const(2)
_SHAPE_LINE = const(3)
_SHAPE_IN_LINE = const(4)
_SHAPE_BESIDE = const(6)
_CROSSING_INSIDE = const(0)
_CROSSING_OUTSIDE = const(1)
_CROSSING_AREA_SUM = const(2)
_CROSSING_COUNTED = const(3)
_CROSSING_ROTATION = const(4)
_CROSSING_SLOPE = const(5)
_CROSSING_DISTANCE = const(6)
_CROSSING_AREA = const(7)
_CROSSING_GAP = const(8)
_CROSSING_SLOPE_MOST = const(9)
_CROSSING_ANGLE = const(10)

_SLOPE_MOST = const(65)  # largest steepness of a line,
_SLOPE_SMALL = const(294912)  # and so much more over the radius: short lines are less straight


@micropython.viper
def line_crossings(
    position: int, value: int, base: int, image: ptr8, log: ptr16, circle: ptr16, fit: ptr32, shape: ptr32,
    angle: int, rounds: int, means: ptr32, result: ptr32,
) -> int:  # fmt: skip
    """How the pixel rows (or columns) outside the rings cross a dark radial line from their centre.

    fit: FIT, centre inside the frame, area 0..2**20; angle: clockwise, 0..65535 of a turn, which is measured
    and corrected `rounds` times (1..8); circle: fixed.COSINE; means: 32 items, of the outer ring, as
    `ring_harmonics` left them: the areas beside the line say what it must show in this light, at least half
    and at most the whole of the rings' own; shape: SHAPE.
    Where rows cross obliquely, the radii are narrowed so that a window touches neither the line's end nor
    what lies within. result: CROSSING. Returns the number of crossings inside the frame."""
    width = int(fit[_FIT_WIDTH])
    height = int(fit[_FIT_HEIGHT])
    cx = (int(fit[_FIT_TRUE_X_Q10]) - (_BIAS - 2)) >> 2
    cy = (int(fit[_FIT_TRUE_Y_Q10]) - (_BIAS - 2)) >> 2
    beside = 0
    seen = 0
    i = 0
    while i < 5:
        value = int(means[16 + (((angle >> 12) + 14 + i) & 15)])
        if value > 0 and i != 2:
            beside += value
            seen += 1
        i += 1
    area_unit = int(fit[_FIT_AREA])
    if seen > 0:
        beside = beside // seen
        if beside < area_unit >> 1:
            beside = area_unit >> 1
        if beside < area_unit:
            area_unit = beside
    outer = int(fit[_FIT_RADIUS_Q8])
    result[_CROSSING_SLOPE_MOST] = _SLOPE_MOST + _SLOPE_SMALL // outer
    first = (outer * int(shape[_SHAPE_LINE_FIRST])) >> 10
    last = (outer * int(shape[_SHAPE_LINE_LAST])) >> 10
    window = (outer * int(shape[_SHAPE_WINDOW])) >> 10
    if window < 300:
        window = 300
    if window > 3584:
        window = 3584
    line_width = (outer * int(shape[_SHAPE_LINE])) >> 10
    clip = (area_unit << 5) // line_width << 8
    half_line = line_width >> 1
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
            smaller = major
            major = oblique
            oblique = smaller
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
        length = half + half
        gaps = length - 1
        begin = ((first + window * oblique // major) * major) >> 14
        end = ((last - half_line * oblique // major) * major) >> 14
        if forward < 0:
            forward = 0 - 1
            line = (centre - begin) >> 8
        else:
            forward = 1
            line = (centre + begin + 255) >> 8
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
            distance = (offset << 14) // major
            crossing = centre_along + ((offset * ratio) >> 14)
            pixel = (crossing + 128) >> 8
            if line < 0 or line >= lines or pixel - half < 0 or pixel + half >= pixels:
                outside += 1
            else:
                position = line * line_pitch + (pixel - half) * along
                last_position = position + length * along
                near = int(log[int(image[position])]) + int(log[int(image[position + along])])
                far = int(log[int(image[last_position])]) + int(log[int(image[last_position - along])])
                slope = ((far - near) << 7) // gaps
                base = (near << 7) - (slope >> 1) - clip
                area = 0
                # minus the darkness; two pixels at a time, and the sum of the areas up to each
                value = int(log[int(image[position])]) - (base >> 8)
                if value >> 31:
                    area -= value
                moment = area
                while position < last_position:
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
                value = (area * major) >> 14
                inside += 1
                area_sum += value
                if value > least_area:
                    counted += 1
                    value = (((half + 1) * area - moment) << 10) // area + (((pixel << 8) - crossing) << 2)
                    value = ((value >> 1) * sign) >> 13
                    distance = distance >> 5
                    sum_d += value
                    sum_r += distance
                    sum_dr += value * distance
                    sum_rr += distance * distance
                    if value < 0:
                        value = 0 - value
                    sum_abs += value
            line += forward
            offset += 256
        result[_CROSSING_INSIDE] = inside
        result[_CROSSING_OUTSIDE] = outside
        result[_CROSSING_AREA_SUM] = area_sum
        result[_CROSSING_COUNTED] = counted
        if counted < 1:
            counted = 1
        rotation = ((sum_dr // ((sum_rr >> 8) + 1)) * 10430) >> 15
        result[_CROSSING_ROTATION] = rotation
        angle = (angle + rotation) & 65535
        result[_CROSSING_ANGLE] = angle
        mean = sum_r // counted
        steepness = (sum_dr - mean * sum_d) // (((sum_rr - mean * sum_r) >> 3) + 1)
        if steepness < 0:
            steepness = 0 - steepness
        result[_CROSSING_SLOPE] = steepness
        result[_CROSSING_DISTANCE] = sum_abs // counted
        result[_CROSSING_AREA] = 0
        result[_CROSSING_GAP] = 256
        if inside >= 2 and inside >= outside:
            result[_CROSSING_AREA] = (area_sum << 8) // (inside * area_unit + 1)
            result[_CROSSING_GAP] = ((inside - int(result[_CROSSING_COUNTED])) << 8) // inside
    return inside


@micropython.viper
def line_end(
    x: int, y: int, sine: int, image: ptr8, log: ptr16, circle: ptr16, fit: ptr32, shape: ptr32, angle: int
) -> int:  # fmt: skip
    """How dark it is beyond a line's end against the lighter side there, 256 = as dark as the line itself.

    fit, shape, angle, circle as in `line_crossings`. 0..1024; 0 where a sample would lie outside the frame or
    the line is not dark."""
    width = int(fit[_FIT_WIDTH])
    height = int(fit[_FIT_HEIGHT])
    radius = int(fit[_FIT_RADIUS_Q8])
    index = angle >> 8
    fraction = angle & 255
    cosine = int(circle[index])
    cosine = cosine + (((int(circle[index + 1]) - cosine) * fraction) >> 8) - 32768
    index = (index + 64) & 255
    sine = int(circle[index])
    sine = 32768 - sine - (((int(circle[index + 1]) - sine) * fraction) >> 8)
    side = (radius * int(shape[_SHAPE_BESIDE])) >> 10
    in_line = 0
    depth = 0
    place = 0
    while place < 2:
        in_line = depth
        distance = (radius * int(shape[_SHAPE_IN_LINE + place])) >> 10
        place += 1
        lighter = 0
        grey = 0
        sample = 0
        while sample < 3:
            # beside, beside, in the line
            x = distance * cosine
            y = distance * sine
            if sample == 0:
                x -= side * sine
                y += side * cosine
            elif sample == 1:
                x += side * sine
                y -= side * cosine
            x = (((int(fit[_FIT_TRUE_X_Q10]) - (_BIAS - 514)) >> 2) + (x >> 14)) >> 8
            y = (((int(fit[_FIT_TRUE_Y_Q10]) - (_BIAS - 514)) >> 2) + (y >> 14)) >> 8
            if x < 1 or y < 1 or x + 1 >= width or y + 1 >= height:
                return 0
            position = y * width + x
            grey = int(log[int(image[position])]) << 1
            grey += int(log[int(image[position - 1])]) + int(log[int(image[position + 1])])
            grey += int(log[int(image[position - width])]) + int(log[int(image[position + width])])
            if sample < 2 and grey > lighter:
                lighter = grey
            sample += 1
        # of the last sample, the one in the line
        depth = lighter - grey
    if in_line <= 0 or depth <= 0:
        return 0
    share = (depth << 8) // in_line
    if share > 1024:
        share = 1024
    return share
