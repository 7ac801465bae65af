"""Odometry messages in C against the same motion in floats."""

import math
import random

import pytest

from c_parts import Parts
from larics.wire import messages as m
from larics.wire.codec import Decoder, fields

TRACK_MM = 300


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    return Parts(tmp_path_factory.mktemp("wheels"))


def read(data):
    found = []
    names = [name for name, *_ in fields(m.ODOMETRY)]
    decoder = Decoder(lambda number, _, values: found.append((number, dict(zip(names, values, strict=True)))))
    decoder.feed(data, len(data))
    assert [number for number, _ in found] == [m.ODOMETRY]
    return found[0][1]


def test_ten_minutes_of_wheels(parts):
    draw = random.Random(7)
    parts.init(1)
    x = y = heading = 0.0
    left_speed = right_speed = 0.0
    worst_mm = 0.0
    for step in range(60_000):
        if step % 100 == 0:
            left_speed, right_speed = draw.uniform(-300, 1000), draw.uniform(-300, 1000)
        left_um, right_um = (round(speed * 10 + draw.uniform(-1, 1)) for speed in (left_speed, right_speed))
        assert parts.roll(left_um, right_um, TRACK_MM, step * 10_000)
        turn = (right_um - left_um) / 1000 / TRACK_MM
        way = (left_um + right_um) / 2000
        x += way * math.cos(heading + turn / 2)
        y += way * math.sin(heading + turn / 2)
        heading += turn
        if step % 1000 == 0:
            told = read(parts.odometry(step * 10_000))
            worst_mm = max(worst_mm, math.hypot(told["x_mm10"] / 10 - x, told["y_mm10"] / 10 - y))
            off = told["heading_cdeg"] / 100 - math.degrees(heading)
            assert abs((off + 180) % 360 - 180) < 0.05
    assert worst_mm < 30  # of 200 m


def test_times_flags_and_epochs(parts):
    parts.init(0x01020304)
    assert read(parts.odometry(5))["flags"] == m.ODOMETRY_STANDING
    parts.move(1000, 0, 2**32 - 1000)
    told = read(parts.odometry(500))  # the clock has wrapped
    assert told["age_us"] == 1500 and told["time_us"] == (2**32 - 1000) & m.COUNT_MAX
    assert (told["x_mm10"], told["y_mm10"], told["flags"], told["epoch"]) == (10, 0, 0, 1 ^ 2 ^ 3 ^ 4)
    parts.jump()
    assert read(parts.odometry(500))["epoch"] == told["epoch"] + 1
    parts.place(999_999_990, is_slipping=True)
    parts.move(100_000, 0, 1000)  # beyond what the wire carries: the next epoch begins at 0
    told = read(parts.odometry(1000))
    assert (told["x_mm10"], told["flags"], told["epoch"]) == (0, m.ODOMETRY_SLIP, (1 ^ 2 ^ 3 ^ 4) + 2)


def test_what_cannot_be_a_motion_is_refused(parts):
    parts.init(1)
    for left, right, track in (
        (200_001, 0, 300),
        (0, -200_001, 300),
        (0, 0, 9),
        (0, 0, 5001),
        (-150_000, 150_000, 300),
    ):
        assert not parts.roll(left, right, track, 0)
    assert not parts.move(0, 90_001, 0) and not parts.roll(-40_000, 40_000, 20, 0)
    assert read(parts.odometry(0))["x_mm10"] == 0
