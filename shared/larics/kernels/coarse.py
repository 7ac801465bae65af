"""The coarse radius of a candidate: distances of the edges that point to it, and the rings they agree on."""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_RADII_WIDTH = const(0)  # items as in kernels.layouts
_RADII_FIRST = const(1)
_RADII_LAST = const(2)
_RADII_BINS = const(3)
_RADII_REACH_Q4 = const(4)
_RADII_HALF_LINE_Q4 = const(5)
_RADII_SLACK_Q4 = const(6)
_RADII_INNER_Q10 = const(7)
_RADII_CAPACITY = const(8)

_OUTER_NEAR_Q4 = const(40)  # an edge is on a ring when it is so near,
_INNER_NEAR_Q4 = const(32)


@micropython.viper
def edge_distances(
    x: int, reach: int, edges: ptr32, y: int, count: int, radii: ptr32, cx: int, cy: int, axes: ptr16,
    distances: ptr32,
) -> int:  # fmt: skip
    """Distances to the candidate centre of the edges that point to it, as ring radii.

    All lengths in 1/16 px: cx, cy 0..16384; radii: layouts.RADII, with the slack for what an edge points to.
    `edges`: position | direction << 20; `axes`: cosine and sine of the 48 directions, * 2**14 + 32768;
    `distances` receives distance | direction from the centre << 16, at most the capacity of them. Returns
    their number."""
    width = int(radii[_RADII_WIDTH])
    reach = int(radii[_RADII_REACH_Q4])
    half_line = int(radii[_RADII_HALF_LINE_Q4])
    slack = int(radii[_RADII_SLACK_Q4])
    capacity = int(radii[_RADII_CAPACITY])
    # most edges lie in other rows: no division for them
    first = ((cy - reach) >> 4) * width
    end = (((cy + reach) >> 4) + 1) * width - 1
    kept = 0
    i = 0
    while i - count:
        position = int(edges[i])
        i += 1
        x = position & 1048575
        if not ((x - first) | (end - x)) >> 31:
            y = x // width
            x = ((x - y * width) << 4) - cx
            if x < reach and 0 - reach < x:
                y = (y << 4) - cy
                if y < reach and 0 - reach < y:
                    direction = position >> 20
                    cosine = int(axes[direction << 1]) - 32768
                    sine = int(axes[(direction << 1) + 1]) - 32768
                    off = (x * sine - y * cosine) >> 14
                    if off < slack and 0 - slack < off:
                        distance = (x * cosine + y * sine) >> 14
                        if distance >> 31:
                            distance = half_line - distance
                            direction += 24
                            if direction >= 48:
                                direction -= 48
                        else:
                            distance = distance - half_line
                        if distance > 0 and (distance - reach) >> 31:
                            distances[kept] = distance | (direction << 16)
                            kept += 1
                            if kept >= capacity:
                                i = count
    return kept


@micropython.viper
def choose_radius(
    value: int, bin: int, histogram: ptr8, radii: ptr32, distances: ptr32, count: int, axes: ptr16,
    rounds: int, result: ptr32,
) -> int:  # fmt: skip
    """The outer radius whose two rings have most edges, with steps of the centre by least squares.

    radii: layouts.RADII, 4 <= first * inner_q10 / 1024; histogram: its bins, scratch space; distances (below
    8 * bins) and axes as in `edge_distances`; rounds: 1..4. result: radius, shift in x, in y (1/16 px), edges
    on the outer ring, on the inner one. Returns the number of edges on both."""
    last = int(radii[_RADII_LAST])
    bins = int(radii[_RADII_BINS])
    last_bin = bins - 1
    inner_q10 = int(radii[_RADII_INNER_Q10])
    shift_x = 0
    shift_y = 0
    radius = 0
    mean = 0
    on_outer = 0
    on_inner = 0
    while rounds > 0:
        rounds -= 1
        shifted = shift_x | shift_y  # not yet in the first round
        bin = 0
        while bin - bins:
            histogram[bin] = 0
            bin += 1
        i = 0
        while i - count:
            value = int(distances[i])
            i += 1
            bin = value & 65535
            if shifted:
                value = value >> 16 << 1
                shift = shift_x * (int(axes[value]) - 32768) + shift_y * (int(axes[value + 1]) - 32768)
                bin -= shift >> 14
            bin = bin >> 3
            if not (bin | (last_bin - bin)) >> 31:
                if int(histogram[bin]) < 255:
                    histogram[bin] = int(histogram[bin]) + 1
        best = 0 - 1
        bin = int(radii[_RADII_FIRST])
        while bin <= last:
            outer = int(histogram[bin - 2]) + int(histogram[bin - 1]) + (int(histogram[bin]) << 1)
            outer += int(histogram[bin + 1]) + int(histogram[bin + 2])
            inner_bin = (bin * inner_q10 + 512) >> 10
            value = int(histogram[inner_bin - 2]) + int(histogram[inner_bin - 1])
            value += (int(histogram[inner_bin]) << 1) + int(histogram[inner_bin + 1])
            value += int(histogram[inner_bin + 2])
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
        while i - count:
            value = int(distances[i])
            i += 1
            bin = value >> 16 << 1
            cosine = int(axes[bin]) - 32768
            sine = int(axes[bin + 1]) - 32768
            # from the outer ring, or else from the inner one
            value = (value & 65535) - radius
            if shifted:
                value -= (shift_x * cosine + shift_y * sine) >> 14
            near = 0
            if value > _OUTER_NEAR_Q4 or value < 0 - _OUTER_NEAR_Q4:
                value = value + radius - inner
                if value < _INNER_NEAR_Q4 and value > 0 - _INNER_NEAR_Q4:
                    on_inner += 1
                    near = 1
            else:
                on_outer += 1
                near = 1
            if near:
                sum_x += value * cosine
                sum_y += value * sine
                mean += value
        on_both = on_outer + on_inner
        if on_both < 1:
            on_both = 1
        mean = mean // on_both
        shift_x += (sum_x // on_both) >> 13
        shift_y += (sum_y // on_both) >> 13
    result[0] = radius + mean
    result[1] = shift_x
    result[2] = shift_y
    result[3] = on_outer
    result[4] = on_inner
    return on_outer + on_inner
