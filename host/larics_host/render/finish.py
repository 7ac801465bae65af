"""What a plate is beside its pattern: how it was printed, how it hangs, what time did to it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

# kernel's row: items of Finish.row
CURL, CURL_COS, CURL_SIN, SCREEN, TONE, WEAR, WEAR_CELL, WEAR_U, WEAR_V, JAG, SHEET = range(11)
FINISH_COLUMNS = 11


@dataclass(frozen=True)
class Finish:
    """A print; the defaults are a flat, round, evenly inked, matt and whole plate.

    sheet          a square sheet of paper around the plate's circle instead of a round plate
    curl_per_m     curvature of the bent plate, 1/m, positive where its sides hang towards the camera;
    curl_deg       direction across the bend, from the orientation line; the marker's centre stays in place
    gloss          share of a lamp's light that the surface mirrors
    tilt           (along u, along v) slopes of the hanging plate, that turn what it mirrors
    screen_mm      pitch of the halftone screen in which the ink is printed; 0: solid
    tone           share of the area that the screen's dots cover
    wear           share of the ink that is gone where it is worn most; wear_mm: size of such places
    wear_at        (u, v) shift of the pattern of wear, in cells
    torn           of (direction in deg, distance from the centre in mm): what lies beyond is torn off
    jag_mm         roughness of the tear
    """

    sheet: bool = False
    curl_per_m: float = 0.0
    curl_deg: float = 0.0
    gloss: float = 0.0
    tilt: tuple = (0.0, 0.0)
    screen_mm: float = 0.0
    tone: float = 1.0
    wear: float = 0.0
    wear_mm: float = 40.0
    wear_at: tuple = (0.0, 0.0)
    torn: tuple = ()
    jag_mm: float = 0.0

    def row(self) -> tuple[np.ndarray, np.ndarray]:
        """The kernels' parameters: float64 [11], and the tears (N, 3): cos, sin, mm.

        Curvature is in 1/mm there, and the tone the screen's level up to which there is ink."""
        curl, tears = np.radians(self.curl_deg), np.array(self.torn, dtype=float).reshape(-1, 2)
        values = np.array(
            [
                *(self.curl_per_m / 1000, np.cos(curl), np.sin(curl)),
                *(self.screen_mm, screen_level(self.tone)),
                *(self.wear, 1 / self.wear_mm, *self.wear_at),
                *(self.jag_mm, float(self.sheet)),
            ]
        )
        turned = np.radians(tears[:, 0])
        return values, np.stack([np.cos(turned), np.sin(turned), tears[:, 1]], axis=1)


@lru_cache(maxsize=256)
def screen_level(tone: float) -> float:
    """The level of the kernel's screen below which lies this share of its area."""
    wave = np.cos(np.linspace(0, np.pi, 400))
    return float(np.quantile(0.5 + 0.25 * (wave[:, None] + wave[None]), tone))
