"""Each limit of the shares that odometry leaves out, and of what legs between markers tell of them."""

from larics.locate.odometry_shares import OdometryShares, Share
from larics.locate.uncertainty import OdometryNoise
from odometry_parts import Told, placed, told_so


class Shares(OdometryShares):
    """Tells how legs were judged."""

    def __init__(self):
        super().__init__(OdometryNoise())
        self.judged = []

    def _judge(self, fits):
        self.judged.append(bool(fits))
        return super()._judge(fits)


def judged(way_mm10, turn_cdeg=0, entry=1, x_mm10=None, heading_cdeg=None, near=False):
    """How the leg from a first marker is judged: odometry told so much, the markers the rest."""
    shares = Shares()
    shares.compare(placed(), Told(), 0, 0)
    told_so(shares, way_mm10, way_mm10, turn_cdeg)
    x_mm10 = way_mm10 if x_mm10 is None else x_mm10
    heading_cdeg = turn_cdeg if heading_cdeg is None else heading_cdeg
    told = Told(way_mm10, turn_cdeg % 36000)
    shares.compare(placed(x_mm10, heading_cdeg % 36000, entry), told, 0, 0, near)
    return shares.judged


def test_which_legs_are_compared():
    for way_mm10, turn_cdeg, entry, count in (
        (2999, 0, 1, 0),
        (3000, 0, 1, 1),
        (5999, 0, 0, 0),
        (6000, 0, 0, 1),
        (0, 5999, 0, 0),
        (0, 6000, 0, 1),
        (0, 159999, 0, 1),
        (0, 160000, 0, 0),
        (159000, 0, 1, 1),
        (160000, 0, 1, 0),
    ):
        assert len(judged(way_mm10, turn_cdeg, entry)) == count, (way_mm10, turn_cdeg, entry)
    for way_mm10, count in ((999, 0), (1000, 1)):
        assert len(judged(way_mm10, entry=0, near=True)) == count, way_mm10


def test_what_wheels_may_make():
    for settings, fits in (
        ({"way_mm10": 4000, "x_mm10": 4000 - 600 - 1000}, True),  # and a quarter of the way
        ({"way_mm10": 4000, "x_mm10": 4000 - 600 - 1001}, False),
        ({"way_mm10": 4000, "heading_cdeg": 1000 + 240}, True),  # and 6 degrees a metre
        ({"way_mm10": 4000, "heading_cdeg": 1000 + 241}, False),
        ({"way_mm10": 0, "turn_cdeg": 8000, "entry": 0, "heading_cdeg": 8000 - 3000}, True),
        ({"way_mm10": 0, "turn_cdeg": 8000, "entry": 0, "heading_cdeg": 8000 - 3001}, False),
    ):
        assert judged(**settings) == [fits], settings


def test_doubt_and_belief():
    for legs, doubted in (
        ((False,), False),
        ((False, False), True),
        ((False, False, True), False),
        ((False, False, False, True), True),
        ((False, False, False, True, True), False),
        ((False, False, False, False, True, True), False),
    ):
        shares = Shares()
        for fits in legs:
            shares._judge(fits)
        assert shares.doubted == doubted, legs


def test_a_short_way_teaches_no_share():
    for told_mm, learns in ((79, False), (80, True)):
        shares = Shares()
        shares.learn_scale(told_mm, 0, 1 << 8, 0)
        assert (shares.scale.items[1] > 0) == learns
        shares = Shares()
        shares.compare(placed(), Told(), 0, 0)
        told_so(shares, 10 * told_mm, 3000, 0)
        shares.compare(placed(3000, 0, 1), Told(3000), 0, 0)
        assert (shares.drift.items[1] > 0) == learns
    shares = Share(0, 1000)
    shares.learn(16384, 0, 1 << 24)
    assert shares.items[1] == 16383 * 16383 >> 14  # with six bits behind the point
    shares = Share(0, 1000)
    for missed_q4 in (-3, 3, 2):  # little in loud noise: no floor makes a slope of it
        shares.learn(200, missed_q4, 1 << 24)
    assert shares.items[0] == 0 and shares.items[1] == 3 * (200 * 200 >> 14)
