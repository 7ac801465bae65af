"""Files behind addresses that fsspec opens, as s3://, beside those of this computer.

An address is what holds "://"; whatever takes a path of frames or of a log takes an address, too.
"""

from __future__ import annotations

import contextlib
import glob
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from typing import Any, BinaryIO

from larics_host.errors import UserError, missing_package


def is_address(text: object) -> bool:
    """Whether fsspec has to open it."""
    return "://" in str(text)


def file_system(address: str) -> tuple[Any, str]:
    """(file system of fsspec, path in it). UserError without fsspec, or where it knows no such."""
    try:
        import fsspec
    except ImportError:
        raise missing_package(address, "fsspec") from None
    try:
        return fsspec.core.url_to_fs(address)
    except (ImportError, ValueError) as error:
        raise UserError("%s: %s" % (address, error)) from None
    except OSError as error:
        raise UserError("%s: %s" % (address, error.strerror or error)) from None


class Remote:
    """A file of fsspec; `str` is its address, `size` its bytes. It can be sent to other processes."""

    def __init__(self, system: Any, path: str, size: int) -> None:
        self.system = system
        self.path = path
        self.size = size

    def __str__(self) -> str:
        return self.system.unstrip_protocol(self.path)

    @property
    def name(self) -> str:
        return PurePosixPath(self.path).name

    @property
    def suffix(self) -> str:
        return PurePosixPath(self.path).suffix

    def open(self) -> BinaryIO:
        """The file, to be read. OSError when it cannot be."""
        return self.system.open(self.path, "rb")

    @contextlib.contextmanager
    def local(self) -> Iterator[Path]:
        """A copy on this computer, removed afterwards. UserError when it cannot be made."""
        with tempfile.TemporaryDirectory(prefix="larics-") as folder:
            path = Path(folder) / self.name
            try:
                with self.open() as source, open(path, "wb") as target:
                    shutil.copyfileobj(source, target, 1 << 20)
            except OSError as error:
                raise UserError("cannot read %s: %s" % (self, error.strerror or error)) from None
            yield path


def list_remote(address: str, deep: bool = False) -> tuple[list[Remote], bool]:
    """(the files behind an address, whether it is that of one file): of a pattern those that fit, of a folder
    those in it, with deep=True also in its sub-folders. UserError when it cannot be listed."""
    system, path = file_system(address)
    try:
        if glob.has_magic(path):
            paths = [one for one in system.glob(path) if system.isfile(one)]
        elif system.isdir(path):
            paths = system.find(path, maxdepth=None if deep else 1)
        else:
            return [Remote(system, path, system.size(path) or 0)], True
        return [Remote(system, one, system.size(one) or 0) for one in sorted(paths)], False
    except OSError as error:
        raise UserError("%s: %s" % (address, error.strerror or "no such file or folder")) from None
