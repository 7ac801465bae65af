"""Where a plate ends: its rim, round or square, and where it is torn off."""

from __future__ import annotations

import math

import numpy as np

from larics_host.compilation import njit
from larics_host.render.painters import texture_at

JAG_CELL_MM = 12.0


@njit(cache=True, nogil=True, inline="always")
def plate_distance(
    u: float, v: float, radius: float, sheet: float, torn: np.ndarray, jag: float, noise: np.ndarray
) -> float:
    """Signed distance (mm, negative inside) of plate point u, v from the plate's edge.

    sheet  not 0: a square of half side `radius`; torn  (N, 3): cos, sin, distance of each tear's line,
    rough by `jag` mm of the texture `noise`
    """
    if sheet > 0.0:
        edge = max(abs(u), abs(v)) - radius
    else:
        edge = math.sqrt(u * u + v * v) - radius
    for index in range(torn.shape[0]):
        rough = jag * texture_at(noise, u / JAG_CELL_MM, v / JAG_CELL_MM)
        edge = max(edge, torn[index, 0] * u + torn[index, 1] * v - torn[index, 2] + rough)
    return edge
