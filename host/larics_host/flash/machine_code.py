"""Machine code of the kernels by a C compiler, a third as long as that of mpy-cross."""

from __future__ import annotations

import shutil
import struct
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from larics_host.flash import viper_to_c

# architecture of mpy-cross -> compiler and what it is told
COMPILERS = {
    "armv7emsp": ("arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mthumb"),  # M7 and M55 run it, too
    "x64": ("gcc", "-m64"),  # for tests on a PC
}
# as the kernels count: without undefined overflow; nothing that would need a library or data beside the code
_OPTIONS = (
    "-std=c11", "-Os", "-ffreestanding", "-fno-builtin", "-fPIC", "-fwrapv", "-fno-strict-aliasing",
    "-fno-jump-tables", "-fno-tree-switch-conversion", "-fno-tree-loop-distribute-patterns",
    "-fno-asynchronous-unwind-tables", "-fno-stack-protector", "-fcf-protection=none",
    "-fno-toplevel-reorder", "-nostdlib", "-static",
    # what these would do makes longer code of the kernels
    "-fno-expensive-optimizations", "-fno-move-loop-invariants", "-fno-tree-loop-optimize",
    "-fira-algorithm=priority", "-fno-schedule-insns2", "-fno-if-conversion",
)  # fmt: skip
_SECTION = "    .code%(n)d : ALIGN(16) { *(.code%(n)d.entry) *(.code%(n)d.rest) }\n"
_LAYOUT = """
ENTRY(entry0)
SECTIONS {
%s    .else : { *(.text .text.* .data .data.* .rodata .rodata.* .bss .bss.* .got .got.* COMMON) }
    ASSERT(SIZEOF(.else) == 0, "data beside the code")
    /DISCARD/ : { *(*) }
}
"""


class NoCompiler(Exception):
    """There is no C compiler for an architecture, or it does not do its work; the text names it."""


def compiler(march: str) -> Sequence[str]:
    """The command. Raises NoCompiler."""
    command = COMPILERS.get(march)
    if command is None:
        raise NoCompiler("there is no C compiler known for %s" % march)
    if shutil.which(command[0]) is None:
        raise NoCompiler("%s is not installed" % command[0])
    return command


def compiled(modules: Sequence[tuple[str, int]], march: str) -> list[list[bytes]]:
    """The machine code of all functions, first to last, of each of these kernels' modules.

    modules: (text, which of the module's objects is the interpreter's table). Raises NoCompiler, and
    Untranslatable for what is not in the kernels' language."""
    counts: list[int] = []
    texts = [viper_to_c.PRELUDE]
    for text, table in modules:
        functions = viper_to_c.kernels(text)
        first = sum(counts)
        texts += [viper_to_c.translate(f, table, first + index) for index, f in enumerate(functions)]
        counts.append(len(functions))
    codes = iter(_compiled("\n".join(texts), sum(counts), march))
    return [[next(codes) for _ in range(count)] for count in counts]


def _compiled(text, count, march):
    with tempfile.TemporaryDirectory() as folder:
        source, layout, target = [Path(folder) / name for name in ("in.c", "layout.ld", "out.elf")]
        source.write_text(text)
        layout.write_text(_LAYOUT % "".join(_SECTION % {"n": number} for number in range(count)))
        options = [*compiler(march), *_OPTIONS, "-Wl,-T,%s,--build-id=none" % layout, "-o", target, source]
        result = subprocess.run(options, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if result.returncode:
            said = result.stdout.strip().splitlines() or ["exit code %d" % result.returncode]
            raise NoCompiler("%s fails: %s" % (options[0], said[-1]))
        sections = _sections(target.read_bytes())
    return [sections[".code%d" % number] for number in range(count)]


def _sections(elf: bytes) -> dict[str, bytes]:
    """{name: content} of the sections of an ELF file, little-endian."""
    wide = elf[4] == 2  # 64 bits
    start, size, count, names = (0x28, 0x3A, 0x3C, 0x3E) if wide else (0x20, 0x2E, 0x30, 0x32)
    (first,) = struct.unpack_from("<Q" if wide else "<I", elf, start)
    (step,), (number,), (names_at,) = [struct.unpack_from("<H", elf, place) for place in (size, count, names)]
    headers = []
    for place in range(first, first + step * number, step):
        layout = "<IIQQQQ" if wide else "<IIIIII"
        name, _, _, _, offset, length = struct.unpack_from(layout, elf, place)
        headers.append((name, elf[offset : offset + length]))
    texts = headers[names_at][1]
    return {texts[name : texts.index(b"\0", name)].decode(): content for name, content in headers}
