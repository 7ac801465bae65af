"""The example for interrupts and tasks: with every warning an error, fed by its interrupt, and driven."""

import ctypes
import shutil
import subprocess

import pytest

from recorded import Stream
from tools.vehicle_build import LIBRARY, SIGNED, SOURCES

FOLDER = LIBRARY.parent / "examples" / "interrupt"
BOARD = """
#include "vehicle.h"
#include <string.h>
uint8_t sent[4096]; uint32_t sent_count; int32_t speed, turn;
void board_send(const uint8_t *bytes, size_t count)
{
    memcpy(sent + sent_count, bytes, count);
    sent_count += (uint32_t)count;
}
void board_drive(int32_t a, int32_t b) { speed = a; turn = b; }
"""


@pytest.fixture(scope="module")
def vehicle(tmp_path_factory):
    folder = tmp_path_factory.mktemp("interrupt")
    (folder / "board.c").write_text(BOARD)
    flags = ["-O1", "-shared", "-fPIC", "-I", str(LIBRARY), "-I", str(FOLDER)]
    subprocess.run(
        ["gcc", *SIGNED, "-c", "-I", str(LIBRARY), str(FOLDER / "vehicle.c"), "-o", str(folder / "v.o")],
        check=True,
    )
    files = [str(folder / "board.c"), str(FOLDER / "vehicle.c"), *map(str, SOURCES)]
    subprocess.run(["gcc", "-std=c99", *flags, *files, "-o", str(folder / "v.so")], check=True)
    return ctypes.CDLL(str(folder / "v.so"))


def number(vehicle, name, kind=ctypes.c_int32):
    return kind.in_dll(vehicle, name).value


def test_it_drives_when_the_camera_has_proven_itself_and_stops_in_silence(vehicle):
    camera, now, answered = Stream(), 1000, 0
    vehicle.vehicle_start(now, 7)
    for turn in range(2000):
        now += 2
        data = b""
        count = number(vehicle, "sent_count")
        if count > answered:
            sent = bytes((ctypes.c_uint8 * 4096).in_dll(vehicle, "sent"))[answered:count]
            data, answered = camera.answer(sent), count
        elif turn % 10 == 0:
            data = camera.marker(x=5000, y=0)
        for byte in data:
            vehicle.vehicle_received(byte)
        vehicle.vehicle_turn(now)
        if turn < 5:
            assert number(vehicle, "speed") == 0
    assert number(vehicle, "speed") > 100 and abs(number(vehicle, "turn")) < 200
    assert number(vehicle, "vehicle_lost", ctypes.c_uint32) == 0
    for _ in range(1000):
        now += 2
        vehicle.vehicle_turn(now)
    assert number(vehicle, "speed") == 0


def test_a_full_ring_loses_and_counts_what_is_new(vehicle):
    before = number(vehicle, "vehicle_lost", ctypes.c_uint32)
    for _ in range(255 + 45):
        vehicle.vehicle_received(1)
    assert number(vehicle, "vehicle_lost", ctypes.c_uint32) == before + 45


def test_it_compiles_for_a_microcontroller(tmp_path):
    if not shutil.which("arm-none-eabi-gcc"):
        pytest.skip("not installed: apt-get install gcc-arm-none-eabi")
    command = ["arm-none-eabi-gcc", *SIGNED, "-Os", "-mthumb", "-mcpu=cortex-m4", "-I", str(LIBRARY), "-c"]
    subprocess.run([*command, str(FOLDER / "vehicle.c"), "-o", str(tmp_path / "v.o")], check=True)
