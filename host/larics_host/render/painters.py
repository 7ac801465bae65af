"""The compiled loops that paint the ceiling and what hangs there, each object within its box of the frame.

plane    float32 [2, height, width]: ceiling point that each pixel sees, mm (rays.fill_plane)
item     float64 [11]: one row of an object table, columns below (scene.item)
box      rows from .. to, columns from .. to (exclusive) that the object may touch
ramp     width of an edge, mm: what a pixel covers on the ceiling
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from larics_host.compilation import njit

if TYPE_CHECKING:
    import numpy as np


# columns of an object table
KIND, X, Y, COS, SIN, A, B, C, VALUE, SOFT, EXTRA = range(11)
OBJECT_COLUMNS = 11
# kinds of objects; A, B, C are lengths in mm
DISC, RING, BOX, ROD, GRILLE, DOTS = range(6)

TEXTURE_SIZE = 256


@njit(cache=True, nogil=True, inline="always")
def texture_at(texture: np.ndarray, x: float, y: float) -> float:
    """Bilinear sample of the periodic square texture."""
    floor_x = math.floor(x)
    floor_y = math.floor(y)
    share_x = x - floor_x
    share_y = y - floor_y
    x0 = int(floor_x) & (TEXTURE_SIZE - 1)
    y0 = int(floor_y) & (TEXTURE_SIZE - 1)
    x1 = (x0 + 1) & (TEXTURE_SIZE - 1)
    y1 = (y0 + 1) & (TEXTURE_SIZE - 1)
    top = texture[y0, x0] + (texture[y0, x1] - texture[y0, x0]) * share_x
    bottom = texture[y1, x0] + (texture[y1, x1] - texture[y1, x0]) * share_x
    return top + (bottom - top) * share_y


@njit(cache=True, nogil=True)
def paint_ceiling(albedo: np.ndarray, plane: np.ndarray, texture: np.ndarray, surface: np.ndarray) -> None:
    """Fill `albedo` (float32, white plate = 1) with the bare ceiling: colour, speckle, stains, tile joints.

    surface  float64 [17]: origin x, y of the texture relative to the plane's; reflectance; speckle strength,
             1 / cell; stain strength, 1 / cell; tile width, length (0: no tiles), cos, sin of its angle;
             joint half width and reflectance factor, tile tint; perforation pitch, radius (0: none); ramp, mm
    """
    origin_x, origin_y, base = surface[0], surface[1], surface[2]
    speckle, fine = surface[3], surface[4]
    stain, coarse = surface[5], surface[6]
    tile_w, tile_l, cos, sin = surface[7], surface[8], surface[9], surface[10]
    joint, joint_factor, tint = surface[11], surface[12], surface[13]
    pitch, hole, ramp = surface[14], surface[15], surface[16]
    height, width = albedo.shape
    for row in range(height):
        for column in range(width):
            x = plane[0, row, column] + origin_x
            y = plane[1, row, column] + origin_y
            grain = speckle * texture_at(texture, x * fine, y * fine)
            grain += stain * texture_at(texture, y * coarse, x * coarse)
            value = base * (1.0 + grain)
            if tile_w > 0.0 or hole > 0.0:
                u = cos * x + sin * y
                v = cos * y - sin * x
                if tile_w > 0.0:
                    cell_u = math.floor(u / tile_w)
                    cell_v = math.floor(v / tile_l)
                    in_u = u - cell_u * tile_w
                    in_v = v - cell_v * tile_l
                    shade = texture[int(cell_v) & (TEXTURE_SIZE - 1), int(cell_u) & (TEXTURE_SIZE - 1)]
                    value *= 1.0 + tint * shade
                    edge = min(min(in_u, tile_w - in_u), min(in_v, tile_l - in_v))
                    cover = min(max(0.5 - (edge - joint) / ramp, 0.0), 1.0) * min(1.0, 2.0 * joint / ramp)
                    value *= 1.0 - cover * (1.0 - joint_factor)
                if hole > 0.0:
                    du = u - pitch * math.floor(u / pitch) - 0.5 * pitch
                    dv = v - pitch * math.floor(v / pitch) - 0.5 * pitch
                    edge = math.sqrt(du * du + dv * dv) - hole
                    cover = min(max(0.5 - edge / ramp, 0.0), 1.0) * min(1.0, 2.0 * hole / ramp)
                    value *= 1.0 - 0.6 * cover
            albedo[row, column] = value


@njit(cache=True, nogil=True, inline="always")
def _distance(item, x, y):
    """Signed distance (mm, negative inside) of a ceiling point from an object's edge."""
    kind = int(item[KIND])
    dx = x - item[X]
    dy = y - item[Y]
    if kind == DISC:
        return math.sqrt(dx * dx + dy * dy) - item[A]
    if kind == RING:
        return abs(math.sqrt(dx * dx + dy * dy) - item[A]) - item[B]
    u = item[COS] * dx + item[SIN] * dy
    v = item[COS] * dy - item[SIN] * dx
    if kind == ROD:
        along = max(abs(u) - item[A], 0.0)
        return math.sqrt(along * along + v * v) - item[B]
    if kind == DOTS:
        pitch = item[B]
        du = u - pitch * math.floor(u / pitch) - 0.5 * pitch
        dv = v - pitch * math.floor(v / pitch) - 0.5 * pitch
        hole = math.sqrt(du * du + dv * dv) - item[C]
        return max(hole, math.sqrt(dx * dx + dy * dy) - item[A])
    over_u = abs(u) - item[A]
    over_v = abs(v) - item[B]
    outside_u = max(over_u, 0.0)
    outside_v = max(over_v, 0.0)
    box = math.sqrt(outside_u * outside_u + outside_v * outside_v) + min(max(over_u, over_v), 0.0)
    if kind == GRILLE:
        slat = abs(v - item[C] * math.floor(v / item[C]) - 0.5 * item[C]) - 0.25 * item[C]
        return max(box, slat)
    return box


