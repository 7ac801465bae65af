"""Prints what the detector reports on given PGM files, a line a file: the same text from every executor.

python (LARICS_KERNELS=numba|plain|strict) or micropython detector_lines.py MIN:MAX FILE...
"""

import sys

from larics.detect.detector import Detector


def read_pgm(name):
    """(width, height, pixels) of a binary PGM without comments."""
    with open(name, "rb") as file:
        data = file.read()
    fields = data[:40].split(None, 4)
    width, height = int(fields[1]), int(fields[2])
    return width, height, bytearray(data[len(data) - width * height :])


def line(detector, pixels):
    text = ""
    for found in (detector.detect(pixels), detector.track(pixels)):
        for one in found:
            text += " %d:%d,%d,%d,%d,%d,%d" % (
                one.marker_id,
                one.x_q8,
                one.y_q8,
                one.heading_cdeg,
                one.radius_q8,
                one.margin,
                one.flags,
            )
        text += " |"
    counts = detector.statistics
    return text + " %d %d %d %s" % (counts.steep, counts.edges, counts.crossings, list(counts.verdicts))


def main(limits, names):
    low, high = limits.split(":")
    for name in names:
        width, height, pixels = read_pgm(name)
        detector = Detector(width, height, int(low), int(high))
        print(name.split("/")[-1] + line(detector, pixels))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
