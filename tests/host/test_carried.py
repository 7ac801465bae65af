"""Poses carried by odometry, in simulated drives: errors, honest sigmas, pushes, and wrong odometry."""

import math
import random

import numpy as np
import pytest

from larics.locate.camera_model import Measurement
from larics.locate.carrier import Carrier
from larics.locate.localizer import Localizer
from larics.locate.marker_map import MarkerMap
from larics.locate.uncertainty import OdometryNoise
from larics.wire.messages import (
    CARRIED,
    COASTING,
    LOST,
    MOTION_INTERPOLATED,
    MOTION_NONE,
    TRACKING,
)
from tests.host.small_int import Small

STEP_S = 0.01
TRACK_MM = 300.0


class Wheels:
    """What larics.locate.odometry.Odometry tells of an exposure."""

    def __init__(self):
        self.state, self.epoch, self.jumps = MOTION_INTERPOLATED, 1, 0
        self.x_mm10 = self.y_mm10 = self.heading_cdeg = 0

    def set(self, x_mm, y_mm, heading):
        self.x_mm10, self.y_mm10 = round(x_mm * 10), round(y_mm * 10)
        self.heading_cdeg = round(math.degrees(heading) * 100) % 36000


def path(speed, seconds, seed, seen=True, factor=1.0):
    """[(x, y, heading true; the same by odometry)] each STEP_S: wheels with 0.3 % bias and 2 % noise that
    `seen` encoders measure, slips of 0.02 a metre; `factor` falsifies the odometry's forward way."""
    rng = np.random.default_rng(seed)
    bias, noise, turn = rng.normal(0, 0.003, 2), np.zeros(2), 0.0
    true, told, found = np.zeros(3), np.zeros(3), []
    for k in range(int(seconds / STEP_S)):
        if k % 200 == 0:
            turn = rng.uniform(-0.4, 0.4) * speed / 1000
        keep = math.exp(-STEP_S / 0.08)
        noise = noise * keep + rng.normal(0, 0.02 * math.sqrt(1 - keep * keep), 2)
        wanted = np.array([speed - turn * TRACK_MM / 2, speed + turn * TRACK_MM / 2]) * STEP_S
        driven = wanted * (1 + noise)
        slip = np.zeros(2)
        if rng.random() < 0.02 * speed / 1000 * STEP_S:
            slip[rng.integers(2)] = rng.normal(0, 5)
        for pose, wheels, scale in (
            (true, driven, 1.0),
            (told, (driven if seen else wanted) * (1 + bias) + slip, factor),
        ):
            forward, angle = wheels.mean() * scale, (wheels[1] - wheels[0]) / TRACK_MM
            pose[0] += forward * math.cos(pose[2] + angle / 2)
            pose[1] += forward * math.sin(pose[2] + angle / 2)
            pose[2] += angle
        found.append((*true, *told))
    return found


class Ceiling:
    """Markers 2 to 5 m apart along a path, seen within 600 mm; map and camera off by their usual errors."""

    def __init__(self, found, seed):
        rng = self.rng = np.random.default_rng(seed + 77)
        self.marks, way, following = [], 0.0, rng.uniform(200, 800)
        for before, now in zip(found, found[1:], strict=False):
            way += math.dist(before[:2], now[:2])
            if way > following:
                place = np.array(now[:2]) + rng.uniform(-200, 200, 2)
                if all(math.dist(place, one[:2]) > 600 for one in self.marks):
                    self.marks.append((*place, rng.uniform(0, 360)))
                following = way + rng.uniform(2000, 5000)
        rows = [
            (k + 1, round(x + rng.normal(0, 1)), round(y + rng.normal(0, 1)),
             round((turn + rng.normal(0, 0.1)) * 100) % 36000)
            for k, (x, y, turn) in enumerate(self.marks)
        ]  # fmt: skip
        self.localizer = Localizer(MarkerMap(rows))
        self.focal = rng.normal(0, 0.001)
        self.tilt_mm = rng.normal(0, math.radians(0.05), 2) * 3000

    def see(self, x, y, heading):
        seen = []
        for k, (mark_x, mark_y, turn) in enumerate(self.marks):
            dx, dy = mark_x - x, mark_y - y
            if math.hypot(dx, dy) > 600:
                continue
            c, s = math.cos(heading), math.sin(heading)
            offset = np.array([c * dx + s * dy, c * dy - s * dx]) * (1 + self.focal) + self.tilt_mm
            offset += self.rng.normal(0, 0.4, 2)
            one = Measurement()
            one.marker_id = k + 1
            one.offset_x_mm10, one.offset_y_mm10 = (round(value * 10) for value in offset)
            one.heading_cdeg = round((turn - math.degrees(heading) + self.rng.normal(0, 0.04)) * 100) % 36000
            one.height_mm10 = one.ring_height_mm10 = 30000
            seen.append(one)
        return seen


