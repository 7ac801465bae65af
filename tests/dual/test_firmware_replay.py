"""The replay driver: frames, numbers, times and skips as a camera would give them."""

import os

from cameras import CameraError
from cameras.pgm import parse_header
from cameras.replay import Replay

FOLDER = "build/dual_replay"


class Clock:
    """A clock that a test turns; wraps early, as a board's does."""

    PERIOD = 1 << 20

    def __init__(self):
        self.now_us = self.PERIOD - 30000

    def ticks_us(self):
        return self.now_us % self.PERIOD

    def ticks_add(self, ticks, delta):
        return (ticks + delta) % self.PERIOD

    def ticks_diff(self, end, start):
        half = self.PERIOD // 2
        return (end - start + half) % self.PERIOD - half


def make_folder():
    for folder in ("build", FOLDER):
        try:
            os.mkdir(folder)
        except OSError:
            pass
    for name in os.listdir(FOLDER):
        os.remove(FOLDER + "/" + name)


def write(name, data):
    with open(FOLDER + "/" + name, "wb") as file:
        file.write(data)


def pgm(width, height, value, comment=b""):
    return b"P5\n" + comment + b"%d %d\n255\n" % (width, height) + bytes([value]) * (width * height)


def frames_of(camera):
    values = []
    while True:
        if camera.grab():
            values.append((camera.frame_number, camera.frame[0], camera.frame[-1]))
        elif camera.ended:
            return values


def fails(camera, text):
    try:
        camera.start()
        frames_of(camera)
    except (CameraError, ValueError) as error:
        assert text in str(error), str(error)
        return
    raise AssertionError("no error about " + text)


def test_header():
    assert parse_header(b"P5 12 34 255\nxx") == (12, 34, 13)
    assert parse_header(b"P5\n# made by hand\n12 34\n# more\n255\nxx") == (12, 34, 35)
    for bad, text in (
        (b"P2 1 1 255\n", "not a binary PGM"),
        (b"", "not a binary PGM"),
        (b"P5 12 3", "cut off"),
        (b"P5 12 34 65535\n", "65535 grey levels"),
        (b"P5 0 34 255\n", "0x34"),
        (b"P5 -2 34 255\n", "unexpected byte 45"),
    ):
        try:
            parse_header(bad)
        except ValueError as error:
            assert text in str(error)
        else:
            raise AssertionError(bad)


def test_folder_in_the_order_of_names_into_one_buffer():
    make_folder()
    for number, value in ((2, 30), (0, 10), (1, 20)):
        write("f%03d.pgm" % number, pgm(7, 5, value, b"# a comment\n" * number))
    write("notes.txt", b"not a frame")
    camera = Replay(FOLDER, clock=Clock())
    camera.start()
    assert (camera.width, camera.height) == (7, 5)
    frame = camera.frame
    assert frames_of(camera) == [(0, 10, 10), (1, 20, 20), (2, 30, 30)]
    assert camera.frame is frame and len(frame) == 35
    assert not camera.grab()


def test_many_pictures_in_one_file():
    make_folder()
    write("all.pgm", b"".join([pgm(4, 3, value) for value in (1, 2, 3, 4)]))
    camera = Replay(FOLDER + "/all.pgm", rounds=2, clock=Clock())
    camera.start()
    assert [value for _, value, _ in frames_of(camera)] == [1, 2, 3, 4, 1, 2, 3, 4]
    assert camera.frame_number == 7


def test_list_of_buffers_and_a_second_start():
    camera = Replay([bytes([9] * 12), bytearray([8] * 12)], width=4, height=3, clock=Clock())
    for _ in range(2):
        camera.start()
        assert frames_of(camera) == [(0, 9, 9), (1, 8, 8)]
        camera.stop()


def test_real_time_waits_and_skips():
    clock = Clock()
    camera = Replay([bytes([k] * 4) for k in range(10)], fps=100, width=2, height=2, clock=clock)
    camera.start()
    start_us = clock.now_us
    assert camera.grab() and camera.frame[0] == 0
    assert not camera.grab()  # the next is not due
    clock.now_us = start_us + 10500
    assert camera.grab() and camera.frame_number == 1
    assert clock.ticks_diff(camera.capture_us, start_us % clock.PERIOD) == 10000
    clock.now_us = start_us + 57000  # 2, 3 and 4 went by; 5 is the newest
    assert camera.grab() and camera.frame_number == 5 and camera.frame[0] == 5
    assert camera.skipped == 3
    assert clock.ticks_diff(clock.ticks_us(), camera.capture_us) == 7000
    clock.now_us = start_us + 500000
    assert camera.grab() and camera.frame_number == 9 and camera.skipped == 6  # the last one is not lost
    clock.now_us += 10000
    assert not camera.grab() and camera.ended


def test_what_is_wrong_is_said():
    make_folder()
    fails(Replay(FOLDER, clock=Clock()), "no .pgm frame")
    write("a.pgm", pgm(7, 5, 1))
    write("b.pgm", pgm(5, 7, 1))
    fails(Replay(FOLDER, clock=Clock()), "b.pgm is 5x7")
    write("b.pgm", pgm(7, 5, 1)[:-1])
    fails(Replay(FOLDER, clock=Clock()), "b.pgm is cut off")
    write("b.pgm", b"P6" + pgm(7, 5, 1)[2:])
    fails(Replay(FOLDER, clock=Clock()), "b.pgm: not a binary PGM picture")
    write("b.pgm", pgm(7, 5, 1) + b"?")
    fails(Replay(FOLDER + "/b.pgm", clock=Clock()), "does not hold whole frames")
    fails(Replay([], width=2, height=2, clock=Clock()), "empty")
    fails(Replay([b"123"], width=2, height=2, clock=Clock()), "too short")
