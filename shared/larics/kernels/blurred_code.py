"""The blur-model reader on the code: eight blurred lines inside the inner ring, fitted jointly.

Units as in larics.kernels.blur.
"""

try:
    import micropython
    from micropython import const  # noqa: F401  (a folder of that name has none)
except ImportError:
    from larics._cpython import micropython, ptr16, ptr32


@micropython.viper
def fit_code(
    ink: ptr16, i: int, value: int, templates: ptr16, axes: int, reach: int, gram: ptr32, side: ptr32,
    rounds: int, amounts: ptr32,
) -> int:  # fmt: skip
    """Eight lines' depths and a constant in two zones of 64 directions, jointly by least squares.

    ink: 2 * 64 items (zone, direction), line p in direction 8 p, limited to 32768 +- 2047 here; templates:
    for each of the `axes` (4, or 1 when they are all alike) of the lines p & 3, for each zone, 33 items for
    0..32 directions from the line, 0 beyond `reach` (1..31). gram: 81 items, side: 9 items, scratch space;
    rounds: of Gauss and Seidel's method, at most. amounts: depths (1/256) + 65536 of 8 lines, the constant in
    units of 256/1024, and the median of the depths at 0, 1, 3, 5 and 7, where no bit is. Returns 0."""
    total = 0
    i = 0
    while i < 128:
        value = int(ink[i])
        if value > 34815:
            value = 34815
            ink[i] = value
        if value < 30721:
            value = 30721
            ink[i] = value
        total += value
        i += 1
    side[8] = ((total - 4194304) >> 2) + 1048576
    amounts[8] = 65536
    gram[80] = 8192
    p = 0
    while p < 8:
        base = (p & (axes - 1)) * 66
        i = p << 3
        value = int(templates[base])
        far = int(templates[base + 33])
        alone = value + far
        total = value * (int(ink[i]) - 32768) + far * (int(ink[64 + i]) - 32768)
        k = 1
        while k <= reach:
            near = int(templates[base + k])
            far = int(templates[base + 33 + k])
            alone += near + near + far + far
            i = ((p << 3) + k) & 63
            value = ((p << 3) - k) & 63
            total += near * (int(ink[i]) + int(ink[value]) - 65536)
            total += far * (int(ink[64 + i]) + int(ink[64 + value]) - 65536)
            k += 1
        gram[p * 9 + 8] = alone >> 2
        gram[72 + p] = alone >> 2
        side[p] = (total >> 10) + 1048576
        amounts[p] = 65536
        p += 1
    # lines that lie alike to each other share the product of their templates
    p = 0
    while p < axes:
        base = p * 66
        apart = 0
        while apart < 40:
            other = ((p + (apart >> 3)) & (axes - 1)) * 66
            k = 0 - reach
            if apart + reach + reach < 64:
                k += apart
            total = 0
            while k <= reach:
                i = (k - apart) & 63
                if i > 32:
                    i = 64 - i
                if i <= reach:
                    value = k
                    if value < 0:
                        value = 0 - value
                    total += int(templates[base + value]) * int(templates[other + i])
                    total += int(templates[base + 33 + value]) * int(templates[other + 33 + i])
                k += 1
            total = total >> 10
            k = p
            while k < 8:
                i = (k + (apart >> 3)) & 7
                gram[k * 9 + i] = total
                gram[i * 9 + k] = total
                k += axes
            apart += 8
        p += 1
    while rounds > 0:
        rounds -= 1
        changed = 0
        p = 0
        base = 0
        while p < 9:
            value = int(amounts[p]) - 65536
            total = ((int(side[p]) - 1048576) << 8) + int(gram[base + p]) * value
            i = 0
            while i < 9:
                total -= int(gram[base + i]) * (int(amounts[i]) - 65536)
                i += 1
            total = total // (int(gram[base + p]) + 1)
            if total > 1023:
                total = 1023
            if total < 0 - 1023:
                total = 0 - 1023
            if total != value:
                changed = 1
                amounts[p] = total + 65536
            base += 9
            p += 1
        if changed == 0:
            rounds = 0
    p = 0
    while p < 8:
        value = int(amounts[p])
        below = 0
        equal = 0
        i = 0
        while i < 8:
            # of 0, 1, 3, 5, 7
            if i == 0 or i & 1:
                if int(amounts[i]) < value:
                    below += 1
                elif int(amounts[i]) == value:
                    equal += 1
            i += 1
        if (p == 0 or p & 1) and below <= 2 and 2 < below + equal:
            amounts[9] = value
        p += 1
    return 0


@micropython.viper
def code_residuals(
    ink: ptr16, i: int, value: int, templates: ptr16, axes: int, reach: int, amounts: ptr32, residuals: ptr32
) -> int:  # fmt: skip
    """residuals[p] = the largest mean residual (1/1024) of `fit_code` in the cells around line p = 2, 4, 6.

    A cell has 3 directions in one zone; there are three to a line, beside each other. ink, templates, axes,
    reach and amounts as in `fit_code`. Returns 0."""
    p = 2
    while p < 8:
        worst = 0
        zone = 0
        while zone < 2:
            k = (p << 3) - 4
            cell = 0
            while cell < 3:
                total = 0
                j = k + 3
                while k < j:
                    value = int(ink[(zone << 6) + (k & 63)]) - 32768
                    value -= int(amounts[8]) - 65536
                    # the lines that reach so far
                    q = (k - reach + 7) >> 3
                    last = (k + reach) >> 3
                    while q <= last:
                        i = k - (q << 3)
                        if i < 0:
                            i = 0 - i
                        i = int(templates[((q & (axes - 1)) * 2 + zone) * 33 + i])
                        value -= (int(amounts[q & 7]) - 65536) * i >> 8
                        q += 1
                    total += value
                    k += 1
                total = total // 3
                if total < 0:
                    total = 0 - total
                if total > worst:
                    worst = total
                cell += 1
            zone += 1
        residuals[p] = worst
        p += 2
    return 0
