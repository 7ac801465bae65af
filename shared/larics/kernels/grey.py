"""Counts grey levels, for the control of the exposure."""

try:
    import micropython
except ImportError:
    from larics._cpython import micropython, ptr8, ptr16


@micropython.viper
def count_greys(
    frame: ptr8, counts: ptr16, place: int, row: int, width: int, left: int, top: int, right: int,
    bottom: int, step: int,
):  # fmt: skip
    """Counts every step-th pixel of columns left..right-1 and rows top..bottom-1 in counts[grey >> 2].

    counts: array('H') of 64, filled anew; at most 65535 pixels. `place` and `row` are registers, give 0."""
    while place < 64:
        counts[place] = 0
        place += 1
    while top < bottom:
        row = top * width
        place = row + left
        row += right
        while place < row:
            n = int(frame[place]) >> 2
            counts[n] = int(counts[n]) + 1
            place += step
        top += step
