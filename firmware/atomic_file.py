"""Files that survive a loss of power at any byte: written anew with a CRC, then renamed.

`name` is the file in use, `name`.old the one before, `name`.new one being written. Whatever moment the
power fails, one of them is whole, and `load` finds the newest that is.
"""

import os
from binascii import crc32

_CRC_LINE = 15  # "\n#crc " + 8 hex digits + "\n"
_PIECE = 256  # bytes that are read at once, where there may be no memory for the whole text

MISSING = 0
GOOD = 1
RESTORED = 2  # the file in use was not whole; another was
CORRUPT = 3  # there are files and none is whole


def _crc_line(crc):
    return b"\n#crc %08x\n" % (crc & 0xFFFFFFFF)


def unseal(data):
    """The text of a file, which ends with a line with its CRC; None when it is not whole.

    A JSON object without the line of the CRC is taken as written by hand: cut off anywhere, it would lack
    its last brace (the texts kept here have one only at their end). Windows' editors put a mark in front."""
    if b"\n#crc" not in data and data.strip()[-1:] == b"}":
        return data.lstrip(b"\xef\xbb\xbf").decode()
    end = len(data) - _CRC_LINE
    if end < 0:
        return None
    text = data[:end]
    if data[end:] != _crc_line(crc32(text)):
        return None
    return text.decode()


class AtomicFile:
    """One kept text. `files` and `opener` replace os and open in tests."""

    def __init__(self, path, files=os, opener=open):
        self._path = path
        self._new = path + ".new"
        self._old = path + ".old"
        self._files = files
        self._open = opener

    def _read(self, path):
        """(exists, text or None)"""
        try:
            with self._open(path, "rb") as file:
                return True, unseal(file.read())
        except OSError:
            return False, None
        except (ValueError, UnicodeError):
            return True, None

    def load(self):
        """(text or None, MISSING | GOOD | RESTORED | CORRUPT)."""
        any_file = False
        for path in (self._path, self._new, self._old):
            exists, text = self._read(path)
            any_file = any_file or exists
            if text is not None:
                return text, GOOD if path == self._path else RESTORED
        return None, CORRUPT if any_file else MISSING

    def save(self, texts):
        """Writes what these texts are one after the other. Raises OSError when the flash is full, read-only
        or does not hold what was written; the text in use is then the one before."""
        self._recover()
        crc = 0
        try:
            with self._open(self._new, "wb") as file:
                for text in texts:
                    data = text.encode()
                    crc = crc32(data, crc)
                    file.write(data)
                file.write(_crc_line(crc))
            if self._seal(self._new) != _crc_line(crc):
                raise OSError("the file read back differs")
        except OSError:
            self._remove(self._new)
            raise
        if self._seal(self._path) is not None:
            self._remove(self._old)
            self._files.rename(self._path, self._old)
        self._files.rename(self._new, self._path)

    def _seal(self, path):
        """The line with the CRC that a file ends with; empty when it is another, None without the file."""
        crc, rest = 0, b""
        try:
            with self._open(path, "rb") as file:
                while True:
                    data = file.read(_PIECE)
                    if not data:
                        break
                    rest += data
                    crc = crc32(rest[:-_CRC_LINE], crc)
                    rest = rest[-_CRC_LINE:]
        except OSError:
            return None
        return rest if rest == _crc_line(crc) else b""

    def _is_whole(self, path):
        return bool(self._seal(path)) or self._read(path)[1] is not None  # written by hand

    def _recover(self):
        """Puts a whole file into use again before .new is overwritten."""
        if self._is_whole(self._path):
            return
        for path in (self._new, self._old):
            if self._is_whole(path):
                if self._seal(self._path) is not None:
                    self._remove(self._path)
                self._files.rename(path, self._path)
                return

    def _remove(self, path):
        try:
            self._files.remove(path)
        except OSError:
            pass
