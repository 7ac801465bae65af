"""One robust fit of both rings' sectors at once: the steps of an iteratively reweighted least squares.

Eight parameters: the radius that both rings share, how far the inner one departs from its ratio, the mean of
the rings' centres, half the difference of their centres (inner less outer), the ellipse that both share.
Sectors weigh by the square of their depth and by how far they lie from the fit, so that what disturbs a part
of one ring does not move the other. Angles and sectors as in kernels.rings.

All work on one ptr32 array, layouts: ROBUST.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr8, ptr32

_BIAS = const(1 << 24)  # items as in kernels.layouts
_FIT_AREA = const(14)
_ROBUST_SHIFTS = const(0)
_ROBUST_BASES = const(32)
_ROBUST_WEIGHTS = const(64)
_ROBUST_LEFT = const(96)
_ROBUST_PARAMETERS = const(128)
_ROBUST_MATRIX = const(136)
_ROBUST_RIGHT = const(200)
_ROBUST_MOMENTS = const(208)
_ROBUST_SCALE = const(236)
_ROBUST_USED = const(237)
_ROBUST_SQUARE = const(238)

_FLOOR_Q10 = const(8)  # smallest spread that is believed
_CUT = const(5)  # spreads from the fit at which a sector counts nothing
_FARTHEST = const(511)
_PIVOT_LEAST = const(24)  # a pivot smaller than its diagonal by more: the sectors do not determine the fit
_SHARE_MOST = const(30000)  # of a parameter in a variance, 4096 = 1: beyond, nothing is determined
_UNEVEN = const(870)  # of the variance that rings cost which are deep on one side: of their first harmonic,
_ROUGH = const(24)  # and the part of the squared steps between sectors, (1/256 of the depth) ** 2, that costs


@micropython.viper
def begin_robust(work: ptr32, fit: ptr32, outer_means: ptr32, inner_means: ptr32) -> int:
    """Takes the sectors' means as `ring_harmonics` left them; returns how many have one, of 32."""
    area = int(fit[_FIT_AREA])
    if area < 1:
        area = 1
    seen = 0
    i = 0
    while i < 32:
        if i < 16:
            shift = int(outer_means[i])
            depth = int(outer_means[16 + i])
        else:
            shift = int(inner_means[i - 16])
            depth = int(inner_means[i])
        weight = 0
        if shift > 0:
            seen += 1
            if depth > area:
                depth = area
            weight = (depth << 6) // area
            weight = (weight * weight) >> 6
            if weight < 1:
                weight = 1
        work[_ROBUST_SHIFTS + i] = shift
        work[_ROBUST_BASES + i] = weight
        work[_ROBUST_WEIGHTS + i] = weight
        i += 1
    i = 0
    while i < 8:
        work[_ROBUST_PARAMETERS + i] = _BIAS
        i += 1
    work[_ROBUST_SCALE] = 50
    return seen


