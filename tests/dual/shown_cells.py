"""A reader of cells and what a picture shows it, for tests of what it makes of that."""

from array import array

from larics.arith import fixed
from larics.coded.cell_reader import CellReader
from larics.marker import golay
from larics.marker.id_set import id_set

BIAS = 1 << 24
WHITE = 900
ID = 1261  # lines of 5
SIDE = 96  # of the frame, in whose middle the marker lies
RADIUS = 24
PAPER = 200  # its grey
FRAME = bytearray([PAPER] * (SIDE * SIDE))


def reader(allowed=None, mirrored=False):
    """A CellReader that has looked at white paper, allowed: the IDs that it may tell, None: all."""
    cells = CellReader(SIDE, SIDE, id_set(allowed, True, False), array("i", bytes(4 * 400)), mirrored)
    look(cells, FRAME)
    return cells


def look(cells, frame, noisy=False, depth=200):
    """Measures a frame in whose middle a marker lies, its orientation line to the right."""
    middle = SIDE * 128
    assert cells.measure(frame, middle, middle, RADIUS * 256, 0, 0, 0, 0, 0, depth, noisy)


def crossed(degrees, grey, frame=FRAME):
    """The frame with that grey between the cells in so many degrees from the orientation line."""
    frame = bytearray(frame)
    sine, cosine = fixed.sin_q14(degrees * 65536 // 360), fixed.cos_q14(degrees * 65536 // 360)
    for radius in (228, 236):
        x = SIDE * 64 + radius * RADIUS * cosine // 150 // 128
        y = SIDE * 64 - radius * RADIUS * sine // 150 // 128
        for near in range(9):
            frame[((y >> 7) + near // 3 - 1) * SIDE + (x >> 7) + near % 3 - 1] = grey
    return frame


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
