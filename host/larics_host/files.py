"""Files that a user names: what goes wrong with them becomes one line.

Texts are read as editors, spreadsheets and consoles of all systems save them: UTF-8 with or without a byte
order mark, UTF-16, UTF-32, and Windows' old Western code page. This program itself writes UTF-8.
"""

from __future__ import annotations

import codecs
import contextlib
import errno
import io
import json
import os
import re
import stat
import zlib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from larics_host.errors import UserError
from larics_host.packed import MAGIC, opened, place

if TYPE_CHECKING:
    from larics_host.annotations import StrPath

_HEAD_BYTES = 4096
_MARKS = (  # UTF-32 first: its mark begins with that of UTF-16
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_CONTROLS = re.compile("[\x01-\x08\x0b\x0e-\x1f]")  # no text has them; zeros are told apart
_MOST_NESTING = 32
_CURLY = "'\u2018\u2019\u201c\u201d`"  # quotes of other languages than JSON
_SEAL = re.compile(r"\n#crc ([0-9a-f]{8})\s*\Z")  # as firmware/atomic_file.py writes it
_PROGRESS_LINES = 4096


def encoding_of(head: bytes) -> str:
    """The encoding of a text by its first bytes: of its mark, or UTF-16 where every other byte is 0."""
    for mark, name in _MARKS:
        if head.startswith(mark):
            return name
    even, odd = head[0::2].count(0), head[1::2].count(0)
    if odd > len(head) // 3 > 2 * even:
        return "utf-16-le"
    if even > len(head) // 3 > 2 * odd:
        return "utf-16-be"
    return "utf-8"


def read_bytes(path: StrPath) -> bytes:
    """All bytes of a file. UserError when it cannot be read."""
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error


def size(path: StrPath) -> int:
    """Bytes of a file, 0 where that is not known."""
    try:
        return os.stat(path).st_size
    except OSError:
        return 0


def read_text(path: StrPath) -> str:
    """The text of a file. UserError when it cannot be read, is none, or is damaged."""
    data = read_bytes(path)
    if data.startswith(MAGIC):
        raise UserError("%s is a compressed file: unpack it first" % path)
    encoding = encoding_of(data[:_HEAD_BYTES])
    no_text = "%s is no text, or a damaged one: some of it is not %s" % (path, encoding.upper())
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError:
        if encoding != "utf-8":
            raise UserError(no_text) from None
        text = data.decode("cp1252", errors="replace")
    if _CONTROLS.search(text):
        raise UserError(no_text)
    if "\0" in text:
        what = "zero bytes" if text.strip("\0") else "nothing but zero bytes"
        raise UserError(
            "%s holds %s: it was damaged, as by a loss of power; restore it from a copy" % (path, what)
        )
    return text


def unwatched(done: int) -> None:
    """A progress that nobody wants to know."""


def lines(path: StrPath, progress: Callable[[int], object] = unwatched) -> Iterator[str]:
    """Yields the lines of a text that may be long and damaged, with their ends as "\\n".

    What cannot be decoded becomes U+FFFD. progress is told now and then how many bytes have been read.
    UserError when the file cannot be read."""
    try:
        with opened(path) as file:
            encoding = encoding_of(file.peek(_HEAD_BYTES)[:_HEAD_BYTES])
            with io.TextIOWrapper(file, encoding, errors="replace") as text:
                for number, line in enumerate(text):
                    if not number % _PROGRESS_LINES:
                        progress(place(file))
                    yield line
    except OSError as error:
        raise UserError("cannot read %s: %s" % (path, error.strerror)) from error


def _depth(value):
    """How deep lists and tables lie in each other."""
    depth, level = 0, [value]
    while level:
        depth += 1
        level = [
            item
            for one in level
            if isinstance(one, (list, dict))
            for item in (one.values() if isinstance(one, dict) else one)
        ]
    return depth


def _no_json(error):
    """What is wrong with a text that is no JSON, for a person, of the decoder's error."""
    if not error.doc.strip():
        return "it is empty"
    before, rest = error.doc[: error.pos].rstrip(), error.doc[error.pos :].lstrip()
    if not rest or error.msg.startswith("Unterminated string"):
        return "it ends in the middle, as if cut off"
    what = error.msg
    if rest.startswith(("//", "/*", "#")):
        what = "JSON has no comments: take out that"
    elif rest[0] in "}]" and before.endswith(","):
        what = "nothing follows the comma"
    elif rest[0] in _CURLY:
        what = 'names and texts stand in straight double quotes, "", not in %s' % rest[0]
    return "%s in line %d" % (what, error.lineno)


def parse_json(text: str, pairs: Callable[[list[tuple[str, Any]]], Any] | None = None) -> Any:
    """The value of a JSON text; ValueError, in words for a person, where it is none or is nested absurdly.

    pairs: makes the value of each table, as json.loads takes it."""
    too_deep = "it is nested more than %d levels deep" % _MOST_NESTING
    try:
        value = json.loads(text, object_pairs_hook=pairs)
    except RecursionError:
        raise ValueError(too_deep) from None
    except json.JSONDecodeError as error:
        raise ValueError(_no_json(error)) from None
    except ValueError:  # Python's limit, which its text explains for programmers
        raise ValueError("a number in it has thousands of digits") from None
    if text.count("[") + text.count("{") > _MOST_NESTING and _depth(value) > _MOST_NESTING:
        raise ValueError(too_deep)
    return value


def read_json(path: StrPath) -> Any:
    """What a JSON file holds, also one as a camera keeps it, with the line of its checksum. UserError when it
    cannot be read, is none, or gives a name two values."""
    text = read_text(path)
    twice: list[str] = []

    def table(pairs):
        names = [name for name, _ in pairs]
        twice.extend(name for name in names if names.count(name) > 1)
        return dict(pairs)

    sealed = _SEAL.search(text)
    if sealed:
        text = text[: sealed.start()]
        if zlib.crc32(text.encode()) != int(sealed[1], 16):
            raise UserError(
                "%s was damaged, or changed by hand: its checksum does not fit; without that last line it is "
                "read as it is" % path
            )
    try:
        value = parse_json(text, table)
    except ValueError as error:
        raise UserError("%s is no JSON file: %s" % (path, error)) from None
    if twice:
        raise UserError("%s gives %s twice: take one of them out" % (path, twice[0]))
    return value


class CannotWrite(UserError):
    """A file cannot be written, or no further: no room, no permission. The text names it."""


def _why(path, error):
    return "cannot write %s: %s" % (path, error.strerror or error)


def write_file(path: StrPath, content: bytes | str) -> None:
    """Writes bytes, or text as UTF-8, names of files that are none escaped: the whole file, or CannotWrite.

    What was there before is only replaced by what is complete."""
    data = content.encode(errors="backslashreplace") if isinstance(content, str) else content
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():  # a device or a pipe
        try:
            target.write_bytes(data)
        except OSError as error:
            raise CannotWrite(_why(path, error)) from error
        return
    beside = target.with_name(".%s.%d.part" % (target.name[:200], os.getpid()))
    before = "; the one before is kept" if target.exists() else ""
    try:
        if before and not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        beside.write_bytes(data)
        if before:
            beside.chmod(stat.S_IMODE(target.stat().st_mode))
        beside.replace(target)
    except OSError as error:
        with contextlib.suppress(OSError):
            beside.unlink()
        raise CannotWrite(_why(path, error) + before) from error


class GrowingFile:
    """A new file that grows by whole pieces, each out of the program at once; one for which there is no room
    is taken back, so that what stays is complete. CannotWrite when it cannot be made or written."""

    def __init__(self, path: StrPath) -> None:
        self.path = path
        self.size = 0  # bytes written
        self._pending = b""
        try:
            self._file = open(path, "wb", buffering=0)  # noqa: SIM115 (closed in close())
        except OSError as error:
            raise CannotWrite(_why(path, error)) from error

    @property
    def closed(self) -> bool:
        return self._file.closed

    def append(self, data: bytes) -> None:
        """Adds a piece."""
        left = memoryview(data)
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError as error:
            with contextlib.suppress(OSError):  # of a device
                self._file.truncate(self.size)
                self._file.seek(self.size)
            raise CannotWrite(_why(self.path, error)) from error
        self.size += len(data)

    def write(self, data: bytes) -> int:
        """Collects for `flush`, for whoever writes a piece in several steps."""
        self._pending += data
        return len(data)

    def flush(self) -> None:
        """Adds what was collected as one piece."""
        data, self._pending = self._pending, b""
        self.append(data)

    def tell(self) -> int:
        """Where the next byte goes."""
        return self.size + len(self._pending)

    def close(self) -> None:
        self._file.close()

    def discard(self) -> None:
        """Closes and removes it."""
        self.close()
        with contextlib.suppress(OSError):
            if os.path.isfile(self.path):
                os.unlink(self.path)


# The one rule of all commands: data, as settings, maps, logs and tables, never takes the place of a file
# without --force, and frames and what lies beside them not without --overwrite. Pictures and pages are drawn
# anew each time: they take the place of a picture or a page, and of nothing else.
PICTURE, PAGE = b"\x89PNG", b"<!doctype html"  # how files begin that are drawn anew each time
_ENDS = {PICTURE: (".png",), PAGE: (".html", ".htm")}


def refuse_other(path: StrPath, kind: bytes, read: Iterable[StrPath] = ()) -> None:
    """UserError when a picture or page would take the place of something else, or of what it is made from, or
    when a picture would lie among those that are read, or when its name is that of another kind of file.

    kind: PICTURE or PAGE; read: the files that are read, and the folders whose pictures are."""
    target = Path(path)
    sources = [Path(source) for source in read]
    if kind == PICTURE and not target.exists():
        for source in sources:
            if source.is_dir() and target.parent.exists() and source.samefile(target.parent):
                raise UserError("%s would lie among the frames that are read: choose another folder" % path)
    if not target.exists() and target.suffix.lower() not in _ENDS[kind]:
        what, end = ("picture is a PNG", ".png") if kind == PICTURE else ("page is HTML", ".html")
        raise UserError("%s: the %s: name it %s" % (path, what, target.with_suffix(end).name))
    if not target.is_file():
        return
    for source in sources:
        if source.exists() and (source.samefile(target) or source.samefile(target.parent)):
            raise UserError("%s would overwrite what is read: choose another name" % path)
    with contextlib.suppress(OSError), open(target, "rb") as file:
        head = file.read(len(kind))
        if head and head.lower() != kind.lower():
            what = "picture" if kind == PICTURE else "page"
            raise UserError("%s exists and is no %s: choose another name" % (path, what))


def refuse_existing(path: StrPath, force: bool) -> None:
    """UserError when the file is there already and may not be overwritten; a device or a pipe may."""
    target = Path(path)
    if (target.is_file() or target.is_dir()) and not force:
        raise UserError("%s exists: choose another name, or --force to overwrite it" % path)
