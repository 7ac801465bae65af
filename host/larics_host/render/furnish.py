"""Furnishes a scene: ceiling, clutter, light and whatever troubles its markers, as a preset wants them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from larics_host.render import clutter
from larics_host.render.painters import BOX, ROD
from larics_host.render.scene import item, table

if TYPE_CHECKING:
    from larics_host.render.presets import Preset
    from larics_host.render.scene import Scene


def furnish(
    scene: Scene,
    rng: np.random.Generator,
    preset: Preset,
    region: tuple[float, float, float, float],
    view_m2: float,
    contrast: float,
    occlusion: float | None = None,
) -> None:
    """Fill a Scene, whose plates hang already, over a region of the map.

    region     (x0, y0, x1, y1) mm; as many views of `view_m2` square metres as it holds are furnished
    contrast   grey levels of the white plate: lamps are as bright to the sensor whatever its light is
    occlusion  share of each outer ring to hide, instead of what the preset puts in the way
    """
    area_m2 = (region[2] - region[0]) * (region[3] - region[1]) * 1e-6
    views = max(1, int(round(area_m2 / view_m2 / 2.5)))  # the box around one turned view is about two of them
    # larger views hold more, but not without end
    density = area_m2 / view_m2 / views * min(max(view_m2 / 2, 0.7), 4.0)

    def count(span):
        return int(round(sum(rng.integers(span[0], span[1] + 1) for _ in range(views)) * density))

    scene.surface = clutter.draw_surface(rng)
    plates = scene.plates
    keep_out = np.array([(p.pose.x_mm, p.pose.y_mm, p.radius_mm + 5) for p in plates]).reshape(-1, 3)
    scene.objects = clutter.draw_furniture(
        rng, region, count(preset.circles), count(preset.straight), count(preset.decoys), keep_out
    )
    lamps, shades, occluders = [], [], []
    for _ in range(views):
        if rng.random() < preset.lamp_share:
            radiance = rng.uniform(*preset.lamp_grey) / contrast
            lamps += clutter.draw_lamps(rng, region, int(rng.integers(1, 3)), radiance, keep_out)
        if rng.random() < preset.shadow:
            shades += clutter.draw_shadows(rng, region, int(rng.integers(1, 4)))
    for plate in plates:
        x, y, radius = plate.pose.x_mm, plate.pose.y_mm, plate.radius_mm
        if rng.random() < preset.dirt:
            shades += clutter.draw_dirt(rng, x, y, radius, int(rng.integers(2, 14)))
        if rng.random() < preset.edge:
            shades += clutter.draw_shadows(rng, (x - radius, y - radius, x + radius, y + radius), 1)
        if rng.random() < preset.glare:
            lamps.append(clutter.draw_glare(rng, x, y, rng.uniform(0, 330), rng.uniform(0.2, 2.5)))
        direction = rng.uniform(0, 2 * math.pi)
        if occlusion:
            occluders.append(_cover(plate, occlusion, direction))
        elif rng.random() < preset.block:
            occluders.append(_thing_in_the_way(rng, x, y, radius, direction))
    scene.occluders, scene.shades, scene.lamps = table(occluders), table(shades), table(lamps)


def _cover(plate, share, direction):
    """A board whose edge hides this share of the outer ring."""
    half = 2000.0
    away = plate.ring_mm * math.cos(math.pi * min(share, 1.0)) + half
    where = (plate.pose.x_mm + away * math.cos(direction), plate.pose.y_mm + away * math.sin(direction))
    return item(BOX, *where, half, half, angle=direction, value=0.5)


def _thing_in_the_way(rng, x, y, radius, direction):
    """A cable, a pipe or the corner of a board that hides a part of the plate."""
    kind = rng.integers(3)
    value = rng.uniform(0.05, 0.9)
    if kind < 2:
        half = rng.uniform(2, 6) if kind == 0 else rng.uniform(8, 25)
        away = rng.uniform(0, 1.0) * radius
        where = (x + away * math.cos(direction), y + away * math.sin(direction))
        across = direction + math.pi / 2
        return item(ROD, *where, 3000, half, angle=across, value=value, extra=rng.uniform(-0.3, 0.3))
    away = rng.uniform(0.45, 1.0) * radius + 600
    where = (x + away * math.cos(direction), y + away * math.sin(direction))
    return item(BOX, *where, 600, rng.uniform(60, 600), angle=direction, value=value)
