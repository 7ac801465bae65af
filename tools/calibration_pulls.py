"""Are the standard errors of `larics calibrate` honest? `python -m tools.calibration_pulls [N [SEED]]`

Renders N cameras (20) that no test uses, calibrates each, and holds the errors against the stated standard
errors. A normal error is within one of them 68 times in 100, within two 95 times.
"""

import re
import sys
import tempfile
from pathlib import Path

import numpy as np

from larics_host.calibration import mounting
from tools.host_figures import CLOUDY, SUNNY, calibration_poses, random_camera, write_frames

SEED = 6100
_LINE = re.compile(r"^(.{36}) +(-?[0-9.]+) \+- ([0-9.]+)", re.MULTILINE)


def stated(text):
    """{quantity: (value, standard error)} of what `larics calibrate` prints."""
    return {name.strip(): (float(value), float(sigma)) for name, value, sigma in _LINE.findall(text)}


def pulls_of(seed, folder):
    """{quantity: error / standard error} of one rendered camera; empty when it is refused."""
    import contextlib
    import io

    from larics_host import cli

    camera, height = random_camera(seed)
    words = ["calibrate", "--radius-px", "24:37", "--height-mm", str(height)]
    for name, poses in calibration_poses(camera, height).items():
        sensor = (SUNNY, CLOUDY)[seed % 2]
        words += ["--" + name, write_frames(folder / str(seed) / name, camera, height, sensor, poses, seed)]
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        if cli.main(words):
            return {}
    mount, forward, left = mounting.angles(camera.rotation)
    true = {
        "focal length": camera.focal_px,
        "tilt, forward": forward,
        "tilt, to the left": left,
        "lens distortion k1": camera.k1,
        "mounting angle": mount,
        "lens ahead of the rotation centre": camera.offset_x_mm,
        "lens to the left of it": camera.offset_y_mm,
    }
    pulls = {}
    for name, (value, sigma) in stated(text.getvalue()).items():
        error = value - true[name]
        if name == "mounting angle":
            error = (error + 180) % 360 - 180
        pulls[name] = error / sigma
    return pulls


def main(count=20, seed=SEED):
    """Prints the shares within one and two standard errors, for each quantity and for all."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for k in range(count):
            for name, pull in pulls_of(seed + k, Path(folder)).items():
                found.setdefault(name, []).append(pull)
    found["all"] = [pull for pulls in found.values() for pull in pulls]
    for name, pulls in found.items():
        size = np.abs(pulls)
        shares = 100 * np.mean(size <= 1), 100 * np.mean(size <= 2), float(np.sqrt(np.mean(size**2)))
        print("%-36s %3d: %3.0f %% within 1, %3.0f %% within 2, rms %.2f" % (name, len(size), *shares))
    return found


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
