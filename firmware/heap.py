"""The board's heap: whether it is small, and the room that is kept there while the program is loaded.

What loading leaves lies everywhere between what stays, so that afterwards no piece is long enough for the
detector's largest buffers: `room` is where they go. It is taken when this module is loaded, first of all.
Collecting while loading costs more than loading, most of all in a large heap, and after each collection
MicroPython looks for memory from the first hole on: only the smallest heaps are collected, and seldom.
"""

import gc

_TWO_DETECTORS = 1 << 20  # bytes in which two fit beside the program
_ROOM = 64 << 10  # edges and cells of votes with the usual settings; what is shorter fits between the rest
_COLLECTED = 480 << 10  # bytes of a heap that would be full of what loading leaves,
_SELDOM = 5  # collections while loading: 32 in as much memory as there is


def _is_small():
    """A PC gives as much as one likes. To count what is free would walk through a large heap."""
    if not hasattr(gc, "mem_free"):
        return False
    try:
        bytearray(_TWO_DETECTORS)
    except MemoryError:
        return True
    return False


def _piece():
    """Half of what is free where that is less than what is wanted."""
    size = _ROOM
    while size:
        try:
            return [bytearray(size)]
        except MemoryError:
            size >>= 1
    return []


small = _is_small()
if small and gc.mem_free() < _COLLECTED:
    gc.threshold(gc.mem_free() >> _SELDOM)
room = _piece() if small else []


def loaded():
    """All is loaded: from here on next to nothing is allocated."""
    if small:
        gc.collect()
        gc.threshold(-1)


def free_bytes():
    """What is free after a collection, the room included. Only for small heaps: it walks through them."""
    gc.collect()
    return gc.mem_free() + sum([len(piece) for piece in room])
