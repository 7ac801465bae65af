"""Calls of the kernels in larics.kernels.candidates."""

from array import array

from larics.kernels.layouts import BIAS, CANDIDATE_ITEMS

CAPACITY = 4
LEAST = 20 << 8


def listed(*ranks):
    """A list with candidates of these ranks, 40 px apart."""
    items = array("i", bytes(4 * CANDIDATE_ITEMS * CAPACITY))
    for index, rank in enumerate(ranks):
        slot = CANDIDATE_ITEMS * index
        items[slot : slot + 6] = array(
            "i", (rank, BIAS + (40 * index << 8), BIAS - (30 << 8), LEAST, 30 << 8, 2)
        )
        items[slot + 6] = items[slot + 7] = items[slot + 13] = 1
    return items


def remember(random):
    for ranks in ((), (70,), (70, 60), (50, 80, 60), (50, 80, 60, 70)):
        for rank in (1, 55, 60, 65, 90):
            for index in (0, 1, 2, 9):
                for off in (0, (LEAST >> 2) - 1, LEAST >> 2):
                    for least in (LEAST, LEAST + 1):
                        yield (
                            listed(*ranks), 0, 0, len(ranks), CAPACITY, rank, BIAS + (40 * index << 8) + off,
                            BIAS - (30 << 8) - off, least, 31 << 8, 5,
                        )  # fmt: skip


def next_unseen(random):
    for ranks in ((), (70,), (50, 80, 60, 70), (80, 80)):
        for unseen in range(16):
            items = listed(*ranks)
            for index in range(len(ranks)):
                items[CANDIDATE_ITEMS * index + 6] = 0 if unseen >> index & 1 else 1
            yield items, 0, 0, len(ranks)


CASES = {"remember": remember, "next_unseen": next_unseen}
