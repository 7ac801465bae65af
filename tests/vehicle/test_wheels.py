"""Odometry messages in C against the same motion in floats."""

import math
import random

import pytest

from c_parts import Parts
from larics.wire import messages as m
from larics.wire.codec import Decoder, Encoder, fields
from larics_vehicle.odometer import Odometer

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


def test_the_same_as_the_python_reference_at_every_step(parts):
    """100,000 calls over the whole range and beyond it, and the bytes of messages now and then."""
    draw = random.Random(5003)
    encoder, refused, resets = Encoder(), 0, 0
    for round_ in range(20):
        parts.init(round_)
        ours, now_us = Odometer(epoch=round_), draw.randrange(2**32)
        encoder.sequence = parts.sequence()
        bound = draw.choice((3, 500, 20_000, 200_000))
        track_mm = draw.choice((10, 11, 160, 300, 557, 5000))
        for step in range(5000):
            now_us = (now_us + draw.choice((1000, 20_000, 2_000_000))) % 2**32
            left, right = draw.randint(-bound, bound), draw.randint(-bound, bound)
            kind = draw.random()
            if kind < 0.002:
                ours.x_mm10 = draw.choice((-499_999_999, 500_000_000, 499_999_900))
                parts.place(ours.x_mm10, False)
            if kind < 0.004:
                ours.reset()
                parts.reset()
            elif kind < 0.5:
                turn = draw.choice((0, 1, -1, 9_000_000, -9_000_001, draw.randint(-bound * 40, bound * 40)))
                wanted = ours.move(left, turn, now_us & m.COUNT_MAX)
                assert parts.move(left, turn, now_us) == wanted, (round_, step)
            else:
                if kind < 0.6:
                    left = right = draw.choice((0, left, -200_001))
                track = draw.choice((9, 5001, 65535)) if kind > 0.99 else track_mm
                wanted = ours.roll(left, right, track, now_us & m.COUNT_MAX)
                refused += not wanted
                assert parts.roll(left, right, track, now_us) == wanted, (round_, step)
            found = (ours.x_mm10, ours.y_mm10, ours._heading_mcdeg, ours.epoch, ours.is_standing)
            assert parts.wheels() == found, (round_, step)
            if step % 50 == 0:
                size = encoder.encode(m.ODOMETRY, ours.message(now_us & m.COUNT_MAX))
                assert parts.odometry(now_us) == bytes(encoder.buffer[:size])
        resets += ours.epoch - round_
    assert refused > 1000 and resets > 100


def test_times_flags_and_epochs(parts):
    parts.init(0x01020304)
    assert read(parts.odometry(5))["flags"] == m.ODOMETRY_STANDING
    parts.move(1000, 0, 2**32 - 1000)
    told = read(parts.odometry(500))  # the clock has wrapped
    assert told["age_us"] == 1500 and told["time_us"] == (2**32 - 1000) & m.COUNT_MAX
    assert (told["x_mm10"], told["y_mm10"], told["flags"], told["epoch"]) == (10, 0, 0, 1 ^ 2 ^ 3 ^ 4)
    parts.reset()
    assert read(parts.odometry(500))["epoch"] == told["epoch"] + 1
    parts.place(499_999_990, is_slipping=True)
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
        (-70_000, 70_001, 300),
        (-(2**31), 0, 300),
    ):
        assert not parts.roll(left, right, track, 0)
    assert not parts.move(0, 9_000_001, 0) and not parts.move(0, -(2**31), 0)
    assert not parts.roll(-40_000, 40_000, 20, 0)
    assert read(parts.odometry(0))["x_mm10"] == 0
