"""Rules on what was measured of a candidate: each is a distance from a limit, the weakest makes the margin.

A rule is a pair of items of `rules`: the distance from the limit, + BIAS, below BIAS when it is broken; and
the distance that leaves no doubt (> 0), which counts as 255.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_FIT_RADIUS_Q8 = const(6)
_FIT_INNER_Q8 = const(7)
_FIT_BULGE_COS = const(8)
_FIT_BULGE_SIN = const(9)
_FIT_AREA = const(14)
_FIT_INNER_Q10 = const(16)
_RING_DEVIATION = const(5)
_RING_USED = const(6)
_RING_INSIDE = const(7)
_RING_MEAN_AREA = const(8)
_CROSSING_SLOPE = const(5)
_CROSSING_DISTANCE = const(6)
_CROSSING_AREA = const(7)
_CROSSING_GAP = const(8)
_CROSSING_SLOPE_MOST = const(9)
_POSITION_NEAR = const(0)
_POSITION_FAR = const(1)
_POSITION_NEAR_MEAN = const(2)
_POSITION_FAR_MEAN = const(3)
_POSITION_LEVEL = const(4)
_POSITION_ITEMS = const(5)

# rings; a limit's own doubt, the distance from it that leaves none, follows it
_INSIDE_LEAST_OUTER = const(20)  # half sectors of 32 with crossings, or that a line covers
_INSIDE_LEAST_INNER = const(24)
_BULGE_PARTS = const(2)  # the second harmonic, 1/1024 px, is below the radius, 1/256 px, over this
_USED_LEAST = const(36)  # of 64: of the sectors with crossings, those that agree
_USED_DOUBT = const(20)
_COVERED_LEAST = const(94)  # of 128: sectors of both rings that agree; half hidden rings are look-alikes
_COVERED_DOUBT = const(30)
_RATIO_FIRST = const(36)  # of the radii, off the family's, 1/1024; markers showed up to 21 at first
_RATIO_MOST = const(16)  # later,
_RATIO_SMALL = const(76800)  # and this over the radius: with few pixels, a ring and a line deviate more
_RATIO_DOUBT = const(20)
_WEAKER_TENTHS = const(6)  # of the stronger ring's area, that of the weaker one
_WEAKER_DOUBT_TENTHS = const(3)
_DEVIATION_MOST = const(320)  # of both rings together, 1/1024 px, and 1/32 of the radius's 1/256 px
# orientation line
_SECOND_MOST = const(250)  # the second darkest direction, 256 = as dark
_SECOND_DOUBT = const(150)
_LINE_LEAST = const(96)  # areas: 256 = as the rings'
_LINE_LEAST_DOUBT = const(110)
_LINE_MOST = const(520)
_LINE_MOST_DOUBT = const(120)
_DISTANCE_MOST = const(200)  # of centroids from the line, 1/1024 px, and 1/64 of the radius's 1/256 px
_DISTANCE_DOUBT = const(150)
_GAP_MOST = const(90)  # share of the line that is missing, 256 = all
_GAP_DOUBT = const(80)
_END_MOST = const(140)  # beyond the line's end, 256 = as dark as the line
_END_DOUBT = const(80)
# code, areas as above
_GUARD_MOST = const(70)  # where no bit is
_GUARD_DOUBT = const(50)
_ONE_LEAST = const(125)
_ONE_DOUBT = const(80)
_ONE_MOST = const(560)  # a line is not twice as dark as the rings,
_LIGHT_MOST = const(110)  # and its place no lighter than what surrounds it
_ZERO_MOST = const(85)
_ZERO_DOUBT = const(50)
_SMALL_Q8 = const(4096)  # in rings smaller than this, the limits of a bit are farther apart
_SMALL_DOUBT = const(25)
_GLARE_MOST = const(90)  # log units: a position that much brighter than the mean may have lost its line
_WEAK_Q8 = const(66)  # a 0 is believed when the ring beside it has this share of the rings' mean area


@micropython.viper
def weakest_rule(rules: ptr32, margin: int, count: int) -> int:
    """The smallest of `margin` (0..255) and those of `count` rules; -1 when one is broken."""
    i = count + count
    while i > 0:
        i -= 2
        distance = int(rules[i]) - _BIAS
        if distance < 0:
            return 0 - 1
        if distance < 65536:
            own = distance * 255 // int(rules[i + 1])
            if own < margin:
                margin = own
    return margin


@micropython.viper
def rings_plausible(fit: ptr32, outer: ptr32, inner: ptr32, deviation: int) -> int:
    """Whether rings are worth another look after their first passes: 1 or 0.

    deviation: of both rings together, above the share that grows with the radius, at which they are not; the
    other arguments as in `rings_rules`."""
    weaker = int(outer[_RING_MEAN_AREA])
    stronger = int(inner[_RING_MEAN_AREA])
    if stronger < weaker:
        weaker = stronger
        stronger = int(outer[_RING_MEAN_AREA])
    if weaker * 10 <= stronger * _WEAKER_TENTHS:
        return 0
    radius = int(fit[_FIT_RADIUS_Q8])
    off = (int(fit[_FIT_INNER_Q8]) << 10) // radius - int(fit[_FIT_INNER_Q10])
    if off >= _RATIO_FIRST or off <= 0 - _RATIO_FIRST:
        return 0
    if int(outer[_RING_DEVIATION]) + int(inner[_RING_DEVIATION]) >= (radius >> 5) + deviation:
        return 0
    return 1


@micropython.viper
def rings_rules(
    rules: ptr32, fit: ptr32, outer: ptr32, inner: ptr32, skipped_outer: int, skipped_inner: int
) -> int:  # fmt: skip
    """Writes the six rules on the fitted rings; returns their number, 0 for rings that no rule need see.

    fit: FIT, radius at least 6 px; outer, inner: RING; skipped_*: half sectors that a line covers."""
    inside_outer = int(outer[_RING_INSIDE])
    inside_inner = int(inner[_RING_INSIDE])
    if inside_outer * 2 + skipped_outer < _INSIDE_LEAST_OUTER:
        return 0
    if inside_inner * 2 + skipped_inner < _INSIDE_LEAST_INNER:
        return 0
    radius = int(fit[_FIT_RADIUS_Q8])
    bulge = (int(fit[_FIT_BULGE_COS]) - _BIAS) * _BULGE_PARTS
    if bulge >= radius or bulge <= 0 - radius:
        return 0
    bulge = (int(fit[_FIT_BULGE_SIN]) - _BIAS) * _BULGE_PARTS
    if bulge >= radius or bulge <= 0 - radius:
        return 0
    used_outer = int(outer[_RING_USED]) * 64 // inside_outer
    used_inner = int(inner[_RING_USED]) * 64 // inside_inner
    rules[0] = used_outer - _USED_LEAST + _BIAS
    rules[1] = _USED_DOUBT
    rules[2] = used_inner - _USED_LEAST + _BIAS
    rules[3] = _USED_DOUBT
    rules[4] = used_outer + used_inner - _COVERED_LEAST + _BIAS
    rules[5] = _COVERED_DOUBT
    off = (int(fit[_FIT_INNER_Q8]) << 10) // radius - int(fit[_FIT_INNER_Q10])
    if off < 0:
        off = 0 - off
    rules[6] = _RATIO_MOST + _RATIO_SMALL // radius - off + _BIAS
    rules[7] = _RATIO_DOUBT
    weaker = int(outer[_RING_MEAN_AREA])
    stronger = int(inner[_RING_MEAN_AREA])
    if stronger < weaker:
        weaker = stronger
        stronger = int(outer[_RING_MEAN_AREA])
    rules[8] = weaker * 10 - stronger * _WEAKER_TENTHS + _BIAS
    rules[9] = stronger * _WEAKER_DOUBT_TENTHS
    most = (radius >> 5) + _DEVIATION_MOST
    rules[10] = most - int(outer[_RING_DEVIATION]) - int(inner[_RING_DEVIATION]) + _BIAS
    rules[11] = most >> 1
    return 6


@micropython.viper
def line_rules(rules: ptr32, line: ptr32, second: int, radius: int, end: int) -> int:
    """Writes the seven rules on the orientation line; returns their number.

    line: CROSSING; second: depth of the second darkest direction, 256 = as deep; radius: 1/256 px; end:
    `line_end`."""
    rules[0] = _SECOND_MOST - second + _BIAS
    rules[1] = _SECOND_DOUBT
    rules[2] = int(line[_CROSSING_AREA]) - _LINE_LEAST + _BIAS
    rules[3] = _LINE_LEAST_DOUBT
    rules[4] = _LINE_MOST - int(line[_CROSSING_AREA]) + _BIAS
    rules[5] = _LINE_MOST_DOUBT
    rules[6] = (radius >> 6) + _DISTANCE_MOST - int(line[_CROSSING_DISTANCE]) + _BIAS
    rules[7] = _DISTANCE_DOUBT
    rules[8] = _GAP_MOST - int(line[_CROSSING_GAP]) + _BIAS
    rules[9] = _GAP_DOUBT
    rules[10] = int(line[_CROSSING_SLOPE_MOST]) - int(line[_CROSSING_SLOPE]) + _BIAS
    rules[11] = int(line[_CROSSING_SLOPE_MOST])
    # a cable or an edge that takes a line's place does not end where the line ends
    rules[12] = _END_MOST - end + _BIAS
    rules[13] = _END_DOUBT
    return 7


@micropython.viper
def code_rules(rules: ptr32, code: ptr32, fit: ptr32, inner_means: ptr32, angle: int) -> int:
    """Writes four rules, on what must be empty and on the three bits, and returns the ID.

    code: POSITION for each of eight; fit: FIT; inner_means: `ring_harmonics` of the inner ring; angle: of the
    orientation line, 0..65535 of a turn. Returns 8 when a bit is in doubt; its rule is then kept by far."""
    guard = 0
    level = 0
    position = 0
    while position < 8:
        slot = position * _POSITION_ITEMS
        level += int(code[slot + _POSITION_LEVEL])
        if position == 0 or position & 1:
            area = int(code[slot + _POSITION_NEAR]) + int(code[slot + _POSITION_FAR])
            if area > guard:
                guard = area
        position += 1
    level = level >> 3
    rules[0] = _GUARD_MOST - (guard >> 1) + _BIAS
    rules[1] = _GUARD_DOUBT
    one_least = _ONE_LEAST
    zero_most = _ZERO_MOST
    if int(fit[_FIT_RADIUS_Q8]) < _SMALL_Q8:
        one_least += _SMALL_DOUBT
        zero_most -= _SMALL_DOUBT
    weak = (int(fit[_FIT_AREA]) * _WEAK_Q8) >> 8
    marker_id = 0
    doubt = 0
    bit = 1
    while bit < 4:
        slot = bit * 2 * _POSITION_ITEMS
        rule = bit + bit
        depth = (int(code[slot + _POSITION_NEAR_MEAN]) + int(code[slot + _POSITION_FAR_MEAN])) >> 1
        depth -= _BIAS
        glare = int(code[slot + _POSITION_LEVEL]) - level
        if glare < 0:
            glare = 0
        own_zero_most = zero_most - (glare >> 1)  # light that is added to a line makes it shallower
        marker_id = marker_id + marker_id
        rules[rule] = _BIAS + 65536
        rules[rule + 1] = 1
        if depth > _ONE_MOST or depth < 0 - _LIGHT_MOST:
            rules[0] = _BIAS - 50
        if depth >= one_least:
            marker_id += 1
            rules[rule] = depth - one_least + _BIAS
            rules[rule + 1] = _ONE_DOUBT
        elif depth > own_zero_most or glare > _GLARE_MOST:
            doubt = 1
        else:
            # a line may be hidden by glare, shadow or dirt when the inner ring beside it is, too
            hidden = 0
            sector = (((angle - bit * 16384) >> 12) & 15) + 15
            last = sector + 2
            while sector <= last:
                if int(inner_means[16 + (sector & 15)]) <= weak:
                    hidden = 1
                sector += 1
            if hidden:
                doubt = 1
            else:
                rules[rule] = own_zero_most - depth + _BIAS
                rules[rule + 1] = _ZERO_DOUBT
        bit += 1
    if doubt:
        return 8
    return marker_id
