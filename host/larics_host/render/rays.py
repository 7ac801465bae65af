"""The compiled loops that follow the camera's rays: pixels to ceiling, and the plates seen through them.

Arguments shared by them:

cam      float64 [13]: focal x (negative: mirrored), focal y, centre x, centre y, then the nine elements of
         the rotation camera -> vehicle, row by row
lens     float64 table of undistorted / distorted radius over the distorted radius squared, and its step
path     float64 [10]: vehicle x, y (mm, relative to the frame's origin), heading (rad), velocity forward,
         left (mm/s), turn rate (rad/s), row time (s), middle row, lens offset x, y (mm)
ceiling  height of the ceiling above the lens, mm
"""

from __future__ import annotations

import math

import numpy as np

from larics_host.compilation import njit
from larics_host.render.finish import (
    CURL,
    CURL_COS,
    CURL_SIN,
    JAG,
    SCREEN,
    SHEET,
    TONE,
    WEAR,
    WEAR_CELL,
    WEAR_U,
    WEAR_V,
)
from larics_host.render.painters import texture_at
from larics_host.render.plate_edge import plate_distance

# beyond this many heights to the side the ceiling is not painted (a camera tilted to the horizon)
FAR = 25.0


@njit(cache=True, nogil=True, inline="always")
def _locate(path, seconds):
    """Vehicle position and heading `seconds` from the middle of the frame: cos, sin, x, y."""
    turn = path[5] * seconds
    half = 0.5 * turn
    chord = seconds
    if abs(half) > 1e-9:
        chord = seconds * math.sin(half) / half
    cos = math.cos(path[2] + half)
    sin = math.sin(path[2] + half)
    x = path[0] + chord * (cos * path[3] - sin * path[4])
    y = path[1] + chord * (sin * path[3] + cos * path[4])
    return math.cos(path[2] + turn), math.sin(path[2] + turn), x, y


@njit(cache=True, nogil=True, inline="always")
def _see(cam, lens, lens_step, ceiling, px, py):
    """Ceiling point in the vehicle's axes, mm from the lens, that image position px, py sees."""
    x = (px - cam[2]) / cam[0]
    y = (py - cam[3]) / cam[1]
    position = (x * x + y * y) / lens_step
    index = min(int(position), lens.size - 2)
    share = position - index
    bend = lens[index] + (lens[index + 1] - lens[index]) * share
    x *= bend
    y *= bend
    up = cam[10] * x + cam[11] * y + cam[12]
    away_x = cam[4] * x + cam[5] * y + cam[6]
    away_y = cam[7] * x + cam[8] * y + cam[9]
    reach = math.sqrt(away_x * away_x + away_y * away_y)
    up = max(up, max(reach / FAR, 1e-9))
    scale = ceiling / up
    return scale * away_x, scale * away_y


@njit(cache=True, nogil=True)
def fill_plane(
    plane: np.ndarray,
    cam: np.ndarray,
    lens: np.ndarray,
    lens_step: float,
    path: np.ndarray,
    ceiling: np.ndarray,
) -> None:
    """Fill `plane` with the ceiling point that each pixel's centre sees at mid-exposure of its row.

    plane  float32 [2, height, width]: x, y in mm from the origin
    """
    height, width = plane.shape[1:]
    for row in range(height):
        cos, sin, x0, y0 = _locate(path, (row - path[7]) * path[6])
        x0 += cos * path[8] - sin * path[9]
        y0 += sin * path[8] + cos * path[9]
        for column in range(width):
            x, y = _see(cam, lens, lens_step, ceiling, float(column), float(row))
            plane[0, row, column] = x0 + cos * x - sin * y
            plane[1, row, column] = y0 + sin * x + cos * y


