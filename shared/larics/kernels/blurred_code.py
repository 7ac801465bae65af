"""The second opinion on the code: eight blurred lines inside the inner ring, fitted jointly.

Units as in larics.kernels.blur.
"""

try:
    import micropython
except ImportError:
    from larics._cpython import micropython, ptr16, ptr32


@micropython.viper
def fit_code(
    ink: ptr16, i: int, value: int, templates: ptr16, reach: int, gram: ptr32, side: ptr32, amounts: ptr32,
    rounds: int,
) -> int:  # fmt: skip
    """Eight lines' depths and a constant in two zones of 64 directions, jointly by least squares.

    ink: 2 * 64 items (zone, direction), line p in direction 8 p; templates: for each of the 4 axes p & 3, for
    each zone, 33 items for 0..32 directions from the line, 0 beyond `reach` (1..32). gram: 81 items, side: 9
    items, scratch space; rounds: of Gauss and Seidel's method. amounts: depths (1/256) + 65536 of 8 lines,
    then the constant in units of 256/1024. Returns 0."""
    p = 0
    while p < 8:
        q = p
        while q < 8:
            gram[p * 9 + q] = 0
            q += 1
        base = (p & 3) * 66
        alone = 0
        total = 0
        k = 0 - reach
        while k < reach:
            i = k
            if i < 0:
                i = 0 - i
            near = int(templates[base + i])
            far = int(templates[base + 33 + i])
            alone += near + far
            i = ((p << 3) + k) & 63
            value = int(ink[i]) - 32768
            if value > 2047:
                value = 2047
            if value < 0 - 2047:
                value = 0 - 2047
            total += near * value
            value = int(ink[64 + i]) - 32768
            if value > 2047:
                value = 2047
            if value < 0 - 2047:
                value = 0 - 2047
            total += far * value
            q = p
            while q < 8:
                i = (k + ((p - q) << 3)) & 63
                if i > 32:
                    i = 64 - i
                if i <= reach:
                    i = (q & 3) * 66 + i
                    gram[p * 9 + q] = int(gram[p * 9 + q]) + (
                        (near * int(templates[i]) + far * int(templates[i + 33])) >> 4
                    )
                q += 1
            k += 1
        q = p
        while q < 8:
            value = int(gram[p * 9 + q]) >> 6
            gram[p * 9 + q] = value
            gram[q * 9 + p] = value
            q += 1
        gram[p * 9 + 8] = alone >> 2
        gram[72 + p] = alone >> 2
        side[p] = (total >> 10) + 1048576
        amounts[p] = 65536
        p += 1
    gram[80] = 8192
    total = 0
    i = 0
    while i < 128:
        value = int(ink[i]) - 32768
        if value > 2047:
            value = 2047
        if value < 0 - 2047:
            value = 0 - 2047
        total += value
        i += 1
    side[8] = (total >> 2) + 1048576
    amounts[8] = 65536
    while rounds > 0:
        rounds -= 1
        p = 0
        while p < 9:
            total = (int(side[p]) - 1048576) << 8
            q = 0
            while q < 9:
                if q != p:
                    total -= int(gram[p * 9 + q]) * (int(amounts[q]) - 65536)
                q += 1
            total = total // (int(gram[p * 10]) + 1)
            if total > 1023:
                total = 1023
            if total < 0 - 1023:
                total = 0 - 1023
            amounts[p] = total + 65536
            p += 1
    return 0


@micropython.viper
def code_residuals(
    ink: ptr16, i: int, value: int, templates: ptr16, reach: int, amounts: ptr32, residuals: ptr32
) -> int:
    """residuals[p] = the largest mean residual (1/1024) of `fit_code` in the cells around line p = 2, 4, 6.

    A cell has 3 directions in one zone; there are three to a line, beside each other. ink, templates, reach
    and amounts as in `fit_code`. Returns 0."""
    p = 2
    while p < 8:
        worst = 0
        zone = 0
        while zone < 2:
            cell = 0 - 3
            while cell < 4:
                total = 0
                j = cell - 1
                while j < cell + 2:
                    k = ((p << 3) + j + 64) & 63
                    value = int(ink[(zone << 6) + k]) - 32768
                    value -= int(amounts[8]) - 65536
                    q = 0
                    while q < 8:
                        i = (k + 64 - (q << 3)) & 63
                        if i > 32:
                            i = 64 - i
                        if i <= reach:
                            i = int(templates[((q & 3) * 2 + zone) * 33 + i])
                            value -= (int(amounts[q]) - 65536) * i >> 8
                        q += 1
                    total += value
                    j += 1
                total = total // 3
                if total < 0:
                    total = 0 - total
                if total > worst:
                    worst = total
                cell += 3
            zone += 1
        residuals[p] = worst
        p += 2
    return 0
