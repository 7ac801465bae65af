"""The pipe driver and its clock: frames and times as a simulator sends them."""

import os
import struct

from cameras import CameraError
from pc.pipe_camera import HEADER, LINE_MAGIC, MAGIC, FrameClock, Line, Pipe

PATH = "build/dual_pipe.bin"


class Written:
    """A UART that keeps what is written to it."""

    data = b""

    def write(self, buffer, offset, count):
        self.data += bytes(buffer[offset : offset + count])
        return count


def write(*frames, cut=0):
    """A file of frames (width, height, number, capture_us), pixels all equal to the number, and of bytes on
    the line (time_us, bytes)."""
    try:
        os.mkdir("build")
    except OSError:
        pass
    data = b""
    for record in frames:
        if len(record) == 2:
            data += struct.pack(HEADER, LINE_MAGIC, len(record[1]), 0, 0, record[0]) + record[1]
            continue
        width, height, number, capture_us = record
        data += struct.pack(HEADER, MAGIC, width, height, number, capture_us) + bytes([number]) * (
            width * height
        )
    with open(PATH, "wb") as file:
        file.write(data[: len(data) - cut])


def test_frames_come_in_order_with_their_times():
    write((8, 4, 0, 5000), (8, 4, 1, 105000), (8, 4, 4, 405000))
    camera = Pipe(PATH, latency_us=2000)
    camera.start()
    assert (camera.width, camera.height) == (8, 4)
    seen = []
    while camera.grab():
        assert bytes(camera.frame) == bytes([camera.frame_number]) * 32
        seen.append((camera.frame_number, camera.capture_us, camera.clock.ticks_us(), camera.skipped))
    assert seen == [(0, 5000, 7000, 0), (1, 105000, 107000, 0), (4, 405000, 407000, 2)]
    assert camera.ended and not camera.grab()


def test_time_goes_on_when_the_stream_has_ended():
    write((8, 4, 0, 5000))
    camera = Pipe(PATH, latency_us=2000)
    camera.start()
    assert camera.grab() and camera.clock.ticks_ms() == 7
    assert not camera.grab()
    passed_ms = 0
    for _ in range(10000000):  # whoever waits for a line that nobody reads waits no longer than it may
        passed_ms = camera.clock.ticks_diff(camera.clock.ticks_ms(), 7)
        if passed_ms > 2:
            break
    assert 2 < passed_ms < 60000 and camera.clock.ticks_us() >= 7000 + 2000


def read(line):
    buffer = bytearray(8)
    found = b""
    while line.any():
        found += bytes(buffer[: line.readinto(buffer, 8)])
    return found


def test_what_the_vehicle_sends_arrives_in_its_time():
    """Between two frames when it comes, during the processing of a frame after it."""
    uart = Written()
    line = Line(uart)
    write(
        (8, 4, 0, 5000),
        (20000, b"one"),
        (20200, b"two"),
        (41000, b"three"),
        (51000, b"four"),
        (8, 4, 1, 50000),
    )
    camera = Pipe(PATH, 2000, line)
    camera.start()
    seen = []
    for _ in range(20):
        if camera.ended:
            break
        got = camera.grab()
        seen.append((camera.clock.ticks_us(), read(line), got))
    assert seen == [
        (7000, b"", True),
        (19000, b"", False),  # the loop looks, and there is nothing yet
        (20000, b"one", False),
        (20200, b"two", False),
        (40000, b"", False),
        (41000, b"three", False),
        (52000, b"four", True),
        (52000, b"", False),
    ]
    assert line.write(b"12345", 1, 3) == 3 and uart.data == b"234"


def test_the_first_bytes_of_the_line_turn_no_time_back():
    write((8, 4, 0, 5000), (7400, b"one"), (8, 4, 1, 25000))
    line = Line(Written())
    camera = Pipe(PATH, 2000, line)
    camera.start()
    seen = [(camera.grab(), camera.clock.ticks_us(), camera.clock.ticks_ms(), read(line)) for _ in range(3)]
    assert seen == [(True, 7000, 7, b""), (False, 7400, 7, b"one"), (True, 27000, 27, b"")], seen


def test_the_receive_buffer_is_as_large_as_a_boards():
    line = Line(Written())
    line.bring(bytes(1000))
    line.bring(b"x" * 100)
    assert read(line) == bytes(1000) + b"x" * 24


def test_exposure_and_gain_are_told_after_each_frame():
    write((8, 4, 0, 0), (8, 4, 1, 10), (8, 4, 2, 20))
    told = PATH + "-controls"
    camera = Pipe(PATH, controls=told)
    camera.start()
    assert camera.adjustable and not Pipe(PATH).adjustable
    while camera.grab():
        camera.exposure(700 + camera.frame_number)
        camera.gain(100 * camera.frame_number)
    with open(told, "rb") as file:
        assert struct.unpack("<6I", file.read()) == (700, 0, 701, 100, 702, 200)


def test_a_stream_that_breaks_off_ends_the_camera():
    write((8, 4, 0, 0), (8, 4, 1, 10), cut=5)
    camera = Pipe(PATH)
    camera.start()
    assert camera.grab() and not camera.grab() and camera.ended


def test_what_is_no_stream_is_refused():
    write((8, 4, 0, 0), (4, 8, 1, 10))
    camera = Pipe(PATH)
    camera.start()
    camera.grab()
    try:
        camera.grab()
        assert False
    except CameraError:
        pass
    with open(PATH, "wb") as file:
        file.write(b"P5 this is a picture")
    for content in (b"P5 this is a picture", b""):
        with open(PATH, "wb") as file:
            file.write(content)
        try:
            Pipe(PATH).start()
            assert False
        except CameraError:
            pass


def test_the_clock_goes_by_the_frames_and_wraps():
    clock = FrameClock(1500)
    period = 1 << 30
    clock.frame_at(1000)
    start_us, start_ms = clock.ticks_us(), clock.ticks_ms()
    assert start_us == 2500 and start_ms == 2
    capture_us = 1000
    for _ in range(3000):
        capture_us = (capture_us + 700500) % period
        clock.frame_at(capture_us)
    assert clock.ticks_us() == (2500 + 3000 * 700500) % period
    assert clock.ticks_ms() == (2500 + 3000 * 700500) // 1000
    assert clock.ticks_diff(5, period - 5) == 10 and clock.ticks_diff(period - 5, 5) == -10
    assert clock.ticks_add(period - 5, 10) == 5
