"""How far a reading of the blur-model reader may be off: standard deviations of centre and heading.

From how far the sectors lie from the fit. Where there is little noise, that is what the model does not know
of the blur, and does not even out over the rings; what defocus shifts leaves the rings round and does not
show in it at all. Nor does a cable or dirt on the lens, which lets one side of the rings look paler or
darker than the other. The weights were fitted to the errors of rendered frames with motion of 8 and 12 px,
defocus of 3.5 px, rings of 6 to 10 px, contrast of 5 grey levels, tilt of 25 degrees, and of harsh scenes,
webcams, dirty lenses and worn plates.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith import tables
from larics.arith.fixed import isqrt
from larics.blurred.blur_model import SIGMAS

_MOST = const(1 << 20)  # of a variance, (1/1024 px) ** 2: one pixel
_FAR = const(2048)  # deviation that counts at most, 1/1024 px
_CALM = const(32)  # noise of the lines' samples below which none of the deviation is noise,
_NOISY = const(44)  # and at which all of it is, less _CALM
_AT_REST = const(48)  # hundredths of the deviation that do not even out,
_MOVING = const(30)  # and where motion blurs
_SHARP_Q10 = const(1638)  # blur, 1/1024 px, beyond which a 13th of it counts, too: 1.6 px
_DEFOCUS = const(13)
_HEADING = const(7700)  # 0.54 of the deviation at the outer ring: mdeg * radius (1/256 px) for 1/1024 px
_HEADING_LEAST = const(2025)  # mdeg ** 2
_SHARP = const(2)  # entries of SIGMAS below which lines are sharper than the directions are apart:
_SHARP_LEAST = const(40000)  # mdeg ** 2; and the deviation counts twice,
_SHARP_NOISE = const(64)  # unless the noise, stronger than this, hides how blurred they are
_UNEVEN_LEAST = const(20)  # 1024ths of the rings' depth by which noise makes one side paler than the other,
_BACKGROUND_LEAST = const(10)  # and of their background
_TURN = const(14324)  # mdeg * radius (1/256 px) that a shift of 1/1024 px turns a line
_TURNED_MOST = const(16000)  # mdeg


def uneven_square(rings):
    """How far what is not alike all around may shift the centre, (1/1024 px) ** 2."""
    if not rings.blur.still:
        return 0
    depth = _one_sided(rings.levels, 0, _UNEVEN_LEAST)
    light = 2 * _one_sided(rings.levels, 32, _BACKGROUND_LEAST)
    return depth * depth + light * light


def _one_sided(levels, first, least):
    """How much more than `least` the levels of 32 sectors differ from side to side, 1024ths of their mean."""
    along = across = 0
    total = 1
    for sector in range(32):
        level = levels[first + sector]
        total += level
        along += level * (tables.WAVES[sector] - 128)
        across += level * (tables.WAVES[(sector + 24) & 31] - 128)
    along = (along << 3) // total
    across = (across << 3) // total
    return max(0, isqrt(along * along + across * across) - least)


def _defocus(rings):
    """How far defocus may shift the centre, 1/1024 px."""
    if not rings.blur.still:
        return 0
    # a unit is 1/24 of the radius, SIGMAS are 1/256 of it
    return max(0, SIGMAS[rings.blur.sigma] * rings.radius_q8 // 1536 - _SHARP_Q10) // _DEFOCUS


def centre_variance(rings, noise, uneven):
    """Of the centre along each axis, (1/1024 px) ** 2; noise: of BlurredLines; uneven: `uneven_square`."""
    blur = rings.blur
    deviation = min(rings.deviation_q10, _FAR)
    square = deviation * deviation * 3 // max(1, rings.used_outer + rings.used_inner)
    known = deviation * min(_CALM, max(0, _NOISY - noise)) * (_AT_REST if blur.still else _MOVING)
    known //= 100 * _CALM
    defocus = _defocus(rings)
    return min(_MOST, square + known * known + defocus * defocus + uneven)


def sigma_mdeg(rings, lines, uneven):
    """Standard deviation of the heading, 0.001 degrees; uneven: `uneven_square`."""
    blur = rings.blur
    radius_q8 = rings.radius_q8
    turned = min(rings.deviation_q10, _FAR) * _HEADING // radius_q8
    least = _HEADING_LEAST
    if blur.still and blur.sigma < _SHARP and lines.noise <= _SHARP_NOISE:
        turned += turned
        least = _SHARP_LEAST
    # what is no line beside it draws a line, too
    residual = min(lines.residual, _FAR) * 4 // 5
    defocus = _defocus(rings) >> 1
    shifted = isqrt(min(_MOST, uneven) + defocus * defocus + residual * residual) * _TURN // radius_q8
    turned = min(turned, _TURNED_MOST)
    shifted = min(shifted, _TURNED_MOST)
    return isqrt(turned * turned + least + shifted * shifted)
