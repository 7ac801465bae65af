"""The methods under test behind one interface: a frame in, a list of `Found` out.

Each method is drawn its own tag (`target`) on a plate of equal footprint; "coded" is a
LARICS marker with cells. The tags' x axis (from the
first corner to the second) lies along what is the orientation line of our marker.
"""

import math
from typing import NamedTuple

import cv2
import numpy as np
import pupil_apriltags

from larics.marker import detection
from larics.marker.verdicts import VERDICT_NAMES
from larics_host.detection.options import DetectionOptions
from larics_host.validation.scoring import Found

RADIUS_TOLERANCE = 0.15  # a known radius is known within this share
SMALLEST_PX = 6  # the detectors take no smaller ring


def radius_range(radius_px):
    """The range that a user would give for a ring of about this radius, whole px."""
    low, high = radius_px * (1 - RADIUS_TOLERANCE), radius_px * (1 + RADIUS_TOLERANCE)
    return max(SMALLEST_PX, math.floor(low)), math.ceil(high)


def _quad_pose(corners):
    """Projected centre and image angle (ccw, deg) of the tag's x axis there, from its four corners."""
    unit = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float32)
    h = cv2.getPerspectiveTransform(unit, corners.astype(np.float32))
    x, y = h[0, 2] / h[2, 2], h[1, 2] / h[2, 2]
    dx = (h[0, 0] - x * h[2, 0]) / h[2, 2]
    dy = (h[1, 0] - y * h[2, 0]) / h[2, 2]
    return float(x), float(y), math.degrees(math.atan2(-dy, dx)) % 360.0


class Larics:
    """Our detector, or the published one: both report `larics.marker.detection.Detection`."""

    target = "larics"

    def __init__(self, detector):
        self.detector = detector

    def __call__(self, frame):
        return [
            Found(
                None if d.flags & detection.FLAG_ID_UNCERTAIN else d.marker_id,
                d.x_q8 / 256.0,
                d.y_q8 / 256.0,
                d.heading_cdeg / 100.0,
                d.margin,
                tuple(detection.flag_names(d.flags)),
            )
            for d in self.detector.detect(frame)
        ]

    def verdicts(self):
        """{verdict: candidates} of the last frame; empty for the published decoder."""
        counts = getattr(self.detector, "statistics", None)
        if counts is None:
            return {}
        return {name: n for name, n in zip(VERDICT_NAMES, counts.verdicts, strict=True) if n}


class Aruco:
    """cv2.aruco with the 4x4 dictionary of 50 tags."""

    target = "aruco"

    def __init__(self, subpixel):
        parameters = cv2.aruco.DetectorParameters()
        if subpixel:
            parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
        self.detector = cv2.aruco.ArucoDetector(dictionary, parameters)

    def __call__(self, frame):
        quads, ids, _ = self.detector.detectMarkers(frame)
        if ids is None:
            return []
        return [
            Found(int(number), *_quad_pose(quad.reshape(4, 2)))
            for quad, number in zip(quads, np.ravel(ids), strict=True)
        ]


class AprilTag:
    """AprilTag 3, family 36h11, one thread."""

    target = "apriltag"

    def __init__(self, decimate):
        self.detector = pupil_apriltags.Detector(families="tag36h11", nthreads=1, quad_decimate=decimate)

    def __call__(self, frame):
        # its pixel centres lie at half integers; its corners run the other way round, and what it calls
        # the upper left corner is the lower right one of cv2.aruco's bitmaps, which are drawn here
        return [
            Found(int(tag.tag_id), *_quad_pose(np.roll(tag.corners[::-1], 2, axis=0) - 0.5))
            for tag in self.detector.detect(frame)
        ]


class HoughCircles:
    """cv2.HoughCircles on the outer ring: a centre, neither heading nor ID."""

    target = "larics"

    def __init__(self, radius_px):
        self.low, self.high = radius_range(radius_px)

    def __call__(self, frame):
        circles = cv2.HoughCircles(
            cv2.GaussianBlur(frame, (0, 0), 1.0),
            cv2.HOUGH_GRADIENT,
            dp=1,
            minDist=2 * self.high,
            param1=30,
            param2=30,
            minRadius=self.low,
            maxRadius=self.high,
        )
        if circles is None:
            return []
        return [Found(None, float(x), float(y), None) for x, y, _ in circles.reshape(-1, 3)]


class Condition(NamedTuple):
    """What a user knows about the frames before any is seen."""

    width: int
    height: int
    radius_px: float  # of the outer ring, seen level
    max_tilt_deg: int = 0  # of the camera


def _larics(known, second_opinion=True):
    radius_px = radius_range(known.radius_px)
    options = DetectionOptions(
        radius_px=radius_px, second_opinion=second_opinion, max_tilt_deg=known.max_tilt_deg
    )
    return Larics(options.make(known.width, known.height))


def _paper(known):
    options = DetectionOptions("paper", radius_px=radius_range(known.radius_px))
    return Larics(options.make(known.width, known.height))


# name: (label, what is drawn, constructor)
METHODS = {
    "larics": ("LARICS", "larics", _larics),
    "larics_coded": ("LARICS coded", "coded", _larics),
    "larics_sharp": (
        "LARICS, blur-model reader off", "larics", lambda known: _larics(known, second_opinion=False),
    ),
    "paper": ("published decoder", "larics", _paper),
    "aruco": ("ArUco", "aruco", lambda known: Aruco(subpixel=False)),
    "aruco_subpix": ("ArUco sub-pixel", "aruco", lambda known: Aruco(subpixel=True)),
    "apriltag": ("AprilTag 36h11", "apriltag", lambda known: AprilTag(1.0)),
    "apriltag2": ("AprilTag 36h11 decimated", "apriltag", lambda known: AprilTag(2.0)),
    "hough": ("cv2.HoughCircles", "larics", lambda known: HoughCircles(known.radius_px)),
}  # fmt: skip

WITHOUT_ID = ("hough",)


def label(name):
    return METHODS[name][0]


def target(name):
    return METHODS[name][1]


def make(name, width, height, radius_px, max_tilt_deg=0):
    """A callable frame -> list of Found for frames of one size and a ring of about `radius_px` seen level.

    The published decoder and the peers know no tilt."""
    cv2.setNumThreads(1)
    return METHODS[name][2](Condition(width, height, radius_px, max_tilt_deg))
