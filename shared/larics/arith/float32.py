"""IEEE 754 single precision from integers, for protocols that want it; no float is ever made."""


def put_float32(buffer, place, numerator, denominator):
    """Writes numerator / denominator, rounded to nearest (ties to even), to buffer[place..place+3].

    Little-endian. |numerator| < 2**30, 0 < denominator < 2**24; every intermediate is below 2**30.
    """
    sign = 0
    if numerator < 0:
        sign = 0x80
        numerator = -numerator
    mantissa = numerator // denominator
    rest = numerator - mantissa * denominator
    exponent = 0
    if numerator == 0:
        exponent = -150  # all bits 0
    else:
        while mantissa < 0x1000000:  # one bit more than is kept, to round by
            rest <<= 1
            mantissa <<= 1
            exponent -= 1
            if rest >= denominator:
                rest -= denominator
                mantissa += 1
        while mantissa >= 0x2000000:
            rest |= mantissa & 1
            mantissa >>= 1
            exponent += 1
        half = mantissa & 1
        mantissa >>= 1
        exponent += 1
        if half and (rest or mantissa & 1):
            mantissa += 1
            if mantissa == 0x1000000:
                mantissa >>= 1
                exponent += 1
    exponent += 150
    buffer[place] = mantissa & 0xFF
    buffer[place + 1] = mantissa >> 8 & 0xFF
    buffer[place + 2] = mantissa >> 16 & 0x7F | (exponent & 1) << 7
    buffer[place + 3] = sign | exponent >> 1


def put_nan32(buffer, place):
    """Writes not-a-number."""
    buffer[place] = buffer[place + 1] = 0
    buffer[place + 2] = 0xC0
    buffer[place + 3] = 0x7F
