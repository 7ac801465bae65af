"""The blur-model reader on the lines: how much of a blurred radial line lies where.

Units as in larics.kernels.blur. A bar is the profile of a blurred line, 24 items for the distances 0..23 from
its middle; across a line at angle phi it is the profile of the rings at phi + 90 degrees.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr16, ptr32

_BAR = const(24)  # as in kernels.layouts
_ALONG = const(408)
_STILL = const(32)
_FAN_DIRECTIONS = const(0)
_FAN_STEP = const(1)
_FAN_START = const(2)
_FAN_FIRST = const(3)
_FAN_COUNT = const(4)
_ZONE_FIRST = const(0)
_ZONE_COUNT = const(1)
_ZONE_SLOT = const(2)


@micropython.viper
def line_template(
    bars: ptr16, i: int, value: int, across: int, middle: int, cosines: ptr16, fan: ptr32, zones: ptr32,
    zone: int, template: ptr16, slot: int,
) -> int:  # fmt: skip
    """template[slot + k] = mean darkness of a blurred line over a zone's units, k directions from its own.

    For k = 0 to half the directions of the fan (FAN); 0 from where it is below 1/256 on. zones: ZONEs, zone:
    the first item of one; across: entry of the bar
    across the line; the one along it is at ALONG, its middle (1/256 unit) from the rings' centre. Returns the
    farthest direction that is not 0."""
    directions = (int(fan[_FAN_DIRECTIONS]) >> 1) + 1
    step = int(fan[_FAN_STEP])
    first = int(fan[_FAN_FIRST]) + int(zones[zone + _ZONE_FIRST])
    count = int(zones[zone + _ZONE_COUNT])
    reach = 0
    k = 0
    while k < directions:
        cosine = int(cosines[k * step]) - 32768
        sine = 32768 - int(cosines[k * step + 64])
        if sine < 0:
            sine = 0 - sine
        total = 0
        x = first * cosine
        y = first * sine
        unit = 0
        while unit < count:
            value = y >> 6
            if value < 5888:
                i = across + (value >> 8)
                dark = int(bars[i])
                if dark > 0:
                    dark += (int(bars[i + 1]) - dark) * (value & 255) >> 8
                    value = (x >> 6) - middle
                    if value < 0:
                        value = 0 - value
                    if value < 5888:
                        i = _ALONG + (value >> 8)
                        part = int(bars[i])
                        part += (int(bars[i + 1]) - part) * (value & 255) >> 8
                        total += part * dark >> 10
            else:
                unit = count
            x += cosine
            y += sine
            unit += 1
        total = total // count
        if total < 4:
            # everything beyond is lighter still
            while k < directions:
                template[slot + k] = 0
                k += 1
        else:
            template[slot + k] = total
            reach = k
        k += 1
    return reach


@micropython.viper
def erase_line(
    samples: ptr16, i: int, value: int, across: int, middle: int, bars: ptr16, cosines: ptr16, fan: ptr32,
    cosine: int, sine: int, amplitude: int, reach: int,
) -> int:  # fmt: skip
    """Brightens the `samples` of a fan by what a blurred line has darkened.

    The line lies in the direction (cosine, sine) * 2**14; amplitude: of the rings, 1/16 grey level; reach:
    distance (1/256 unit, below 5888) from where on the bar across is 0; the rest as in line_template.
    Returns 0."""
    directions = int(fan[_FAN_DIRECTIONS])
    step = int(fan[_FAN_STEP])
    start = int(fan[_FAN_START])
    first = int(fan[_FAN_FIRST])
    count = int(fan[_FAN_COUNT])
    k = 0
    reach = reach << 6
    while k < directions:
        i = k * step + start
        c0 = int(cosines[i]) - 32768
        s0 = 32768 - int(cosines[i + 64])
        x = (c0 * cosine + s0 * sine) >> 14
        y = (s0 * cosine - c0 * sine) >> 14
        if y < 0:
            y = 0 - y
        if x > 0 and y * first < reach:
            dx = x
            dy = y
            x = x * first
            y = y * first
            slot = k * count
            end = slot + count
            while slot < end and y < reach:
                i = across + (y >> 14)
                dark = int(bars[i])
                dark += (int(bars[i + 1]) - dark) * (y >> 6 & 255) >> 8
                value = (x >> 6) - middle
                if value < 0:
                    value = 0 - value
                if value < 5888:
                    i = _ALONG + (value >> 8)
                    part = int(bars[i])
                    part += (int(bars[i + 1]) - part) * (value & 255) >> 8
                    samples[slot] = int(samples[slot]) + ((part * dark >> 10) * amplitude >> 10)
                x += dx
                y += dy
                slot += 1
        k += 1
    return 0


@micropython.viper
def ink_profile(
    samples: ptr16, i: int, value: int, fan: ptr32, zones: ptr32, zone: int, levels: ptr16, angle: int,
    bars: ptr16, motion_axis: int, ink: ptr16, skirts: ptr16,
) -> int:  # fmt: skip
    """ink[slot + k] = darkness of a zone's samples of direction k less the rings' skirts there + 32768.

    samples: of a fan; zones, zone: as in line_template; levels: as from sectors.sector_levels; direction k
    lies at angle + 2 k steps (1/256 of half a turn); motion_axis: 1/32 of half a turn or STILL; bars: those
    of all rels; skirts: 17 items, scratch space. value: a register for what is at
    hand. Returns 0."""
    directions = int(fan[_FAN_DIRECTIONS])
    step = int(fan[_FAN_STEP]) << 1
    pitch = int(fan[_FAN_COUNT])
    base = int(zones[zone + _ZONE_FIRST])
    unit = int(fan[_FAN_FIRST]) + base
    count = int(zones[zone + _ZONE_COUNT])
    slot = int(zones[zone + _ZONE_SLOT])
    i = 0
    while i < 17:
        skirts[i] = 65535
        i += 1
    k = 0
    rel = 0
    skirt = 65535
    while k < directions:
        if motion_axis < _STILL:
            rel = ((angle - (motion_axis << 3) + 4) >> 3) & 31
            if rel > 16:
                rel = 32 - rel
            skirt = int(skirts[rel])
        if skirt == 65535:
            skirt = 0
            bar = rel * _BAR
            i = unit - 24
            while i < unit + count - 24:
                # how far from the outer ring, and from the inner one
                value = i
                if value < 0:
                    value = 0 - value
                if value < 24:
                    skirt += int(bars[bar + value])
                value = i + 8
                if value < 0:
                    value = 0 - value
                if value < 24:
                    skirt += int(bars[bar + value])
                i += 1
            skirt = skirt // count
            skirts[rel] = skirt
        value = 0
        i = base
        end = base + count
        while i < end:
            value += int(samples[i])
            i += 1
        i = (angle >> 4) & 31
        value = int(levels[32 + i]) * count - value
        value = (value << 8) // ((int(levels[i]) * count >> 2) + 1) - skirt
        if value > 8191:
            value = 8191
        if value < 0 - 8191:
            value = 0 - 8191
        ink[slot + k] = value + 32768
        base += pitch
        angle += step
        k += 1
    return 0


@micropython.viper
def line_depths(
    i: int, j: int, ink: ptr16, fan: ptr32, templates: ptr16, angle: int, motion_axis: int, first: int,
    last: int, depths: ptr16,
) -> int:  # fmt: skip
    """depths[k] = how much of a line lies in direction k (1/256 of one) + 32768, for first <= k <= last.

    The lesser of two fits, to the directions on either side and the line itself, so that the edge of a shadow
    is not half a line; directions that are hardly dark are not measured. ink: one item a direction, the whole
    turn or all that lies within 9 of first and last;
    templates: 15 items for every other rel, for 0..14 directions from the line; the rest as in ink_profile.
    Returns 0."""
    directions = int(fan[_FAN_DIRECTIONS])
    step = int(fan[_FAN_STEP]) << 1
    before = 0 - 1
    mean = 0
    square = 0
    rest = 0
    k = first
    while k <= last:
        rel = 0
        if motion_axis < _STILL:
            rel = ((angle + k * step - (motion_axis << 3) + 4) >> 3) & 31
            if rel > 16:
                rel = 32 - rel
        base = (rel >> 1) * 15
        if base != before:
            # 12 directions are compared, 9 to one side and 2 to the other
            before = base
            mean = int(templates[base]) + int(templates[base + 1]) + int(templates[base + 2])
            i = base + 1
            while i < base + 10:
                mean += int(templates[i])
                i += 1
            mean = mean // 12
            value = int(templates[base]) - mean
            rest = value
            square = 64 + value * value
            i = base + 1
            while i < base + 10:
                value = int(templates[i]) - mean
                rest += value
                square += value * value
                if i < base + 3:
                    rest += value
                    square += value * value
                i += 1
            square = square >> 6
        least = 0 - 16383
        if (int(ink[k]) - 32768) * 4 >= int(templates[base]):
            least = 1 << 28
            side = 0 - 1
            while side < 2:
                mean_ink = 0
                product = 0
                i = k - side - side
                j = 0 - 2
                while j < 10:
                    if i < 0:
                        i += directions
                    elif i >= directions:
                        i -= directions
                    value = int(ink[i]) - 32768
                    mean_ink += value
                    if j < 0:
                        product += (int(templates[base - j]) - mean) * value
                    else:
                        product += (int(templates[base + j]) - mean) * value
                    i += side
                    j += 1
                value = ((product - mean_ink // 12 * rest) << 2) // square
                if value < least:
                    least = value
                side += 2
        if least > 16383:
            least = 16383
        if least < 0 - 16383:
            least = 0 - 16383
        depths[k] = least + 32768
        k += 1
    return 0


@micropython.viper
def deepest(depths: ptr16, k: int, value: int, directions: int, apart: int, result: ptr32) -> int:
    """result: the deepest direction, its depth + 32768, that of the deepest more than `apart` steps away.

    Returns the deepest direction."""
    best = 0
    where = 0
    k = 0
    while k < directions:
        value = int(depths[k])
        if value > best:
            best = value
            where = k
        k += 1
    second = 0
    k = apart + 1
    while k < directions - apart:
        value = where + k
        if value >= directions:
            value -= directions
        value = int(depths[value])
        if value > second:
            second = value
        k += 1
    result[0] = where
    result[1] = best
    result[2] = second
    return where


@micropython.viper
def line_residual(
    ink: ptr16, k: int, total: int, templates: ptr16, base: int, half: int, middle: int, depth: int
) -> int:
    """Mean residual of `ink` (2 * half + 1 items around `middle`) when a line of that depth is taken out.

    templates: 15 items from `base` on; half up to 14; depth in 1/256 line, up to 16383. Returns 1/1024 of the
    rings' darkness."""
    mean = 0
    k = 0 - half
    while k <= half:
        i = k
        if i < 0:
            i = 0 - i
        mean += int(ink[middle + k]) - 32768 - (depth * int(templates[base + i]) >> 8)
        k += 1
    mean = mean // (half + half + 1)
    total = 0
    k = 0 - half
    while k <= half:
        i = k
        if i < 0:
            i = 0 - i
        i = int(ink[middle + k]) - 32768 - (depth * int(templates[base + i]) >> 8) - mean
        if i < 0:
            i = 0 - i
        total += i
        k += 1
    return total // (half + half + 1)


