"""Detections drawn into the frame they were found in."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from larics.marker import LARICS3

if TYPE_CHECKING:
    from larics.marker import Family
    from larics_host.truth import Truth


# blue, green, red
CERTAIN = (80, 200, 0)
UNCERTAIN = (0, 160, 255)
TRUE = (255, 140, 0)
_OUTLINE = (0, 0, 0)
_SHIFT = 6  # sub-pixel bits of OpenCV's drawing functions
_SMALLEST_WIDTH = 720


def zoom_for(width: int) -> int:
    """How many times a frame is enlarged so that one can see a centre to a fraction of a pixel."""
    return max(1, math.ceil(_SMALLEST_WIDTH / width))


class _Canvas:
    """The enlarged frame, drawn on in the frame's coordinates."""

    def __init__(self, frame, zoom):
        height, width = frame.shape
        enlarged = cv2.resize(frame, (width * zoom, height * zoom), interpolation=cv2.INTER_NEAREST)
        self.zoom = zoom
        self.image = cv2.cvtColor(enlarged, cv2.COLOR_GRAY2BGR)

    def _fixed(self, value):
        # the centre of a frame's pixel is the centre of its square of zoom x zoom pixels
        return round(((value + 0.5) * self.zoom - 0.5) * (1 << _SHIFT))

    def circle(self, x, y, radius, colour, width):
        center = (self._fixed(x), self._fixed(y))
        span = round(radius * self.zoom * (1 << _SHIFT))
        cv2.circle(self.image, center, span, colour, width, cv2.LINE_AA, _SHIFT)

    def line(self, x1, y1, x2, y2, colour, width):
        ends = (self._fixed(x1), self._fixed(y1)), (self._fixed(x2), self._fixed(y2))
        cv2.line(self.image, *ends, colour, width, cv2.LINE_AA, _SHIFT)

    def text(self, x, y, text, colour):
        """Text on a dark ground, its left end near (x, y), moved into the picture."""
        size, face, pad = 0.6, cv2.FONT_HERSHEY_SIMPLEX, 4
        (width, height), base = cv2.getTextSize(text, face, size, 1)
        rows, columns = self.image.shape[:2]
        left = int(np.clip(x * self.zoom, pad, max(pad, columns - width - pad)))
        line = int(np.clip(y * self.zoom + height / 2, height + pad, max(height + pad, rows - base - pad)))
        above, before = max(0, line - height - pad), max(0, left - pad)
        self.image[above : line + base, before : left + width + pad] //= 4
        cv2.putText(self.image, text, (left, line), face, size, colour, 1, cv2.LINE_AA)


def _draw_one(canvas, found, family):
    x, y, radius = found["x"], found["y"], found["radius"]
    colour = UNCERTAIN if found["id"] is None else CERTAIN
    angle = math.radians(found["heading"])
    ux, uy = math.cos(angle), -math.sin(angle)
    end = radius * family.orientation_end_mm10 / family.outer_mm10
    arm, barb = 0.15 * radius, 0.16 * radius
    for tint, extra in ((_OUTLINE, 2), (colour, 0)):
        canvas.circle(x, y, radius, tint, 1 + extra)
        canvas.circle(x, y, radius * family.inner_mm10 / family.outer_mm10, tint, 1 + extra)
        canvas.line(x - arm, y, x + arm, y, tint, 1 + extra)
        canvas.line(x, y - arm, x, y + arm, tint, 1 + extra)
        tip_x, tip_y = x + end * ux, y + end * uy
        canvas.line(x + radius * ux, y + radius * uy, tip_x, tip_y, tint, 2 + extra)
        for side in (-1, 1):
            back_x, back_y = -ux + side * 0.6 * uy, -uy - side * 0.6 * ux
            canvas.line(tip_x, tip_y, tip_x + barb * back_x, tip_y + barb * back_y, tint, 2 + extra)
    name = "ID ?" if found["id"] is None else "ID %d" % found["id"]
    # beside the ring, on the side where the orientation line is not
    label_y = y + 1.25 * radius * (-1 if uy > 0.3 else 1)
    canvas.text(x + 0.8 * radius, label_y, "%s  margin %d" % (name, found["margin"]), colour)


def _draw_truth(canvas, truth, family):
    x, y, radius = truth.x_px, truth.y_px, truth.radius_px
    plate = radius * family.plate_mm10 / family.outer_mm10
    angle = math.radians(truth.heading_deg)
    canvas.circle(x, y, plate, TRUE, 2)
    canvas.line(x, y, x + plate * math.cos(angle), y - plate * math.sin(angle), TRUE, 1)
    canvas.text(x - plate, y - plate, "true ID %d" % truth.id, TRUE)


def draw_detections(
    frame: np.ndarray,
    detections: Iterable[dict[str, Any]],
    zoom: int | None = None,
    family: Family = LARICS3,
    truths: Iterable[Truth] = (),
) -> np.ndarray:
    """The frame (2-D uint8), enlarged `zoom` times, with its detections, as a BGR image.

    `detections` are dicts as of `detectors.as_dict`: rings, a cross at the centre, an arrow along the
    orientation line, ID and margin; amber instead of green where the ID is uncertain.
    `truths` are records of larics_host.truth: the rim of the plate and the heading, in blue.
    """
    canvas = _Canvas(np.ascontiguousarray(frame), zoom or zoom_for(frame.shape[1]))
    for truth in truths:
        _draw_truth(canvas, truth, family)
    for found in detections:
        _draw_one(canvas, found, family)
    return canvas.image
