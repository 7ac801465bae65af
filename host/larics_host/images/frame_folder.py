"""A folder of frames as this program writes it: frame_<number>.pgm, in the order of their numbers."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from larics_host.errors import UserError
from larics_host.files import write_file
from larics_host.images.stills import encode_pgm
from larics_host.wording import counted

if TYPE_CHECKING:
    import numpy as np

    from larics_host.annotations import StrPath


_NAME = re.compile(r"frame_(\d+)\.pgm")


def refuse_beside(folder: Path, names: Iterable[str], overwrite: bool) -> None:
    """UserError when a folder holds one of the files that are written beside frames."""
    for name in names:
        if (folder / name).exists() and not overwrite:
            raise UserError("%s holds %s already: choose another folder or add --overwrite" % (folder, name))


def make_folder(path: StrPath, overwrite: bool = False, beside: Iterable[str] = ()) -> Path:
    """The folder, made when it is not there. UserError when it holds frames, or the files that are written
    beside them; with `overwrite` the frames go."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        old = list(folder.glob("frame_*.pgm"))
        if old and not overwrite:
            raise UserError("%s holds frames already: choose another folder or add --overwrite" % folder)
        refuse_beside(folder, beside, overwrite)
        for file in old:
            file.unlink()
    except OSError as error:
        raise UserError("cannot write to %s: %s" % (folder, error.strerror)) from None
    return folder


def frame_name(number: int) -> str:
    return "frame_%06d.pgm" % number


def number_of(name: str) -> int | None:
    """The number in a frame's name; None for another name."""
    match = _NAME.fullmatch(name)
    return int(match.group(1)) if match else None


def write_frame(path: StrPath, frame: np.ndarray) -> None:
    """Writes a 2-D uint8 array as PGM. UserError when that fails."""
    write_file(path, encode_pgm(frame))


class Kept:
    """How many frames of a run are whole, and the other files that belong to them."""

    def __init__(self, folder: Path, others: Iterable[str]) -> None:
        self.folder = folder
        self.frames = 0
        self._others = tuple(others)

    def text(self) -> str:
        """For a sentence."""
        return "%s kept in %s" % (counted(self.frames, "frame"), self.folder)

    def discard_empty(self) -> None:
        """Takes away what is of no use without a frame."""
        with contextlib.suppress(OSError):
            for name in self._others:
                (self.folder / name).unlink(missing_ok=True)
            self.folder.rmdir()  # fails when something else is in it


@contextlib.contextmanager
def keeping(folder: Path, others: Iterable[str]) -> Iterator[Kept]:
    """Around a run that writes frames: an error tells how many are kept, and leaves nothing without one.

    others: names of the files written beside them. Ends by KeyboardInterrupt as any other way."""
    kept = Kept(folder, others)
    try:
        yield kept
    except (UserError, KeyboardInterrupt) as error:
        if not kept.frames:
            kept.discard_empty()
        if kept.frames and isinstance(error, UserError):
            raise UserError("%s; %s" % (error, kept.text())) from error
        raise