@njit(cache=True, nogil=True, inline="always")
def _ink_distance(rings, lines, arcs, cells, side, u, v):
    """Signed distance (mm, negative in the ink) of plate point u, v from the nearest edge of the pattern."""
    if side > 0.0:
        count = cells.shape[0]
        cell = side / count
        column = (u / side + 0.5) * count
        row = (0.5 - v / side) * count
        i = int(math.floor(column))
        j = int(math.floor(row))
        in_x = column - i
        in_y = row - j
        ink = 0
        if 0 <= i < count and 0 <= j < count:
            ink = cells[j, i]
        nearest = 1.0
        for dj in range(-1, 2):
            for di in range(-1, 2):
                other = 0
                if 0 <= i + di < count and 0 <= j + dj < count:
                    other = cells[j + dj, i + di]
                if other != ink:
                    gap_x = 0.0 if di == 0 else (1.0 - in_x if di > 0 else in_x)
                    gap_y = 0.0 if dj == 0 else (1.0 - in_y if dj > 0 else in_y)
                    nearest = min(nearest, math.sqrt(gap_x * gap_x + gap_y * gap_y))
        return -nearest * cell if ink else nearest * cell
    radius = math.sqrt(u * u + v * v)
    best = 1e9
    for index in range(rings.shape[0]):
        best = min(best, abs(radius - rings[index, 0]) - rings[index, 1])
    for index in range(lines.shape[0]):
        along = lines[index, 0] * u + lines[index, 1] * v
        across = abs(lines[index, 0] * v - lines[index, 1] * u)
        best = min(best, max(max(lines[index, 2] - along, along - lines[index, 3]), across - lines[index, 4]))
    for index in range(arcs.shape[0]):
        along = arcs[index, 0] * u + arcs[index, 1] * v
        across = abs(arcs[index, 0] * v - arcs[index, 1] * u)
        # from the straight sides, which point to the centre; an arc is less than half a turn
        beside = across * arcs[index, 2] - along * arcs[index, 3]
        best = min(best, max(max(arcs[index, 4] - radius, radius - arcs[index, 5]), beside))
    return best


@njit(cache=True, nogil=True, inline="always")
def _worn(ink, finish, noise, u, v):
    """What is left of the ink (0..1) at plate point u, v after halftone printing and wear."""
    if finish[SCREEN] > 0.0:
        # a screen of dots at 45 degrees
        a = (u + v) * (math.pi * math.sqrt(2.0)) / finish[SCREEN]
        b = (u - v) * (math.pi * math.sqrt(2.0)) / finish[SCREEN]
        dot = 0.5 + 0.25 * (math.cos(a) + math.cos(b))
        ink *= min(max(0.5 + 12.0 * (finish[TONE] - dot), 0.0), 1.0)
    if finish[WEAR] > 0.0:
        place = texture_at(
            noise, u * finish[WEAR_CELL] + finish[WEAR_U], v * finish[WEAR_CELL] + finish[WEAR_V]
        )
        ink *= 1.0 - finish[WEAR] * min(max(0.5 + place, 0.0), 1.0)
    return ink


