"""The program for a board with little memory: smaller, at the price of readable tracebacks.

    machine code   of the kernels comes from a C compiler, where there is one for the board
    names          are those that MicroPython has anyway (flash.short_names), each in a file
                   once (flash.bytecode)
    modules        have such names, too, without packages; kernels are few modules (flash.flat_modules),
                   and so is the rest (flash.joined_modules), but where files are read in place
    texts          of errors and of reasons are left out (flash.silent)
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

from larics_host.flash import (
    build,
    bytecode,
    flat_modules,
    joined_modules,
    machine_code,
    mpy_file,
    short_names,
    silent,
    tracebacks,
)

HEAP_BYTES = 448 << 10  # a heap below that is small: the usual program takes 382 KB, and some that it leaves
_KERNELS = "larics/kernels/"
# free bytes that the second opinion wants before it is loaded; the usual program says more in its source
_WITH_SECOND_OPINION = {True: 132 << 10, False: 110 << 10}
_RESERVE = 12 << 10  # bytes that a detector leaves to the rest, which takes less than in the usual program
_NO_LINES = ("-O3",)
_NATIVE = re.compile(r"^ *@micropython\.native$", re.MULTILINE)


@dataclass(frozen=True)
class SmallProgram:
    """files   [(name on the board, bytes)]
    names   what translates its tracebacks, see flash.tracebacks
    lacks   why the kernels are not from a C compiler; "" when they are
    holds   {name on the board: names of the usual build's files that it stands for}
    """

    files: list[tuple[str, bytes]]
    names: dict[str, Any]
    lacks: str
    holds: dict[str, list[str]]


def compile_small(
    root: Path,
    march: str,
    in_place: bool,
    also: Sequence[str] = (),
    keep: Iterable[str] = (),
    loads: Iterable[str] | None = None,
) -> SmallProgram:
    """in_place: whether its files are read where they lie, in ROMFS; also: as in build.program; keep: names
    that are called from outside; loads: modules that are loaded from there, if not all with such a name.
    Raises UserError with what the compiler of MicroPython says."""
    keep = set(keep)
    loads = keep if loads is None else set(loads)
    try:
        return _compiled(root, march, in_place, also, keep, loads, "")
    except machine_code.NoCompiler as error:
        return _compiled(root, march, in_place, also, keep, loads, str(error))


def _compiled(root, march, in_place, also, keep, loads, lacks):
    numbers = {
        ("parts", "_WITH_SECOND_OPINION"): _WITH_SECOND_OPINION[in_place],
        ("parts", "_RESERVE"): _RESERVE,
    }
    linked = build.texts(root, also, {} if lacks else numbers, silent.silent)
    usual = {build.module_of(name): name for name in linked}
    kernels = {module for module, name in usual.items() if name.startswith(_KERNELS)}
    modules = {build.module_of(name): _NATIVE.sub("", text) for name, text in linked.items()}
    sources = modules
    parts = {module: {module: text} for module, text in modules.items()}
    if not in_place:
        groups = flat_modules.loaded_together(modules, kernels, loads)
        joined = joined_modules.joined(modules, groups, kernels)
        modules, parts = joined.texts, joined.parts
    flat = flat_modules.flattened(modules, kernels, loads)
    texts = {usual.get(module, module + ".mpy"): text for module, text in flat.texts.items()}
    files = build.compile_texts(texts, march, () if in_place else _NO_LINES)
    read = {name: mpy_file.MpyFile(data) for name, data in files}
    if not lacks:
        _take_machine_code(
            [
                (texts[name], file)
                for name, file in read.items()
                if kernels.issuperset(flat.origins[build.module_of(name)])
            ],
            march,
        )
    places = short_names.file_names(list(flat.texts))
    taken = {name for file in read.values() for name in file.names} - (set(flat.texts) - set(modules))
    renamed = short_names.chosen(flat.texts, taken, keep, sources)
    holds = {
        module: [usual[origin] for first in origins for origin in parts[first]]
        for module, origins in flat.origins.items()
    }
    described = {}
    for name, file in read.items():
        module = build.module_of(name)
        file.names = [places[module], *[renamed.get(n, n) for n in file.names[1:]]]
        bytecode.share_names(file, has_lines=in_place)
        if in_place:
            described[places[module]] = tracebacks.described(holds[module][0], texts[name], renamed)
        else:
            described[places[module]] = tracebacks.together(
                [
                    tracebacks.described(usual[origin], text, renamed)
                    for first in flat.origins[module]
                    for origin, text in parts[first].items()
                ]
            )
    return SmallProgram(
        [(name, file.result()) for name, file in read.items()],
        {"lines": in_place, "files": described},
        lacks,
        {name: holds[build.module_of(name)] for name in read},
    )


def _take_machine_code(kernels, march):
    """kernels: (text, file)"""
    modules = [(text, file.function_table) for text, file in kernels]
    for (_, file), codes in zip(kernels, machine_code.compiled(modules, march), strict=True):
        file.set_machine_code(codes)
