"""Random ceilings: surfaces, furniture, things in the way, shadows and lamps, drawn from a Generator.

Sizes are those of real ceilings in mm. `region` is (x0, y0, x1, y1) in the map; `keep_out` an (N, 3) table of
x, y, radius that furniture stays clear of.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from larics.marker import LARICS3
from larics_host.render import painters
from larics_host.render.painters import BOX, DISC, DOTS, GRILLE, RING, ROD
from larics_host.render.scene import Surface, item, table

if TYPE_CHECKING:
    import numpy as np

    from larics_host.annotations import Row


TILE_SIZES_MM = ((600.0, 600.0), (625.0, 625.0), (1200.0, 600.0), (300.0, 300.0), (1250.0, 125.0))


def draw_surface(rng: np.random.Generator) -> Surface:
    """A bare ceiling: white or grey, plain, tiled, or tiled with perforated tiles."""
    tiled = rng.random() < 0.7
    perforated = tiled and rng.random() < 0.15
    return Surface(
        reflectance=rng.uniform(0.45, 0.95),
        speckle=rng.uniform(0.0, 0.06),
        speckle_mm=rng.uniform(3.0, 20.0),
        stain=rng.uniform(0.0, 0.04),
        stain_mm=rng.uniform(120.0, 500.0),
        tile_mm=TILE_SIZES_MM[rng.integers(len(TILE_SIZES_MM))] if tiled else (0.0, 0.0),
        tile_angle=rng.uniform(0, math.pi / 2),
        joint_mm=rng.uniform(4.0, 24.0),
        joint_factor=rng.uniform(0.35, 1.05),
        tile_tint=rng.uniform(0.0, 0.025),
        hole_pitch_mm=rng.uniform(25.0, 60.0),
        hole_mm=rng.uniform(4.0, 9.0) if perforated else 0.0,
        offset_mm=(rng.uniform(0, 3000.0), rng.uniform(0, 3000.0)),
    )


def _place(rng, region):
    return rng.uniform(region[0], region[2]), rng.uniform(region[1], region[3])


def _clear(rows, keep_out):
    """Whether no object of the group covers or touches a place to be kept free."""
    rows = table(rows)
    return all(painters.distance(row, x, y) > radius for row in rows for x, y, radius in keep_out)


def _smoke_detector(rng, x, y):
    size = rng.uniform(45, 65)
    rim = rng.uniform(0.75, 1.0)
    return [
        item(DISC, x, y, size, value=rim),
        item(RING, x, y, size * rng.uniform(0.55, 0.8), rng.uniform(2, 6), value=rng.uniform(0.1, 0.5)),
        item(DISC, x, y, size * rng.uniform(0.2, 0.4), value=rng.uniform(0.3, 0.9)),
        item(DISC, x + size / 2, y, 4, value=rng.uniform(0.0, 0.4)),
    ]


def _rings(rng, x, y):
    """Concentric rings of any ratio, on the ceiling or on a plate of their own."""
    count = rng.integers(1, 5)
    outer = rng.uniform(60, 230)
    half = rng.uniform(2, 12)
    value = rng.uniform(0.0, 0.5)
    rows = []
    if rng.random() < 0.5:
        rows.append(item(DISC, x, y, outer * rng.uniform(1.1, 1.8), value=rng.uniform(0.8, 1.0)))
    radius = outer
    for _ in range(count):
        rows.append(item(RING, x, y, radius, half, value=value))
        radius *= rng.uniform(0.35, 0.9)
        if radius < 3 * half:
            break
    return rows


def _diffuser(rng, x, y):
    """A round air outlet: equally spaced rings around a disc."""
    count = rng.integers(3, 7)
    outer = rng.uniform(100, 250)
    pitch = outer / (count + 0.5)
    half = pitch * rng.uniform(0.12, 0.3)
    value = rng.uniform(0.1, 0.5)
    rows = [item(DISC, x, y, outer + half, value=rng.uniform(0.75, 1.0))]
    rows += [item(RING, x, y, outer - pitch * index, half, value=value) for index in range(count)]
    rows.append(item(DISC, x, y, pitch * 0.4, value=value))
    return rows


def _speaker(rng, x, y):
    size = rng.uniform(60, 150)
    pitch = rng.uniform(9, 18)
    return [
        item(DISC, x, y, size * 1.12, value=rng.uniform(0.8, 1.0)),
        item(DOTS, x, y, size, pitch, pitch * rng.uniform(0.25, 0.4), value=rng.uniform(0.1, 0.5)),
        item(RING, x, y, size * 1.1, rng.uniform(1.5, 4), value=rng.uniform(0.3, 0.7)),
    ]


def _disc(rng, x, y):
    size = rng.uniform(15, 200)
    rows = [item(DISC, x, y, size, value=rng.uniform(0.0, 1.0))]
    if rng.random() < 0.6:
        rows.append(item(DISC, x, y, size * rng.uniform(0.3, 0.92), value=rng.uniform(0.0, 1.0)))
    return rows


CIRCLES = (_smoke_detector, _rings, _diffuser, _speaker, _disc)


def _grille(rng, x, y, angle):
    length, width = rng.uniform(100, 400), rng.uniform(50, 200)
    pitch = rng.uniform(14, 40)
    return [
        item(BOX, x, y, length + 20, width + 20, angle=angle, value=rng.uniform(0.6, 0.95)),
        item(GRILLE, x, y, length, width, pitch, angle=angle, value=rng.uniform(0.05, 0.5)),
    ]


def _pipe(rng, x, y, angle):
    half = rng.uniform(10, 45)
    # the shadow it throws on the ceiling beside it, then the pipe lit from one side
    away = half * rng.uniform(0.6, 1.6)
    shadow_x, shadow_y = x - away * math.sin(angle), y + away * math.cos(angle)
    return [
        item(ROD, shadow_x, shadow_y, 4000, half, angle=angle, value=rng.uniform(0.3, 0.5), soft_mm=half),
        item(ROD, x, y, 4000, half, angle=angle, value=rng.uniform(0.4, 0.9), extra=rng.uniform(-0.35, 0.35)),
    ]


def _cable(rng, x, y, angle):
    rows = []
    half, value = rng.uniform(2, 7), rng.uniform(0.0, 0.6)
    for _ in range(8):  # a chain of straight pieces that wanders
        length = rng.uniform(100, 400)
        ahead_x, ahead_y = x + length * math.cos(angle), y + length * math.sin(angle)
        middle = ((x + ahead_x) / 2, (y + ahead_y) / 2)
        rows.append(item(ROD, *middle, length / 2, half, angle=angle, value=value))
        x, y = ahead_x, ahead_y
        angle += rng.normal(0, 0.25)
    return rows


def _beam(rng, x, y, angle):
    half = rng.uniform(40, 150)
    return [item(BOX, x, y, 4000, half, angle=angle, value=rng.uniform(0.3, 0.95))]


def _hatch(rng, x, y, angle):
    """A rectangle with a frame: hatch, sign, panel."""
    a, b = rng.uniform(40, 300), rng.uniform(40, 300)
    frame = rng.uniform(4, 15)
    return [
        item(BOX, x, y, a + frame, b + frame, angle=angle, value=rng.uniform(0.1, 0.7)),
        item(BOX, x, y, a, b, angle=angle, value=rng.uniform(0.4, 1.0)),
    ]


STRAIGHT = (_grille, _pipe, _cable, _beam, _hatch)


def draw_decoy(rng: np.random.Generator, x: float, y: float, angle: float) -> list[Row]:
    """A thing made to look like a marker that is none; no part of it may spell a valid one.

    The marker's rings without the orientation line; rings of other ratios with all lines; one ring alone
    with lines.
    """
    family = LARICS3
    outer, inner, half = family.outer_mm10 / 10, family.inner_mm10 / 10, rng.uniform(7.5, 10)
    end = family.orientation_end_mm10 / 10
    code = (family.code_start_mm10 / 10, family.code_end_mm10 / 10)
    ink = rng.uniform(0.0, 0.15)
    rows = [item(DISC, x, y, family.plate_mm10 / 10, value=rng.uniform(0.85, 1.0))]

    def line(quarter, start, end):
        turned = angle + quarter * math.pi / 2
        middle, length = (start + end) / 2, (end - start) / 2
        where = (x + middle * math.cos(turned), y + middle * math.sin(turned))
        return item(BOX, *where, length, half, angle=turned, value=ink)

    kind = rng.integers(4)
    if kind == 0:  # true rings, perhaps coding lines, no orientation line
        rows += [item(RING, x, y, radius, half, value=ink) for radius in (outer, inner)]
        return rows + [line(quarter, *code) for quarter in (1, 2, 3) if rng.random() < 0.4]
    if kind == 1:  # another ratio; the coding lines end well inside the inner ring
        ratio = rng.choice([rng.uniform(0.4, 0.55), rng.uniform(0.78, 0.84)])
        rows += [item(RING, x, y, radius, half, value=ink) for radius in (outer, outer * ratio)]
        code = (code[0], min(code[1], 0.75 * outer * ratio))
    else:  # the outer or the inner ring alone
        rows.append(item(RING, x, y, outer if kind == 2 else inner, half, value=ink))
    rows.append(line(0, outer, end))
    return rows + [line(quarter, *code) for quarter in (1, 2, 3) if rng.random() < 0.5]


def draw_furniture(
    rng: np.random.Generator,
    region: tuple[float, float, float, float],
    circles: int,
    straight: int,
    decoys: int = 0,
    keep_out: Iterable[Any] = (),
) -> np.ndarray:
    """Object table of about `circles`, `straight` and `decoys` things in the region, clear of `keep_out`."""
    rows = []
    tasks = ["decoy"] * decoys + ["straight"] * straight + ["circle"] * circles
    for task in tasks:
        for _ in range(20):
            x, y = _place(rng, region)
            angle = rng.uniform(0, 2 * math.pi)
            if task == "circle":
                group = CIRCLES[rng.integers(len(CIRCLES))](rng, x, y)
            elif task == "straight":
                group = STRAIGHT[rng.integers(len(STRAIGHT))](rng, x, y, angle)
            else:
                group = draw_decoy(rng, x, y, angle)
            if _clear(group, keep_out):
                rows += group
                break
    return table(rows)


def draw_shadows(
    rng: np.random.Generator, region: tuple[float, float, float, float], count: int
) -> list[Row]:
    """Soft shadows of things between lamp and ceiling, as rows of shades."""
    rows = []
    for _ in range(count):
        x, y = _place(rng, region)
        angle, soft = rng.uniform(0, 2 * math.pi), rng.uniform(15, 150)
        value = rng.uniform(0.45, 0.85)
        kind = rng.integers(3)
        if kind == 0:
            rows.append(item(ROD, x, y, 3000, rng.uniform(20, 200), angle=angle, value=value, soft_mm=soft))
        elif kind == 1:
            sizes = rng.uniform(100, 900), rng.uniform(100, 900)
            rows.append(item(BOX, x, y, *sizes, angle=angle, value=value, soft_mm=soft))
        else:
            rows.append(item(DISC, x, y, rng.uniform(80, 600), value=value, soft_mm=soft))
    return rows


def draw_dirt(rng: np.random.Generator, x: float, y: float, radius: float, count: int) -> list[Row]:
    """Blotches, drips and dust on a plate, as rows of shades."""
    rows = []
    for _ in range(count):
        away, direction = radius * math.sqrt(rng.random()), rng.uniform(0, 2 * math.pi)
        where = (x + away * math.cos(direction), y + away * math.sin(direction))
        value = rng.uniform(0.45, 0.9)
        if rng.random() < 0.25:
            length, half = rng.uniform(15, 80), rng.uniform(1.5, 5)
            rows.append(item(ROD, *where, length, half, angle=direction, value=value, soft_mm=6))
        else:
            size = rng.uniform(4, 25)
            rows.append(item(DISC, *where, size, value=value, soft_mm=rng.uniform(0.4, 1.5) * size))
    return rows


def draw_lamps(
    rng: np.random.Generator,
    region: tuple[float, float, float, float],
    count: int,
    radiance: float,
    keep_out: Iterable[Any] = (),
) -> list[Row]:
    """Lit panels, tubes and round lamps with a halo; `radiance` in units of the white plate."""
    rows = []
    for _ in range(count):
        for _ in range(20):
            x, y = _place(rng, region)
            angle = rng.uniform(0, math.pi)
            kind = rng.integers(3)
            value = radiance * rng.uniform(0.7, 1.3)
            halo = dict(soft_mm=rng.uniform(40, 160), extra=min(rng.uniform(0.1, 0.6) / value, 0.5))
            if kind == 0:
                sizes = rng.uniform(150, 300), rng.uniform(100, 300)
                row = item(BOX, x, y, *sizes, angle=angle, value=value, **halo)
            elif kind == 1:
                sizes = rng.uniform(300, 750), rng.uniform(15, 60)
                row = item(ROD, x, y, *sizes, angle=angle, value=value, **halo)
            else:
                row = item(DISC, x, y, rng.uniform(30, 170), value=value, **halo)
            if _clear([row], keep_out):
                rows.append(row)
                break
    return rows


def draw_glare(rng: np.random.Generator, x: float, y: float, away_mm: float, strength: float) -> Row:
    """The bright patch that a lamp leaves on a plate `away_mm` from its centre, as a row of lamps."""
    direction = rng.uniform(0, 2 * math.pi)
    where = (x + away_mm * math.cos(direction), y + away_mm * math.sin(direction))
    return item(DISC, *where, rng.uniform(2, 15), value=strength, soft_mm=rng.uniform(30, 120), extra=1.0)
