"""Radial lines: which directions are dark around the rings, and what a line at a given angle looks like.

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


@micropython.viper
def annulus_profile(
    image: ptr8, x: int, y: int, total: int, log: ptr16, cosine: ptr16, width: int, height: int, cx: int,
    cy: int, first: int, pitch: int, samples: int, stride: int, profile: ptr16,
) -> int:  # fmt: skip
    """profile[k] = 1 + sum of the log greys of `samples` nearest pixels in direction k * stride / 256 turn.

    cx, cy, first (radius) and pitch (between samples) in 1/256 px, radii below 32768; samples 1..16; 256 //
    stride items; 0 where a sample would lie outside the frame. Returns the number of directions inside the
    frame."""
    # without a test for each direction when the whole annulus lies inside the frame
    x = (first + pitch * samples) >> 8
    near_border = 1
    if (cx >> 8) > x and (cy >> 8) > x and (cx >> 8) + x + 2 < width and (cy >> 8) + x + 2 < height:
        near_border = 0
    inside = 0
    k = 0
    slot = 0
    while k < 256:
        dx = int(cosine[k]) - 32768
        dy = 32768 - int(cosine[k + 64])
        x = cx + 128 + ((first * dx) >> 14)
        y = cy + 128 + ((first * dy) >> 14)
        dx = (pitch * dx) >> 14
        dy = (pitch * dy) >> 14
        total = 0
        i = samples
        if near_border:
            end_x = x + dx * samples
            end_y = y + dy * samples
            if x < 256 or y < 256 or end_x < 256 or end_y < 256:
                i = 0
            if (x >> 8) >= width or (y >> 8) >= height or (end_x >> 8) >= width or (end_y >> 8) >= height:
                i = 0
        if i > 0:
            inside += 1
            total = 1
        while i > 0:
            total += int(log[int(image[(y >> 8) * width + (x >> 8)])])
            x += dx
            y += dy
            i -= 1
        profile[slot] = total
        slot += 1
        k += stride
    return inside


@micropython.viper
def dark_directions(
    profile: ptr16, k: int, depth: int, directions: int, near: int, far: int, apart: int, depths: ptr16,
    capacity: int, result: ptr32,
) -> int:  # fmt: skip
    """The directions that are darker than both their sides, darkest first, as (direction, depth) in `result`.

    The sides are the means of the directions `near` and `far` steps away (below `directions`); picks lie
    more than `apart` steps apart and are at least 3/8 as deep as the first. depths: scratch space, one item
    per direction. Returns their number, at most `capacity`."""
    k = 0
    while k < directions:
        depth = int(profile[k])
        depths[k] = 0
        if depth > 0:
            i = k + near
            if i >= directions:
                i -= directions
            j = k + far
            if j >= directions:
                j -= directions
            side = int(profile[i]) + int(profile[j])
            i = k - near
            if i < 0:
                i += directions
            j = k - far
            if j < 0:
                j += directions
            other = int(profile[i]) + int(profile[j])
            if other < side:
                side = other
            depth = (side >> 1) - depth
            if depth > 0:
                depths[k] = depth
        k += 1
    picked = 0
    least = 1
    while picked < capacity:
        best = 0
        where = 0
        k = 0
        while k < directions:
            depth = int(depths[k])
            if depth > best:
                best = depth
                where = k
            k += 1
        if best < least:
            return picked
        if picked == 0:
            least = (best * 3 >> 3) + 1
        result[picked + picked] = where
        result[picked + picked + 1] = best
        picked += 1
        i = where - apart
        j = 0
        while j <= apart + apart:
            k = i + j
            if k < 0:
                k += directions
            if k >= directions:
                k -= directions
            depths[k] = 0
            j += 1
    return picked


@micropython.viper
def line_crossings(
    position: int, value: int, base: int, image: ptr8, log: ptr16, circle: ptr16, width: int, height: int,
    fit: ptr32, shape: ptr32, angle: int, area_unit: int, result: ptr32,
) -> int:  # fmt: skip
    """How the pixel rows (or columns) outside the rings cross a dark radial line from their centre.

    fit: kernels.rings: FIT, centre inside the frame; angle: clockwise, 0..65535 of a turn; circle:
    fixed.COSINE; area_unit: darkness times width of the rings (log units * px); shape: for an outer radius of
    1024 the radii where the line's measuring begins and ends (below 2048), half the window, the line's width.
    Where rows cross obliquely, the radii are narrowed so that a window touches neither the line's end nor
    what lies within. result: crossings inside the frame, outside, their area, crossings with at least 3/8
    of the rings' area, rotation (1/65536 turn, to be added to the clockwise angle), steepness of the
    centroids against the radius (1/1024), their mean distance from the line (1/1024 px), mean area of a
    crossing and share of those with less (256 = as the rings', 256 = all), largest steepness to be
    expected. Returns the number of crossings inside the frame."""
    cx = (int(fit[_TRUE_X_Q10]) - (_BIAS - 2)) >> 2
    cy = (int(fit[_TRUE_Y_Q10]) - (_BIAS - 2)) >> 2
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
    result[4] = (value * 10430) >> 15
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


@micropython.viper
def code_positions(
    position: int, x: int, y: int, image: ptr8, log: ptr16, circle: ptr16, width: int, height: int, cx: int,
    cy: int, angle: int, first: int, pitch: int, radii: int, window: int, opening: int, clip: int,
    area_unit: int, result: ptr32,
) -> int:  # fmt: skip
    """What lies at eight positions around (cx, cy), 45 degrees apart, counterclockwise as seen.

    At `radii` (even, 2..16) radii from `first` in steps of `pitch`, nine interpolated samples across the
    position, as far as `window` to both sides but at most opening/256 of the radius; all 1/256 px, the
    farthest sample within 32768 of the centre. The baseline is the darker of the two ends. angle: of the
    first position, clockwise, 0..65535 of a turn; circle: fixed.COSINE; clip: log units; area_unit: 1..65535,
    log units * px.
    result, for each position: area of the nearer half of the radii below the darker end, of the farther half,
    both again below the mean of the ends (+ BIAS, may be negative), all as 256ths of area_unit; mean of the
    ends.
    Returns 1, or 0 when a sample would lie outside the frame."""
    index = angle >> 8
    fraction = angle & 255
    cosine = int(circle[index])
    cosine = cosine + (((int(circle[index + 1]) - cosine) * fraction) >> 8) - 32768
    index = (index + 64) & 255
    sine = int(circle[index])
    sine = 32768 - sine - (((int(circle[index + 1]) - sine) * fraction) >> 8)
    unit = area_unit * (radii >> 1)
    slot = 0
    while slot < 40:
        near_area = 0
        near_mean = 0
        area = 0
        mean = 0
        level = 0
        radius = first
        left = radii
        while left > 0:
            half = (radius * opening) >> 8
            if half > window:
                half = window
            spacing = half >> 2
            dx = (0 - sine * spacing) >> 14
            dy = (cosine * spacing) >> 14
            x = cx + ((radius * cosine) >> 14) - (dx << 2)
            y = cy + ((radius * sine) >> 14) - (dy << 2)
            base = x + (dx << 3)
            end = y + (dy << 3)
            if x < 0 or y < 0 or base < 0 or end < 0:
                return 0
            if (x >> 8) + 1 >= width or (base >> 8) + 1 >= width:
                return 0
            if (y >> 8) + 1 >= height or (end >> 8) + 1 >= height:
                return 0
            # the samples of the line between the two ends, which make the baseline
            base = 0
            value = 0
            sum = 0
            i = 0
            while i < 9:
                position = (y >> 8) * width + (x >> 8)
                fraction = x & 255
                value = int(image[position])
                upper = (value << 8) + (int(image[position + 1]) - value) * fraction
                position += width
                value = int(image[position])
                value = (value << 8) + (int(image[position + 1]) - value) * fraction
                value = int(log[(upper + (((value - upper) * (y & 255)) >> 8) + 128) >> 8])
                if i == 0:
                    base = value
                sum += value
                x += dx
                y += dy
                i += 1
            end = value
            sum = sum - base - end
            level += base + end
            mean += (((base + end) * 7 >> 1) - sum) * spacing
            if end < base:
                base = end
            sum = (base - clip) * 7 - sum
            if sum > 0:
                area += sum * spacing
            radius += pitch
            left -= 1
            if left + left == radii:
                near_area = area
                near_mean = mean
                area = 0
                mean = 0
        result[slot] = near_area // unit
        result[slot + 1] = area // unit
        result[slot + 2] = near_mean // unit + _BIAS
        result[slot + 3] = mean // unit + _BIAS
        result[slot + 4] = level // (radii + radii)
        slot += 5
        value = ((cosine + sine) * 11585) >> 14
        sine = ((sine - cosine) * 11585) >> 14
        cosine = value
    return 1
