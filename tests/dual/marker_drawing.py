"""Markers drawn with integers only, so that tests have the same frames on every interpreter."""

from larics.arith.fixed import cos_q14, isqrt, sin_q14, turn16_from_cdeg
from larics.marker import CODED, LARICS3

_CELLS_CDEG = (1850, 2750, 3650, 5350, 6250, 7150)  # middles of the cells of a quarter turn


def _near(value, centre, half):
    return -half <= value - centre <= half


def in_cell(u, v, cell):
    """Whether a point lies within the angles of a cell."""
    turn16 = turn16_from_cdeg(9000 * (cell // 6) + _CELLS_CDEG[cell % 6])
    cosine, sine = cos_q14(turn16), sin_q14(turn16)
    along, across = (u * cosine + v * sine) >> 14, (v * cosine - u * sine) >> 14
    return along > 0 and abs(across) * 1000 <= along * 79  # the tangent of 4.5 degrees


def is_dark(u, v, bits, unit, cells=0):
    """Whether the point u along and v to the left of the orientation line is black; `unit` makes 150 mm."""

    def scaled(length_mm10):
        return length_mm10 * unit // LARICS3.outer_mm10

    radius = isqrt(u * u + v * v)
    half = scaled(LARICS3.line_mm10) // 2
    if _near(radius, scaled(LARICS3.outer_mm10), half) or _near(radius, scaled(LARICS3.inner_mm10), half):
        return True
    if scaled(LARICS3.outer_mm10) <= u <= scaled(LARICS3.orientation_end_mm10) and _near(v, 0, half):
        return True
    if cells and scaled(CODED.cell_start_mm10) <= radius <= scaled(CODED.cell_end_mm10):
        return any([cells >> cell & 1 and in_cell(u, v, cell) for cell in range(24)])
    start, end = scaled(LARICS3.code_start_mm10), scaled(LARICS3.code_end_mm10)
    for bit, along, across in zip(bits, (v, -u, -v), (u, v, u)):  # lines at 90, 180 and 270 degrees
        if bit and start <= along <= end and _near(across, 0, half):
            return True
    return False


def draw(width, height, marker_id, x_q4, y_q4, radius_q4, heading_cdeg, light=190, dark=30, noise=11, seed=1):
    """A frame with one level marker, two by two samples a pixel, on an endless plate.

    x_q4, y_q4, radius_q4: centre and outer ring in 1/16 px; light, dark: grey levels of plate and lines, to
    which 0 .. noise - 1 is added. Returns a bytearray.
    """
    bits = CODED.bits(marker_id)
    cells = CODED.cells(marker_id)
    turn16 = turn16_from_cdeg(heading_cdeg)
    cosine, sine = cos_q14(turn16), sin_q14(turn16)
    frame = bytearray(width * height)
    state = seed
    reach = radius_q4 * 26 // 15
    for y in range(height):
        for x in range(width):
            black = 0
            if abs(16 * x - x_q4) < reach and abs(16 * y - y_q4) < reach:
                for sample in range(4):
                    dx = 16 * x - 4 + 8 * (sample & 1) - x_q4
                    dy = y_q4 - (16 * y - 4 + 8 * (sample >> 1))  # upwards
                    u = (dx * cosine + dy * sine) >> 14
                    v = (dy * cosine - dx * sine) >> 14
                    if is_dark(u, v, bits, radius_q4, cells):
                        black += 1
            state = (state * 1103515245 + 12345) & 0x7FFFFFFF
            grey = light - (light - dark) * black // 4 + (state >> 20) % noise
            frame[y * width + x] = min(255, grey)
    return frame
