"""The coarse radius of a candidate: distances of the edges that point to it, and the rings they agree on."""

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
    # most edges lie in other rows: no division for them
    first = ((cy - reach) >> 4) * width
    end = (((cy + reach) >> 4) + 1) * width
    kept = 0
    i = 0
    while i < count:
        position = int(edges[i])
        i += 1
        x = position & 1048575
        if x >= first and x < end:
            y = x // width
            x = ((x - y * width) << 4) - cx
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
