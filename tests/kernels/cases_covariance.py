"""Calls of the kernel in larics.kernels.covariance."""

from array import array

# of sigmas of scale, drift and turn at most, as priors allow
_SIGMAS = 104857, 274500, 104857


def grow(random):
    for number in range(240):
        extreme = number < 40
        bits = [1 if number >> k & 1 else -1 for k in range(4)]
        xx, yy = random.below(1 << random.between(4, 25)), random.below(1 << random.between(4, 25))
        tt = random.below(1 << random.between(8, 27))
        items = [xx, random.between(-min(xx, yy), min(xx, yy)), yy]
        items += [random.between(-30000, 30000), random.between(-30000, 30000), tt]
        items += [random.below(20000), random.below(100000), random.between(-50000, 50000)]
        items += [random.between(-50000, 50000)]
        items += [random.below(most) for most in _SIGMAS]
        items += [random.between(-192, 96), random.below(10001) * (number % 5 > 0), random.between(-100, 60)]
        way = [
            random.between(-9000, 9000),
            random.between(-9000, 9000),
            random.below(1200),
            random.below(8001),
        ]
        way += [
            random.between(-176, 176),
            random.between(-176, 176),
            random.below(16384),
            random.below(31416),
        ]
        if extreme:  # everything as large as it can be, and just too large for use
            most = 1 << 25, bits[0] * 33000000, 1 << 25, bits[1] * (1 << 22), bits[2] * (1 << 22), 1 << 27
            items[:6] = list(most)
            items[number % 6] += number == 33 or number == 38
            items[8:10] = [bits[0] << 18, bits[1] << 18]
            items[10:16] = list(_SIGMAS) + [96, 10000, 60]  # noqa: RUF005
            way = [bits[0] * 170000, bits[3] * 170000, 12000, 8000, 176, 176, 16383, 31416]
        px, py, since, speed, way_q4, turn_q4, way_mm, turned = way
        yield 0, 0, array("i", items + [0] * 4), px, py, since, speed, way_q4, turn_q4, way_mm, turned


CASES = {"grow": grow}
