"""Frames from wherever they are: images, folders, video files and OpenMV streams.

`open_frames(paths)` is all that the commands need; every frame is a 2-D uint8 array of (rows, columns).
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from larics_host.addresses import Remote, is_address, list_remote
from larics_host.errors import UserError, report
from larics_host.images import openmv_stream, stills
from larics_host.wording import counted

if TYPE_CHECKING:
    from larics_host.annotations import StrPath


STILL_EXTENSIONS = (".pgm", ".png", ".jpg", ".jpeg")
STREAM_EXTENSIONS = (".bin",)
VIDEO_EXTENSIONS = (".avi", ".mp4", ".m4v", ".mkv", ".mov", ".mjpeg", ".mpg", ".webm")
EXTENSIONS = STILL_EXTENSIONS + STREAM_EXTENSIONS + VIDEO_EXTENSIONS
_VIDEO = re.compile(  # MP4 and its kin but for HEIF, Matroska, AVI, MPEG, GIF
    rb"....ftyp(?!heic|heix|mif1|avif)|\x1aE\xdf\xa3|RIFF....AVI |\0\0\x01[\xba\xb3]|GIF8[79]a", re.DOTALL
)
MAX_STILL_BYTES = 256 << 20


def _natural_key(path):
    """Sorts frame2 before frame10."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", path.name.lower())]


def list_sources(path: StrPath) -> list[Path | Remote]:
    """The files behind one argument: itself, or what a folder holds in natural order, not its sub-folders.
    Those of an address are Remote.

    Raises UserError when it does not exist or is a folder without frames.
    """
    if not str(path):
        raise UserError("an empty name of a file or folder")
    if is_address(path):
        files, alone = list_remote(str(path))
        return _in_order([one for one in files if alone or one.suffix.lower() in EXTENSIONS], path)
    path = Path(path)
    try:
        if not path.is_dir():
            if not path.exists():
                raise UserError("%s: no such file or folder" % path)
            if not path.is_file():
                raise UserError("%s: not a file or folder" % path)
            return [path]
        found = [
            entry
            for entry in path.iterdir()
            if entry.suffix.lower() in EXTENSIONS and not entry.name.startswith(".") and entry.is_file()
        ]
    except OSError as error:
        raise UserError("%s: %s" % (path, error.strerror)) from error
    return _in_order(found, path)


def _in_order(found, path):
    if not found:
        raise UserError("%s: no frames in this folder (%s)" % (path, " ".join(EXTENSIONS)))
    return sorted(found, key=_natural_key)


def _read_video(path):
    """Yields the frames; one line on standard error when there are fewer than the file should hold."""
    # ffmpeg would write its own lines to stderr; read once, when the first video is opened
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
    import cv2

    video = cv2.VideoCapture(str(path))
    try:
        if not video.isOpened():
            raise UserError("not a video that can be read")
        turn = round(video.get(cv2.CAP_PROP_ORIENTATION_META)) % 360
        if turn:
            video.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)
            stills.tell_of_turn(str(path), "turned by %d degrees" % turn)
        count = last_ms = 0
        while True:
            good, image = video.read()
            if not good:
                break
            count += 1
            last_ms = video.get(cv2.CAP_PROP_POS_MSEC)
            image = np.asarray(image)
            yield image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        if not count:
            raise UserError("the video holds no frame that can be read")
        # some files tell their length in time only: with a varying rate, the number is no more than a guess
        expected = int(video.get(cv2.CAP_PROP_FRAME_COUNT))
        in_time = round(last_ms * video.get(cv2.CAP_PROP_FPS) / 1000) + 1
        if max(count, in_time) < expected:
            report(
                "%s: the video ends early: expected %s, read %d" % (path, counted(expected, "frame"), count)
            )
    finally:
        video.release()


def _read_remote(remote):
    with remote.local() as path:
        for name, frame in read_source(path):
            yield str(remote) + name[len(str(path)) :], frame


def read_source(path: StrPath | Remote) -> Iterator[tuple[str, np.ndarray]]:
    """Yields (name, frame) of one file: its path as the name, with "#0", "#1"... when it holds several.

    The content says what it is; what it does not tell, the extension does: whether it is a video.
    Raises UserError for whatever cannot be read, after the frames that could.
    """
    if isinstance(path, Remote):
        yield from _read_remote(path)
        return
    path = Path(path)
    try:
        with path.open("rb") as file:
            head = file.read(16)
            file.seek(0)
            if not head:
                raise UserError("empty file")
            if stills.is_still(head) and path.suffix.lower() != ".mjpeg":  # JPEGs one after the other
                if path.stat().st_size > MAX_STILL_BYTES:
                    raise UserError("too large for an image")
                yield str(path), stills.decode_still(file.read(), str(path))
                return
            if head.startswith(openmv_stream.MAGIC):
                frames = openmv_stream.read_stream(file)
            elif path.suffix.lower() in VIDEO_EXTENSIONS or _VIDEO.match(head):
                frames = _read_video(path)
            elif head.startswith((b"\x1f\x8b", b"PK\x03\x04")):
                raise UserError("a compressed file: unpack it first")
            elif kind := stills.other_kind(head):
                raise UserError("a %s image: convert it to PNG, JPEG or PGM" % kind)
            else:
                raise UserError("not an image, video or OpenMV stream that larics can read")
            for index, frame in enumerate(frames):
                yield "%s#%d" % (path, index), frame
    except OSError as error:
        raise UserError("%s: %s" % (path, error.strerror)) from error
    except UserError as error:
        raise UserError("%s: %s" % (path, error)) from error


def open_frames(
    paths: Iterable[StrPath], on_error: Callable[[UserError], object] | None = None
) -> Iterator[tuple[str, np.ndarray]]:
    """Yields (name, frame) of all frames behind `paths`: files, folders, video files, OpenMV streams.

    Raises UserError at the first source that cannot be read; with `on_error`, calls it with that error
    instead and goes on with the next source, so that one bad file does not lose the others.
    """
    for argument in paths:
        try:
            sources = list_sources(argument)
        except UserError as error:
            if on_error is None:
                raise
            on_error(error)
            continue
        for source in sources:
            try:
                yield from read_source(source)
            except UserError as error:
                if on_error is None:
                    raise
                on_error(error)
