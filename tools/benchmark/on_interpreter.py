"""Runs on MicroPython: ticks of each call of `detect` over frames in files.

    micropython on_interpreter.py METHOD RADIUS_MIN RADIUS_MAX MAX_TILT WIDTH HEIGHT FRAME.raw[@X,Y,RADIUS]...

METHOD is larics, larics_sharp (blur-model reader off) or paper. A frame with a predicted place (1/256 px) is
tracked, one without is searched.

Prints `key value...` lines: `loop` (two measurements of 10,000 empty viper turns, to tell an
instruction counter from a clock), `memory` (bytes of the detector's buffers), one `frame` a file: ticks,
number of detections, first ID, whether the blur-model reader was asked (1, 0); and from a second pass one
`kernel` a viper function: ticks, calls, name.
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


def _ticks_of_turns():
    start = time.ticks_us()
    _turns(TURNS)
    return time.ticks_diff(time.ticks_us(), start)


def _process(detector, frame, place):
    """What is found in a frame, searched or, from a predicted place, tracked."""
    if place:
        return detector.track(frame, place[0], place[1], place[2])
    return detector.detect(frame)


def _make(method, low, high, max_tilt_deg, width, height):
    if method == "paper":
        from larics.detect.paper import PaperDetector

        return PaperDetector(width, height, radius_min_px=low, radius_max_px=high)
    from larics.detect.detector import Detector

    return Detector(
        width, height, radius_min_px=low, radius_max_px=high, max_tilt_deg=max_tilt_deg,
        second_opinion=method == "larics",
    )  # fmt: skip


def _asked(detector):
    """1 when the blur-model reader was asked in the last frame, else 0."""
    return int(hasattr(detector, "statistics") and detector.statistics.blur_verdict >= 0)


def _counted(function, total, count):
    """The function of `count` arguments, that adds its ticks and calls to total = [ticks, calls].

    Made for its number of arguments, because a starred call would allocate, which costs more than a kernel.
    """
    names = ", ".join(["a%d" % i for i in range(count)])
    scope = {"function": function, "total": total, "now": time.ticks_us, "difference": time.ticks_diff}
    exec(
        "def call(%s):\n"
        "    start = now()\n"
        "    result = function(%s)\n"
        "    total[0] += difference(now(), start)\n"
        "    total[1] += 1\n"
        "    return result\n" % (names, names),
        scope,
    )
    return scope["call"]


def _kernels():
    """(module, function name) of all kernels that are loaded."""
    found = []
    for path, module in list(sys.modules.items()):
        if path.startswith("larics.kernels."):
            for name in dir(module):
                if callable(getattr(module, name)) and name not in ("const", "table16", "frame_view"):
                    found.append((module, name))
    return found


def _count_kernels(detector, words, frame):
    """{kernel: [ticks, calls]} over all frames, what counting costs taken off."""
    arguments = {}

    def noted(key, function):
        def call(*values):
            arguments[key] = len(values)
            return function(*values)

        return call

    kernels = [(module, name, getattr(module, name)) for module, name in _kernels()]
    for module, name, function in kernels:
        setattr(module, name, noted((module.__name__, name), function))
    for word in words:
        place = _read(word, frame)
        gc.collect()  # of what noting takes
        _process(detector, frame, place)
    totals = {}
    for module, name, function in kernels:
        count = arguments.get((module.__name__, name))
        if count is not None:
            total = totals.setdefault(module.__name__.split(".")[-1] + "." + name, [0, 0])
            function = _counted(function, total, count)
        setattr(module, name, function)
    for word in words:
        place = _read(word, frame)
        gc.collect()
        _process(detector, frame, place)
    empty = [0, 0]
    nothing = _counted(lambda a, b, c, d, e, f: None, empty, 6)
    for _ in range(1000):
        nothing(0, 1, 2, 3, 4, 5)
    for total in totals.values():
        total[0] = max(0, total[0] - total[1] * empty[0] // empty[1])
    return totals


def _read(word, frame):
    """Reads the frame that an argument names; returns what to track, or nothing."""
    name, _, place = word.partition("@")
    with open(name, "rb") as file:
        file.readinto(frame)
    return [int(number) for number in place.split(",")] if place else []


def main(method, low, high, max_tilt_deg, width, height, words):
    print("platform", sys.platform)
    print("loop", _ticks_of_turns(), _ticks_of_turns())
    detector = _make(method, low, high, max_tilt_deg, width, height)
    if method != "paper":
        print("memory", detector.memory())
    frame = bytearray(width * height)
    _process(detector, frame, _read(words[0], frame))  # what happens once is not the cost of a frame
    for word in words:
        place = _read(word, frame)
        gc.collect()
        start = time.ticks_us()
        found = _process(detector, frame, place)
        ticks = time.ticks_diff(time.ticks_us(), start)
        print("frame", ticks, len(found), found[0].marker_id if found else "-", _asked(detector))
    for name, (ticks, calls) in _count_kernels(detector, words, frame).items():
        print("kernel", ticks, calls, name)


main(sys.argv[1], *[int(word) for word in sys.argv[2:7]], sys.argv[7:])
