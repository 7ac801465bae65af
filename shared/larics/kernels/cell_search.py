"""The two words of the cells' code that cost least, given what each cell looks like."""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr16, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_WORD_ID = const(0)
_WORD_COST = const(1)
_WORD_SECOND = const(2)

SCRATCH = const(180)  # items of scratch space that `likeliest_words` takes

_ENOUGH = const(192)  # a second word that costs so much more than the first leaves no doubt of it
_TOO_NEAR = const(78)  # a word other than the empty one is not told when a second costs less than that more
_CERTAIN = const(400)  # so much, where some cells tell nothing or contradict: the best of margins
_EXAMINED_MOST = const(100)  # words that are looked at, and some; others count for what they cost at least


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
    blank = 0
    # and what the eight that tell the least would cost, in order after an item less than any
    least[0] = 0
    count = 0
    last = 1 << 29
    bit = 1
    cell = 0
    while cell < 24:
        i = cell + shift
        if i >= 24:
            i -= 24
        i = int(weights[i])
        if i == _BIAS:
            blank += 1
        else:
            telling = telling | bit
            if i > _BIAS:
                word = word | bit
            else:
                i = _BIAS + _BIAS - i
        if i < last:
            # the largest of eight falls out
            j = 7
            if count < 8:
                j = count
                count += 1
            other = int(least[j])
            while other > i:
                least[j + 1] = other
                j -= 1
                other = int(least[j])
            least[j + 1] = i
            if count == 8:
                last = int(least[8])
        bit += bit
        cell += 1
    second = 0 - (_BIAS << 3)
    i = 1
    while i < 9:
        second += int(least[i])
        i += 1
    if second < _ENOUGH or (second < _CERTAIN and blank):
        return 0
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
    # the one that is contradicted taken off
    cost = 0
    word = word & telling
    if word:
        i = shift
        while word > 1:
            word = word >> 1
            i += 1
        if i >= 24:
            i -= 24
        cost = int(weights[i]) - _BIAS
        if cost < 0:
            cost = 0 - cost
        last = last - _BIAS
        if cost < last:
            last = cost
        second -= cost + last
    if second < _ENOUGH or (second < _CERTAIN and cost + blank):
        return 0
    result[_WORD_ID] = marker_id
    result[_WORD_COST] = cost
    result[_WORD_SECOND] = cost + second
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
    telling = (1 << 24) - 1
    # backwards, as the last ones of equals come first; after an item above any, which none passes
    rows[25] = 1 << 29
    place = 26
    cell = 24
    while cell > 0:
        cell -= 1
        j = cell + shift
        if j >= 24:
            j -= 24
        value = int(weights[j]) - _BIAS
        if value > 0:
            hard = hard | (1 << cell)
        elif value == 0:
            telling = telling ^ (1 << cell)
        else:
            value = 0 - value
        value = (value << 5) | cell
        i = place
        row = int(rows[i - 1])
        while row < value:
            rows[i] = row
            i -= 1
            row = int(rows[i - 1])
        rows[i] = value
        place += 1
    # what the 16 patterns of each 4 cells cost to contradict: items 50 .. 145
    j = shift
    slot = 50
    while slot < 146:
        i = slot
        size = slot + 16
        while slot < size:  # of one cell each, for the time being
            value = int(weights[j]) - _BIAS
            if value < 0:
                value = 0 - value
            rows[slot] = value
            slot += 4
            j += 1
            if j >= 24:
                j -= 24
        one = int(rows[i])
        value = int(rows[i + 4])
        cell = int(rows[i + 8])
        rows[i] = 0
        rows[i + 1] = one
        rows[i + 2] = value
        rows[i + 3] = one + value
        rows[i + 4] = cell
        rows[i + 5] = cell + one
        rows[i + 6] = cell + value
        rows[i + 7] = cell + one + value
        one += int(rows[i + 12])
        i += 8
        rows[i] = int(rows[i + 4])
        rows[i + 1] = one
        rows[i + 2] = int(rows[i]) + value
        rows[i + 3] = one + value
        value += cell
        rows[i + 4] = int(rows[i]) + cell
        rows[i + 5] = one + cell
        rows[i + 6] = int(rows[i]) + value
        rows[i + 7] = one + value
    # and those of the coding lines: items 172 .. 179
    rows[172] = 0
    cell = 0
    size = 1
    while size < 8:
        value = int(lines[cell]) - _BIAS
        cell += 1
        i = 172
        while i < 172 + size:
            rows[i + size] = int(rows[i])
            if value > 0:
                rows[i] = int(rows[i]) + value
            else:
                rows[i + size] = int(rows[i]) - value
            i += 1
        size += size
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
        bit = 1 << cell
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
            i = 0
            while i < 12:
                value = int(rows[i])
                if value & bit:
                    rows[i] = value ^ row
                    rows[13 + i] = int(rows[13 + i]) ^ row_id
                i += 1
            rows[rank] = row
            rows[13 + rank] = row_id
            rank += 1
        else:
            rows[134 + place - rank] = int(rows[place]) >> 5
        place += 1
    while place < 50:
        rows[134 + place - rank] = int(rows[place]) >> 5
        place += 1
    rows[38] = 0
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
        j = 12
        apart = 0
        if k < 12:
            first = k + 1
            j = 11
            apart = int(rows[26 + k]) >> 5
        end = j
        while j >= first:
            one = apart + (int(rows[26 + j]) >> 5)
            near = base ^ int(rows[j])
            near_id = base_id ^ int(rows[13 + j])
            i = end
            last = j
            if j == 12:
                last = 11
            if one >= second:
                j = 0 - 1
                i = last
            while i > last:
                row_id = 1
                if one + (int(rows[26 + i]) >> 5) >= second:
                    i = last  # and so is whatever follows
                else:
                    row_id = near_id ^ int(rows[13 + i])
                row = near ^ int(rows[i])
                # IDs below 8 have no cells of their own, but the empty word stands for them
                if (row_id & 7 and row_id > 7 and row_id != 4095) or row_id == 0:
                    examined += 1
                    value = int(rows[50 + (row & 15)]) + int(rows[66 + ((row >> 4) & 15)])
                    value += int(rows[82 + ((row >> 8) & 15)])
                    if value < second:  # most words cost that much in half of the cells
                        value += int(rows[98 + ((row >> 12) & 15)])
                        value += int(rows[114 + ((row >> 16) & 15)]) + int(rows[130 + (row >> 20)])
                        if row_id:
                            value += int(rows[172 + (row_id & 7)])
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
                i -= 1
            j -= 1
        contradicted = 0
        row = best_word & telling
        while row:
            row = row & (row - 1)
            contradicted += 1
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
    return second_id
