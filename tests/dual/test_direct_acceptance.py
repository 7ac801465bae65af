"""The direct reader's decision on rings and the orientation line, at each limit and just beyond it."""

from array import array

from larics.direct.acceptance import Acceptance
from larics.kernels import layouts
from larics.marker import verdicts
from larics.marker.id_set import id_set

BIAS = layouts.BIAS
RADIUS_Q8 = 7680  # 30 px
ALL = (1, 2, 3, 4, 5, 6, 7)


def allowed(ids):
    return id_set(ids, False, 0 in ids)


class Rings:
    """Flawless rings of 30 px, whose radii are 682 to 1024."""

    def __init__(self):
        self.radius_q8 = RADIUS_Q8
        self.skipped_outer = self.skipped_inner = 0
        self.fit = array("i", [0] * layouts.FIT_ITEMS)
        self.fit[layouts.FIT_INNER_Q8] = 5120
        self.fit[layouts.FIT_BULGE_COS] = self.fit[layouts.FIT_BULGE_SIN] = BIAS
        self.fit[layouts.FIT_AREA] = 1000
        self.fit[layouts.FIT_INNER_Q10] = 682
        self.resize(RADIUS_Q8)
        self.outer = array("i", [0] * layouts.RING_ITEMS)
        self.inner = array("i", [0] * layouts.RING_ITEMS)
        for ring in (self.outer, self.inner):
            ring[layouts.RING_USED] = ring[layouts.RING_INSIDE] = 16
            ring[layouts.RING_MEAN_AREA] = 1000
        self.inner_means = array("i", [1000] * 32)

    def resize(self, radius_q8):
        self.radius_q8 = self.fit[layouts.FIT_RADIUS_Q8] = radius_q8
        self.fit[layouts.FIT_INNER_Q8] = radius_q8 * 2 // 3


class Lines:
    """A flawless orientation line, and positions that tell the ID `marker_id`."""

    def __init__(self, marker_id=5):
        self.line = array("i", [0] * layouts.CROSSING_ITEMS)
        self.line[layouts.CROSSING_AREA] = 256
        self.line[layouts.CROSSING_SLOPE_MOST] = 100
        self.second_q8 = self.end_q8 = self.stroke_q8 = self.angle_turn16 = 0
        self.code_inside = 1
        self.code = array("i", [0] * (8 * layouts.POSITION_ITEMS))
        for position in range(8):
            self.put(position, layouts.POSITION_LEVEL, 500)
            self.deepen(position, 0)
        for bit in (1, 2, 3):
            if marker_id >> (3 - bit) & 1:
                self.deepen(2 * bit, 256)

    def put(self, position, item, value):
        self.code[position * layouts.POSITION_ITEMS + item] = value

    def deepen(self, position, depth):
        """Sets the depths of both halves below the mean of their sides; a bit also below the darker side."""
        self.put(position, layouts.POSITION_NEAR_MEAN, BIAS + depth + 7)
        self.put(position, layouts.POSITION_FAR_MEAN, BIAS + depth - 7)
        if position in (2, 4, 6):
            self.put(position, layouts.POSITION_NEAR, max(0, depth - 50))
            self.put(position, layouts.POSITION_FAR, max(0, depth - 50))

    def stray(self, depth):
        """Lets a position that must be empty stray by that depth."""
        self.put(3, layouts.POSITION_NEAR_MEAN, BIAS + depth)
        self.put(3, layouts.POSITION_FAR_MEAN, BIAS + depth)

    def light(self, grey):
        """The brightness of all positions, log units."""
        for position in range(8):
            self.put(position, layouts.POSITION_LEVEL, grey)

    def brighten(self, position, grey, brighter):
        """Light on a position and the one beside it; the mean is as if it lay on the one alone."""
        self.put(position, layouts.POSITION_LEVEL, grey + brighter)
        self.put(position + 1, layouts.POSITION_LEVEL, grey + brighter)
        self.put(0, layouts.POSITION_LEVEL, grey - brighter)


def rings_verdict(rings, acceptance=None, low_q8=RADIUS_Q8, high_q8=RADIUS_Q8):
    return (acceptance or Acceptance(allowed(ALL), 0)).rings(rings, low_q8, high_q8)


def rings_margin(change):
    rings = Rings()
    change(rings)
    acceptance = Acceptance(allowed(ALL), 0)
    assert rings_verdict(rings, acceptance) == verdicts.ACCEPTED
    return acceptance.margin


def used(rings, outer, inner):
    """Sets (sectors used, sectors with crossings, half sectors skipped) of both rings."""
    rings.outer[layouts.RING_USED], rings.outer[layouts.RING_INSIDE], rings.skipped_outer = outer
    rings.inner[layouts.RING_USED], rings.inner[layouts.RING_INSIDE], rings.skipped_inner = inner


def test_radii_may_leave_the_range_by_an_eighth():
    for radius_q8, expected in (
        (7168, verdicts.ACCEPTED),
        (7167, verdicts.OUT_OF_RANGE),
        (9216, verdicts.ACCEPTED),
        (9217, verdicts.OUT_OF_RANGE),
    ):
        rings = Rings()
        rings.resize(radius_q8)
        assert rings_verdict(rings, None, 8192, 8192) == expected, radius_q8


