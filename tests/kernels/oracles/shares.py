"""The regressions over what odometry leaves out: the sums as they are defined, in floating point."""

import math

import numpy as np

from larics.kernels import layouts as at

MOST = 1 << 19  # of a sum


def learn_slope(before, after, result):
    _, _, share, told, missed_q4, variance_q8 = before
    told = min(max(told, -16383), 16383)
    missed_q4 = min(max(missed_q4, -32767), 32767)
    variance = min(max(variance_q8 >> 4, 16), 1 << 20)
    behind = 2.0 ** -share[at.TREND_FINE]
    moment = share[at.TREND_MOMENT] * behind + told * missed_q4 / variance
    weight = share[at.TREND_WEIGHT] * behind + told * told / variance
    found = after[2]
    behind = 2.0 ** -found[at.TREND_FINE]
    forgotten = weight / max(found[at.TREND_WEIGHT] * behind, 0.5)
    halved = max(0, round(math.log2(max(forgotten, 1)))) if found[at.TREND_FINE] == 0 else 0
    assert halved == 0 or max(weight, abs(moment)) > (MOST - 64) << (halved - 1)  # not without need
    assert 0 <= found[at.TREND_FINE] <= share[at.TREND_FINE]
    np.testing.assert_allclose(found[at.TREND_MOMENT] * behind, moment / 2**halved, atol=4 * behind)
    np.testing.assert_allclose(found[at.TREND_WEIGHT] * behind, weight / 2**halved, atol=4 * behind)
    assert abs(found[at.TREND_MOMENT]) < MOST and result == found[at.TREND_WEIGHT] < MOST
    assert list(found[at.TREND_PRIOR_Q20 :]) == list(share[at.TREND_PRIOR_Q20 :])


def _power(q4):
    """2**(q4 / 16), a straight line between whole exponents, as locate.uncertainty.times_q4."""
    return 2.0 ** max(q4 >> 4, -30) * (1 + (q4 & 15) / 16)


def settle_slope(before, after, result):
    _, _, share, loud_q4 = before
    found = after[2]
    fine_q4 = 16 * share[at.TREND_FINE]
    weight = min(share[at.TREND_PRIOR_WEIGHT] * _power(loud_q4 + fine_q4), 1 << 24) + share[at.TREND_WEIGHT]
    moment = float(share[at.TREND_MOMENT])
    off = 2 + 2.0 ** max(
        0, loud_q4 + fine_q4 >> 4
    )  # the prior's weight is a whole number before it is so loud
    while weight >= MOST:
        weight, moment, fine_q4 = weight / 2, moment / 2, fine_q4 - 16
    slopes = [65536 * min(max(moment / max(weight + more, 1), -8), 8) for more in (-off, off)]
    most = 1 << 18
    ends = sorted(min(max(share[at.TREND_PRIOR_Q20] + slope, -most), most) for slope in slopes)
    room = 132 + 0.02 * abs(ends[0])
    assert ends[0] - room <= found[at.TREND_VALUE_Q20] <= ends[1] + room
    spread = _power(loud_q4 + fine_q4 >> 1) * 2**18
    ends = [
        min(min(spread / math.sqrt(max(weight + more, 1)), 1 << 24), share[at.TREND_PRIOR_SIGMA_Q20])
        for more in (off, -off)
    ]
    assert ends[0] * 0.97 - 2 <= found[at.TREND_SIGMA_Q20] <= ends[1] * 1.03 + 2
    assert result == found[at.TREND_SIGMA_Q20]
    assert list(found[: at.TREND_VALUE_Q20]) == list(share[: at.TREND_VALUE_Q20])


ORACLES = {"shares": (learn_slope, settle_slope)}
