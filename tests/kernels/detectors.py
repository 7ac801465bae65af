"""Whole detectors on extreme frames: `detectors.py NAME...`, on any interpreter; names: DETECTORS.

One line a frame: detector, size, frame, and what was found. Interpreters agree when their lines do, and the
strict executor raises where any intermediate would overflow an int32.
"""

import sys

from inputs import PATTERNS, Random, pixels

SEED = 4711


def paper(width, height, radius_min_px, radius_max_px):
    from larics.paper import PaperDetector

    return PaperDetector(width, height, radius_min_px, radius_max_px)


def detector(width, height, radius_min_px, radius_max_px):
    from larics.detector import Detector

    return Detector(width, height, radius_min_px=radius_min_px, radius_max_px=radius_max_px)


DETECTORS = {"paper": paper, "detector": detector}
SIZES = ((80, 60, 10, 24), (93, 71, 15, 20))

for name in sys.argv[1:]:
    for width, height, low, high in SIZES:
        made = DETECTORS[name](width, height, low, high)
        for pattern in sorted(PATTERNS):
            frame = pixels(pattern, width, height, Random(SEED))
            print(name, width, height, pattern, made.detect(frame))
