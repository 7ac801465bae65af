"""Whole detectors on extreme frames: `detectors.py NAME...`, on any interpreter; names: DETECTORS.

One line a frame: detector, size, frame, and what was found. Interpreters agree when their lines do, and the
strict executor raises where any intermediate would overflow an int32.
"""

import sys

from inputs import PATTERNS, Random, pixels

from marker_drawing import draw

SEED = 4711


def paper(width, height, radius_min_px, radius_max_px):
    from larics.paper import PaperDetector

    return PaperDetector(width, height, radius_min_px, radius_max_px)


def detector(width, height, radius_min_px, radius_max_px):
    from larics.detector import Detector

    return Detector(width, height, radius_min_px=radius_min_px, radius_max_px=radius_max_px)


DETECTORS = {"paper": paper, "detector": detector}
SIZES = ((80, 60, 10, 22), (115, 90, 24, 28))
# light, dark, noise: the strongest contrast, the weakest, and lines that noise all but hides
LIGHTS = ((255, 0, 1), (60, 50, 1), (10, 0, 1), (150, 100, 106), (245, 20, 11))


def frames(width, height, low, high):
    """(name, frame) of markers of several sizes, headings and contrasts, and of patterns if small."""
    for index, (light, dark, noise) in enumerate(LIGHTS):
        radius_q4 = 16 * low + (high - low) * 4 * index + 3
        heading_cdeg = (7 * index + radius_q4) * 1234 % 36000
        place = (8 * width + 5, 8 * height - 3)
        frame = draw(
            width,
            height,
            1 + (index + radius_q4) % 7,
            place[0],
            place[1],
            radius_q4,
            heading_cdeg,
            light,
            dark,
            noise,
        )
        yield "marker of %d/16 px, %d on %d" % (radius_q4, dark, light), frame
    if width < 100:
        for pattern in sorted(PATTERNS):
            yield pattern, pixels(pattern, width, height, Random(SEED))


for width, height, low, high in SIZES:
    detectors = [(name, DETECTORS[name](width, height, low, high)) for name in sys.argv[1:]]
    for frame_name, frame in frames(width, height, low, high):
        for name, made in detectors:
            print(name, width, height, frame_name, made.detect(frame))
