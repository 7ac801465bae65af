"""A folder of frames as this program writes it: frame_<number>.pgm, in the order of their numbers."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from larics_host.errors import UserError
from larics_host.files import write_file
from larics_host.images.stills import encode_pgm

if TYPE_CHECKING:
    import numpy as np

    from larics_host.annotations import StrPath


_NAME = re.compile(r"frame_(\d+)\.pgm")


def make_folder(path: StrPath, overwrite: bool = False) -> Path:
    """The folder, made when it is not there. UserError when it holds frames; with `overwrite` they go."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        old = list(folder.glob("frame_*.pgm"))
        if old and not overwrite:
            raise UserError("%s holds frames already: choose another folder or add --overwrite" % folder)
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
