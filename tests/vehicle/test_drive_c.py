"""The C library drives exactly as the Python reference does: the same commands at every step."""

import math
import random

import pytest

from larics.arith import fixed
from larics.locate.route import Route
from larics.wire import messages as m
from larics.wire.codec import Encoder
from larics_host.drive.c_controller import CController, compiler
from larics_vehicle.approach import ALIGN, ARRIVED, CENTER, GO, HALT, SEARCH, Approach
from recorded import message

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler: apt-get install gcc")

STEPS = 100_000


class World:
    """A vehicle that does as commanded, under markers a few metres apart, and what a poor camera says."""

    def __init__(self, generator):
        self.random = generator
        self.side_mm = generator.choice((900, 2000, 4000))
        self.view_mm = generator.choice((400, 900, 1500))
        self.rate_ms = generator.choice((20, 50, 357))
        self.trouble = generator.choice((0, 0.02, 0.2))
        self.with_map = generator.random() < 0.6
        self.x = self.y = self.heading = 0.0
        self.frame = 0
        self.wait_ms = 0

    def move(self, speed_mm_s, turn_cdeg_s, elapsed_ms):
        self.heading += math.radians(turn_cdeg_s / 100) * elapsed_ms / 1000 * self.random.uniform(0.97, 1.03)
        way = speed_mm_s * elapsed_ms / 1000
        self.x += way * math.cos(self.heading)
        self.y += way * math.sin(self.heading)
        if self.random.random() < 0.0005:  # pushed
            self.x += self.random.uniform(-1500, 1500)
            self.heading += self.random.uniform(-2, 2)

    def _markers(self):
        side = self.side_mm
        column, row = round(self.x / side), round(self.y / side)
        for c in (column - 1, column, column + 1):
            for r in (row - 1, row, row + 1):
                dx, dy = c * side - self.x, r * side - self.y
                forward = dx * math.cos(self.heading) + dy * math.sin(self.heading)
                left = dy * math.cos(self.heading) - dx * math.sin(self.heading)
                if math.hypot(forward, left) < self.view_mm:
                    yield 1 + (c + 3 * r) % 7, forward, left, (c * 90 + r * 37) % 360

    def messages(self, elapsed_ms):
        """[(type, values)] that arrive in this time."""
        self.wait_ms -= elapsed_ms
        if self.wait_ms > 0:
            return []
        self.wait_ms = self.rate_ms
        draw = self.random
        if draw.random() < self.trouble / 4:
            self.wait_ms += draw.choice((300, 1500, 3000))
        self.frame += 1
        seen = list(self._markers())
        told = []
        age_us = draw.choice((0, 15_000, 60_000, 400_000, m.COUNT_MAX))
        if draw.random() > 0.01:
            age_us = 15_000
        for index, (marker_id, x, y, angle) in enumerate(seen):
            flags = 0
            if draw.random() < self.trouble:
                marker_id = draw.choice((m.ID_NONE, 1, 5, 200))
                flags = m.MARKER_ID_UNCERTAIN if marker_id == m.ID_NONE else m.MARKER_BORDER
            if draw.random() < self.trouble / 10:
                flags |= m.MARKER_NO_OFFSET
            heading = round(angle * 100 - math.degrees(self.heading) * 100 + draw.gauss(0, 5)) % 36000
            values = {"x_mm10": round(x * 10 + draw.gauss(0, 3)), "y_mm10": round(y * 10 + draw.gauss(0, 3))}
            if draw.random() < 0.001:
                values = {
                    "x_mm10": draw.choice((-1_000_000, 1_000_000)),
                    "y_mm10": draw.choice((-1, 0, 1_000_000)),
                }
            values |= {"frame": self.frame, "age_us": age_us, "flags": flags, "id": marker_id}
            told.append((m.MARKER, values | {"index": index, "count": len(seen), "heading_cdeg": heading}))
        if not seen:
            told.append((m.MARKER, {"frame": self.frame, "age_us": age_us, "flags": m.MARKER_NONE}))
        if self.with_map:
            next_cdeg = draw.choice(
                (round(-math.degrees(self.heading) * 100) % 36000,) * 9 + (m.DIRECTION_NONE,)
            )
            position = draw.choice((m.ROUTE_NONE, 1, 2)) if next_cdeg == m.DIRECTION_NONE else 1
            state = draw.choice((m.TRACKING,) * 4 + (m.COASTING, m.CARRIED, m.CARRIED, m.LOST))
            values = {"frame": self.frame, "state": state, "id": 1 if state == m.TRACKING else m.ID_NONE}
            told.append((m.POSE, values | {"route_position": position, "next_cdeg": next_cdeg}))
        elif draw.random() < 0.05:
            told.append((m.STATUS, {"boot": 3}))
        return [(number, message(number, **values)) for number, values in told]


def limits_of(draw):
    usual = {"speed_mm_s": 200, "turn_cdeg_s": 6000, "accel_mm_s2": 400, "turn_accel_cdeg_s2": 18000}
    usual |= {"stale_ms": 500, "center_mm10": 300, "align_cdeg": 150, "leg_mm": 6000}
    ranges = {"speed_mm_s": 20000, "turn_cdeg_s": 100000, "accel_mm_s2": 50000, "turn_accel_cdeg_s2": 1000000}
    ranges |= {"stale_ms": 10000, "center_mm10": 100000, "align_cdeg": 18000, "leg_mm": 1000000}
    kind = draw.random()
    if kind < 0.5:
        return usual
    if kind < 0.9:
        return {name: max(1, int(value * draw.uniform(0.3, 3))) for name, value in usual.items()}
    return {name: draw.choice((1, high, draw.randint(1, high))) for name, high in ranges.items()}


