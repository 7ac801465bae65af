"""Sets of IDs: numbers and ranges, as people give them; a bit for each of 4096, as kernels take them."""

from larics.marker import CODED_ID_MOST, PLAIN_ID_MOST


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
    most = CODED_ID_MOST if coded else PLAIN_ID_MOST
    for item in allowed or ((0, most),):
        first, last = ends_of(item)
        last = min(last, most)
        for place in range(first >> 3, (last >> 3) + 1):  # eight at once: it is done at the start
            used = 255 if allow_id0 and not place else 254  # no other ID that is a multiple of 8
            from_first = 255 << max(0, first - 8 * place)
            bits[place] |= used & from_first & (2 << min(7, last - 8 * place)) - 1
    return bits


def holds(bits, marker_id):
    """Whether a set holds an ID of 0..4095."""
    return bits[marker_id >> 3] >> (marker_id & 7) & 1 > 0
