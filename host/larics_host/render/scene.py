"""What the camera sees: a ceiling with its furniture in map coordinates, and the plates on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING

import cv2
import numpy as np

from larics_host.render import painters
from larics_host.render.painters import TEXTURE_SIZE

if TYPE_CHECKING:
    from larics_host.annotations import Row


NOTHING = np.zeros((0, painters.OBJECT_COLUMNS))


def item(
    kind: int,
    x_mm: float,
    y_mm: float,
    a_mm: float,
    b_mm: float = 0.0,
    c_mm: float = 0.0,
    *,
    angle: float = 0.0,
    value: float = 0.5,
    soft_mm: float = 0.0,
    extra: float = 0.0,
) -> Row:
    """One row of an object table: see the kinds in `painters`.

    DISC radius a; RING radius a, half width b; BOX half sizes a, b; ROD half length a, half width b;
    GRILLE half sizes a, b, slat pitch c; DOTS disc of radius a, holes of radius c at pitch b. `angle` in rad.
    `value` is a reflectance (white plate = 1), a shade's factor or a lamp's radiance; `extra` shades a rod
    like a pipe, and is the halo of a lamp as a share of its radiance.
    """
    return (kind, x_mm, y_mm, np.cos(angle), np.sin(angle), a_mm, b_mm, c_mm, value, soft_mm, extra)


def table(rows: Sequence[Row]) -> np.ndarray:
    """(N, 11) float64 from a list of `item` rows."""
    return np.array(rows, dtype=float).reshape(-1, painters.OBJECT_COLUMNS)


@dataclass
class Surface:
    """The bare ceiling. Strengths are shares of the reflectance, sizes mm; tile_mm (0, 0): no tiles."""

    reflectance: float = 0.75
    speckle: float = 0.03
    speckle_mm: float = 8.0
    stain: float = 0.03
    stain_mm: float = 300.0
    tile_mm: tuple = (0.0, 0.0)
    tile_angle: float = 0.0
    joint_mm: float = 10.0
    joint_factor: float = 0.6
    tile_tint: float = 0.01
    hole_pitch_mm: float = 20.0
    hole_mm: float = 0.0
    offset_mm: tuple = (0.0, 0.0)

    def row(self, origin_x: float, origin_y: float, mm_per_px: float) -> np.ndarray:
        """The kernel's parameter row for a plane whose origin is this map point."""
        # speckle finer than a pixel averages out in it
        speckle = self.speckle * min(1.0, self.speckle_mm / mm_per_px)
        return np.array(
            [
                *(origin_x + self.offset_mm[0], origin_y + self.offset_mm[1]),
                *(self.reflectance, speckle, 1 / self.speckle_mm, self.stain, 1 / self.stain_mm),
                *(*self.tile_mm, np.cos(self.tile_angle), np.sin(self.tile_angle)),
                *(self.joint_mm / 2, self.joint_factor, self.tile_tint),
                *(self.hole_pitch_mm, self.hole_mm, 1.2 * mm_per_px),
            ]
        )


@dataclass
class Scene:
    """Everything overhead, in the map frame.

    ceiling_mm  height of the ceiling above the lens
    plates      markers, in the order of the truth records
    objects     ceiling furniture under the plates; occluders hang before them; shades multiply the light
                (shadows, dirt); lamps add to it: object tables
    low_lamps   LowLamp below the ceiling, seen only as glossy plates mirror them
    """

    ceiling_mm: float = 3000.0
    surface: Surface = field(default_factory=Surface)
    plates: tuple = ()
    objects: np.ndarray = field(default_factory=lambda: NOTHING)
    occluders: np.ndarray = field(default_factory=lambda: NOTHING)
    shades: np.ndarray = field(default_factory=lambda: NOTHING)
    lamps: np.ndarray = field(default_factory=lambda: NOTHING)
    low_lamps: tuple = ()


@lru_cache(maxsize=1)
def texture() -> np.ndarray:
    """(256, 256) float32 periodic noise of zero mean and unit variance; the same in every process."""
    rng = np.random.Generator(np.random.PCG64(20))
    noise = rng.standard_normal((TEXTURE_SIZE, TEXTURE_SIZE), dtype=np.float32)
    wrapped = cv2.copyMakeBorder(noise, 8, 8, 8, 8, cv2.BORDER_WRAP)
    smooth = cv2.GaussianBlur(wrapped, (0, 0), 0.8)[8:-8, 8:-8]
    return np.ascontiguousarray((smooth - smooth.mean()) / smooth.std())