@micropython.viper
def weigh_sectors(i: int, shift: int, product: int, work: ptr32, waves: ptr8, ratio: int, turn: int) -> int:
    """What the fit leaves of each sector, the sectors' new weights, and the sums that the next step needs.

    waves: tables.SECTOR_WAVES; ratio: of the radii, 1/1024; turn: 0 for weights by depth alone, 1 for weights
    that fall with the distance, too, 2 for weights that vanish. Returns their sum, 64 a full sector."""
    radius = int(work[_ROBUST_PARAMETERS]) - _BIAS
    departs = int(work[_ROBUST_PARAMETERS + 1]) - _BIAS
    seen = 0
    ring = 0
    while ring < 2:
        a0 = radius
        a1 = int(work[_ROBUST_PARAMETERS + 2]) - int(work[_ROBUST_PARAMETERS + 4])
        b1 = int(work[_ROBUST_PARAMETERS + 3]) - int(work[_ROBUST_PARAMETERS + 5])
        a2 = int(work[_ROBUST_PARAMETERS + 6]) - _BIAS
        b2 = int(work[_ROBUST_PARAMETERS + 7]) - _BIAS
        if ring:
            a0 = ((radius * ratio) >> 10) + departs
            a1 = int(work[_ROBUST_PARAMETERS + 2]) + int(work[_ROBUST_PARAMETERS + 4]) - _BIAS - _BIAS
            b1 = int(work[_ROBUST_PARAMETERS + 3]) + int(work[_ROBUST_PARAMETERS + 5]) - _BIAS - _BIAS
            a2 = (a2 * ratio) >> 10
            b2 = (b2 * ratio) >> 10
        a0 = a0 - a1 - b1 - a2 - b2 + 8  # the waves' 128 is 0
        i = ring << 4
        end = i + 16
        wave = 0
        while i < end:
            shift = int(work[_ROBUST_SHIFTS + i])
            left = 0
            if shift > 0:
                product = a1 * int(waves[wave]) + b1 * int(waves[wave + 1])
                product += a2 * int(waves[wave + 2]) + b2 * int(waves[wave + 3])
                left = shift - 32768 - ((a0 + (product >> 7)) >> 4)
                if left > _FARTHEST:
                    left = _FARTHEST
                if left < 0 - _FARTHEST:
                    left = 0 - _FARTHEST
                if turn:
                    product = left
                    if product >> 31:
                        product = 0 - product
                    work[_ROBUST_RIGHT + seen] = product
                    seen += 1
            work[_ROBUST_LEFT + i] = left + _BIAS
            wave += 8
            i += 1
        ring += 1
    if turn:
        # the median of what is left, by halving; it seldom exceeds 15
        low = 0
        high = 511
        middle = 15
        while low < high:
            within = 0
            i = 0
            while i < seen:
                if int(work[_ROBUST_RIGHT + i]) <= middle:
                    within += 2
                i += 1
            if within >= seen:
                high = middle
            else:
                low = middle + 1
            middle = (low + high) >> 1
        scale = (low * 1746) >> 10
        if scale < _FLOOR_Q10:
            scale = _FLOOR_Q10
        work[_ROBUST_SCALE] = scale
        scale = scale * _CUT
        i = 0
        while i < 32:
            weight = int(work[_ROBUST_BASES + i])
            if weight > 0:
                left = int(work[_ROBUST_LEFT + i]) - _BIAS
                if left >> 31:
                    left = 0 - left
                left = (left << 8) // scale
                if turn > 1:
                    product = 0
                    if left < 256:
                        product = 256 - ((left * left) >> 8)
                    weight = (weight * product * product + 32768) >> 16
                elif left > 64:
                    weight = (weight << 6) // left
                work[_ROBUST_WEIGHTS + i] = weight
            i += 1
    used = 0
    square = 0
    ring = 0
    while ring < 2:
        c0 = 0
        c1 = 0
        s1 = 0
        c2 = 0
        s2 = 0
        c3 = 0
        s3 = 0
        c4 = 0
        s4 = 0
        r0 = 0
        rc = 0
        rs = 0
        rc2 = 0
        rs2 = 0
        odd = 0
        odd_left = 0
        # of sectors half a turn apart the odd waves are opposite and the even ones equal
        i = ring << 4
        end = i + 8
        wave = 0
        while i < end:
            weight = int(work[_ROBUST_WEIGHTS + i])
            left = int(work[_ROBUST_LEFT + i]) - _BIAS
            product = weight * left
            square += (product * left) >> 6
            shift = int(work[_ROBUST_WEIGHTS + 8 + i])
            left = int(work[_ROBUST_LEFT + 8 + i]) - _BIAS
            apart = product
            product = shift * left
            square += (product * left) >> 6
            c0 += weight + shift
            odd += shift
            both = weight + shift
            weight -= shift
            r0 += apart + product
            odd_left += product
            left = apart + product
            apart -= product
            shift = int(waves[wave])
            c1 += weight * shift
            rc += apart * shift
            shift = int(waves[wave + 1])
            s1 += weight * shift
            rs += apart * shift
            shift = int(waves[wave + 2])
            c2 += both * shift
            rc2 += left * shift
            shift = int(waves[wave + 3])
            s2 += both * shift
            rs2 += left * shift
            c3 += weight * int(waves[wave + 4])
            s3 += weight * int(waves[wave + 5])
            c4 += both * int(waves[wave + 6])
            s4 += both * int(waves[wave + 7])
            wave += 8
            i += 1
        odd = odd << 8
        odd_left = odd_left << 8
        c1 += odd
        s1 += odd
        c3 += odd
        s3 += odd
        rc += odd_left
        rs += odd_left
        used += c0
        i = _ROBUST_MOMENTS + ring * 14
        shift = c0 << 7  # the waves' 128 is 0
        product = r0 << 7
        work[i] = (c0 << 2) + _BIAS
        work[i + 1] = ((c1 - shift) >> 5) + _BIAS
        work[i + 2] = ((s1 - shift) >> 5) + _BIAS
        work[i + 3] = ((c2 - shift) >> 5) + _BIAS
        work[i + 4] = ((s2 - shift) >> 5) + _BIAS
        work[i + 5] = ((c3 - shift) >> 5) + _BIAS
        work[i + 6] = ((s3 - shift) >> 5) + _BIAS
        work[i + 7] = ((c4 - shift) >> 5) + _BIAS
        work[i + 8] = ((s4 - shift) >> 5) + _BIAS
        work[i + 9] = (r0 >> 5) + _BIAS
        work[i + 10] = ((rc - product) >> 12) + _BIAS
        work[i + 11] = ((rs - product) >> 12) + _BIAS
        work[i + 12] = ((rc2 - product) >> 12) + _BIAS
        work[i + 13] = ((rs2 - product) >> 12) + _BIAS
        ring += 1
    work[_ROBUST_USED] = used
    work[_ROBUST_SQUARE] = square
    return used