@njit(cache=True, nogil=True)
def distance(item: np.ndarray, x: float, y: float) -> float:
    """Signed distance (mm, negative inside) of ceiling point x, y from the edge of a ceiling object."""
    return _distance(item, x, y)


@njit(cache=True, nogil=True)
def paint_object(
    image: np.ndarray, plane: np.ndarray, item: np.ndarray, box: np.ndarray, ramp: float
) -> None:
    """Blend an object's VALUE into `image`; its edge is SOFT mm wide, at least `ramp`.

    EXTRA shades a ROD across like a pipe lit from one side.
    """
    soft = max(item[SOFT], ramp)
    value = item[VALUE]
    for row in range(box[0], box[1]):
        for column in range(box[2], box[3]):
            x = float(plane[0, row, column])
            y = float(plane[1, row, column])
            cover = 0.5 - _distance(item, x, y) / soft
            if cover <= 0.0:
                continue
            cover = min(cover, 1.0)
            if item[SOFT] > ramp:
                cover = cover * cover * (3.0 - 2.0 * cover)
            paint = value
            if item[EXTRA] != 0.0:
                across = (item[COS] * (y - item[Y]) - item[SIN] * (x - item[X])) / item[B]
                paint *= 1.0 + item[EXTRA] * min(max(across, -1.0), 1.0)
            image[row, column] += cover * (paint - image[row, column])


@njit(cache=True, nogil=True)
def paint_occluder(
    color: np.ndarray, alpha: np.ndarray, plane: np.ndarray, item: np.ndarray, box: np.ndarray, ramp: float
) -> None:
    """Lay an object over what is already in the pair of layers (`color` is premultiplied by `alpha`)."""
    soft = max(item[SOFT], ramp)
    for row in range(box[0], box[1]):
        for column in range(box[2], box[3]):
            x = float(plane[0, row, column])
            y = float(plane[1, row, column])
            cover = min(max(0.5 - _distance(item, x, y) / soft, 0.0), 1.0)
            if cover <= 0.0:
                continue
            paint = item[VALUE]
            if item[EXTRA] != 0.0:
                across = (item[COS] * (y - item[Y]) - item[SIN] * (x - item[X])) / item[B]
                paint *= 1.0 + item[EXTRA] * min(max(across, -1.0), 1.0)
            color[row, column] += cover * (paint - color[row, column])
            alpha[row, column] += cover * (1.0 - alpha[row, column])


@njit(cache=True, nogil=True)
def paint_shade(shade: np.ndarray, plane: np.ndarray, item: np.ndarray, box: np.ndarray, ramp: float) -> None:
    """Multiply `shade` by VALUE inside the object, with a smooth penumbra SOFT mm wide."""
    soft = max(item[SOFT], ramp)
    for row in range(box[0], box[1]):
        for column in range(box[2], box[3]):
            cover = 0.5 - _distance(item, float(plane[0, row, column]), float(plane[1, row, column])) / soft
            if cover <= 0.0:
                continue
            cover = min(cover, 1.0)
            cover = cover * cover * (3.0 - 2.0 * cover)
            shade[row, column] *= 1.0 - cover * (1.0 - item[VALUE])


@njit(cache=True, nogil=True)
def paint_glow(glow: np.ndarray, plane: np.ndarray, item: np.ndarray, box: np.ndarray, ramp: float) -> None:
    """Add a lamp: VALUE inside, outside a halo of EXTRA * VALUE that decays over SOFT mm."""
    for row in range(box[0], box[1]):
        for column in range(box[2], box[3]):
            edge = _distance(item, float(plane[0, row, column]), float(plane[1, row, column]))
            cover = min(max(0.5 - edge / ramp, 0.0), 1.0)
            halo = item[EXTRA]
            if edge > 0.0:
                halo *= math.exp(-edge / item[SOFT])
            glow[row, column] += item[VALUE] * (cover + (1.0 - cover) * halo)


@njit(cache=True, nogil=True)
def merge(
    image: np.ndarray,
    color: np.ndarray,
    alpha: np.ndarray,
    shade: np.ndarray,
    glow: np.ndarray,
    flags: Sequence[bool],
) -> None:
    """image = (image under the occluders) * shade + glow, in place. flags: has occluders, has glow."""
    height, width = image.shape
    for row in range(height):
        for column in range(width):
            value = image[row, column]
            if flags[0]:
                value = value * (1.0 - alpha[row, column]) + color[row, column]
            value *= shade[row, column]
            if flags[1]:
                value += glow[row, column]
            image[row, column] = value
