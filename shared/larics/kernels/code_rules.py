"""Rules on what was measured where the coding lines may be: what must be empty, and the three bits.

A bit is told only where nothing else explains what is seen: a mirrored lamp bleaches a line, and its edge, a
shadow's, a cable or a stain may pass for one. Rules as in kernels.rules; the limits were measured on rendered
frames of all presets and on path-traced ones.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_FIT_RADIUS_Q8 = const(6)
_FIT_AREA = const(14)
_POSITION_NEAR = const(0)
_POSITION_FAR = const(1)
_POSITION_NEAR_MEAN = const(2)
_POSITION_FAR_MEAN = const(3)
_POSITION_LEVEL = const(4)
_POSITION_ROUGH = const(5)
_POSITION_ITEMS = const(6)
_LIGHT_LEVEL = const(0)
_LIGHT_THIRD = const(1)
_LIGHT_GUARD = const(2)
_LIGHT_STRAY = const(3)
_LIGHT_STRAY_HALF = const(4)
_LIGHT_ROUGH = const(5)

# areas: 256 = as the rings'; a limit's own doubt, the distance from it that leaves none, follows it
_GUARD_MOST = const(70)  # where no bit is
_GUARD_DOUBT = const(50)
_ONE_LEAST = const(125)
_ONE_DOUBT = const(80)
_ONE_MOST = const(560)  # a line is not twice as dark as the rings,
_PALER_MOST = const(110)  # and its place no lighter than what surrounds it
_ZERO_MOST = const(85)
_ZERO_DOUBT = const(50)
_SMALL_Q8 = const(4096)  # in rings smaller than this, the limits of a bit are farther apart
_SMALL_DOUBT = const(25)
# light on a position, log units of grey: what a mirrored lamp adds to a line makes it shallow or hides it
_FADED = const(60)  # twice the depth at which a 0 may be a bleached line; twice the stray depth is added,
_FADED_MOST = const(120)  # up to this; where it is brighter than the mean, by so much less;
_FADED_LEAST = const(20)  # but never below this;
_CALM = const(64)  # a smooth 0 that is not bright is a stain, where no position strays more
_HALF_FADED = const(30)  # likewise of the deeper half, and twice what their halves stray
_ROUGH_MOST = const(120)  # mean square of what lies on a 0, 7168 = as deep as a line, and so many times what
_ROUGH_NOISE = const(3)  # lies where no bit is: something crosses it, and hides a line as well;
_ROUGHEST = const(400)  # where it is lighter than its sides, what lies beside it is rough, up to this
_GLARE_MOST = const(130)  # a position that much brighter than the mean may have lost its line,
_SPOT_MOST = const(50)  # or that much brighter than the third brightest, if it is as bright as this:
_SPOT_BRIGHT = const(980)
_BUMP_MOST = const(45)  # or so much brighter than both places beside it: a patch of white, or of light;
_BUMP_GLARE = const(100)  # a position brighter than the mean by this
_BUMP_LESS = const(25)  # if it is so much brighter than those
_HIGH = const(900)  # where tone curves flatten what the light leaves of a line
_BRIGHT = const(25)  # a 0 there that is so much brighter than the mean, if not quite empty,
_BRIGHT_DEPTH = const(5)
_BLEACHED = const(1020)  # where little of a line would be left, such a 0 is none,
_CLIPPED = const(1036)  # else, or on clipped white, it needs
_PALE_Q8 = const(160)  # a ring beside it that has this share of the rings' mean area;
_CLIPPED_DISTANCE = const(18)  # and on clipped white its margin is no more than this leaves
_PALE_ONE_Q8 = const(148)  # a 1 has this share of the deepest one's depth: a scratch is thinner than a line;
_PALE_GLARE = const(15)  # unless light on it makes it shallower,
_UNEVEN = const(100)  # or what must be empty strays no more
# edges, cables that cross and stains may pass for a line, or undo one
_LEAST = const(24)  # area of any 1 below the darker side,
_EVEN = const(75)  # where a half of what must be empty strays more,
_EDGE_GLARE = const(15)  # or it has none and is so much brighter than the mean: the edge of a reflection
_HALF_LEAST = const(60)  # where that of a half is less, each half's below the mean of the sides;
_HALVES_Q4 = const(7)  # the shallower half of a 1 has this share of the deeper one's depth,
_SOUND_Q8 = const(200)  # unless the ring beside it has less than this share of the rings' mean area
_STRAY_MOST = const(150)  # and what must be empty strays no more
_WEAK_Q8 = const(66)  # a 0 is believed when the ring beside it has this share of the rings' mean area,
_HIDDEN_DEPTH = const(20)  # or some of it, and the 0 is as empty as this and not bright,
_CROSSED_Q8 = const(160)  # unless across the centre a ring shows no more, as a bar hides both,
_DIM_Q8 = const(185)  # this where it is rough: a bright cable crosses both


@micropython.viper
def code_light(light: ptr32, code: ptr32) -> int:
    """What the eight positions tell of light and noise: LIGHT. code: POSITION for each of eight. Always 1."""
    level = 0
    first = 0
    second = 0
    third = 0
    guard = 0
    stray = 0
    stray_half = 0
    rough = 0
    position = 0
    while position < 8:
        slot = position * _POSITION_ITEMS
        value = int(code[slot + _POSITION_LEVEL])
        level += value
        if value > first:
            third = second
            second = first
            first = value
        elif value > second:
            third = second
            second = value
        elif value > third:
            third = value
        if position == 0 or position & 1:
            area = int(code[slot + _POSITION_NEAR]) + int(code[slot + _POSITION_FAR])
            if area > guard:
                guard = area
        if position & 1:
            near = int(code[slot + _POSITION_NEAR_MEAN]) - _BIAS
            far = int(code[slot + _POSITION_FAR_MEAN]) - _BIAS
            value = near + far
            if value < 0:
                value = 0 - value
            if value > stray:
                stray = value
            if near < 0:
                near = 0 - near
            if far < 0:
                far = 0 - far
            if near > stray_half:
                stray_half = near
            if far > stray_half:
                stray_half = far
        if position == 0 or position & 1:
            value = int(code[slot + _POSITION_ROUGH])
            below = 0
            equal = 0
            other = 0
            while other < 8:
                if other == 0 or other & 1:
                    near = int(code[other * _POSITION_ITEMS + _POSITION_ROUGH])
                    if near < value:
                        below += 1
                    elif near == value:
                        equal += 1
                other += 1
            if below <= 2 and below + equal > 2:
                rough = value
        position += 1
    light[_LIGHT_LEVEL] = level >> 3
    light[_LIGHT_THIRD] = third
    light[_LIGHT_GUARD] = guard
    light[_LIGHT_STRAY] = stray
    light[_LIGHT_STRAY_HALF] = stray_half
    light[_LIGHT_ROUGH] = rough
    return 1


@micropython.viper
def code_rules(rules: ptr32, code: ptr32, light: ptr32, fit: ptr32, inner_means: ptr32, angle: int) -> int:
    """Writes four rules, on what must be empty and on the three bits, and returns the ID.

    code: POSITION for each of eight; light: LIGHT; fit: FIT; inner_means: `ring_harmonics` of the inner ring;
    angle: of the orientation line, 0..65535 of a turn. A bit in doubt is left out of the ID and added eight
    times as high instead, so that 8 and more is no ID; its rule is kept by far."""
    level = int(light[_LIGHT_LEVEL])
    faded = _FADED + int(light[_LIGHT_STRAY])
    if faded > _FADED_MOST:
        faded = _FADED_MOST
    half_faded = _HALF_FADED + int(light[_LIGHT_STRAY_HALF]) * 2
    rules[0] = _GUARD_MOST - (int(light[_LIGHT_GUARD]) >> 1) + _BIAS
    rules[1] = _GUARD_DOUBT
    one_least = _ONE_LEAST
    zero_most = _ZERO_MOST
    if int(fit[_FIT_RADIUS_Q8]) < _SMALL_Q8:
        one_least += _SMALL_DOUBT
        zero_most -= _SMALL_DOUBT
    rough_most = _ROUGH_MOST + int(light[_LIGHT_ROUGH]) * _ROUGH_NOISE
    pale = 0
    slot = 2 * _POSITION_ITEMS
    while slot < 8 * _POSITION_ITEMS:
        depth = (
            int(code[slot + _POSITION_NEAR_MEAN]) + int(code[slot + _POSITION_FAR_MEAN]) - 2 * _BIAS
        ) >> 1
        if depth > pale:
            pale = depth
        slot += 2 * _POSITION_ITEMS
    if pale > _ONE_MOST:
        pale = _ONE_MOST
    pale = (pale * _PALE_ONE_Q8) >> 8
    marker_id = 0
    bit = 1
    while bit < 4:
        slot = bit * 2 * _POSITION_ITEMS
        rule = bit + bit
        near = int(code[slot + _POSITION_NEAR_MEAN]) - _BIAS
        half = int(code[slot + _POSITION_FAR_MEAN]) - _BIAS
        depth = (near + half) >> 1
        if near > half:
            half = near
        bright = int(code[slot + _POSITION_LEVEL])
        bump = bright - int(code[slot - _POSITION_ITEMS + _POSITION_LEVEL])
        glare = bright - int(code[slot + _POSITION_ITEMS + _POSITION_LEVEL])
        if glare < bump:
            bump = glare
        glare = bright - level
        if glare < 0:
            glare = 0
        own_zero_most = zero_most - (glare >> 1)  # light that is added to a line makes it shallower
        marker_id = marker_id + marker_id
        in_doubt = 0
        rules[rule] = _BIAS + 65536
        rules[rule + 1] = 1
        if depth > _ONE_MOST or depth < 0 - _PALER_MOST:
            rules[0] = _BIAS - 50
        if depth >= one_least:
            marker_id += 1
            near = int(code[slot + _POSITION_NEAR])
            far = int(code[slot + _POSITION_FAR])
            signs = 0
            if depth < pale and glare < _PALE_GLARE:
                signs = 1
                if int(light[_LIGHT_STRAY]) > _UNEVEN or near + far < _HALF_LEAST:
                    signs = 2
            if near + far < _LEAST:
                signs += 1
                if int(light[_LIGHT_STRAY_HALF]) > _EVEN or (near + far == 0 and glare > _EDGE_GLARE):
                    signs = 2
            if near < _LEAST or far < _LEAST:
                if depth + depth - half < _HALF_LEAST or int(light[_LIGHT_STRAY]) > _STRAY_MOST:
                    signs = 2
            if ((depth + depth - half) << 4) < half * _HALVES_Q4 and glare < _PALE_GLARE:
                # half a line fades beside a ring that fades, or in light; else it is a stain
                weak = (int(fit[_FIT_AREA]) * _SOUND_Q8) >> 8
                hidden = 0
                sector = (((angle - bit * 16384) >> 12) & 15) + 15
                last = sector + 2
                while sector <= last:
                    value = int(inner_means[16 + (sector & 15)])
                    if value > 0 and value < weak:
                        hidden = 1
                    sector += 1
                if hidden == 0:
                    signs = 2
            if signs > 1:
                in_doubt = 1
            else:
                rules[rule] = depth - one_least + _BIAS
                rules[rule + 1] = _ONE_DOUBT
        elif depth > own_zero_most or glare > _GLARE_MOST or bump > _BUMP_MOST:
            in_doubt = 1
        elif bright > _SPOT_BRIGHT and bright - int(light[_LIGHT_THIRD]) > _SPOT_MOST:
            in_doubt = 1
        elif bright > _BLEACHED and glare > _BRIGHT and depth > _BRIGHT_DEPTH:
            in_doubt = 1
        elif half > half_faded or int(code[slot + _POSITION_ROUGH]) > _ROUGHEST:
            in_doubt = 1
        elif (
            depth * 2 > _FADED_LEAST
            and depth * 2 > faded - glare
            and (bright > _HIGH or int(light[_LIGHT_STRAY]) > _CALM)
        ):
            in_doubt = 1
        else:
            # of what need not mean anything, two signs do
            signs = 0
            if bump > _BUMP_LESS:
                signs = 1
                if glare > _BUMP_GLARE:
                    signs = 2
            # a line may be hidden by glare, shadow or dirt when the inner ring beside it is, too
            weak = _WEAK_Q8
            if bright >= _CLIPPED or (bright > _HIGH and glare > _BRIGHT and depth > _BRIGHT_DEPTH):
                weak = _PALE_Q8
            if int(code[slot + _POSITION_ROUGH]) > rough_most:
                signs += 1
                weak = _DIM_Q8
                if depth > 0:
                    signs = 2
            weak = (int(fit[_FIT_AREA]) * weak) >> 8
            crossed = (int(fit[_FIT_AREA]) * _CROSSED_Q8) >> 8
            hidden = 0
            opposite = 0
            sector = (((angle - bit * 16384) >> 12) & 15) + 15
            last = sector + 2
            while sector <= last:
                if int(inner_means[16 + (sector & 15)]) <= weak:
                    hidden += 1
                # across the centre; 0 where a line was expected
                value = int(inner_means[16 + ((sector + 8) & 15)])
                if value > 0 and value <= crossed:
                    opposite = 1
                sector += 1
            if hidden:
                signs += 1
                if hidden > 2 or bright > _HIGH or depth > _HIDDEN_DEPTH:
                    signs = 2
                if opposite or int(light[_LIGHT_STRAY]) > _UNEVEN:
                    signs = 2
            if signs > 1:
                in_doubt = 1
            else:
                distance = own_zero_most - depth
                if bright >= _CLIPPED and distance > _CLIPPED_DISTANCE:
                    distance = _CLIPPED_DISTANCE
                rules[rule] = distance + _BIAS
                rules[rule + 1] = _ZERO_DOUBT
        if in_doubt:
            marker_id = (marker_id & 65534) + 8
        bit += 1
    return marker_id
