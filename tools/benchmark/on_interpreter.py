"""Runs on MicroPython: ticks of each call of `detect` over frames in files.

    micropython on_interpreter.py larics|paper RADIUS_MIN RADIUS_MAX WIDTH HEIGHT FRAME.raw...

Prints `key value...` lines: `loop` (two measurements of 10,000 empty viper turns, to tell an
instruction counter from a clock), `memory` (bytes of the detector's buffers), one `frame` a file: ticks,
number of detections, first ID; and from a second pass one `kernel` a viper function: ticks, calls, name.
"""

import gc
import sys
import time

import micropython

TURNS = 10000


@micropython.viper
def _turns(count: int):
    i = 0
    while i < count:
        i += 1


def _ticks(function, argument):
    gc.collect()
    start = time.ticks_us()
    result = function(argument)
    return time.ticks_diff(time.ticks_us(), start), result


def _make(method, low, high, width, height):
    if method == "paper":
        from larics.paper import PaperDetector

        return PaperDetector(width, height, radius_min_px=low, radius_max_px=high)
    from larics.detector import Detector

    return Detector(width, height, radius_min_px=low, radius_max_px=high)


def _counted(function, total):
    """The function, that adds its ticks and calls to total = [ticks, calls]."""

    def call(*values):
        start = time.ticks_us()
        result = function(*values)
        total[0] += time.ticks_diff(time.ticks_us(), start)
        total[1] += 1
        return result

    return call


def _count_kernels(totals):
    """Counts in every function of the kernel modules that are loaded; totals: {name: [ticks, calls]}."""
    for path, module in list(sys.modules.items()):
        if not path.startswith("larics.kernels."):
            continue
        for name in dir(module):
            function = getattr(module, name)
            if callable(function) and name not in ("const", "table16", "frame_view"):
                total = totals.setdefault(path.split(".")[-1] + "." + name, [0, 0])
                setattr(module, name, _counted(function, total))


def _read(name, frame):
    with open(name, "rb") as file:
        file.readinto(frame)


def main(method, low, high, width, height, names):
    print("platform", sys.platform)
    print("loop", _ticks(_turns, TURNS)[0], _ticks(_turns, TURNS)[0])
    detector = _make(method, low, high, width, height)
    if method == "larics":
        print("memory", detector.memory())
    frame = bytearray(width * height)
    for i, name in enumerate(names):
        _read(name, frame)
        if i == 0:
            detector.detect(frame)  # what happens once is not the cost of a frame
        ticks, found = _ticks(detector.detect, frame)
        print("frame", ticks, len(found), found[0].marker_id if found else "-")
    totals = {}
    _count_kernels(totals)
    for name in names:
        _read(name, frame)
        detector.detect(frame)
    empty = [0, 0]  # what counting itself costs
    nothing = _counted(lambda *values: None, empty)
    for _ in range(200):
        nothing(0, 1, 2, 3, 4, 5, 6, 7, 8, 9)
    for name, (ticks, calls) in totals.items():
        if calls:
            print("kernel", max(0, ticks - calls * empty[0] // empty[1]), calls, name)


main(sys.argv[1], *[int(word) for word in sys.argv[2:6]], sys.argv[6:])
