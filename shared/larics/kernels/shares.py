"""The regressions over what the vehicle's odometry leaves out, for each leg (locate.odometry_shares)."""

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython, ptr32

_MASK = const(0x3FFFFFFF)
_SIGN = const(0x20000000)

_TREND_MOMENT = const(0)  # items as in kernels.layouts
_TREND_WEIGHT = const(1)
_TREND_FINE = const(2)
_TREND_PRIOR_Q20 = const(3)
_TREND_PRIOR_SIGMA_Q20 = const(4)
_TREND_PRIOR_WEIGHT = const(5)
_TREND_VALUE_Q20 = const(6)
_TREND_SIGMA_Q20 = const(7)

_MOST_MM = const(16383)
_MOST_WEIGHT = const(1 << 19)  # a memory of some ten legs, and of 30 bits
_PRODUCT_MOST = const(1 << 24)  # as of locate.uncertainty.times_q4


@micropython.viper
def learn_slope(mask: int, sign: int, share: ptr32, told: int, missed_q4: int, variance_q8: int) -> int:
    """Adds a leg to the sums of a TREND: what odometry told, what it missed (Q4), the variance of that (Q8).

    |told| and |missed_q4| count for 16383 and 32767 at most, variance_q8 from 256 to 2**24. mask, sign: any.
    Returns the weight."""
    mask = _MASK
    sign = _SIGN
    if told > _MOST_MM:
        told = _MOST_MM
    if told < 0 - _MOST_MM:
        told = 0 - _MOST_MM
    if missed_q4 > 32767:
        missed_q4 = 32767
    if missed_q4 < 0 - 32767:
        missed_q4 = 0 - 32767
    variance_q4 = variance_q8 >> 4
    if variance_q4 < 16:
        variance_q4 = 16
    if variance_q4 > 1 << 20:
        variance_q4 = 1 << 20
    half = variance_q4 >> 1
    fine = int(share[_TREND_FINE])
    total = ((int(share[_TREND_MOMENT]) & mask) ^ sign) - sign
    weight = int(share[_TREND_WEIGHT])
    missed_q4 = missed_q4 * told
    told = told * told
    whole = missed_q4 // variance_q4
    more = told // variance_q4
    most = whole
    if most < 0:
        most = 0 - most
    if most < more:
        most = more
    # half the sums: to fewer bits or, without any behind the point, the old windows are forgotten
    while fine and most >= _MOST_WEIGHT:
        weight = weight >> 1
        total = total >> 1
        fine -= 1
    total += (whole << fine) + (((missed_q4 - whole * variance_q4) << fine) + half) // variance_q4
    weight += (more << fine) + (((told - more * variance_q4) << fine) + half) // variance_q4
    while weight >= _MOST_WEIGHT or total >= _MOST_WEIGHT or total <= 0 - _MOST_WEIGHT:
        weight = weight >> 1
        total = total >> 1
        if fine:
            fine -= 1
    share[_TREND_MOMENT] = total
    share[_TREND_WEIGHT] = weight
    share[_TREND_FINE] = fine
    return weight


@micropython.viper
def settle_slope(mask: int, sign: int, share: ptr32, loud_q4: int) -> int:
    """Writes the slope and its sigma by all legs, when the noise is 2**(loud_q4 / 16) times the usual one.

    |loud_q4| up to 400. mask, sign: any. Returns the sigma, Q20."""
    mask = _MASK
    sign = _SIGN
    total = ((int(share[_TREND_MOMENT]) & mask) ^ sign) - sign
    weight = int(share[_TREND_WEIGHT])
    fine_q4 = int(share[_TREND_FINE]) << 4
    shift = loud_q4 + fine_q4
    value = int(share[_TREND_PRIOR_WEIGHT])
    root = 0
    k = 0
    while k < 2:  # the prior's weight, and then sigma, times 2**(shift / 16)
        value = value * (16 + (shift & 15)) >> 4
        shift = shift >> 4
        if shift < 0 - 30:
            shift = 0 - 30
        if shift <= 0:
            value = value >> (0 - shift)
        else:
            while shift and value < _PRODUCT_MOST:
                value += value
                shift -= 1
        if value > _PRODUCT_MOST:
            value = _PRODUCT_MOST
        if k == 0:
            weight += value
            while weight >= _MOST_WEIGHT:
                weight = weight >> 1
                total = total >> 1
                fine_q4 -= 16
            if weight < 1:
                weight = 1
            total = total << 9
            value = total // weight
            total = ((total - value * weight) << 7) // weight
            if value > 4096:
                value = 4096
            if value < 0 - 4096:
                value = 0 - 4096
            total += value << 7
            total += ((int(share[_TREND_PRIOR_Q20]) & mask) ^ sign) - sign
            if total > 1 << 18:
                total = 1 << 18
            if total < 0 - (1 << 18):
                total = 0 - (1 << 18)
            share[_TREND_VALUE_Q20] = total
            weight = weight << 10
            root = 1
            value = weight
            while value:
                value = value >> 2
                root += root
            value = (root + weight // root) >> 1
            while value < root:
                root = value
                value = (root + weight // root) >> 1
            value = (1 << 23) // root
            shift = (loud_q4 + fine_q4) >> 1
        k += 1
    if value > int(share[_TREND_PRIOR_SIGMA_Q20]):
        value = int(share[_TREND_PRIOR_SIGMA_Q20])
    share[_TREND_SIGMA_Q20] = value
    return value
