"""Poses carried by odometry, in simulated drives: errors, honest sigmas, pushes, and wrong odometry."""

import random

import numpy as np
import pytest

from larics.locate.camera_model import Measurement
from larics.locate.carrier import Carrier, Fix
from larics.locate.localizer import Localizer
from larics.locate.marker_map import MarkerMap
from larics.locate.uncertainty import OdometryNoise
from larics.wire.messages import CARRIED, COASTING, LOST, MOTION_INTERPOLATED, MOTION_NONE, TRACKING
from tests.host.small_int import Small
from tools.odometry_drives import Ceiling, Wheels, between, covered, drive, p95_mm, path, tracked


def drives(speed, rate, seeds, **options):
    return np.concatenate([drive(speed, rate, seed, **options)[0] for seed in seeds])


@pytest.mark.parametrize("speed, rate, most_mm", [(200, 2.8, 20), (1000, 2.8, 40), (2000, 20, 60)])
def test_between_markers_the_pose_is_right_and_says_how_right(speed, rate, most_mm):
    frames = drives(speed, rate, range(5100, 5106), slips_m=0, seconds=max(40, 15000 / speed))
    assert not np.any(frames[:, 0] == LOST)
    carried = between(frames)
    assert len(carried) > 0.3 * len(frames) and p95_mm(carried) < most_mm
    # systematic errors are drawn once a drive: of six drives some are further off
    assert min(covered(carried)) > 0.85 and min(covered(tracked(frames))) > 0.8


def test_the_systematic_errors_are_most_of_what_is_wrong_when_tracking():
    exact = drives(1000, 20, range(5110, 5113), off=0.0, seconds=20)
    off = drives(1000, 20, range(5110, 5113), seconds=20)
    for frames in (exact, off):
        assert 2.5 < np.median(tracked(frames)[:, 4]) < 4
    assert p95_mm(tracked(exact)) < 1.5 and p95_mm(tracked(off)) > 3


def test_without_odometry_it_is_as_before():
    frames = drives(1000, 20, (5103, 5107), use=False)
    assert not np.any(frames[:, 0] == CARRIED)
    assert p95_mm(between(frames)) > 100 and min(covered(between(frames))) > 0.9


def test_wheels_whose_noise_no_encoder_sees_make_sigma_larger():
    seen = between(drives(2000, 20, range(5104, 5108), slips_m=0))
    frames = between(drives(2000, 20, range(5104, 5110), seen=False))
    assert p95_mm(frames) < 500 and min(covered(frames)) > 0.85
    assert np.median(frames[:, 4]) > 3 * np.median(seen[:, 4])


def quietness(missed_mm10, missed_cdeg, ways=4, way_mm10=2500):
    """Sigma of the place eight ways behind a first marker, 0.1 mm, under which odometry missed so much in
    each of so many ways at 2 m/s, to the left and to the right in turn; and how loud the wheels are believed
    to be."""
    carrier, wheels, fix = Carrier(OdometryNoise()), Wheels(), Fix()
    wheels.set(0, 0, 0)
    carrier.move(wheels, 0)
    fix.entry, fix.scatter_mm10, fix.scatter_cdeg, fix.certain_mm10, fix.certain_cdeg = 1, 5, 4, 29, 12
    carrier.fix(fix)
    now_us = 0
    for k in range(1, ways + 9):
        now_us += way_mm10 * 50
        wheels.x_mm10 += way_mm10
        carrier.move(wheels, now_us)
        if k <= ways:
            fix.x_mm10 = wheels.x_mm10
            fix.y_mm10 += missed_mm10
            fix.heading_cdeg = (fix.heading_cdeg + missed_cdeg * (-1) ** k) % 36000
            carrier.fix(fix)
    return carrier.sigma_y_mm10, carrier.way_noise.q4


def test_quiet_wheels_are_known_as_such_below_the_first_marker():
    loud = quietness(300, 400)
    assert quietness(1, 1)[0] < 0.15 * loud[0] and quietness(10, 30)[0] < 0.8 * loud[0]
    assert quietness(1000, 1200)[0] < 1.1 * loud[0]  # so short a way does not tell that they are louder
    assert quietness(1, 1, ways=2)[0] > 0.9 * loud[0]  # two of them tell nothing, nor do shorter ones
    assert quietness(1, 1, way_mm10=490) == quietness(300, 1, way_mm10=490)


def test_a_slow_camera_does_not_take_the_way_below_a_marker_for_one_between_markers():
    assert quietness(1, 0, way_mm10=7100)[1] == quietness(1, 0, way_mm10=14900)[1] == 0
    assert quietness(1, 0, way_mm10=15100)[1] < -20


