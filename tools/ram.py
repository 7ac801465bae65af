"""What the program takes of a board's memory, by module and by buffer, and the limits it keeps.

    python tools/ram.py

Needs no board: bytes of .mpy, of which a board holds about as much in memory when it reads them from its
flash, and the detector's buffers at 320x240 with the usual settings.
"""

import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "shared"), str(ROOT / "host")]

from larics.detect.detector import Detector  # noqa: E402
from larics.settings import Settings  # noqa: E402
from larics_host.flash import build  # noqa: E402

MARCH = "armv7emsp"
# loaded with the usual settings: not what other settings, cameras or commands ask for
NOT_LOADED = (
    "cameras/", "larics/arith/float32", "larics/boards", "larics/detect/paper", "larics/detect/thinned",
    "larics/kernels/paper", "larics/kernels/raw", "larics/locate/carrier", "larics/locate/coasting",
    "larics/locate/localizer", "larics/locate/marker_map", "larics/locate/matching", "larics/locate/motion",
    "larics/locate/navigator", "larics/locate/noise", "larics/locate/odometry_shares", "larics/locate/route",
    "larics/locate/uncertainty", "larics/marker/far_apart", "larics/wire/mavlink", "larics/wire/messages",
    "larics/wire/nmea",
)  # fmt: skip
CODE_MOST = 209000  # bytes of .mpy that are loaded; raise it only for what is worth the memory
BUFFERS_MOST = 97000


def code():
    """[(module, bytes of .mpy, whether the usual settings load it)], largest first."""
    found = [(name, len(data)) for name, data in build.compile_program(ROOT, MARCH)]
    found.sort(key=lambda row: -row[1])
    return [(name, size, not name.startswith(NOT_LOADED)) for name, size in found]


def buffers():
    """[(buffer, bytes)] of the detector with the usual settings, and their sum."""
    usual = Settings()
    detector = Detector(usual.width, usual.height, usual.radius_min_px, usual.radius_max_px)
    votes = detector._votes
    rows = [
        ("cells of votes", 4 * len(votes.cells)),
        ("edges", 4 * (len(detector._edges) + len(detector._fewer))),
        ("direct reader", detector.direct.memory()),
        ("blur-model reader", detector.blur_reader.memory()),
    ]
    total = detector.memory()
    rows.append(("tables of scales and the rest", total - sum(size for _, size in rows)))
    return rows, total


def main():
    rows = code()
    loaded = sum(size for _, size, is_loaded in rows if is_loaded)
    for name, size, is_loaded in rows:
        print("%8d  %s%s" % (size, name, "" if is_loaded else "  (when needed)"))
    print("%8d  loaded with the usual settings, at most %d" % (loaded, CODE_MOST))
    parts, total = buffers()
    for name, size in parts:
        print("%8d  %s" % (size, name))
    print("%8d  buffers, at most %d" % (total, BUFFERS_MOST))
    return int(loaded > CODE_MOST or total > BUFFERS_MOST)


if __name__ == "__main__":
    sys.exit(main())
