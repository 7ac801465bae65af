"""Odometry through the whole program: MOTION with each frame, counted in STATUS, and nothing allocated."""

import micropython
from board_parts import Clock, Uart, make_app, marker, plain

from larics.wire import messages as m
from larics.wire.codec import Encoder
from wire_values import at, message_values, named

TIME = at(m.ODOMETRY, "time_us")
X = at(m.ODOMETRY, "x_mm10")


class Feed(Uart):
    """A UART on which one ODOMETRY waits each time that the line is read; it allocates nothing."""

    def __init__(self, collect=True):
        Uart.__init__(self, collect)
        self.encoder = Encoder()
        self.clock = None
        self.moves = True
        self.values = message_values(m.ODOMETRY, epoch=1)
        self.left = -1  # bytes of the message; -1 before it is made, 0 when it is read
        self.place = 0

    def any(self):
        if self.left < 0:
            now_us = self.clock.ticks_us() & m.COUNT_MAX
            self.values[TIME] = now_us
            if self.moves:
                self.values[X] = now_us >> 10  # 0.1 m/s
            self.left = self.encoder.encode(m.ODOMETRY, self.values)
            self.place = 0
        elif self.left == 0:
            self.left = -1
            return 0
        return self.left

    def readinto(self, buffer, count):
        for k in range(count):
            buffer[k] = self.encoder.buffer[self.place + k]
        self.place += count
        self.left -= count
        return count


def program(collect=True):
    uart = Feed(collect)
    app = make_app([marker(5, 80, 60, 20), plain(120)], uart, {"focal_q8": 200 * 256, "method": "paper"})
    uart.clock = app.loop._clock
    return app, uart


def test_motion_comes_with_each_frame_and_is_counted():
    app, uart = program()
    for _ in range(40):
        app.loop.step()
    app.loop.close(200)
    frames = [named(m.MARKER, values)["frame"] for values in uart.of(m.MARKER)]
    motions = [named(m.MOTION, values) for values in uart.of(m.MOTION)]
    assert [motion["frame"] for motion in motions] == frames[-len(motions) :] and len(motions) > 30
    assert motions[-1]["state"] != m.MOTION_NONE and motions[-1]["epoch"] == 1
    assert motions[-1]["way_mm10"] > motions[0]["way_mm10"]
    status = named(m.STATUS, uart.of(m.STATUS)[-1])
    assert status["odometry_used"] >= 40 and status["odometry_refused"] == status["odometry_jumps"] == 0
    assert status["unanswered"] == 0 and uart.of(m.ACK) == uart.of(m.NACK) == []


def test_without_odometry_there_is_no_motion():
    uart = Uart(collect=True)
    app = make_app([marker(5, 80, 60, 20)], uart, {"method": "paper"})
    for _ in range(20):
        app.loop.step()
    assert uart.of(m.MARKER) and not uart.of(m.MOTION)


def test_odometry_and_motion_allocate_nothing():
    uart = Feed(collect=False)
    place = {"focal_q8": 200 * 256, "method": "larics", "map": [[5, 1000, 2000, 9000, 0, 0]]}
    frames = [marker(5, 80, 60, 20), plain(120), plain(121)]
    app = make_app(frames, uart, place, clock=Clock(500))  # or the poses kept span no time at all
    uart.clock = app.loop._clock
    uart.moves = False  # as the marker above says
    for _ in range(60):
        app.loop.step()
    used = app.odometry.used
    micropython.heap_lock()
    try:
        for _ in range(60):
            app.loop.step()
    finally:
        micropython.heap_unlock()
    assert app.faults.total == 0 and app.odometry.used >= used + 60
    assert app.parts.sensor.navigator.pose.carried
