"""What lies where the coding lines may be, inside the rings.

Angles count clockwise from x, because y points down. Darkness is in units of tables.LOG_GREY_Q8.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_BIAS = const(1 << 24)  # what may be negative is stored with this added: ptr32 loads differ in their sign


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
