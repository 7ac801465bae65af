"""Each limit of the clock by which the vehicle's time is known, at it and just beyond."""

from larics.locate.vehicle_clock import VehicleClock
from larics.wire import messages as m


def heard(*messages):
    """A clock that heard (arrived_us, offset_us), and whether it believes the last one."""
    clock = VehicleClock()
    for arrived_us, offset_us in messages:
        believed = clock.hear(arrived_us, (arrived_us - offset_us) & m.COUNT_MAX, 0)
    return clock, believed


def test_the_least_delay_is_forgotten_slowly():
    for passed_ms, offset_us in ((1000, 400), (8000, 3200), (8001, 3200)):
        clock, _ = heard((0, 0), (1000 * passed_ms, 900000))
        assert clock.camera_us(0) == offset_us, passed_ms


def test_clocks_that_leap_apart():
    for offset_us, believed in ((1000400, True), (1000401, False)):  # 0.4 ms were forgotten in the second
        assert heard((0, 0), (1000000, offset_us))[1] == believed
        assert heard((0, 0), (1000000, 800 - offset_us))[1] == believed


def test_spans_of_messages():
    eighth = [(250000 * k, 0) for k in range(7)]
    for last, spans_ms, left in ((1999000, 2000, 8), (2000000, 4000, 0)):
        clock, _ = heard(*eighth, (last, 0))
        assert (clock.items[9], clock.items[12]) == (spans_ms, left), last
    assert heard(*eighth[1:], (2250000, 0))[0].items[12] == 7
    clock, _ = heard(*[(250000 * k, 0) for k in range(200)])
    assert clock.items[9] == 8000
    for silence_us, left in ((32000000, 2), (32001000, 0)):
        assert heard((0, 0), (silence_us, 0))[0].items[12] == left
    assert heard((0, 0), (20000, 0), (40000, 2000000))[0].items[12] == 1  # another clock: all is forgotten


def learned(between_ms, grown_us, waited_us=0, late_us=0):
    clock, _ = heard((0, 0))
    items, now_us = clock.items, 1000 * between_ms
    items[5], items[6], items[7] = 1, 0, 0
    items[13], items[14], items[15] = now_us, grown_us & m.COUNT_MAX, waited_us
    items[9], items[17] = 8000, late_us
    items[10] = items[18] = items[19] = now_us
    clock.learn()
    return clock


def test_a_drift_is_learned_beyond_doubt_and_within_reason():
    for between_ms, grown_us, waited_us, drift_ppm in (
        (1000, 6000, 0, 0),
        (1000, 6001, 0, 6001),
        (1000, -6001, 0, -6001),
        (1000, 6500, 500, 0),
        (1000, 6501, 500, 6501),
        (1000, 19999, 0, 19999),
        (1000, 20001, 0, 20000),
        (1000, -20001, 0, -20000),
        (40000, 40000, 0, 1000),
        (40000, 900000, 0, 20000),
        (40001, 40000, 0, 0),
    ):
        clock = learned(between_ms, grown_us, waited_us)
        assert clock.drift_ppm() == drift_ppm, (between_ms, grown_us)
        assert clock.items[9] == (2000 if drift_ppm else 8000)  # a new one is soon looked at again


def test_an_estimate_that_no_message_reaches_is_put_right():
    for waited_us, late_us, offset_us in ((0, 3000, 0), (0, 3001, 3001), (700, 3700, 0), (700, 3701, 3701)):
        assert learned(1000, 0, waited_us, late_us).camera_us(0) == offset_us, late_us
