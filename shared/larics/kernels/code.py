"""What lies where the coding lines may be, inside the rings.

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
_SHAPE_WINDOW = const(2)
_SHAPE_LINE = const(3)
_SHAPE_BEYOND = const(5)
_SHAPE_CODE_FIRST = const(11)
_SHAPE_CODE_LAST = const(12)
_SHAPE_CODE_RADII = const(13)
_SHAPE_CODE_OPENING = const(14)
_POSITION_NEAR = const(0)
_POSITION_FAR = const(1)
_POSITION_NEAR_MEAN = const(2)
_POSITION_FAR_MEAN = const(3)
_POSITION_LEVEL = const(4)
_POSITION_ROUGH = const(5)
_POSITION_ITEMS = const(6)
_STROKE_STEP_Q10 = const(41)  # of the radius, between samples across a stroke
_LINE_SEEN = const(2 * _BIAS + 250)  # of both halves of a position with a line


@micropython.viper
def code_positions(
    value: int, position: int, y: int, image: ptr8, log: ptr16, circle: ptr16, fit: ptr32, shape: ptr32,
    angle: int, result: ptr32,
) -> int:  # fmt: skip
    """What lies at eight positions around the centre, 45 degrees apart, counterclockwise as seen.

    At the radii that `shape` (SHAPE) gives, nine interpolated samples across the position, as far as half the
    line and its window to both sides, but at most the opening; the farthest sample within 32768/256 px of the
    centre. The baseline is the darker of the two ends. fit: FIT, area 0..2**20; angle: of the first position,
    clockwise, 0..65535 of a turn; circle: fixed.COSINE.
    result: POSITION for each position.
    Returns 1, or 0 when a sample would lie outside the frame."""
    width = int(fit[_FIT_WIDTH])
    height = int(fit[_FIT_HEIGHT])
    cx = (int(fit[_FIT_TRUE_X_Q10]) - (_BIAS - 2)) >> 2
    cy = (int(fit[_FIT_TRUE_Y_Q10]) - (_BIAS - 2)) >> 2
    outer = int(fit[_FIT_RADIUS_Q8])
    line = (outer * int(shape[_SHAPE_LINE])) >> 10
    window = (line >> 1) + ((outer * int(shape[_SHAPE_WINDOW])) >> 11)
    opening = int(shape[_SHAPE_CODE_OPENING])
    radii = int(shape[_SHAPE_CODE_RADII])
    first = (outer * int(shape[_SHAPE_CODE_FIRST])) >> 10
    pitch = (((outer * int(shape[_SHAPE_CODE_LAST])) >> 10) - first) // (radii - 1)
    clip = (int(fit[_FIT_AREA]) << 5) // line
    unit = (int(fit[_FIT_AREA]) + 1) * (radii >> 1)
    square = (int(fit[_FIT_AREA]) << 8) // line
    if square > 4095:
        square = 4095
    # of a line's depth, divided by 64, as what is divided by it is multiplied by 4
    square = ((square * square) >> 6) + 1
    index = angle >> 8
    fraction = angle & 255
    cosine = int(circle[index])
    cosine = cosine + (((int(circle[index + 1]) - cosine) * fraction) >> 8) - 32768
    index = (index + 64) & 255
    sine = int(circle[index])
    sine = 32768 - sine - (((int(circle[index + 1]) - sine) * fraction) >> 8)
    slot = 0
    while slot < 8 * _POSITION_ITEMS:
        near_area = 0
        near_mean = 0
        area = 0
        mean = 0
        level = 0
        rough = 0
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
            end_x = x + (dx << 3)
            end_y = y + (dy << 3)
            if x < 0 or y < 0 or end_x < 0 or end_y < 0:
                return 0
            if (x >> 8) + 1 >= width or (end_x >> 8) + 1 >= width:
                return 0
            if (y >> 8) + 1 >= height or (end_y >> 8) + 1 >= height:
                return 0
            # the samples of the line between the two ends, which make the baseline
            base = 0
            value = 0
            sum = 0
            squares = 0
            moment = 0
            i = 0
            while i - 9:
                position = (y >> 8) * width + (x >> 8)
                fraction = x & 255
                value = int(image[position])
                upper = (value << 8) + (int(image[position + 1]) - value) * fraction
                position += width
                value = int(image[position])
                value = (value << 8) + (int(image[position + 1]) - value) * fraction
                value = int(log[(upper + (((value - upper) * (y & 255)) >> 8) + 128) >> 8])
                if not i:
                    base = value
                sum += value
                value -= base
                moment += value * i
                squares += value * value
                x += dx
                y += dy
                i += 1
            # of the last sample, which the line between both ends goes through
            rise = value
            value += base
            sum = sum - base - value
            rough += squares - rise * rise - ((rise * ((moment - (rise << 3) << 2) - rise * 35)) >> 4)
            level += base + value
            mean += (((base + value) * 7 >> 1) - sum) * spacing
            if value < base:
                base = value
            deeper = (base - clip) * 7 - sum
            if deeper > 0:
                area += deeper * spacing
            radius += pitch
            left -= 1
            if left + left == radii:
                near_area = area
                near_mean = mean
                area = 0
                mean = 0
        result[slot + _POSITION_NEAR] = near_area // unit
        result[slot + _POSITION_FAR] = area // unit
        result[slot + _POSITION_NEAR_MEAN] = near_mean // unit + _BIAS
        result[slot + _POSITION_FAR_MEAN] = mean // unit + _BIAS
        result[slot + _POSITION_LEVEL] = level // (radii + radii)
        rough = (rough << 2) // square
        if rough > 65535:
            rough = 65535
        result[slot + _POSITION_ROUGH] = rough
        slot += _POSITION_ITEMS
        turned = ((cosine + sine) * 11585) >> 14
        sine = ((sine - cosine) * 11585) >> 14
        cosine = turned
    return 1


@micropython.viper
def stroke_beyond(
    x: int, y: int, value: int, image: ptr8, log: ptr16, circle: ptr16, fit: ptr32, shape: ptr32, angle: int,
    code: ptr32,
) -> int:  # fmt: skip
    """How dark the darkest stroke is that goes on between the rings beyond a coding line, 256 = as they are.

    Looked at is each of three positions of `code` (as from `code_positions`) that is as dark as a line. Of
    seven pixels across, at the radius that `shape` (SHAPE) gives beyond a line's end: the darkest of the
    middle three below the lighter of the two outermost, on the darker side: an edge is none. Less where some
    lie outside the frame. fit: FIT, area 0..2**20; angle: of the first position, clockwise, 0..65535 of a
    turn; circle: fixed.COSINE."""
    width = int(fit[_FIT_WIDTH])
    outer = int(fit[_FIT_RADIUS_Q8])
    darkest = 0
    slot = 2 * _POSITION_ITEMS
    while slot < 8 * _POSITION_ITEMS:
        angle = (angle - 16384) & 65535
        if int(code[slot + _POSITION_NEAR_MEAN]) + int(code[slot + _POSITION_FAR_MEAN]) >= _LINE_SEEN:
            i = ((angle + 128) >> 8) & 255
            cosine = int(circle[i]) - 32768
            sine = 32768 - int(circle[(i + 64) & 255])
            side = 0 - outer * 3
            before = 0
            dark = 1 << 16
            after = 0
            i = 0
            while i < 7:
                # the radius and, across, 6 mm of 150
                value = (outer * int(shape[_SHAPE_BEYOND])) >> 10
                y = (side * _STROKE_STEP_Q10) >> 10
                x = (cosine * value - sine * y) >> 14
                y = (sine * value + cosine * y) >> 14
                x = (((int(fit[_FIT_TRUE_X_Q10]) - (_BIAS - 514)) >> 2) + x) >> 8
                y = (((int(fit[_FIT_TRUE_Y_Q10]) - (_BIAS - 514)) >> 2) + y) >> 8
                value = 0
                if x >= 0 and y >= 0 and x < width and y < int(fit[_FIT_HEIGHT]):
                    value = int(log[int(image[y * width + x])])
                if i < 2:
                    if value > before:
                        before = value
                elif i > 4:
                    if value > after:
                        after = value
                elif value < dark:
                    dark = value
                side += outer
                i += 1
            if after < before:
                before = after
            if before - dark > darkest:
                darkest = before - dark
        slot += 2 * _POSITION_ITEMS
    value = (int(fit[_FIT_AREA]) << 8) // ((outer * int(shape[_SHAPE_LINE])) >> 10) + 1
    return (darkest << 8) // value
