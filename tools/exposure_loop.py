"""The exposure control in closed loop with the renderer: steps of light, a lamp in the picture, as a plot.

    python tools/exposure_loop.py          writes build/exposure.png and prints how many frames each step cost

The camera drives slowly under markers; a frame shows the exposure that was set two frames before, as with
sensors that are set while the next frame is already on its way.
"""

import pathlib
import sys
from dataclasses import replace

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "shared"), str(ROOT / "host"), str(ROOT / "firmware")]

from exposure import Exposure, gain_q8  # noqa: E402
from larics.device.factory import make_detector  # noqa: E402
from larics.settings import Settings  # noqa: E402
from larics_host.render.camera import Camera, Motion, Pose  # noqa: E402
from larics_host.render.plates import Plate  # noqa: E402
from larics_host.render.scene import Scene, Surface  # noqa: E402
from larics_host.render.sensor import Sensor  # noqa: E402
from larics_host.render.view import render_radiance  # noqa: E402

WIDTH, HEIGHT = 320, 240
FPS = 30
SPEED_MM_S = 100.0
DELAY = 2  # frames until a new exposure is seen
BLACK = 20.0
FULL_WELL_US = 4000  # exposure that makes a white plate 200 grey levels at light 1 without gain


class LitCamera:
    """Has the driver's exposure and gain; `take` gives the frame of a light level."""

    def __init__(self, settings, seed=1600):
        self.width, self.height = WIDTH, HEIGHT
        self._exposure_us, self._gain_cdb = settings.exposure_us, settings.gain_db10 * 10
        self._under_way = [(self._exposure_us, self._gain_cdb)] * DELAY
        self._rng = np.random.default_rng(seed)
        self._optics = Camera(width=WIDTH, height=HEIGHT, focal_px=500.0)
        plates = (Plate(1, Pose(-150.0, 100.0, 40.0), black=0.05),)
        self._scene = Scene(2500.0, Surface(0.6, tile_mm=(600.0, 600.0)), plates)
        self._index = 0

    def exposure(self, us=None):
        if us is not None:
            self._exposure_us = us
        return self._exposure_us

    def gain(self, cdb=None):
        if cdb is not None:
            self._gain_cdb = cdb // 50 * 50
        return self._gain_cdb

    def take(self, light, lamp=0.0):
        """(frame, exposure us, gain cdb) of the next frame; `lamp`: share of the frame a lamp covers."""
        self._under_way.append((self._exposure_us, self._gain_cdb))
        exposure_us, gain_cdb = self._under_way.pop(0)
        x_mm = 100.0 * np.sin(self._index / 25.0)
        self._index += 1
        gain = gain_q8(gain_cdb) / 256
        amount = light * gain * exposure_us / FULL_WELL_US
        radiance = render_radiance(
            self._scene,
            Pose(float(x_mm), 0.0, 0.0),
            Motion(SPEED_MM_S, 0.0, 0.0),
            replace(self._optics, exposure_us=float(exposure_us)),
            0.6,
        )
        if lamp:
            rows = int(HEIGHT * lamp)
            radiance[:rows] = 40.0
            radiance[rows:] += 0.25 * np.exp(-np.arange(HEIGHT - rows) / 15.0)[:, None].astype(np.float32)
        sensor = Sensor(
            contrast=200.0 * amount, black=BLACK, read_noise=1.0 * max(1.0, gain**0.5), shot_noise=0.01 * gain
        )
        return sensor.frame(radiance, self._rng), exposure_us, gain_cdb


