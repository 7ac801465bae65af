"""Calls of the kernels in larics.kernels.odometry."""

from array import array

from larics.arith.tables import QUARTER_SINE_Q14
from larics.locate.odometry import Odometry
from larics.wire.messages import COUNT_MAX


class _Drive:
    """A vehicle whose messages come late by chance, whose clock runs 1 % fast, and that jumps at times."""

    def __init__(self, random):
        self.random = random
        self.now_us = 1000000
        self.odometry = Odometry(lambda: self.now_us & COUNT_MAX, 2604)
        self.values = array("i", [COUNT_MAX - 500000, 1000, -3000, 9000, 0, 0, 0])

    def step(self):
        """Arguments for a message that is about to be admitted; the drive itself takes it, too."""
        values, random = self.values, self.random
        step_us = 20000 + 3000000 * (random.below(40) == 0)
        self.now_us += step_us
        values[0] = (values[0] + step_us * 101 // 100) & COUNT_MAX
        values[2] += random.between(-50, 200) + 300000 * (random.below(30) == 0)
        values[4] = (values[4] + random.between(-300, 300)) % 36000
        values[5] = (values[5] + (random.below(40) == 0)) & 255
        values[1] = 1200000 if random.below(30) == 0 else 1000
        now_us = self.now_us + 4000 + random.below(16000)
        known = copied(values), copied(self.odometry._ring), copied(self.odometry.clock.items)
        before, self.now_us = self.now_us, now_us
        self.odometry.take(values)
        self.now_us = before
        return known + (now_us & COUNT_MAX,)  # noqa: RUF005  (MicroPython has no stars in tuples)


def copied(items):
    return array("i", items)


def admit(random):
    drive = _Drive(random)
    for _ in range(60):
        values, ring, clock, now_us = drive.step()
        yield 0, 0, values, ring, clock, now_us


def hear(random):
    drive = _Drive(random)
    for number in range(900):
        drive.step()
        if number % 15 == 0:
            yield 0, 0, copied(drive.odometry.clock.items)


def settle(random):
    drive = _Drive(random)
    for _ in range(60):
        values, ring, clock, now_us = drive.step()
        yield 0, 0, values, ring, clock, now_us, int(random.below(10) > 0)


def pose_at(random):
    drive = _Drive(random)
    for _ in range(60):
        drive.step()
        time_us = (drive.now_us + random.between(-150000, 260000)) & COUNT_MAX
        yield 0, 0, copied(drive.odometry._ring), time_us, array("i", [0] * 7)


def advance(random):
    for number in range(150):
        dx, dy = random.between(-3499, 3499), random.between(-3499, 3499)
        turn, told = random.between(-18000, 17999), random.between(0, 40000)
        if number % 3:
            dx, dy, turn = dx // 50, dy // 50, turn // 50
        path = [
            random.between(0, 2303999),
            random.between(-9000000, 9000000),
            random.between(-9000000, 9000000),
        ]
        path += [random.between(-9000, 9000), random.between(-9000, 9000), (1 << 24) - random.below(9000)]
        path += [random.below(640), random.between(-180000, 180000), random.below(180001), 0]
        path += [random.between(-1024, 1024), random.between(-4096, 4096), random.between(-16384, 16384)]
        path.append(random.below(5001))
        sums = [random.between(-160000, 160000), random.below(160000)]
        sums += [random.below(170000), random.between(-170000, 170000)]
        passed_ms, known = random.between(1, 2000), int(number % 8 > 0)
        yield (
            0, 0, array("i", path), array("i", sums), QUARTER_SINE_Q14, dx, dy, turn, told, passed_ms, known,
        )  # fmt: skip


CASES = {"advance": advance, "admit": admit, "hear": hear, "settle": settle, "pose_at": pose_at}
