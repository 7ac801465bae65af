"""Frames to measure on: rendered ones with truth, photographs without a marker."""

import hashlib
import os
from pathlib import Path

import cv2
import numpy as np
import skimage.data
from PIL import Image

from larics_host.validation.scoring import Expected

WIDTH, HEIGHT = 360, 296
CODED = "coded"  # a target of the bench: LARICS markers with cells


def render(preset, seed, index, target, radius_px, overrides):
    """One rendered frame and its truths as scoring wants them."""
    from larics_host.render import render_frame

    if target == CODED:
        target, overrides = "larics", {"family": "coded", **overrides}
    frame, truths = render_frame(
        preset, seed, index, width=WIDTH, height=HEIGHT, radius_px=radius_px, target=target, **overrides
    )
    return frame, [
        Expected(t.id, t.x_px, t.y_px, t.heading_deg, t.radius_px, t.visible)
        for t in truths
        if t.id is not None
    ]


def renderer_digest():
    """Tells whether two runs saw the same frames: a digest of the renderer's sources."""
    from larics_host import render as package

    digest = hashlib.sha256()
    for path in sorted(Path(package.__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


class Cache:
    """Rendered frames kept in a folder, for tuning runs that see the same frames again and again.

    A change of the renderer's sources makes the stored frames unused, not wrong."""

    def __init__(self, folder):
        self.folder = Path(folder) / renderer_digest()
        self.folder.mkdir(parents=True, exist_ok=True)

    def block(self, preset, seed, start, count, target, radius_px, overrides):
        """`count` frames from index `start` on, rendered unless stored."""
        name = "%s-%d-%d-%d-%s-%g" % (preset, seed, start, count, target, radius_px)
        if overrides:
            name += "-" + hashlib.sha256(repr(sorted(overrides.items())).encode()).hexdigest()[:10]
        path = self.folder / (name + ".npz")
        if path.exists():
            with np.load(path) as stored:
                frames, rows = stored["frames"], stored["truths"]
            truths = [[] for _ in frames]
            for row in rows:
                truths[int(row[0])].append(Expected(int(row[1]), *map(float, row[2:])))
            return list(zip(frames, truths, strict=True))
        block = [render(preset, seed, start + i, target, radius_px, overrides) for i in range(count)]
        rows = [(i, *truth) for i, (_, truths) in enumerate(block) for truth in truths]
        partial = path.with_name("%s.%d.part.npz" % (name, os.getpid()))
        np.savez(
            partial,
            frames=np.stack([frame for frame, _ in block]),
            truths=np.array(rows, float).reshape(-1, 7),
        )
        partial.replace(path)
        return block


_PHOTOGRAPHS = (
    *("astronaut.png", "brick.png", "camera.png", "cell.png", "chelsea.png", "coffee.png", "coins.png"),
    *("grass.png", "gravel.png", "hubble_deep_field.jpg", "ihc.png", "moon.png", "motorcycle_left.png"),
    *("motorcycle_right.png", "page.png", "retina.jpg", "rocket.jpg", "text.png"),
)
_photographs = []


def photograph(seed, index):
    """A random crop of one of scikit-image's photographs, 360x296, some of them turned or dimmed."""
    if not _photographs:
        folder = Path(skimage.data.__file__).parent
        _photographs.extend(np.asarray(Image.open(folder / name).convert("L")) for name in _PHOTOGRAPHS)
    random = np.random.default_rng([seed, index])
    image = _photographs[index % len(_photographs)]
    if random.random() < 0.5:
        image = np.rot90(image, random.integers(1, 4))
    rows, columns = image.shape
    widest = min(columns, rows * WIDTH / HEIGHT)
    width = random.uniform(min(100.0, widest), widest)
    height = width * HEIGHT / WIDTH
    x, y = random.uniform(0, columns - width), random.uniform(0, rows - height)
    kernel = cv2.INTER_AREA if width > WIDTH else cv2.INTER_LINEAR
    crop = np.ascontiguousarray(image[int(y) : int(y + height), int(x) : int(x + width)])
    crop = cv2.resize(crop, (WIDTH, HEIGHT), interpolation=kernel)
    gain = random.uniform(0.3, 1.0)
    noise = random.normal(0.0, random.uniform(0.0, 3.0), crop.shape)
    return np.clip(crop * gain + noise, 0, 255).astype(np.uint8)
