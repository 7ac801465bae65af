"""The vehicle's library on the computers that it is made for: every warning an error, run in emulators.

    python tools/vehicle_targets.py [NAME ...]

A recorded stream goes through decoder, supervision, choice, drive, route, odometry and challenge; what comes
out is summed up in one CRC, which must be the same everywhere. Prints that, flash, RAM, and cycles: of an AVR
as simavr counts them, of a Cortex-M the instructions, of which qemu lets one pass each nanosecond. A target
whose tools are missing is left out, with what to install; the exit code is 1 when one fails.
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "shared")]

from tools.vehicle_build import LIBRARY, SIGNED, SOURCES, STRICT, drive_corpus  # noqa: E402

HERE = ROOT / "tests" / "vehicle" / "target"
ARDUINO = pathlib.Path("/usr/share/arduino/hardware/arduino/avr")
_LIMIT_S = 600  # only a program that hangs reaches it


@dataclass(frozen=True)
class Target:
    """compiler and flags; emulator: command before the program, () for none; packages: of Debian, by tool;
    systick_ns: instructions for one tick of its SysTick; size: the tool that tells sizes"""

    name: str
    compiler: str
    flags: tuple
    platform: str
    emulator: tuple
    packages: dict
    size: str = "size"
    link: tuple = ()


def _cortex(name, core, machine, systick_ns):
    return Target(
        name,
        "arm-none-eabi-gcc",
        ("-mthumb", "-mcpu=" + core, "-DSYSTICK_NS=%du" % systick_ns),
        "cortex",
        (
            *("qemu-system-arm", "-machine", machine, "-nographic", "-monitor", "none", "-serial", "none"),
            *("-semihosting-config", "enable=on,target=native", "-icount", "shift=0", "-kernel"),
        ),
        {"arm-none-eabi-gcc": "gcc-arm-none-eabi", "qemu-system-arm": "qemu-system-arm"},
        "arm-none-eabi-size",
        ("-nostartfiles", "-T", str(HERE / "cortex.ld"), "-Wl,--gc-sections"),
    )


def _avr(name, mcu):
    return Target(
        name,
        "avr-gcc",
        ("-mmcu=" + mcu, "-DF_CPU=16000000UL"),
        "avr",
        ("simavr", "-m", mcu, "-f", "16000000"),
        {"avr-gcc": "gcc-avr avr-libc", "simavr": "simavr"},
        "avr-size",
        ("-Wl,--gc-sections",),
    )


TARGETS = (
    Target("pc", "gcc", (), "hosted", (), {"gcc": "gcc"}),
    Target(
        "big-endian",
        "powerpc-linux-gnu-gcc",
        ("-static",),
        "hosted",
        ("qemu-ppc",),
        {
            "powerpc-linux-gnu-gcc": "gcc-powerpc-linux-gnu libc6-dev-powerpc-cross",
            "qemu-ppc": "qemu-user",
        },
        "powerpc-linux-gnu-size",
    ),
    _avr("uno", "atmega328p"),
    _avr("mega", "atmega2560"),
    _cortex("cortex-m0", "cortex-m0", "microbit", 1000 // 16),
    _cortex("cortex-m3", "cortex-m3", "mps2-an385", 1000 // 25),
    _cortex("cortex-m4", "cortex-m4", "mps2-an386", 1000 // 25),
    _cortex("cortex-m7", "cortex-m7", "mps2-an500", 1000 // 25),
)


def missing(target):
    """None when the target can be built and run, else one line that says what to install."""
    packages = [package for tool, package in target.packages.items() if not shutil.which(tool)]
    return "not installed: apt-get install " + " ".join(packages) if packages else None


def stream_header():
    """C text of the recorded stream."""
    data = drive_corpus(90, seed=5)
    rows = [", ".join(map(str, data[k : k + 24])) for k in range(0, len(data), 24)]
    body = ",\n    ".join(rows)
    return "#define STREAM_BYTES %du\nstatic const uint8_t stream[] LARICS_IN_FLASH = {\n    %s};\n" % (
        len(data),
        body,
    )


def build(target, folder):
    """The program for a target; subprocess.CalledProcessError when it does not compile without a warning."""
    folder = pathlib.Path(folder)
    (folder / "stream.h").write_text(stream_header())
    program = folder / (target.name + ".elf")
    flags = [*STRICT, "-Os", "-ffunction-sections", "-fdata-sections", *target.flags]
    sources = [str(HERE / "target.c"), str(HERE / ("platform_%s.c" % target.platform)), *map(str, SOURCES)]
    if target.platform == "cortex":  # registers at fixed addresses are no ISO C
        flags.remove("-pedantic")
        flags.remove("-std=c99")
        flags.append("-std=gnu99")
    command = [target.compiler, *flags, "-I", str(LIBRARY), "-I", str(HERE), "-I", str(folder), *sources]
    subprocess.run([*command, *target.link, "-o", str(program)], check=True)
    return program


def run(target, program):
    """{name: number} that the program prints."""
    result = subprocess.run(
        [*target.emulator, str(program)],
        capture_output=True,
        stdin=subprocess.DEVNULL,
        timeout=_LIMIT_S,
        text=True,
        errors="replace",
    )
    found = {}
    for line in result.stdout.splitlines() + result.stderr.splitlines():
        line = re.sub("\x1b\\[\\d*m", "", line)  # simavr colours what it prints
        name, sign, value = line.strip().rstrip(".").partition("=")
        if sign and value.isdigit():
            found[name.strip()] = int(value)
    if "stack" not in found:
        raise RuntimeError("%s did not run to its end: %s" % (target.name, result.stderr.strip()[-300:]))
    return found


def flash(target, folder):
    """{file of the library: bytes of code and constants}, compiled alone."""
    found = {}
    for source in SOURCES:
        made = pathlib.Path(folder) / ("%s-%s.o" % (target.name, source.stem))
        command = [target.compiler, *SIGNED, "-Os", *target.flags, "-c", str(source), "-o", str(made)]
        subprocess.run(command, check=True)
        output = subprocess.run([target.size, str(made)], check=True, capture_output=True, text=True).stdout
        text, data, _ = output.splitlines()[1].split()[:3]
        found[source.stem] = int(text) + int(data)
    return found


BOARDS = {"uno": ("atmega328p", "standard", 2048), "mega": ("atmega2560", "mega", 8192)}
ARDUINO_PACKAGES = {"avr-gcc": "gcc-avr avr-libc", "avr-g++": "gcc-avr"}
# as platform.txt of the core has them; this avr-gcc's float.h lacks DECIMAL_DIG in C++
_C_FLAGS = ("-Os", "-w", "-std=gnu11", "-ffunction-sections", "-fdata-sections")
_CPP_FLAGS = (
    *("-Os", "-w", "-std=gnu++11", "-fpermissive", "-fno-exceptions", "-fno-threadsafe-statics"),
    *("-ffunction-sections", "-fdata-sections", "-DDECIMAL_DIG=__DECIMAL_DIG__"),
)


def missing_arduino():
    """As `missing`, for sketches."""
    packages = [package for tool, package in ARDUINO_PACKAGES.items() if not shutil.which(tool)]
    if not ARDUINO.is_dir():
        packages.append("arduino-core-avr")
    return "not installed: apt-get install " + " ".join(packages) if packages else None


def sketch_sizes(board, sketches, folder):
    """{sketch: (bytes of flash, bytes of RAM)} with Debian's Arduino core; CalledProcessError when a sketch
    or the library does not compile without a warning."""
    mcu, variant, _ = BOARDS[board]
    core = ARDUINO / "cores" / "arduino"
    common = ["-mmcu=" + mcu, "-DF_CPU=16000000L", "-DARDUINO=10819", "-DARDUINO_ARCH_AVR", "-I", str(core)]
    common += ["-I", str(ARDUINO / "variants" / variant)]
    folder = pathlib.Path(folder) / board
    folder.mkdir()
    made = []

    def compile_one(compiler, flags, source):
        made.append(str(folder / (pathlib.Path(source).name + ".o")))
        subprocess.run([compiler, "-c", *flags, *common, str(source), "-o", made[-1]], check=True)

    for source in sorted(core.glob("*.c")):
        compile_one("avr-gcc", _C_FLAGS, source)
    for source in sorted(core.glob("*.cpp")):
        compile_one("avr-g++", _CPP_FLAGS, source)
    strict = ["-Wall", "-Wextra", "-Werror", "-I", str(LIBRARY)]
    for source in SOURCES:
        flags = [flag for flag in _C_FLAGS if flag != "-w"]
        compile_one("avr-gcc", [*flags, *strict, "-Wconversion", "-Wsign-conversion"], source)
    sizes = {}
    for sketch in sketches:
        flags = [flag for flag in _CPP_FLAGS if flag != "-w"]
        compile_one("avr-g++", [*flags, *strict, "-x", "c++", "-include", "Arduino.h"], sketch)
        program = folder / (sketch.stem + ".elf")
        subprocess.run(
            ["avr-g++", "-Os", "-mmcu=" + mcu, "-Wl,--gc-sections", *made, "-lm", "-o", str(program)],
            check=True,
        )
        made.pop()
        output = subprocess.run(["avr-size", str(program)], check=True, capture_output=True, text=True).stdout
        text, data, bss, *_ = map(int, output.splitlines()[1].split()[:3])
        sizes[sketch.stem] = (text + data, data + bss)
    return sizes


def all_sketches():
    return sorted((LIBRARY.parent / "examples").glob("*/*.ino"))


def main(arguments):
    wanted = [target for target in TARGETS if not arguments or target.name in arguments]
    failed, crc = False, None
    with tempfile.TemporaryDirectory() as folder:
        for target in wanted:
            reason = missing(target)
            if reason:
                print("%-10s left out, %s" % (target.name, reason))
                continue
            try:
                found = run(target, build(target, folder))
                sizes = flash(target, folder)
            except (subprocess.SubprocessError, RuntimeError) as error:
                print("%-10s FAILED: %s" % (target.name, error))
                failed = True
                continue
            crc = crc or found["crc"]
            is_same = found["crc"] == crc
            failed |= not is_same
            print(
                "%-10s %s, %d bytes of flash"
                % (target.name, "same" if is_same else "DIFFERENT", sum(sizes.values()))
            )
            print("           flash: " + " ".join("%s %d" % item for item in sizes.items()))
            rest = {name: value for name, value in found.items() if name not in ("crc", "messages")}
            print("           " + " ".join("%s %d" % item for item in rest.items()))
        reason = missing_arduino()
        if reason:
            print("sketches   left out, %s" % reason)
        for board in BOARDS if not reason else ():
            try:
                sizes = sketch_sizes(board, all_sketches(), folder)
            except subprocess.SubprocessError as error:
                print("%-10s sketches FAILED: %s" % (board, error))
                failed = True
                continue
            for sketch, (used, ram) in sizes.items():
                print("%-10s sketch %s: %d bytes of flash, %d of RAM" % (board, sketch, used, ram))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
