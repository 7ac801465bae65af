"""What cells that were measured tell: their weights, and the two likeliest words of the code.

Darkness is in units of tables.LOG_GREY_Q8.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_WORD_ID = const(0)
_WORD_COST = const(1)
_WORD_SECOND = const(2)
_WORD_CONTRADICTED = const(3)
_WORD_BLANK = const(4)

SCRATCH = const(172)  # items of scratch space that `likeliest_words` takes
WEIGHTS = const(26)  # items that `cell_weights` writes

_LIGHT = const(_BIAS - 128)
_BLEACHED = const(1024)  # log units: a grey of 240
_LEAST_CELLS = const(12)
_ALL_WHITE = const(20)  # cells that must have been looked at, for none of them to be dark to tell something
_DARK = const(_BIAS + 154)  # the fourth darkest cell of a coded marker shows more
_ENOUGH = const(192)  # a second word that costs so much more than the first leaves no doubt of it
_TOO_NEAR = const(78)  # a word other than the empty one is not told when a second costs less than that more
_CERTAIN = const(400)  # so much, where some cells tell nothing or contradict: the best of margins
_EXAMINED_MOST = const(100)  # words that are looked at, and some; others count for what they cost at least
# a cell that leaves no doubt weighs 64; to be believed a word must cost that much less than the second,
_GAP_LEAST = const(78)
_GAP_LEAST_ALONE = const(110)  # without lines that agree,
_GAP_LEAST_PLAIN = const(80)  # of plain markers, with lines that were read,
_GAP_LEAST_TURNED = const(78)  # where the orientation line is not seen, when the first costs at most
_COST_MOST_TURNED = const(80)  # that much,
_GAP_SURE = const(288)  # for the margin of 255 so much more,
_COST_QUARTERS = const(5)  # and at least as much as the first contradicts,
_COST_QUARTERS_PLAIN = const(2)  # of the empty word half as much: what hides cells seldom darkens them
_SHADE = const(60)  # log units
_TONE = const(100)  # log units: 19 of them are 5 percent
_STROKE_MOST = const(5)  # dark cells, none that is white between them, that one stroke may cross,
_STROKE_FEW = const(3)  # and at two places


@micropython.viper
def cell_weights(value: int, i: int, scratch: ptr32, depths: ptr32, hidden: int, weights: ptr32) -> int:
    """What each cell tells: + BIAS, up to 64 above it looks dark, up to 64 below white, BIAS nothing.

    depths: as from `cells.cell_depths`; hidden: as from `cells.local_depths`; scratch: 48 items.
    Levels are the fourth of both ends, since of a coded marker at least 8 cells are dark and 8 white; where
    the darkest are not dark, those of a plain marker.
    What covers a cell looks like white, but is seldom as bright as the white beside the cells that are dark:
    the less alike, the less a cell tells; but where none looks dark, an edge of light is likelier than
    something that hides them all. Where the ring before it is hidden, a cell that looks white tells nothing.
    weights: WEIGHTS items; after the cells' the usual white, log units, and what the dark ones cost a plain
    marker: half of it beyond the first, when one stroke may make them all. Returns how many cells were looked
    at, 0 when too few."""
    count = 0
    seen = 0
    # the four lowest and the four highest so far
    low = 1 << 29
    low_3 = low
    low_2 = low
    low_1 = low
    high = 0
    high_3 = 0
    high_2 = 0
    high_1 = 0
    i = 0
    while i < 24:
        value = int(depths[i])
        # outside the frame, or lighter than the white beside it
        if value < _LIGHT:
            weights[i] = 0
            if value:
                seen += 1
        else:
            weights[i] = value
            count += 1
            if value < low:
                if value < low_3:
                    low = low_3
                    if value < low_2:
                        low_3 = low_2
                        if value < low_1:
                            low_2 = low_1
                            low_1 = value
                        else:
                            low_2 = value
                    else:
                        low_3 = value
                else:
                    low = value
            if value > high:
                if value > high_3:
                    high = high_3
                    if value > high_2:
                        high_3 = high_2
                        if value > high_1:
                            high_2 = high_1
                            high_1 = value
                        else:
                            high_2 = value
                    else:
                        high_3 = value
                else:
                    high = value
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
    darkest = high + half + half
    lightest = low - half
    # the white beside the dark cells in order, after an item less than any, to know its middle, or where
    # there are few, beside all
    scratch[0] = 0
    dark = 0
    i = 0
    while i < 24:
        value = int(weights[i])
        if value > darkest or value < lightest:
            weights[i] = _BIAS
        else:
            value = (value - middle) * 83 // half
            if value > 0:
                if value > 64:
                    value = 64
                if value < 17:
                    value = 0
            else:
                if value < 0 - 64:
                    value = 0 - 64
                if value > 0 - 17:
                    value = 0
            weights[i] = value + _BIAS
            if value > 0:
                value = int(depths[48 + i])
                slot = dark
                near = int(scratch[slot])
                while near > value:
                    scratch[slot + 1] = near
                    slot -= 1
                    near = int(scratch[slot])
                scratch[slot + 1] = value
                dark += 1
        i += 1
    many_dark = 1
    if dark < 4:
        many_dark = 0
        # two fifths of all are as bright or brighter: in order downwards, after an item above any
        scratch[0] = 1 << 29
        seen += count
        most = seen - seen * 3 // 5
        seen = 0
        last = 0 - 1
        i = 0
        while i < 24:
            value = int(depths[48 + i])
            if value > last and int(depths[i]):
                slot = most - 1
                if seen < most:
                    slot = seen
                    seen += 1
                near = int(scratch[slot])
                while near < value:
                    scratch[slot + 1] = near
                    slot -= 1
                    near = int(scratch[slot])
                scratch[slot + 1] = value
                if seen == most:
                    last = int(scratch[most])
            i += 1
        white = int(scratch[most])
    else:
        seen = dark
        white = int(scratch[1 + (seen >> 1)])
    weights[24] = white
    all_white = 0
    if dark == 0 and count >= _ALL_WHITE:
        all_white = 1
    # a lamp's light, unless the whole picture is bleached
    bleached = _BLEACHED
    if white >= _BLEACHED:
        bleached = 1 << 29
    total = 0
    dark = 0
    i = 0
    while i < 24:
        value = int(weights[i]) - _BIAS
        off = int(depths[48 + i]) - white
        # as white as the others in most
        if off > _TONE >> 1 or off < 0 - (_TONE >> 1) or int(depths[24 + i]) >= bleached:
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
            if off > _TONE >> 1 and value < 0 and many_dark:
                # where two cells are dark in the same shadow or light, the plate is seen there
                level = int(depths[48 + i])
                slot = 1
                while slot < seen:
                    near = int(scratch[slot + 1]) - level
                    far = level - int(scratch[slot])
                    slot += 1
                    if far < 0:
                        slot = seen  # the others lie farther
                    if near < far:
                        near = far
                    if near < off:
                        off = near
                        if off <= _TONE >> 1:
                            slot = seen  # near enough
            off = _TONE + (_TONE >> 1) - off
            if value > 0:
                off += _TONE + (_TONE >> 1)
            if int(depths[24 + i]) >= bleached:
                off = 0
            if off < _TONE:
                if off < 0:
                    off = 0
                if all_white and off < _TONE >> 1:
                    off = _TONE >> 1
                value = value * off // _TONE
                weights[i] = value + _BIAS
        if value > 0:
            total += value
            dark += 1
        elif value < 0 and (hidden >> i) & 1:
            weights[i] = _BIAS
        i += 1
    # dark cells that one stroke may have made: there is none between them that is white, or they are few
    if total > 64 and dark <= _STROKE_MOST:
        strokes = 0
        seen = 0
        i = 0
        while i < 48:
            slot = i
            if i >= 24:
                slot = i - 24
            value = int(weights[slot]) - _BIAS
            if value > 0:
                if seen == 0 and i >= 24:  # by then it is known what came before the first
                    strokes += 1
                seen = 1
            elif value < 0:
                seen = 0
            i += 1
        if strokes < 3 and dark <= _STROKE_FEW:
            total -= ((total - 64) * 3) >> 2
        elif strokes < 2:
            total -= (total - 64) >> 1
    weights[25] = total
    return count


@micropython.viper
def certain_word(
    j: int, i: int, least: ptr32, weights: ptr32, generator: ptr16, lines: ptr32, result: ptr32
) -> int:  # fmt: skip
    """The word of the cells' code that they leave no doubt of; 1, or 0 when there is none.

    Looked at are those that the cells as they look are, but for up to two of twelve that carry an ID, when
    they contradict one cell at most. Any other word differs from such a one in eight cells, which tells what
    it costs at least. least: 9 items, scratch space; the other arguments and the result as in
    `likeliest_words`."""
    shift = int(lines[3])
    word = 0
    telling = 0
    bit = 1
    i = 0
    while i < 24:
        j = i + shift
        if j >= 24:
            j -= 24
        value = int(weights[j])
        if value != _BIAS:
            telling = telling | bit
            if value > _BIAS:
                word = word | bit
        bit += bit
        i += 1
    marker_id = 0
    hard = word
    bit = 1
    i = 0
    while i < 12:
        if (hard >> int(generator[24 + i])) & 1:
            marker_id = marker_id | bit
            word = word ^ int(generator[i + i]) ^ (int(generator[i + i + 1]) << 16)
        bit += bit
        i += 1
    # from here on, what a word contradicts
    odd = word & telling
    odd = odd & (odd - 1)
    i = 0
    while odd and i < 12:
        row = int(generator[i + i]) | (int(generator[i + i + 1]) << 16)
        odd = (word ^ row) & telling
        odd = odd & (odd - 1)
        j = i + 1
        while odd and j < 12:
            other = row ^ int(generator[j + j]) ^ (int(generator[j + j + 1]) << 16)
            odd = (word ^ other) & telling
            odd = odd & (odd - 1)
            if odd == 0:
                row = other
                marker_id = marker_id ^ (1 << j)
            j += 1
        if odd == 0:
            word = word ^ row
            marker_id = marker_id ^ (1 << i)
        i += 1
    if odd:
        return 0
    if marker_id:
        if marker_id < 8 or marker_id & 7 == 0 or marker_id == 4095:
            return 0
        i = 0
        while i < 3:
            value = int(lines[i]) - _BIAS
            if (marker_id >> i) & 1:
                value = 0 - value
            if value > 0:
                return 0
            i += 1
    # what the eight that tell the least would cost, the one that is contradicted taken off
    least[0] = 0
    count = 0
    last = 1 << 29
    cost = 0
    blank = 0
    contradicted = 0
    i = 0
    while i < 24:
        j = i + shift
        if j >= 24:
            j -= 24
        value = int(weights[j])
        if value < _BIAS:
            value = _BIAS + _BIAS - value
        if value == _BIAS:
            blank += 1
        elif (word >> i) & 1:
            contradicted = 1
            cost = value - _BIAS
            value = _BIAS - cost
        if value < last:
            # the largest of eight falls out
            j = 7
            if count < 8:
                j = count
                count += 1
            other = int(least[j])
            while other > value:
                least[j + 1] = other
                j -= 1
                other = int(least[j])
            least[j + 1] = value
            if count == 8:
                last = int(least[8])
        i += 1
    second = 0
    i = 1
    while i < 9:
        second += int(least[i]) - _BIAS
        i += 1
    if second < _ENOUGH or (second < _CERTAIN and cost + blank):
        return 0
    result[_WORD_ID] = marker_id
    result[_WORD_COST] = cost
    result[_WORD_SECOND] = cost + second
    result[_WORD_CONTRADICTED] = contradicted
    result[_WORD_BLANK] = blank
    return 1


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
    most two of them are looked at one by one, and where that leaves doubt those that contradict three, until
    _EXAMINED_MOST have been; of any other it is known what it costs at least (ordered statistics decoding,
    Fossorier and Lin, IEEE Trans. Inf. Theory 41, 1995, p. 1379).
    result: WORD. Returns the ID of the second, or 4096 when none was looked at."""
    # cells by what they tell: items 26 .. 49
    shift = int(lines[3])
    hard = 0
    blank = 0
    code = 0
    i = 0
    while i < 3:
        if int(lines[i]) > _BIAS:
            code = code | (1 << i)
        i += 1
    i = 0
    while i < 24:
        j = i + shift
        if j >= 24:
            j -= 24
        value = int(weights[j]) - _BIAS
        if value > 0:
            hard = hard | (1 << i)
        elif value == 0:
            blank += 1
        else:
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
    examined = 0
    k = 12
    while k < 13:
        base = word ^ int(rows[k])
        base_id = marker_id ^ int(rows[13 + k])
        # from the basis cells that tell the least; what they cost is known beforehand
        first = 0
        i = 12
        apart = 0
        if k < 12:
            first = k + 1
            i = 11
            apart = int(rows[26 + k]) >> 5
        end = i
        while i >= first:
            one = apart
            if i < 12:
                one += int(rows[26 + i]) >> 5
            j = end
            if one >= second:
                i = 0 - 1
                j = i
            while j > i or (j == 12 and i == 12):
                other = one
                if j < 12:
                    other += int(rows[26 + j]) >> 5
                row_id = 1
                if other >= second:
                    j = i  # and so is whatever follows
                else:
                    row_id = base_id ^ int(rows[13 + i]) ^ int(rows[13 + j])
                row = base ^ int(rows[i]) ^ int(rows[j])
                # IDs below 8 have no cells of their own, but the empty word stands for them
                if (row_id & 7 and row_id > 7 and row_id != 4095) or row_id == 0:
                    examined += 1
                    value = int(rows[50 + (row & 15)]) + int(rows[66 + ((row >> 4) & 15)])
                    value += int(rows[82 + ((row >> 8) & 15)])
                    if value < second:  # most words cost that much in half of the cells
                        value += int(rows[98 + ((row >> 12) & 15)])
                        value += int(rows[114 + ((row >> 16) & 15)]) + int(rows[130 + (row >> 20)])
                    if row_id and value < second:
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
                j -= 1
            i -= 1
        contradicted = 0
        i = 0
        while i < 24:
            j = i + shift
            if j >= 24:
                j -= 24
            if (best_word >> i) & 1 and int(weights[j]) != _BIAS:
                contradicted += 1
            i += 1
        # every other word contradicts three of the basis, one of them before the last that was changed, or
        # four, and differs from the first in eight cells
        if k == 12:
            k = 10
        least = 1 << 20
        count = 4
        while count > 2:
            value = 0
            i = 0
            while i < count:
                value += int(rows[37 - i]) >> 5
                i += 1
            if count == 3:
                value -= int(rows[35]) >> 5
                if k == 0:
                    value = least
                else:
                    value += int(rows[25 + k]) >> 5
            while i + contradicted < 8:
                value += int(rows[171 + count - i])
                i += 1
            more = 0
            if value < least:
                least = value
                more = 1
            count -= 1
        k -= 1
        if (
            (best_id and least >= best and second - best < _TOO_NEAR)
            or more == 0
            or examined > _EXAMINED_MOST
        ):
            k = 13  # neither would another word be told nor this one, or it takes too much work
        elif least >= second or least - best >= _ENOUGH:
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


