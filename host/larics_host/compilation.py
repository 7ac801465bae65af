"""The loops that numba compiles: kept where that is possible, and told of while it takes its time.

python -m larics_host.compilation      compiles all of them, for whoever installs larics where its users
                                       cannot write
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import random
import re
import sys
import threading
from array import array
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from larics import _cpython
from larics_host.errors import report_once

_PATIENCE_S = 2.0


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """numba's njit, its result kept only where there is a folder for that."""
    import numba

    return numba.njit(**dict(options, cache=options.get("cache", False) and _cpython.KEEPS_COMPILED))


PACKAGES = "kernels", "render"
_LOOP = re.compile(r"^@(?:micropython\.viper|njit\((?!.*inline).*\))\s+def (\w+)", re.MULTILINE)
# frames that together need every loop
_FRAMES = ("sunny", 1, (0, 2)), ("harsh", 1, (0, 1, 2, 3)), ("glossy", 1, (1,)), ("webcam", 2, (12,))


def loops_of(source: Path) -> list[str]:
    """The loops in a module, as "module.function"."""
    return ["%s.%s" % (source.stem, name) for name in _LOOP.findall(source.read_text(encoding="utf-8"))]


def _stamp():
    """What compiled loops depend on: their text, and who compiles them for which processor."""
    import llvmlite.binding
    import numba

    digest = hashlib.sha256(
        repr((sys.version, numba.__version__, llvmlite.binding.get_host_cpu_name())).encode()
    )
    for package in PACKAGES:
        for source in sorted(_folder(package).glob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()


def _stamp_file():
    """Where it is told of which stamp all loops are compiled; beside them, so that it goes when they go."""
    kept = os.environ.get("NUMBA_CACHE_DIR")
    return (Path(kept) if kept else _folder("kernels") / "__pycache__") / "all-loops.stamp"


def _folder(package):
    return Path(__file__ if package == "render" else _cpython.__file__).parent / package


@functools.cache
def _starter():
    """The class of what begins to wait when numba begins to compile."""
    from numba.core import event

    class Starter(event.Listener):
        timer: threading.Timer | None = None

        def __init__(self, what):
            self.what = what

        def on_start(self, event):
            if not self.timer:
                once = "is done once and " if _cpython.KEEPS_COMPILED else ""
                text = "compiling %s for this computer, which %smay take a minute" % (self.what, once)
                self.timer = threading.Timer(_PATIENCE_S, report_once, (("compiling", self.what), text))
                self.timer.daemon = True
                self.timer.start()

        def on_end(self, event):
            pass

    return Starter


@contextlib.contextmanager
def told(what: str) -> Iterator[None]:
    """Around what may compile loops: one line when numba does, whatever is kept, and that takes long."""
    if _cpython.EXECUTOR != "numba":
        yield
        return
    from numba.core import event

    with event.install_listener("numba:compile", _starter()(what)) as listener:
        try:
            yield
        finally:
            if listener.timer:
                listener.timer.cancel()


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
    """What looks at grey levels, packs raw frames, ends MAVLink messages and takes odometry, with a camera's
    buffers."""
    from larics.device.frame_check import FrameCheck
    from larics.device.raw_frame import RawSender
    from larics.kernels.crc import x25
    from larics.kernels.grey import count_greys
    from larics.locate.camera_model import Measurement
    from larics.locate.carrier import Carrier, Fix
    from larics.locate.odometry import Odometry
    from larics.locate.rolling import RollingShutter
    from larics.locate.uncertainty import OdometryNoise

    frame = bytearray(4096)  # one half can be packed, the other cannot
    frame[:2048] = random.Random(1).randbytes(2048)
    FrameCheck().update(frame)
    count_greys(frame, array("H", bytes(128)), 0, 0, 64, 0, 0, 64, 64, 1)
    x25(frame, 0, 8, 50)
    sender = RawSender()
    sender.start(0, frame, 64, 64, 0)
    while sender.next():
        pass
    odometry = Odometry(lambda: 50000)
    odometry.look()
    for time_us in (10000, 20000):
        odometry.take(array("i", (time_us, 0, time_us // 1000, 0, 0, 0, 0)))
    odometry.at(50000)
    carrier, rolling = Carrier(OdometryNoise()), RollingShutter(25000, 1 << 17)
    carrier.shares.scale.learn(300, 1, 1 << 8)
    carrier.shares.settle(0, 0)
    for time_us in (10000, 20000):
        odometry.x_mm10 += 700
        carrier.move(odometry, time_us)
        carrier.fix(Fix())
        rolling.follow([Measurement()], 1, time_us, odometry)


def is_compiled() -> bool:
    """Whether `compile_once` has nothing to do."""
    if _cpython.EXECUTOR != "numba" or not _cpython.KEEPS_COMPILED:
        return True
    with contextlib.suppress(OSError):
        return _stamp_file().read_text() == _stamp()
    return False


def compile_once() -> None:
    """Compiles all loops, for a program that begins afterwards, unless that was done before."""
    if is_compiled():
        return
    with told("the detector"):
        compile_all()
    with contextlib.suppress(OSError):
        _stamp_file().write_text(_stamp())


if __name__ == "__main__":
    compile_once()
    print("compiled")
