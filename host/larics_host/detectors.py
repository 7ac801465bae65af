"""The detection methods by name, behind one constructor, and detections in a user's units."""

from larics.detection import NO_ID, flag_names
from larics.marker import LARICS3
from larics_host.errors import UserError

METHODS = ("paper",)
DEFAULT_METHOD = "paper"
DEFAULT_RADIUS_PX = (10, 66)  # what an unknown camera height may give


def make_detector(method, width, height, radius_px=None, family=LARICS3):
    """A detector for frames of one size.

    method: one of METHODS; radius_px: (smallest, largest) radius of the outer ring, None when unknown.
    Raises UserError when no marker of that size can be in such a frame, or the method does not take it.
    """
    low, high = radius_px or DEFAULT_RADIUS_PX
    if not radius_px:
        high = max(low, min(high, min(width, height) // 2))
    if min(width, height) < 2 * low + 1:
        raise UserError(
            "a frame of %d x %d px is smaller than a ring of radius %d px: use larger frames or --radius-px"
            % (width, height, low)
        )
    # imported here: a method compiles its kernels when it is loaded
    try:
        if method == "paper":
            from larics.paper import PaperDetector

            return PaperDetector(width, height, low, high, family=family)
        if method == "larics":
            from larics.detector import Detector

            return Detector(width, height, radius_min_px=low, radius_max_px=high, family=family)
    except ValueError as error:
        raise UserError(str(error)) from error
    raise UserError("unknown method %s: use one of %s" % (method, ", ".join(METHODS)))


def as_dict(detection):
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
