"""What the program takes of a board's memory, by module and by buffer, and the limits it keeps.

    python tools/ram.py

Needs no board: bytes of .mpy of the usual and the small-heap build, of which a board holds about as much in
memory when it reads them from its flash, and the detector's buffers at 320x240 with the usual settings.
Without a C compiler for the board the small-heap build is not looked at.
"""

import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "shared"), str(ROOT / "host")]

from larics.detect.detector import Detector  # noqa: E402
from larics.settings import Settings  # noqa: E402
from larics_host.flash import machine_code, mpy_file, short_names, small_heap  # noqa: E402
from larics_host.flash.build import compile_program  # noqa: E402

MARCH = "armv7emsp"
# loaded with the usual settings: not what other settings, cameras or commands ask for
NOT_LOADED = (
    "cameras/", "larics/arith/float32", "larics/boards", "larics/detect/paper", "larics/detect/thinned",
    "larics/kernels/covariance", "larics/kernels/paper", "larics/kernels/raw", "larics/kernels/rolling",
    "larics/kernels/shares",
    "larics/locate/carrier", "larics/locate/coasting",
    "larics/locate/localizer", "larics/locate/marker_map", "larics/locate/matching", "larics/locate/motion",
    "larics/locate/navigator", "larics/locate/noise", "larics/locate/odometry_shares",
    "larics/locate/rolling", "larics/locate/route",
    "larics/locate/uncertainty", "larics/locate/wheel_noise", "larics/marker/far_apart",
    "larics/wire/mavlink", "larics/wire/messages", "larics/wire/nmea",
)  # fmt: skip
CODE_MOST = 241000  # bytes of .mpy that are loaded; raise it only for what is worth the memory
SMALL_MOST = 108400  # of the small-heap build: with more, a heap of 256 KiB does not take all from flash
NAMES_MOST = 285  # of the small-heap build: the list of them doubles when it is full, with 300 or so of all
BUFFERS_MOST = 82400


def code():
    """[(module, bytes of .mpy, those of the small-heap build or None, whether the usual settings load it)],
    largest first, and how many names the small-heap build has of which MicroPython may know nothing. What it
    puts into one module stands beside the first."""
    small, names = {}, set()
    try:
        machine_code.compiler(MARCH)
        program = small_heap.compile_small(ROOT, MARCH, False)
        small = {program.holds[name][0]: len(data) for name, data in program.files}
        for name, data in program.files:
            if any(not part.startswith(NOT_LOADED) for part in program.holds[name]):
                names.update(mpy_file.MpyFile(data).names)
    except machine_code.NoCompiler as error:
        print("no small-heap build: %s" % error)
    found = [(name, len(data), small.get(name)) for name, data in compile_program(ROOT, MARCH)]
    found.sort(key=lambda row: -row[1])
    rows = [(*row, not row[0].startswith(NOT_LOADED)) for row in found]
    return rows, len(names.difference(short_names.STATIC))


def buffers():
    """[(buffer, bytes)] of the detector with the usual settings, and their sum."""
    usual = Settings()
    detector = Detector(usual.width, usual.height, usual.radius_min_px, usual.radius_max_px)
    votes = detector._votes
    rows = [
        ("cells of votes", 4 * len(votes.cells)),
        ("edges", 4 * len(detector._edges)),
        ("direct reader", detector.direct.memory()),
        ("blur-model reader", detector.blur_reader.memory()),
    ]
    total = detector.memory()
    rows.append(("tables of scales and the rest", total - sum(size for _, size in rows)))
    return rows, total


def main():
    rows, names = code()
    loaded = sum(row[1] for row in rows if row[3])
    # a small heap does without what weighs all evidence
    smaller = sum(row[2] or 0 for row in rows if row[3] and "/evidence" not in row[0])
    print("   usual   small")
    for name, size, small, is_loaded in rows:
        print("%8d%8s  %s%s" % (size, small or "", name, "" if is_loaded else "  (when needed)"))
    limits = "loaded with the usual settings, at most %d and %d" % (CODE_MOST, SMALL_MOST)
    print("%8d%8d  %s" % (loaded, smaller, limits))
    print("%16d  names, at most %d" % (names, NAMES_MOST))
    parts, total = buffers()
    for name, size in parts:
        print("%8d  %s" % (size, name))
    print("%8d  buffers, at most %d" % (total, BUFFERS_MOST))
    return int(loaded > CODE_MOST or smaller > SMALL_MOST or names > NAMES_MOST or total > BUFFERS_MOST)


if __name__ == "__main__":
    sys.exit(main())
