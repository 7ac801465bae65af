"""The blur-model reader's model of blur: what a line and the two rings look like through it.

Lengths along a radius are in units of 1/24 of the outer radius: the outer ring lies at 24, the inner one at
16, and the rings are looked at from 13 to 28. `rel` is an angle from the direction of motion in 1/32 of half
a turn, folded to 0..16. Angles are clockwise from x, as y points down. Greys are in 1/16 levels, darkness is
in 1/1024 of that of a wide line.

Both rings together are symmetric about the unit 20: while the blur is searched for, the units at the same
distance from it are added up, which makes 9 items of 16.

Bars, templates and sums are made for some rels at once: for rel, rel + step, ... up to 16.
"""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr16, ptr32

_RELS = const(17)  # as in kernels.layouts
_BAR = const(24)
_STILL = const(32)


@micropython.viper
def blurred_bars(
    x: int, distance: int, ramp: ptr16, width: int, motion: int, sigma: int, cosines: ptr16, rel: int,
    step: int, count: int, slot: int, bars: ptr16,
) -> int:  # fmt: skip
    """bars[slot + d] = darkness (1/1024) at d units from the middle of a line, d = 0..count - 1.

    For `rel` and a motion at right angles to the line; those for the next rels follow at slot + 24 step, ...
    width (of the line) and motion 1..16384, sigma 16..4096, all in 1/256 unit; a motion across the line below
    one unit counts as one. ramp: tables.RAMP_Q12, the gaussian's distribution integrated once: its second
    difference over width and motion is the blurred line. cosines: tables.COSINE_Q14_BIASED. Returns 0."""
    inverse = (1 << 26) // sigma
    reach = sigma * 3
    while rel < _RELS:
        across = motion * (int(cosines[rel << 2]) - 32768) >> 14
        if across < 256:
            across = 256
        narrow = width - across
        if narrow < 0:
            narrow = 0 - narrow
        narrow = narrow >> 1
        wide = (width + across) >> 1
        scale = (1 << 24) // across
        distance = 0
        i = slot
        last = slot + count
        while i < last:
            total = 0
            if distance - wide < reach:
                # four terms of the second difference: each is a ramp, rounded off around its foot
                x = distance + wide
                if x < reach:
                    x = x * inverse >> 16
                    part = int(ramp[x >> 5])
                    total += (part - (x << 2) << 5) + (int(ramp[(x >> 5) + 1]) - part) * (x & 31)
                x = distance + narrow
                if x < reach:
                    x = x * inverse >> 16
                    part = int(ramp[x >> 5])
                    total -= (part - (x << 2) << 5) + (int(ramp[(x >> 5) + 1]) - part) * (x & 31)
                feet = wide - narrow
                x = distance - narrow
                if x > 0:
                    feet -= x
                else:
                    x = 0 - x
                if x < reach:
                    x = x * inverse >> 16
                    part = int(ramp[x >> 5])
                    total -= (part - (x << 2) << 5) + (int(ramp[(x >> 5) + 1]) - part) * (x & 31)
                x = distance - wide
                if x > 0:
                    feet += x
                else:
                    x = 0 - x
                if x < reach:
                    x = x * inverse >> 16
                    part = int(ramp[x >> 5])
                    total += (part - (x << 2) << 5) + (int(ramp[(x >> 5) + 1]) - part) * (x & 31)
                total = (((total * sigma >> 13) + (feet << 4)) * scale) >> 18
                if total < 0:
                    total = 0
            bars[i] = total
            i += 1
            distance += 256
        slot += step * _BAR
        rel += step
    return 0


