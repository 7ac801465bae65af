"""The cells of a coded marker: how dark each is against the white beside it, through the fitted pose.

Angles count clockwise from x, because y points down. Darkness is in units of tables.LOG_GREY_Q8.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_FIT_RADIUS_Q8 = const(6)
_FIT_BULGE_COS = const(8)
_FIT_BULGE_SIN = const(9)
_FIT_X_Q10 = const(10)
_FIT_Y_Q10 = const(11)
_FIT_TRUE_X_Q10 = const(12)
_FIT_TRUE_Y_Q10 = const(13)
_FIT_AREA = const(14)
_FIT_LINE_Q10 = const(17)
_PLACE_X_Q8 = const(0)
_PLACE_Y_Q8 = const(1)
_PLACE_RADIUS_Q8 = const(2)
_PLACE_E1_Q14 = const(3)
_PLACE_E2_Q14 = const(4)
_PLACE_HX_Q14 = const(5)
_PLACE_HY_Q14 = const(6)
_PLACE_COSINE_Q14 = const(7)
_PLACE_SINE_Q14 = const(8)
_PLACE_DEPTH = const(9)
_PLACE_RADII_Q10 = const(10)
_PLACE_WIDTH = const(14)
_PLACE_HEIGHT = const(15)

_BENT_MOST = const(4096)
_COVERED_Q8 = const(128)  # a ring's sector with less of the rings' area is hidden
_FADED_LEAST_Q8 = const(110)  # darkness is made up for down to this share of the rings' area
_HIDDEN_LEAST_Q8 = const(190)  # of what may be hidden, down to this: an edge of what covers it is no cell
_OUTSIDE = const(_BIAS - (1 << 20))  # below it a cell is not looked at
_DARK_LEAST = const(4)  # where so many cells are dark as they are,
_DARK = const(_BIAS + 154)  # by this
_CELL_TURN16 = const(3368)  # of the first cell of a quarter turn, of a cell, of the gap after the third
_CELL_STEP_TURN16 = const(1638)
_CELL_GAP_TURN16 = const(1457)
_USUAL = const(1024)  # ellipse, and half of it perspective, * 2**14: 6 degrees of tilt and more
_TANGENT_Q14 = const(572)  # of 2 degrees, between the samples at one radius


@micropython.viper
def direct_place(fit: ptr32, x: int, y: int, circle: ptr16, angle: int, place: ptr32) -> int:
    """Writes PLACE from the direct reader's pose and the orientation line's angle in the picture.

    fit: FIT, area 0..2**20; angle: clockwise, 0..65535 of a turn; circle: fixed.COSINE. Returns 1, or 0 for a
    shape that no marker has."""
    radius = int(fit[_FIT_RADIUS_Q8])
    e1 = ((int(fit[_FIT_BULGE_COS]) - _BIAS) << 12) // radius
    e2 = ((int(fit[_FIT_BULGE_SIN]) - _BIAS) << 12) // radius
    # the middle of the rings' centres lies by 13/18 of the bend beside the true centre
    hx = (int(fit[_FIT_X_Q10]) - int(fit[_FIT_TRUE_X_Q10])) * 5671 // radius
    hy = (int(fit[_FIT_Y_Q10]) - int(fit[_FIT_TRUE_Y_Q10])) * 5671 // radius
    if e1 > _BENT_MOST or e2 > _BENT_MOST or hx > _BENT_MOST or hy > _BENT_MOST:
        return 0
    if e1 < 0 - _BENT_MOST or e2 < 0 - _BENT_MOST or hx < 0 - _BENT_MOST or hy < 0 - _BENT_MOST:
        return 0
    place[_PLACE_X_Q8] = (int(fit[_FIT_TRUE_X_Q10]) - (_BIAS - 2)) >> 2
    place[_PLACE_Y_Q8] = (int(fit[_FIT_TRUE_Y_Q10]) - (_BIAS - 2)) >> 2
    place[_PLACE_RADIUS_Q8] = radius
    place[_PLACE_E1_Q14] = e1 + _BIAS
    place[_PLACE_E2_Q14] = e2 + _BIAS
    place[_PLACE_HX_Q14] = hx + _BIAS
    place[_PLACE_HY_Q14] = hy + _BIAS
    x = angle >> 8
    y = angle & 255
    cosine = int(circle[x])
    cosine = cosine + (((int(circle[x + 1]) - cosine) * y) >> 8) - 32768
    x = (x + 64) & 255
    sine = int(circle[x])
    sine = 32768 - sine - (((int(circle[x + 1]) - sine) * y) >> 8)
    # in the marker's plane the line lies where the ellipse is undone; of length 1 again, nearly
    x = cosine - ((e1 * cosine + e2 * sine) >> 14)
    y = sine - ((e2 * cosine - e1 * sine) >> 14)
    length = 49152 - ((x * x + y * y) >> 14)
    place[_PLACE_COSINE_Q14] = ((x * length) >> 15) + _BIAS
    place[_PLACE_SINE_Q14] = ((y * length) >> 15) + _BIAS
    x = (int(fit[_FIT_AREA]) << 8) // ((radius * int(fit[_FIT_LINE_Q10]) >> 10) + 1)
    if x < 1:
        x = 1
    place[_PLACE_DEPTH] = x
    return 1


@micropython.viper
def cell_depths(
    x: int, y: int, position: int, image: ptr8, log: ptr16, axes: ptr16, place: ptr32, result: ptr32
) -> int:  # fmt: skip
    """How dark each of the 24 cells is, from the nearest pixels: six in it and four of white beside it.

    place: PLACE, centre within the frame or at most a radius outside, radius 1024..20480, shape within +-4096
    of BIAS; axes: tables.CELL_AXES, cosine and sine of the six cells of a quarter turn.
    result: of each cell 256 * darkness / depth + BIAS, 0 when a pixel lies outside the frame; then of each
    the mean brightness in it, then of the white beside it, log units, 0 likewise.
    Returns the number of cells that lie inside the frame."""
    width = int(place[_PLACE_WIDTH])
    right = (width << 8) - 1
    bottom = (int(place[_PLACE_HEIGHT]) << 8) - 1
    radius = int(place[_PLACE_RADIUS_Q8])
    unit = int(place[_PLACE_DEPTH]) * 12
    cx = int(place[_PLACE_X_Q8]) + 128
    cy = int(place[_PLACE_Y_Q8]) + 128
    ux = int(place[_PLACE_COSINE_Q14]) - _BIAS
    uy = int(place[_PLACE_SINE_Q14]) - _BIAS
    e1 = int(place[_PLACE_E1_Q14]) - _BIAS
    e2 = int(place[_PLACE_E2_Q14]) - _BIAS
    hx = int(place[_PLACE_HX_Q14]) - _BIAS
    hy = int(place[_PLACE_HY_Q14]) - _BIAS
    # of shapes that are usual no pixel lies farther than two radii away
    near_border = 0
    x = radius + radius
    if cx < x or cy < x or cx + x > right or cy + x > bottom:
        near_border = 1
    if e1 > _USUAL or e2 > _USUAL or e1 < 0 - _USUAL or e2 < 0 - _USUAL:
        near_border = 1
    if hx > _USUAL >> 1 or hy > _USUAL >> 1 or hx < 0 - (_USUAL >> 1) or hy < 0 - (_USUAL >> 1):
        near_border = 1
    # radii, and what a bend adds to them
    radius_1 = int(place[_PLACE_RADII_Q10])
    radius_2 = int(place[_PLACE_RADII_Q10 + 1])
    radius_3 = int(place[_PLACE_RADII_Q10 + 2])
    radius_4 = int(place[_PLACE_RADII_Q10 + 3])
    bend_1 = (radius_1 * radius_1) >> 10
    bend_2 = (radius_2 * radius_2) >> 10
    bend_3 = (radius_3 * radius_3) >> 10
    bend_4 = (radius_4 * radius_4) >> 10
    inside = 0
    cell = 0
    axis = 0
    while cell < 24:
        x = int(axes[axis])
        y = int(axes[axis + 1])
        vx = (ux * x + uy * y) >> 14
        vy = (uy * x - ux * y) >> 14
        bend = (hx * vx + hy * vy) >> 14
        dx = (radius * (vx + ((e1 * vx + e2 * vy) >> 14))) >> 14
        dy = (radius * (vy + ((e2 * vx - e1 * vy) >> 14))) >> 14
        ring = 4
        if near_border:
            ring = 0
            while ring < 4:
                position = int(place[_PLACE_RADII_Q10 + ring])
                position = position + ((((position * position) >> 10) * bend) >> 14)
                x = (dx * position) >> 10
                y = (dy * position) >> 10
                step_x = (y * _TANGENT_Q14) >> 14
                step_y = (x * _TANGENT_Q14) >> 14
                x += cx + step_x
                y += cy - step_y
                vx = x - step_x - step_x
                vy = y + step_y + step_y
                ring += 1
                if x < 0 or y < 0 or x > right or y > bottom or vx < 0 or vy < 0 or vx > right or vy > bottom:
                    ring = 8
        x = 0
        within = 0
        beside = 0
        if ring == 4:
            # written out, since a turn of a loop costs as much as a pixel
            x = ((bend * bend_1) >> 14) + radius_1
            y = (x * dy) >> 10
            x = (x * dx) >> 10
            step_x = (y * _TANGENT_Q14) >> 14
            step_y = (x * _TANGENT_Q14) >> 14
            x = x + cx + step_x
            y = y + cy - step_y
            beside = int(log[int(image[(y >> 8) * width + (x >> 8)])])
            x = x - step_x - step_x
            y = y + step_y + step_y
            beside += int(log[int(image[(y >> 8) * width + (x >> 8)])])
            x = ((bend * bend_2) >> 14) + radius_2
            y = (x * dy) >> 10
            x = (x * dx) >> 10
            step_x = (y * _TANGENT_Q14) >> 14
            step_y = (x * _TANGENT_Q14) >> 14
            x = x + cx + step_x
            y = y + cy - step_y
            beside += int(log[int(image[(y >> 8) * width + (x >> 8)])])
            x = x - step_x - step_x
            y = y + step_y + step_y
            beside += int(log[int(image[(y >> 8) * width + (x >> 8)])])
            x = ((bend * bend_3) >> 14) + radius_3
            y = (x * dy) >> 10
            x = (x * dx) >> 10
            step_x = (y * _TANGENT_Q14) >> 14
            step_y = (x * _TANGENT_Q14) >> 14
            x = x + cx + step_x
            y = y + cy - step_y
            within = int(log[int(image[(y >> 8) * width + (x >> 8)])])
            x = x - step_x
            y = y + step_y
            within += int(log[int(image[(y >> 8) * width + (x >> 8)])])
            x = x - step_x
            y = y + step_y
            within += int(log[int(image[(y >> 8) * width + (x >> 8)])])
            x = ((bend * bend_4) >> 14) + radius_4
            y = (x * dy) >> 10
            x = (x * dx) >> 10
            step_x = (y * _TANGENT_Q14) >> 14
            step_y = (x * _TANGENT_Q14) >> 14
            x = x + cx + step_x
            y = y + cy - step_y
            within += int(log[int(image[(y >> 8) * width + (x >> 8)])])
            x = x - step_x
            y = y + step_y
            within += int(log[int(image[(y >> 8) * width + (x >> 8)])])
            x = x - step_x
            y = y + step_y
            within += int(log[int(image[(y >> 8) * width + (x >> 8)])])
            inside += 1
            x = ((beside * 3 - within * 2) << 8) // unit + _BIAS
            if x < 1:
                x = 1
        result[cell] = x
        result[24 + cell] = within // 6
        result[48 + cell] = beside >> 2
        cell += 1
        axis += 2
        if axis == 12:
            # counterclockwise by a quarter
            axis = 0
            x = ux
            ux = uy
            uy = 0 - x
    return inside


@micropython.viper
def local_depths(area: int, i: int, angle: int, is_faint: int, means: ptr32, depths: ptr32) -> int:
    """Puts darkness in proportion to that of the rings before each cell; returns the cells that are hidden.

    Dirt on a lens blurs one side: cells there are fainter, as the ring is. area: of the rings, 0..2**20;
    angle: clockwise, of the orientation line, 0..65535 of a turn; means: as from harmonics.ring_harmonics of
    the outer ring, 16 + k: area of sector k, 0..2**20, 0 where it was not looked at; depths: as from
    `cell_depths`. A cell is hidden when one of the nearest two sectors has less than half the rings' area,
    unless is_faint: then that is known to be faint, too. The mean of both counts, where it is less than the
    rings' area by a sixteenth, not in full of those hidden, and when some cells are dark as they are: dirt on
    the plate of a plain marker is not to look darker. Bit k is set for cell k when it is hidden."""
    if area < 1:
        area = 1
    half = (area * _COVERED_Q8) >> 8
    if is_faint:
        half = 0
    most = area + area - (area >> 3)
    dark = 0
    cell = 0
    while cell < 24:
        if int(depths[cell]) > _DARK:
            dark += 1
        cell += 1
    if dark < _DARK_LEAST:
        most = 0
    hidden = 0
    angle -= _CELL_TURN16 - 2048
    i = 0
    cell = 0
    while cell < 24:
        # the border between sectors k - 1 and k
        k = (angle >> 12) & 15
        after = int(means[16 + k])
        before = int(means[16 + ((k + 15) & 15)])
        if after == 0:
            after = before
        elif before == 0:
            before = after
        if after > 0:
            least = _FADED_LEAST_Q8
            if before < half or after < half:
                hidden = hidden | (1 << cell)
                least = _HIDDEN_LEAST_Q8
            if before + after < most and int(depths[cell]) > _OUTSIDE:
                k = ((before + after) << 7) // area
                if k < least:
                    k = least
                depths[cell] = ((int(depths[cell]) - _BIAS) << 8) // k + _BIAS
        cell += 1
        i += 1
        angle -= _CELL_STEP_TURN16
        if i == 3:
            angle -= _CELL_GAP_TURN16
        elif i == 6:
            i = 0
            angle -= 16384 - 6 * _CELL_STEP_TURN16 - _CELL_GAP_TURN16
    return hidden
