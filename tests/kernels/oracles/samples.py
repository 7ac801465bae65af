"""The blur-model reader's samples and the shape of its rings."""

import math

import numpy as np

from larics.kernels import layouts as at

from .compare import BIAS, close, numbers, same


def _bilinear(picture, x, y):
    left, top = int(x), int(y)
    fx, fy = x - left, y - top
    a, b = picture[top, left : left + 2]
    c, d = picture[top + 1, left : left + 2]
    return (a + (b - a) * fx) * (1 - fy) + (c + (d - c) * fx) * fy


def polar_samples(before, after, result):
    _, _, image, _, pose, fan, _, cosine, sine, _ = before
    cx, cy, radius, e1, e2, hx, hy, width, height = pose
    cx, cy, e1, e2, hx, hy = (value - BIAS for value in (cx, cy, e1, e2, hx, hy))
    e1, e2, hx, hy = (value / 16384 for value in (e1, e2, hx, hy))
    directions, step, start, first, count = fan
    picture = numbers(image).reshape(height, width).astype(float)
    found = numbers(after[9], directions * count).reshape(directions, count) if result else None
    inside = True
    for k in range(directions):
        angle = 2 * math.pi * (start + k * step) / 256
        turned = math.atan2(sine, cosine)
        vx, vy = math.cos(angle + turned), math.sin(angle + turned)
        wx, wy = vx + e1 * vx + e2 * vy, vy + e2 * vx - e1 * vy
        for i in range(count):
            u = (first + i) / 24
            distance = radius / 256 * u * (1 + (hx * vx + hy * vy) * u)
            x, y = cx / 256 + distance * wx, cy / 256 + distance * wy
            if not (0.2 <= x < width - 1.2 and 0.2 <= y < height - 1.2):
                inside = inside and 0 <= x < width - 1 and 0 <= y < height - 1
                continue
            if result:
                around = [
                    16 * _bilinear(picture, x + dx, y + dy) for dx in (-0.1, 0, 0.1) for dy in (-0.1, 0, 0.1)
                ]
                assert min(around) - 40 <= found[k, i] <= max(around) + 40, (k, i)
    assert inside or not result