def test_sectors_of_the_rings_that_must_be_seen_and_agree():
    good, poor = verdicts.ACCEPTED, verdicts.POOR_RINGS
    for outer, inner, expected in (
        ((16, 16, 0), (16, 16, 0), good),
        ((10, 10, 0), (16, 16, 0), good),  # 20 half sectors of the outer ring
        ((9, 9, 2), (16, 16, 0), good),
        ((9, 9, 1), (16, 16, 0), poor),
        ((16, 16, 0), (12, 12, 0), good),  # 24 of the inner one
        ((16, 16, 0), (11, 11, 1), poor),
        ((9, 16, 0), (16, 16, 0), good),  # 36 of 64 agree
        ((5, 9, 2), (16, 16, 0), poor),  # 35
        ((16, 16, 0), (9, 16, 0), good),
        ((16, 16, 0), (5, 9, 6), poor),
        ((9, 16, 0), (10, 11, 2), good),  # 36 and 58 together
        ((9, 16, 0), (9, 10, 4), poor),  # 36 and 57
    ):
        rings = Rings()
        used(rings, outer, inner)
        assert rings_verdict(rings) == expected, (outer, inner)


def test_rings_blurred_on_one_side_need_less_that_agrees_and_a_look_all_around():
    for outer, inner, expected in (
        ((9, 16, 0), (9, 16, 0), verdicts.ACCEPTED),
        ((8, 16, 0), (9, 16, 0), verdicts.POOR_RINGS),  # 32 of 64 are too few for either ring
    ):
        rings = Rings()
        used(rings, outer, inner)
        acceptance = Acceptance(allowed(ALL), 0)
        assert acceptance.rings(rings, RADIUS_Q8, RADIUS_Q8) == verdicts.POOR_RINGS
        assert acceptance.rings(rings, RADIUS_Q8, RADIUS_Q8, True) == expected
    rings = Rings()
    used(rings, (9, 16, 0), (9, 16, 0))
    assert acceptance.rings(rings, RADIUS_Q8, RADIUS_Q8, True) == verdicts.ACCEPTED
    assert acceptance.margin == 0  # 36 of 64, the limit of either ring
    for sectors, deviation, expected in ((29, 279, True), (28, 279, False), (29, 280, False)):
        rings = Rings()
        used(rings, (sectors - 15, 15, 0), (15, 15, 0))
        rings.outer[layouts.RING_DEVIATION] = deviation  # 160 and 1/64 of the radius
        assert acceptance.uneven(rings) == expected, (sectors, deviation)


def test_shape_and_darkness_of_the_rings():
    def change(item, value, of=None):
        def apply(rings):
            (rings.fit if of is None else getattr(rings, of))[item] = value

        return apply

    def areas(outer, inner):
        def apply(rings):
            rings.outer[layouts.RING_MEAN_AREA], rings.inner[layouts.RING_MEAN_AREA] = outer, inner

        return apply

    def deviations(outer, inner):
        def apply(rings):
            rings.outer[layouts.RING_DEVIATION], rings.inner[layouts.RING_DEVIATION] = outer, inner

        return apply

    for at, beyond in (
        (change(layouts.FIT_BULGE_COS, BIAS + 3839), change(layouts.FIT_BULGE_COS, BIAS + 3840)),
        (change(layouts.FIT_BULGE_COS, BIAS - 3839), change(layouts.FIT_BULGE_COS, BIAS - 3840)),
        (change(layouts.FIT_BULGE_SIN, BIAS + 3839), change(layouts.FIT_BULGE_SIN, BIAS + 3840)),
        (change(layouts.FIT_BULGE_SIN, BIAS - 3839), change(layouts.FIT_BULGE_SIN, BIAS - 3840)),
        (change(layouts.FIT_INNER_Q10, 682 + 26), change(layouts.FIT_INNER_Q10, 682 + 27)),
        (change(layouts.FIT_INNER_Q10, 682 - 26), change(layouts.FIT_INNER_Q10, 682 - 27)),
        (areas(600, 1000), areas(599, 1000)),
        (areas(1000, 600), areas(1000, 599)),
        (deviations(300, 260), deviations(301, 260)),  # 320 and 1/32 of the radius
    ):
        rings = Rings()
        at(rings)
        assert rings_verdict(rings) == verdicts.ACCEPTED
        beyond(rings)
        assert rings_verdict(rings) == verdicts.POOR_RINGS
    # with few pixels the ratio may be farther off, with many less
    for radius_q8, off in ((3840, 36), (15360, 21)):
        rings = Rings()
        rings.resize(radius_q8)
        rings.fit[layouts.FIT_INNER_Q10] = 682 - off
        assert rings_verdict(rings, None, radius_q8, radius_q8) == verdicts.ACCEPTED
        rings.fit[layouts.FIT_INNER_Q10] -= 1
        assert rings_verdict(rings, None, radius_q8, radius_q8) == verdicts.POOR_RINGS


