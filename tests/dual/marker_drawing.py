"""Markers drawn with integers only, so that tests have the same frames on every interpreter."""

from larics.arith.fixed import cos_q14, sin_q14, turn16_from_cdeg
from larics.marker import CODED, LARICS3

_CELLS_CDEG = (1850, 2750, 3650, 5350, 6250, 7150)  # middles of the cells of a quarter turn
_CELL_TURNS = [turn16_from_cdeg(9000 * quarter + middle) for quarter in range(4) for middle in _CELLS_CDEG]
_CELL_DIRECTIONS = [(cos_q14(turn16), sin_q14(turn16)) for turn16 in _CELL_TURNS]


def in_cell(u, v, direction):
    """Whether a point lies within the angles of a cell, whose middle has this cosine and sine."""
    cosine, sine = direction
    along = (u * cosine + v * sine) >> 14
    return along > 0 and abs((v * cosine - u * sine) >> 14) * 1000 <= along * 79  # the tangent of 4.5 degrees


def _squares(least, most):
    """Limits of the squared distance of what is from `least` to `most` away, in whole units."""
    return least * least, (most + 1) * (most + 1) - 1


def darkness(marker_id, unit):
    """A function that tells whether the point u along and v to the left of the orientation line is black;
    `unit` makes 150 mm. What does not depend on the point is worked out once: MicroPython is slow."""

    def scaled(length_mm10):
        return length_mm10 * unit // LARICS3.outer_mm10

    half = scaled(LARICS3.line_mm10) // 2
    outer, line_end = scaled(LARICS3.outer_mm10), scaled(LARICS3.orientation_end_mm10)
    outer_from, outer_to = _squares(outer - half, outer + half)
    inner = scaled(LARICS3.inner_mm10)
    inner_from, inner_to = _squares(inner - half, inner + half)
    start, end = scaled(LARICS3.code_start_mm10), scaled(LARICS3.code_end_mm10)
    left, back, right = CODED.bits(marker_id)  # lines at 90, 180 and 270 degrees
    cells = CODED.cells(marker_id)
    directions = [direction for cell, direction in enumerate(_CELL_DIRECTIONS) if cells >> cell & 1]
    cells_from, cells_to = _squares(scaled(CODED.cell_start_mm10), scaled(CODED.cell_end_mm10))

    def is_dark(u, v):
        square = u * u + v * v
        if outer_from <= square <= outer_to or inner_from <= square <= inner_to:
            return True
        if -half <= v <= half:
            return outer <= u <= line_end or (back and start <= -u <= end)
        if cells_from <= square <= cells_to:
            for direction in directions:
                if in_cell(u, v, direction):
                    return True
            return False
        if -half <= u <= half:
            return left and start <= v <= end or right and start <= -v <= end
        return False

    return is_dark


def draw(width, height, marker_id, x_q4, y_q4, radius_q4, heading_cdeg, light=190, dark=30, noise=11, seed=1):
    """A frame with one level marker, two by two samples a pixel, on an endless plate.

    x_q4, y_q4, radius_q4: centre and outer ring in 1/16 px; light, dark: grey levels of plate and lines, to
    which 0 .. noise - 1 is added. Returns a bytearray.
    """
    is_dark = darkness(marker_id, radius_q4)
    turn16 = turn16_from_cdeg(heading_cdeg)
    cosine, sine = cos_q14(turn16), sin_q14(turn16)
    frame = bytearray(width * height)
    state = seed
    reach = radius_q4 * 26 // 15
    for y in range(height):
        row_is_near = abs(16 * y - y_q4) < reach
        for x in range(width):
            black = 0
            if row_is_near and abs(16 * x - x_q4) < reach:
                for sample in range(4):
                    dx = 16 * x - 4 + 8 * (sample & 1) - x_q4
                    dy = y_q4 - (16 * y - 4 + 8 * (sample >> 1))  # upwards
                    if is_dark((dx * cosine + dy * sine) >> 14, (dy * cosine - dx * sine) >> 14):
                        black += 1
            state = (state * 1103515245 + 12345) & 0x7FFFFFFF
            grey = light - (light - dark) * black // 4 + (state >> 20) % noise
            frame[y * width + x] = min(255, grey)
    return frame
