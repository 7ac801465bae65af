"""The second opinion's model of blur: what a line and the two rings look like through it.

Lengths along a radius are in units of 1/24 of the outer radius: the outer ring lies at 24, the inner one at
16, and the rings are looked at from 13 to 28. `rel` is an angle from the direction of motion in 1/32 of half
a turn, folded to 0..16. Angles are clockwise from x, as y points down. Greys are in 1/16 levels, darkness is
in 1/1024 of that of a wide line.
"""

try:
    import micropython
except ImportError:
    from larics._cpython import micropython, ptr16, ptr32


@micropython.viper
def blurred_bar(
    ramp: ptr16, x: int, total: int, width: int, motion: int, sigma: int, first: int, count: int,
    profile: ptr16
) -> int:
    """profile[first + d] = darkness (1/1024) at d units from the middle of a line, d = 0..count - 1.

    width (of the line), motion (across the line) and sigma in 1/256 unit, 1..16384; a motion below one unit
    counts as one. ramp: tables.RAMP_Q12, the gaussian's distribution integrated once: its second difference
    over width and motion is the blurred line. Returns count."""
    if motion < 256:
        motion = 256
    narrow = width - motion
    if narrow < 0:
        narrow = 0 - narrow
    narrow = narrow >> 1
    wide = (width + motion) >> 1
    distance = 0
    end = first + count
    while first < end:
        # beyond the blurred edge everything is light; within it the four terms of the second difference
        total = 0
        if distance - wide < sigma << 2:
            part = 0
            while part < 4:
                value = distance + wide
                if part == 1:
                    value = distance + narrow
                elif part == 2:
                    value = distance - narrow
                elif part == 3:
                    value = distance - wide
                x = value
                if x < 0:
                    x = 0 - x
                    value = x << 4
                else:
                    value = 0
                x = x << 10
                if x >= sigma << 12:
                    x = x >> 6
                else:
                    x = x // sigma
                    slot = x >> 5
                    x = x & 31
                    x = (int(ramp[slot]) << 5) + (int(ramp[slot + 1]) - int(ramp[slot])) * x
                    x = ((x >> 5) * sigma) >> 8
                if part == 0 or part == 3:
                    total += x - value
                else:
                    total += value - x
                part += 1
            total = (total << 6) // motion
            if total < 0:
                total = 0
        profile[first] = total
        first += 1
        distance += 256
    return count


@micropython.viper
def ring_template(
    bars: ptr16, i: int, value: int, bar: int, templates: ptr16, slot: int, sums: ptr32, sum_slot: int,
    kinds: int,
) -> int:  # fmt: skip
    """What both rings look like at the units 13..28, from the line's profile at `bar` (d = 0..23).

    templates from `slot` on: 16 darknesses, 16 derivatives of the outer ring's, 16 of the inner ring's, each
    less their mean + 32768 (1/1024, per unit). sums from `sum_slot` on: sums of squares of the darkness, of
    the outer, of the inner derivative, of their product + 2**28, mean darkness. With kinds = 1 (not 3) only
    the darkness and its sums are written. Returns 0."""
    kind = 0
    while kind < kinds:
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
        mean = mean >> 4
        square = 0
        i = 0
        while i < 16:
            value = int(templates[slot + i]) - mean
            templates[slot + i] = value
            value -= 32768
            square += value * value
            i += 1
        sums[sum_slot + kind] = square
        if kind == 0:
            sums[sum_slot + 4] = mean
        slot += 16
        kind += 1
    if kinds == 3:
        slot -= 32
        square = 1 << 28
        i = 0
        while i < 16:
            square += (int(templates[slot + i]) - 32768) * (int(templates[slot + 16 + i]) - 32768)
            i += 1
        sums[sum_slot + 3] = square
    return 0


@micropython.viper
def match_sectors(
    means: ptr16, i: int, product: int, sectors: int, templates: ptr16, sums: ptr32,
    rel_step: int, rel_end: int, matches: ptr16,
) -> int:  # fmt: skip
    """matches[rel * sectors + s] = squared correlation (1/1024) of sector s with the template of `rel`.

    0 for rings that are bright; means as from polar.mean_samples for 16 samples, templates (48 items a rel)
    and sums (8 items a rel) as from ring_template, for the rels 0, rel_step, ... below rel_end. Returns 0."""
    sector = 0
    while sector < sectors:
        first = sector << 4
        power = 16
        i = first
        while i < first + 16:
            product = int(means[i]) - 32768
            power += product * product
            i += 1
        rel = 0
        while rel < rel_end:
            slot = rel * 48
            product = 0
            i = first
            last = first + 16
            while i < last:
                product -= (int(means[i]) - 32768) * (int(templates[slot]) - 32768)
                product -= (int(means[i + 1]) - 32768) * (int(templates[slot + 1]) - 32768)
                slot += 2
                i += 2
            value = 0
            if product > 0:
                # amplitude times inverse amplitude
                value = (product << 4) // ((int(sums[rel << 3]) >> 6) + 1)
                if power < 1048576:
                    value = value * ((product << 7) // ((power >> 6) + 1)) >> 13
                else:
                    value = value * ((product << 3) // ((power >> 10) + 1)) >> 13
                if value > 1024:
                    value = 1024
            matches[rel * sectors + sector] = value
            rel += rel_step
        sector += 1
    return 0


@micropython.viper
def best_direction(
    matches: ptr16, sector: int, rel: int, sectors: int, step: int, offset: int, floor: int, direction: int,
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
            rel = (offset + sector * step - direction) & 31
            if rel > 16:
                rel = 32 - rel
            rel = int(matches[rel * sectors + sector])
            if rel < floor:
                rel = floor
            total += rel
            sector += 1
        if total > best:
            best = total
            result[0] = direction
        direction += pitch
    return best


@micropython.viper
def match_direction(
    means: ptr16, i: int, product: int, sectors: int, step: int, offset: int, templates: ptr16, sums: ptr32,
    direction: int, still: int, floor: int,
) -> int:  # fmt: skip
    """The sum of matches for one direction of motion; arguments and result as of best_direction."""
    total = 0
    sector = 0
    while sector < sectors:
        rel = 0
        if still == 0:
            rel = (offset + sector * step - direction) & 31
            if rel > 16:
                rel = 32 - rel
        slot = rel * 48
        power = 16
        product = 0
        i = sector << 4
        last = i + 16
        while i < last:
            value = int(means[i]) - 32768
            power += value * value
            product -= value * (int(templates[slot]) - 32768)
            slot += 1
            i += 1
        value = 0
        if product > 0:
            value = (product << 4) // ((int(sums[rel << 3]) >> 6) + 1)
            if power < 1048576:
                value = value * ((product << 7) // ((power >> 6) + 1)) >> 13
            else:
                value = value * ((product << 3) // ((power >> 10) + 1)) >> 13
            if value > 1024:
                value = 1024
        if value < floor:
            value = floor
        total += value
        sector += 1
    return total
