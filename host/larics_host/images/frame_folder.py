"""A folder of frames as this program writes it: frame_<number>.pgm, in the order of their numbers."""

import re
from pathlib import Path

from larics_host.errors import UserError
from larics_host.files import write_file
from larics_host.images.stills import encode_pgm

_NAME = re.compile(r"frame_(\d+)\.pgm")


def make_folder(path, overwrite=False):
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


def frame_name(number):
    return "frame_%06d.pgm" % number


def number_of(name):
    """The number in a frame's name; None for another name."""
    match = _NAME.fullmatch(name)
    return int(match.group(1)) if match else None


def write_frame(path, frame):
    """Writes a 2-D uint8 array as PGM. UserError when that fails."""
    write_file(path, encode_pgm(frame))