@micropython.viper
def believed_word(lines_id: int, gap: int, is_turned: int, weights: ptr32, result: ptr32) -> int:
    """What is believed of the two likeliest words: 1 + its ID + 4096 * margin of 0..255; 0 for neither.

    lines_id: 1..7 as the coding lines were read, which must agree; 0 when in doubt. is_turned: 1 where the
    code alone says where the orientation line is. weights: as from `cell_weights`,
    of which item 25 counts; result: WORD."""
    told = int(result[_WORD_ID])
    cost = int(result[_WORD_COST])
    gap = int(result[_WORD_SECOND]) - cost
    least = _GAP_LEAST_ALONE
    if lines_id:
        # one stroke across a plain plate, such as its own edge, contradicts it but once
        plain = int(weights[25])
        least = _GAP_LEAST
        if told == 0 or plain < cost:
            least = _GAP_LEAST_PLAIN
            if told:
                gap = 0
            gap += cost - plain
            cost = plain
            told = 0
        elif told & 7 != lines_id:
            return 0
        elif gap > plain - cost:
            gap = plain - cost
    if is_turned:
        least = _GAP_LEAST_TURNED
        if cost > _COST_MOST_TURNED:
            return 0
    quarters = _COST_QUARTERS
    if told == 0:
        quarters = _COST_QUARTERS_PLAIN
    if gap < least or gap * 4 < cost * quarters:
        return 0
    gap = (gap - least) * 255 // _GAP_SURE
    if gap > 255:
        gap = 255
    return 1 + told + (gap << 12)
