"""The blur-model reader on the rings: samples in polar coordinates, and the radius where the rings are.

Units as in larics.kernels.blur.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_CIRCLE_X_Q8 = const(0)
_CIRCLE_Y_Q8 = const(1)
_CIRCLE_RADIUS_Q8 = const(2)
_CIRCLE_E1 = const(3)
_CIRCLE_E2 = const(4)
_CIRCLE_HX = const(5)
_CIRCLE_HY = const(6)
_CIRCLE_WIDTH = const(7)
_CIRCLE_HEIGHT = const(8)
_FAN_DIRECTIONS = const(0)
_FAN_STEP = const(1)
_FAN_START = const(2)
_FAN_FIRST = const(3)
_FAN_COUNT = const(4)
_SCAN_FIRST = const(0)
_SCAN_PITCH = const(1)
_SCAN_COUNT = const(2)
_SCAN_LEAST = const(3)
_SCAN_LAST = const(4)
_SCAN_REFERENCE = const(5)


@micropython.viper
def polar_samples(
    value: int, position: int, image: ptr8, y: int, pose: ptr32, fan: ptr32, cosines: ptr16, cosine: int,
    sine: int, samples: ptr16,
) -> int:  # fmt: skip
    """samples[k * count + i] = grey at unit first + i in direction k of an oblique circle, interpolated.

    pose: CIRCLE; fan: FAN, turned by (cosine, sine) * 2**14; cosines: tables.COSINE_Q14_BIASED. A point u (in
    radii) in direction v lies at (I + (e1 e2, e2 -e1)) v u (1 + h v u). Returns 1, or 0 when a sample would
    lie outside the frame."""
    width = int(pose[_CIRCLE_WIDTH])
    height = int(pose[_CIRCLE_HEIGHT])
    cx = int(pose[_CIRCLE_X_Q8]) - _BIAS
    cy = int(pose[_CIRCLE_Y_Q8]) - _BIAS
    radius = int(pose[_CIRCLE_RADIUS_Q8])
    e1 = int(pose[_CIRCLE_E1]) - _BIAS
    e2 = int(pose[_CIRCLE_E2]) - _BIAS
    hx = int(pose[_CIRCLE_HX]) - _BIAS
    hy = int(pose[_CIRCLE_HY]) - _BIAS
    directions = int(fan[_FAN_DIRECTIONS])
    step = int(fan[_FAN_STEP])
    entry = int(fan[_FAN_START])
    first = int(fan[_FAN_FIRST])
    count = int(fan[_FAN_COUNT])
    k = 0
    slot = 0
    while k < directions:
        c0 = int(cosines[entry & 255]) - 32768
        s0 = 32768 - int(cosines[(entry & 255) + 64])
        entry += step
        c = (c0 * cosine - s0 * sine) >> 14
        s = (s0 * cosine + c0 * sine) >> 14
        dx = c + ((e1 * c + e2 * s) >> 14)
        dy = s + ((e2 * c - e1 * s) >> 14)
        bend = (hx * c + hy * s) >> 14
        dx = ((radius * dx) // 24) >> 6
        dy = ((radius * dy) // 24) >> 6
        bend_x = (dx * bend // 24) >> 14
        bend_y = (dy * bend // 24) >> 14
        last = first + count - 1
        x = ((cx << 8) + last * dx + last * last * bend_x) >> 16
        y = ((cy << 8) + last * dy + last * last * bend_y) >> 16
        if x < 0 or y < 0 or x + 1 >= width or y + 1 >= height:
            return 0
        x = (cx << 8) + first * dx + first * first * bend_x
        y = (cy << 8) + first * dy + first * first * bend_y
        if x < 0 or y < 0 or (x >> 16) + 1 >= width or (y >> 16) + 1 >= height:
            return 0
        dx += bend_x * (first + first + 1)
        dy += bend_y * (first + first + 1)
        bend_x += bend_x
        bend_y += bend_y
        bends = bend_x | bend_y
        end = slot + count
        while slot - end:
            position = (y >> 16) * width + (x >> 16)
            fraction = (x >> 8) & 255
            value = int(image[position])
            upper = (value << 8) + (int(image[position + 1]) - value) * fraction
            position += width
            value = int(image[position])
            value = (value << 8) + (int(image[position + 1]) - value) * fraction
            samples[slot] = (upper + (((value - upper) * ((y >> 8) & 255)) >> 8) + 8) >> 4
            slot += 1
            x += dx
            y += dy
            if bends:
                dx += bend_x
                dy += bend_y
        k += 1
    return 1


@micropython.viper
def circle_samples(
    slot: int, x: int, image: ptr8, width: int, cx: int, cy: int, cosines: ptr16, directions: int,
    wanted: int, scan: ptr32, samples: ptr16,
) -> int:  # fmt: skip
    """samples[k * count + i] = grey of the pixel at the distance first + i * pitch in direction k + 1/2.

    Only of directions k for which bit k & 7 of `wanted` is set; the others' items are left alone. scan: SCAN,
    of which the radii to try are given and the rest is set; cx, cy: 1/256 px; directions: a power of two, 8
    to 128; cosines: tables.COSINE_Q14_BIASED. All must lie inside the frame. Returns 0."""
    least = int(scan[_SCAN_LEAST])
    last = int(scan[_SCAN_LAST])
    pitch = least // 20
    if pitch < 24:
        pitch = 24
    before = least * 13 // 24 // pitch
    first = before * pitch
    count = last * 29 // 24 // pitch - before + 2
    scan[_SCAN_FIRST] = first
    scan[_SCAN_PITCH] = pitch
    scan[_SCAN_COUNT] = count
    scan[_SCAN_REFERENCE] = (least + last) >> 1
    step = 256 // directions
    entry = step >> 1
    slot = 0
    k = 0
    while k < directions:
        if (wanted >> (k & 7)) & 1 == 0:
            slot += count
            entry += step
            k += 1
            continue
        k += 1
        dx = int(cosines[entry]) - 32768
        dy = 32768 - int(cosines[entry + 64])
        entry += step
        x = (cx << 8) + (dx * first >> 6) + 32768
        y = (cy << 8) + (dy * first >> 6) + 32768
        dx = dx * pitch >> 6
        dy = dy * pitch >> 6
        end = slot + count
        while slot - end:
            samples[slot] = int(image[(y >> 16) * width + (x >> 16)]) << 4
            x += dx
            y += dy
            slot += 1
    return 0


@micropython.viper
def mean_samples(
    slot: int, i: int, samples: ptr16, apart: int, sectors: int, count: int, means: ptr16
) -> int:
    """means[s * count + i] = mean of the directions 2 s and 2 s + 1, with their offset removed.

    apart: from one of those directions to the other, `count`, or 0 for sectors of one direction each. The
    `count` (even) means of a sector are relative to their own mean + 32768; that one follows the last
    sector's: means[sectors * count + s]. Returns the number of sectors."""
    sector = 0
    i = 0
    slot = 0
    while sector < sectors:
        whole = 0
        end = slot + count
        while slot - end:
            value = (int(samples[i]) + int(samples[i + apart])) >> 1
            means[slot] = value
            whole += value
            value = (int(samples[i + 1]) + int(samples[i + apart + 1])) >> 1
            means[slot + 1] = value
            whole += value
            i += 2
            slot += 2
        i += apart
        whole = whole // count
        means[sectors * count + sector] = whole
        whole = 32768 - whole
        slot -= count
        while slot - end:
            means[slot] = int(means[slot]) + whole
            means[slot + 1] = int(means[slot + 1]) + whole
            slot += 2
        sector += 1
    return sectors


