"""The detection methods by name, behind one constructor, and detections in a user's units."""

from __future__ import annotations

from collections.abc import Iterable
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from larics.marker import RADIUS_MAX_PX, RADIUS_MIN_PX
from larics.marker.detection import NO_ID, NO_SIGMA, flag_names
from larics.marker.verdicts import MARGIN_MIN
from larics.settings import field
from larics.settings.fields import DETECTOR, FIELDS
from larics_host.detection import reduced
from larics_host.errors import UserError

if TYPE_CHECKING:
    from larics.marker.detection import Detection
    from larics_host.annotations import AnyDetector


METHODS = field("method").choices
DEFAULT_METHOD = field("method").default
DEFAULT_RADIUS_PX = (RADIUS_MIN_PX, RADIUS_MAX_PX)
_MOST_PX = {
    "larics": reduced.RADIUS_MOST_PX,
    "paper": 90,
}  # a ring's radius; of the latter with any line width


def make_detector(
    method: str,
    width: int,
    height: int,
    radius_px: tuple[int, int] | None = None,
    line_mm: int | None = None,
    allowed_ids: Iterable[int] | None = None,
    allow_id0: bool = False,
    max_tilt_deg: int = 0,
    margin_min: int = MARGIN_MIN,
    second_opinion: bool = True,
    family: str = "coded",
) -> AnyDetector:
    """A detector for frames of one size, each by itself.

    method: one of METHODS; radius_px: (smallest, largest) radius of the outer ring, None when unknown;
    line_mm: whole mm, width of the lines at a ring radius of 150 mm, None for the usual 15 to 20;
    allowed_ids: the IDs that may be reported, None for all (method larics only);
    family: "coded", which reads plain markers, too, or "plain" (method larics only);
    max_tilt_deg, margin_min, second_opinion: as of `larics.detect.detector.Detector`, for that method.
    Frames over 1024 px and larger rings are reduced for it by whole factors; results are in original pixels.
    Raises UserError when no marker of that size can be in such a frame, or the method does not take it.
    """
    if method not in METHODS:
        raise UserError("unknown method %s: use one of %s" % (method, ", ".join(METHODS)))
    low, high = radius_px or DEFAULT_RADIUS_PX
    if min(width, height) < 2 * low + 1:
        raise UserError(
            "a frame of %d x %d px is smaller than a ring of radius %d px: use larger frames or --radius-px"
            % (width, height, low)
        )
    # not a Settings: frames and radii may be such as no camera has
    settings = SimpleNamespace(**{f.name: f.default for f in FIELDS if f.rebuilds & DETECTOR})
    settings.method, settings.tracking = method, False
    settings.line_mm10 = 10 * (line_mm or 0)
    settings.allowed_ids, settings.allow_id0 = allowed_ids or (), allow_id0
    settings.max_tilt_cdeg, settings.margin_min = 100 * max_tilt_deg, margin_min
    settings.second_opinion, settings.family = second_opinion, family

    def make(width: int, height: int, low: int, high: int) -> AnyDetector:
        from larics.device import factory  # it compiles the kernels

        settings.radius_min_px, settings.radius_max_px = low, high
        return factory.make_detector(settings, (width, height), thorough=True)

    if radius_px:
        levels = reduced.levels_of(width, height, low, high, _MOST_PX[method])
    else:
        levels = reduced.unknown_levels(width, height, low, high)
        if method == "paper":
            levels = levels[:1]
    try:
        if len(levels) == 1 and levels[0].factor == 1:
            return make(width, height, levels[0].low_px, levels[0].high_px)
        return reduced.ReducedDetector(width, height, levels, make)
    except ValueError as error:
        raise UserError(str(error)) from error


def as_dict(detection: Detection) -> dict[str, Any]:
    """A Detection with x, y and radius in px, heading in degrees, and names for the flags.

    sigma and heading_sigma: standard deviations of x and of y, and of the heading; None where not known."""
    return {
        "id": None if detection.marker_id == NO_ID else detection.marker_id,
        "x": round(detection.x_q8 / 256, 4),
        "y": round(detection.y_q8 / 256, 4),
        "heading": round(detection.heading_cdeg / 100, 2),
        "radius": round(detection.radius_q8 / 256, 4),
        "margin": detection.margin,
        "flags": flag_names(detection.flags),
        "sigma": None if detection.sigma_q12 == NO_SIGMA else round(detection.sigma_q12 / 4096, 4),
        "heading_sigma": None if detection.sigma_mdeg == NO_SIGMA else detection.sigma_mdeg / 1000,
    }