def circle_samples(before, after, result):
    _, _, image, width, cx, cy, _, directions, wanted, _, samples = before
    picture = numbers(image).reshape(-1, width)
    scan = after[9]
    least, last = scan[at.SCAN_LEAST], scan[at.SCAN_LAST]
    count, pitch = scan[at.SCAN_COUNT], scan[at.SCAN_PITCH]
    # steps of a twentieth of the smallest radius, from the unit 13 of it to the unit 29 of the largest
    assert pitch == max(24, least // 20) and scan[at.SCAN_REFERENCE] == (least + last) // 2
    assert 0 <= least * 13 / 24 - scan[at.SCAN_FIRST] < pitch
    assert 0 < scan[at.SCAN_FIRST] + (count - 1) * pitch - last * 29 / 24 <= pitch
    found = numbers(after[10], directions * count).reshape(directions, count)
    for k in range(directions):
        if not wanted >> k % 8 & 1:
            same(found[k], samples[k * count : (k + 1) * count])
            continue
        angle = 2 * math.pi * (k + 0.5) / directions
        for i in range(count):
            distance = (scan[at.SCAN_FIRST] + i * scan[at.SCAN_PITCH]) / 256
            x, y = cx / 256 + distance * math.cos(angle), cy / 256 + distance * math.sin(angle)
            seen = {
                16 * picture[math.floor(y + dy + 0.5), math.floor(x + dx + 0.5)]
                for dx in (-0.02, 0.02)
                for dy in (-0.02, 0.02)
            }
            assert found[k, i] in seen, (k, i)


def mean_samples(before, after, result):
    _, _, samples, apart, sectors, count, _ = before
    pitch = count + apart
    for sector in range(sectors):
        first = numbers(samples)[sector * pitch : sector * pitch + count]
        other = numbers(samples)[sector * pitch + apart : sector * pitch + apart + count]
        mean = (first + other) // 2
        whole = mean.sum() // count
        same(after[6][sector * count : sector * count + count], (mean - whole + 32768) & 65535)
        assert after[6][sectors * count + sector] == whole
    assert result == sectors


def sector_radii(before, after, result):
    _, _, _, samples, scan, templates, sums, least_match, untouched, begin, hop, whole = before
    first, pitch, count, least, last, reference = scan
    greys = numbers(samples, 32 * count).reshape(32, count)
    template = numbers(templates, 16) - 32768
    total = 0
    seen_sectors = range(begin, 32, hop)
    for sector in set(range(0, 32, 2)) - set(seen_sectors):
        same(after[8][sector : sector + 2], untouched[sector : sector + 2])
    for sector in seen_sectors:
        profile = (greys[sector - 1] + greys[(sector + 1) % 32] + 2 * greys[sector]) // 4
        matches = {}
        radius = least
        while radius <= last:
            places = (radius * np.arange(13, 29) / 24 - first) / pitch + 0.5
            places = np.clip(places, 0, count - 1)
            seen = profile[places.astype(int)]
            product = -(seen * template).sum()
            power = ((seen - seen.mean()) ** 2).sum() + 16
            matches[radius] = max(0, product) ** 2 / (sums[0] * power) * 1024
            radius += radius // 20
        shift = after[8][sector]
        assert after[8][sector + 1] == 0
        best = max(matches.values())
        if shift:
            chosen = (shift - 1048576) // 4 + reference
            assert chosen in matches and matches[chosen] >= 0.6 * best - 30, (sector, matches, chosen)
            total += matches[chosen]
        else:
            total += min(best, least_match)
    assert result - whole <= len(seen_sectors) * 1024
    if all(after[8][sector] for sector in seen_sectors):
        assert abs(result - whole - total) <= 0.15 * total + 200


def line_shade(before, after, result):
    image, _, _, pose, _, _ = before
    cx, cy = [(pose[k] - at.BIAS) / 256 for k in (at.CIRCLE_X_Q8, at.CIRCLE_Y_Q8)]
    e1, e2 = [(pose[k] - at.BIAS) / 16384 for k in (at.CIRCLE_E1, at.CIRCLE_E2)]
    width, height = pose[at.CIRCLE_WIDTH], pose[at.CIRCLE_HEIGHT]
    unit = pose[at.CIRCLE_RADIUS_Q8] / 256 / 24
    angles = 2 * math.pi * (np.arange(64) + 0.5) / 64
    cos, sin = np.cos(angles), np.sin(angles)
    dx, dy = unit * (cos + e1 * cos + e2 * sin), unit * (sin + e2 * cos - e1 * sin)
    inside = [(cx + 32 * dx, width), (cy + 32 * dy, height)]
    if result == 8192:
        assert any(values.min() < -0.4 or values.max() > size - 0.6 for values, size in inside)
        assert after[5][0] == 0
        return
    assert all(values.min() > -0.6 and values.max() < size - 0.4 for values, size in inside)
    # a pixel's edge is where rounding decides: shades of places a little to either side bound the result
    found, bands = [], []
    for off in (-0.02, 0, 0.02):
        picture = numbers(image).reshape(-1, width)

        def seen(u, off=off, picture=picture):
            x = np.clip(np.floor(cx + u * dx + 0.5 + off).astype(int), 0, width - 1)
            return picture[np.clip(np.floor(cy + u * dy + 0.5 + off).astype(int), 0, height - 1), x]

        rings = (2 * seen(20) - seen(16) - seen(24)).sum()
        around = sum(seen(u) for u in range(28, 33))
        around = np.roll(around, 1) + 2 * around + np.roll(around, -1)
        beside = [sum(np.roll(around, side * k) for k in (5, 6, 7)) for side in (1, -1)]
        deepest = max(0, (np.minimum(*beside) - 3 * around).max())
        # five pixels, four times, three times, against two of each of 64 directions
        found.append(min(8191, 256 * (deepest / 60) / (max(64, rings) / 128)))
        bands.append((seen(20) < np.minimum(seen(32), seen(8))).sum())
    assert min(found) * 0.9 - 8 <= result <= max(found) * 1.1 + 8, (result, found)
    assert min(bands) - 2 <= after[5][0] <= max(bands) + 2, (after[5][0], bands)


def ring_shifts(before, after, result):
    _, _, means, templates, sums, motion_axis, radius, limit, least_match, _, _, _ = before
    good = 0
    for sector in range(32):
        rel = (1 + 2 * sector - motion_axis) % 32 if motion_axis < at.STILL else 0
        rel = min(rel, 32 - rel)
        dark, outer, inner = numbers(templates)[48 * rel : 48 * rel + 48].reshape(3, 16) - 32768.0
        seen = numbers(means)[16 * sector : 16 * sector + 16] - 32768.0
        power = (seen**2).sum() + 16
        product = max(0.0, -(seen * dark).sum())
        amplitude = min(16383, 1024 * product / (dark**2).sum())
        match = min(1024, 1024 * product**2 / ((dark**2).sum() * power))
        found = after[11][sector], after[11][32 + sector], after[11][64 + sector]
        assert abs(found[0] - amplitude) <= 1 + amplitude / 50, (sector, found, amplitude)
        assert abs(found[2] - match) <= 20 + match / 25, (sector, found, match)
        background = means[512 + sector] + found[0] * sums[8 * rel + 4] / 1024
        assert abs(found[1] - background) <= 1
        counts = found[2] >= least_match and found[0] > 3
        good += counts
        if not counts:
            assert after[9][sector] == after[10][sector] == 0
            continue
        left = np.clip((seen + found[0] * dark / 1024) * 1024 / found[0], -1024, 1024)
        # two unknown shifts: least squares
        normal = np.array([[outer @ outer, outer @ inner], [outer @ inner, inner @ inner]])
        side = np.array([left @ outer, left @ inner])
        if (
            np.any(np.abs(side) > 3.8 * np.diag(normal))
            or np.linalg.cond(normal) > 30
            or normal[1, 1] < 65536
        ):
            continue  # bounded, or hardly to be told apart
        shifts = np.linalg.solve(normal, side) * 1024
        for ring in range(2):
            shift = after[9 + ring][sector]
            if abs(shifts[ring]) < 0.9 * limit:
                expected = shifts[ring] / 1024 * radius / 24 * 4
                assert shift and abs(shift - 1048576 - expected) <= 12 + abs(expected) / 12, (sector, ring)
            elif abs(shifts[ring]) > 1.1 * limit:
                assert shift == 0
    assert result == good


def shift_harmonics(before, after, result):
    _, _, shifts, _, rounds, floor, _ = before
    values = numbers(shifts)
    found = numbers(after[6])
    assert result == found[6] <= np.count_nonzero(values)
    if found[6] < 32 or rounds < 4:
        return
    angles = 2 * np.pi * (np.arange(32) + 0.5) / 32
    design = np.stack((np.ones(32), np.cos(angles), np.sin(angles), np.cos(2 * angles), np.sin(2 * angles)))
    expected = np.linalg.lstsq(design.T, values - 1048576, rcond=None)[0]
    scale = 3 + np.abs(values - 1048576).max() / 50
    close(found[:5] - 1048576, expected, scale)
    close(found[5], np.abs(values - 1048576 - expected @ design).mean(), scale)


ORACLES = {
    "polar": (
        polar_samples,
        circle_samples,
        mean_samples,
        sector_radii,
        line_shade,
    ),
    "sectors": (
        ring_shifts,
        shift_harmonics,
    ),
}
