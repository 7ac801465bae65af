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
_WORD_ID = const(0)
_WORD_COST = const(1)
_WORD_SECOND = const(2)
_WORD_CONTRADICTED = const(3)
_WORD_BLANK = const(4)

SCRATCH = const(172)  # items of scratch space that `likeliest_words` takes

_LIGHT = const(_BIAS - 128)
_BLEACHED = const(1024)  # log units: a grey of 240
_LEAST_CELLS = const(12)
_ALL_WHITE = const(20)  # cells that must have been looked at, for none of them to be dark to tell something
_DARK = const(_BIAS + 154)  # the fourth darkest cell of a coded marker shows more
_ENOUGH = const(192)  # a second word that costs so much more than the first leaves no doubt of it
_ALL_TELL = const(24)  # the least telling cell of those that are as a word has them
_SHADE = const(60)  # log units
_TONE = const(100)  # log units: 19 of them are 5 percent
_BENT_MOST = const(4096)
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
    position: int, x: int, y: int, image: ptr8, log: ptr16, axes: ptr16, place: ptr32, result: ptr32
) -> int:  # fmt: skip
    """How dark each of the 24 cells is, from the nearest pixels: six in it and four of white beside it.

    place: PLACE, centre within the frame or at most a radius outside, radius 1024..20480, shape within +-4096
    of BIAS; axes: tables.CELL_AXES, cosine and sine of the six cells of a quarter turn.
    result: of each cell 256 * darkness / depth + BIAS, 0 when a pixel lies outside the frame; then of each
    the mean brightness in it, then of the white beside it, log units. Returns the number of cells that lie
    inside the frame."""
    width = int(place[_PLACE_WIDTH])
    right = (width << 8) - 1
    bottom = (int(place[_PLACE_HEIGHT]) << 8) - 1
    radius = int(place[_PLACE_RADIUS_Q8])
    unit = int(place[_PLACE_DEPTH]) * 12
    cx = int(place[_PLACE_X_Q8]) + 128
    cy = int(place[_PLACE_Y_Q8]) + 128
    inside = 0
    cell = 0
    while cell < 24:
        # direction of the cell: counterclockwise by whole quarters, then by its angle within one
        dx = int(place[_PLACE_COSINE_Q14]) - _BIAS
        dy = int(place[_PLACE_SINE_Q14]) - _BIAS
        position = cell
        while position >= 6:
            x = dx
            dx = dy
            dy = 0 - x
            position -= 6
        x = int(axes[position + position])
        y = int(axes[position + position + 1])
        vx = (dx * x + dy * y) >> 14
        vy = (dy * x - dx * y) >> 14
        x = int(place[_PLACE_E1_Q14]) - _BIAS
        y = int(place[_PLACE_E2_Q14]) - _BIAS
        bend = ((int(place[_PLACE_HX_Q14]) - _BIAS) * vx + (int(place[_PLACE_HY_Q14]) - _BIAS) * vy) >> 14
        dx = (radius * (vx + ((x * vx + y * vy) >> 14))) >> 14
        dy = (radius * (vy + ((y * vx - x * vy) >> 14))) >> 14
        beside = 0
        within = 0
        ring = 0
        while ring < 4:
            position = int(place[_PLACE_RADII_Q10 + ring])
            position = position + ((((position * position) >> 10) * bend) >> 14)
            vx = (dx * position) >> 10
            vy = (dy * position) >> 10
            step_x = (vy * _TANGENT_Q14) >> 14
            step_y = (vx * _TANGENT_Q14) >> 14
            x = cx + vx + step_x
            y = cy + vy - step_y
            vx = x - step_x - step_x
            vy = y + step_y + step_y
            if x < 0 or y < 0 or x > right or y > bottom or vx < 0 or vy < 0 or vx > right or vy > bottom:
                ring = 8
            else:
                sum = int(log[int(image[(y >> 8) * width + (x >> 8)])])
                sum += int(log[int(image[(vy >> 8) * width + (vx >> 8)])])
                if ring < 2:
                    beside += sum
                else:
                    within += sum + int(log[int(image[((y + step_y) >> 8) * width + ((x - step_x) >> 8)])])
                ring += 1
        result[cell] = 0
        if ring == 4:
            inside += 1
            x = ((beside * 3 - within * 2) << 8) // unit + _BIAS
            if x < 1:
                x = 1
            result[cell] = x
        result[24 + cell] = within // 6
        result[48 + cell] = beside >> 2
        cell += 1
    return inside