@micropython.viper
def ring_templates(
    bars: ptr16, i: int, value: int, rel: int, step: int, templates: ptr16, sums: ptr32
) -> int:
    """What both rings look like at the units 13..28, from lines' profiles.

    bars: 24 items a rel. templates, 48 items a rel: 16 darknesses, 16 derivatives of the outer ring's, 16 of
    the inner ring's, each less their mean + 32768 (1/1024, per unit). sums, 8 items a rel: sums of squares of
    the darkness, of the outer, of the inner derivative, of their product + 2**28, mean darkness.
    Returns 0."""
    while rel < _RELS:
        bar = rel * _BAR
        slot = rel * 48
        kind = 0
        while kind < 3:
            mean = 0
            i = 0
            while i < 16:
                outer = i - 11
                inner = i - 3
                if kind == 0:
                    if outer < 0:
                        outer = 0 - outer
                    if inner < 0:
                        inner = 0 - inner
                    value = int(bars[bar + outer]) + int(bars[bar + inner])
                else:
                    if kind == 2:
                        outer = inner
                    inner = outer - 1
                    outer = outer + 1
                    if outer < 0:
                        outer = 0 - outer
                    if inner < 0:
                        inner = 0 - inner
                    value = (int(bars[bar + outer]) - int(bars[bar + inner])) >> 1
                mean += value
                templates[slot + i] = value + 32768
                i += 1
            rest = mean & 15
            mean = mean >> 4
            square = 0
            i = slot
            while i < slot + 16:
                # the rest is spread over the first items, so that all add up to nothing
                value = int(templates[i]) - mean
                if rest > 0:
                    value -= 1
                    rest -= 1
                templates[i] = value
                value -= 32768
                square += value * value
                i += 1
            sums[(rel << 3) + kind] = square
            if kind == 0:
                sums[(rel << 3) + 4] = mean
            slot += 16
            kind += 1
        square = 1 << 28
        i = slot - 32
        while i < slot - 16:
            square += (int(templates[i]) - 32768) * (int(templates[i + 16]) - 32768)
            i += 1
        sums[(rel << 3) + 3] = square
        rel += step
    return 0


@micropython.viper
def fold_templates(
    bars: ptr16, i: int, value: int, rel: int, step: int, templates: ptr16, sums: ptr32
) -> int:
    """The first 9 items of a rel's template become the darknesses at 0..8 units from the unit 20, unchanged.

    bars, rel, step, templates, sums as in ring_templates. sums: the sum of squares of the darkness less
    its mean, as there; items 5 and 6: the sum of the darknesses at all 16 units, and of those 9 items.
    Returns 0."""
    while rel < _RELS:
        bar = rel * _BAR
        slot = rel * 48
        # in the middle between the rings once, at the unit 28 once, at the others twice
        value = int(bars[bar + 4]) << 1
        templates[slot] = value
        single = value
        square = value * value
        value = int(bars[bar + 4]) + int(bars[bar + 12])
        templates[slot + 8] = value
        single += value
        square += value * value
        double = 0
        i = 1
        while i < 8:
            value = i - 4
            if value < 0:
                value = 0 - value
            value = int(bars[bar + value]) + int(bars[bar + i + 4])
            templates[slot + i] = value
            double += value
            square += value * value << 1
            i += 1
        slot = rel << 3
        value = single + double + double
        sums[slot + 5] = value
        sums[slot + 6] = single + double
        sums[slot] = square - (value * value >> 4)
        rel += step
    return 0


@micropython.viper
def fold_sectors(i: int, k: int, means: ptr16, sectors: int, folds: ptr16, powers: ptr32) -> int:
    """Adds up the sectors 2 s and 2 s + 1, and in them the units at the same distance from the unit 20.

    means: 16 items a sector, as from polar.mean_samples. folds, 10 items for each of `sectors`: 9 such sums
    + 16384, then the sum of all. powers: sum of squares of the two sectors' means, + 16. Returns 0."""
    sector = 0
    while sector < sectors:
        i = sector << 5
        slot = sector * 10
        folds[slot] = int(means[i + 7]) + int(means[i + 23]) - 49152
        folds[slot + 8] = int(means[i + 15]) + int(means[i + 31]) - 49152
        k = 1
        while k < 8:
            value = int(means[i + 7 + k]) + int(means[i + 23 + k]) + int(means[i + 7 - k])
            folds[slot + k] = value + int(means[i + 23 - k]) - 114688
            k += 1
        power = 16
        total = 0
        k = i + 16
        while i < k:
            value = int(means[i]) + int(means[i + 16]) - 65536
            total += value
            value = value >> 1
            power += value * value
            i += 1
        folds[slot + 9] = total
        powers[sector] = power
        sector += 1
    return 0


