"""Files as they are or packed by gzip, read alike: what is whole comes out, damage is told."""

from __future__ import annotations

import io
import zlib
from typing import TYPE_CHECKING, BinaryIO

from larics_host.errors import report_once

if TYPE_CHECKING:
    from larics_host.annotations import StrPath

MAGIC = b"\x1f\x8b"
_PIECE = 1 << 16


class _Unpacked(io.RawIOBase):
    """The bytes of gzip members one after the other, as `cat a.gz b.gz` makes them."""

    def __init__(self, stream: BinaryIO, name: str) -> None:
        self._stream, self._name = stream, name
        self._member = None
        self._packed = self._ready = b""

    def readable(self):
        return True

    def readinto(self, buffer):
        while not self._ready:
            self._packed = self._packed or self._stream.read(_PIECE)
            if not self._packed:
                return self._end("is cut off" if self._member else None)
            if self._member is None:
                self._packed = self._packed.lstrip(b"\0")  # of a tape or a block device
                if not self._packed:
                    continue
                if not MAGIC.startswith(self._packed[:2]):
                    return self._end("is damaged: something else follows the packed data")
                self._member = zlib.decompressobj(31)
            try:
                self._ready = self._member.decompress(self._packed, _PIECE)
            except zlib.error:
                return self._end("is damaged")
            self._packed = self._member.unused_data or self._member.unconsumed_tail
            if self._member.eof:
                self._member = None
        count = min(len(buffer), len(self._ready))
        buffer[:count], self._ready = self._ready[:count], self._ready[count:]
        return count

    def _end(self, why):
        if why:
            text = "%s %s; what is whole of it is read" % (self._name, why)
            report_once(text, text)
        self._packed, self._member, self._stream = b"", None, io.BytesIO()
        return 0

    def place(self) -> int:
        """Bytes of the packed file that were read."""
        return self._stream.tell()

    def close(self):
        self._stream.close()
        super().close()


def opened(path: StrPath) -> io.BufferedReader:
    """A file, to be read once from its beginning. OSError when it cannot be opened."""
    file = open(path, "rb")  # noqa: SIM115 (the caller's)
    if file.peek(2)[:2] == MAGIC:
        return io.BufferedReader(_Unpacked(file, str(path)))
    return file


def place(file: io.BufferedReader) -> int:
    """Bytes of what `opened` opened that were read, of a packed one packed."""
    raw = file.raw
    return raw.place() if isinstance(raw, _Unpacked) else file.tell()
