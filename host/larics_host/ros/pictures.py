"""Raw frames as sensor_msgs/CompressedImage (PNG, every grey as it was), and what is in them as
annotations."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from larics.marker import LARICS3
from larics_host.connection.raw_frame import RawAssembly
from larics_host.errors import UserError, report_once
from larics_host.images.drawing import CERTAIN, UNCERTAIN
from larics_host.ros.topics import header, time_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

_LINE_STRIP = 3
_CLEAR = {"a": 0.0}
_HALF_PX = 0.5  # annotations count from the corner of the first pixel, we from its centre
_THICKNESS_PX = 1.5
_FONT_PX = 12.0


class Assembler:
    """Puts RAW_HEADER and RAW_CHUNKs together."""

    def __init__(self) -> None:
        self._raw: RawAssembly | None = None

    def header(self, fields: Any) -> None:
        """Takes a RAW_HEADER: a new frame begins, unless it is the same once more."""
        if self._raw is None or self._raw.token != fields.token:
            self._raw = RawAssembly(fields)

    def chunk(self, fields: Any) -> tuple[int, np.ndarray] | None:
        """Takes a RAW_CHUNK; (number, frame (height, width) uint8) when it was the last one that was missing
        and the checksum is right."""
        raw = self._raw
        if raw is None or not raw.add(fields) or raw.missing() is not None:
            return None
        self._raw = None
        frame = raw.frame()
        return None if frame is None else (frame.frame, frame.array())


def compressed_image(frame: np.ndarray, frame_id: str, stamp_ns: int) -> dict[str, Any]:
    """A CompressedImage of a (height, width) uint8 frame."""
    data = cv2.imencode(".png", frame)[1].tobytes()
    return {"header": header(stamp_ns, frame_id), "format": "png", "data": data}


def detections(frame: np.ndarray, settings: Mapping[str, Any]) -> Sequence[dict[str, Any]] | None:
    """What a camera with these settings sees in a single frame (see CameraView.detect); None when they do not
    suit it, which is told once."""
    from larics_host.detection.camera_view import CameraView

    height, width = frame.shape
    try:
        return CameraView(dict(settings), width, height).detect(frame)
    except UserError as error:
        report_once(("picture", width, height), "pictures have no annotations: %s" % error)
        return None


def drawn(found: Sequence[dict[str, Any]], stamp_ns: int) -> dict[str, Any]:
    """An ImageAnnotations: both rings, the orientation line, ID and margin of each detection."""
    stamp = time_of(stamp_ns)
    circles, lines, texts = [], [], []
    for one in found:
        blue, green, red = UNCERTAIN if one["id"] is None else CERTAIN
        colour = {"r": red / 255, "g": green / 255, "b": blue / 255, "a": 1.0}
        x, y, radius = one["x"] + _HALF_PX, one["y"] + _HALF_PX, one["radius"]
        for scale in (1.0, LARICS3.inner_mm10 / LARICS3.outer_mm10):
            circles.append(
                {
                    "timestamp": stamp,
                    "position": {"x": x, "y": y},
                    "diameter": 2 * radius * scale,
                    "thickness": _THICKNESS_PX,
                    "fill_color": _CLEAR,
                    "outline_color": colour,
                }
            )
        angle = math.radians(one["heading"])
        end = LARICS3.orientation_end_mm10 / LARICS3.outer_mm10
        points = [
            {"x": x + scale * radius * math.cos(angle), "y": y - scale * radius * math.sin(angle)}
            for scale in (1.0, end)
        ]
        line = {"type": _LINE_STRIP, "points": points, "outline_color": colour, "fill_color": _CLEAR}
        lines.append({"timestamp": stamp, "thickness": _THICKNESS_PX, **line})
        name = "ID ?" if one["id"] is None else "ID %d" % one["id"]
        texts.append(
            {
                "timestamp": stamp,
                "position": {"x": x + 0.8 * radius, "y": y + radius},
                "text": "%s  margin %d" % (name, one["margin"]),
                "font_size": _FONT_PX,
                "text_color": colour,
                "background_color": {"a": 0.6},
            }
        )
    return {"timestamp": stamp, "circles": circles, "points": lines, "texts": texts}
