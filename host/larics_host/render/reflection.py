"""Lamps mirrored in glossy plates: light that is added to paper and ink alike.

A low lamp lies in a level plane below the ceiling: a window, a lamp on the floor or the vehicle's own. The
ray from the lens to a place P of the plate goes on, mirrored, to P + (P - lens) depth / height in that plane;
where the plate slopes towards the camera, it is turned back by twice the slope. So a plate bent like a
cylinder stretches or squeezes the lamp's image across the bend, and a tilted one shifts it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from larics_host.compilation import njit
from larics_host.render import painters
from larics_host.render.finish import CURL, CURL_COS, CURL_SIN, JAG, SHEET
from larics_host.render.painters import BOX, DISC, ROD
from larics_host.render.plate_edge import plate_distance
from larics_host.render.scene import item, texture

if TYPE_CHECKING:
    from larics_host.render.plates import Plate
    from larics_host.render.scene import Scene

Point = tuple[float, float]


@dataclass(frozen=True)
class LowLamp:
    """A lamp below the ceiling.

    item       row of an object table, in the map and in the lamp's own plane: VALUE is its radiance (white
               plate = 1), SOFT the width of its image's edge, EXTRA the share that its haze keeps beside it
    depth_mm   of that plane below the ceiling
    """

    item: tuple
    depth_mm: float


@njit(cache=True, nogil=True)
def paint_reflection(
    glow: np.ndarray,
    plane: np.ndarray,
    lamp: np.ndarray,
    mirror: np.ndarray,
    finish: np.ndarray,
    torn: np.ndarray,
    noise: np.ndarray,
    box: np.ndarray,
    ramp: float,
) -> None:
    """Add the image of a lamp in one plate to `glow`, where the plate is and not where it is torn off.

    mirror  float64 [11]: plate x, y; cos, sin of its heading; radius; slopes along map x, y (how fast it
            comes down); lens x, y; depth of the lamp, and the same / height of the ceiling
    """
    depth, ratio = mirror[9], mirror[10]
    for row in range(box[0], box[1]):
        for column in range(box[2], box[3]):
            x = float(plane[0, row, column])
            y = float(plane[1, row, column])
            dx = x - mirror[0]
            dy = y - mirror[1]
            u = mirror[2] * dx + mirror[3] * dy
            v = mirror[3] * dx - mirror[2] * dy
            edge = plate_distance(u, v, mirror[4], finish[SHEET], torn, finish[JAG], noise)
            cover = min(max(0.5 - edge / ramp, 0.0), 1.0)
            if cover <= 0.0:
                continue
            # slope of the bent plate, along its u and v, then along the map's axes
            bend = finish[CURL] * (finish[CURL_COS] * u + finish[CURL_SIN] * v)
            bend_u = bend * finish[CURL_COS]
            bend_v = bend * finish[CURL_SIN]
            slope_x = mirror[5] + mirror[2] * bend_u + mirror[3] * bend_v
            slope_y = mirror[6] + mirror[3] * bend_u - mirror[2] * bend_v
            hit_x = x + (x - mirror[7]) * ratio - 2.0 * depth * slope_x
            hit_y = y + (y - mirror[8]) * ratio - 2.0 * depth * slope_y
            away = painters.distance(lamp, hit_x, hit_y)
            soft = max(lamp[painters.SOFT], ramp)
            lit = min(max(0.5 - away / soft, 0.0), 1.0)
            lit = lit * lit * (3.0 - 2.0 * lit)
            haze = lamp[painters.EXTRA] * math.exp(-max(away, 0.0) / (2.0 * soft))
            glow[row, column] += cover * lamp[painters.VALUE] * (lit + (1.0 - lit) * haze)


def mirror_row(plate: Plate, origin: Point, lens: Point, depth_mm: float, ceiling_mm: float) -> np.ndarray:
    """The kernel's `mirror` for a plate; all map points relative to `origin`."""
    heading = math.radians(plate.pose.heading_deg)
    cos, sin = math.cos(heading), math.sin(heading)
    along, across = plate.finish.tilt
    slope = (cos * along + sin * across, sin * along - cos * across)
    return np.array(
        [
            *(plate.pose.x_mm - origin[0], plate.pose.y_mm - origin[1], cos, sin, plate.radius_mm),
            *(*slope, lens[0] - origin[0], lens[1] - origin[1], depth_mm, depth_mm / ceiling_mm),
        ]
    )


def add_reflections(
    glow: np.ndarray,
    plane: np.ndarray,
    scene: Scene,
    origin: Point,
    lens: Point,
    boxes: list[np.ndarray | None],
    ramp: float,
) -> None:
    """Add the images of all low lamps in the plates that are glossy.

    boxes   by plate: rows and columns that it may touch, or None
    lens    (x, y) of the lens in the map at mid-exposure; ramp  mm that a pixel covers
    """
    for plate, box in zip(scene.plates, boxes, strict=True):
        if box is None or not plate.finish.gloss:
            continue
        finish, torn = plate.finish.row()
        for lamp in scene.low_lamps:
            row = np.array(lamp.item, dtype=float)
            row[painters.X] -= origin[0]
            row[painters.Y] -= origin[1]
            row[painters.VALUE] *= plate.finish.gloss
            mirror = mirror_row(plate, origin, lens, lamp.depth_mm, scene.ceiling_mm)
            paint_reflection(glow, plane, row, mirror, finish, torn, texture(), box, ramp)


def draw_low_lamp(
    rng: np.random.Generator, plate: Plate, lens: Point, ceiling_mm: float, radiance: float
) -> LowLamp:
    """A LowLamp whose image in a plate lies somewhere on the plate or just beside it."""
    depth_mm = ceiling_mm * rng.uniform(1.0, 1.4)
    away, direction = plate.radius_mm * 1.1 * math.sqrt(rng.random()), rng.uniform(0, 2 * math.pi)
    x, y = plate.pose.x_mm + away * math.cos(direction), plate.pose.y_mm + away * math.sin(direction)
    mirror = mirror_row(plate, (0.0, 0.0), lens, depth_mm, ceiling_mm)
    x += (x - lens[0]) * depth_mm / ceiling_mm - 2 * depth_mm * mirror[5]
    y += (y - lens[1]) * depth_mm / ceiling_mm - 2 * depth_mm * mirror[6]
    scale = 1 + depth_mm / ceiling_mm  # of the lamp to its image in a flat plate
    kind, angle = rng.integers(3), rng.uniform(0, math.pi)
    # hard edges in laminate, soft ones in satin paper
    soft = scale * (rng.uniform(1.0, 8.0) if rng.random() < 0.5 else rng.uniform(20.0, 160.0))
    look = {"angle": angle, "value": radiance, "soft_mm": soft, "extra": rng.uniform(0.0, 0.25)}
    if kind == 0:
        row = item(DISC, x, y, scale * rng.uniform(10, 90), **look)
    elif kind == 1:
        row = item(BOX, x, y, scale * rng.uniform(30, 200), scale * rng.uniform(20, 120), **look)
    else:
        row = item(ROD, x, y, scale * rng.uniform(80, 500), scale * rng.uniform(5, 30), **look)
    return LowLamp(row, depth_mm)