@micropython.viper
def sector_radii(
    position: int, product: int, profile: ptr16, samples: ptr16, scan: ptr32, templates: ptr16, sums: ptr32,
    least_match: int, shifts: ptr32, sector: int, hop: int, whole: int,
) -> int:  # fmt: skip
    """The outer radius where the template of both rings correlates best, in every hop-th of 32 sectors.

    The first is `sector`, an even one. samples: those of `circle_samples` in 32 directions; scan: SCAN, radii
    are tried in steps of 1/20; templates and sums: one template of blur.ring_templates and its sums; profile:
    an item a sample, scratch space. shifts: for each sector the distance from the reference (1/1024 px) +
    2**20, or 0 where the correlation's square is below least_match (1/1024), and 0 of the next sector.
    Returns `whole` plus the sum of those squares."""
    count = int(scan[_SCAN_COUNT])
    first = int(scan[_SCAN_FIRST])
    pitch = int(scan[_SCAN_PITCH])
    last = int(scan[_SCAN_LAST])
    reference = int(scan[_SCAN_REFERENCE])
    square = (int(sums[0]) >> 6) + 1
    while sector < 32:
        left = ((sector + 31) & 31) * count
        right = ((sector + 1) & 31) * count
        i = sector * count
        position = 0
        while position - count:
            product = int(samples[left]) + int(samples[right]) + (int(samples[i]) << 1)
            profile[position] = product >> 2
            left += 1
            right += 1
            i += 1
            position += 1
        best = 0
        best_radius = 0
        most = 0
        radius = int(scan[_SCAN_LEAST])
        while radius <= last:
            step = (radius << 8) // (24 * pitch)
            start = 13 * step - (first << 8) // pitch + 128
            position = start
            product = 0
            product -= int(profile[position >> 8]) * (int(templates[0]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[1]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[2]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[3]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[4]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[5]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[6]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[7]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[8]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[9]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[10]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[11]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[12]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[13]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[14]) - 32768)
            position += step
            product -= int(profile[position >> 8]) * (int(templates[15]) - 32768)
            # the rings are not where half as much was found elsewhere
            if product > most >> 1:
                if product > most:
                    most = product
                position = start
                offset = int(profile[position >> 8])
                total = 0
                power = 0
                i = 0
                while i - 16:
                    value = int(profile[position >> 8]) - offset
                    total += value
                    power += value * value
                    position += step
                    i += 1
                total = total >> 2
                power = power - total * total + 16
                if power > 0:
                    value = (product << 4) // square
                    if power < 1048576:
                        value = value * ((product << 7) // ((power >> 6) + 1)) >> 13
                    else:
                        value = value * ((product << 3) // ((power >> 10) + 1)) >> 13
                    if value > best:
                        best = value
                        best_radius = radius
            radius += radius // 20
        whole += best
        shifts[sector] = 0
        shifts[sector + 1] = 0
        if best >= least_match:
            shifts[sector] = ((best_radius - reference) << 2) + 1048576
        sector += hop
    return whole


@micropython.viper
def line_shade(image: ptr8, x: int, y: int, pose: ptr32, cosines: ptr16, shades: ptr32) -> int:
    """How dark the darkest direction outside the rings is, in 256ths of the rings' mean depth.

    pose: CIRCLE, of which no perspective counts; cosines: tables.COSINE_Q14_BIASED. Each of 64 directions
    is seen at the units 28 to 32, in the nearest pixels; it is compared with the lighter of the 4 to 8
    directions to one side and those to the other, the less light of both. Rings less deep than half a grey
    level count as that deep. shades: 128 items, scratch space, of which the first receives in how many
    directions unit 20, between the rings, is darker than the units 32 and 8. Returns at most 8191; 8192, and
    none of these directions, when something lies outside the frame."""
    width = int(pose[_CIRCLE_WIDTH])
    height = int(pose[_CIRCLE_HEIGHT])
    cx = ((int(pose[_CIRCLE_X_Q8]) - _BIAS) << 8) + 32768
    cy = ((int(pose[_CIRCLE_Y_Q8]) - _BIAS) << 8) + 32768
    radius = int(pose[_CIRCLE_RADIUS_Q8])
    e1 = int(pose[_CIRCLE_E1]) - _BIAS
    e2 = int(pose[_CIRCLE_E2]) - _BIAS
    rings = 0
    band = 0
    k = 0
    while k < 64:
        c = int(cosines[(k << 2) + 2]) - 32768
        s = 32768 - int(cosines[(k << 2) + 66])
        dx = c + ((e1 * c + e2 * s) >> 14)
        dy = s + ((e2 * c - e1 * s) >> 14)
        dx = ((radius * dx) // 24) >> 6
        dy = ((radius * dy) // 24) >> 6
        x = cx + (dx << 5)
        y = cy + (dy << 5)
        if x < 0 or y < 0 or x >> 16 >= width or y >> 16 >= height:
            shades[0] = 0
            return 8192
        outside = int(image[(y >> 16) * width + (x >> 16)])
        x -= dx
        y -= dy
        value = outside + int(image[(y >> 16) * width + (x >> 16)])
        x -= dx
        y -= dy
        value += int(image[(y >> 16) * width + (x >> 16)])
        x -= dx
        y -= dy
        value += int(image[(y >> 16) * width + (x >> 16)])
        x -= dx
        y -= dy
        shades[k] = value + int(image[(y >> 16) * width + (x >> 16)])
        x -= dx << 2
        y -= dy << 2
        rings -= int(image[(y >> 16) * width + (x >> 16)])
        x -= dx << 2
        y -= dy << 2
        value = int(image[(y >> 16) * width + (x >> 16)])
        rings += value << 1
        x -= dx << 2
        y -= dy << 2
        rings -= int(image[(y >> 16) * width + (x >> 16)])
        x -= dx << 3
        y -= dy << 3
        if value < outside and value < int(image[(y >> 16) * width + (x >> 16)]):
            band += 1
        k += 1
    k = 0
    while k < 64:
        value = int(shades[k])
        shades[k + 64] = int(shades[(k + 63) & 63]) + value + value + int(shades[(k + 1) & 63])
        k += 1
    deepest = 0
    k = 0
    while k < 64:
        value = int(shades[((k + 59) & 63) + 64]) + int(shades[((k + 57) & 63) + 64])
        value += int(shades[((k + 58) & 63) + 64])
        other = int(shades[((k + 5) & 63) + 64]) + int(shades[((k + 7) & 63) + 64])
        other += int(shades[((k + 6) & 63) + 64])
        if other < value:
            value = other
        value -= int(shades[k + 64]) * 3
        if value > deepest:
            deepest = value
        k += 1
    shades[0] = band
    # 60 pixels against 128
    if rings < 64:
        rings = 64
    value = deepest * 546 // rings
    if value > 8191:
        value = 8191
    return value
