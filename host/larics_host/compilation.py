"""The loops that numba compiles: kept where that is possible, and told of while it takes its time.

python -m larics_host.compilation      compiles all of them, for whoever installs larics where its users
                                       cannot write
"""

from __future__ import annotations

import contextlib
import os
import random
import re
import sys
import threading
from array import array
from collections.abc import Callable, Container, Iterable, Iterator
from pathlib import Path
from typing import Any

from larics import _cpython
from larics_host.errors import report_once

_PATIENCE_S = 2.0


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """numba's njit, its result kept only where there is a folder for that."""
    import numba

    return numba.njit(**dict(options, cache=options.get("cache", False) and _cpython.KEEPS_COMPILED))


_LOOP = re.compile(r"^@(?:micropython\.viper|njit\((?!.*inline).*\))\s+def (\w+)", re.MULTILINE)
_NEVER = "crc.crc32", "crc.cobs"  # CPython has its own CRC-32, and needs no COBS in place
# frames that together need every loop
_FRAMES = ("sunny", 1, (0, 2)), ("harsh", 1, (0, 1, 2, 3)), ("glossy", 1, (1,)), ("webcam", 2, (12,))
_NOT_TO_DETECT = "crc", "grey", "raw", "paper"  # modules that a usual detection does without


def _is_compiled(folder: Path, but: Container[str]) -> bool:
    """Whether every loop of a package was compiled since its text was changed, by this version of Python;
    `but` for modules, and loops as "module.function", that need not be."""
    kept = os.environ.get("NUMBA_CACHE_DIR")
    places = list(Path(kept).glob("%s_*" % folder.name)) if kept else [folder / "__pycache__"]
    ending = ".py%d%d.nbi" % sys.version_info[:2]
    newest: dict[str, float] = {}
    for index in (path for place in places for path in place.glob("*" + ending)):
        loop = index.name.partition("-")[0]
        newest[loop] = max(newest.get(loop, 0.0), index.stat().st_mtime)
    for source in folder.glob("*.py"):
        changed_s = source.stat().st_mtime
        for function in _LOOP.findall(source.read_text(encoding="utf-8")):
            loop = "%s.%s" % (source.stem, function)
            if source.stem not in but and loop not in but and newest.get(loop, 0.0) < changed_s:
                return False
    return True


def _folder(package):
    return Path(__file__ if package == "render" else _cpython.__file__).parent / package


@contextlib.contextmanager
def told(package: str, what: str) -> Iterator[None]:
    """Around what may compile the loops of a package: one line when that is new and takes long."""
    folder = _folder(package)
    if _cpython.EXECUTOR != "numba" or _is_compiled(folder, _NOT_TO_DETECT):
        yield
        return
    text = "compiling %s for this computer, which is done once and may take a minute" % what
    timer = threading.Timer(_PATIENCE_S, report_once, (("compiling", package), text))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def compile_all() -> None:
    """Compiles what detection, rendering and a camera on this computer need, by doing all that."""
    from larics_host.detection.detectors import METHODS, make_detector
    from larics_host.render import render_frame

    methods: Iterable[str] = METHODS
    for preset, seed, indices in _FRAMES:
        for index in indices:
            frame, _ = render_frame(preset, seed, index)
            for method in methods:
                make_detector(method, 360, 296, (10, 66)).detect(frame)
            methods = ("larics",)
    _compile_for_cameras()


def _compile_for_cameras():
    """What looks at grey levels, packs raw frames and ends MAVLink messages, with a camera's buffers."""
    from larics.device.frame_check import FrameCheck
    from larics.device.raw_frame import RawSender
    from larics.kernels.crc import x25
    from larics.kernels.grey import count_greys

    frame = bytearray(4096)  # one half can be packed, the other cannot
    frame[:2048] = random.Random(1).randbytes(2048)
    FrameCheck().update(frame)
    count_greys(frame, array("H", bytes(128)), 0, 0, 64, 0, 0, 64, 64, 1)
    x25(frame, 0, 8, 50)
    sender = RawSender()
    sender.start(0, frame, 64, 64, 0)
    while sender.next():
        pass


def compile_once() -> None:
    """Compiles what detection needs, for a program that begins afterwards, unless that was done before."""
    if (
        _cpython.EXECUTOR == "numba"
        and _cpython.KEEPS_COMPILED
        and not _is_compiled(_folder("kernels"), _NEVER)
    ):
        with told("kernels", "the detector"):
            compile_all()


if __name__ == "__main__":
    compile_all()
    print("compiled")
