"""Rules on what was measured of a candidate: each is a distance from a limit, the weakest makes the margin.

A rule is a pair of items of `rules`: the distance from the limit, + BIAS, below BIAS when it is broken; and
the distance that leaves no doubt (> 0), which counts as 255.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr32

BIAS = const(1 << 24)

_RADIUS_Q8 = const(6)  # items as in kernels.rings: FIT,
_INNER_Q8 = const(7)
_BULGE_COS = const(8)
_BULGE_SIN = const(9)
_AREA = const(14)
_INNER_Q10 = const(16)
_DEVIATION = const(5)  # and of a ring's harmonics
_USED = const(6)
_INSIDE = const(7)
_MEAN_AREA = const(8)

_LINE_DEVIATION = const(6)  # items of kernels.lines.line_crossings
_LINE_AREA = const(7)
_LINE_GAP = const(8)
_LINE_SLOPE = const(5)
_LINE_SLOPE_MOST = const(9)

_COVERED_LEAST = const(94)  # of 128: sectors of both rings that agree; half hidden rings are look-alikes
_RATIO_FIRST = const(36)  # of the radii, off the family's, 1/1024; markers showed up to 21 at first
_END_MOST = const(140)  # 256 = as dark as the line
_LINE_MOST = const(520)  # areas: 256 = as the rings'
_GUARD_MOST = const(70)
_ONE_LEAST = const(125)
_ONE_MOST = const(560)  # a line is not twice as dark as the rings,
_LIGHT_MOST = const(110)  # and its place no lighter than what surrounds it
_ZERO_MOST = const(85)
_SMALL_Q8 = const(4096)  # in rings smaller than this, the limits of a bit are farther apart
_SMALL_DOUBT = const(25)
_GLARE = const(90)  # log units: a position that much brighter than the mean may have lost its line
_WEAK_Q8 = const(66)  # a 0 is believed when the ring beside it has this share of the rings' mean area


@micropython.viper
def weakest_rule(rules: ptr32, i: int, margin: int, count: int) -> int:
    """The smallest of `margin` (0..255) and those of `count` rules; -1 when one is broken."""
    i = count + count
    while i > 0:
        i -= 2
        distance = int(rules[i]) - BIAS
        if distance < 0:
            return 0 - 1
        if distance < 65536:
            distance = distance * 255 // int(rules[i + 1])
            if distance < margin:
                margin = distance
    return margin


@micropython.viper
def rings_plausible(
    fit: ptr32, weaker: int, stronger: int, outer: ptr32, inner: ptr32, deviation: int
) -> int:
    """Whether rings are worth another look after their first passes: 1 or 0.

    deviation: of both rings together, above the share that grows with the radius, at which they are not; the
    other arguments as in `rings_rules`."""
    weaker = int(outer[_MEAN_AREA])
    stronger = int(inner[_MEAN_AREA])
    if stronger < weaker:
        weaker = stronger
        stronger = int(outer[_MEAN_AREA])
    if weaker * 5 <= stronger * 3:
        return 0
    radius = int(fit[_RADIUS_Q8])
    off = (int(fit[_INNER_Q8]) << 10) // radius - int(fit[_INNER_Q10])
    if off >= _RATIO_FIRST or off <= 0 - _RATIO_FIRST:
        return 0
    if int(outer[_DEVIATION]) + int(inner[_DEVIATION]) >= (radius >> 5) + deviation:
        return 0
    return 1


@micropython.viper
def rings_rules(
    rules: ptr32, i: int, value: int, fit: ptr32, outer: ptr32, inner: ptr32, skipped_outer: int,
    skipped_inner: int,
) -> int:  # fmt: skip
    """Writes the six rules on the fitted rings; returns their number, 0 for rings that no rule need see.

    fit: kernels.rings: FIT, radius at least 6 px; outer, inner: `ring_harmonics` of each ring; skipped_*:
    half sectors that a line covers."""
    if int(outer[_INSIDE]) * 2 + skipped_outer < 20 or int(inner[_INSIDE]) * 2 + skipped_inner < 24:
        return 0
    radius = int(fit[_RADIUS_Q8])
    value = int(fit[_BULGE_COS]) - BIAS
    i = int(fit[_BULGE_SIN]) - BIAS
    if value + value >= radius or i + i >= radius or value + value <= 0 - radius or i + i <= 0 - radius:
        return 0
    value = int(outer[_USED]) * 64 // int(outer[_INSIDE])
    i = int(inner[_USED]) * 64 // int(inner[_INSIDE])
    rules[0] = value - 36 + BIAS
    rules[1] = 20
    rules[2] = i - 36 + BIAS
    rules[3] = 20
    rules[4] = value + i - _COVERED_LEAST + BIAS
    rules[5] = 30
    value = (int(fit[_INNER_Q8]) << 10) // radius - int(fit[_INNER_Q10])
    if value < 0:
        value = 0 - value
    # with few pixels a ring and a line deviate more than in proportion
    rules[6] = 16 + 76800 // radius - value + BIAS
    rules[7] = 20
    value = int(outer[_MEAN_AREA])
    i = int(inner[_MEAN_AREA])
    if i < value:
        value = i
        i = int(outer[_MEAN_AREA])
    rules[8] = value * 10 - i * 6 + BIAS
    rules[9] = i * 3
    value = (radius >> 5) + 320
    rules[10] = value - int(outer[_DEVIATION]) - int(inner[_DEVIATION]) + BIAS
    rules[11] = value >> 1
    return 6


@micropython.viper
def line_rules(rules: ptr32, line: ptr32, second: int, radius: int, end: int) -> int:
    """Writes the seven rules on the orientation line; returns their number.

    line: result of `line_crossings`; second: depth of the second darkest direction, 256 = as deep; radius:
    1/256 px; end: `line_end`."""
    rules[0] = 250 - second + BIAS
    rules[1] = 150
    rules[2] = int(line[_LINE_AREA]) - 96 + BIAS
    rules[3] = 110
    rules[4] = _LINE_MOST - int(line[_LINE_AREA]) + BIAS
    rules[5] = 120
    rules[6] = (radius >> 6) + 200 - int(line[_LINE_DEVIATION]) + BIAS
    rules[7] = 150
    rules[8] = 90 - int(line[_LINE_GAP]) + BIAS
    rules[9] = 80
    rules[10] = int(line[_LINE_SLOPE_MOST]) - int(line[_LINE_SLOPE]) + BIAS
    rules[11] = int(line[_LINE_SLOPE_MOST])
    # a cable or an edge that takes a line's place does not end where the line ends
    rules[12] = _END_MOST - end + BIAS
    rules[13] = 80
    return 7


@micropython.viper
def code_rules(
    rules: ptr32, i: int, value: int, code: ptr32, fit: ptr32, inner_means: ptr32, angle: int
) -> int:
    """Writes four rules, on what must be empty and on the three bits, and returns the ID.

    code: `code_positions`; inner_means: `ring_harmonics` of the inner ring; angle: of the orientation line,
    0..65535 of a turn. Returns 8 when a bit is in doubt; its rule is then kept by far."""
    guard = 0
    level = 0
    i = 0
    while i < 40:
        level += int(code[i + 4])
        value = int(code[i]) + int(code[i + 1])
        if (i == 0 or i & 1) and value > guard:
            guard = value
        i += 5
    level = level >> 3
    rules[0] = _GUARD_MOST - (guard >> 1) + BIAS
    rules[1] = 50
    one_least = _ONE_LEAST
    zero_most = _ZERO_MOST
    if int(fit[_RADIUS_Q8]) < _SMALL_Q8:
        one_least += _SMALL_DOUBT
        zero_most -= _SMALL_DOUBT
    weak = (int(fit[_AREA]) * _WEAK_Q8) >> 8
    marker_id = 0
    doubt = 0
    bit = 1
    while bit < 4:
        i = bit * 10
        depth = (int(code[i + 2]) + int(code[i + 3]) - (BIAS + BIAS)) >> 1
        glare = int(code[i + 4]) - level
        if glare < 0:
            glare = 0
        value = zero_most - (glare >> 1)  # light that is added to a line makes it shallower
        marker_id = marker_id + marker_id
        i = bit + bit
        bit += 1
        rules[i] = BIAS + 65536
        rules[i + 1] = 1
        if depth > _ONE_MOST or depth < 0 - _LIGHT_MOST:
            rules[0] = BIAS - 50
        if depth >= one_least:
            marker_id += 1
            rules[i] = depth - one_least + BIAS
            rules[i + 1] = 80
        elif depth > value or glare > _GLARE:
            doubt = 1
        else:
            # a line may be hidden by glare, shadow or dirt when the inner ring beside it is, too
            value = value - depth
            depth = (((angle - i * 8192) >> 12) & 15) + 15
            glare = depth + 3
            while depth < glare:
                if int(inner_means[16 + (depth & 15)]) <= weak:
                    doubt = 1
                    glare = 0
                depth += 1
            if glare > 0:
                rules[i] = value + BIAS
                rules[i + 1] = 50
    if doubt:
        return 8
    return marker_id
