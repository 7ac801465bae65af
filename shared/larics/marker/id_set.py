"""Sets of IDs: numbers and ranges, as people give them; a bit for each of 4096, as kernels take them."""

from larics.marker import CODED_ID_MOST, is_used


def ends_of(item):
    """First and last ID of an item of a list of IDs and (first, last) of ranges."""
    return (item, item) if isinstance(item, int) else item


def within(allowed, marker_id):
    """Whether a list of IDs and (first, last) of ranges holds an ID; an empty one holds all."""
    for item in allowed:
        if isinstance(item, int):
            if item == marker_id:
                return True
        elif item[0] <= marker_id <= item[1]:
            return True
    return not allowed


def id_set(allowed, coded, allow_id0):
    """bytearray of 512 bytes, bit k & 7 of byte k >> 3 for ID k: those of `allowed` that a family uses.

    allowed: IDs, or (first, last) of ranges; None or empty: all. What the family does not use is left out."""
    bits = bytearray(512)
    for item in allowed or ((0, CODED_ID_MOST),):
        first, last = ends_of(item)
        for marker_id in range(first, min(last, CODED_ID_MOST) + 1):
            if is_used(marker_id, coded, allow_id0):
                bits[marker_id >> 3] |= 1 << (marker_id & 7)
    return bits


def holds(bits, marker_id):
    """Whether a set holds an ID of 0..4095."""
    return bits[marker_id >> 3] >> (marker_id & 7) & 1 > 0
