"""What dark cells cost a plain marker: the places beside them tell print from strokes.

Angles count clockwise from x, because y points down. Darkness is in units of tables.LOG_GREY_Q8.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
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

GAPS = const(24)  # items of scratch space that `stroke_cost` takes

_MIDDLE_COS_Q14 = const(16214)  # 8.25 degrees: between a line's direction and the first cell
_MIDDLE_SIN_Q14 = const(2351)
_DIAGONAL_Q14 = const(11585)  # 45 degrees: between the third cell and the fourth
_TANGENT_Q14 = const(286)  # of 1 degree, between the samples at one radius
_STROKE_MOST = const(8)  # dark cells that strokes may have made: of a coded marker there are more, or as many
_WHITE_MOST = const(51)  # a fifth of a cell's darkness, or lighter by as much: white,
_CROSSED_LEAST = const(115)  # and this much: something other than print crosses it
_TONE = const(50)  # log units: 19 of them are 5 percent
_TONE_MOST = const(100)
_PRINTED = const(32)  # white on both sides is what printed cells have


@micropython.viper
def stroke_cost(
    x: int, y: int, image: ptr8, log: ptr16, place: ptr32, depths: ptr32, weights: ptr32, gaps: ptr32
) -> int:  # fmt: skip
    """What the dark cells cost a plain marker: as much as they weigh, but for what no print makes.

    place, depths: as `cells.cell_depths` takes and writes them; weights: as from `cell_words.cell_weights`,
    before they are mirrored; gaps: GAPS items, scratch space: how dark the white places beside the first and
    the last of three cells are, where these are dark.
    Cells are taken together that stand side by side, with nothing white between them. Where a place that is
    never printed on is dark, too, a stroke crosses them all: they cost nothing. Where the white beside a cell
    has another tone, an edge lies there: it costs less, and half where the cell before or after has. Where
    white is on both sides they are as sharp as print, and cost more."""
    dark = int(weights[26])
    i = dark
    count = 0
    while i:
        i = i & (i - 1)
        count += 1
    if count == 0 or count > _STROKE_MOST:
        return int(weights[25])
    width = int(place[_PLACE_WIDTH])
    height = int(place[_PLACE_HEIGHT])
    radius = int(place[_PLACE_RADIUS_Q8])
    unit = int(place[_PLACE_DEPTH]) << 2
    ux = int(place[_PLACE_COSINE_Q14]) - _BIAS
    uy = int(place[_PLACE_SINE_Q14]) - _BIAS
    e1 = int(place[_PLACE_E1_Q14]) - _BIAS
    e2 = int(place[_PLACE_E2_Q14]) - _BIAS
    i = 0
    while i < 24:
        # the places before the first cell of six, between the third and the fourth, after the last
        x = _MIDDLE_COS_Q14
        y = _MIDDLE_SIN_Q14
        k = dark >> i
        if i % 6 == 2:
            x = _DIAGONAL_Q14
            y = _DIAGONAL_Q14
            k = k | (k >> 1)
        elif i % 6 == 5:
            x = _MIDDLE_SIN_Q14
            y = _MIDDLE_COS_Q14
        if k & 1:
            vx = (ux * x + uy * y) >> 14
            vy = (uy * x - ux * y) >> 14
            bend = ((int(place[_PLACE_HX_Q14]) - _BIAS) * vx + (int(place[_PLACE_HY_Q14]) - _BIAS) * vy) >> 14
            dx = (radius * (vx + ((e1 * vx + e2 * vy) >> 14))) >> 14
            dy = (radius * (vy + ((e2 * vx - e1 * vy) >> 14))) >> 14
            # two pixels at each of four radii: white first, then between the cells
            value = 0
            k = 0
            while k < 8:
                y = int(place[_PLACE_RADII_Q10 + (k >> 1)])
                y += (((y * y) >> 10) * bend) >> 14
                x = (dx * y) >> 10
                y = (dy * y) >> 10
                step = _TANGENT_Q14
                if k & 1:
                    step = 0 - step
                vx = (x + ((y * step) >> 14) + int(place[_PLACE_X_Q8]) + 128) >> 8
                vy = (y - ((x * step) >> 14) + int(place[_PLACE_Y_Q8]) + 128) >> 8
                if vx < 0 or vy < 0 or vx >= width or vy >= height:
                    value = 0 - (1 << 20)
                    k = 8
                else:
                    x = int(log[int(image[vy * width + vx])])
                    if k >= 4:
                        x = 0 - x
                    value += x
                    k += 1
            if value < 0 - 8192:
                gaps[i] = 0  # outside the frame: neither dark nor white
            else:
                gaps[i] = (value << 8) // unit + _BIAS
            if i % 6 == 2:
                gaps[i + 1] = int(gaps[i])
        if i % 6 == 0:
            i += 2
        elif i % 6 == 2:
            i += 3
        else:
            x = ux
            ux = uy
            uy = 0 - x
            i += 1
    white = int(weights[24])
    total = 0
    i = 0
    while i < 24:
        before = i - 1
        if i == 0:
            before = 23
        first = (dark >> i) & 1
        if first and (dark >> before) & 1:
            if i % 3 or int(gaps[i]) > _BIAS + _WHITE_MOST or int(gaps[before]) > _BIAS + _WHITE_MOST:
                first = 0
        if first:
            # the first of some that belong together
            crossed = 0
            steady = 1
            cost = 0
            k = i
            more = 1
            while more:
                value = int(weights[k]) - _BIAS
                if value <= 0:
                    value = 64  # darker than ink
                x = int(depths[48 + k]) - white
                if x < 0:
                    x = 0 - x
                if x > _TONE:
                    steady = 0
                    if x > _TONE_MOST:
                        x = _TONE_MOST
                    value = value * (_TONE_MOST - x) // (_TONE_MOST - _TONE)
                cost += value
                if k % 3 != 1 and int(gaps[k]) > _BIAS + _CROSSED_LEAST:
                    crossed = 1
                last = k
                k += 1
                if k == 24:
                    k = 0
                more = (dark >> k) & 1
                if (
                    k % 3 == 0
                    and int(gaps[last]) <= _BIAS + _WHITE_MOST
                    and int(gaps[k]) <= _BIAS + _WHITE_MOST
                ):
                    more = 0
            # what lies before the first, and after the last
            edge = 0
            slot = before
            value = int(depths[slot])
            if i % 3 == 0:
                value = int(gaps[i])
            y = 0
            while y < 2:
                x = 0
                if int(depths[slot]):
                    x = int(depths[48 + slot]) - white
                if x < 0:
                    x = 0 - x
                if x > _TONE_MOST:
                    edge = 1
                if x > _TONE or value > _BIAS + _WHITE_MOST or value < _BIAS - _WHITE_MOST:
                    steady = 0
                slot = k
                value = int(depths[slot])
                if last % 3 == 2:
                    value = int(gaps[last])
                y += 1
            if crossed:
                cost = 0
            elif steady:
                cost += _PRINTED
            elif edge:
                cost = cost >> 1
            total += cost
        i += 1
    return total
