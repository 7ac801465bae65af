"""Edges of thin dark lines on a sparse grid: threshold, gate, direction.

Positions are indices into the frame, y * width + x. `reach` is the distance in px of the pixels whose
difference is the gradient (1..3). Rectangles are left <= x < right, top <= y < bottom, and the caller keeps
them far enough from the border that every pixel read lies inside the frame.
"""

try:
    import micropython
except ImportError:
    from larics._cpython import micropython, ptr8, ptr16, ptr32


@micropython.viper
def gradient_histogram(
    image: ptr8, position: int, across: int, width: int, reach: int, left: int, right: int, top: int,
    bottom: int, step: int, histogram: ptr16,
) -> int:  # fmt: skip
    """Adds the gradient of every step-th pixel to `histogram` (128 items, in units of 2 grey levels).

    Each row of samples begins five eighths of a step later than the one before, lest tiles fall into step.
    The length of (across, down) is taken as max + 3/8 min. reach <= left, right <= width - reach, likewise
    for rows; step >= 1; fewer than 65536 samples. Returns their number."""
    samples = 0
    shift = 0
    row_reach = width * reach
    y = top
    while y < bottom:
        position = y * width + left + shift
        end = y * width + right
        shift += (step * 5) >> 3
        if shift >= step:
            shift -= step
        while position < end:
            across = int(image[position + reach]) - int(image[position - reach])
            down = int(image[position + row_reach]) - int(image[position - row_reach])
            if across < 0:
                across = 0 - across
            if down < 0:
                down = 0 - down
            if across < down:
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
    image: ptr8, position: int, across: int, width: int, reach: int, left: int, right: int, top: int,
    bottom: int, step: int, rows: int, shift: int, threshold2: int, positions: ptr32, listed: int,
    capacity: int,
) -> int:  # fmt: skip
    """Lists the grid points whose gradient is longer than the square root of `threshold2` (< 2**18).

    step, rows: px between the columns and the rows of the grid; every second row begins `shift` px beside
    left. The first `listed` positions are kept. Stops when `capacity` are listed; `positions` has capacity +
    1 items. Limits of the rectangle as in `gradient_histogram`, also for left + shift. Returns the number
    listed."""
    if listed >= capacity:
        top = bottom
    row_reach = width * reach
    shift = left + left + shift
    y = top
    while y < bottom:
        position = y * width + left
        end = y * width + right
        while position < end:
            across = int(image[position + reach]) - int(image[position - reach])
            down = int(image[position + row_reach]) - int(image[position - row_reach])
            if across * across + down * down > threshold2:
                positions[listed] = position
                listed += 1
                if listed >= capacity:
                    end = 0
                    y = bottom
            position += step
        left = shift - left
        y += rows
    return listed


@micropython.viper
def thin_line_edges(
    image: ptr8, position: int, a: int, b: int, positions: ptr32, count: int, edges: ptr32, row_reach: int,
    reach: int, threshold: int, directions: ptr8, probes: ptr16, first: int, end: int, thin: int,
) -> int:  # fmt: skip
    """Lists the positions that are edges of thin dark lines in `edges`, as position | direction << 20.

    `edges` may be `positions` itself. Only positions from `first` to before `end` are looked at.
    With thin = 0 all of those are kept: a blurred line is no thin line any more.

    The direction (0..47, of 48 in a turn, clockwise from x since y points down) is that of the 3x3 Sobel
    gradient with spacing `reach`, towards the light side; `directions` has 136 entries (tables.DIRECTION_48).
    `probes` holds three offsets + 32768 for each direction: beyond the line, in it, and on the light side.
    row_reach = width * reach; count <= items of both; positions < 2**20. Returns the number kept."""
    kept = 0
    diagonal = row_reach + reach
    antidiagonal = row_reach - reach
    i = 0
    while i < count:
        position = int(positions[i])
        i += 1
        if position < first or position >= end:
            continue
        a = int(image[position + diagonal]) - int(image[position - diagonal])
        b = int(image[position - antidiagonal]) - int(image[position + antidiagonal])
        gx = a + b + ((int(image[position + reach]) - int(image[position - reach])) << 1)
        gy = a - b + ((int(image[position + row_reach]) - int(image[position - row_reach])) << 1)
        slot = 0
        a = gx
        b = gy
        if a < 0:
            a = 0 - a
            slot = 34
        if b < 0:
            b = 0 - b
            slot += 68
        if a >= b:
            if a > 0:
                slot += ((b << 4) + (a >> 1)) // a
        else:
            slot += 17 + ((a << 4) + (b >> 1)) // b
        slot = int(directions[slot])
        a = 1
        b = 0
        if thin:
            gx = slot * 3
            position -= 32768
            b = int(image[position + int(probes[gx + 1])])
            a = int(image[position + int(probes[gx])]) - b
            b = int(image[position + int(probes[gx + 2])]) - b
            position += 32768
            if a + a <= threshold:
                a = 0 - 256
        if a * 3 >= b:
            edges[kept] = position | (slot << 20)
            kept += 1
    return kept
