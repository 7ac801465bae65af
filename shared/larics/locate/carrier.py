"""The pose carried from marker to marker by the vehicle's odometry, with its covariance, in integers.

A marker sets pose and covariance; each way and turn since moves the pose and lets the covariance grow by a
model of two wheels: noise in proportion to the way, and systematic shares of way and turn, which
larics.locate.odometry_shares learns. How loud the noise is, that along the way and that of turns,
larics.locate.wheel_noise finds at the next marker and, that it is quiet, already below the first: encoders
that do not see what the wheels do make it a hundred times larger. What is known beforehand is in
larics.locate.uncertainty.

Way is in 0.1 mm Q4, heading in 0.01 degrees Q6, covariance in mm2 Q4, mm mrad Q5 and mrad2 Q8, shares in Q20;
every intermediate stays within 30 bits. Nothing is allocated.
"""

from array import array

try:
    import micropython
    from micropython import const
except ImportError:
    from larics._cpython import const, micropython

from larics.arith.fixed import wrap_cdeg
from larics.arith.tables import QUARTER_SINE_Q14
from larics.kernels.covariance import grow
from larics.kernels.odometry import advance
from larics.locate.motion import scaled_q14
from larics.locate.odometry import length
from larics.locate.odometry_shares import OdometryShares, mrad_q4
from larics.locate.uncertainty import times_q4
from larics.locate.wheel_noise import Loudness, Slope
from larics.wire.messages import WAY_UNKNOWN

_STEP_MM10 = const(640)  # of way, after which the covariance grows
_WAY_NOISE_Q20 = const(2097)  # as in kernels.covariance
_NEAR_LEGS = const(2)  # ways and turns under one marker show the noise of the wheels for as long as no more
_NEAR_MOST_MM10 = const(7000)  # ... legs do; ways no longer than this
_NEAR_MOST_MS = const(2047)
_NEAR_MS = const(900)  # wheels that go wrong for 0.3 s show a third of their noise in half of this,
_ALIKE_MS = const(200)  # and of two ways that each take so long half of that as a difference
_LATE_MM_S = const(25)  # 0.01 mm by the 0.4 ms that the clocks of vehicle and camera differ by
_MOST_MRAD = const(2000)  # of a turn that moves a vehicle in the map by what calibration is wrong by
_MOST_OFF = const(2000)  # 0.01 mm
_LEAST_Q4 = const(-48)  # against the noise that depends on no speed: less no short way shows
_LEARN_MM10 = const(3000)  # a shorter way teaches nothing, nor does one under the same marker that is shorter
_LEARN_AGAIN_MM10 = const(15000)  # than this: wheels go wrong for 0.3 s, and the camera's errors cancel
_MOST_MM10 = const(7000)  # of one increment
_PATH_HEADING_Q6 = const(0)
_PATH_X = const(1)
_PATH_Y = const(2)
_PATH_NEW_X = const(3)
_PATH_NEW_Y = const(4)
_PATH_WAY = const(5)
_PATH_SINCE = const(6)
_PATH_TURNED = const(7)
_PATH_TURNED_MOST = const(8)
_PATH_SPEED = const(9)
_PATH_SCALE_Q12 = const(10)
_PATH_TURN_Q14 = const(11)
_PATH_DRIFT_Q16 = const(12)
_PATH_HALF_TRACK = const(13)
_PATH_ITEMS = const(14)
_COVARIANCE_XX = const(0)
_COVARIANCE_XY = const(1)
_COVARIANCE_YY = const(2)
_COVARIANCE_XT = const(3)
_COVARIANCE_YT = const(4)
_COVARIANCE_TT = const(5)
_COVARIANCE_SCALE = const(6)
_COVARIANCE_TURNS = const(7)
_COVARIANCE_BENT_X = const(8)
_COVARIANCE_BENT_Y = const(9)
_COVARIANCE_SCALE_SIGMA = const(10)
_COVARIANCE_DRIFT_SIGMA = const(11)
_COVARIANCE_TURN_SIGMA = const(12)
_COVARIANCE_NOISE_Q4 = const(13)
_COVARIANCE_HASTE_US = const(14)
_COVARIANCE_TRACK_Q4 = const(15)
_COVARIANCE_SIGMA_X = const(16)
_COVARIANCE_SIGMA_Y = const(17)
_COVARIANCE_SIGMA_CDEG = const(18)
_COVARIANCE_CORRELATION = const(19)
_COVARIANCE_ITEMS = const(20)


