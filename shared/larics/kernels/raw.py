"""Pixels of a raw frame as few bits: LOCO-I's prediction (Weinberger, Seroussi, Sapiro 2000) and Rice codes.

The pixels of a chunk follow each other row by row within a strip of `width` columns, `stride` being the
frame's row; the first is number `column` of its row. Only pixels of the same chunk predict, so that each can
be decoded alone. An error of prediction e, modulo 256 in -128..127, is coded as z = 2 e, or -2 e - 1 where
e < 0.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8

_ESCAPE = const(12)  # zeros before a z that is written as 8 bits, being too large to be told by their number
_ESCAPED_BITS = const(20)


@micropython.viper
def predict(
    pixels: ptr8, errors: ptr8, place: int, n: int, count: int, column: int, width: int, stride: int,
    most_bits: int, total: int,
) -> int:  # fmt: skip
    """Puts the first pixel and the z of those after it into errors[:n]; returns n + (k << 16).

    place      index of the first pixel; count: pixels that are left, 1..505
    most_bits  it ends before `count` when at least so many bits are needed
    k          0..7, by the mean of z: the Rice parameter that fits about
    `n` and `total` are registers, give 1 and 0."""
    k = 0
    west = int(pixels[place])
    errors[0] = west
    while n < count:
        place += 1
        column += 1
        if column == width:
            column = 0
            place += stride - width
        guess = west
        if n >= width:
            north = int(pixels[place - stride])
            if column == 0:
                guess = north
            elif n > width:
                corner = int(pixels[place - stride - 1])
                if north < west:
                    if corner >= west:
                        guess = north
                    elif corner > north:
                        guess = north + west - corner
                elif corner < north:
                    if corner <= west:
                        guess = north
                    else:
                        guess = north + west - corner
        west = int(pixels[place])
        z = ((west - guess + 128) & 255) - 128
        if z < 0:
            z = 0 - z - z - 1
        else:
            z = z + z
        errors[n] = z
        total += z
        n += 1
        while k < 7 and (n << k) < total:
            k += 1
        if n * (k + 1) > most_bits:
            count = n
    return n + (k << 16)


@micropython.viper
def fitting(errors: ptr8, n: int, count: int, k: int, bits: int) -> int:
    """How many of errors[:count] fit into so many bits with the Rice parameter k; n: give 1.

    The first takes 8 bits."""
    bits -= 8
    while n < count:
        z = int(errors[n]) >> k
        if z < _ESCAPE:
            bits -= z + 1 + k
        else:
            bits -= _ESCAPED_BITS
        if bits < 0:
            count = n
        else:
            n += 1
    return n


@micropython.viper
def pack(errors: ptr8, data: ptr8, n: int, count: int, k: int, size: int, place: int):
    """Writes errors[:count] to data[:size], zeros after them; `n` and `place` are registers, give 1 and 1."""
    data[0] = int(errors[0])
    kept = 0  # bits not yet written, fewer than 8
    bits = 0
    while n < count:
        z = int(errors[n])
        high = z >> k
        if high < _ESCAPE:
            high += k + 1
            z = (1 << k) | (z & ((1 << k) - 1))
        else:
            high = _ESCAPED_BITS
        kept = (kept << high) | z
        bits += high
        while bits >= 8:
            bits -= 8
            data[place] = (kept >> bits) & 255
            place += 1
        kept = kept & ((1 << bits) - 1)
        n += 1
    if bits > 0:
        data[place] = (kept << (8 - bits)) & 255
        place += 1
    while place < size:
        data[place] = 0
        place += 1


@micropython.viper
def gather(
    pixels: ptr8, data: ptr8, place: int, n: int, count: int, column: int, width: int, stride: int, size: int
):
    """Copies `count` pixels as they are to data[:size], zeros after them; n: give 0."""
    while n < count:
        data[n] = int(pixels[place])
        place += 1
        column += 1
        if column == width:
            column = 0
            place += stride - width
        n += 1
    while n < size:
        data[n] = 0
        n += 1
