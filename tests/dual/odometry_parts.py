"""Readings of odometry and fixes by markers, for tests of what is made of them."""

from larics.locate.carrier import Carrier, Fix
from larics.locate.uncertainty import OdometryNoise


class Told:
    """A pose that odometry told."""

    def __init__(self, x_mm10=0, heading_cdeg=0):
        self.x_mm10, self.y_mm10, self.heading_cdeg = x_mm10, 0, heading_cdeg


def placed(x_mm10=0, heading_cdeg=0, entry=0):
    """A fix by a marker, that of this number in the map."""
    fix = Fix()
    fix.x_mm10, fix.heading_cdeg, fix.entry = x_mm10, heading_cdeg, entry
    return fix


def told_so(shares, forward_mm10, way_mm10, turn_cdeg):
    """As if odometry had told that since the last marker."""
    shares.sums[0] = shares.sums[1] = forward_mm10
    shares.sums[2], shares.sums[3] = way_mm10, turn_cdeg


def carrier():
    """A Carrier at the origin with an odometry that has not moved yet, and the Fix that put it there."""
    made = Carrier(OdometryNoise())
    odometry = Told()
    odometry.epoch = odometry.jumps = 0
    made.move(odometry, 0)
    fix = placed()
    fix.scatter_mm10, fix.scatter_cdeg = 10, 10
    made.fix(fix)
    return made, fix
