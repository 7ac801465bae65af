"""Grey levels of a frame: counted to control the exposure, sampled to compare it with the frame before."""

try:
    import micropython
    from micropython import const  # noqa: F401  (a folder of that name has none)
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


@micropython.viper
def take_sample(frame: ptr8, kept: ptr8, place: int, k: int, step: int, count: int, found: ptr16):
    """Puts every step-th pixel into kept[:count] and tells of them in found, array('H') of 4:

    how many differ from what was kept, the least, the largest and the sum; at most 257 pixels.
    `place` and `k` are registers, give 0."""
    found[0] = 0
    found[1] = 255
    found[2] = 0
    found[3] = 0
    while k < count:
        grey = int(frame[place])
        if grey != int(kept[k]):
            found[0] = int(found[0]) + 1
            kept[k] = grey
        if grey < int(found[1]):
            found[1] = grey
        if grey > int(found[2]):
            found[2] = grey
        found[3] = int(found[3]) + grey
        place += step
        k += 1
