"""Whole detectors on extreme frames, on any interpreter, one line a frame and detector.

    detectors.py --make FILE       draws the frames
    detectors.py FILE NAME...      runs the detectors of that name (DETECTORS) on them

Interpreters agree when their lines do, and the strict executor raises where any intermediate would overflow
an int32.
"""

import sys

SEED = 4711
SIZES = ((80, 60, 12, 18), (115, 90, 24, 28))
# light, dark, noise: the strongest contrast, the weakest, and lines that noise all but hides
LIGHTS = ((255, 0, 1), (60, 50, 1), (10, 0, 1), (150, 100, 106), (245, 20, 11))


def frames(width, height, low, high):
    """(name, frame) of markers of several sizes, headings and contrasts, and of patterns if small."""
    from inputs import PATTERNS, Random, pixels

    from marker_drawing import draw

    for index, (light, dark, noise) in enumerate(LIGHTS):
        radius_q4 = 16 * low + (high - low) * 4 * index + 3
        heading_cdeg = (7 * index + radius_q4) * 1234 % 36000
        marker_id = 1 + (index + radius_q4) % 7
        x_q4, y_q4 = 8 * width + 5, 8 * height - 3
        yield (
            "marker:%d/16px,%d_on_%d" % (radius_q4, dark, light),
            draw(width, height, marker_id, x_q4, y_q4, radius_q4, heading_cdeg, light, dark, noise),
        )
    if width < 100:
        for pattern in sorted(PATTERNS):
            yield pattern, pixels(pattern, width, height, Random(SEED))


def make(path):
    """Writes the frames, each after a line with its name, size and range of radii."""
    with open(path, "wb") as file:
        for width, height, low, high in SIZES:
            for name, frame in frames(width, height, low, high):
                file.write(("%s %d %d %d %d\n" % (name, width, height, low, high)).encode())
                file.write(frame)


def paper(width, height, radius_min_px, radius_max_px):
    from larics.detect.paper import PaperDetector

    return PaperDetector(width, height, radius_min_px, radius_max_px)


def detector(width, height, radius_min_px, radius_max_px):
    from larics.detect.detector import Detector

    return Detector(width, height, radius_min_px=radius_min_px, radius_max_px=radius_max_px)


DETECTORS = {"paper": paper, "detector": detector}


def run(path, names):
    made = {}
    with open(path, "rb") as file:
        while True:
            line = file.readline().decode().split()
            if not line:
                break
            size = tuple([int(word) for word in line[1:]])
            frame = bytearray(file.read(size[0] * size[1]))
            for name in names:
                if (name, size) not in made:
                    made[name, size] = DETECTORS[name](*size)
                print(name, size, line[0], made[name, size].detect(frame))


if sys.argv[1] == "--make":
    make(sys.argv[2])
else:
    run(sys.argv[1], sys.argv[2:])
