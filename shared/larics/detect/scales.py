"""The range of radii cut into scales, and the scales into groups that share a frame's gradients."""

try:
    from micropython import const
except ImportError:
    from larics._cpython import const

from larics.arith.fixed import cos_q14

RADIUS_LEAST_PX = const(6)
RADIUS_MOST_PX = const(72)

_SPAN_Q8 = const(378)  # radii of one scale: largest / smallest
_TINY_MOST_Q8 = const(2560)  # below, radii differ by few pixels however large their ratio
_TINY_SPAN_Q8 = const(450)


class Scale:
    """What one range of radii needs: the pitch of its grid, and with it, set by the detector, its edge
    finder, its votes' tables and what the coarse fit takes of it (kernels.layouts: RADII).

    step    px between the cells of votes, and between the points where edges are looked for
    reach   distance in px of the pixels whose difference is the gradient
    """

    def __init__(self, radius_min_q8, radius_max_q8):
        self.radius_min_q8 = radius_min_q8
        self.radius_max_q8 = radius_max_q8
        self.radius_q8 = (radius_min_q8 + radius_max_q8) // 2
        radius_px = (self.radius_q8 + 128) >> 8
        # finer grids than these cost more and find no more
        self.step = 3 if radius_px < 15 else 4 if radius_px < 22 else min(8, radius_px // 5)
        self.reach = 1 if radius_px < 20 else 2 if radius_px < 45 else 3
        self.edges = None
        self.votes = None
        self.radii = None
        self.is_searched = False  # for blurred edges in this frame, see blurred_search


def tilted_px(radius_px, tilt_deg):
    """The radius of a ring seen level when the camera is tilted: shortened, and farther away."""
    cosine = cos_q14(tilt_deg * 65536 // 360)
    return max(RADIUS_LEAST_PX, radius_px * (cosine * cosine >> 14) >> 14)


def cut(radius_min_px, radius_max_px):
    """The range of radii cut into scales of about the same ratio, smallest first."""
    low_q8, high_q8 = radius_min_px << 8, radius_max_px << 8
    span_q8 = _SPAN_Q8 if high_q8 > _TINY_MOST_Q8 else _TINY_SPAN_Q8
    count = 1
    while _power_q8(span_q8, count) < high_q8 * 256 // low_q8:
        count += 1
    ratio_q8 = 256  # the least ratio whose power covers the range
    while _power_q8(ratio_q8, count) < high_q8 * 256 // low_q8:
        ratio_q8 += 1
    scales = []
    for index in range(count):
        next_q8 = high_q8 if index == count - 1 else low_q8 * ratio_q8 >> 8
        scales.append(Scale(low_q8, next_q8))
        low_q8 = next_q8
    return scales


def _power_q8(ratio_q8, exponent):
    power = 256
    for _ in range(exponent):
        power = power * ratio_q8 >> 8
    return power


def grouped(scales):
    """Groups of scales, as lists with the finest last, which take their edges from one gradient.

    Every second point of the finest grid serves the others of its group, whose own would have about as many.
    They get the reach of the finest."""
    groups = []
    finest = None
    for scale in scales:
        # two pixels are far enough for any but the smallest rings
        if (
            finest is not None
            and min(scale.reach, 2) == finest.reach
            and 3 * finest.step * finest.step <= 2 * scale.step * scale.step
        ):
            scale.reach = finest.reach
            groups[-1].insert(0, scale)
        else:
            finest = scale
            groups.append([scale])
    return groups
