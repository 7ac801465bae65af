"""The blur-model reader on the rings: samples in polar coordinates, and the radius where the rings are.

Units as in larics.kernels.blur.
"""

try:
    import micropython
except ImportError:
    from larics._cpython import micropython, ptr8, ptr16, ptr32


@micropython.viper
def polar_samples(
    image: ptr8, x: int, y: int, position: int, width: int, height: int, cx: int, cy: int, cosines: ptr16,
    directions: int, table_step: int, table_first: int, cosine: int, sine: int, radius: int, e1: int, e2: int,
    hx: int, hy: int, first: int, count: int, samples: ptr16,
) -> int:  # fmt: skip
    """samples[k * count + i] = grey at unit first + i in direction k, interpolated, of an oblique circle.

    cx, cy, radius (1024..24576): 1/256 px; cosines: tables.COSINE_Q14_BIASED, used from entry table_first in
    steps of table_step, turned by (cosine, sine) * 2**14; e1, e2: the ellipse, hx, hy: the perspective, all
    * 2**14 and within +-4096. A point u (in radii) in direction v lies at (I + (e1 e2, e2 -e1)) v u (1 + h v
    u). first + count <= 48. Returns 1, or 0 when a sample would lie outside the frame."""
    k = 0
    slot = 0
    entry = table_first
    while k < directions:
        c0 = int(cosines[entry & 255]) - 32768
        s0 = 32768 - int(cosines[(entry & 255) + 64])
        entry += table_step
        c = (c0 * cosine - s0 * sine) >> 14
        s = (s0 * cosine + c0 * sine) >> 14
        dx = c + ((e1 * c + e2 * s) >> 14)
        dy = s + ((e2 * c - e1 * s) >> 14)
        bend = (hx * c + hy * s) >> 14
        dx = ((radius * dx) // 24) >> 6
        dy = ((radius * dy) // 24) >> 6
        bend_x = (dx * bend // 24) >> 14
        bend_y = (dy * bend // 24) >> 14
        i = first + count - 1
        x = ((cx << 8) + i * dx + i * i * bend_x) >> 16
        y = ((cy << 8) + i * dy + i * i * bend_y) >> 16
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
        i = slot + count
        while slot < i:
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
            dx += bend_x
            dy += bend_y
        k += 1
    return 1


@micropython.viper
def circle_samples(
    image: ptr8, x: int, y: int, width: int, cx: int, cy: int, cosines: ptr16, directions: int, first: int,
    pitch: int, count: int, samples: ptr16,
) -> int:  # fmt: skip
    """samples[k * count + i] = grey of the pixel at the distance first + i * pitch in direction k + 1/2.

    cx, cy, first, pitch: 1/256 px; directions: a power of two, at most 128; cosines:
    tables.COSINE_Q14_BIASED. All must lie inside the frame. Returns 0."""
    step = 256 // directions
    entry = step >> 1
    slot = 0
    while directions > 0:
        directions -= 1
        dx = int(cosines[entry]) - 32768
        dy = 32768 - int(cosines[entry + 64])
        entry += step
        x = (cx << 8) + (dx * first >> 6) + 32768
        y = (cy << 8) + (dy * first >> 6) + 32768
        dx = dx * pitch >> 6
        dy = dy * pitch >> 6
        end = slot + count
        while slot < end:
            samples[slot] = int(image[(y >> 16) * width + (x >> 16)]) << 4
            x += dx
            y += dy
            slot += 1
    return 0


@micropython.viper
def mean_samples(
    samples: ptr16, i: int, slot: int, apart: int, sectors: int, count: int, means: ptr16
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
        while slot < end:
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
        while slot < end:
            means[slot] = int(means[slot]) + whole
            means[slot + 1] = int(means[slot + 1]) + whole
            slot += 2
        sector += 1
    return sectors


@micropython.viper
def sector_radii(
    profile: ptr16, position: int, product: int, samples: ptr16, count: int, first: int, pitch: int,
    least: int, last: int, reference: int, templates: ptr16, square: int, least_match: int, shifts: ptr32,
) -> int:  # fmt: skip
    """The outer radius of the rings in every other of 32 sectors, where the template of both correlates best.

    samples: `count` greys in each of 32 directions, from the distance `first` on in steps of `pitch` (1/256
    px, like the radii); radii from `least` to `last` are tried in steps of 1/20; templates and square: one
    template of blur.ring_templates and its sum of squares; profile: `count` items, scratch space. shifts: for
    each sector the distance from the radius `reference` (1/1024 px) + 2**20, or 0 where the correlation's
    square is below least_match (1/1024). Returns the sum of those squares."""
    whole = 0
    square = (square >> 6) + 1
    sector = 0
    while sector < 32:
        left = ((sector + 31) & 31) * count
        right = ((sector + 1) & 31) * count
        i = sector * count
        position = 0
        while position < count:
            product = int(samples[left]) + int(samples[right]) + (int(samples[i]) << 1)
            profile[position] = product >> 2
            left += 1
            right += 1
            i += 1
            position += 1
        best = 0
        best_radius = 0
        most = 0
        radius = least
        while radius <= last:
            step = (radius << 8) // (24 * pitch)
            start = 13 * step - (first << 8) // pitch + 128
            position = start
            product = 0
            i = 0
            while i < 16:
                product -= int(profile[position >> 8]) * (int(templates[i]) - 32768)
                position += step
                product -= int(profile[position >> 8]) * (int(templates[i + 1]) - 32768)
                position += step
                product -= int(profile[position >> 8]) * (int(templates[i + 2]) - 32768)
                position += step
                product -= int(profile[position >> 8]) * (int(templates[i + 3]) - 32768)
                position += step
                i += 4
            # the rings are not where half as much was found elsewhere
            if product > most >> 1:
                if product > most:
                    most = product
                position = start
                offset = int(profile[position >> 8])
                total = 0
                power = 0
                i = 0
                while i < 16:
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
        sector += 2
    return whole
