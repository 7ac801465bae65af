"""Header of a binary PGM picture (netpbm P5, 8 bits), from its first bytes."""

HEADER_MAX = 64


def parse_header(data):
    """Returns (width, height, offset of the first pixel); ValueError says what is wrong."""
    if bytes(data[:2]) != b"P5":
        raise ValueError("not a binary PGM picture")
    numbers = []
    position = 2
    while len(numbers) < 3:
        if position >= len(data):
            raise ValueError("PGM header longer than %d bytes or cut off" % HEADER_MAX)
        byte = data[position]
        if byte == 35:  # '#': a comment up to the end of the line
            while position < len(data) and data[position] != 10:
                position += 1
        elif 48 <= byte <= 57:
            value = 0
            while position < len(data) and 48 <= data[position] <= 57:
                value = value * 10 + data[position] - 48
                position += 1
            numbers.append(value)
            continue
        elif byte not in (9, 10, 13, 32):
            raise ValueError("PGM header has an unexpected byte %d" % byte)
        position += 1
    width, height, maximum = numbers
    if maximum != 255:
        raise ValueError("PGM picture has %d grey levels, 255 is wanted" % maximum)
    if width < 1 or height < 1:
        raise ValueError("PGM picture of %dx%d pixels" % (width, height))
    return width, height, position + 1
