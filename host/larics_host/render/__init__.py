"""The frame renderer: a pin-hole camera in 3-D under a ceiling with markers.

    render_frame(preset, seed, index, ...)   one frame of a preset and its truth; see `presets`
    render_view(scene, pose, motion, camera, sensor, rng)   one picture of a given scene; see `view`

Modules: camera (projection, lens, rolling shutter), plates (markers and tags), finish (print, bend and wear
of a plate), plate_edge (rim and tears), scene (ceiling and what hangs there), clutter (random furniture and
light), reflection (lamps mirrored in plates), rays and painters (compiled loops), optics (blur), lens_dirt,
flicker, sensor (grey levels, noise, JPEG), defects, processing (the image processor), view (one picture and
its truth), presets (ranges), furnish (a scene of a preset), troubles (what else may happen to it), series
(random frames), drive (frames along a path).
"""

from larics_host.render.presets import PRESETS
from larics_host.render.series import render_frame
from larics_host.render.view import render_view

__all__ = ["PRESETS", "render_frame", "render_view"]
