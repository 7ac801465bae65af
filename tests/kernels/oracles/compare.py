"""What oracles share: constants by their definition, and comparisons of whole arrays."""

import numpy as np

from larics.arith import tables
from larics.kernels import layouts as at
from larics.marker import golay

BIAS = at.BIAS
WORDS = np.array([golay.cells(marker_id) for marker_id in range(4096)])
LOG = np.frombuffer(bytes(tables.LOG_GREY_Q8), "<u2").astype(int)
TURN = np.frombuffer(bytes(tables.COSINE_Q14_BIASED), "<u2").astype(int) - 32768


def numbers(buffer, count=None):
    """A buffer's items as a numpy array of integers."""
    return np.array(buffer[:count] if count is not None else buffer, dtype=np.int64)


def same(found, expected):
    np.testing.assert_array_equal(numbers(found), numbers(expected))


def close(found, expected, most):
    off = np.abs(np.asarray(found, float) - np.asarray(expected, float))
    assert off.max(initial=0) <= most, (off.max(), int(np.argmax(off)))


def log2_grey(grey):
    """The definition of the log grey, for interpolated greys, too."""
    return 256 * np.log2((np.asarray(grey, float) + 16) / 16)
