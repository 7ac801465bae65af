"""How far a reading of the blur-model reader may be off: standard deviations of centre and heading.

From how far the sectors lie from the fit. Where there is little noise, that is what the model does not know
of the blur, and does not even out over the rings; what defocus shifts leaves the rings round and does not
show in it at all. The weights were fitted to the errors of rendered frames with motion of 8 and 12 px,
defocus of 3.5 px, rings of 6 to 10 px, contrast of 5 and 8 grey levels, and tilt: of the centres 59 to 84 %
lie within one of them, 88 to 99 % within two; of the headings 52 to 79 and 75 to 97 %.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import isqrt
from larics.blurred.blur_model import SIGMAS

_MOST = const(1 << 20)  # of a variance, (1/1024 px) ** 2: one pixel
_FAR = const(2048)  # deviation that counts at most, 1/1024 px
_CALM = const(32)  # noise of the lines' samples below which none of the deviation is noise,
_NOISY = const(40)  # and at which all of it is, less _CALM
_AT_REST = const(48)  # hundredths of the deviation that do not even out,
_MOVING = const(30)  # and where motion blurs
_SHARP_Q10 = const(1638)  # blur, 1/1024 px, beyond which a 13th of it counts, too: 1.6 px
_DEFOCUS = const(13)
_HEADING = const(7700)  # 0.54 of the deviation at the outer ring: mdeg * radius (1/256 px) for 1/1024 px
_HEADING_LEAST = const(2025)  # mdeg ** 2


def centre_variance(rings, noise):
    """Of the centre along each axis, (1/1024 px) ** 2; noise: of BlurredLines."""
    blur = rings.blur
    deviation = min(rings.deviation_q10, _FAR)
    square = deviation * deviation * 3 // max(1, rings.used_outer + rings.used_inner)
    known = deviation * min(_CALM, max(0, _NOISY - noise)) * (_AT_REST if blur.still else _MOVING)
    known //= 100 * _CALM
    defocus = 0
    if blur.still:
        # a unit is 1/24 of the radius, SIGMAS are 1/256 of it
        defocus = max(0, SIGMAS[blur.sigma] * rings.radius_q8 // 1536 - _SHARP_Q10) // _DEFOCUS
    return min(_MOST, square + known * known + defocus * defocus)


def sigma_mdeg(rings):
    """Standard deviation of the heading, 0.001 degrees."""
    turned = min(rings.deviation_q10, _FAR) * _HEADING // rings.radius_q8
    return isqrt(turned * turned + _HEADING_LEAST)
