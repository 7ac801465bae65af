"""What tools/learn_evidence.py learns, and that the kernel weighs as the tool does."""

import struct

import numpy as np

from larics.arith.fixed import table16
from larics.direct import evidence_tables
from larics.kernels import evidence as kernels
from larics.kernels.layouts import BIAS
from tools import learn_evidence as tool


def test_pairs_tell_what_no_item_alone_tells():
    random = np.random.default_rng(1)
    items = random.integers(-300, 300, (2000, 3))
    answers = ((items[:, 0] > 40) != (items[:, 2] > -90)).astype(float)
    model = tool.boost(items, answers, 12)
    sums = tool.weigh(model, items)
    assert ((sums > 0) == (answers > 0)).mean() > 0.95
    table = table16(tool.pack(model))
    for row, expected in zip(items[:100], sums[:100], strict=True):
        assert kernels.weigh(np.array([*row, *[0] * 17], np.int32) + BIAS, table, len(model)) == expected


def test_the_tables_hold_pairs_of_items_that_there_are():
    for table, pairs, items in (
        (evidence_tables.BIT, evidence_tables.BIT_PAIRS, tool.BIT_ITEMS),
        (evidence_tables.LINE, evidence_tables.LINE_PAIRS, tool.LINE_ITEMS),
    ):
        numbers = np.array(struct.unpack("<%dH" % (7 * pairs), table)).reshape(pairs, 7)
        assert (numbers[:, 0] & 255).max() < items and (numbers[:, 0] >> 8).max() < items


def test_directions_near_the_truth():
    assert tool.turn16(90) == 49152
    assert tool.off_cdeg(100, 65436) == tool.off_cdeg(65436, 100)
    assert abs(tool.off_cdeg(0, 65536 - 1092) - 600) < 2
