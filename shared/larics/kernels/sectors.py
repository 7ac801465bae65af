"""The blur-model reader on the rings' 32 sectors: how far they are off, what light falls on them.

Units as in larics.kernels.blur; sector k lies around the direction (k + 1/2) / 32 turn.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr16, ptr32

_STILL = const(32)  # as in kernels.layouts


@micropython.viper
def ring_shifts(
    value: int, i: int, means: ptr16, templates: ptr16, sums: ptr32, motion_axis: int, radius: int,
    limit: int, least_match: int, outer: ptr32, inner: ptr32, sectors: ptr16,
) -> int:  # fmt: skip
    """How far each of 32 sectors' rings lie outside of where they are expected: one Gauss-Newton step.

    motion_axis: direction of motion, 1/32 of half a turn, or STILL; radius: 1/256 px; limit: largest shift
    that counts, 1/1024 unit; least_match: smallest squared correlation (1/1024) that counts; means, templates
    and sums as in blur.match_sectors. outer, inner: the two rings' shifts (1/1024 px) + 2**20, 0 where they
    do not count. sectors: 32 amplitudes (1/16 grey level), backgrounds, squared correlations. Returns the
    number of sectors that match."""
    good = 0
    sector = 0
    while sector < 32:
        rel = 0
        if motion_axis < _STILL:
            rel = (1 + sector + sector - motion_axis) & 31
            if rel > 16:
                rel = 32 - rel
        slot = rel * 48
        sum_slot = rel << 3
        power = 16
        product = 0
        i = sector << 4
        end = i + 16
        while i - end:
            value = int(means[i]) - 32768
            power += value * value
            product -= value * (int(templates[slot]) - 32768)
            value = int(means[i + 1]) - 32768
            power += value * value
            product -= value * (int(templates[slot + 1]) - 32768)
            slot += 2
            i += 2
        amplitude = 0
        match = 0
        if product > 0:
            amplitude = (product << 4) // ((int(sums[sum_slot]) >> 6) + 1)
            if power < 1048576:
                match = amplitude * ((product << 7) // ((power >> 6) + 1)) >> 13
            else:
                match = amplitude * ((product << 3) // ((power >> 10) + 1)) >> 13
            if match > 1024:
                match = 1024
        if amplitude > 16383:
            amplitude = 16383
        sectors[sector] = amplitude
        sectors[32 + sector] = int(means[512 + sector]) + (amplitude * int(sums[sum_slot + 4]) >> 10)
        sectors[64 + sector] = match
        shift_outer = 0
        shift_inner = 0
        counts = 0
        if match >= least_match and amplitude > 3:
            good += 1
            counts = 1
            from_outer = 0
            from_inner = 0
            slot -= 16
            i -= 16
            while i - end:
                value = int(means[i]) - 32768 + (amplitude * (int(templates[slot]) - 32768) >> 10)
                value = (value << 10) // amplitude
                if (value + 1024) >> 11:
                    value = 1024 - ((value >> 31) & 2048)
                from_outer += value * (int(templates[slot + 16]) - 32768)
                from_inner += value * (int(templates[slot + 32]) - 32768)
                slot += 1
                i += 1
            own = int(sums[sum_slot + 1])
            other = int(sums[sum_slot + 2])
            both = int(sums[sum_slot + 3]) - 268435456
            if own > 131071 or other > 131071:
                own = own >> 8
                other = other >> 8
                both = both >> 8
                from_outer = from_outer >> 8
                from_inner = from_inner >> 8
            else:
                own = own >> 4
                other = other >> 4
                both = both >> 4
                from_outer = from_outer >> 4
                from_inner = from_inner >> 4
            value = own * 4
            if from_outer > value:
                from_outer = value
            if from_outer < 0 - value:
                from_outer = 0 - value
            value = other * 4
            if from_inner > value:
                from_inner = value
            if from_inner < 0 - value:
                from_inner = 0 - value
            value = ((own * other - both * both) >> 10) + 1
            shift_outer = (from_outer * other - from_inner * both) // value
            shift_inner = (from_inner * own - from_outer * both) // value
        outer[sector] = 0
        inner[sector] = 0
        if counts:
            if shift_outer < limit and 0 - limit < shift_outer:
                outer[sector] = ((shift_outer * (radius // 24)) >> 8) + 1048576
            if shift_inner < limit and 0 - limit < shift_inner:
                inner[sector] = ((shift_inner * (radius // 24)) >> 8) + 1048576
        sector += 1
    return good


@micropython.viper
def shift_harmonics(
    other: int, angle: int, shifts: ptr32, cosines: ptr16, rounds: int, floor: int, result: ptr32
) -> int:
    """Harmonics 0..2 of 32 sectors' shifts, with outliers left out.

    shifts: 1/1024 px + 2**20, 0 where there is none; those farther from the harmonics than `floor` and four
    times the mean deviation, or than 128 px, are left out; projection repeated at most `rounds` times (1..8)
    makes up for the gaps. cosines: tables.COSINE_Q14_BIASED. result: constant, cos, sin, cos 2, sin 2 (+
    2**20 each), mean deviation (all 1/1024 px), shifts used. Returns the number of shifts used."""
    a0 = 0
    a1 = 0
    b1 = 0
    a2 = 0
    b2 = 0
    limit = 1 << 17
    deviation = 0
    used = 0
    settled = 0
    while rounds > 0:
        rounds -= 1
        used = 0
        deviation = 0
        s0 = 0
        sa1 = 0
        sb1 = 0
        sa2 = 0
        sb2 = 0
        i = 0
        angle = 4
        while i < 16:
            value = int(shifts[i])
            other = int(shifts[i + 16])
            if value + other > 0:
                # two opposite sectors have the even harmonics in common
                ca1 = (int(cosines[angle]) - 32768) >> 7
                cb1 = (32768 - int(cosines[angle + 64])) >> 7
                double = (angle + angle) & 255
                ca2 = (int(cosines[double]) - 32768) >> 7
                cb2 = (32768 - int(cosines[double + 64])) >> 7
                odd = a1 * ca1 + b1 * cb1
                even = a2 * ca2 + b2 * cb2
                whole = 0
                difference = 0
                if value > 0:
                    value = value - 1048576 - a0 - ((even + odd) >> 7)
                    whole = value
                    if value >> 31:
                        value = 0 - value
                    if value < limit:
                        used += 1
                        difference = whole
                        deviation += value
                    else:
                        whole = 0
                if other > 0:
                    other = other - 1048576 - a0 - ((even - odd) >> 7)
                    value = other
                    if value >> 31:
                        value = 0 - value
                    if value < limit:
                        used += 1
                        whole += other
                        difference -= other
                        deviation += value
                s0 += whole
                sa1 += difference * ca1
                sb1 += difference * cb1
                sa2 += whole * ca2
                sb2 += whole * cb2
            i += 1
            angle += 8
        if used > 0:
            s0 = s0 // used
            value = used << 6
            sa1 = sa1 // value
            sb1 = sb1 // value
            sa2 = sa2 // value
            sb2 = sb2 // value
            a0 += s0
            a1 += sa1
            b1 += sb1
            a2 += sa2
            b2 += sb2
            deviation = deviation // used
            # twice in a row without a change that matters
            value = (s0 ^ s0 >> 31) | (sa1 ^ sa1 >> 31) | (sb1 ^ sb1 >> 31) | (sa2 ^ sa2 >> 31)
            if (value | (sb2 ^ sb2 >> 31)) > 3:
                settled = 0
            else:
                settled += 1
                if settled == 2:
                    rounds = 0
        # a few sectors side by side may drive the harmonics apart: 128 px bound what they add up to
        limit = deviation * 4
        if limit < floor:
            limit = floor
        if limit > 131072:
            limit = 131072
    result[0] = a0 + 1048576
    result[1] = a1 + 1048576
    result[2] = b1 + 1048576
    result[3] = a2 + 1048576
    result[4] = b2 + 1048576
    result[5] = deviation
    result[6] = used
    return used


@micropython.viper
def median(values: ptr16, i: int, j: int, first: int, count: int, sorted_values: ptr16) -> int:
    """The median (the upper one of two) of `count` values from entry `first` on; sorted_values: scratch."""
    i = 0
    while i < count:
        value = int(values[first + i])
        j = i - 1
        while j >= 0 and int(sorted_values[j]) > value:
            sorted_values[j + 1] = int(sorted_values[j])
            j -= 1
        sorted_values[j + 1] = value
        i += 1
    return int(sorted_values[count >> 1])


@micropython.viper
def sector_levels(
    sectors: ptr16,
    i: int,
    sector: int,
    amplitude: int,
    background: int,
    least_match: int,
    wide: int,
    local: int,
    levels: ptr16,
) -> int:
    """levels: for each of 32 sectors the rings' amplitude, then their background, among its neighbours.

    sectors: as from ring_shifts. Of the sectors up to `wide` away those count that match and have 2/5 to
    twice `amplitude`; when fewer than half do, or if not `local`, amplitude and background stand in. Returns
    the number of sectors that count."""
    good = 0
    of_amplitude = 0
    of_background = 0
    counted = 0
    sector = 0 - wide - wide
    while sector < 32:
        # the window ahead of this sector gains one and loses one
        i = (sector + wide) & 31
        value = int(sectors[i])
        if int(sectors[64 + i]) >= least_match and value * 5 >= amplitude * 2 and value <= amplitude * 2:
            of_amplitude += value
            of_background += int(sectors[32 + i])
            counted += 1
            if sector >= 0 - wide and sector < 32 - wide:
                good += 1
        if sector > 0:
            i = (sector + 31 - wide) & 31
            value = int(sectors[i])
            if int(sectors[64 + i]) >= least_match and value * 5 >= amplitude * 2 and value <= amplitude * 2:
                of_amplitude -= value
                of_background -= int(sectors[32 + i])
                counted -= 1
        if sector >= 0:
            if counted <= wide or local == 0:
                levels[sector] = amplitude
                levels[32 + sector] = background
            else:
                levels[sector] = of_amplitude // counted
                levels[32 + sector] = of_background // counted
        sector += 1
    return good
