"""Drives by markers and odometry without pictures: errors of the pose and how often its sigma is right.

    python tools/odometry_drives.py [--drives 12] [--seconds 60] [--seed 5000] [--only SPEED]

The localizer gets what the detector would measure, with its noise and with errors of calibration and map that
are drawn once a drive, as large as the settings say; and what encoders would tell, with bias and slips, and
for "unseen" without the noise of the wheels.
"""

import argparse
import math
import sys

import numpy as np

from larics.locate.camera_model import Measurement
from larics.locate.localizer import Localizer
from larics.locate.marker_map import MarkerMap
from larics.locate.uncertainty import Systematic
from larics.wire.messages import CARRIED, COASTING, LOST, MOTION_INTERPOLATED, TRACKING

STEP_S = 0.01
TRACK_MM = 300.0
HEIGHT_MM = 3000.0
REACH_MM = 600.0
SPEEDS_MM_S, RATES_HZ = (200, 1000, 2000), (2.8, 20, 60)


class Wheels:
    """What larics.locate.odometry.Odometry tells of an exposure."""

    def __init__(self):
        self.state, self.epoch, self.jumps = MOTION_INTERPOLATED, 1, 0
        self.x_mm10 = self.y_mm10 = self.heading_cdeg = 0
        self.is_standing = False

    def set(self, x_mm, y_mm, heading):
        self.x_mm10, self.y_mm10 = round(x_mm * 10), round(y_mm * 10)
        self.heading_cdeg = round(math.degrees(heading) * 100) % 36000


def path(speed, seconds, seed, seen=True, factor=1.0, bias=0.003, slips_m=0.02, noise_s=0.3):
    """[(x, y, heading true; the same by odometry)] each STEP_S: wheels with bias and 2 % of noise, which
    `seen` encoders measure, and slips of 5 mm; `factor` falsifies the odometry's forward way."""
    rng = np.random.default_rng(seed)
    off, noise, turn = rng.normal(0, bias, 2), np.zeros(2), 0.0
    true, told, found = np.zeros(3), np.zeros(3), []
    keep = math.exp(-STEP_S / noise_s)
    for k in range(int(seconds / STEP_S)):
        if k % 200 == 0:
            turn = rng.uniform(-0.4, 0.4) * speed / 1000
        noise = noise * keep + rng.normal(0, 0.02 * math.sqrt(1 - keep * keep), 2)
        wanted = np.array([speed - turn * TRACK_MM / 2, speed + turn * TRACK_MM / 2]) * STEP_S
        driven = wanted * (1 + noise)
        slip = np.zeros(2)
        if rng.random() < slips_m * speed / 1000 * STEP_S:
            slip[rng.integers(2)] = rng.normal(0, 5)
        counted = (driven if seen else wanted) * (1 + off) + slip
        for pose, wheels, scale in ((true, driven, 1.0), (told, counted, factor)):
            forward, angle = wheels.mean() * scale, (wheels[1] - wheels[0]) / TRACK_MM
            pose[0] += forward * math.cos(pose[2] + angle / 2)
            pose[1] += forward * math.sin(pose[2] + angle / 2)
            pose[2] += angle
        found.append((*true, *told))
    return found


class Ceiling:
    """Markers 2 to 5 m apart along a path, seen within REACH_MM; map and camera are off by their standard
    deviations times `off`."""

    def __init__(self, found, seed, off=1.0, noise=None):
        rng = self.rng = np.random.default_rng(seed + 77)
        self.marks, way, following = [], 0.0, rng.uniform(200, 800)
        for before, now in zip(found, found[1:], strict=False):
            way += math.dist(before[:2], now[:2])
            if way > following:
                place = np.array(now[:2]) + rng.uniform(-200, 200, 2)
                if all(math.dist(place, one[:2]) > REACH_MM for one in self.marks):
                    self.marks.append((*place, rng.uniform(0, 360)))
                following = way + rng.uniform(2000, 5000)
        rows = [
            (k + 1, round(x + off * rng.normal(0, 1)), round(y + off * rng.normal(0, 1)),
             round((turn + off * rng.normal(0, 0.1)) * 100) % 36000)
            for k, (x, y, turn) in enumerate(self.marks)
        ]  # fmt: skip
        self.localizer = Localizer(
            MarkerMap(rows), speed_mm_s=2500, systematic=Systematic(), odometry_noise=noise
        )
        self.scale = 1 + off * rng.normal(0, 0.001) + off * rng.normal(0, 3.0) / HEIGHT_MM
        self.offset_mm = off * rng.normal(0, math.radians(0.05) * HEIGHT_MM, 2) + off * rng.normal(0, 1.0, 2)
        self.mount = math.radians(off * rng.normal(0, 0.05))

    def see(self, x, y, heading):
        """The Measurements of a frame."""
        seen = []
        for k, (mark_x, mark_y, turn) in enumerate(self.marks):
            dx, dy = mark_x - x, mark_y - y
            if math.hypot(dx, dy) > REACH_MM:
                continue
            towards = heading + self.mount
            c, s = math.cos(towards), math.sin(towards)
            offset = np.array([c * dx + s * dy, c * dy - s * dx]) * self.scale + self.offset_mm
            offset += self.rng.normal(0, 0.4, 2)
            one = Measurement()
            one.marker_id = k + 1
            one.offset_x_mm10, one.offset_y_mm10 = (round(value * 10) for value in offset)
            direction = turn - math.degrees(towards) + self.rng.normal(0, 0.04)
            one.heading_cdeg = round(direction * 100) % 36000
            one.height_mm10 = one.ring_height_mm10 = round(HEIGHT_MM * 10)
            one.sigma_mm10, one.sigma_mdeg = 5, 40
            seen.append(one)
        return seen