@micropython.viper
def normal_equations(work: ptr32, i: int, slot: int, ratio: int, ratio_weight: int, apart_weight: int) -> int:
    """The matrix (256 = one full sector) and the right hand side of the next step, from the sums.

    ratio_weight, apart_weight: how sure it is, on the same scale, that the inner radius keeps its ratio and
    that the rings' centres are one. Always 1."""
    square = (ratio * ratio) >> 10
    # sums of products of two harmonics, outer then inner
    oc = int(work[_ROBUST_MOMENTS]) - _BIAS
    ic = int(work[_ROBUST_MOMENTS + 14]) - _BIAS
    work[_ROBUST_MATRIX] = oc + ((square * ic) >> 10) + _BIAS
    work[_ROBUST_MATRIX + 8] = ((ratio * ic) >> 10) + _BIAS
    work[_ROBUST_MATRIX + 9] = ic + ratio_weight + _BIAS
    i = 0
    while i < 2:
        # centre along x, then y: against the radii
        slot = int(work[_ROBUST_MOMENTS + 1 + i]) - _BIAS
        turned = int(work[_ROBUST_MOMENTS + 15 + i]) - _BIAS
        work[_ROBUST_MATRIX + 16 + (i << 3)] = slot + ((ratio * turned) >> 10) + _BIAS
        work[_ROBUST_MATRIX + 17 + (i << 3)] = turned + _BIAS
        work[_ROBUST_MATRIX + 32 + (i << 3)] = ((ratio * turned) >> 10) - slot + _BIAS
        work[_ROBUST_MATRIX + 33 + (i << 3)] = turned + _BIAS
        # ellipse against the radii
        slot = int(work[_ROBUST_MOMENTS + 3 + i]) - _BIAS
        turned = int(work[_ROBUST_MOMENTS + 17 + i]) - _BIAS
        work[_ROBUST_MATRIX + 48 + (i << 3)] = slot + ((square * turned) >> 10) + _BIAS
        work[_ROBUST_MATRIX + 49 + (i << 3)] = ((ratio * turned) >> 10) + _BIAS
        i += 1
    o2 = int(work[_ROBUST_MOMENTS + 3]) - _BIAS
    i2 = int(work[_ROBUST_MOMENTS + 17]) - _BIAS
    # cos cos, cos sin, sin sin
    ocs = (int(work[_ROBUST_MOMENTS + 4]) - _BIAS) >> 1
    ics = (int(work[_ROBUST_MOMENTS + 18]) - _BIAS) >> 1
    slot = (oc + o2) >> 1
    turned = (ic + i2) >> 1
    work[_ROBUST_MATRIX + 18] = slot + turned + _BIAS
    work[_ROBUST_MATRIX + 34] = turned - slot + _BIAS
    work[_ROBUST_MATRIX + 36] = slot + turned + apart_weight + _BIAS
    work[_ROBUST_MATRIX + 26] = ocs + ics + _BIAS
    work[_ROBUST_MATRIX + 35] = ics - ocs + _BIAS
    work[_ROBUST_MATRIX + 42] = ics - ocs + _BIAS
    work[_ROBUST_MATRIX + 44] = ocs + ics + _BIAS
    slot = (oc - o2) >> 1
    turned = (ic - i2) >> 1
    work[_ROBUST_MATRIX + 27] = slot + turned + _BIAS
    work[_ROBUST_MATRIX + 43] = turned - slot + _BIAS
    work[_ROBUST_MATRIX + 45] = slot + turned + apart_weight + _BIAS
    # ellipse against the centres: cos cos2, sin cos2, cos sin2, sin sin2
    i = 0
    while i < 4:
        if i == 0:
            slot = int(work[_ROBUST_MOMENTS + 1]) + int(work[_ROBUST_MOMENTS + 5]) - _BIAS - _BIAS
            turned = int(work[_ROBUST_MOMENTS + 15]) + int(work[_ROBUST_MOMENTS + 19]) - _BIAS - _BIAS
        elif i == 1:
            slot = int(work[_ROBUST_MOMENTS + 6]) - int(work[_ROBUST_MOMENTS + 2])
            turned = int(work[_ROBUST_MOMENTS + 20]) - int(work[_ROBUST_MOMENTS + 16])
        elif i == 2:
            slot = int(work[_ROBUST_MOMENTS + 2]) + int(work[_ROBUST_MOMENTS + 6]) - _BIAS - _BIAS
            turned = int(work[_ROBUST_MOMENTS + 16]) + int(work[_ROBUST_MOMENTS + 20]) - _BIAS - _BIAS
        else:
            slot = int(work[_ROBUST_MOMENTS + 1]) - int(work[_ROBUST_MOMENTS + 5])
            turned = int(work[_ROBUST_MOMENTS + 15]) - int(work[_ROBUST_MOMENTS + 19])
        slot = slot >> 1
        turned = (ratio * turned) >> 11
        o2 = _ROBUST_MATRIX + 50 + (i & 1) + ((i >> 1) << 3)
        work[o2] = slot + turned + _BIAS
        work[o2 + 2] = turned - slot + _BIAS
        i += 1
    slot = int(work[_ROBUST_MOMENTS + 7]) - _BIAS
    turned = int(work[_ROBUST_MOMENTS + 21]) - _BIAS
    work[_ROBUST_MATRIX + 54] = ((oc + slot) >> 1) + ((square * (ic + turned)) >> 11) + _BIAS
    work[_ROBUST_MATRIX + 63] = ((oc - slot) >> 1) + ((square * (ic - turned)) >> 11) + _BIAS
    slot = int(work[_ROBUST_MOMENTS + 8]) - _BIAS
    turned = int(work[_ROBUST_MOMENTS + 22]) - _BIAS
    work[_ROBUST_MATRIX + 62] = (slot >> 1) + ((square * turned) >> 11) + _BIAS
    # right hand side
    slot = int(work[_ROBUST_MOMENTS + 9]) - _BIAS
    turned = int(work[_ROBUST_MOMENTS + 23]) - _BIAS
    work[_ROBUST_RIGHT] = slot + ((ratio * turned) >> 10) + _BIAS
    # in proportion: 2 of 256 a sector, parameters in 16ths
    work[_ROBUST_RIGHT + 1] = (
        turned - ((ratio_weight * ((int(work[_ROBUST_PARAMETERS + 1]) - _BIAS) >> 4)) >> 7) + _BIAS
    )
    i = 0
    while i < 2:
        slot = int(work[_ROBUST_MOMENTS + 10 + i]) - _BIAS
        turned = int(work[_ROBUST_MOMENTS + 24 + i]) - _BIAS
        work[_ROBUST_RIGHT + 2 + i] = slot + turned + _BIAS
        o2 = (apart_weight * ((int(work[_ROBUST_PARAMETERS + 4 + i]) - _BIAS) >> 4)) >> 7
        work[_ROBUST_RIGHT + 4 + i] = turned - slot - o2 + _BIAS
        slot = int(work[_ROBUST_MOMENTS + 12 + i]) - _BIAS
        turned = int(work[_ROBUST_MOMENTS + 26 + i]) - _BIAS
        work[_ROBUST_RIGHT + 6 + i] = slot + ((ratio * turned) >> 10) + _BIAS
        i += 1
    return 1


