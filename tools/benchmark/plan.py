"""What the bench measures: presets, sweeps, and which methods take part in each."""

from typing import NamedTuple

from . import evaluate

RADIUS_PX = 30.0
FRESH_SEED = 5000  # seeds from here on belong to the bench; tuning stays below 1000

QUALITY_METHODS = ("larics", "paper", "aruco", "aruco_subpix", "apriltag", "hough")
TIMED_METHODS = ("larics", "paper", "aruco", "aruco_subpix", "apriltag", "apriltag2", "hough")
SWEPT_METHODS = ("larics", "paper", "aruco_subpix", "apriltag")


class Job(NamedTuple):
    """What the cost of a frame is measured for on MicroPython."""

    method: str
    radius_range: tuple
    presets: tuple
    track: bool = False


ONE_MARKER = ("sunny", "cloudy", "double", "fast", "harsh")
COSTS = {
    "search": Job("larics", (25, 35), ONE_MARKER),
    "track": Job("larics", (25, 35), ONE_MARKER, track=True),
    "search, two to four markers": Job("larics", (25, 35), ("multi",)),
    "search, clutter without a marker": Job("larics", (25, 35), ("negative",)),
    "search, radius 10 to 66 px": Job("larics", (10, 66), ONE_MARKER),
    "published decoder": Job("paper", (25, 35), ONE_MARKER),
}


class Sweep(NamedTuple):
    """One condition made worse step by step, everything else as in the preset."""

    title: str
    axis: str
    preset: str
    override: str  # name of render_frame's argument
    values: tuple


SWEEPS = {
    "contrast": Sweep("Contrast", "grey levels", "cloudy", "contrast", (3, 4, 5, 6, 8, 12, 20, 40)),
    "blur": Sweep("Motion blur", "length, px", "sunny", "blur_px", (0, 2, 4, 6, 8, 10, 12, 16)),
    "defocus": Sweep("Defocus", "sigma, px", "sunny", "defocus_px", (0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4)),
    "radius": Sweep("Size", "outer ring, px", "sunny", "radius_px", (6, 7, 8, 10, 15, 20, 30, 45, 60)),
    "tilt": Sweep("Tilt", "degrees", "sunny", "tilt_deg", (0, 5, 10, 15, 20, 25, 30, 35, 40)),
    "occlusion": Sweep("Occlusion", "share covered", "sunny", "occlusion", (0, 0.05, 0.1, 0.15, 0.2, 0.3)),
}


def presets():
    """The renderer's presets, those without a marker left out."""
    from larics_host.render import PRESETS

    return [name for name in PRESETS if name not in evaluate.NEGATIVES]