class Fix:
    """Where markers put the vehicle: place and heading, the entry of the map, the standard deviations of what
    scatters, of what does not, and of both, and whether it was expected elsewhere."""

    def __init__(self):
        self.x_mm10 = self.y_mm10 = self.heading_cdeg = 0
        self.entry = -1
        self.scatter_mm10 = self.scatter_cdeg = 0
        self.certain_mm10 = self.certain_cdeg = 0
        self.sigma_mm10 = self.sigma_cdeg = 0
        self.moved = False


class Carrier:
    """`fix` with each marker, `move` with the odometry of each frame. model: uncertainty.OdometryNoise.

    known                           whether there is a pose to carry
    x_mm10, y_mm10, heading_cdeg    after `move`
    sigma_x_mm10, sigma_y_mm10, sigma_cdeg, correlation_q14
    way_mm                          since the marker, at most WAY_UNKNOWN
    shares                          odometry_shares.OdometryShares
    """

    def __init__(self, model):
        self._model = model
        self.shares = OdometryShares(model)
        self.known = False
        self.x_mm10 = self.y_mm10 = self.heading_cdeg = 0
        self.sigma_x_mm10 = self.sigma_y_mm10 = self.sigma_cdeg = self.correlation_q14 = 0
        self.way_mm = 0
        self.way_noise, self.turn_noise = Loudness(), Loudness()
        self._legs = 0
        self._entry = -1  # of the last marker
        self._near_ms = 0  # of the way that is compared, without standing
        self._near_ways, self._near_drift, self._near_turns = Slope(), Slope(), Slope()
        self._odometry = None
        self._epoch = self._jumps = -1
        self._last_x = self._last_y = self._last_heading = self._last_us = 0
        self._x0 = self._y0 = 0
        path = self._path = array("i", [0] * _PATH_ITEMS)
        path[_PATH_HALF_TRACK] = model.half_track_mm
        items = self._items = array("i", [0] * _COVARIANCE_ITEMS)
        items[_COVARIANCE_NOISE_Q4] = model.noise_q4
        items[_COVARIANCE_HASTE_US] = model.speed_noise_us
        items[_COVARIANCE_TRACK_Q4] = model.track_q4
        self._grown = False  # since sigma was told

    @micropython.native
    def fix(self, fix):
        """A marker put the vehicle there, a Fix. Learns from it."""
        if self._odometry is None:
            return
        path = self._path
        if self.known and path[_PATH_WAY] > (_LEARN_AGAIN_MM10 if fix.entry == self._entry else _LEARN_MM10):
            self._hear_noise(fix)
        if fix.entry != self._entry:
            self._entry, self._near_ms = fix.entry, 0
        near = self._legs <= _NEAR_LEGS
        ended = self.shares.compare(fix, self._odometry, path[_PATH_SPEED], self.turn_noise.q4, near)
        if ended and near:
            if self.shares.way_mm10 <= _NEAR_MOST_MM10:
                self._look_closely(fix)
            self._near_ms = 0
        self._x0, self._y0 = fix.x_mm10, fix.y_mm10
        path[_PATH_HEADING_Q6] = fix.heading_cdeg << 6
        path[_PATH_X] = path[_PATH_Y] = path[_PATH_NEW_X] = path[_PATH_NEW_Y] = 0
        path[_PATH_WAY] = path[_PATH_SINCE] = path[_PATH_TURNED] = path[_PATH_TURNED_MOST] = 0
        items = self._items
        items[_COVARIANCE_XX] = items[_COVARIANCE_YY] = _variance_q4(fix)
        items[_COVARIANCE_XY] = items[_COVARIANCE_XT] = items[_COVARIANCE_YT] = 0
        items[_COVARIANCE_TT] = _variance_of_heading_q8(fix)
        items[_COVARIANCE_SCALE] = items[_COVARIANCE_TURNS] = 0
        items[_COVARIANCE_BENT_X] = items[_COVARIANCE_BENT_Y] = 0
        self.known = True
        # all that `_tell` would find, with less work
        self.x_mm10, self.y_mm10, self.heading_cdeg = fix.x_mm10, fix.y_mm10, fix.heading_cdeg
        self.sigma_x_mm10 = self.sigma_y_mm10 = fix.sigma_mm10
        self.sigma_cdeg = fix.sigma_cdeg
        self.correlation_q14 = self.way_mm = 0
        self._grown = False

    def move(self, odometry, time_us):
        """Carries the pose on to the odometry's at that time (modulo 2**30); False when that has jumped: then
        nothing is known."""
        if odometry.epoch != self._epoch or odometry.jumps != self._jumps or self._odometry is None:
            self._epoch, self._jumps = odometry.epoch, odometry.jumps
            self._odometry = odometry
            self._forget()
        else:
            self._carry(odometry, max(1, ((time_us - self._last_us) & 0x3FFFFFFF) // 1000))
        self._last_x, self._last_y = odometry.x_mm10, odometry.y_mm10
        self._last_heading = odometry.heading_cdeg
        self._last_us = time_us
        if self.known:
            self._tell()
        return self.known

    def _forget(self):
        self.known = False
        self.shares.forget_anchor()

    def _carry(self, odometry, passed_ms):
        dx, dy = odometry.x_mm10 - self._last_x, odometry.y_mm10 - self._last_y
        turn_cdeg = wrap_cdeg(odometry.heading_cdeg - self._last_heading)
        if dx == 0 and dy == 0 and turn_cdeg == 0:
            return
        if abs(dx) > 100000 or abs(dy) > 100000:  # 10 m between two frames: no way for a covariance
            self._forget()
            return
        if abs(dx) + abs(dy) < _MOST_MM10:
            self._advance(dx, dy, turn_cdeg, self._last_heading, passed_ms)
            return
        parts = 1 + (abs(dx) + abs(dy)) // _MOST_MM10
        for k in range(parts):  # long increments in pieces, so that the covariance follows the way
            turned_cdeg = turn_cdeg * k // parts
            self._advance(
                dx * (k + 1) // parts - dx * k // parts,
                dy * (k + 1) // parts - dy * k // parts,
                turn_cdeg * (k + 1) // parts - turned_cdeg,
                self._last_heading + turned_cdeg,
                max(1, passed_ms // parts),
            )

    def _advance(self, dx, dy, turn_cdeg, told_cdeg, passed_ms):
        """An increment of the odometry from its heading told_cdeg on: 0.1 mm, 0.01 degrees."""
        shares = self.shares
        if shares.changed:
            self._take_shares()
        known = 1 if self.known else 0
        since = advance(
            0, 0, self._path, shares.sums, QUARTER_SINE_Q14, dx, dy, turn_cdeg, told_cdeg, passed_ms, known
        )
        if self._legs <= _NEAR_LEGS:
            self._near_ms = min(_NEAR_MOST_MS, self._near_ms + passed_ms)
        if since >= _STEP_MM10:
            self._grow()

    def _take_shares(self):
        shares, path, items = self.shares, self._path, self._items
        shares.changed = False
        path[_PATH_SCALE_Q12] = shares.scale.value_q20 >> 8
        path[_PATH_TURN_Q14] = shares.turn.value_q20 >> 6
        path[_PATH_DRIFT_Q16] = shares.drift.value_q20 >> 4
        items[_COVARIANCE_SCALE_SIGMA] = shares.scale.sigma_q20
        items[_COVARIANCE_DRIFT_SIGMA] = shares.drift.sigma_q20
        items[_COVARIANCE_TURN_SIGMA] = shares.turn.sigma_q20

    def _grow(self):
        """The covariance follows the way since it did so last."""
        if self.shares.changed:
            self._take_shares()
        path = self._path
        way_mm = min(path[_PATH_WAY] // 10, 16383)  # further, the shares grow no more: it is lost before
        turned = mrad_q4(path[_PATH_TURNED_MOST]) >> 4
        grow(
            0, 0, self._items, path[_PATH_NEW_X], path[_PATH_NEW_Y], path[_PATH_SINCE], path[_PATH_SPEED],
            self.way_noise.q4, self.turn_noise.q4, way_mm, turned,
        )  # fmt: skip
        path[_PATH_SINCE] = path[_PATH_NEW_X] = path[_PATH_NEW_Y] = 0
        self._grown = True

    def _tell(self):
        self.x_mm10 = self._x0 + (self._path[_PATH_X] >> 4)
        self.y_mm10 = self._y0 + (self._path[_PATH_Y] >> 4)
        self.heading_cdeg = (self._path[_PATH_HEADING_Q6] >> 6) % 36000
        self.way_mm = min(WAY_UNKNOWN, self._path[_PATH_WAY] // 10)
        if self._grown:
            self._grown = False
            items = self._items
            self.sigma_x_mm10, self.sigma_y_mm10 = items[_COVARIANCE_SIGMA_X], items[_COVARIANCE_SIGMA_Y]
            self.sigma_cdeg = items[_COVARIANCE_SIGMA_CDEG]
            self.correlation_q14 = items[_COVARIANCE_CORRELATION]

    def _hear_noise(self, fix):
        """How far the marker is off, in squares of the sigma: along the way since the last one, and across it
        and in the heading, which is what turns make of it."""
        self._grow()
        self._tell()
        dx = max(-20000, min(20000, fix.x_mm10 - self.x_mm10))
        dy = max(-20000, min(20000, fix.y_mm10 - self.y_mm10))
        off = mrad_q4(max(-6000, min(6000, wrap_cdeg(fix.heading_cdeg - self.heading_cdeg))))
        items, place, turn = self._items, _variance_q4(fix), _variance_of_heading_q8(fix)
        xx, xy, yy = items[_COVARIANCE_XX], items[_COVARIANCE_XY], items[_COVARIANCE_YY]
        least_q4 = self._least_q4(self._model.at_speed_q4(self._path[_PATH_SPEED]))
        turn_q4 = min(1 << 18, off * off // max(1, items[_COVARIANCE_TT] + turn >> 4))
        ahead, aside = self._path[_PATH_X] >> 4, self._path[_PATH_Y] >> 4
        distance = length(ahead, aside)
        if distance > _LEARN_MM10 and max(abs(ahead), abs(aside)) <= 120000:
            ux, uy = (ahead << 12) // distance, (aside << 12) // distance
            along, across = dx * ux + dy * uy >> 12, dy * ux - dx * uy >> 12
            cc, ss, cs = ux * ux >> 10, uy * uy >> 10, ux * uy >> 10
            variance = scaled_q14(xx, cc) + 2 * scaled_q14(xy, cs) + scaled_q14(yy, ss)
            variance = max(1, variance + place)
            turn_q4 += _square_q4(across, max(1, xx + yy + 2 * place - variance))
            turn_q4 >>= 1
            if not fix.moved:
                scale = items[_COVARIANCE_SCALE]
                self._learn_scale(distance, along, max(1, variance - (scale * scale >> 4)))
            self.way_noise.hear(_square_q4(along, variance), fix.moved, least_q4)
        self.turn_noise.hear(turn_q4, fix.moved, least_q4)
        if not fix.moved:
            self._legs = min(_NEAR_LEGS + 1, self._legs + 1)
        self.shares.settle(self.way_noise.q4, self.turn_noise.q4)

    def _least_q4(self, noise_q4):
        """How quiet wheels may be, against that noise: slips come with the way, as fast as it may be."""
        return self._model.noise_q4 - noise_q4 + _LEAST_Q4

    def _learn_scale(self, distance, along, variance):
        """From how far the marker lies off along the way since the last one."""
        loud_q4 = self.way_noise.q4
        variance_q8 = times_q4(min(variance, 1 << 19) << 4, -loud_q4)
        self.shares.learn_scale(distance // 10, along * 8 // 5, variance_q8, loud_q4)

    def _look_closely(self, fix):
        """Before there are legs to learn from: wheels that err less under a marker than the model says, on
        the way or turn that was compared, are less noisy. It is too short to show that they are noisier.

        A turn counts by what the difference of the wheels missed, half of it; all squares are in mm2 Q8.
        What else is missed: by the scatter of the detection, as odometry is of a time that is a little
        wrong, and as what is wrong with the calibration turns with the vehicle."""
        shares, half_track_mm = self.shares, self._model.half_track_mm
        way_ms = max(1, self._near_ms)
        speed_mm_s = min(8000, shares.way_mm10 * 100 // way_ms)
        turned = min(_MOST_MRAD, abs(shares.told_mrad))
        noise_q4 = self._model.at_speed_q4(speed_mm_s)
        expected = times_q4(shares.way_mm10 * _WAY_NOISE_Q20 >> 10, noise_q4) >> 6
        expected = min(1 << 19, expected * way_ms // (way_ms + _NEAR_MS) * way_ms // (way_ms + _ALIKE_MS))
        least_q4 = self._least_q4(noise_q4)
        off = max(-4000, min(4000, shares.missed_q4 * half_track_mm // 160))  # 0.01 mm
        scatter = min(_MOST_OFF, min(fix.scatter_cdeg, 3000) * half_track_mm * 7 // 400)
        late = min(_MOST_OFF, turned * half_track_mm // (way_ms * _LATE_MM_S))
        slope = self._near_drift if shares.told_mm else self._near_turns
        square = slope.rest(shares.told_mm >> 3 or shares.told_mrad >> 4, off)
        if square >= 0:
            scatter = (scatter * scatter + late * late + 19) // 20
            self.turn_noise.look(square, scatter, expected, least_q4)
        if shares.told_mm:
            off, scatter = max(-4000, min(4000, shares.off_mm10 * 10)), min(_MOST_OFF, fix.scatter_mm10 * 10)
            late = speed_mm_s // _LATE_MM_S
            swept = min(_MOST_OFF, min(fix.certain_mm10, 10000) * turned // 100)
            square = self._near_ways.rest(shares.told_mm >> 3, off)
            if square >= 0:
                scatter = (scatter * scatter + late * late + (swept * swept >> 1) + 19) // 20
                self.way_noise.look(square, scatter, expected, least_q4)
        self.way_noise.follow(self.turn_noise.q4)
        shares.settle(self.way_noise.q4, self.turn_noise.q4)


def _square_q4(off_mm10, variance_q4):
    """The square of a distance by its variance, Q4."""
    off_mm10 = min(20000, abs(off_mm10))
    return min(1 << 18, off_mm10 * off_mm10 // 25 * 64 // variance_q4)


def _variance_q4(fix):
    """Of a Fix's place, along x and along y: mm2 Q4."""
    scatter_mm10, certain_mm10 = min(fix.scatter_mm10, 10000), min(fix.certain_mm10, 10000)
    variance = scatter_mm10 * scatter_mm10 + certain_mm10 * certain_mm10
    return variance // 100 << 4 if variance > 1 << 25 else (variance << 4) // 100


def _variance_of_heading_q8(fix):
    """Of its heading: mrad2 Q8."""
    scatter, certain = mrad_q4(min(fix.scatter_cdeg, 3000)), mrad_q4(min(fix.certain_cdeg, 3000))
    return scatter * scatter + certain * certain
