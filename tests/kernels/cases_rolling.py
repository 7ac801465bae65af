"""Calls of the kernels in larics.kernels.rolling."""

from array import array

from larics.arith.tables import QUARTER_SINE_Q14

# of each item, at most, and of x, y, heading, row_q8 and radius_q8
_PASSED_MS, _TURN, _ROW, _SHEAR = 500, 30000, 12500, 14325
_MARKER = 30000, 30000, 36000, 262144, 18432


def unroll(random):
    for number in range(200):
        passed_ms = random.between(1, _PASSED_MS)
        far = 80 * passed_ms
        items = [
            random.between(-far, far),
            random.between(-far, far),
            passed_ms,
            random.between(-_TURN, _TURN),
        ]
        items += [random.between(-20000, 60000), random.between(-_ROW, _ROW), random.between(-_SHEAR, _SHEAR)]
        items += [random.between(-16384, 16384), random.between(-16384, 16384), 0, 0, 0, 0, 0, 0, 0]
        marker = [random.between(-most, most) for most in _MARKER[:4]]
        radius_q8 = random.below(_MARKER[4])
        if number < 32:  # everything as large as it can be
            bits = [1 if number >> k & 1 else -1 for k in range(5)]
            items[:6] = [bits[0] * 40000, bits[1] * 40000, 500, bits[2] * _TURN, 4500, bits[3] * _ROW]
            items[6:9] = [bits[4] * _SHEAR, 11585, 11585]
            marker, radius_q8 = [bits[1] * 30000, bits[0] * 30000, 4500 + 9000 * (number & 3), 262143], 18432
        yield (
            0, 0, array("i", items), QUARTER_SINE_Q14, marker[0], marker[1], marker[2], marker[3], radius_q8,
        )  # fmt: skip


def follow(random):
    for number in range(200):
        items = array("i", [7] * 16)
        last_us, passed_us = random.below(1 << 30), random.below(520000 if number & 3 else 20000)
        x, y, heading = (
            random.between(-1 << 29, 1 << 28),
            random.between(-1 << 29, 1 << 28),
            random.below(36000),
        )
        items[12], items[15] = last_us, heading
        items[13], items[14] = x, y
        if number < 8:  # nothing, each of the three, and as far apart as can be
            step = (number & 1, number >> 1 & 1, number >> 2)
            items[13] = x = (1 << 29) - 1 if number == 7 else x
            step = (-(1 << 30) + 1, 0, 0) if number == 7 else step
        else:
            far = passed_us // 12
            step = random.between(-far, far), random.between(-far, far), random.between(-1000, 1000)
        time_us = (last_us + passed_us) & 0x3FFFFFFF
        heading = (heading + step[2]) % 36000
        yield 0, 0, items, x + step[0], y + step[1], heading, time_us, int(number % 10 != 9)


CASES = {"unroll": unroll, "follow": follow}
