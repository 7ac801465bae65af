"""Residuals of the calibrations as pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from larics_host.plots import COLOURS, new_figure, png

if TYPE_CHECKING:
    from larics_host.calibration.lens import LensFit
    from larics_host.calibration.observe import Observations
    from larics_host.calibration.turn import Mount, Turn


def lens(observations: Observations, result: LensFit) -> bytes:
    """Where the markers were, and by how much their radii differ from the fitted camera's, as PNG."""
    figure = new_figure(9, 3.8)
    places, sizes = figure.subplots(1, 2, width_ratios=(1.2, 1))
    reach = max(0.02, float(np.abs(result.residuals_px).max()))
    dots = places.scatter(
        observations.x_px, observations.y_px, c=result.residuals_px, cmap="coolwarm", vmin=-reach, vmax=reach
    )
    figure.colorbar(dots, ax=places, label="radius, measured minus fitted, px")
    places.set_xlim(-0.5, observations.width - 0.5)
    places.set_ylim(observations.height - 0.5, -0.5)
    places.set_aspect("equal")
    places.set_title("markers in the picture", fontsize=10)
    x, y = result.model.center_px
    distance = np.hypot(observations.x_px - x, observations.y_px - y)
    sizes.plot(distance, result.residuals_px, ".", color=COLOURS[0])
    sizes.axhline(0, color="#888888", linewidth=0.7)
    sizes.set_xlabel("from the middle of the lens, px")
    sizes.set_ylabel("residual, px")
    sizes.grid(True, linewidth=0.4)
    return png(figure)


def turn(result: Turn, mount: Mount) -> bytes:
    """The marker around the lens while the vehicle turned, the residuals, and the straight drive, as PNG."""
    figure = new_figure(11 if len(mount.path_mm) else 8, 3.8)
    views = figure.subplots(1, 3 if len(mount.path_mm) else 2)
    offsets = result.offsets_mm
    views[0].plot(-offsets[:, 1], offsets[:, 0], ".", color=COLOURS[0], label="marker")
    radius = float(np.hypot(*result.marker_mm))
    round_ = np.linspace(0, 2 * np.pi, 200)
    x, y = -result.centre_mm
    views[0].plot(-y + radius * np.cos(round_), x + radius * np.sin(round_), color="#888888", linewidth=0.7)
    views[0].plot([-y], [x], "x", color=COLOURS[1], label="rotation centre")
    views[0].plot([0], [0], "+", color=COLOURS[2], label="lens")
    views[0].set_aspect("equal")
    views[0].set_title("seen from the lens, mm; image top is up", fontsize=10)
    views[0].legend(fontsize=8, loc="lower center", ncols=3, bbox_to_anchor=(0.5, -0.25), columnspacing=1)
    for axis, name in enumerate(("forward", "left")):
        views[1].plot(result.headings_deg, result.residuals_mm[:, axis], ".", color=COLOURS[axis], label=name)
    views[1].axhline(0, color="#888888", linewidth=0.7)
    views[1].set_xlabel("direction of the marker, deg")
    views[1].set_ylabel("residual, mm")
    views[1].grid(True, linewidth=0.4)
    views[1].legend(fontsize=8, loc="lower center", ncols=2, bbox_to_anchor=(0.5, 1.0))
    if len(mount.path_mm):
        path = mount.path_mm
        views[2].plot(path[:, 0], path[:, 1], ".-", color=COLOURS[0])
        views[2].plot(*path[0], "o", color=COLOURS[2])
        views[2].set_aspect("equal")
        views[2].set_title("the drive in the marker's axes, mm; dot: begin", fontsize=10)
    return png(figure)
