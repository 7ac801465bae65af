"""The list of candidates for the blur-model reader."""

from larics.kernels import layouts as at


def _candidates(items, count):
    """{(least, x, y): rank} of a list."""
    slots = [items[at.CANDIDATE_ITEMS * k : at.CANDIDATE_ITEMS * (k + 1)] for k in range(count)]
    where = (at.CANDIDATE_LEAST_Q8, at.CANDIDATE_X_Q8, at.CANDIDATE_Y_Q8)
    return {tuple(slot[k] for k in where): slot[at.CANDIDATE_RANK] for slot in slots}


def remember(before, after, result):
    items, _, _, count, capacity, rank, x, y, least, most, verdict = before
    expected = _candidates(items, count)
    near = [
        key for key in expected
        if key[0] == least and abs(key[1] - x) < least // 4 and abs(key[2] - y) < least // 4
    ]  # fmt: skip
    if not any(expected[key] >= rank for key in near):
        if near:
            del expected[near[-1]]
        elif count == capacity and min(expected.values()) < rank:
            del expected[min(expected, key=expected.get)]
        if len(expected) < capacity:
            expected[least, x, y] = rank
    assert _candidates(after[0], result) == expected
    slot = [
        k * at.CANDIDATE_ITEMS for k in range(result)
        if list(after[0][k * at.CANDIDATE_ITEMS :][:4]) == [rank, x, y, least]
    ]  # fmt: skip
    if slot and (least, x, y) not in _candidates(items, count):
        new = after[0][slot[0] : slot[0] + at.CANDIDATE_ITEMS]
        assert new[at.CANDIDATE_MOST_Q8] == most and new[at.CANDIDATE_VERDICT] == verdict
        assert new[at.CANDIDATE_LOOKED] == new[at.CANDIDATE_SCORE] == new[at.CANDIDATE_KIND] == 0


def next_unseen(before, after, result):
    items, _, _, count = before
    ranks = [
        -1 if items[slot + at.CANDIDATE_LOOKED] else items[slot]
        for slot in range(0, at.CANDIDATE_ITEMS * count, at.CANDIDATE_ITEMS)
    ]
    best = max(ranks, default=-1)
    assert result == (ranks.index(best) * at.CANDIDATE_ITEMS if best > 0 else -1)


ORACLES = {
    "candidates": (
        remember,
        next_unseen,
    ),
}
