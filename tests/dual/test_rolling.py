"""A rolling shutter is undone with the same numbers on both interpreters, without allocating."""

from larics.locate.camera_model import Measurement
from larics.locate.rolling import RollingShutter

try:
    from micropython import heap_lock, heap_unlock
except ImportError:

    def heap_lock():
        pass

    heap_unlock = heap_lock


class Told:
    state = epoch = jumps = 1
    x_mm10 = y_mm10 = heading_cdeg = 0


def seen(offset_mm10=3000, row_q8=15000, heading_cdeg=4500, above_mm10=30000):
    one = Measurement()
    one.offset_x_mm10, one.offset_y_mm10, one.row_q8 = offset_mm10, offset_mm10 // 2, row_q8
    one.heading_cdeg, one.height_mm10, one.radius_q8 = heading_cdeg, above_mm10, 8600
    return one


def test_the_same_numbers_and_nothing_allocated():
    undo, told, markers = RollingShutter(25000, 172000, 9000), Told(), [seen(), seen(-2000, -9000, 30000)]
    undo.follow(markers, 0, 0, told)
    told.x_mm10, told.y_mm10, told.heading_cdeg = 700, -200, 35900
    heap_lock()
    try:
        undo.follow(markers, 2, 50000, told)
    finally:
        heap_unlock()
    numbers = [(one.offset_x_mm10, one.offset_y_mm10, one.heading_cdeg) for one in markers]
    assert numbers == [(3022, 1493, 4530), (-2012, -997, 30028)], numbers