@micropython.viper
def ink_noise(ink: ptr16, k: int, total: int, directions: int, apart: int) -> int:
    """Mean second difference of the ink of directions `apart` steps from each other: twice their noise.

    Those that are more than three times the mean so far are a line's or an edge's and left out. ink:
    `directions` items, the whole turn. Returns the mean, 1/1024 of the rings' darkness."""
    limit = 1 << 20
    rounds = 4
    while rounds > 0:
        rounds -= 1
        total = 0
        used = 0
        k = 0
        while k < directions:
            i = k + apart
            if i >= directions:
                i -= directions
            value = k - apart
            if value < 0:
                value += directions
            value = int(ink[k]) + int(ink[k]) - int(ink[i]) - int(ink[value])
            if value < 0:
                value = 0 - value
            if value < limit:
                total += value
                used += 1
            k += 1
        limit = total * 3 // (used + 1) + 3
    return total // (used + 1)


@micropython.viper
def line_turn(
    ink: ptr16, i: int, value: int, templates: ptr16, base: int, half: int, middle: int, result: ptr32
) -> int:
    """How far a line lies off the middle of `ink` (2 * half + 1 items around `middle`): a Gauss-Newton step.

    Only the odd part counts, less its linear trend, so that neither depth nor shading matters. templates: 15
    items from `base` on; half 4..13. result: the offset in 1/256 direction + 2**20. Returns 0."""
    square = 64
    linear = 0
    cross = 0
    product = 0
    trend = 0
    even = 0
    even_square = 64
    mean = 0
    k = 1
    while k <= half:
        value = int(templates[base + k])
        mean += value
        k += 1
    mean = (mean + mean + int(templates[base])) // (half + half + 1)
    k = 0
    while k <= half:
        value = int(templates[base + k]) - mean
        even_square += value * value
        i = int(ink[middle + k]) + int(ink[middle - k]) - 65536
        even += value * (i >> 1)
        if k:
            even_square += value * value
            even += value * (i >> 1)
            i = int(ink[middle + k]) - int(ink[middle - k])
            value = (int(templates[base + k - 1]) - int(templates[base + k + 1])) >> 1
            square += value * value
            linear += k * k
            cross += k * value
            product += value * (i >> 1)
            trend += k * (i >> 1)
        k += 1
    # product' = product - trend * cross / linear, square' = square - cross^2 / linear
    value = (cross << 4) // linear
    product = product - (trend * value >> 4)
    square = square - (cross * value >> 4)
    if square < 64:
        square = 64
    even = (even << 2) // (even_square >> 6)
    if even < 16:
        even = 16
    value = (product << 2) // (square >> 6)
    value = (value << 8) // even
    if value > 65536:
        value = 65536
    if value < 0 - 65536:
        value = 0 - 65536
    result[0] = value + 1048576
    return 0
