"""The compiled inner loops of the renderer: one pass over pixels each, no allocation of frame size.

Arguments shared by several of them:

cam      float64 [13]: focal x (negative: mirrored), focal y, centre x, centre y, then the nine elements of
         the rotation camera -> vehicle, row by row
lens     float64 table of undistorted / distorted radius over the distorted radius squared, and its step
path     float64 [10]: vehicle x, y (mm, relative to the frame's origin), heading (rad), velocity forward,
         left (mm/s), turn rate (rad/s), row time (s), middle row, lens offset x, y (mm)
ceiling  height of the ceiling above the lens, mm
plane    float32 [2, height, width]: ceiling point of each pixel at its row's mid-exposure, mm from the origin
"""

import math

import numpy as np
from numba import njit

# ceiling objects: columns of the table that paint_object takes
KIND, X, Y, COS, SIN, A, B, C, VALUE, SOFT, EXTRA = range(11)
OBJECT_COLUMNS = 11
# kinds of objects; A, B, C are lengths in mm
DISC, RING, BOX, ROD, GRILLE, DOTS = range(6)

TEXTURE_SIZE = 256
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
def fill_plane(plane, cam, lens, lens_step, path, ceiling):
    """Fill `plane` with the ceiling point that each pixel's centre sees at mid-exposure of its row."""
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
def _texture(texture, x, y):
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
def paint_ceiling(albedo, plane, texture, surface):
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
            grain = speckle * _texture(texture, x * fine, y * fine)
            grain += stain * _texture(texture, y * coarse, x * coarse)
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
def paint_object(image, plane, item, box, ramp):
    """Blend an object's VALUE into `image`; its edge is SOFT mm wide, at least `ramp`.

    EXTRA shades a ROD across like a pipe lit from one side. box: row, column from .. to (exclusive).
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
def paint_occluder(color, alpha, plane, item, box, ramp):
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
def paint_shade(shade, plane, item, box, ramp):
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
def paint_glow(glow, plane, item, box, ramp):
    """Add a lamp: VALUE inside, outside a halo of EXTRA * VALUE that decays over SOFT mm."""
    for row in range(box[0], box[1]):
        for column in range(box[2], box[3]):
            edge = _distance(item, float(plane[0, row, column]), float(plane[1, row, column]))
            cover = min(max(0.5 - edge / ramp, 0.0), 1.0)
            halo = item[EXTRA]
            if edge > 0.0:
                halo *= math.exp(-edge / item[SOFT])
            glow[row, column] += item[VALUE] * (cover + (1.0 - cover) * halo)


@njit(cache=True, nogil=True, inline="always")
def _ink_distance(rings, lines, cells, side, u, v):
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
    return best


@njit(cache=True, nogil=True)
def paint_plate(image, cam, lens, lens_step, path, ceiling, plate, rings, lines, cells, side, samples, box):
    """Lay a marker over `image`, integrating each pixel over its area and over its row's exposure.

    plate    float64 [9]: centre x, y; cos, sin of the heading; radius; white; black; width of the edge ramp;
             reach: a pixel whose centre is farther than this from every edge needs one sample; mm
    samples  (N, 3): offset in x, y (px) and time (s) of each sample; symmetric, so that nothing is shifted
    """
    count = samples.shape[0]
    pose = np.empty((count + 1, 4))
    limit, ramp, reach = plate[4], plate[7], plate[8]
    white, black = plate[5], plate[6]
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
            edge = math.sqrt(u * u + v * v) - limit
            if edge > reach:
                continue
            ink = _ink_distance(rings, lines, cells, side, u, v)
            if edge < -reach and abs(ink) > reach:
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
                cover = 0.5 - (math.sqrt(u * u + v * v) - limit) / ramp
                if cover <= 0.0:
                    continue
                cover = min(cover, 1.0)
                ink = 0.5 - _ink_distance(rings, lines, cells, side, u, v) / ramp
                ink = min(max(ink, 0.0), 1.0)
                alpha += cover
                color += cover * (white + ink * (black - white))
            image[row, column] = image[row, column] * (1.0 - alpha / count) + color / count


@njit(cache=True, nogil=True)
def merge(image, color, alpha, shade, glow, flags):
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


@njit(cache=True, nogil=True)
def expose(frame, image, noise, levels):
    """Radiance (plate's white = 1) -> grey levels with vignetting, shot and read noise, 8 bit.

    levels  float64 [8]: black level, contrast, read noise variance, shot variance per grey level, vignetting
            (loss at the corner), centre x, y, 1 / corner distance squared
    """
    height, width = image.shape
    for row in range(height):
        dy = row - levels[6]
        for column in range(width):
            dx = column - levels[5]
            corner = (dx * dx + dy * dy) * levels[7]
            light = levels[1] * image[row, column] * (1.0 - levels[4] * corner)
            grey = levels[0] + light
            grey += noise[row, column] * math.sqrt(levels[2] + levels[3] * max(grey, 0.0))
            frame[row, column] = int(min(max(grey + 0.5, 0.0), 255.0))


@njit(cache=True, nogil=True)
def distance(item, x, y):
    """Signed distance (mm, negative inside) of ceiling point x, y from the edge of a ceiling object."""
    return _distance(item, x, y)
