"""The two rings: coarse radius from the edges, crossings with pixel rows and columns, robust harmonics.

Angles of the rings are counted clockwise from x, because y points down; a ring is divided into 16 sectors of
22.5 degrees, sector 0 beginning at x, and into 32 half sectors. Darkness is measured in units of
tables.LOG_GREY_Q8 (256 per octave of grey + 16), so that it does not depend on the light.
"""

try:
    import micropython
except ImportError:
    from larics._cpython import micropython, ptr8, ptr16, ptr32


@micropython.viper
def edge_distances(
    edges: ptr32, position: int, x: int, y: int, count: int, width: int, cx: int, cy: int, reach: int,
    half_line: int, slack: int, axes: ptr16, distances: ptr32, capacity: int,
) -> int:  # fmt: skip
    """Distances to the candidate centre of the edges that point to it within `slack`, as ring radii.

    All lengths in 1/16 px: cx, cy 0..16384, reach 0..4096, half_line 0..256. `edges`: position |
    direction << 20; `axes`: cosine and sine of the 48 directions, * 2**14 + 32768; `distances` receives
    distance | direction from the centre << 16, at most `capacity` items. Returns their number."""
    kept = 0
    i = 0
    while i < count:
        position = int(edges[i])
        i += 1
        y = (position & 1048575) // width
        x = (((position & 1048575) - y * width) << 4) - cx
        if x < reach and 0 - reach < x:
            y = (y << 4) - cy
            if y < reach and 0 - reach < y:
                position = position >> 20
                cosine = int(axes[position << 1]) - 32768
                sine = int(axes[(position << 1) + 1]) - 32768
                off = (x * sine - y * cosine) >> 14
                if off < slack and 0 - slack < off:
                    x = (x * cosine + y * sine) >> 14
                    if x < 0:
                        x = half_line - x
                        position += 24
                        if position >= 48:
                            position -= 48
                    else:
                        x = x - half_line
                    if x > 0 and x < reach:
                        distances[kept] = x | (position << 16)
                        kept += 1
                        if kept >= capacity:
                            i = count
    return kept