WRONG = {
    "backwards": lambda x, y, heading: (-x, -y, heading),
    "ten times": lambda x, y, heading: (10 * x, 10 * y, heading),
    "a tenth": lambda x, y, heading: (x / 10, y / 10, heading),
    "inches": lambda x, y, heading: (x / 25.4, y / 25.4, heading),
    "axes exchanged": lambda x, y, heading: (y, x, heading),
    "clockwise": lambda x, y, heading: (x, y, -heading),
    "radians for degrees": lambda x, y, heading: (x, y, heading * 3.14159 / 180),
    "standing": lambda x, y, heading: (0, 0, 0),
}


@pytest.mark.parametrize("name", WRONG)
def test_odometry_of_the_wrong_sign_unit_or_axis_is_noticed_and_ignored(name):
    frames, localizer = drive(1000, 20, 5106, distort=WRONG[name])
    assert localizer.carrier.shares.doubted and not localizer.carried
    late = frames[len(frames) // 3 :]
    assert np.mean(late[:, 0] == CARRIED) < 0.1
    assert p95_mm(tracked(late)) < 20


def test_it_is_believed_again_when_it_fits_again():
    good, bad = (path(1000, 30, 5108, factor=factor) for factor in (1.0, 10.0))
    ceiling, wheels = Ceiling(good, 5108), Wheels()
    doubted, states = [], []
    for k in range(0, len(good), 5):
        x, y, heading, *told = (bad if k < 1000 else good)[k]
        wheels.set(*told)
        wheels.epoch = 1 if k < 1000 else 2
        seen = ceiling.see(x, y, heading)
        states.append(ceiling.localizer.update(seen, len(seen), k * 10000, wheels))
        doubted.append(ceiling.localizer.carrier.shares.doubted)
    assert any(doubted[:200]) and not any(doubted[-150:]) and CARRIED in states[-150:]


def test_one_push_is_no_wrong_odometry():
    localizer, wheels, one = a_drive_to_a_marker()
    for k in range(6, 200):
        if k % 60 == 0:  # it is put below the other marker, where it drives on
            one.marker_id = 5 - (one.marker_id or 2) if one.marker_id in (2, 3) else 2
        wheels.x_mm10 += 200
        one.offset_x_mm10 = -200 * (k % 60)
        localizer.update([one], 1, k * 50000, wheels)
        assert not localizer.carrier.shares.doubted, k
    assert localizer.state == TRACKING


def test_shares_of_the_odometry_are_learned():
    """Scale and drift by the ways from marker to marker, the turn on the spot below one."""
    localizer, wheels, one = a_drive_to_a_marker()
    for k in range(160):  # two turns, of which odometry tells 1 % more
        one.heading_cdeg = -450 * k % 36000
        wheels.heading_cdeg = 454 * k % 36000
        localizer.update([one], 1, (6 + k) * 50000, wheels)
    shares = localizer.carrier.shares
    assert abs(shares.turn.value_q20 / 2**20 + 4 / 454) < 0.003 and shares.turn.sigma_q20 < 4000
    frames, localizer = drive(1000, 20, 5111, slips_m=0, bias=0.01, off=0.2)
    shares, off = localizer.carrier.shares, np.random.default_rng(5111).normal(0, 0.01, 2)
    for share, true in (
        (shares.scale, 1 / (1 + off.mean()) - 1),
        (shares.drift, -(off[1] - off[0]) / 300 * 1000),
    ):
        assert abs(share.value_q20 / 2**20 - true) < 3 * share.sigma_q20 / 2**20 + abs(true) / 20
        assert abs(share.value_q20 / 2**20 - true) < abs(true) / 2


def a_drive_to_a_marker():
    """A localizer that tracks marker 1 at the origin, and its wheels."""
    localizer, wheels = Localizer(MarkerMap([(1, 0, 0, 0), (2, 3000, 0, 0), (3, 0, 3000, 0)])), Wheels()
    one = Measurement()
    one.marker_id, one.height_mm10, one.ring_height_mm10 = 1, 30000, 30000
    one.offset_x_mm10 = one.offset_y_mm10 = one.heading_cdeg = 0
    for k in range(6):
        assert localizer.update([one], 1, k * 50000, wheels) == (LOST if k == 0 else TRACKING)
    return localizer, wheels, one


def test_a_vehicle_that_stands_is_carried_for_long_and_one_that_drives_until_its_sigma_is_too_large():
    localizer, wheels, _ = a_drive_to_a_marker()
    for k in range(6, 1200):  # a minute
        assert localizer.update([], 0, k * 50000, wheels) == CARRIED
    assert localizer.sigma_mm10 < 40 and localizer.carrier.way_mm == 0
    last_mm10, metres = 0, 0
    while localizer.update([], 0, (k := k + 1) * 50000, wheels) == CARRIED:
        assert localizer.sigma_mm10 >= last_mm10 and abs(localizer.x_mm10 - wheels.x_mm10) < 10
        last_mm10 = localizer.sigma_mm10
        wheels.x_mm10 += 1000
        metres = wheels.x_mm10 / 10000
    assert localizer.state == LOST and 4 < metres < 30 and last_mm10 > 5000


def test_a_vehicle_that_is_put_elsewhere_is_found_within_three_frames():
    localizer, wheels, one = a_drive_to_a_marker()
    one.marker_id = 2
    states = [localizer.update([one], 1, (6 + k) * 50000, wheels) for k in range(3)]
    assert states[-1] == TRACKING and (localizer.x_mm10, localizer.y_mm10) == (30000, 0)
    assert localizer.update([], 0, 9 * 50000, wheels) == CARRIED and localizer.x_mm10 == 30000


def test_a_jump_of_the_odometry_is_no_way():
    for change in ({"epoch": 2}, {"jumps": 1}):
        localizer, wheels, _ = a_drive_to_a_marker()
        wheels.__dict__.update(change)
        wheels.x_mm10 = 50000
        assert localizer.update([], 0, 300000, wheels) == COASTING and abs(localizer.x_mm10) < 10


def test_frames_without_odometry_coast_and_are_caught_up_with():
    localizer, wheels, _ = a_drive_to_a_marker()
    wheels.x_mm10, wheels.state = 5000, MOTION_NONE
    assert localizer.update([], 0, 300000, wheels) == COASTING
    wheels.state = MOTION_INTERPOLATED
    assert localizer.update([], 0, 350000, wheels) == CARRIED and abs(localizer.x_mm10 - 5000) < 10


@pytest.mark.parametrize("seed", range(30))
def test_every_intermediate_is_a_small_integer(seed):
    rng = random.Random(seed)
    model = OdometryNoise()
    if seed % 3:
        share, low = rng.choice((-100000, 100000)), rng.choice((0, 1, 100000))
        model = OdometryNoise(
            share, -share, rng.choice((-15000, 15000)), low, low, low // 7, rng.choice((0, 1, 250000)),
            rng.choice((0, 10000)), rng.choice((20, 5000)),
        )  # fmt: skip
    for name, value in vars(model).items():
        setattr(model, name, Small(value))
    carrier, wheels, fix = Carrier(model), Wheels(), Fix()
    wheels.x_mm10 = wheels.y_mm10 = wheels.heading_cdeg = Small(0)
    now_us = Small(5)
    carrier.move(wheels, now_us)
    far = 1 << 27
    for _ in range(8):
        fix.x_mm10, fix.y_mm10 = Small(rng.choice((-far, far, 0))), Small(rng.choice((-far, far, 0)))
        if rng.random() < 0.7:  # near to where it was carried
            fix.x_mm10, fix.y_mm10 = Small(carrier.x_mm10 + rng.randint(-900, 900)), Small(carrier.y_mm10)
        fix.heading_cdeg, fix.entry = Small(rng.randrange(36000)), Small(rng.randint(1, 3))
        fix.scatter_mm10, fix.scatter_cdeg = (
            Small(rng.choice((0, 20, 20000))),
            Small(rng.choice((0, 15, 18000))),
        )
        fix.certain_mm10, fix.certain_cdeg = (
            Small(rng.choice((0, 29, 30000))),
            Small(rng.choice((0, 12, 12728))),
        )
        fix.moved = rng.random() < 0.3
        carrier.fix(fix)
        step, turn = rng.choice((30, 100, 3000, 99999)), rng.choice((5, 300, 18000))
        for _ in range(rng.choice((1, 5, 40))):
            wheels.x_mm10 = Small(int(wheels.x_mm10) + rng.randint(-step // 8, step))
            wheels.y_mm10 = Small(int(wheels.y_mm10) + rng.randint(-step // 8, step // 8))
            wheels.heading_cdeg = Small((int(wheels.heading_cdeg) + rng.randint(-turn, turn)) % 36000)
            now_us = Small((int(now_us) + rng.choice((0, 1000, 50000, 400000000))) & 0x3FFFFFFF)
            carrier.move(wheels, now_us)
        shares = carrier.shares
        for part in (carrier, shares, shares.scale, shares.turn, shares.drift):
            numbers = {name: value for name, value in vars(part).items() if isinstance(value, int)}
            numbers |= enumerate(getattr(part, "items", ()))  # what a kernel works with
            assert len(numbers) > 4 and all(abs(value) < 1 << 30 for value in numbers.values()), numbers


@pytest.mark.parametrize("seen", [True, False])
def test_after_few_legs_sigma_is_neither_too_narrow_nor_much_too_wide(seen):
    frames = []
    for seed in range(5120, 5136):
        drive_of_three = drive(2000, 20, seed, seen=seen, slips_m=0, seconds=8)[0]
        frames.append(drive_of_three[len(drive_of_three) // 3 :])  # behind the first leg
    frames = between(np.concatenate(frames))
    assert min(covered(frames)) > 0.9
    assert np.sqrt(np.mean((frames[:, 1:4] / frames[:, 4:7]) ** 2, axis=0)).min() > 0.35
