"""Rules on rings and orientation line: each is a distance from a limit, the weakest makes the margin.

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

# rings; a limit's own doubt, the distance from it that leaves none, follows it
_INSIDE_LEAST_OUTER = const(20)  # half sectors of 32 with crossings, or that a line covers
_INSIDE_LEAST_INNER = const(24)
_BULGE_PARTS = const(2)  # the second harmonic, 1/1024 px, is below the radius, 1/256 px, over this
_USED_LEAST = const(36)  # of 64: of the sectors with crossings, those that agree
_USED_DOUBT = const(20)
_RATIO_FIRST = const(36)  # of the radii, off the family's, 1/1024; markers showed up to 21 at first
_RATIO_MOST = const(16)  # later,
_RATIO_SMALL = const(76800)  # and this over the radius: with few pixels, a ring and a line deviate more
_RATIO_DOUBT = const(20)
_WEAKER_TENTHS = const(6)  # of the stronger ring's area, that of the weaker one
_WEAKER_DOUBT_TENTHS = const(3)
_DEVIATION_MOST = const(320)  # of both rings together, 1/1024 px, and 1/32 of the radius's 1/256 px
# orientation line
_SECOND_MOST = const(250)  # another direction that may be a line, 256 = as dark
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
    rules: ptr32, fit: ptr32, outer: ptr32, inner: ptr32, skipped_outer: int, skipped_inner: int,
    covered_least: int, covered_doubt: int,
) -> int:  # fmt: skip
    """Writes the six rules on the fitted rings; returns their number, 0 for rings that no rule need see.

    fit: FIT, radius at least 6 px; outer, inner: RING; skipped_*: half sectors that a line covers;
    covered_*: limit and doubt of the sectors of both rings that agree, of 128."""
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
    rules[4] = used_outer + used_inner - covered_least + _BIAS
    rules[5] = covered_doubt
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

    line: CROSSING; second: area of another direction that may be a line, 256 = as the line's; radius:
    1/256 px; end: `line_end`."""
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