@micropython.viper
def factor_matrix(k: int, column: int, row: int, work: ptr32) -> int:
    """The matrix in place into unit triangle and pivots; 0 when the sectors do not determine the fit."""
    row = 0
    while row < 8:
        base = _ROBUST_MATRIX + (row << 3)
        diagonal = int(work[base + row]) - _BIAS
        pivot = diagonal
        column = 0
        while column < row:
            # products of the row with its pivots so far stand left of `column`
            other = _ROBUST_MATRIX + (column << 3)
            value = int(work[base + column]) - _BIAS
            k = 0
            while k < column:
                value -= ((int(work[other + k]) - _BIAS) * (int(work[base + k]) - _BIAS)) >> 12
                k += 1
            work[base + column] = value + _BIAS
            column += 1
        column = 0
        while column < row:
            value = int(work[base + column]) - _BIAS
            k = (value << 12) // (int(work[_ROBUST_MATRIX + column * 9]) - _BIAS)
            pivot -= (k * value) >> 12
            work[base + column] = k + _BIAS
            column += 1
        if pivot * _PIVOT_LEAST <= diagonal or pivot < 32:
            return 0
        work[base + row] = pivot + _BIAS
        row += 1
    return 1


@micropython.viper
def solve_step(row: int, k: int, value: int, work: ptr32) -> int:
    """Moves the parameters by the solution; returns the largest move, 1/16384 px."""
    row = 0
    while row < 8:
        value = int(work[_ROBUST_RIGHT + row]) - _BIAS
        k = 0
        while k < row:
            value -= (
                (int(work[_ROBUST_MATRIX + (row << 3) + k]) - _BIAS) * (int(work[_ROBUST_RIGHT + k]) - _BIAS)
            ) >> 12
            k += 1
        work[_ROBUST_RIGHT + row] = value + _BIAS
        row += 1
    most = 0
    while row > 0:
        row -= 1
        value = ((int(work[_ROBUST_RIGHT + row]) - _BIAS) << 11) // (
            int(work[_ROBUST_MATRIX + row * 9]) - _BIAS
        )
        k = row + 1
        while k < 8:
            value -= (
                (int(work[_ROBUST_MATRIX + (k << 3) + row]) - _BIAS) * (int(work[_ROBUST_RIGHT + k]) - _BIAS)
            ) >> 12
            k += 1
        if value > 8192:
            value = 8192
        if value < 0 - 8192:
            value = 0 - 8192
        work[_ROBUST_RIGHT + row] = value + _BIAS
        work[_ROBUST_PARAMETERS + row] = int(work[_ROBUST_PARAMETERS + row]) + value
        if value < 0:
            value = 0 - value
        if value > most:
            most = value
    return most


