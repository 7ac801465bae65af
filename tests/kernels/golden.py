"""Both methods on frames in files: `golden.py FILE.pgm...`, on any interpreter, one line a frame and method.

The ring radius is in the name (_r30_), known within 15 %.
"""

import sys

from larics.detect.detector import Detector
from larics.detect.paper import PaperDetector


def read(path):
    """Width, height and pixels of a binary PGM without comments."""
    with open(path, "rb") as file:
        data = file.read()
    kind, width, height, most = data[:40].split()[:4]
    assert kind == b"P5" and most == b"255"
    width, height = int(width), int(height)
    return width, height, bytearray(data[len(data) - width * height :])


for path in sys.argv[1:]:
    width, height, frame = read(path)
    name = path.split("/")[-1]
    radius = int(name.split("_")[1][1:])
    low, high = radius * 85 // 100, (radius * 115 + 99) // 100
    print(name, "paper", PaperDetector(width, height, low, high).detect(frame))
    print(name, "larics", Detector(width, height, radius_min_px=low, radius_max_px=high).detect(frame))
