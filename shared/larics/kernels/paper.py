"""Kernels of the published method: Sobel, Hough voting, local threshold, radial sums.

Gradients are held for a band of rows at a time: item `row * width + x` belongs to pixel
(x, first_row + row). They are biased by 1024, since ptr16 loads unsigned. Bounds given below hold for
any 8-bit frame of at most 1024x1024 pixels and rings of at most 100 px.
"""

try:
    import micropython
    from micropython import const  # noqa: F401  (a folder of that name has none)
except ImportError:
    from larics._cpython import micropython, ptr8, ptr16, ptr32


@micropython.viper
def clear16(buffer: ptr16, count: int):
    """Sets `count` items to 0."""
    i = 0
    while i < count:
        buffer[i] = 0
        i += 1


@micropython.viper
def clear32(buffer: ptr32, count: int):
    """Sets `count` items to 0."""
    i = 0
    while i < count:
        buffer[i] = 0
        i += 1


@micropython.viper
def sobel(
    gray: ptr8,
    gx: ptr16,
    gy: ptr16,
    magnitude: ptr16,
    width: int,
    first_row: int,
    rows: int,
    floor_squared: int,
):
    """Equations 4 to 6 for the rows first_row .. first_row + rows - 1, all of them inside the frame's border.

    gray: frame; gx, gy, magnitude: rows * width items. gx grows to the right and gy downwards, each
    -1020..1020 before the bias of 1024; the magnitude is in 1/16, at most 23080, and 0 in the first and last
    column and where its square is below floor_squared (1..2080800), which saves the root there.
    Largest intermediate: 256 * 2 * 1020**2 = 5.4e8.
    """
    row = 0
    while row < rows:
        o = row * width
        i = (first_row + row) * width
        end = o + width - 1
        magnitude[o] = 0
        magnitude[end] = 0
        o += 1
        i += 1
        while o < end:
            above = i - width
            below = i + width
            nw = int(gray[above - 1])
            ne = int(gray[above + 1])
            sw = int(gray[below - 1])
            se = int(gray[below + 1])
            dx = ne + se - nw - sw + ((int(gray[i + 1]) - int(gray[i - 1])) << 1)
            dy = sw + se - nw - ne + ((int(gray[below]) - int(gray[above])) << 1)
            gx[o] = dx + 1024
            gy[o] = dy + 1024
            square = dx * dx + dy * dy
            root = 0
            if square >= floor_squared:
                if dx < 0:
                    dx = 0 - dx
                if dy < 0:
                    dy = 0 - dy
                square = square << 8
                better = (dx + dy) << 4  # never below the root, and at most 1.42 times it
                root = better + 1
                while better < root:  # Newton
                    root = better
                    better = (root + square // root) >> 1
            magnitude[o] = root
            o += 1
            i += 1
        row += 1


@micropython.viper
def count_magnitudes(magnitude: ptr16, histogram: ptr32, count: int):
    """Adds `count` magnitudes (1/16 units, up to 23080) to a histogram of whole units; 0 is left out.

    histogram: 1443 items.
    """
    i = 0
    while i < count:
        value = int(magnitude[i]) >> 4
        if value > 0:
            histogram[value] = int(histogram[value]) + 1
        i += 1


@micropython.viper
def threshold_of_strongest(histogram: ptr32, bins: int, keep: int) -> int:
    """The smallest value that at most `keep` of the counted items reach; `bins` if there is none."""
    value = bins
    left = keep
    while value > 0:
        left -= int(histogram[value - 1])
        if left < 0:
            return value
        value -= 1
    return value


@micropython.viper
def vote(
    accumulator: ptr16,
    gx: ptr16,
    gy: ptr16,
    magnitude: ptr16,
    width: int,
    height: int,
    first_row: int,
    rows: int,
    threshold_q4: int,
    nearest: int,
    farthest: int,
):
    """Equations 2 and 3: every edge pixel votes for the centres x - r cos, y - r sin on its gradient's line.

    r runs from `nearest` to `farthest` (1..100 px) in whole pixels, on both sides of the edge, since a line
    has one edge of each polarity. accumulator: width * height items; votes outside the frame are dropped.
    An edge is a pixel whose magnitude reaches threshold_q4 (1/16 units, at least 16).
    A cell gets at most two votes from a pixel, so at most 2 * pi * 101**2 = 64100, which fits 16 bits.
    Largest intermediate: 1020 << 18 = 2.7e8.
    """
    row = 0
    while row < rows:
        o = row * width + 1
        x = 1
        while x < width - 1:
            strength = int(magnitude[o])
            if strength >= threshold_q4:
                dx = ((int(gx[o]) - 1024) << 18) // strength  # unit vector, 1/16384
                dy = ((int(gy[o]) - 1024) << 18) // strength
                side = 0
                while side < 2:
                    px = (x << 14) + 8192 + dx * nearest
                    py = ((first_row + row) << 14) + 8192 + dy * nearest
                    r = nearest
                    while r <= farthest:
                        cx = px >> 14
                        cy = py >> 14
                        if cx >= 0 and cx < width and cy >= 0 and cy < height:
                            cell = cy * width + cx
                            accumulator[cell] = int(accumulator[cell]) + 1
                        px += dx
                        py += dy
                        r += 1
                    dx = 0 - dx
                    dy = 0 - dy
                    side += 1
            o += 1
            x += 1
        row += 1


@micropython.viper
def argmax16(buffer: ptr16, count: int) -> int:
    """Index of the largest of `count` items, the first one if there are several; count >= 1."""
    i = 1
    best = int(buffer[0])
    index = 0
    while i < count:
        value = int(buffer[i])
        if value > best:
            best = value
            index = i
        i += 1
    return index


@micropython.viper
def count_radii(
    histogram: ptr16,
    gx: ptr16,
    gy: ptr16,
    magnitude: ptr16,
    width: int,
    first_row: int,
    rows: int,
    threshold_q4: int,
    x0: int,
    y0: int,
    reach: int,
):
    """Equation 1 with the centre known: counts edges by their distance from (x0, y0), in quarters of a pixel.

    Counted are the edge pixels of the band within `reach` (1..101 px) in x, whose gradient's line passes
    (x0, y0) within 1.5 px. histogram: 4 * reach items; what is farther away is dropped.
    Largest intermediate: 32 * 1020 * (101 + 1023) = 3.7e7.
    """
    left = x0 - reach
    if left < 1:
        left = 1
    right = x0 + reach
    if right > width - 2:
        right = width - 2
    row = 0
    while row < rows:
        ry = first_row + row - y0
        x = left
        o = row * width + left
        while x <= right:
            strength = int(magnitude[o])
            if strength >= threshold_q4:
                rx = x - x0
                cross = rx * (int(gy[o]) - 1024) - ry * (int(gx[o]) - 1024)
                if cross < 0:
                    cross = 0 - cross
                if cross << 5 <= 3 * strength:
                    square = (rx * rx + ry * ry) << 8
                    if rx < 0:
                        rx = 0 - rx
                    if ry < 0:
                        better = (rx - ry) << 4
                    else:
                        better = (rx + ry) << 4
                    root = better + 1
                    while better < root:
                        root = better
                        if root > 0:
                            better = (root + square // root) >> 1
                    quarter = (root + 2) >> 2
                    if quarter < 4 * reach:
                        histogram[quarter] = int(histogram[quarter]) + 1
            x += 1
            o += 1
        row += 1


@micropython.viper
def binarise(
    gray: ptr8,
    window: ptr8,
    columns: ptr32,
    width: int,
    height: int,
    x0: int,
    y0: int,
    half: int,
    box: int,
    share_q8: int,
):
    """The local window around (x0, y0) as 1 (dark) and 0: dark lies more than share_q8 / 256 below the
    mean of the (2 box + 1) square around it. Outside the frame is 0, and no part of a mean.

    window: (2 half + 1)**2 items, row by row; columns: `width` items of work space; (x0, y0) inside the
    frame; half <= 150, box <= 50; share_q8 0..255.
    Largest intermediate: 255 * 101**2 << 8 = 6.7e8.
    """
    first = x0 - half - box  # the columns that matter
    if first < 0:
        first = 0
    last = x0 + half + box
    if last > width - 1:
        last = width - 1
    top = y0 - half - box
    if top < 0:
        top = 0
    x = first
    while x <= last:
        columns[x] = 0
        x += 1
    o = 0
    y = y0 - half - box - box
    while y <= y0 + half:
        # columns[x] becomes the sum of the rows y - box .. y + box that lie inside the frame
        entering = y + box
        if entering >= top and entering < height:
            i = entering * width + first
            x = first
            while x <= last:
                columns[x] = int(columns[x]) + int(gray[i])
                i += 1
                x += 1
        leaving = y - box - 1
        if leaving >= top and leaving < height:
            i = leaving * width + first
            x = first
            while x <= last:
                columns[x] = int(columns[x]) - int(gray[i])
                i += 1
                x += 1
        if y >= y0 - half:
            upper = y - box
            if upper < 0:
                upper = 0
            lower = y + box
            if lower > height - 1:
                lower = height - 1
            total = 0
            x = x0 - half - box - box
            while x <= x0 + half:
                entering = x + box
                if entering >= first and entering <= last:
                    total += int(columns[entering])
                leaving = x - box - 1
                if leaving >= first and leaving <= last:
                    total -= int(columns[leaving])
                if x >= x0 - half:
                    dark = 0
                    if x >= 0 and x < width and y >= 0 and y < height:
                        left = x - box
                        if left < 0:
                            left = 0
                        right = x + box
                        if right > width - 1:
                            right = width - 1
                        area = (lower - upper + 1) * (right - left + 1)
                        if (int(gray[y * width + x]) * area) << 8 < total * (256 - share_q8):
                            dark = 1
                    window[o] = dark
                    o += 1
                x += 1
        y += 1


@micropython.viper
def radial_sums(window: ptr8, sines: ptr16, sums: ptr16, half: int):
    """Equation 7: H(a) = sum over r = 0 .. half of the window at r in direction a, for a = 0 .. 359 degrees.

    window: (2 half + 1)**2 items of 0 or 1, half <= 150, the centre in its middle; sines: 32768 + 16384 sin,
    of 0 .. 449 degrees; sums: 360 items. The nearest pixel is taken; y grows downwards, angles count
    counterclockwise. Largest intermediate: 301 << 14 = 4.9e6.
    """
    side = half + half + 1
    angle = 0
    while angle < 360:
        dx = int(sines[angle + 90]) - 32768
        dy = 32768 - int(sines[angle])
        x = (half << 14) + 8192
        y = x
        total = 0
        r = 0
        while r <= half:
            total += int(window[(y >> 14) * side + (x >> 14)])
            x += dx
            y += dy
            r += 1
        sums[angle] = total
        angle += 1