def drive(speed, rate, seed, use=True, seconds=40, noise=None, off=1.0, distort=None, **options):
    """[(state, error x mm, y mm, deg, sigma x mm, y mm, deg)] of each frame after the first marker, and the
    localizer; distort: function of what odometry tells (x mm, y mm, radians), which makes it wrong."""
    found = path(speed, seconds, seed, **options)
    ceiling, wheels, frames = Ceiling(found, seed, off, noise), Wheels(), []
    localizer, last = ceiling.localizer, -1
    for k in range(int(seconds * rate)):
        at = round(k / rate / STEP_S)
        if at == last or at >= len(found):
            continue
        last = at
        x, y, heading, *told = found[at]
        wheels.set(*(distort(*told) if distort else told))
        seen = ceiling.see(x, y, heading)
        state = localizer.update(seen, len(seen), round(at * STEP_S * 1e6), wheels if use else None)
        if state != TRACKING and not frames:
            continue
        turned = (localizer.heading_cdeg / 100 - math.degrees(heading) + 180) % 360 - 180
        sigmas = localizer.sigma_x_mm10 / 10, localizer.sigma_y_mm10 / 10, localizer.sigma_cdeg / 100
        frames.append((state, localizer.x_mm10 / 10 - x, localizer.y_mm10 / 10 - y, turned, *sigmas))
    return np.array(frames), localizer


def between(frames):
    return frames[(frames[:, 0] == CARRIED) | (frames[:, 0] == COASTING)]


def tracked(frames):
    return frames[frames[:, 0] == TRACKING]


def p95_mm(frames):
    return np.percentile(np.hypot(frames[:, 1], frames[:, 2]), 95)


def covered(frames):
    """Shares of x, y and heading within two of their own sigmas."""
    return np.mean(np.abs(frames[:, 1:4]) <= 2 * frames[:, 4:7], axis=0)


def _row(frames):
    off = np.hypot(frames[:, 1], frames[:, 2])
    numbers = (*(np.percentile(off, q) for q in (50, 95, 100)), *(100 * covered(frames)))
    return "%5.1f %6.1f %7.1f  [%3.0f %3.0f %3.0f]" % numbers


def main(arguments=None):
    """Returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--drives", type=int, default=24, help="of each kind")
    parser.add_argument("--seed", type=int, default=5000, help="of the first drive; those below 1000 tune")
    parser.add_argument("--speed", type=int, action="append", metavar="MM_S", help="200, 1000 and 2000")
    parser.add_argument("--rate", type=float, action="append", metavar="HZ", help="2.8, 20 and 60")
    parser.add_argument("--slips", type=float, default=0.02, help="a metre")
    args = parser.parse_args(arguments)
    print(
        "errors of the place, p50 p95 max mm [x, y, heading within 2 sigma, %], tracking and between markers;"
    )
    print("frames lost")
    for name, options in (("seen", {}), ("unseen", {"seen": False}), ("none", {"use": False})):
        for speed in args.speed or SPEEDS_MM_S:
            for rate in args.rate or RATES_HZ:
                seconds = max(40, 30000 / speed)
                drives = [
                    drive(speed, rate, seed, seconds=seconds, slips_m=args.slips, **options)[0]
                    for seed in range(args.seed, args.seed + args.drives)
                ]
                frames = np.concatenate(drives)
                rows = _row(tracked(frames)), _row(between(frames))
                lost = int(np.sum(frames[:, 0] == LOST))
                print("%-8s %5d %8.1f  %s   %s  %5d" % (name, speed, rate, *rows, lost), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