@micropython.viper
def cell_weights(scratch: ptr32, i: int, value: int, depths: ptr32, weights: ptr32) -> int:
    """What each cell tells: + BIAS, up to 64 above it looks dark, up to 64 below white, BIAS nothing.

    depths: as from `cell_depths`; scratch: 48 items. Levels are the fourth of both ends, since of a coded
    marker at least 8 cells are dark and 8 white; where the darkest are not dark, those of a plain marker.
    What covers a cell looks like white, but is seldom as bright as the white beside the cells that are dark:
    the less alike, the less a cell tells; but where none looks dark, an edge of light is likelier than
    something that hides them all. weights has 25 items, the last for the usual white, log units.
    Returns how many cells were looked at, 0 when too few."""
    count = 0
    low = 1 << 29  # the fourth lowest, in items 0 .. 3, and the fourth highest, in items 4 .. 7
    high = 0
    i = 0
    while i < 4:
        scratch[i] = low
        scratch[4 + i] = high
        i += 1
    i = 0
    while i < 24:
        value = int(depths[i])
        # outside the frame, or lighter than the white beside it
        if value < _LIGHT:
            value = 0
        weights[i] = value
        if value:
            count += 1
            if value < low:
                slot = 3
                while slot > 0 and int(scratch[slot - 1]) > value:
                    scratch[slot] = int(scratch[slot - 1])
                    slot -= 1
                scratch[slot] = value
                low = int(scratch[3])
            if value > high:
                slot = 7
                while slot > 4 and int(scratch[slot - 1]) < value:
                    scratch[slot] = int(scratch[slot - 1])
                    slot -= 1
                scratch[slot] = value
                high = int(scratch[7])
        i += 1
    if count < _LEAST_CELLS:
        return 0
    if high < _DARK:
        low = _BIAS
        high = _BIAS + 256
        middle = _BIAS + 128
        half = 102
    else:
        middle = (low + high) >> 1
        half = (high - low + 2) >> 1
    span = half + half
    dark = 0
    i = 0
    while i < 24:
        value = int(weights[i])
        if value == 0 or value > high + span or value + half < low:
            value = 0
        else:
            value = (value - middle) * 83 // half
            if value > 64:
                value = 64
            if value < 0 - 64:
                value = 0 - 64
            if value < 17 and value > 0 - 17:
                value = 0
        weights[i] = value + _BIAS
        if value > 0:
            dark += 1
        i += 1
    # the white beside the dark cells, where there are some, or of the brighter half of all
    seen = 0
    i = 0
    while i < 24:
        value = 0
        if int(depths[i]) and (dark < 4 or int(weights[i]) > _BIAS):
            value = int(depths[48 + i])
            slot = seen
            while slot > 0 and int(scratch[slot - 1]) > value:
                scratch[slot] = int(scratch[slot - 1])
                slot -= 1
            scratch[slot] = value
            seen += 1
        i += 1
    if dark < 4:
        white = int(scratch[seen * 3 // 5])
    else:
        white = int(scratch[seen >> 1])
    weights[24] = white
    i = 0
    while i < 24:
        value = int(weights[i]) - _BIAS
        off = int(depths[48 + i]) - white
        if off < 0:
            off = 0 - off
            if off > _SHADE and int(depths[i]):
                # in a shadow ink is less dark against the white beside it
                value = int(depths[i]) - middle + (middle - low) * off // 768
                value = value * 83 // half
                if value > 64:
                    value = 64
                if value < 0 - 64:
                    value = 0 - 64
                if value < 17 and value > 0 - 17:
                    value = 0
                weights[i] = value + _BIAS
        off = _TONE + (_TONE >> 1) - off
        if value > 0:
            off += _TONE + (_TONE >> 1)
        # a lamp's light, unless the whole picture is bleached
        if int(depths[24 + i]) >= _BLEACHED and white < _BLEACHED:
            off = 0
        if off < _TONE:
            if off < 0:
                off = 0
            if dark == 0 and count >= _ALL_WHITE and off < _TONE >> 1:
                off = _TONE >> 1
            weights[i] = value * off // _TONE + _BIAS
        i += 1
    return count


@micropython.viper
def likeliest_words(
    rows: ptr32, i: int, j: int, weights: ptr32, generator: ptr16, lines: ptr32, allowed: ptr8, result: ptr32
) -> int:  # fmt: skip
    """The two words of the cells' code that cost least, given what each cell looks like.

    weights: of each cell, + BIAS: above it looks dark, below white, by at most 1023, which is what it costs a
    word to contradict it; lines: likewise of the three coding lines, the least significant first, which count
    for every word but the empty one, that of a plain marker; then the cell that counts as the first, 0..23.
    generator: tables.CELL_ROWS. allowed: a bit for each of 4096 IDs: the second word must be allowed. rows:
    SCRATCH items, scratch space.
    The 12 most telling cells that are independent of each other make a basis. The words that contradict at
    most two of them, and where that leaves doubt three, are looked at one by one; of any other it is known
    what it costs at least (ordered statistics decoding, Fossorier and Lin, IEEE Trans. Inf. Theory 41, 1995,
    p. 1379).
    result: WORD. Returns the ID of the second, or 4096 when none was looked at."""
    # cells by what they tell: items 26 .. 49
    shift = int(lines[3])
    hard = 0
    blank = 0
    least = 1 << 20
    i = 0
    while i < 24:
        j = i + shift
        if j >= 24:
            j -= 24
        value = int(weights[j]) - _BIAS
        if value > 0:
            hard = hard | (1 << i)
        else:
            value = 0 - value
        if value < least:
            least = value
        i += 1
    code = 0
    i = 0
    while i < 3:
        if int(lines[i]) > _BIAS:
            code = code | (1 << i)
        i += 1
    # mostly the cells as they look are a word: every other one contradicts eight of them
    word = 0
    marker_id = 0
    i = 0
    while i < 12:
        if (hard >> int(generator[24 + i])) & 1:
            word = word ^ int(generator[i + i]) ^ (int(generator[i + i + 1]) << 16)
            marker_id = marker_id | (1 << i)
        i += 1
    if word == hard and least >= _ALL_TELL:
        if marker_id == 0 or (marker_id & 7 == code and marker_id > 7 and marker_id != 4095):
            result[_WORD_ID] = marker_id
            result[_WORD_COST] = 0
            result[_WORD_SECOND] = least << 3
            result[_WORD_CONTRADICTED] = 0
            result[_WORD_BLANK] = 0
            return 4096
    i = 0
    while i < 24:
        j = i + shift
        if j >= 24:
            j -= 24
        value = int(weights[j]) - _BIAS
        if value == 0:
            blank += 1
        if value < 0:
            value = 0 - value
        value = (value << 5) | i
        j = i
        while j > 0 and int(rows[25 + j]) < value:
            rows[26 + j] = int(rows[25 + j])
            j -= 1
        rows[26 + j] = value
        i += 1
    # what the 16 patterns of each 4 cells cost to contradict: items 50 .. 145
    i = 0
    while i < 24:
        slot = 50 + ((i >> 2) << 4)
        if i & 3 == 0:
            rows[slot] = 0
        j = i + shift
        if j >= 24:
            j -= 24
        value = int(weights[j]) - _BIAS
        if value < 0:
            value = 0 - value
        size = 1 << (i & 3)
        j = 0
        while j < size:
            rows[slot + size + j] = int(rows[slot + j]) + value
            j += 1
        i += 1
    # a generator of the code that has a basis cell each: words in items 0 .. 11, their IDs in 13 .. 24
    i = 0
    while i < 12:
        rows[i] = int(generator[i + i]) | (int(generator[i + i + 1]) << 16)
        rows[13 + i] = 1 << i
        i += 1
    rows[12] = 0
    rows[25] = 0
    word = 0
    marker_id = 0
    rank = 0
    place = 26
    while rank < 12:
        cell = int(rows[place]) & 31
        i = rank
        while i < 12 and (int(rows[i]) >> cell) & 1 == 0:
            i += 1
        if i < 12:
            row = int(rows[i])
            rows[i] = int(rows[rank])
            rows[rank] = row
            row_id = int(rows[13 + i])
            rows[13 + i] = int(rows[13 + rank])
            rows[13 + rank] = row_id
            rows[26 + rank] = int(rows[place])
            j = 0
            while j < 12:
                if j != rank and (int(rows[j]) >> cell) & 1:
                    rows[j] = int(rows[j]) ^ row
                    rows[13 + j] = int(rows[13 + j]) ^ row_id
                j += 1
            rank += 1
        else:
            rows[134 + place - rank] = int(rows[place]) >> 5
        place += 1
    while place < 50:
        rows[134 + place - rank] = int(rows[place]) >> 5
        place += 1
    i = 0
    while i < 12:
        if (hard >> (int(rows[26 + i]) & 31)) & 1:
            word = word ^ int(rows[i])
            marker_id = marker_id ^ int(rows[13 + i])
        i += 1
    word = word ^ hard  # from here on, what a word contradicts
    best = 1 << 20
    best_id = 4096
    best_word = 0
    second = 1 << 20
    second_id = 4096
    k = 12
    while k < 13:
        base = word ^ int(rows[k])
        base_id = marker_id ^ int(rows[13 + k])
        i = 0
        end = 13
        if k < 12:
            i = k + 1
            end = 12
        while i < end:
            j = i + 1
            if i == 12:
                j = 12
            while j < end:
                row = base ^ int(rows[i]) ^ int(rows[j])
                row_id = base_id ^ int(rows[13 + i]) ^ int(rows[13 + j])
                # IDs below 8 have no cells of their own, but the empty word stands for them
                if (row_id & 7 and row_id > 7 and row_id != 4095) or row_id == 0:
                    value = int(rows[50 + (row & 15)]) + int(rows[66 + ((row >> 4) & 15)])
                    value += int(rows[82 + ((row >> 8) & 15)]) + int(rows[98 + ((row >> 12) & 15)])
                    value += int(rows[114 + ((row >> 16) & 15)]) + int(rows[130 + (row >> 20)])
                    if row_id:
                        rank = (row_id ^ code) & 7
                        cell = 0
                        while rank:
                            if rank & 1:
                                size = int(lines[cell]) - _BIAS
                                if size < 0:
                                    size = 0 - size
                                value += size
                            rank = rank >> 1
                            cell += 1
                    if value < second:
                        if value < best:
                            size = 0
                            if best_id < 4096:
                                size = int(allowed[best_id >> 3]) >> (best_id & 7)
                            if best_id == 0 or size & 1:
                                second = best
                                second_id = best_id
                            best = value
                            best_id = row_id
                            best_word = row
                        else:
                            size = int(allowed[row_id >> 3]) >> (row_id & 7)
                            if row_id == 0 or size & 1:
                                second = value
                                second_id = row_id
                j += 1
            i += 1
        if k < 9:
            k += 1
        else:
            contradicted = 0
            i = 0
            while i < 24:
                j = i + shift
                if j >= 24:
                    j -= 24
                if (best_word >> i) & 1 and int(weights[j]) != _BIAS:
                    contradicted += 1
                i += 1
            # every other word contradicts that many of the basis, and differs from the first in eight cells
            count = 3
            if k == 9:
                count = 4
            least = 0
            i = 0
            while i < count:
                least += int(rows[37 - i]) >> 5
                i += 1
            while i + contradicted < 8:
                least += int(rows[171 + count - i])
                i += 1
            if k == 12 and least < second and least - best < _ENOUGH:
                k = 0
            else:
                k = 13
    if second > least:
        second = least
        second_id = 4096
    result[_WORD_ID] = best_id
    result[_WORD_COST] = best
    result[_WORD_SECOND] = second
    result[_WORD_CONTRADICTED] = contradicted
    result[_WORD_BLANK] = blank
    return second_id
