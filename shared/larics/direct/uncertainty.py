"""How far a direct reading may be off: standard deviations of centre and heading, of each detection its own.

From what the fit of the rings leaves, how unevenly deep they are, how far the last pass still moved them, and
how straight the orientation line is. The weights were fitted to the errors of rendered frames of all presets.

Limits are comparisons here: a call of min or max takes as many instructions as ten of them.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith import tables
from larics.kernels import robust as kernels

_SAMPLING = const(150)  # (1/1024 px) ** 2 of the sectors' spread: of sampling, which evens out over the rings
_UNSEEN = const(256)  # taken for how far an orientation line strays that is not seen
_MOST = const(1 << 20)  # of a variance, (1/1024 px) ** 2: one pixel
_CROSSING_COUNTED = const(3)  # items as in kernels.layouts
_CROSSING_DISTANCE = const(6)
_CROSSING_AREA = const(7)
_FEW_PIXELS = const(35840)  # so much of the variance, over the square of the radius (1/16 px), is added to it
_AREA_OFF = const(20)  # what is darker or paler than a line, 256 = as the rings', lies in uneven light
_DEFOCUSED = const(5)  # a darker one counts so much more: defocus draws its sides into it
_HEADING = const(1085)  # cdeg that 1/256 of the radius turns the line's middle, * 256 / 1024 * 16
_HEADING_LEAST = const(31)  # (1/16 cdeg) ** 2


@micropython.native
def centre_variance(robust, rings, lines):
    """Of the centre along each axis, (1/1024 px) ** 2; lines: None when the orientation line was not seen."""
    variance = robust.variance
    square = robust.square
    most = variance * 9 // 10
    sampling = variance * _SAMPLING // (square if square > _SAMPLING else _SAMPLING)
    variance = (variance - (sampling if sampling < most else most)) * 13 // 16
    area = rings.area
    variance += kernels.uneven_depths(
        0, 0, 0, tables.WAVES, area if area > 1 else 1, rings.outer_means, rings.inner_means
    )
    distance = lines.line[_CROSSING_DISTANCE] if lines is not None else _UNSEEN
    if distance > 4096:
        distance = 4096
    moved = rings.moved_q10
    if moved > 4096:
        moved = 4096
    return with_few_pixels(variance + distance * distance // 22 + moved * moved // 12, rings.radius_q8)


@micropython.native
def with_few_pixels(variance, radius_q8):
    """The variance with what few pixels add to it: sectors of a small ring are not independent."""
    radius_q4 = radius_q8 >> 4
    share_q8 = _FEW_PIXELS * 256 // (radius_q4 * radius_q4)
    if share_q8 > 1023:
        share_q8 = 1023
    if variance > _MOST:
        variance = _MOST
    variance += variance * share_q8 >> 8
    return variance if variance < _MOST else _MOST


@micropython.native
def sigma_q12(variance):
    """Standard deviation of a centre of that variance, 1/4096 px, 1..4096."""
    sigma = kernels.root(variance << 4, 0, 0)
    return sigma if sigma else 1


@micropython.native
def sigma_mdeg(variance, lines, radius_q8):
    """Standard deviation of the heading, 0.001 degrees, at least 3: the line's own, and the centre's."""
    line = lines.line
    distance = line[_CROSSING_DISTANCE]
    if distance > 1024:
        distance = 1024
    counted = line[_CROSSING_COUNTED]
    square = distance * distance * 5 // (counted * 4 if counted > 2 else 8) + variance * 5 // 4
    darker = line[_CROSSING_AREA] - 256
    off = (darker if darker > 0 else -darker) - _AREA_OFF
    if off > 0:
        if off > 1024:
            off = 1024
        square += off * off * (_DEFOCUSED if darker > 0 else 1) >> 1
    if square > _MOST:
        square = _MOST
    turned = kernels.root(square << 8, 0, 0) * _HEADING // radius_q8
    if turned > 16000:
        turned = 16000
    return kernels.root(turned * turned + _HEADING_LEAST, 0, 0) * 10 >> 4