@njit(cache=True, nogil=True)
def paint_plate(
    image: np.ndarray,
    cam: np.ndarray,
    lens: np.ndarray,
    lens_step: float,
    path: np.ndarray,
    ceiling: np.ndarray,
    plate: np.ndarray,
    finish: np.ndarray,
    torn: np.ndarray,
    noise: np.ndarray,
    rings: np.ndarray,
    lines: np.ndarray,
    arcs: np.ndarray,
    cells: np.ndarray,
    side: float,
    samples: np.ndarray,
    box: np.ndarray,
) -> None:
    """Lay a marker over `image`, integrating each pixel over its area and over its row's exposure.

    plate    float64 [9]: centre x, y; cos, sin of the heading; radius; white; black; width of the edge ramp;
             reach: a pixel whose centre is farther than this from every edge needs one sample; mm
    finish, torn   Finish.row;  noise  the texture of wear and tears
    samples  (N, 3): offset in x, y (px) and time (s) of each sample; symmetric, so that nothing is shifted
    """
    count = samples.shape[0]
    pose = np.empty((count + 1, 4))
    limit, ramp, reach = plate[4], plate[7], plate[8]
    white, black = plate[5], plate[6]
    # how far the bend may move a point of the rim, seen under 45 degrees at most
    sag = 0.5 * abs(finish[CURL]) * limit * limit
    uneven = finish[SCREEN] > 0.0 or finish[WEAR] > 0.0
    for row in range(box[0], box[1]):
        row_time = (row - path[7]) * path[6]
        for index in range(count + 1):
            time = row_time
            if index < count:
                time += samples[index, 2]
            cos, sin, x0, y0 = _locate(path, time)
            x0 += cos * path[8] - sin * path[9] - plate[0]
            y0 += sin * path[8] + cos * path[9] - plate[1]
            # vehicle axes -> plate's u, v; v is clockwise from u in the map
            pose[index, 0] = plate[2] * cos + plate[3] * sin
            pose[index, 1] = plate[3] * cos - plate[2] * sin
            pose[index, 2] = plate[2] * x0 + plate[3] * y0
            pose[index, 3] = plate[3] * x0 - plate[2] * y0
        for column in range(box[2], box[3]):
            x, y = _see(cam, lens, lens_step, ceiling, float(column), float(row))
            u = pose[count, 0] * x + pose[count, 1] * y + pose[count, 2]
            v = pose[count, 1] * x - pose[count, 0] * y + pose[count, 3]
            edge = plate_distance(u, v, limit, finish[SHEET], torn, finish[JAG], noise)
            if edge > reach + sag:
                continue
            ink = _ink_distance(rings, lines, arcs, cells, side, u, v)
            if edge < -reach - sag and abs(ink) > reach + sag and not (uneven and ink < 0.0):
                image[row, column] = black if ink < 0.0 else white
                continue
            # within a pixel the ceiling point moves in proportion
            right_x, right_y = _see(cam, lens, lens_step, ceiling, column + 0.5, float(row))
            left_x, left_y = _see(cam, lens, lens_step, ceiling, column - 0.5, float(row))
            below_x, below_y = _see(cam, lens, lens_step, ceiling, float(column), row + 0.5)
            above_x, above_y = _see(cam, lens, lens_step, ceiling, float(column), row - 0.5)
            xx, yx = right_x - left_x, right_y - left_y
            xy, yy = below_x - above_x, below_y - above_y
            alpha = 0.0
            color = 0.0
            for index in range(count):
                px, py = samples[index, 0], samples[index, 1]
                sx, sy = x + xx * px + xy * py, y + yx * px + yy * py
                u = pose[index, 0] * sx + pose[index, 1] * sy + pose[index, 2]
                v = pose[index, 1] * sx - pose[index, 0] * sy + pose[index, 3]
                if finish[CURL] != 0.0:
                    # the bent plate is nearer, so the ray meets it nearer to the lens's axis
                    bent = finish[CURL_COS] * u + finish[CURL_SIN] * v
                    near = 1.0 - 0.5 * finish[CURL] * bent * bent / ceiling
                    sx *= near
                    sy *= near
                    u = pose[index, 0] * sx + pose[index, 1] * sy + pose[index, 2]
                    v = pose[index, 1] * sx - pose[index, 0] * sy + pose[index, 3]
                cover = 0.5 - plate_distance(u, v, limit, finish[SHEET], torn, finish[JAG], noise) / ramp
                if cover <= 0.0:
                    continue
                cover = min(cover, 1.0)
                ink = 0.5 - _ink_distance(rings, lines, arcs, cells, side, u, v) / ramp
                ink = min(max(ink, 0.0), 1.0)
                if uneven:
                    ink = _worn(ink, finish, noise, u, v)
                alpha += cover
                color += cover * (white + ink * (black - white))
            image[row, column] = image[row, column] * (1.0 - alpha / count) + color / count