@micropython.viper
def variance_of(row: int, k: int, value: int, work: ptr32, first: int, beyond: int) -> int:
    """Variance of parameter `first` + beyond/128 of the one two further on, 4096 = as a full sector's.

    The matrix as `factor_matrix` left it."""
    row = 0
    sum = 0
    while row < 8:
        value = 0
        if row == first:
            value = 4096
        if row == first + 2:
            value = beyond << 5
        k = 0
        while k < row:
            value -= (
                (int(work[_ROBUST_MATRIX + (row << 3) + k]) - _BIAS) * (int(work[_ROBUST_RIGHT + k]) - _BIAS)
            ) >> 12
            k += 1
        if value > _SHARE_MOST:
            value = _SHARE_MOST
        if value < 0 - _SHARE_MOST:
            value = 0 - _SHARE_MOST
        work[_ROBUST_RIGHT + row] = value + _BIAS
        sum += ((value * value) >> 12) * 256 // (int(work[_ROBUST_MATRIX + row * 9]) - _BIAS)
        row += 1
    return sum


@micropython.viper
def uneven_depths(
    i: int, value: int, along: int, waves: ptr8, area: int, outer_means: ptr32, inner_means: ptr32
) -> int:
    """How unevenly deep the rings are: variance of the centre to be expected of it, (1/1024 px) ** 2.

    Blur that differs from side to side moves the two rings apart, and a depth that jumps from sector to
    sector tells of something that lies over them; what either costs was measured. area: the rings' mean."""
    uneven = 0
    rough = 0
    pairs = 0
    last = 0
    ring = 0
    while ring < 2:
        along = 0
        across = 0
        i = 0
        angle = 1
        while i < 16:
            value = int(outer_means[16 + i])
            if ring:
                value = int(inner_means[16 + i])
            if value > 0:
                value = (value << 8) // area
                if value > 1023:
                    value = 1023
                along += value * (int(waves[angle]) - 128)
                across += value * (int(waves[(angle + 24) & 31]) - 128)
                if last > 0:
                    last -= value
                    rough += last * last
                    pairs += 1
            last = value
            angle += 2
            i += 1
        last = 0
        along = along >> 7
        across = across >> 7
        if along > 4095 or along < 0 - 4095:
            along = 4095
        if across > 4095 or across < 0 - 4095:
            across = 4095
        uneven += ((along * along) >> 8) + ((across * across) >> 8)
        ring += 1
    if pairs < 1:
        pairs = 1
    return ((uneven * _UNEVEN) >> 14) + (rough // pairs) // _ROUGH


@micropython.viper
def root(value: int, bit: int, found: int) -> int:
    """Floor of the square root of 0 <= value < 2**30."""
    found = 0
    bit = 268435456
    while bit > value:
        bit = bit >> 2
    while bit > 0:
        if value >= found + bit:
            value -= found + bit
            found = (found >> 1) + bit
        else:
            found = found >> 1
        bit = bit >> 2
    return found