@micropython.viper
def choose_radius(
    histogram: ptr8, bin: int, value: int, first: int, last: int, bins: int, inner_q10: int, distances: ptr32,
    count: int, axes: ptr16, rounds: int, result: ptr32,
) -> int:  # fmt: skip
    """The outer radius whose two rings have most edges, with steps of the centre by least squares.

    first..last: outer radii to try, half pixels, 4 <= first * inner_q10 / 1024, last + 3 <= bins; histogram:
    `bins` items, scratch space; inner_q10: ratio of the rings * 1024; distances (below 8 * bins) and axes
    as in `edge_distances`; rounds: 1..4. result: radius, shift in x, in y (1/16 px), edges on the outer
    ring, on the inner one. Returns the number of edges on both."""
    shift_x = 0
    shift_y = 0
    radius = 0
    mean = 0
    on_outer = 0
    on_inner = 0
    while rounds > 0:
        rounds -= 1
        bin = 0
        while bin < bins:
            histogram[bin] = 0
            bin += 1
        i = 0
        while i < count:
            value = int(distances[i])
            i += 1
            bin = value >> 16
            value = value & 65535
            bin = bin << 1
            bin = shift_x * (int(axes[bin]) - 32768) + shift_y * (int(axes[bin + 1]) - 32768)
            bin = (value - (bin >> 14)) >> 3
            if bin >= 0 and bin < bins:
                if int(histogram[bin]) < 255:
                    histogram[bin] = int(histogram[bin]) + 1
        best = 0 - 1
        bin = first
        while bin <= last:
            outer = int(histogram[bin - 2]) + int(histogram[bin - 1]) + (int(histogram[bin]) << 1)
            outer += int(histogram[bin + 1]) + int(histogram[bin + 2])
            i = (bin * inner_q10 + 512) >> 10
            value = int(histogram[i - 2]) + int(histogram[i - 1]) + (int(histogram[i]) << 1)
            value += int(histogram[i + 1]) + int(histogram[i + 2])
            if value > outer:
                value = outer + ((value - outer) >> 2)
            value += outer
            if value > best:
                best = value
                radius = bin
            bin += 1
        radius = radius * 8 + 4
        inner = (radius * inner_q10 + 512) >> 10
        sum_x = 0
        sum_y = 0
        mean = 0
        on_outer = 0
        on_inner = 0
        i = 0
        while i < count:
            value = int(distances[i])
            i += 1
            bin = (value >> 16) << 1
            value = value & 65535
            cosine = int(axes[bin]) - 32768
            sine = int(axes[bin + 1]) - 32768
            value = value - ((shift_x * cosine + shift_y * sine) >> 14) - radius
            bin = 0
            if value > 40 or value < 0 - 40:
                value = value + radius - inner
                if value < 32 and value > 0 - 32:
                    on_inner += 1
                    bin = 1
            else:
                on_outer += 1
                bin = 1
            if bin:
                sum_x += value * cosine
                sum_y += value * sine
                mean += value
        value = on_outer + on_inner
        if value < 1:
            value = 1
        mean = mean // value
        shift_x += (sum_x // value) >> 13
        shift_y += (sum_y // value) >> 13
    result[0] = radius + mean
    result[1] = shift_x
    result[2] = shift_y
    result[3] = on_outer
    result[4] = on_inner
    return on_outer + on_inner


@micropython.viper
def ring_crossings(
    position: int, value: int, base: int, image: ptr8, log: ptr16, width: int, height: int, cx: int, cy: int,
    radius: int, window: int, step: int, clip: int, roots: ptr16, bulge_cos: int, bulge_sin: int, limit: int,
    least_area: int, skip: ptr8, skip_bit: int, sectors: ptr32,
) -> int:  # fmt: skip
    """Where pixel rows (within 45 degrees of x) and columns (the others) cross a dark ring line.

    Each crossing is the centroid of what is darker than the straight line between the window's ends by more
    than `clip`; no pixel is interpolated. cx, cy, radius (1536..20480), window (half width, 256..radius /
    4) in 1/256 px, the centre inside the frame; step: rows between crossings; roots: tables.ROOT; bulge_*:
    second harmonic of the radius, 1/1024 px, taken off (+-8192); limit: largest residual that counts
    (1/1024 px); least_area: smallest darkness times width that counts (log units * px). sectors: 32 x
    (crossings inside the frame, their area, those that count, sum of residual + 32768 in 1/1024 px) are
    added to. Returns the number of crossings tried."""
    measured = 0
    radius2 = radius * radius
    swap = 0
    while swap < 2:
        if swap:
            along = width
            line_pitch = 1
            centre = cx
            centre_along = cy
            lines = width
            pixels = height
        else:
            along = 1
            line_pitch = width
            centre = cy
            centre_along = cx
            lines = height
            pixels = width
        last = (radius * 181) >> 16
        line = ((centre + 128) >> 8) - last
        last = line + last + last
        while line < 0:
            line += step
        if last >= lines:
            last = lines - 1
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
                    value = position + (half + half) * along
                    near = int(log[int(image[position])]) + int(log[int(image[position + along])])
                    far = int(log[int(image[value])]) + int(log[int(image[value - along])])
                    slope = ((far - near) << 7) // (half + half - 1)
                    base = (near << 7) - (slope >> 1) - (clip << 8)
                    area = 0
                    moment = 0
                    value = (base >> 8) - int(log[int(image[position])])
                    if value > 0:
                        area = value
                        moment = value
                    i = half
                    while i > 0:
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
                        i -= 1
                    base = (sector >> 1) << 2
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
    return measured


@micropython.viper
def ring_harmonics(
    slot: int, i: int, residual: int, sectors: ptr32, means: ptr32, units: ptr8, rounds: int, floor: int,
    result: ptr32
) -> int:
    """Harmonics 0..2 of the residual over the 16 sectors, with outliers left out; the sectors are cleared.

    Sectors without crossings, and those farther than `floor` (1/1024 px) and four times the mean deviation
    from the harmonics, are left out; repeated projection (`rounds` times, 1..8) makes up for the gaps.
    sectors: as in `ring_crossings`, up to 255 crossings each; means: 32 items of scratch space (second half:
    mean area of each sector + 1, or 0 where there was none); units: tables.HARMONICS_4.
    result: constant, cos, sin, cos 2, sin 2 (1/1024 px), mean deviation (1/1024 px), sectors used, sectors
    with crossings, mean area of the used ones. Returns the number of sectors used."""
    inside = 0
    i = 0
    slot = 0
    while i < 16:
        means[i] = 0
        means[i + 16] = 0
        residual = int(sectors[slot])
        if residual > 0:
            inside += 1
            means[i + 16] = int(sectors[slot + 1]) // residual + 1
            if int(sectors[slot + 2]) * 2 >= residual:
                means[i] = int(sectors[slot + 3]) // int(sectors[slot + 2])
            sectors[slot] = 0
            sectors[slot + 1] = 0
            sectors[slot + 2] = 0
            sectors[slot + 3] = 0
        slot += 4
        i += 1
    a0 = 32768
    a1 = 0
    b1 = 0
    a2 = 0
    b2 = 0
    limit = 1048576
    deviation = 0
    used = 0
    while rounds > 0:
        used = 0
        deviation = 0
        s0 = 0
        sa1 = 0
        sb1 = 0
        sa2 = 0
        sb2 = 0
        unit = 0
        while unit < 16:
            # four sectors a quarter turn apart share their harmonics but for signs: from the last to the
            # first
            ca1 = int(units[unit]) - 128
            cb1 = int(units[unit + 1]) - 128
            ca2 = int(units[unit + 2]) - 128
            cb2 = int(units[unit + 3]) - 128
            next1 = 0 - a1 * ca1 - b1 * cb1
            model1 = a1 * cb1 - b1 * ca1
            model2 = 0 - a2 * ca2 - b2 * cb2
            fold_a = 0
            fold_b = 0
            fold_2 = 0
            i = 12 + (unit >> 2)
            while i >= 0:
                residual = int(means[i])
                if residual > 0:
                    residual = residual - a0 - ((model1 + model2) >> 7)
                    if residual < limit and 0 - limit < residual:
                        used += 1
                        s0 += residual
                        if residual < 0:
                            deviation -= residual
                        else:
                            deviation += residual
                    else:
                        residual = 0
                slot = fold_a
                fold_a = residual - fold_b
                fold_b = slot
                fold_2 = residual - fold_2
                slot = model1
                model1 = next1
                next1 = 0 - slot
                model2 = 0 - model2
                i -= 4
            sa1 += fold_a * ca1 - fold_b * cb1
            sb1 += fold_a * cb1 + fold_b * ca1
            sa2 += fold_2 * ca2
            sb2 += fold_2 * cb2
            unit += 4
        if used > 0:
            a0 += s0 // used
            i = used << 6
            a1 += sa1 // i
            b1 += sb1 // i
            a2 += sa2 // i
            b2 += sb2 // i
            deviation = deviation // used
        limit = deviation * 4
        if limit < floor:
            limit = floor
        rounds -= 1
    area = 0
    counted = 0
    i = 0
    while i < 16:
        if int(means[i]) > 0:
            area += int(means[i + 16])
            counted += 1
        i += 1
    if counted < 1:
        counted = 1
    result[0] = a0 - 32768
    result[1] = a1
    result[2] = b1
    result[3] = a2
    result[4] = b2
    result[5] = deviation
    result[6] = used
    result[7] = inside
    result[8] = area // counted
    return used


@micropython.viper
def weak_sectors(means: ptr32, i: int, weak: int, first: int, count: int, least: int) -> int:
    """How many of `count` sectors from `first` (any integer >= 0, modulo 16) have a mean area below `least`.

    means: 32 items as `ring_harmonics` leaves them; a sector outside the frame counts as weak."""
    weak = 0
    i = first
    while i < first + count:
        if int(means[16 + (i & 15)]) <= least:
            weak += 1
        i += 1
    return weak


@micropython.viper
def skip_half_sectors(skip: ptr8, i: int, bits: int, angle: int, reach: int, outer: int, inner: int) -> int:
    """Marks the half sectors within `reach` of the orientation line (`outer`) and of coding lines (`inner`).

    angle: clockwise, 0..65535 of a turn, reach likewise, 0..8192; bits: 1, 2, 4, 8 for lines at 0, 90, 180,
    270 degrees counterclockwise as seen, 1 being the orientation line; skip: 32 items, cleared first.
    Returns outer sectors marked + 64 * inner sectors marked."""
    i = 0
    while i < 32:
        skip[i] = 0
        i += 1
    marked = 0
    line = 0
    while line < 4:
        if bits & (1 << line):
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


@micropython.viper
def mean_area(means: ptr32, i: int, total: int, first: int, count: int) -> int:
    """Mean area of `count` sectors from `first` (any integer >= 0, modulo 16), the middle one left out.

    means: 32 items as `ring_harmonics` leaves them; sectors without crossings do not count; 0 without any."""
    total = 0
    seen = 0
    i = 0
    while i < count:
        area = int(means[16 + ((first + i) & 15)])
        if area > 0 and i != count >> 1:
            total += area
            seen += 1
        i += 1
    if seen > 0:
        total = total // seen
    return total
