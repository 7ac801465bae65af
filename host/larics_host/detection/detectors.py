"""The detection methods by name, behind one constructor, and detections in a user's units."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from larics.marker import LARICS3
from larics.marker.detection import NO_ID, flag_names
from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics.marker.detection import Detection
    from larics_host.annotations import AnyDetector


METHODS = ("larics", "paper")
DEFAULT_METHOD = "larics"
DEFAULT_RADIUS_PX = (10, 66)  # what an unknown camera height may give


def make_detector(
    method: str,
    width: int,
    height: int,
    radius_px: tuple[int, int] | None = None,
    line_mm: int | None = None,
    allowed_ids: Iterable[int] | None = None,
    allow_id0: bool = False,
    **more: Any,
) -> AnyDetector:
    """A detector for frames of one size.

    method: one of METHODS; radius_px: (smallest, largest) radius of the outer ring, None when unknown;
    line_mm: whole mm, width of the lines at a ring radius of 150 mm, None for the usual 15 to 20;
    allowed_ids: the IDs that may be reported, None for all (method larics only);
    more: max_tilt_deg, margin_min and second_opinion of `larics.detect.detector.Detector`, for that method.
    Raises UserError when no marker of that size can be in such a frame, or the method does not take it.
    """
    if method not in METHODS:
        raise UserError("unknown method %s: use one of %s" % (method, ", ".join(METHODS)))
    low, high = radius_px or DEFAULT_RADIUS_PX
    if not radius_px:
        high = max(low + 1, min(high, min(width, height) // 2))
    if min(width, height) < 2 * low + 1:
        raise UserError(
            "a frame of %d x %d px is smaller than a ring of radius %d px: use larger frames or --radius-px"
            % (width, height, low)
        )
    # imported here: a method compiles its kernels when it is loaded
    try:
        if method == "paper":
            from larics.detect.paper import PaperDetector

            line_mm10 = 0 if line_mm is None else 10 * line_mm
            family = LARICS3.scaled(LARICS3.outer_mm10, line_mm10, allow_id0)
            return PaperDetector(width, height, low, high, family=family)
        from larics.detect.detector import Detector

        return Detector(
            width, height, low, high, line_mm=line_mm, allowed_ids=allowed_ids, allow_id0=allow_id0, **more
        )
    except ValueError as error:
        raise UserError(str(error)) from error


def as_dict(detection: Detection) -> dict[str, Any]:
    """A Detection with x, y and radius in px, heading in degrees, and names for the flags."""
    return {
        "id": None if detection.marker_id == NO_ID else detection.marker_id,
        "x": round(detection.x_q8 / 256, 4),
        "y": round(detection.y_q8 / 256, 4),
        "heading": round(detection.heading_cdeg / 100, 2),
        "radius": round(detection.radius_q8 / 256, 4),
        "margin": detection.margin,
        "flags": flag_names(detection.flags),
    }
