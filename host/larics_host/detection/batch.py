"""Detection in many frames on all cores; the results come in the order of the frames."""

from __future__ import annotations

import itertools
import os
import time
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from larics_host.addresses import Remote
from larics_host.compilation import told
from larics_host.detection import detectors
from larics_host.errors import UserError, report_once, withheld
from larics_host.fleet import engine
from larics_host.images.frame_sources import STILL_EXTENSIONS, list_sources, read_source

if TYPE_CHECKING:
    from larics_host.annotations import StrPath
    from larics_host.detection.options import DetectionOptions


_BLOCK = 16  # frames handed to a process at a time
_BLOCK_SENT = 128  # to another computer, which costs some milliseconds
_POOL_FROM = 6000  # frames from which starting processes pays
_STREAM_FRAME_BYTES = 60_000  # a guess of what a frame of a stream takes


class Result(NamedTuple):
    """What became of a frame.

    found   detections as dicts, None when the frame or its source could not be processed; then `error`
            says why. `width` is 0 when not even the frame could be read
    ms      time of the detection, None for the first frame of a size, which also loads the kernels
    frame   the frame itself, when it was asked for
    """

    name: str
    width: int = 0
    height: int = 0
    found: list | None = None
    ms: float | None = None
    error: str | None = None
    frame: np.ndarray | None = None


class _Work:
    """One detector for each frame size, made when the first frame of that size comes."""

    def __init__(self, options, keep_frames):
        self._options = options
        self._keep = keep_frames
        self._by_size = {}

    def block(self, items):
        """The results of a block: items are paths of images, or (name, frame)."""
        results = []
        for item in items:
            if isinstance(item, tuple):
                results.append(self.detect(*item))
                continue
            try:
                results += [self.detect(name, frame) for name, frame in read_source(item)]
            except UserError as error:
                results.append(Result(str(item), error=str(error)))
        return results

    def detect(self, name, frame):
        height, width = frame.shape
        size = (width, height)
        fresh = size not in self._by_size
        if fresh:
            try:
                self._by_size[size] = detector = self._options.make(width, height)
                if getattr(detector, "factor", 1) > 1:
                    _tell_of_reduction(name, width, height, detector)
            except UserError as error:
                self._by_size[size] = error
        detector = self._by_size[size]
        if isinstance(detector, UserError):
            return Result(name, width, height, error="%s: %s" % (name, detector))
        start = time.perf_counter()
        with told("the detection"):
            found = [detectors.as_dict(one) for one in detector.detect(frame)]
        ms = None if fresh else 1000 * (time.perf_counter() - start)
        return Result(name, width, height, found, ms, None, frame if self._keep else None)


def _tell_of_reduction(name, width, height, detector):
    level = detector.levels[0]
    text = "%s: frames of %d x %d px are reduced %d times; results in original pixels, rings from %d px on"
    numbers = width, height, level.factor, level.factor * level.low_px
    report_once(("reduced", width, height), text % (name, *numbers))


_works: dict[str, _Work] = {}  # of this process


def _run(task):
    """(results, lines to tell) of a block, in whatever process."""
    options, keep_frames, items = task
    key = repr((options, keep_frames))
    if key not in _works:
        _works.clear()
        _works[key] = _Work(options, keep_frames)
    with withheld() as lines:
        return _works[key].block(items), lines


def _told(answer):
    """The results of a block, once what their process had to say is said."""
    results, lines = answer
    for about, text in lines:
        report_once(about, text)
    return results


def _sources(paths, errors):
    for path in paths:
        try:
            yield from list_sources(path)
        except UserError as error:
            errors.append(Result(str(path), error=str(error)))


def _is_still(path):
    return path.suffix.lower() in STILL_EXTENSIONS


def count_frames(paths: Iterable[StrPath]) -> tuple[int | None, int]:
    """(number of frames, None when only reading them would tell; how long the longest name is)."""
    found = list(_sources(paths, []))
    width = max([5] + [len(str(path)) for path in found])
    return (len(found), width) if all(map(_is_still, found)) else (None, width + 6)


def _blocks(paths, errors, most):
    """Blocks of images by path, for whoever takes them to read, and of frames read here from streams."""
    block = []
    for path in _sources(paths, errors):
        if _is_still(path):
            block.append(path)
        else:
            try:
                for item in read_source(path):
                    block.append(item)
                    if len(block) >= most:
                        yield block
                        block = []
            except UserError as error:
                errors.append(Result(str(path), error=str(error)))
        if len(block) >= most:
            yield block
            block = []
    if block:
        yield block


def usual_jobs(paths: Iterable[StrPath]) -> int:
    """How many processes are worth starting."""
    frames = 0
    for path in _sources(paths, []):
        size = path.size if isinstance(path, Remote) else path.stat().st_size
        frames += 1 if _is_still(path) else size // _STREAM_FRAME_BYTES
    return cores() if frames >= _POOL_FROM else 1


def cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def detect_all(
    paths: Iterable[StrPath],
    options: DetectionOptions,
    jobs: int | None = None,
    keep_frames: bool = False,
    scheduler: str | None = None,
) -> Iterator[Result]:
    """Yields a Result for every frame behind `paths`, and one for every source that cannot be read.

    options   DetectionOptions;  jobs  processes, None for as many as are worth it
    scheduler address of a Dask scheduler, whose workers then do it; see fleet.engine.run
    """
    jobs = 1 if scheduler else jobs or usual_jobs(paths)
    errors: list[Result] = []
    blocks = _blocks(paths, errors, _BLOCK_SENT if scheduler else _BLOCK)
    if jobs == 1 and not scheduler:
        results = _serial(blocks, options, keep_frames)
    else:
        results = _parallel(blocks, options, jobs, keep_frames, scheduler)
    for result in results:
        while errors:
            yield errors.pop(0)
        yield result
    yield from errors


def detect_live(frames: Iterable[tuple[str, np.ndarray]], options: DetectionOptions) -> Iterator[Result]:
    """Yields a Result, with its frame, for each (name, frame) as it comes."""
    work = _Work(options, True)
    for name, frame in frames:
        yield work.detect(name, frame)


def _serial(blocks, options, keep_frames):
    work = _Work(options, keep_frames)
    for block in blocks:
        for item in block:  # one by one, so that whoever watches sees each as it is done
            yield from work.block([item])


def _parallel(blocks, options, jobs, keep_frames, scheduler):
    if not scheduler:
        # here, so that loops are compiled once and not by each process, and who waits is told meanwhile
        first = next(blocks, [])
        yield from _Work(options, keep_frames).block(first[:1])
        blocks = itertools.chain([first[1:]], blocks)
    tasks = ((options, keep_frames, block) for block in blocks)
    for answer in engine.run(_run, tasks, jobs, scheduler):
        yield from _told(answer)