@micropython.viper
def match_sectors(
    i: int, slot: int, folds: ptr16, templates: ptr16, sectors: int, powers: ptr32, sums: ptr32, rel: int,
    step: int, matches: ptr16,
) -> int:  # fmt: skip
    """matches[rel * sectors + s] = squared correlation (1/1024) of sector s with the template of `rel`.

    0 for rings that are bright; folds and powers as from fold_sectors, templates and sums as from
    fold_templates. Returns 0."""
    while rel < _RELS:
        slot = rel << 3
        square = (int(sums[slot]) >> 6) + 1
        whole = int(sums[slot + 5])
        bias = int(sums[slot + 6]) << 14
        slot = rel * 48
        sector = 0
        i = 0
        while sector < sectors:
            product = bias + (int(folds[i + 9]) * whole >> 4) - (
                int(folds[i]) * int(templates[slot]) + int(folds[i + 1]) * int(templates[slot + 1])
                + int(folds[i + 2]) * int(templates[slot + 2]) + int(folds[i + 3]) * int(templates[slot + 3])
                + int(folds[i + 4]) * int(templates[slot + 4]) + int(folds[i + 5]) * int(templates[slot + 5])
                + int(folds[i + 6]) * int(templates[slot + 6]) + int(folds[i + 7]) * int(templates[slot + 7])
                + int(folds[i + 8]) * int(templates[slot + 8])
            )  # fmt: skip
            product = product >> 1
            value = 0
            if product > 0:
                # amplitude times inverse amplitude
                value = (product << 4) // square
                power = int(powers[sector])
                if power < 1048576:
                    value = value * ((product << 7) // ((power >> 6) + 1)) >> 13
                else:
                    value = value * ((product << 3) // ((power >> 10) + 1)) >> 13
                if value > 1024:
                    value = 1024
            matches[rel * sectors + sector] = value
            i += 10
            sector += 1
        rel += step
    return 0


@micropython.viper
def best_direction(
    value: int, sector: int, matches: ptr16, sectors: int, step: int, offset: int, floor: int, direction: int,
    pitch: int, result: ptr32,
) -> int:  # fmt: skip
    """The direction of motion with the largest sum of matches, of `direction`, + pitch, ... below 32.

    In 1/32 of half a turn; sector s lies at offset + s * step; a match below `floor` counts as floor.
    result: the direction. Returns the sum."""
    best = 0 - 1
    while direction < 32:
        total = 0
        sector = 0
        while sector < sectors:
            # the rel, and its match
            value = (offset + sector * step - direction) & 31
            if value > 16:
                value = 32 - value
            value = int(matches[value * sectors + sector])
            if value < floor:
                value = floor
            total += value
            sector += 1
        if total > best:
            best = total
            result[0] = direction
        direction += pitch
    return best


@micropython.viper
def match_direction(
    folds: ptr16, i: int, slot: int, templates: ptr16, sectors: int, powers: ptr32, sums: ptr32,
    step: int, offset: int, motion_axis: int, floor: int,
) -> int:  # fmt: skip
    """The sum of matches for one direction of motion or for STILL; the rest as of the two before."""
    total = 0
    sector = 0
    i = 0
    while sector < sectors:
        rel = 0
        if motion_axis < _STILL:
            rel = (offset + sector * step - motion_axis) & 31
            if rel > 16:
                rel = 32 - rel
        slot = rel * 48
        sum_slot = rel << 3
        product = (int(sums[sum_slot + 6]) << 14) + (int(folds[i + 9]) * int(sums[sum_slot + 5]) >> 4) - (
            int(folds[i]) * int(templates[slot]) + int(folds[i + 1]) * int(templates[slot + 1])
            + int(folds[i + 2]) * int(templates[slot + 2]) + int(folds[i + 3]) * int(templates[slot + 3])
            + int(folds[i + 4]) * int(templates[slot + 4]) + int(folds[i + 5]) * int(templates[slot + 5])
            + int(folds[i + 6]) * int(templates[slot + 6]) + int(folds[i + 7]) * int(templates[slot + 7])
            + int(folds[i + 8]) * int(templates[slot + 8])
        )  # fmt: skip
        product = product >> 1
        value = 0
        if product > 0:
            value = (product << 4) // ((int(sums[sum_slot]) >> 6) + 1)
            power = int(powers[sector])
            if power < 1048576:
                value = value * ((product << 7) // ((power >> 6) + 1)) >> 13
            else:
                value = value * ((product << 3) // ((power >> 10) + 1)) >> 13
            if value > 1024:
                value = 1024
        if value < floor:
            value = floor
        total += value
        i += 10
        sector += 1
    return total