def test_a_margin_is_the_weakest_rule_of_the_rings():
    assert rings_margin(lambda rings: None) == 255
    assert rings_margin(lambda rings: used(rings, (10, 16, 0), (16, 16, 0))) == 51  # 4 of 20
    assert rings_margin(lambda rings: used(rings, (16, 16, 0), (10, 16, 0))) == 51
    assert rings_margin(lambda rings: used(rings, (11, 14, 0), (11, 14, 0))) == 51  # 6 of 30

    def off(rings):
        rings.fit[layouts.FIT_INNER_Q10] = 682 + 16

    def faint(rings):
        rings.outer[layouts.RING_MEAN_AREA] = 750

    def deviating(rings):
        rings.outer[layouts.RING_DEVIATION] = 420

    for change in (off, faint, deviating):
        assert rings_margin(change) == 127  # half way
    rings = Rings()
    off(rings)
    assert rings_verdict(rings, Acceptance(allowed(ALL), 127)) == verdicts.ACCEPTED
    assert rings_verdict(rings, Acceptance(allowed(ALL), 128)) == verdicts.POOR_RINGS


def test_rings_that_are_fainter_on_one_side_may_agree_in_fewer_sectors():
    rings = Rings()
    used(rings, (11, 14, 0), (11, 14, 0))  # 50 of 64 each
    for uneven, margin in ((False, 51), (True, 76)):  # 6 of 30 above 94, 36 of 120 above 64
        acceptance = Acceptance(allowed(ALL), 0)
        assert acceptance.rings(rings, RADIUS_Q8, RADIUS_Q8, uneven) == verdicts.ACCEPTED
        assert acceptance.margin == margin


def test_first_look_at_rings():
    look = Acceptance(allowed(ALL), 0).first_look
    for item, at, beyond in (
        (layouts.FIT_INNER_Q10, 682 + 35, 682 + 36),
        (layouts.FIT_INNER_Q10, 682 - 35, 682 - 36),
    ):
        rings = Rings()
        rings.fit[item] = at
        assert look(rings, 480)
        rings.fit[item] = beyond
        assert not look(rings, 480)
    for ring in ("outer", "inner"):
        for item, at, beyond in ((layouts.RING_DEVIATION, 719, 720), (layouts.RING_MEAN_AREA, 601, 600)):
            rings = Rings()
            getattr(rings, ring)[item] = at
            assert look(rings, 480)
            getattr(rings, ring)[item] = beyond
            assert not look(rings, 480)


LINE_LIMITS = (  # item of the line or attribute, last value that is accepted, step beyond, doubt
    ("second_q8", 250, 1, 150),
    (layouts.CROSSING_AREA, 96, -1, 110),
    (layouts.CROSSING_AREA, 520, 1, 120),
    (layouts.CROSSING_DISTANCE, 200 + RADIUS_Q8 // 64, 1, 150),
    (layouts.CROSSING_GAP, 90, 1, 80),
    (layouts.CROSSING_SLOPE, 100, 1, 100),
    ("end_q8", 140, 1, 80),
)


def test_limits_of_the_orientation_line():
    rings = Rings()
    for item, limit, beyond, doubt in LINE_LIMITS:
        acceptance = Acceptance(allowed(ALL), 0)
        assert acceptance.orientation(Lines(), rings) == verdicts.ACCEPTED and acceptance.margin == 255
        for distance, margin in ((0, 0), (doubt // 2, 255 * (doubt // 2) // doubt), (-1, -1)):
            lines = Lines()
            if isinstance(item, str):
                setattr(lines, item, limit - beyond * distance)
            else:
                lines.line[item] = limit - beyond * distance
            acceptance.margin = 255
            expected = verdicts.ACCEPTED if margin >= 0 else verdicts.NO_ORIENTATION
            assert acceptance.orientation(lines, rings) == expected, (item, distance)
            assert acceptance.margin == margin, (item, distance)


def code_verdict(lines, rings=None, ids=ALL, margin=255, margin_min=0):
    """The verdict, the ID and the margin."""
    acceptance = Acceptance(allowed(ids), margin_min)
    acceptance.margin = margin
    verdict = acceptance.code(lines, rings or Rings(), None, False)
    return verdict, acceptance.marker_id, acceptance.margin


def test_a_pose_without_an_id_needs_a_larger_margin():
    lines = Lines(5)
    lines.code_inside = 0
    assert code_verdict(lines, margin=112)[0] == verdicts.ID_UNCERTAIN
    assert code_verdict(lines, margin=111)[0] == verdicts.NOT_EMPTY
    assert code_verdict(lines, margin=149, margin_min=150)[0] == verdicts.NOT_EMPTY
    lines = Lines(5)
    lines.stray(30)
    lines.deepen(4, 60)
    assert code_verdict(lines, margin_min=127)[0] == verdicts.ACCEPTED
    assert code_verdict(lines, margin_min=128)[0] == verdicts.NOT_EMPTY
