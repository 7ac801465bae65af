"""A board's console for tests: boots boot.py and main.py of /flash, then serves the REPL on its line.

    micropython fake_board.py FLASH_IMAGE IDENTITY

The real interpreter executes what comes by the raw REPL and runs what lies on the flash: a FAT file system in
the file FLASH_IMAGE, as on an OpenMV board. Ctrl-C must arrive as a signal. Exit code 42 stands for
machine.reset(): whoever runs this starts it again.
"""

import io
import os
import sys

import micropython
import vfs

RESET = 42

here = __file__.rsplit("/", 1)[0]
sys.path.append(here + "/fakes")
sys.modules["machine"] = __import__("fake_machine")
import csi  # noqa: E402
import fake_machine  # noqa: E402
import omv  # noqa: E402


def reset():
    sys.stdout.write("\r\n")
    sys.exit(RESET)


class Line:
    """A UART that nobody listens to; whenever it is looked at, the camera has another frame."""

    def write(self, buffer, offset, count):
        return count

    def any(self):
        csi.world.complete()
        return 0


class Disk:
    """A block device in a file."""

    SIZE = 512

    def __init__(self, path, blocks=4096):
        try:
            self.file = open(path, "r+b")
        except OSError:
            with open(path + ".new", "wb") as file:
                for _ in range(blocks):
                    file.write(bytes(self.SIZE))
            os.rename(path + ".new", path)  # whole, or not there: Ctrl-C may come at any time
            self.file = open(path, "r+b")
        self.blocks = os.stat(path)[6] // self.SIZE

    def readblocks(self, block, buffer):
        self.file.seek(block * self.SIZE)
        self.file.readinto(buffer)

    def writeblocks(self, block, buffer):
        self.file.seek(block * self.SIZE)
        self.file.write(buffer)

    def ioctl(self, operation, argument):
        if operation == 4:
            return self.blocks
        if operation == 5:
            return self.SIZE
        return 0


class Rom:
    """`vfs` as on a board with a ROMFS partition, which lies in a file. OSError without that."""

    BLOCK = 4096

    def __init__(self, path):
        self.path = path
        with open(path, "rb") as file:
            self.memory = bytearray(file.read())
        if self.memory[:3] == b"\xd2\xcd\x31":
            vfs.mount(vfs.VfsRom(self.memory), "/rom")
        self.umount = vfs.umount

    def rom_ioctl(self, operation, number=0, *arguments):
        if operation == 1:
            return 1
        if operation == 2:
            return self.memory
        if operation == 3:
            first, count = arguments
            self.memory[first : first + count] = b"\xff" * count
            return 16
        if operation == 4:
            first, data = arguments
            self.memory[first : first + len(data)] = data
        if operation == 5:
            with open(self.path, "wb") as file:
                file.write(self.memory)
        return self.BLOCK if operation == 6 else 0


def boot():
    """What a board does after its reset: boot.py, then main.py, if they are there."""
    for name in ("boot.py", "main.py"):
        try:
            with open("/flash/" + name) as file:
                code = file.read()
        except OSError:
            continue
        execute(code, sys.stdout, name)


def execute(code, errors, name="<stdin>"):
    """Runs code in __main__; an exception is printed to `errors`."""
    try:
        micropython.kbd_intr(3)
        exec(compile(code, name, "exec"), scope)
    except SystemExit as end:
        if end.args and end.args[0] == RESET:
            raise
    except BaseException as error:
        sys.print_exception(error, errors)


def read_byte():
    data = sys.stdin.buffer.read(1)
    if not data:
        sys.exit(0)
    return data


def write(text):
    sys.stdout.write(text)


def raw_repl():
    """Until Ctrl-B."""
    write("raw REPL; CTRL-B to exit\r\n>")
    code = b""
    while True:
        byte = read_byte()
        if byte == b"\x02":
            write("\r\n>>> ")
            return
        if byte == b"\x05":
            read_byte()
            read_byte()
            write("R\x00")  # no paste mode
        elif byte == b"\x01":
            code = b""
            write("raw REPL; CTRL-B to exit\r\n>")
        elif byte == b"\x04":
            if code:
                run(code, "OK")
            else:
                write("OK\r\nMPY: soft reboot\r\nraw REPL; CTRL-B to exit\r\n>")
            code = b""
        else:
            code += byte


def paste():
    """Code by the raw paste mode, with a window of so many bytes."""
    window = 16384
    write("R\x01")
    sys.stdout.buffer.write(bytes([window & 255, window >> 8]))
    code = bytearray()
    while True:
        byte = read_byte()
        if byte == b"\x04":
            write("\x04")
            return bytes(code)
        code.extend(byte)
        if len(code) % window == 0:
            write("\x01")


def run(code, before):
    write(before)
    errors = io.StringIO()
    execute(code, errors)
    write("\x04" + errors.getvalue() + "\x04>")


def main(image, identity):
    disk = Disk(image)
    try:
        vfs.mount(vfs.VfsFat(disk), "/flash")
    except OSError:  # new
        vfs.VfsFat.mkfs(disk)
        vfs.mount(vfs.VfsFat(disk), "/flash")
    try:
        sys.modules["vfs"] = Rom(image + ".rom")
    except OSError:
        pass  # most boards have no such partition
    os.chdir("/flash")
    sys.path[:] = ["", "/flash", "/flash/lib", ".frozen", here + "/fakes"]
    omv.name = identity
    fake_machine.reset = reset
    fake_machine.world.uart = Line()
    begun = False
    while True:
        try:
            if not begun:
                begun = True
                boot()
                write("MicroPython on a stand-in board\r\n>>> ")
            serve()
        except KeyboardInterrupt:  # Ctrl-C outside of a program, whenever it comes
            write("\r\n>>> ")


def serve():
    """The friendly REPL, as far as a program needs it."""
    while True:
        byte = read_byte()
        if byte == b"\x01":
            raw_repl()
        elif byte == b"\x04":
            write("\r\nMPY: soft reboot\r\n")
            boot()
            write(">>> ")


scope = {"__name__": "__main__"}
main(sys.argv[1], sys.argv[2])
