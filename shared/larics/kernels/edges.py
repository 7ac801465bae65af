"""Edges of thin dark lines on a sparse grid: threshold, gate, direction.

Positions are indices into the frame, y * width + x. grid: layouts.GRID; the caller keeps its rectangle far
enough from the border that every pixel read lies inside the frame.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_GRID_WIDTH = const(0)  # items as in kernels.layouts
_GRID_REACH = const(1)
_GRID_LEFT = const(2)
_GRID_RIGHT = const(3)
_GRID_TOP = const(4)
_GRID_BOTTOM = const(5)
_GRID_STEP = const(6)
_GRID_FIRST = const(7)
_GRID_END = const(8)


@micropython.viper
def gradient_histogram(
    across: int, position: int, image: ptr8, grid: ptr32, every: int, histogram: ptr16
) -> int:
    """Adds the gradient of every so-manyth column and row of the grid to `histogram`.

    It has 128 items, in units of 2 grey levels.
    Each row of samples begins five eighths of a step later than the one before, lest tiles fall into step.
    The length of (across, down) is taken as max + 3/8 min. every >= 1; fewer than 65536 samples. Returns
    their number."""
    width = int(grid[_GRID_WIDTH])
    reach = int(grid[_GRID_REACH])
    left = int(grid[_GRID_LEFT])
    right = int(grid[_GRID_RIGHT])
    bottom = int(grid[_GRID_BOTTOM])
    step = int(grid[_GRID_STEP]) * every
    samples = 0
    shift = 0
    row_reach = width * reach
    y = int(grid[_GRID_TOP])
    while y < bottom:
        position = y * width + left + shift
        end = y * width + right
        shift += (step * 5) >> 3
        if shift >= step:
            shift -= step
        while position < end:
            across = int(image[position + reach]) - int(image[position - reach])
            down = int(image[position + row_reach]) - int(image[position - row_reach])
            if across >> 31:
                across = 0 - across
            if down >> 31:
                down = 0 - down
            if (across - down) >> 31:
                smaller = across
                across = down
                down = smaller
            across = (across + ((down * 3) >> 3)) >> 1
            if across > 127:
                across = 127
            histogram[across] = int(histogram[across]) + 1
            samples += 1
            position += step
        y += step
    return samples


@micropython.viper
def edge_threshold(
    histogram: ptr16,
    i: int,
    seen: int,
    samples: int,
    floor: int,
    median_q4: int,
    share_min: int,
    share_max: int,
) -> int:
    """Edge threshold in grey levels from the histogram, which is cleared: median_q4/16 of the median, but
    so that between share_min and share_max 1024ths of the samples pass, and at least `floor`.

    histogram: 128 items; 0 <= samples < 65536; shares 0..1024; floor 1..255; median_q4 0..255."""
    seen = 0
    half = samples >> 1
    few = samples - ((samples * share_min) >> 10)
    many = samples - ((samples * share_max) >> 10)
    median = 0
    upper = 127
    lower = 127
    i = 0
    while i < 128:
        before = seen
        seen += int(histogram[i])
        histogram[i] = 0
        if before < half and seen >= half:
            median = i
        if before < many and seen >= many:
            lower = i
        if before < few and seen >= few:
            upper = i
        i += 1
        if seen >= few and seen >= half and seen >= many:
            while i < 128:
                histogram[i] = 0
                i += 1
    threshold = (median * median_q4) >> 3
    upper = upper + upper + 1
    lower = lower + lower + 1
    if threshold > upper:
        threshold = upper
    if threshold < lower:
        threshold = lower
    if threshold < floor:
        threshold = floor
    return threshold


@micropython.viper
def steep_positions(
    position: int, between: int, image: ptr8, grid: ptr32, field: int, threshold2: int, positions: ptr32,
    listed: int, capacity: int,
) -> int:  # fmt: skip
    """Lists the grid points whose gradient is longer than the square root of `threshold2` (< 2**18).

    field: 0 for all points, 1 or 2 for those of one colour on a chessboard. The first `listed` positions are
    kept. Stops when `capacity` are listed; `positions` has capacity + 1 items. Returns the number listed."""
    width = int(grid[_GRID_WIDTH])
    reach = int(grid[_GRID_REACH])
    begin = int(grid[_GRID_LEFT])
    last = int(grid[_GRID_RIGHT])
    bottom = int(grid[_GRID_BOTTOM])
    rows = int(grid[_GRID_STEP])
    step = rows
    both_begins = begin + begin
    if field > 0:
        step = rows + rows
        both_begins += rows
        if field > 1:
            begin += rows
    # from the pixel above a point on, which `position` is here
    row_reach = width * reach
    below = row_reach + row_reach
    left = row_reach - reach
    right = row_reach + reach
    y = int(grid[_GRID_TOP])
    if listed >= capacity:
        y = bottom
    while y < bottom:
        position = y * width + begin - row_reach
        end = position + last - begin
        # four at a time, of which the last ones may write the item beyond the capacity; then the others
        fours = end - 3 * step
        while position < fours:
            between = int(image[position + right]) - int(image[position + left])
            square = between * between
            between = int(image[position + below]) - int(image[position])
            if between * between + square > threshold2:
                positions[listed] = position + row_reach
                listed += 1
                if listed >= capacity:
                    listed = capacity
                    end = 0
                    fours = 0
                    y = bottom
            position += step
            between = int(image[position + right]) - int(image[position + left])
            square = between * between
            between = int(image[position + below]) - int(image[position])
            if between * between + square > threshold2:
                positions[listed] = position + row_reach
                listed += 1
                if listed >= capacity:
                    listed = capacity
                    end = 0
                    fours = 0
                    y = bottom
            position += step
            between = int(image[position + right]) - int(image[position + left])
            square = between * between
            between = int(image[position + below]) - int(image[position])
            if between * between + square > threshold2:
                positions[listed] = position + row_reach
                listed += 1
                if listed >= capacity:
                    listed = capacity
                    end = 0
                    fours = 0
                    y = bottom
            position += step
            between = int(image[position + right]) - int(image[position + left])
            square = between * between
            between = int(image[position + below]) - int(image[position])
            if between * between + square > threshold2:
                positions[listed] = position + row_reach
                listed += 1
                if listed >= capacity:
                    listed = capacity
                    end = 0
                    fours = 0
                    y = bottom
            position += step
        while position < end:
            between = int(image[position + right]) - int(image[position + left])
            square = between * between
            between = int(image[position + below]) - int(image[position])
            if between * between + square > threshold2:
                positions[listed] = position + row_reach
                listed += 1
                if listed >= capacity:
                    end = 0
                    y = bottom
            position += step
        begin = both_begins - begin
        y += rows
    return listed


@micropython.viper
def thin_line_edges(
    image: ptr8, position: int, a: int, b: int, positions: ptr32, count: int, edges: ptr32, grid: ptr32,
    threshold: int, directions: ptr8, probes: ptr16, least2: int,
) -> int:  # fmt: skip
    """Lists the positions that are edges of thin dark lines in `edges`, as position | direction << 20, and
    after them, in no order, the other ones.

    `edges` may be `positions` itself. Positions outside the grid's first and end are passed over.
    Nor is one an edge whose gradient, as of `steep_positions`, is no longer than the square root of `least2`;
    0 does not look.

    The direction (0..47, of 48 in a turn, clockwise from x since y points down) is that of the 3x3 Sobel
    gradient with the grid's reach, towards the light side; `directions` has 136 entries
    (tables.DIRECTION_48). `probes` holds three offsets + 32768 for each direction: beyond the line, in it,
    and on the light side. count <= items of both, < 2**15; positions < 2**20. Returns the number of edges |
    that of all listed << 15."""
    reach = int(grid[_GRID_REACH])
    row_reach = int(grid[_GRID_WIDTH]) * reach
    first = int(grid[_GRID_FIRST])
    end = int(grid[_GRID_END]) - 1
    kept = 0
    listed = 0
    diagonal = row_reach + reach
    antidiagonal = row_reach - reach
    i = 0
    while i < count:
        position = int(positions[i])
        i += 1
        if ((position - first) | (end - position)) >> 31:
            continue
        a = int(image[position + diagonal]) - int(image[position - diagonal])
        b = int(image[position - antidiagonal]) - int(image[position + antidiagonal])
        gx = a + b + ((int(image[position + reach]) - int(image[position - reach])) << 1)
        gy = a - b + ((int(image[position + row_reach]) - int(image[position - row_reach])) << 1)
        slot = 0
        a = gx
        b = gy
        if a >> 31:
            a = 0 - a
            slot = 34
        if b >> 31:
            b = 0 - b
            slot += 68
        if a >= b:
            if a > 0:
                slot += ((b << 4) + (a >> 1)) // a
        else:
            slot += 17 + ((a << 4) + (b >> 1)) // b
        slot = int(directions[slot])
        # how much lighter it is beyond the line and on the light side than in it
        probe = slot * 3
        position -= 32768
        dark = int(image[position + int(probes[probe + 1])])
        a = int(image[position + int(probes[probe])]) - dark
        b = 0
        if a + a > threshold and a * 3 >= int(image[position + int(probes[probe + 2])]) - dark:
            b = 1
        position += 32768
        if b and least2:
            gx = int(image[position + reach]) - int(image[position - reach])
            gy = int(image[position + row_reach]) - int(image[position - row_reach])
            if gx * gx + gy * gy <= least2:
                b = 0
        if b:
            edges[listed] = int(edges[kept])
            edges[kept] = position | (slot << 20)
            kept += 1
        else:
            edges[listed] = position | (slot << 20)
        listed += 1
    return kept | (listed << 15)
