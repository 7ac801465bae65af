"""Logs behind paths and addresses, cut into blocks that can be read apart from each other.

JSON lines are read in blocks by whoever works on them, so that a log may be larger than any memory; other
logs (.csv, .bin, .mcap, and compressed ones) are one block, read as a stream.
"""

from __future__ import annotations

import contextlib
import glob
import gzip
import lzma
import tempfile
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO, NamedTuple

from larics_host.addresses import is_address, list_remote
from larics_host.errors import UserError, missing_package, report_once
from larics_host.files import encoding_of
from larics_host.packed import MAGIC

KINDS = (".jsonl", ".mcap", ".csv", ".bin")  # of one log in several forms, the first is read
PACKED = (".gz", ".bz2", ".xz", ".zst")
BLOCK_BYTES = 4 << 20
_HEAD_BYTES = 256
_PIECE = 1 << 14  # of a packed file: what comes before its damage is kept
_LINE_MOST = 1 << 16  # a longer one is none; and a file without line ends must not fill the memory


class Source(NamedTuple):
    """A log: its name for people, the file system of fsspec (None: this computer's), and its path there."""

    name: str
    system: Any
    path: str
    size: int
    vehicle: str

    def open(self) -> BinaryIO:
        """The file, to be read. OSError when it cannot be."""
        return open(self.path, "rb") if self.system is None else self.system.open(self.path, "rb")


class Block(NamedTuple):
    """Bytes of a log in which lines begin that belong to it; `end` None for all there is."""

    source: Source
    start: int
    end: int | None


def list_logs(arguments: Iterable[str], by: str | None = None) -> list[Source]:
    """The logs behind files, folders (with those in them) and patterns, in the order of their names.

    by   "folder" or "file": what a vehicle is called by; None: by folder when the logs lie in several
    UserError when an argument stands for none."""
    found: dict[tuple[str, str], tuple[str, Any, str, int]] = {}
    for argument in arguments:
        for one in _behind(argument):
            found[str(one[1] and one[1].protocol), one[2]] = one
    logs = sorted(found.values())
    folders = {str(PurePosixPath(path).parent) for _, _, path, _ in logs}
    by = by or ("folder" if len(folders) > 1 else "file")
    return [Source(*log, _vehicle(log[2], by)) for log in logs]


def _vehicle(path, by):
    path = PurePosixPath(path)
    return path.parent.name or "/" if by == "folder" else _stem(path)


def _stem(path):
    """The name without the ending that says what kind of log it is."""
    name = path.name
    for ending in (*PACKED, *KINDS):
        name = name.removesuffix(ending)
    return name


def _kind(path):
    """One of KINDS, or None."""
    name = str(path)
    for ending in PACKED:
        name = name.removesuffix(ending)
    return PurePosixPath(name).suffix if PurePosixPath(name).suffix in KINDS else None


def _behind(argument):
    """(name, system, path, size) of what an argument stands for."""
    try:
        system, entries = _addressed(argument) if is_address(argument) else (None, _local(argument))
    except OSError as error:
        raise UserError("%s: %s" % (argument, error.strerror or error)) from None
    alone = len(entries) == 1 and entries[0][2]
    best: dict[tuple[str, str], tuple[int, str, int]] = {}
    for path, size, _ in entries:
        kind = _kind(path)
        if kind is None and not alone:
            continue
        stem = (str(PurePosixPath(path).parent), _stem(PurePosixPath(path)))
        rank = KINDS.index(kind) if kind else 0
        if stem not in best or rank < best[stem][0]:
            best[stem] = rank, path, size
    if not best:
        raise UserError("%s: no log there (%s)" % (argument, " ".join(KINDS)))
    return [
        (path if system is None else system.unstrip_protocol(path), system, path, size)
        for _, path, size in best.values()
    ]


def _local(argument):
    """[(path, size, whether it was named itself)] of this computer."""
    path = Path(argument)
    if path.is_dir():
        return [(str(p), p.stat().st_size, False) for p in sorted(path.rglob("*")) if p.is_file()]
    if path.is_file():
        return [(str(path), path.stat().st_size, True)]
    return [(p, Path(p).stat().st_size, False) for p in sorted(glob.glob(argument, recursive=True))]


def _addressed(argument):
    files, alone = list_remote(argument, deep=True)
    return files[0].system if files else None, [(one.path, one.size, alone) for one in files]


def blocks(sources: Iterable[Source], block_bytes: int = BLOCK_BYTES) -> Iterator[Block]:
    """The Blocks of all logs, in their order."""
    for source in sources:
        if not source.path.endswith(".jsonl") or _is_odd(source):
            yield Block(source, 0, None)
            continue
        for start in range(0, max(1, source.size), block_bytes):
            yield Block(source, start, start + block_bytes)


def _is_odd(source):
    """Whether JSON lines of this computer are packed all the same, or of another encoding."""
    if source.system is not None:
        return False
    try:
        with source.open() as file:
            head = file.read(_HEAD_BYTES)
    except OSError:
        return False  # whoever reads it tells
    return head.startswith(MAGIC) or encoding_of(head) not in ("utf-8", "utf-8-sig")


def lines(block: Block) -> Iterator[bytes]:
    """The lines that begin in a block, with their ends; of one that is too long its beginning."""
    with block.source.open() as file:
        position = block.start
        if position:  # what began before belongs to the block before
            file.seek(position - 1)
            position = _end_of_line(file, b"", position - 1, block.end)
        while block.end is None or position < block.end:
            line = file.readline(_LINE_MOST)
            if not line:
                return
            position = _end_of_line(file, line, position + len(line), block.end)
            yield line


def _end_of_line(file, piece, position, end):
    """Where the line ends of which `piece` was read up to `position`; no farther than a block needs."""
    while not piece.endswith(b"\n") and (len(piece) == _LINE_MOST or not piece):
        if end is not None and position > end:
            break
        piece = file.readline(_LINE_MOST)
        position += len(piece)
        if not piece:
            break
    return position


@contextlib.contextmanager
def local_copy(source: Source) -> Iterator[Path]:
    """The path of a log on this computer: its own, or of a copy that is removed afterwards, unpacked."""
    packed = source.path.endswith(PACKED)
    if source.system is None and (not packed or source.path.endswith(".gz")):
        yield Path(source.path)
        return
    name = PurePosixPath(source.path).name
    with tempfile.TemporaryDirectory(prefix="larics-fleet-") as folder:
        path = Path(folder) / (PurePosixPath(name).stem if packed else name)
        with contextlib.ExitStack() as stack:
            stream: Any = stack.enter_context(source.open())
            if packed:
                stream = stack.enter_context(_unpacked(stream, name))
            target = stack.enter_context(open(path, "wb"))
            try:
                while piece := stream.read(_PIECE):
                    target.write(piece)
            except (EOFError, lzma.LZMAError, zlib.error, gzip.BadGzipFile):
                report_once(
                    source.name, "%s is cut off or damaged; what is whole of it is read" % source.name
                )
        yield path


def _unpacked(stream, name):
    try:
        from fsspec.compression import compr
        from fsspec.utils import infer_compression
    except ImportError:
        raise missing_package(name, "fsspec") from None
    kind = infer_compression(name)
    if kind not in compr:
        raise UserError("%s: this kind of compression needs the Python package zstandard" % name)
    return compr[kind](stream, mode="rb")
