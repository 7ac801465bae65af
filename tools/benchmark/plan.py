"""What the bench measures: presets, sweeps, and which methods take part in each."""

from typing import NamedTuple

from . import evaluate, methods

RADIUS_PX = 30.0
LEAST_MARGINS = (16, 32, 48, 64, 96, 128, 160, 192)
FRESH_SEED = 5000  # seeds from here on belong to the bench; tuning stays below 1000

QUALITY_METHODS = (
    *("larics", "larics_coded", "larics_sharp", "paper", "aruco", "aruco_subpix", "apriltag", "hough"),
)
TIMED_METHODS = ("larics", "paper", "aruco", "aruco_subpix", "apriltag", "apriltag2", "hough")
SWEPT_METHODS = ("larics", "larics_coded", "larics_sharp", "paper", "aruco_subpix", "apriltag")


class Sweep(NamedTuple):
    """One condition made worse step by step, everything else as in the preset."""

    title: str
    axis: str
    preset: str
    override: str  # name of render_frame's argument
    values: tuple
    must: float | None = None  # the worst value at which markers are still to be found, see targets.py
    aim: float | None = None
    tells_tilt: bool = False  # the detector is set to allow the tilt of each point

    def point(self, value):
        """(radius in px, overrides, tilt that the detector is told) at one value."""
        if self.override == "radius_px":
            return float(value), {}, 0
        return RADIUS_PX, {self.override: value}, int(value) if self.tells_tilt else 0


SWEEPS = {
    "contrast": Sweep(
        "Contrast", "grey levels", "cloudy", "contrast", (3, 4, 5, 6, 8, 12, 20, 40), must=8, aim=5
    ),
    "blur": Sweep(
        "Motion blur", "length, px", "sunny", "blur_px", (0, 2, 4, 6, 8, 10, 12, 16), must=8, aim=12
    ),
    "defocus": Sweep(
        "Defocus", "sigma, px", "sunny", "defocus_px", (0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4), must=2.5, aim=3.5
    ),
    "radius": Sweep(
        "Size", "outer ring, px", "sunny", "radius_px", (6, 7, 8, 10, 12, 15, 20, 30, 45, 60), must=8, aim=6
    ),
    "tilt": Sweep(
        "Tilt", "degrees", "sunny", "tilt_deg", (0, 5, 10, 15, 20, 25, 30, 35, 40), must=25, aim=35,
        tells_tilt=True,
    ),
    "occlusion": Sweep(
        "Share covered", "of the outer ring", "sunny", "occlusion", (0, 0.05, 0.1, 0.15, 0.2, 0.3)
    ),
}  # fmt: skip


def frames_a_point(frames):
    """How many frames a point of a sweep takes when a preset takes `frames`."""
    return max(1, frames // 4)


def sweep_jobs(key, seed, count, names):
    """The jobs of one sweep, `count` frames a point; their groups are (key, value)."""
    sweep = SWEEPS[key]
    found = []
    for value in sweep.values:
        radius_px, overrides, tilt = sweep.point(value)
        found += evaluate.jobs(
            (key, value), sweep.preset, seed, count, radius_px, overrides, names, max_tilt_deg=tilt
        )
    return found


class Scene(NamedTuple):
    """Frames to count on: presets in turns, drawn with the same overrides."""

    presets: tuple
    radius_px: float = RADIUS_PX
    overrides: tuple = ()  # of (name, value)


class Job(NamedTuple):
    """What the cost of a frame is measured for on MicroPython."""

    method: str
    radius_range: tuple
    scene: Scene
    track: bool = False
    max_tilt_deg: int = 0


ONE_MARKER = ("sunny", "cloudy", "double", "fast", "harsh")
WITHOUT = ", blur-model reader off"  # ends the name of the job that a job is held against
CLUTTER = "search, clutter without a marker"


def _costs():
    single = Scene(ONE_MARKER)
    jobs = {
        "search": Job("larics", (25, 35), single),
        "search" + WITHOUT: Job("larics_sharp", (25, 35), single),
        "track": Job("larics", (25, 35), single, track=True),
        "search, two to four markers": Job("larics", (25, 35), Scene(("multi",))),
        CLUTTER: Job("larics", (25, 35), Scene(("negative",))),
        CLUTTER + WITHOUT: Job("larics_sharp", (25, 35), Scene(("negative",))),
        "search, radius 10 to 66 px": Job("larics", (10, 66), single),
        "published decoder": Job("paper", (25, 35), single),
    }
    for key, sweep in SWEEPS.items():
        if sweep.must is not None:
            radius_px, overrides, tilt = sweep.point(sweep.must)
            scene = Scene((sweep.preset,), radius_px, tuple(overrides.items()))
            radii = methods.radius_range(radius_px)
            name = "search, %s %g" % (key, sweep.must)
            jobs[name] = Job("larics", radii, scene, max_tilt_deg=tilt)
            jobs[name + WITHOUT] = Job("larics_sharp", radii, scene, max_tilt_deg=tilt)
    return jobs


COSTS = _costs()


def presets():
    """The renderer's presets, those without a marker left out."""
    from larics_host.render import PRESETS

    return [name for name in PRESETS if name not in evaluate.NEGATIVES]
