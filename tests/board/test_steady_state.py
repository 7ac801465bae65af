"""In steady state the loop allocates nothing: heap_lock makes any allocation an error, which is a fault."""

import gc

import micropython
from board_parts import Clock, Uart, make_app, marker, plain

from larics.wire import messages as m
from wire_values import at

DETECTIONS = at(m.STATUS, "detections")
STEP_US = 5000  # with each reading of the clock: several seconds, and as many STATUS, in what is looked at


def frames():
    return [marker(5, 80, 60, 20), plain(120), marker(3, 70, 50, 20)]


def run_locked(app, rounds):
    processed = [0]
    for _ in range(60):  # everything that is made at first use
        app.loop.step()
    micropython.heap_lock()
    try:
        count = 0
        for _ in range(rounds):
            if app.loop.step():
                count += 1
    finally:
        micropython.heap_unlock()
    processed[0] = count
    return count


def test_processing_frames_allocates_nothing():
    for method in ("paper", "larics"):
        app = make_app(frames(), settings={"method": method, "focal_q8": 200 * 256}, clock=Clock(STEP_US))
        assert run_locked(app, 60) == 60
        assert app.faults.total == 0, (method, app.faults.last)
        assert app.status.fill(0)[DETECTIONS] > 60


def test_poses_and_status_allocate_nothing():
    settings = {"focal_q8": 200 * 256, "map": [[5, 1000, 2000, 9000, 0, 0]]}
    app = make_app(frames(), settings=settings, clock=Clock(STEP_US))
    assert run_locked(app, 100) == 100
    # marker 3 is in no map, marker 5 in the first frame of a round: nothing else goes wrong
    assert app.faults.total and app.faults.last == m.FAULT_MARKER_UNKNOWN and not app.faults.active


def test_a_slow_or_dead_line_allocates_nothing():
    uart = Uart()
    app = make_app(frames(), uart, clock=Clock(200))
    app.loop.step()
    uart.room = 0
    assert run_locked(app, 60) == 60
    assert app.faults.total == 1  # the line, once


def test_memory_stays_level_over_many_frames():
    app = make_app(frames(), settings={"method": "paper"})
    for _ in range(60):
        app.loop.step()
    gc.collect()
    before = gc.mem_alloc()
    for _ in range(300):
        app.loop.step()
    gc.collect()
    assert gc.mem_alloc() - before < 500, gc.mem_alloc() - before
