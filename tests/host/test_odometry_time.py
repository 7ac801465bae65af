"""How well the time between odometry and exposure is known; every intermediate is a small integer."""

import random
import statistics
from array import array

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from larics.locate.odometry import Odometry
from larics.locate.vehicle_clock import VehicleClock
from larics.wire import messages as m
from wire_values import message_values

LINE_US = 2604


def errors_ms(frame_rate, busy_s, rate, drift_ppm, seed, seconds=90.0, settle_s=25.0):
    """Errors of the time of each message. The line is read all the time but for `busy_s` of each frame; one
    message in a hundred is held up on the way by up to 200 ms."""
    rng = random.Random(seed)
    clock, offset_us = VehicleClock(), rng.randrange(1 << 30)
    now_s, found = 0.0, []
    while now_s < seconds:
        now_s += rng.uniform(0.95, 1.05) / rate
        age_s = rng.uniform(0.0005, 0.004)
        come_s = now_s + age_s + LINE_US * 1e-6 + (rng.uniform(0, 0.2) if rng.random() < 0.01 else 0)
        phase_s = come_s % (1 / frame_rate)
        wait_s = max(0.0, busy_s - phase_s) + rng.uniform(0, 0.001)
        arrived_us = int((come_s + wait_s) * 1e6) - LINE_US & m.COUNT_MAX
        sampled_us = int(now_s * 1e6 * (1 - drift_ppm * 1e-6)) + offset_us & m.COUNT_MAX
        sent_us = sampled_us + int(age_s * 1e6) & m.COUNT_MAX
        assert clock.hear(arrived_us, sent_us, int((busy_s if phase_s < busy_s else 0.001) * 1e6))
        if now_s > settle_s:
            true_us = int(now_s * 1e6) & m.COUNT_MAX
            found.append(
                (clock.camera_us(sampled_us) - true_us + (1 << 29)) % (1 << 30) / 1000 - (1 << 29) / 1000
            )
    return found


@pytest.mark.parametrize("frame_rate, busy_s", [(2.8, 0.09), (2.8, 0.3), (20, 0.04), (60, 0.014)])
@pytest.mark.parametrize("rate, drift_ppm", [(50, 0), (100, 60), (50, -100)])
def test_the_time_of_odometry_is_known_to_half_a_millisecond(frame_rate, busy_s, rate, drift_ppm):
    found = errors_ms(frame_rate, busy_s, rate, drift_ppm, seed=5000)
    assert statistics.pstdev(found) < 0.5 and abs(statistics.mean(found)) < 0.8
    assert max(map(abs, found)) < 3


@pytest.mark.parametrize("drift_ppm", [10000, -10000])
def test_clocks_that_run_one_percent_apart_are_followed(drift_ppm):
    found = errors_ms(20, 0.04, 50, drift_ppm, seed=5001)
    assert statistics.pstdev(found) < 1 and max(map(abs, found)) < 5


@settings(max_examples=25)
@given(data=st.data())
def test_whatever_comes_every_result_is_a_small_integer(data):
    whole = lambda low, high: data.draw(st.integers(low, high) | st.sampled_from([low, high]))  # noqa: E731
    now = [data.draw(st.integers(0, m.COUNT_MAX))]
    odometry = Odometry(lambda: now[0], LINE_US)
    far = (1 << 29) - 1
    time_us = whole(0, m.COUNT_MAX)
    for _ in range(25):
        now[0] = (now[0] + data.draw(st.sampled_from([0, 1, 20000, 900000, 9000000]))) & m.COUNT_MAX
        step = data.draw(st.sampled_from([20000, 20000, 20000, 1, 0, 999999, 400000000]))
        time_us = (time_us + step) & m.COUNT_MAX
        values = message_values(
            m.ODOMETRY, time_us=time_us, age_us=whole(0, m.COUNT_MAX) if step == 1 else 1000,
            x_mm10=whole(-far, far) if step > 900000 else whole(0, 200), y_mm10=whole(0, 200),
            heading_cdeg=whole(0, 35999), epoch=whole(0, 1), flags=0,
        )  # fmt: skip
        odometry.look()
        odometry.take(array("i", values))
        odometry.at((now[0] - data.draw(st.integers(-300000, 300000))) & m.COUNT_MAX)
        assert abs(odometry.x_mm10) < 1 << 30 and 0 <= odometry.way_mm10 <= m.COUNT_MAX
