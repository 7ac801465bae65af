"""The lights: what a person would see over time, and the counters of faults."""

from faults import Faults
from larics.wire import messages as m
from leds import Leds, NoLeds


class Led:
    def __init__(self):
        self.lit = None
        self.switched = 0

    def on(self):
        self.lit = True
        self.switched += 1

    def off(self):
        self.lit = False
        self.switched += 1


def watch(milliseconds, tracking=False, coasting=False, faults=0):
    """(share of the time red, green and blue were lit in percent, times each was switched on)."""
    three = [Led(), Led(), Led()]
    leds = Leds(*three)
    lit = [0, 0, 0]
    begun = [0, 0, 0]
    before = [False, False, False]
    for _ in range(milliseconds // 10):
        leds.show(tracking, coasting, faults, 10)
        for k in range(3):
            lit[k] += three[k].lit
            begun[k] += three[k].lit and not before[k]
            before[k] = three[k].lit
    return [1000 * count // milliseconds for count in lit], begun, three


def test_tracking_is_steady_green():
    shares, begun, three = watch(5000, tracking=True)
    assert shares == [0, 100, 0] and begun == [0, 1, 0]
    assert three[1].switched == 2  # off at first, then on: not in every round


def test_coasting_blinks_green_and_lost_flashes_blue():
    shares, begun, _ = watch(10000, coasting=True)
    assert 45 <= shares[1] <= 55 and 38 <= begun[1] <= 42 and shares[0] == shares[2] == 0
    shares, begun, _ = watch(10000)
    assert 4 <= shares[2] <= 8 and 10 <= begun[2] <= 11 and shares[0] == shares[1] == 0


def test_a_fault_flashes_its_code():
    for code in (1, 3, 12):
        period_ms = code * 300 + 1500
        _, begun, _ = watch(4 * period_ms, tracking=True, faults=1 << code)
        assert code * 4 - 1 <= begun[0] <= code * 4 + 1, (code, begun)
    _, begun, _ = watch(2 * 2100, faults=1 << 2 | 1 << 9)  # the lowest one first
    assert 3 <= begun[0] <= 5


def test_all_lights_and_none():
    three = [Led(), Led(), Led()]
    Leds(*three).all(True)
    assert [led.lit for led in three] == [True, True, True]
    NoLeds().all(True)
    NoLeds().show(True, False, 0, 10)


def test_faults_that_last_are_counted_once():
    faults = Faults()
    faults.begin(m.FAULT_STORAGE)
    faults.begin(m.FAULT_STORAGE)
    faults.report(m.FAULT_DETECT)
    assert (faults.total, faults.last, faults.active) == (2, m.FAULT_DETECT, 1 << m.FAULT_STORAGE)
    faults.end(m.FAULT_STORAGE)
    faults.end(m.FAULT_STORAGE)
    assert faults.active == 0 and faults.total == 2
    faults.total = m.COUNT_MAX
    faults.report(m.FAULT_DETECT)
    assert faults.total == 0
