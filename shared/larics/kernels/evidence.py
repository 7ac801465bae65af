"""What a candidate's measured quantities say together, where rules on each of them alone are in doubt.

A table that was learnt from frames (tools/learn_evidence.py) holds pairs of comparisons; of each pair, one of
four numbers is added. The sum is the logarithm of how much likelier the one answer is, so that a quantity
counts as much as it did in those frames, and differently beside another one.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr16, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_FIT_RADIUS_Q8 = const(6)
_FIT_AREA = const(14)
_CROSSING_SLOPE = const(5)
_CROSSING_DISTANCE = const(6)
_CROSSING_AREA = const(7)
_CROSSING_GAP = const(8)
_POSITION_NEAR = const(0)
_POSITION_FAR = const(1)
_POSITION_NEAR_MEAN = const(2)
_POSITION_FAR_MEAN = const(3)
_POSITION_LEVEL = const(4)
_POSITION_ROUGH = const(5)
_POSITION_ITEMS = const(6)
_LIGHT_LEVEL = const(0)
_LIGHT_STRAY = const(3)
_LIGHT_STRAY_HALF = const(4)
_LIGHT_ROUGH = const(5)
_RELATIVE_LEAST = const(64)  # share of the rings' area that stands for a ring that is hidden
_OFFSET = const(1 << 12)  # added to what is compared,
_ZERO = const(1 << 15)  # and to what is summed: a table holds no negative numbers
_DEPTH_MOST = const(4095)
_PAIR_ITEMS = const(7)


@micropython.viper
def stroke_depths(
    profile: ptr16, value: int, k: int, directions: int, side: int, unit: int, depths: ptr16
) -> int:
    """How much darker (above _ZERO) or brighter (below) each direction is than what lies beside it.

    profile: as from `directions.annulus_profile`, `directions` items, a power of 2; of both sides, so many
    directions away, the one that differs less counts, and none where it lies between them: an edge is no
    stroke. unit: what makes 256, above 0. Always 1."""
    turn = directions - 1
    k = 0
    while k < directions:
        value = int(profile[k])
        before = int(profile[(k - side) & turn])
        after = int(profile[(k + side) & turn])
        depth = _ZERO
        if value and before and after:
            before -= value
            after -= value
            if before > 0 and after > 0:
                if after < before:
                    before = after
                depth = (before << 8) // unit
                if depth > _DEPTH_MOST:
                    depth = _DEPTH_MOST
                depth += _ZERO
            elif before < 0 and after < 0:
                if after > before:
                    before = after
                depth = ((0 - before) << 8) // unit
                if depth > _DEPTH_MOST:
                    depth = _DEPTH_MOST
                depth = _ZERO - depth
        depths[k] = depth
        k += 1
    return 1


@micropython.viper
def second_strokes(depths: ptr16, k: int, best: int, directions: int, apart: int, result: ptr32) -> int:
    """The second darkest and the second brightest stroke, so many directions from the first: what crosses a
    circle does it twice. depths: as from `stroke_depths`. result: both, above 0. Always 1."""
    turn = directions - 1
    sign = 0
    while sign < 2:
        where = 0
        turns = 0
        while turns < 2:
            best = 0
            place = 0
            k = 0
            while k < directions:
                value = int(depths[k]) - _ZERO
                if sign:
                    value = 0 - value
                if value > best:
                    away = (k - where) & turn
                    if away > directions >> 1:
                        away = directions - away
                    if turns == 0 or away > apart:
                        best = value
                        place = k
                k += 1
            where = place
            turns += 1
        result[sign] = best
        sign += 1
    return 1


@micropython.viper
def bit_items(
    items: ptr32, code: ptr32, light: ptr32, fit: ptr32, inner_means: ptr32, gap: ptr16, inside: ptr16,
    crossing: ptr32, directions: int, angle: int, bit: int,
) -> int:  # fmt: skip
    """What tells whether a coding line lies at a position: 20 items + BIAS. Always 1.

    code: POSITION for each of eight; light: LIGHT; fit: FIT; inner_means: `ring_harmonics` of the inner ring;
    gap, inside: `stroke_depths` between the rings and across the coding lines; crossing: `second_strokes` of
    gap; angle: of the orientation line, clockwise, 0..65535 of a turn; bit: 1..3."""
    slot = bit * 2 * _POSITION_ITEMS
    near = int(code[slot + _POSITION_NEAR_MEAN]) - _BIAS
    far = int(code[slot + _POSITION_FAR_MEAN]) - _BIAS
    depth = (near + far) >> 1
    items[0] = depth + _BIAS
    if far < near:
        value = near
        near = far
        far = value
    items[1] = near + _BIAS
    items[2] = far + _BIAS
    near = int(code[slot + _POSITION_NEAR])
    far = int(code[slot + _POSITION_FAR])
    items[3] = near + far + _BIAS
    if far < near:
        near = far
    items[4] = near + _BIAS
    items[5] = int(code[slot + _POSITION_ROUGH]) + _BIAS
    level = int(code[slot + _POSITION_LEVEL])
    items[6] = level + _BIAS
    items[7] = level - int(light[_LIGHT_LEVEL]) + _BIAS
    # where a coding line would lie across the centre; of orientation and middle bit the orientation's own
    value = ((bit * 2 + 4) & 7) * _POSITION_ITEMS
    items[8] = int(code[value + _POSITION_LEVEL]) - level + _BIAS
    # the deepest of the three
    value = 2 * _POSITION_ITEMS
    level = 0 - _BIAS
    while value < 8 * _POSITION_ITEMS:
        near = (
            int(code[value + _POSITION_NEAR_MEAN]) + int(code[value + _POSITION_FAR_MEAN]) - 2 * _BIAS
        ) >> 1
        if near > level:
            level = near
        value += 2 * _POSITION_ITEMS
    items[9] = level + _BIAS
    # the ring in the two sectors beside, 256 = as the rings' mean, 0 where a line was expected
    angle = (angle - bit * 16384) & 65535
    value = int(fit[_FIT_AREA]) + 1
    near = (int(inner_means[16 + (((angle - 2048) >> 12) & 15)]) << 8) // value
    far = (int(inner_means[16 + (((angle + 2048) >> 12) & 15)]) << 8) // value
    level = (near + far) >> 1
    if near == 0 or far == 0:
        level = near + far
    if level < _RELATIVE_LEAST:
        level = _RELATIVE_LEAST
    if depth > _DEPTH_MOST:
        depth = _DEPTH_MOST
    if depth < 0 - _DEPTH_MOST:
        depth = 0 - _DEPTH_MOST
    items[10] = (depth << 8) // level + _BIAS
    if far < near:
        level = near
        near = far
        far = level
    items[11] = near + _BIAS
    items[12] = far + _BIAS
    items[13] = (value << 4) // (int(fit[_FIT_RADIUS_Q8]) >> 6) + _BIAS
    # strokes beyond it, and across it
    items[14] = int(crossing[0]) + _BIAS
    items[15] = int(crossing[1]) + _BIAS
    slot = 16
    level = directions >> 5  # a thirtysecond of a turn to both sides
    while slot < 20:
        near = 0
        far = 0
        value = ((angle * directions + 32768) >> 16) - level
        depth = value + level + level
        while value <= depth:
            if slot == 16:
                angle_depth = int(gap[value & (directions - 1)]) - _ZERO
            else:
                angle_depth = int(inside[value & (directions - 1)]) - _ZERO
            if angle_depth > near:
                near = angle_depth
            if angle_depth < far:
                far = angle_depth
            value += 1
        items[slot] = near + _BIAS
        items[slot + 1] = _BIAS - far
        slot += 2
    return 1


@micropython.viper
def line_items(
    items: ptr32, line: ptr32, code: ptr32, light: ptr32, fit: ptr32, outer_means: ptr32, inner_means: ptr32,
    angle: int, end: int,
) -> int:  # fmt: skip
    """What tells whether a direction is that of the orientation line: 15 items + BIAS. Always 1.

    line: CROSSING; end: `line_end`; the others as in `bit_items`, for that direction."""
    items[0] = int(line[_CROSSING_AREA]) + _BIAS
    items[1] = int(line[_CROSSING_GAP]) + _BIAS
    items[2] = int(line[_CROSSING_DISTANCE]) + _BIAS
    items[3] = int(line[_CROSSING_SLOPE]) + _BIAS
    items[4] = end + _BIAS
    # the coding lines and what lies opposite the orientation line's end
    first = 0 - _BIAS
    second = first
    slot = 0
    while slot < 8 * _POSITION_ITEMS:
        value = (
            int(code[slot + _POSITION_NEAR_MEAN]) + int(code[slot + _POSITION_FAR_MEAN]) - 2 * _BIAS
        ) >> 1
        if slot == 0:
            items[5] = value + _BIAS
        elif value > first:
            second = first
            first = value
        elif value > second:
            second = value
        slot += 2 * _POSITION_ITEMS
    items[6] = first + _BIAS
    items[7] = second + _BIAS
    items[8] = int(light[_LIGHT_STRAY]) + _BIAS
    items[9] = int(light[_LIGHT_STRAY_HALF]) + _BIAS
    items[10] = int(light[_LIGHT_ROUGH]) + _BIAS
    area = int(fit[_FIT_AREA]) + 1
    sector = 16 + (((angle - 2048) >> 12) & 15)
    value = 16 + (((angle + 2048) >> 12) & 15)
    near = (int(outer_means[sector]) << 8) // area
    far = (int(outer_means[value]) << 8) // area
    if far < near:
        slot = near
        near = far
        far = slot
    items[11] = near + _BIAS
    items[12] = far + _BIAS
    near = (int(inner_means[sector]) << 8) // area
    far = (int(inner_means[value]) << 8) // area
    items[13] = ((near + far) >> 1) + _BIAS
    items[14] = (area << 4) // (int(fit[_FIT_RADIUS_Q8]) >> 6) + _BIAS
    return 1


@micropython.viper
def weigh(items: ptr32, table: ptr16, pairs: int) -> int:
    """The sum that a learnt table gives for `items` (+ BIAS): above 0 for yes, 256 = a factor of e.

    table: of each pair, both items' numbers (the second times 256), what each is compared with, and four
    numbers, + _ZERO: for neither above, the second, the first, both."""
    total = 0
    slot = 0
    while pairs > 0:
        pair = int(table[slot])
        leaf = slot + 3
        if int(items[pair & 255]) - (_BIAS - _OFFSET) > int(table[slot + 1]):
            leaf += 2
        if int(items[pair >> 8]) - (_BIAS - _OFFSET) > int(table[slot + 2]):
            leaf += 1
        total += int(table[leaf]) - _ZERO
        slot += _PAIR_ITEMS
        pairs -= 1
    return total
