"""How far a reading of the blur-model reader may be off: standard deviations of centre and heading.

From how far the sectors lie from the fit. Where there is little noise, that is what the model does not know
of the blur, and does not even out over the rings. The weights were fitted to the errors of rendered frames
with motion of 8 and 11 px, rings of 8 and 10 px and contrast of 8 grey levels.
"""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

_MOST = const(1 << 20)  # of a variance, (1/1024 px) ** 2: one pixel
_FAR = const(2048)  # deviation that counts at most, 1/1024 px
_CALM = const(32)  # noise of the lines' samples below which none of the deviation is noise,
_NOISY = const(40)  # and at which all of it is, less _CALM
_HEADING = const(8880)  # 0.62 of the deviation at the outer ring: mdeg * radius (1/256 px) for 1/1024 px


def centre_variance(rings, noise):
    """Of the centre along each axis, (1/1024 px) ** 2; noise: of BlurredLines."""
    deviation = min(rings.deviation_q10, _FAR)
    square = deviation * deviation * 3 // max(1, rings.used_outer + rings.used_inner)
    known = deviation * min(_CALM, max(0, _NOISY - noise)) * 2 // (5 * _CALM)
    return min(_MOST, square + known * known)


def sigma_mdeg(rings):
    """Standard deviation of the heading, 0.001 degrees, at least 1."""
    return max(1, min(rings.deviation_q10, _FAR) * _HEADING // rings.radius_q8)
