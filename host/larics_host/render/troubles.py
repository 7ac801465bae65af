"""Draws what else may trouble a marker: print, wear, mirrored lamps, cables, lit edges, lens and camera.

All of it comes from random streams of its own, so that a preset without troubles is drawn as if they did not
exist.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from larics_host.render import clutter
from larics_host.render.defects import Defects
from larics_host.render.finish import Finish
from larics_host.render.flicker import Flicker
from larics_host.render.lens_dirt import draw_smears
from larics_host.render.painters import BOX, ROD
from larics_host.render.processing import Processing
from larics_host.render.reflection import draw_low_lamp
from larics_host.render.scene import item, table

if TYPE_CHECKING:
    from larics_host.render.plates import Plate
    from larics_host.render.scene import Scene
    from larics_host.render.sensor import Sensor


@dataclass(frozen=True)
class Troubles:
    """Shares are probabilities, spans (low, high); see the drawing functions for what each one is.

    Of each plate:   sheet, curl, gloss (with `mirrored` low lamps as bright as `mirrored_grey`), faint,
                     screen, wear, torn, stains, cable, lit_edge
    Of each frame:   smears (how many on the lens), over (exposed), flicker, interlaced, upscaled, defects,
                     tone, sharpen, temporal, median, bilateral
    """

    sheet: float = 0.0
    curl: float = 0.0
    gloss: float = 0.0
    mirrored: tuple = (1, 3)
    mirrored_grey: tuple = (15.0, 400.0)
    faint: float = 0.0
    screen: float = 0.0
    wear: float = 0.0
    torn: float = 0.0
    stains: float = 0.0
    cable: float = 0.0
    lit_edge: float = 0.0
    smears: tuple = (0, 0)
    over: float = 0.0
    flicker: float = 0.0
    interlaced: float = 0.0
    upscaled: float = 0.0
    defects: float = 0.0
    tone: float = 0.0
    sharpen: float = 0.0
    temporal: float = 0.0
    median: float = 0.0
    bilateral: float = 0.0


def trouble_plate(rng: np.random.Generator, plate: Plate, troubles: Troubles, keep_ink: bool) -> Plate:
    """The plate as it was printed, hung and used. `keep_ink`: its contrast is given, so no faint print."""

    def happens(share):
        return rng.random() < share

    sheet, curled, glossy = happens(troubles.sheet), happens(troubles.curl), happens(troubles.gloss)
    finish = Finish(
        sheet=sheet,
        curl_per_m=rng.uniform(-0.3, 0.3) if curled else 0.0,
        curl_deg=rng.uniform(0, 180),
        gloss=1.0 if glossy else 0.0,
        tilt=(rng.normal(0, 0.015), rng.normal(0, 0.015)),
    )
    if happens(troubles.screen):
        finish = replace(finish, screen_mm=rng.uniform(2.0, 9.0), tone=rng.uniform(0.35, 0.85))
    if happens(troubles.wear):
        where = (rng.uniform(0, 256), rng.uniform(0, 256))
        finish = replace(finish, wear=rng.uniform(0.2, 0.7), wear_mm=rng.uniform(8, 60), wear_at=where)
    if happens(troubles.torn):
        # seldom so far in that a ring is hurt badly; the orientation line may be lost to it
        far = [
            (rng.uniform(0, 360), plate.ring_mm * rng.uniform(0.85, 1.7)) for _ in range(rng.integers(1, 3))
        ]
        finish = replace(finish, torn=tuple(far), jag_mm=rng.uniform(1.0, 10.0))
    white, black = plate.white, plate.black
    if happens(troubles.faint) and not keep_ink:
        white = rng.uniform(0.6, 1.0)
        black = white * (1 - rng.uniform(0.15, 0.7))
    return replace(plate, finish=finish, white=white, black=black)


def trouble_scene(
    scene: Scene, rng: np.random.Generator, troubles: Troubles, lens: tuple[float, float], contrast: float
) -> None:
    """Add mirrored lamps, stains, cables and edges of light to a furnished Scene.

    lens  (x, y) of the lens in the map; contrast  grey levels of the white plate
    """
    low, shades, occluders = list(scene.low_lamps), list(scene.shades), list(scene.occluders)
    for plate in scene.plates:
        x, y, radius = plate.pose.x_mm, plate.pose.y_mm, plate.radius_mm
        if plate.finish.gloss:
            for _ in range(rng.integers(troubles.mirrored[0], troubles.mirrored[1] + 1)):
                radiance = math.exp(rng.uniform(*np.log(troubles.mirrored_grey))) / contrast
                low.append(draw_low_lamp(rng, plate, lens, scene.ceiling_mm, radiance))
        if rng.random() < troubles.stains:
            shades += clutter.draw_dirt(rng, x, y, radius, int(rng.integers(2, 16)))
        if rng.random() < troubles.lit_edge:
            shades.append(_lit_edge(rng, x, y, radius))
        if rng.random() < troubles.cable:
            occluders += _cable(rng, x, y, radius)
    scene.low_lamps, scene.shades, scene.occluders = tuple(low), table(shades), table(occluders)


def _lit_edge(rng, x, y, radius):
    """Half of the surroundings in sunlight or in a shadow, with a sharp border over the plate."""
    direction, half = rng.uniform(0, 2 * math.pi), 6000.0
    away = radius * rng.uniform(-0.9, 0.9) + half
    value = rng.uniform(1.4, 4.0) if rng.random() < 0.4 else rng.uniform(0.1, 0.6)
    where = (x + away * math.cos(direction), y + away * math.sin(direction))
    return item(BOX, *where, half, half, angle=direction, value=value, soft_mm=rng.uniform(2, 40))


def _cable(rng, x, y, radius):
    """A cable, cord or strip across the plate, dark or brighter than the plate."""
    direction = rng.uniform(0, 2 * math.pi)
    away = rng.uniform(0, 0.8) * radius
    where = (x + away * math.cos(direction), y + away * math.sin(direction))
    value = rng.uniform(0.9, 1.8) if rng.random() < 0.5 else rng.uniform(0.0, 0.4)
    half, shade = rng.uniform(2, 9), rng.uniform(-0.4, 0.4)
    return [item(ROD, *where, 4000, half, angle=direction + math.pi / 2, value=value, extra=shade)]


def trouble_sensor(rng: np.random.Generator, sensor: Sensor, troubles: Troubles) -> Sensor:
    """The Sensor with a dirty lens, lamps that flicker, and an image processor behind it."""

    def happens(share):
        return rng.random() < share

    lens = draw_smears(rng, int(rng.integers(troubles.smears[0], troubles.smears[1] + 1)))
    exposure = rng.uniform(1.2, 3.0) if happens(troubles.over) else 1.0
    flicker = Flicker()
    if happens(troubles.flicker):
        flicker = Flicker(
            rng.uniform(0.1, 0.7), 50.0 if rng.random() < 0.5 else 60.0, rng.uniform(0, 2 * math.pi)
        )
    field_us = rng.uniform(8000, 20000) if happens(troubles.interlaced) else 0.0
    scale = rng.uniform(0.5, 0.9) if happens(troubles.upscaled) and not field_us else 1.0
    defects = Defects()
    if happens(troubles.defects):
        defects = Defects(
            hot=rng.uniform(0, 0.0006),
            dead=rng.uniform(0, 0.0004),
            columns=rng.uniform(0, 2.0),
            rows=rng.uniform(0, 1.5),
            stuck_columns=int(rng.integers(0, 3)),
            seed=int(rng.integers(1 << 30)),
        )
    tone, sharpen = happens(troubles.tone), happens(troubles.sharpen)
    temporal, median, bilateral = (
        happens(share) for share in (troubles.temporal, troubles.median, troubles.bilateral)
    )
    processing = Processing(
        temporal=rng.uniform(0.2, 0.6) if temporal else 0.0,
        temporal_grey=rng.uniform(2, 6),
        median_px=(3, 3, 5)[rng.integers(3)] if median else 0,
        bilateral=(rng.uniform(1.0, 2.5), rng.uniform(8, 40)) if bilateral else (0.0, 0.0),
        gamma=rng.uniform(1.0, 2.4) if tone else 1.0,
        curve=rng.uniform(-0.3, 0.7) if tone else 0.0,
        lift=rng.uniform(0, 25) if tone else 0.0,
        sharpen=rng.uniform(0.3, 2.0) if sharpen else 0.0,
        sharpen_px=rng.uniform(0.7, 2.0),
    )
    return replace(
        sensor, lens=lens, exposure=exposure, flicker=flicker, field_us=field_us, scale=scale,
        defects=defects, processing=processing,
    )  # fmt: skip