def run(lights, lamps=None, settings=None):
    """Rows of (light, lamp, found ID right, median grey, exposure us, gain cdb), one for each frame."""
    settings = settings or Settings(
        {"radius_min_px": 24, "radius_max_px": 36, "max_speed_mm_s": 300, "tracking": False}
    )
    camera = LitCamera(settings)
    control = Exposure(camera, settings)
    detector = make_detector(settings, (WIDTH, HEIGHT))
    rows = []
    for index, light in enumerate(lights):
        lamp = lamps[index] if lamps else 0.0
        frame, exposure_us, gain_cdb = camera.take(light, lamp)
        found = detector.detect(frame)
        control.update(frame.reshape(-1), WIDTH, HEIGHT, found)
        right = any(detection.marker_id == 1 for detection in found)
        rows.append((light, lamp, right, float(np.median(frame)), exposure_us, gain_cdb))
    return rows, control


def recovery(rows):
    """For each step of light or lamp: (frame, before, after, frames until the marker is found for good,
    frames until the median grey is within 60..200)."""
    steps = []
    ends = [k for k in range(1, len(rows)) if rows[k - 1][:2] != rows[k][:2]] + [len(rows)]
    for index, end in zip(ends, ends[1:], strict=False):
        part = rows[index:end]
        lost = [k + 1 for k, row in enumerate(part) if not row[2]]
        off = [k + 1 for k, row in enumerate(part) if not 60 <= row[3] <= 200]
        steps.append((index, rows[index - 1][:2], rows[index][:2], max(lost, default=0), max(off, default=0)))
    return steps


def profile():
    """Light and lamp of the plotted run: steps of 10x and 30x both ways, and a lamp that comes and goes."""
    lights, lamps = [], []
    for light, lamp, count in (
        (1.0, 0.0, 40),
        (0.1, 0.0, 40),
        (1.0, 0.0, 40),
        (10.0, 0.0, 40),
        (1.0, 0.0, 30),
        (30.0, 0.0, 30),
        (1.0, 0.0, 30),
        (0.03, 0.0, 30),
        (1.0, 0.0, 30),
        (1.0, 0.25, 40),
        (1.0, 0.0, 30),
    ):
        lights += [light] * count
        lamps += [lamp] * count
    return lights, lamps


def plot(rows, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    frames = np.arange(len(rows))
    light, lamp, right, grey, exposure_us, gain = (np.array(column) for column in zip(*rows, strict=True))
    figure, axes = plt.subplots(4, 1, figsize=(11, 8), sharex=True, height_ratios=(1, 1.2, 1.2, 1))
    axes[0].step(frames, light, where="post", color="#f08c00")
    axes[0].set_yscale("log")
    axes[0].set_ylabel("light")
    axes[0].fill_between(frames, 0.02, 50, where=lamp > 0, color="#f08c00", alpha=0.2, label="lamp in view")
    axes[0].legend(loc="upper right")
    axes[1].plot(frames, grey, ".-", markersize=3, color="#22303c")
    axes[1].plot(frames[~right], grey[~right], "x", color="#d6336c", label="marker not found")
    axes[1].set_ylabel("median grey")
    axes[1].legend(loc="upper right")
    axes[2].step(frames, exposure_us / 1000, where="post", color="#2f6fde")
    axes[2].set_yscale("log")
    axes[2].set_ylabel("exposure, ms")
    axes[3].step(frames, gain / 100, where="post", color="#00a35c")
    axes[3].set_ylabel("gain, dB")
    axes[3].set_xlabel("frame, at %d a second" % FPS)
    for panel in axes:
        panel.grid(alpha=0.3)
    found = right.sum(), len(rows)
    figure.suptitle("Exposure control in closed loop: marker found in %d of %d frames" % found)
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def main():
    rows, control = run(*profile())
    print("blur limit of the exposure: %.1f ms" % (control.blur_limit_us / 1000))
    for index, before, now, lost, off in recovery(rows):
        print(
            "frame %3d: light %5.2f lamp %.2f -> light %5.2f lamp %.2f: marker lost for %d frames, "
            "well exposed after %d" % (index, *before, *now, lost, off)
        )
    plot(rows, ROOT / "build" / "exposure.png")
    print("plot: build/exposure.png")


if __name__ == "__main__":
    main()
