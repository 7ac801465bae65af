"""Which directions are dark around the rings: candidates of the orientation line.

Angles count clockwise from x, because y points down. Darkness is in units of tables.LOG_GREY_Q8.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_FIT_RADIUS_Q8 = const(6)
_FIT_TRUE_X_Q10 = const(12)
_FIT_TRUE_Y_Q10 = const(13)
_FIT_WIDTH = const(20)
_FIT_HEIGHT = const(21)
_SHAPE_AROUND_FIRST = const(7)
_SHAPE_AROUND_LAST = const(8)
_SHAPE_AROUND_SAMPLES = const(9)
_SHAPE_AROUND_STRIDE = const(10)


@micropython.viper
def annulus_profile(
    dx: int, dy: int, image: ptr8, total: int, log: ptr16, circle: ptr16, fit: ptr32, shape: ptr32,
    profile: ptr16,
) -> int:  # fmt: skip
    """profile[k] = 1 + sum of the log greys of nearest pixels around the rings in direction k * stride / 256.

    fit: FIT; shape: SHAPE, radii, samples in each direction and stride; circle: fixed.COSINE. 256 // stride
    items; 0 where a sample would lie outside the frame. Returns the number of directions inside the frame, 0
    when the centre lies outside."""
    width = int(fit[_FIT_WIDTH])
    height = int(fit[_FIT_HEIGHT])
    cx = (int(fit[_FIT_TRUE_X_Q10]) - (_BIAS - 2)) >> 2
    cy = (int(fit[_FIT_TRUE_Y_Q10]) - (_BIAS - 2)) >> 2
    if cx < 0 or cy < 0 or (cx >> 8) >= width or (cy >> 8) >= height:
        return 0
    radius = int(fit[_FIT_RADIUS_Q8])
    samples = int(shape[_SHAPE_AROUND_SAMPLES])
    stride = int(shape[_SHAPE_AROUND_STRIDE])
    first = (radius * int(shape[_SHAPE_AROUND_FIRST])) >> 10
    pitch = (((radius * int(shape[_SHAPE_AROUND_LAST])) >> 10) - first) // (samples - 1)
    # without a test for each direction when the whole annulus lies inside the frame
    reach = (first + pitch * samples) >> 8
    near_border = 1
    if (cx >> 8) > reach and (cy >> 8) > reach:
        if (cx >> 8) + reach + 2 < width and (cy >> 8) + reach + 2 < height:
            near_border = 0
    inside = 0
    k = 0
    slot = 0
    while k < 256:
        dx = int(circle[k]) - 32768
        dy = 32768 - int(circle[k + 64])
        x = cx + 128 + ((first * dx) >> 14)
        y = cy + 128 + ((first * dy) >> 14)
        dx = (pitch * dx) >> 14
        dy = (pitch * dy) >> 14
        total = 0
        i = samples
        if near_border:
            end_x = x + dx * samples
            end_y = y + dy * samples
            if x < 256 or y < 256 or end_x < 256 or end_y < 256:
                i = 0
            if (x >> 8) >= width or (y >> 8) >= height or (end_x >> 8) >= width or (end_y >> 8) >= height:
                i = 0
        if i:
            inside += 1
            total = 1
        while i:
            total += int(log[int(image[(y >> 8) * width + (x >> 8)])])
            x += dx
            y += dy
            i -= 1
        profile[slot] = total
        slot += 1
        k += stride
    return inside


@micropython.viper
def dark_directions(
    profile: ptr16, k: int, depth: int, directions: int, near: int, far: int, apart: int, depths: ptr16,
    capacity: int, result: ptr32,
) -> int:  # fmt: skip
    """The directions that are darker than both their sides, darkest first, as (direction, depth) in `result`.

    The sides are the means of the directions `near` and `far` steps away; directions: a power of 2; picks lie
    more than `apart` steps apart and are at least 3/8 as deep as the first. depths: scratch space, one item
    per direction. Returns their number, at most `capacity`."""
    turn = directions - 1
    k = 0
    while k < directions:
        depth = int(profile[k])
        depths[k] = 0
        if depth > 0:
            side = int(profile[(k + near) & turn]) + int(profile[(k + far) & turn])
            other = int(profile[(k - near) & turn]) + int(profile[(k - far) & turn])
            if other < side:
                side = other
            depth = (side >> 1) - depth
            if depth > 0:
                depths[k] = depth
        k += 1
    picked = 0
    least = 1
    while picked < capacity:
        best = 0
        where = 0
        k = 0
        while k - directions:
            depth = int(depths[k])
            if depth > best:
                best = depth
                where = k
            k += 1
        if best < least:
            return picked
        if picked == 0:
            least = (best * 3 >> 3) + 1
        result[picked + picked] = where
        result[picked + picked + 1] = best
        picked += 1
        i = where - apart
        j = 0
        while j <= apart + apart:
            depths[(i + j) & turn] = 0
            j += 1
    return picked


@micropython.viper
def quarter_phase(profile: ptr16, k: int, slot: int, circle: ptr16, directions: int, result: ptr32) -> int:
    """The wave of four periods in a turn that a profile holds: its cosine and sine + BIAS in `result`.

    profile: as from `annulus_profile`, 64..256 directions; circle: fixed.COSINE. What is dark at right angles
    makes the wave negative there. Returns the number of directions inside the frame."""
    step = 1024 // directions
    cosine = 0
    sine = 0
    inside = 0
    k = 0
    slot = 0
    while k < directions:
        value = int(profile[k])
        if value:
            inside += 1
        # up to 16 * 1045 in value
        cosine += (value * (int(circle[slot]) - 32768)) >> 10
        sine += (value * (32768 - int(circle[slot + 64]))) >> 10
        slot = (slot + step) & 255
        k += 1
    result[0] = cosine + _BIAS
    result[1] = sine + _BIAS
    return inside