def drive(speed, rate, seed, use=True, seconds=40, **options):
    """[(state, error x mm, y mm, deg, sigma x mm, y mm, deg)] of each frame after the first marker."""
    found = path(speed, seconds, seed, **options)
    ceiling, wheels, frames = Ceiling(found, seed), Wheels(), []
    localizer = ceiling.localizer
    for k in range(0, len(found), round(1 / rate / STEP_S)):
        x, y, heading, *told = found[k]
        wheels.set(*told)
        seen = ceiling.see(x, y, heading)
        state = localizer.update(seen, len(seen), round(k * STEP_S * 1e6), wheels if use else None)
        if state != TRACKING and not frames:
            continue
        carrier = localizer.carrier
        turned = (localizer.heading_cdeg / 100 - math.degrees(heading) + 180) % 360 - 180
        sigmas = (localizer.sigma_mm10 / 10, localizer.sigma_mm10 / 10, localizer.sigma_cdeg / 100)
        if localizer.carried:
            sigmas = (carrier.sigma_x_mm10 / 10, carrier.sigma_y_mm10 / 10, carrier.sigma_cdeg / 100)
        frames.append((state, localizer.x_mm10 / 10 - x, localizer.y_mm10 / 10 - y, turned, *sigmas))
    return np.array(frames), localizer


def between(frames):
    return frames[(frames[:, 0] == CARRIED) | (frames[:, 0] == COASTING)]


def p95_mm(frames):
    return np.percentile(np.hypot(frames[:, 1], frames[:, 2]), 95)


def covered(frames):
    """Shares of x, y and heading within two of their own sigmas."""
    return np.mean(np.abs(frames[:, 1:4]) <= 2 * frames[:, 4:7], axis=0)


@pytest.mark.parametrize("speed, rate, most_mm", [(1000, 2.8, 40), (1000, 20, 40), (2000, 20, 60)])
def test_between_markers_the_pose_is_right_and_says_how_right(speed, rate, most_mm):
    frames = np.concatenate([drive(speed, rate, seed)[0] for seed in (5100, 5101, 5102)])
    assert not np.any(frames[:, 0] == LOST)
    carried = between(frames)
    assert len(carried) > 0.4 * len(frames) and p95_mm(carried) < most_mm
    assert min(covered(carried)) > 0.9 and min(covered(frames[frames[:, 0] == TRACKING])) > 0.9


def test_without_odometry_it_is_as_before():
    frames, localizer = drive(1000, 20, 5103, use=False)
    assert not np.any(frames[:, 0] == CARRIED) and not localizer.carried
    assert p95_mm(between(frames)) > 100


def test_wheels_whose_noise_no_encoder_sees_make_sigma_larger():
    seen = between(drive(2000, 20, 5104)[0])
    frames = np.concatenate([between(drive(2000, 20, seed, seen=False)[0]) for seed in (5104, 5105)])
    late = frames[len(frames) // 4 :]
    assert p95_mm(frames) < 500 and min(covered(late)) > 0.8
    assert np.median(late[:, 4]) > 3 * np.median(seen[:, 4])


@pytest.mark.parametrize("factor", [-1.0, 10.0])
def test_odometry_of_the_wrong_sign_or_unit_is_noticed_and_ignored(factor):
    frames, localizer = drive(1000, 20, 5106, factor=factor)
    assert localizer.carrier.doubted and not localizer.carried
    late = frames[len(frames) // 2 :]
    assert not np.any(late[:, 0] == CARRIED) and np.any(late[:, 0] == TRACKING)
    tracking = late[late[:, 0] == TRACKING]
    assert p95_mm(tracking) < 20


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
    carrier, wheels = Carrier(OdometryNoise()), Wheels()
    wheels.x_mm10 = wheels.y_mm10 = wheels.heading_cdeg = Small(0)
    carrier.move(wheels)
    far = 1 << 27
    for _ in range(8):
        x, y = Small(rng.choice((-far, far, 0))), Small(rng.choice((-far, far, 0)))
        if rng.random() < 0.7:  # near to where it was carried
            x, y = Small(carrier.x_mm10 + rng.randint(-900, 900)), Small(carrier.y_mm10)
        sigmas = Small(rng.choice((0, 20, 65535))), Small(rng.choice((0, 15, 65535)))
        carrier.fix(x, y, Small(rng.randrange(36000)), *sigmas, Small(29), Small(12))
        step, turn = rng.choice((30, 100, 3000, 99999)), rng.choice((5, 300, 18000))
        for _ in range(rng.choice((1, 5, 40))):
            wheels.x_mm10 = Small(int(wheels.x_mm10) + rng.randint(-step // 8, step))
            wheels.y_mm10 = Small(int(wheels.y_mm10) + rng.randint(-step // 8, step // 8))
            wheels.heading_cdeg = Small((int(wheels.heading_cdeg) + rng.randint(-turn, turn)) % 36000)
            carrier.move(wheels)
        for name, value in vars(carrier).items():
            assert name == "_model" or isinstance(value, bool) or abs(value) < 1 << 30, name
