"""What hangs on the ceiling to be found: LARICS plates, and the tags they are compared with.

Plate coordinates, mm: u along the orientation line, v 90 degrees counterclockwise from it as seen by
whoever looks at the printed face (that is from below, so the map sees v clockwise from u).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from larics.marker import ARC, LARICS3, LINE, PLAIN_ID_MOST, RING, Family
from larics_host.render.camera import Pose
from larics_host.render.finish import Finish

TARGETS = ("larics", "aruco", "apriltag")


def printed_family(marker_id: int, line_mm10: int = LARICS3.line_mm10) -> Family:
    """The family as which an ID is printed: plain up to 7, coded above."""
    return Family(line_mm10=line_mm10, allow_id0=marker_id == 0, coded=marker_id > PLAIN_ID_MOST)


@dataclass(frozen=True)
class Plate:
    """A marker in the map.

    pose        centre, and heading of the orientation line, counterclockwise seen from above. A tag's
                heading is the direction along its bitmap's rows, from the left column to the right
                (from the first to the second corner of cv2.aruco), its centre that of the bitmap.
    target      "larics"; or a tag of equal footprint: "aruco" (4x4, 6 modules with its border) or
                "apriltag" (36h11, 8 modules), whose square with one module of quiet zone just fits
                the same round plate
    white, black   reflectance of the plate and of the ink; 1 and 0 make the contrast exact
    finish      how it is printed, hangs and has aged
    """

    marker_id: int
    pose: Pose = Pose()
    family: Family = LARICS3
    target: str = "larics"
    white: float = 1.0
    black: float = 0.0
    finish: Finish = Finish()

    @property
    def radius_mm(self) -> float:
        """Radius of the white plate."""
        return self.family.plate_mm10 / 10

    @property
    def ring_mm(self) -> float:
        """Radius of the outer ring, to the centre of its line (a tag has none; the footprint is equal)."""
        return self.family.outer_mm10 / 10

    @property
    def pointer_mm(self) -> tuple[float, float]:
        """Two places on the u axis between which the image heading is measured.

        A LARICS marker shows its direction by a line at some distance from the centre: from the centre to the
        middle of that line. A tag shows it by its left and right sides alike.
        """
        if self.target == "larics":
            return 0.0, (self.family.outer_mm10 + self.family.orientation_end_mm10) / 20
        half = tag_side_mm(self.target, self.radius_mm) / 2
        return -half, half

    def pattern(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
        """The ink as the sampling kernel takes it.

        Returns rings (N, 2): radius, half width; lines (M, 5): cos, sin of the angle, start, end, half
        width; arcs (K, 6): cos, sin of the middle, cos, sin of half the angle, start, end, all in mm; the
        tag's cells (n, n) uint8, 1 = ink, and its side in mm (0: no tag).
        """
        if self.target != "larics":
            cells = tag_cells(self.target, self.marker_id)
            side = tag_side_mm(self.target, self.radius_mm)
            return np.zeros((0, 2)), np.zeros((0, 5)), np.zeros((0, 6)), cells, side
        rings, lines, arcs = [], [], np.zeros((0, 6))
        for kind, *sizes in self.family.strokes(self.marker_id):
            if kind == RING:
                radius, width = sizes
                rings.append((radius / 10, width / 20))
            elif kind == LINE:
                angle_cdeg, start, end, width = sizes
                angle = math.radians(angle_cdeg / 100)
                lines.append((math.cos(angle), math.sin(angle), start / 10, end / 10, width / 20))
            elif kind == ARC:
                first, last, start, end = sizes
                middle, half = math.radians((first + last) / 200), math.radians((last - first) / 200)
                arc = (math.cos(middle), math.sin(middle), math.cos(half), math.sin(half))
                arcs = np.vstack([arcs, (*arc, start / 10, end / 10)])
        return np.array(rings), np.array(lines), arcs, np.zeros((1, 1), np.uint8), 0.0


@lru_cache(maxsize=64)
def tag_cells(target: str, marker_id: int) -> np.ndarray:
    """(n, n) uint8, 1 = black, with the black border: the bitmap of tag `marker_id`."""
    import cv2

    name = cv2.aruco.DICT_4X4_50 if target == "aruco" else cv2.aruco.DICT_APRILTAG_36h11
    dictionary = cv2.aruco.getPredefinedDictionary(name)
    modules = dictionary.markerSize + 2
    return (cv2.aruco.generateImageMarker(dictionary, marker_id, modules) == 0).astype(np.uint8)


def tag_side_mm(target: str, plate_radius_mm: float = LARICS3.plate_mm10 / 10) -> float:
    """Side of the tag's black square: with one module of quiet zone its corners touch the plate's rim."""
    modules = 6 if target == "aruco" else 8
    return plate_radius_mm * math.sqrt(2) * modules / (modules + 2)
