"""The program for a board with little memory: smaller, at the price of readable tracebacks.

    machine code   of the kernels comes from a C compiler, where there is one for the board
    names          are those that MicroPython has anyway (flash.short_names)
    bytecode       is made of native functions, which are few and not called for each pixel
    lines          of the sources are forgotten, but where files are read in place: there they take nothing

What such a traceback means is in the names that are kept of each build, for `larics traceback`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from larics_host.flash import build, machine_code, mpy_file, short_names, tracebacks

HEAP_BYTES = 448 << 10  # a heap below that is small: the usual program takes 375 KB, and some that it leaves
_KERNELS = "larics/kernels/"
# free bytes that the second opinion wants before it is loaded; the usual program says more in its source
_WITH_SECOND_OPINION = {True: 132 << 10, False: 150 << 10}
_NO_LINES = ("-O3",)
_NATIVE = re.compile(r"^ *@micropython\.native$", re.MULTILINE)


@dataclass(frozen=True)
class SmallProgram:
    """files   [(name on the board, bytes)]
    names   what translates its tracebacks, see flash.tracebacks
    lacks   why the kernels are not from a C compiler; "" when they are
    """

    files: list[tuple[str, bytes]]
    names: dict[str, Any]
    lacks: str


def compile_small(
    root: Path, march: str, in_place: bool, also: Sequence[str] = (), keep: Iterable[str] = ()
) -> SmallProgram:
    """in_place: whether its files are read where they lie, in ROMFS; also: as in build.program; keep: names
    that are called from outside. Raises UserError with what the compiler of MicroPython says."""
    try:
        return _compiled(root, march, in_place, also, keep, "")
    except machine_code.NoCompiler as error:
        return _compiled(root, march, in_place, also, keep, str(error))


def _compiled(root, march, in_place, also, keep, lacks):
    numbers = {} if lacks else {("parts", "_WITH_SECOND_OPINION"): _WITH_SECOND_OPINION[in_place]}
    texts = {name: _NATIVE.sub("", text) for name, text in build.texts(root, also, numbers).items()}
    files = build.compile_texts(texts, march, () if in_place else _NO_LINES)
    read = {name: mpy_file.MpyFile(data) for name, data in files}
    if not lacks:
        _take_machine_code(read, texts, march)
    sources = short_names.file_names([build.module_of(name) for name in read])
    renamed = short_names.chosen(
        {build.module_of(name): text for name, text in texts.items()},
        {name for file in read.values() for name in file.names},
        keep,
    )
    for name, file in read.items():
        file.names = [sources[build.module_of(name)], *[renamed.get(n, n) for n in file.names[1:]]]
    names = {
        sources[build.module_of(name)]: tracebacks.described(name, texts[name], renamed) for name in read
    }
    return SmallProgram(
        [(name, file.result()) for name, file in read.items()],
        {"lines": in_place, "files": names},
        lacks,
    )


def _take_machine_code(read, texts, march):
    kernels = {name: file for name, file in read.items() if name.startswith(_KERNELS)}
    modules = [(texts[name], file.function_table) for name, file in kernels.items()]
    for file, codes in zip(kernels.values(), machine_code.compiled(modules, march), strict=True):
        file.set_machine_code(codes)
