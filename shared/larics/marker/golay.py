"""The code of the cells: the extended Golay code [24, 12, 8] of a 12-bit ID, laid out around the marker.

A word is the ID times 2**12 and 12 bits of check, and any two words differ in at least 8 of 24 bits: the code
of M. J. E. Golay, Notes on digital coding (1949), with one bit of parity more. Cells are counted as in
`larics.marker`, a set bit is a dark cell.

Neighbouring bits of a word lie far from each other: in their natural order a marker seen turned by one cell
would give another word every other time; in this one only the empty and the full word survive that.
"""

CELLS = 24
DISTANCE = 8  # any two words differ in at least so many cells

# check bits of each bit of an ID, uint16
_CHECKS = b"\xeb\x08\x3e\x09\x97\x0a\xc6\x0d\x67\x03\xcd\x06\x99\x0d\xda\x03\xb4\x07\x68\x0f\x3b\x06\x75\x0c"
# cell of each bit of a word
ORDER = b"\x16\x07\x11\x13\x06\x03\x01\x08\x14\x09\x12\x17\x04\x02\x05\x00\x10\x0f\x0c\x0a\x15\x0b\x0e\x0d"


def word(marker_id):
    """The word of a 12-bit ID: the ID in bits 12..23, its check in bits 0..11."""
    check = 0
    for bit in range(12):
        if marker_id >> bit & 1:
            check ^= _CHECKS[2 * bit] | _CHECKS[2 * bit + 1] << 8
    return marker_id << 12 | check


def cells(marker_id):
    """The dark cells of a 12-bit ID, a bit for each of 24."""
    bits = word(marker_id)
    dark = 0
    for bit in range(CELLS):
        dark |= (bits >> bit & 1) << ORDER[bit]
    return dark


def differing(one, other):
    """In how many cells the words of two 12-bit IDs differ."""
    different = word(one) ^ word(other)
    count = 0
    while different:
        different &= different - 1
        count += 1
    return count
