"""What cells that were measured tell: their weights, and whether a word of the code is believed.

Darkness is in units of tables.LOG_GREY_Q8.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_WORD_ID = const(0)
_WORD_COST = const(1)
_WORD_SECOND = const(2)

WEIGHTS = const(29)  # items that `cell_weights` writes

_LIGHT = const(_BIAS - 128)
_BLEACHED = const(1024)  # log units: a grey of 240
_LEAST_CELLS = const(12)
_ALL_WHITE = const(20)  # cells that must have been looked at, for none of them to be dark to tell something
_DARK = const(_BIAS + 154)  # the fourth darkest cell of a coded marker shows more
_DARK_MOST = const(_BIAS + 384)  # where print is patchy some are darker: the others are not to pass for white
# a cell that leaves no doubt weighs 64; to be believed a word must cost that much less than the second,
_ALL_IN_DOUBT = const(56)  # no line tells anything
_GAP_LEAST = const(78)
_GAP_LEAST_NONE = const(48)  # less, and what it contradicts, where that is next to nothing,
_GAP_LEAST_PART = const(78)  # and twice what it contradicts, where some lines are in doubt,
_GAP_LEAST_ALONE = const(110)  # without lines that agree,
_GAP_LEAST_PLAIN = const(45)  # of plain markers, with lines that were read,
_GAP_LEAST_TURNED = const(78)  # where the orientation line is not seen, when the first costs at most
_COST_MOST_TURNED = const(80)  # that much,
_BLANK_FEW = const(4)  # cells that tell nothing, and nothing covers; for each beyond these so much more,
_GAP_BLANK = const(8)
_LITTLE = const(48)  # a cell that weighs less is in doubt,
_LITTLE_FEW = const(10)  # and of more, covered or not, two that are misread make another word:
_GAP_LITTLE = const(16)  # for each beyond these so much more,
_GAP_SURE = const(288)  # for the margin of 255 so much more,
_COST_QUARTERS = const(7)  # and at least as much as the first contradicts,
_COST_QUARTERS_PLAIN = const(2)  # of the empty word half as much: what hides cells seldom darkens them
_SHADE = const(60)  # log units
_TONE = const(100)  # log units: 19 of them are 5 percent


@micropython.viper
def cell_weights(neutral: int, i: int, scratch: ptr32, depths: ptr32, hidden: int, weights: ptr32) -> int:
    """What each cell tells: + BIAS, up to 64 above it looks dark, up to 64 below white, BIAS nothing.

    neutral: the share of the way from the white level to the dark one at which a cell tells nothing, 1..128
    / 256; depths: as from `cells.cell_depths`; hidden: as from `cells.local_depths`; scratch: 48 items.
    Levels are the fourth of both ends, since of a coded marker at least 8 cells are dark and 8 white; where
    the darkest are not dark, those of a plain marker.
    What covers a cell looks like white, but is seldom as bright as the white beside the cells that are dark:
    the less alike, the less a cell tells; but where none looks dark, an edge of light is likelier than
    something that hides them all. Where the ring before it is hidden, a cell that looks white tells nothing.
    weights: WEIGHTS items; after the cells' the usual white, log units, what the dark ones weigh in all,
    which they are: bit k for cell k, how many tell nothing though nothing of another tone covers them, and
    how many tell nothing or little.
    Returns how many cells were looked at, 0 when too few."""
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
    darkest = high + high - low + 1
    if high < _DARK:
        low = _BIAS
        high = _BIAS + 256
        darkest = _BIAS + 460
        middle = _BIAS + 128
        half = 102
        above = 83
        below = 83
    else:
        if high > _DARK_MOST:
            high = _DARK_MOST
        half = (high - low + 2) >> 1
        middle = ((high - low) * neutral) >> 8
        middle += low
        above = 83 - (((128 - neutral) * 5) >> 4)
        below = 83 + (((128 - neutral) * 5) >> 4)
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
            value = value - middle
            if value > 0:
                value = value * above // half
                if value > 64:
                    value = 64
                if value < 17:
                    value = 0
            else:
                value = value * below // half
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
    mask = 0
    blank = 0
    little = 0
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
                    if value > 0:
                        value = value * above // half
                    else:
                        value = value * below // half
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
            mask = mask | (1 << i)
        elif int(depths[i]) > darkest:
            total += 64  # no cell of a coded marker, but of a plain one neither
            mask = mask | (1 << i)
        elif value < 0 and (hidden >> i) & 1:
            weights[i] = _BIAS
        value = int(weights[i]) - _BIAS
        if value < _LITTLE and value > 0 - _LITTLE:
            little += 1
        if value == 0 and int(depths[i]):
            off = int(depths[48 + i]) - white
            if off <= _TONE and off >= 0 - _TONE:
                blank += 1  # nothing of another tone covers it
        i += 1
    weights[25] = total
    weights[26] = mask
    weights[27] = blank
    weights[28] = little
    return count


@micropython.viper
def believed_word(lines_id: int, gap: int, is_turned: int, weights: ptr32, result: ptr32) -> int:
    """What is believed of the two likeliest words: 1 + its ID + 4096 * margin of 0..255; 0 for neither.

    lines_id: 1..7 as the coding lines were read, which must agree; 0 when in doubt, or plus eight times the
    lines in doubt, when the others must. is_turned: 1 where the code alone says where the orientation line
    is. weights: as from `cell_weights`, of which item 25 counts; result: WORD."""
    told = int(result[_WORD_ID])
    cost = int(result[_WORD_COST])
    gap = int(result[_WORD_SECOND]) - cost
    least = _GAP_LEAST_ALONE
    if lines_id >= _ALL_IN_DOUBT:
        lines_id = 0
    elif lines_id > 7:
        if told and (told ^ lines_id) & (7 ^ (lines_id >> 3)):
            return 0
        least = _GAP_LEAST_PART + cost + cost
    elif lines_id:
        # one stroke across a plain plate, such as its own edge, contradicts it but once
        plain = int(weights[25])
        least = _GAP_LEAST
        if cost < _GAP_LEAST - _GAP_LEAST_NONE:
            least = _GAP_LEAST_NONE + cost
        if told == 0 or plain < cost:
            least = _GAP_LEAST_PLAIN
            if told:
                gap = 0
            gap += cost - plain
            cost = plain
            told = 0
        elif told & 7 != lines_id:
            return 0
        else:
            if gap > plain - cost:
                gap = plain - cost
            # another word may hide where nothing is seen
            count = (int(weights[27]) - _BLANK_FEW) * _GAP_BLANK
            little = (int(weights[28]) - _LITTLE_FEW) * _GAP_LITTLE
            if count < little:
                count = little
            if count > 0:
                least += count
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
