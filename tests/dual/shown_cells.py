"""A reader of cells and what a picture shows it, for tests of what it makes of that."""

from array import array

from larics.coded.cell_reader import CellReader
from larics.marker import golay
from larics.marker.id_set import id_set

BIAS = 1 << 24
WHITE = 900
ID = 1261  # lines of 5


def reader(allowed=None, mirrored=False):
    """A CellReader of frames of 360 x 296, allowed: the IDs that it may tell, None: all."""
    return CellReader(360, 296, id_set(allowed, True, False), array("i", bytes(4 * 400)), mirrored)


def show(cells, marker_id, turn=0):
    """As a sharp picture shows the cells of a marker; `turn` quarter turns clockwise."""
    dark = golay.cells(marker_id) if marker_id > 7 else 0
    for cell in range(24):
        is_dark = dark >> (cell + 6 * turn) % 24 & 1
        cells.depths[cell] = BIAS + (360 if is_dark else 0)
        cells.depths[24 + cell] = WHITE - (360 if is_dark else 0)
        cells.depths[48 + cell] = WHITE
    return dark


def mirror(cells):
    """Exchanges left and right of what is shown."""
    for cell in range(12):
        for row in range(3):
            a, b = 24 * row + cell, 24 * row + 23 - cell
            cells.depths[a], cells.depths[b] = cells.depths[b], cells.depths[a]


def cover(cells, which, tone):
    """Hides cells under something of another tone."""
    for cell in which:
        cells.depths[cell] = BIAS
        cells.depths[24 + cell] = cells.depths[48 + cell] = tone
