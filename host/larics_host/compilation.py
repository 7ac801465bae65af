"""The loops that numba compiles: kept where that is possible, and told of while it takes its time.

python -m larics_host.compilation      compiles all of them, for whoever installs larics where its users
                                       cannot write
"""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from larics import _cpython
from larics_host.errors import report_once

_PATIENCE_S = 2.0


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """numba's njit, its result kept only where there is a folder for that."""
    import numba

    return numba.njit(**dict(options, cache=options.get("cache", False) and _cpython.KEEPS_COMPILED))


def _is_compiled(folder):
    kept = os.environ.get("NUMBA_CACHE_DIR")
    pattern = "%s_*/*.nbi" % folder.name if kept else "*.nbi"
    return any(Path(kept or folder / "__pycache__").glob(pattern))


def _folder(package):
    return Path(__file__ if package == "render" else _cpython.__file__).parent / package


@contextlib.contextmanager
def told(package: str, what: str) -> Iterator[None]:
    """Around what may compile the loops of a package: one line when that is new and takes long."""
    folder = _folder(package)
    if _cpython.EXECUTOR != "numba" or _is_compiled(folder):
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
    """Compiles what detection and rendering need, by doing both."""
    from larics_host.detection.detectors import METHODS, make_detector
    from larics_host.render import render_frame

    for preset in ("sunny", "harsh"):
        for index in range(4):
            frame, _ = render_frame(preset, 1, index)
            for method in METHODS:
                make_detector(method, 360, 296, (10, 66)).detect(frame)


def compile_once() -> None:
    """Compiles what detection needs, for a program that begins afterwards, unless that was done before."""
    if _cpython.EXECUTOR == "numba" and _cpython.KEEPS_COMPILED and not _is_compiled(_folder("kernels")):
        with told("kernels", "the detector"):
            compile_all()


if __name__ == "__main__":
    compile_all()
    print("compiled")
