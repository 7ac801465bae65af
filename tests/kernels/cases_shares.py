"""Calls of the kernels in larics.kernels.shares."""

from array import array


def _share(random, number):
    """Sums, a prior from the settings, and no result yet; every eighth as large as they can be."""
    if number % 8 == 0:
        return array("i", [(1 << 19) - 1, (1 << 19) - 1, 6 * (number & 1), -104857, 104857, 1 << 20, 0, 0])
    most = 1 << random.between(1, 19)
    share = [random.between(1 - most, most - 1), random.below(most), random.below(7)]
    share += [random.between(-20000, 20000), 1 << random.between(3, 17), most >> 3, 0, 0]
    return array("i", share)


def learn_slope(random):
    for number in range(200):
        told = random.between(-20000, 20000) if number % 3 else random.between(-200, 200)
        missed = random.between(-1 << random.between(1, 17), 1 << 17)
        yield 0, 0, _share(random, number), told, missed, 1 << random.between(0, 25)


def settle_slope(random):
    for number in range(200):
        yield 0, 0, _share(random, number), random.between(-400, 400)


CASES = {"learn_slope": learn_slope, "settle_slope": settle_slope}
