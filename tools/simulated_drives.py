"""Simulated drives of a vehicle with odometry under markers that are hardly ever seen together.

Two wheels, 300 mm apart: a bias each, noise and slips that the encoders do not see. A camera that sees what
is within its view, with the noise of readings and the errors that a calibration leaves. Nothing here is the
product's own estimation: only its wire is used, to write the log that a camera would have sent. What was
true stays in `Drive`.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from larics.marker import CODED
from larics.wire import messages as m
from larics.wire.codec import Encoder
from larics_host.connection import records

TRACK_MM = 300.0
_VIEW_MM = (650.0, 820.0)  # ahead and aside of the lens in which a marker is whole
_SLIP_MM = 7.0  # standard deviation of one wheel's way in a slip
_NOISE_MM2_MM = 0.0005  # of each wheel, unseen, between slips


@dataclass
class World:
    """What a drive goes through. Shares and rates: wrong of the passages, wrong_frames of the single readings
    with another ID; slips per metre; bias and noise of the wheels; spacing and number of the markers."""

    markers: int = 30
    spacing_mm: float = 3000.0
    length_m: float = 200.0
    slips: float = 0.02
    wrong: float = 0.03
    wrong_frames: float = 0.01
    bias: float = 0.003
    ids: int = 0  # so many different IDs; 0: each its own
    moved: bool = True  # one marker is hung elsewhere half way
    carried_m: float = 0.0  # after so many metres the vehicle is carried off, unseen by its wheels; 0: never
    speed_mm_s: float = 1000.0
    rate: float = 30.0


@dataclass
class Drive:
    """hall: [(ID, x mm, y mm, heading deg)], as it is at the end; moved: number of the one that was moved,
    or None; frames: [(number, vehicle pose in odometry (x, y, deg), way mm, turn deg, [(ID, x, y, deg)])];
    misread: [(frame, ID read)] of passages read wrong; passages: how many there were; path: true poses."""

    hall: list
    moved: int | None = None
    frames: list = field(default_factory=list)
    misread: list = field(default_factory=list)
    passages: int = 0
    path: list = field(default_factory=list)


def hall_of(world: World, rng: np.random.Generator) -> list:
    """Markers on a crooked grid; with repeated IDs the same one is never a neighbour of itself."""
    columns = math.ceil(math.sqrt(world.markers * 1.2))
    known = CODED.ids()
    hall = []
    for k in range(world.markers):
        row, column = divmod(k, columns)
        if world.ids:
            marker_id = (column + 3 * row) % world.ids + 1
        else:
            marker_id = known[int(rng.integers(0, 100)) + 100 * k % (len(known) - 100)]
        x, y = (world.spacing_mm * step + rng.uniform(-300, 300) for step in (column, row))
        hall.append((marker_id, x, y, float(rng.uniform(0, 360))))
    return hall


def _tour(world, hall, rng):
    """Numbers of markers in the order of driving: each time one of the least visited neighbours."""
    places = np.array([one[1:3] for one in hall])
    visits = np.zeros(len(hall))
    order, driven, before = [0], 0.0, -1
    while driven < 1000 * world.length_m:
        here = order[-1]
        visits[here] += 1
        apart = np.hypot(*(places - places[here]).T)
        near = [k for k in np.argsort(apart) if 0 < apart[k] < 1.35 * world.spacing_mm]
        score = [visits[k] + rng.uniform(0, 0.9) + (2 if k == before else 0) for k in near]
        before = here
        order.append(int(near[int(np.argmin(score))]))
        driven += float(apart[order[-1]])
    return order


class _Wheels:
    """The true pose and that of the odometry."""

    def __init__(self, world, rng):
        self.world, self.rng = world, rng
        self.pose = [0.0, 0.0, 0.0]
        self.odometry = [rng.uniform(-9000, 9000), rng.uniform(-9000, 9000), rng.uniform(-math.pi, math.pi)]
        self.way = self.turn = 0.0
        self.driven = 0.0
        self._bias = 1 + rng.normal(0, world.bias, 2)

    def step(self, ahead, turn):
        """Drives so far, and turns by so much, in truth; the odometry follows as its wheels see it."""
        _move(self.pose, ahead, turn)
        self.driven += abs(ahead)
        ways = np.array([ahead - turn * TRACK_MM / 2, ahead + turn * TRACK_MM / 2])
        noise = self.rng.normal(0, 1, 2) * np.sqrt(_NOISE_MM2_MM * np.abs(ways))
        seen = ways * self._bias + noise
        if self.rng.random() < self.world.slips * np.abs(ways).max() / 1000:
            seen[self.rng.integers(2)] += self.rng.normal(0, _SLIP_MM)
        moved, turned = seen.mean(), (seen[1] - seen[0]) / TRACK_MM
        _move(self.odometry, moved, turned)
        self.way += abs(moved)
        self.turn += abs(turned)


def _move(pose, ahead, turn):
    middle = pose[2] + turn / 2
    pose[0] += ahead * math.cos(middle)
    pose[1] += ahead * math.sin(middle)
    pose[2] += turn


class _Camera:
    """What the camera reads, with the errors that its calibration left."""

    def __init__(self, world, rng, drive):
        self.world, self.rng, self.drive = world, rng, drive
        self._tilt = rng.normal(0, 2.4, 2)  # 0.05 degrees at 2.75 m
        self._mount = rng.normal(0, math.radians(0.05))
        self._focal = 1 + rng.normal(0, 0.001)
        self._ids = sorted({one[0] for one in drive.hall})
        self._in_view = {}  # number -> ID read all along, None for the true one

    def read(self, frame, pose, hall):
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        seen, in_view = [], {}
        for k, (marker_id, x, y, heading) in enumerate(hall):
            dx, dy = x - pose[0], y - pose[1]
            if abs(dx) > 1100 or abs(dy) > 1100:
                continue
            ahead, left = cos * dx + sin * dy, cos * dy - sin * dx
            if abs(ahead) > _VIEW_MM[0] or abs(left) > _VIEW_MM[1]:
                continue
            if k in self._in_view:
                in_view[k] = self._in_view[k]
            else:
                self.drive.passages += 1
                in_view[k] = None
                if self.rng.random() < self.world.wrong:
                    in_view[k] = self._other(marker_id)
                    self.drive.misread.append((frame, in_view[k]))
            read = in_view[k] or marker_id
            if self.rng.random() < self.world.wrong_frames:
                read = self._other(marker_id)
            c, s = math.cos(self._mount), math.sin(self._mount)
            off = self._focal * ahead, self._focal * left
            place = c * off[0] - s * off[1] + self._tilt[0], s * off[0] + c * off[1] + self._tilt[1]
            place = [value + self.rng.normal(0, 0.5) for value in place]
            turned = heading - math.degrees(pose[2] - self._mount) + self.rng.normal(0, 0.05)
            seen.append((read, *place, turned))
        self._in_view = in_view
        return seen

    def _other(self, marker_id):
        return int(self.rng.choice([one for one in self._ids if one != marker_id]))


def drive(world: World, seed: int) -> Drive:
    """A Drive through a hall of its own: on the spot turned to the next marker, then there, not quite
    straight."""
    rng = np.random.default_rng(seed)
    hall = hall_of(world, rng)
    result = Drive(hall)
    wheels, camera = _Wheels(world, rng), _Camera(world, rng, result)
    wheels.pose[:2] = hall[0][1:3]
    step = world.speed_mm_s / world.rate
    order = _tour(world, hall, rng)
    half = len(order) // 2
    visits = [min(order[1:half].count(k), order[half + 1 :].count(k)) for k in range(len(hall))]
    often = int(rng.choice(np.flatnonzero(np.array(visits) == max(visits))))
    frame, carried = 1, False
    before = list(hall)
    for index, number in enumerate(order[1:], 1):
        if world.moved and max(visits) and index == half:  # who never comes by again cannot tell
            marker_id, x, y, heading = hall[often]
            angle, way = rng.uniform(0, 2 * math.pi), rng.uniform(150, 500)
            place = x + way * math.cos(angle), y + way * math.sin(angle)
            hall[often] = (marker_id, *place, (heading + rng.uniform(-40, 40)) % 360)
            result.moved = often
            before = list(hall)
        goal = np.array(before[number][1:3]) + rng.normal(0, 100, 2)
        while True:
            dx, dy = goal - wheels.pose[:2]
            away = math.hypot(dx, dy)
            if away < 2 * step:
                break
            off = (math.atan2(dy, dx) - wheels.pose[2] + math.pi) % (2 * math.pi) - math.pi
            if abs(off) > 0.35:  # on the spot, at 90 degrees a second
                wheels.step(0.0, math.copysign(min(abs(off), 1.57 / world.rate), off))
            else:
                wheels.step(step, max(-0.03, min(0.03, off * 0.1)))
            if world.carried_m and not carried and wheels.driven > 1000 * world.carried_m:
                carried = True
                wheels.pose[2] += rng.choice([-1, 1]) * rng.uniform(0.5, 1.2)
                wheels.pose[0] += rng.uniform(-1500, 1500)
            seen = camera.read(frame, wheels.pose, hall)
            state = tuple(wheels.odometry), wheels.way, wheels.turn
            result.frames.append((frame, *state, seen))
            result.path.append(tuple(wheels.pose))
            frame += 1
    return result


def messages_of(one: Drive) -> Iterator[tuple[int, list[int]]]:
    """Yields (type, values) of what a camera sends: the markers of each frame, then its motion."""
    for frame, (x, y, heading), way, turn, seen in one.frames:
        for index, (marker_id, ahead, left, turned) in enumerate(seen):
            place = round(10 * ahead), round(10 * left), 27500, round(100 * turned) % 36000
            yield m.MARKER, [frame, 20000, 0, marker_id, index, len(seen), *place, 99, 7680, 100, 30]
        if not seen:
            yield m.MARKER, [frame, 20000, m.MARKER_NONE, m.ID_NONE, 0, 0, 0, 0, 0, 0, 0, 0, 65535, 65535]
        pose = round(10 * x), round(10 * y), round(math.degrees(heading) * 100) % 36000
        sums = round(10 * way), round(math.degrees(turn) * 100)
        yield m.MOTION, [frame, m.MOTION_INTERPOLATED, 0, *pose, *sums, 0]


def write_log(path: Path, one: Drive) -> Path:
    """The log of a drive: raw bytes for .bin, else JSON lines."""
    if path.suffix == ".bin":
        encoder = Encoder()
        with open(path, "wb") as file:
            for number, values in messages_of(one):
                file.write(encoder.buffer[: encoder.encode(number, values)])
        return path
    with open(path, "w") as file:
        for sequence, (number, values) in enumerate(messages_of(one)):
            record = records.record_of(number, values)
            name = "MARKER" if number == m.MARKER else "MOTION"
            head = {"time_s": round(values[0] / 30, 6), "message": name, "sequence": sequence & 0xFFFF}
            file.write(json.dumps({**head, **records.as_json(record)}) + "\n")
    return path