def drive(seed, steps, reached):
    """So many steps of one drive with both; counts the states in `reached`."""
    draw = random.Random(seed)
    world, limits = World(draw), limits_of(draw)
    reference, ours = Approach(**limits), CController(limits)
    encoder = Encoder()
    for step in range(steps):
        elapsed_ms = draw.choice((20,) * 20 + (1, 7, 0, 250, 1000, 3000))
        data = b""
        for number, values in world.messages(elapsed_ms):
            data += encoder.buffer[: encoder.encode(number, values)]
            reference.on_message(number, 0, values)
        ours.receive(data, 0)
        if draw.random() < 0.002:
            word = draw.choice(("stop", "start", "start", "hold", "go"))
            if word in ("hold", "go"):
                reference.is_held = word == "hold"
                ours.hold(reference.is_held)
            else:
                getattr(reference, word)()
                getattr(ours, word)()
        reference.step(elapsed_ms)
        ours.step(elapsed_ms)
        expected = (reference.state, reference.speed_mm_s, reference.turn_cdeg_s, reference.left_id)
        found = (ours.state, ours.speed_mm_s, ours.turn_cdeg_s, ours.left_id)
        assert found == expected and ours.is_end == reference.is_end, (seed, step, limits)
        reached[reference.state] = reached.get(reference.state, 0) + 1
        world.move(reference.speed_mm_s, reference.turn_cdeg_s, min(elapsed_ms, 1000))


def test_the_same_commands_at_every_step_of_closed_loops():
    reached = {}
    for seed in range(5000, 5000 + STEPS // 500):
        drive(seed, 500, reached)
    assert sum(reached.values()) == STEPS
    assert all(reached.get(state, 0) > 300 for state in (HALT, SEARCH, CENTER, ALIGN, GO, ARRIVED)), reached


def test_limits_outside_their_range_are_refused():
    good = limits_of(random.Random(1))
    for name in good:
        for value in (0, -1, 2_000_000):
            with pytest.raises(ValueError):
                CController(good | {name: value})


def test_the_same_positions_on_the_route():
    draw = random.Random(5001)
    meanings = {}
    for _ in range(400):
        length = draw.choice((2, 3, 4, 7, 12, 30, 64))
        ids = [draw.randint(1, 6)]
        while len(ids) < length:
            ids.append(draw.choice([k for k in (1, 2, 3, 4, 5, 6, 300) if k != ids[-1]]))
        if draw.random() < 0.5 and len(ids) > 2 and ids[-2] != ids[0]:
            ids[-1] = ids[0]
        start = draw.choice((-1, -1, 0, len(ids) - 1))
        reference = Route(ids, start=start)
        ours = CController(limits_of(random.Random(1)))
        assert ours.route(ids, start)
        place = 0
        for _ in range(100):
            kind = draw.random()
            if kind < 0.05:
                reference.lose_sight()
                ours.see(-1)
            elif kind < 0.08:
                expected = (reference.pass_by(), reference.position, reference.next_position())
                assert ours.see(-2)[:3] == expected
            if kind > 0.3:
                place = (place + draw.choice((1, 1, 1, 1, 1, 2, 3))) % len(ids)
            seen = ids[place] if kind > 0.1 else draw.choice((1, 2, 3, 9, 300))
            meaning = reference.see(seen)
            expected = (meaning, reference.position, reference.next_position(), reference.missed)
            assert ours.see(seen) == expected
            meanings[meaning] = meanings.get(meaning, 0) + 1
    assert {0, 1, 2, 3, 4, 6} <= set(meanings) and min(meanings.values()) > 50, meanings


def test_what_cannot_be_a_route_is_refused():
    ours = CController(limits_of(random.Random(1)))
    for ids, start in (([1], -1), ([1, 1], -1), ([1, 2, 2, 3], -1), ([1, 2], 2), ([1, 2], -2)):
        assert not ours.route(ids, start)
        with pytest.raises(ValueError):
            Route(ids, start=start)


def test_the_arithmetic(tmp_path):
    """Every angle, and roots and arc tangents at random, as larics.arith.fixed has them."""
    import ctypes
    import subprocess

    from tools.vehicle_build import LIBRARY, STRICT

    source = tmp_path / "arith.so"
    files = [str(LIBRARY / "larics_arith.c")]
    subprocess.run([compiler(), *STRICT, "-O2", "-shared", "-fPIC", *files, "-o", str(source)], check=True)
    c = ctypes.CDLL(str(source))
    for angle in range(-70000, 70000, 7):
        assert c.larics_sin_q14(angle) == fixed.sin_q14(angle)
        assert c.larics_cos_q14(angle) == fixed.cos_q14(angle)
        assert c.larics_turn16_from_cdeg(angle) == fixed.turn16_from_cdeg(angle)
        assert c.larics_cdeg_from_turn16(angle) == fixed.cdeg_from_turn16(angle)
        assert c.larics_wrap_cdeg(angle) == fixed.wrap_cdeg(angle)
        assert c.larics_floor_div(angle, 1000) == angle // 1000
        assert c.larics_floor_mod(angle, 1000) == angle % 1000
        assert c.larics_floor_shift(angle, 6) == angle >> 6
    draw = random.Random(5002)
    for _ in range(20000):
        x, y = (draw.randint(-(1 << bits), 1 << bits) for bits in (draw.randint(1, 21), draw.randint(1, 21)))
        assert c.larics_atan2_turn16(y, x) == fixed.atan2_turn16(y, x)
        value = draw.randint(0, (1 << draw.randint(1, 32)) - 1)
        assert c.larics_isqrt(ctypes.c_uint32(value)) == math.isqrt(value) == fixed.isqrt(value)
