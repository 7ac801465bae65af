"""What each kernel must give, computed another way: numpy in floating point, or the plain definition.

ORACLES: module.kernel -> function(arguments before the call, arguments after it, result) that asserts. The
arguments are those of the cases_<module>.py. `same` and `close` compare whole arrays.
"""

import math

import numpy as np

from larics import _cpython
from larics.arith import tables
from larics.kernels import layouts as at
from larics.marker import golay

BIAS = at.BIAS
WORDS = np.array([golay.cells(marker_id) for marker_id in range(4096)])
LOG = np.frombuffer(bytes(tables.LOG_GREY_Q8), "<u2").astype(int)
TURN = np.frombuffer(bytes(tables.COSINE_Q14_BIASED), "<u2").astype(int) - 32768


def numbers(buffer, count=None):
    """A buffer's items as a numpy array of integers."""
    return np.array(buffer[:count] if count is not None else buffer, dtype=np.int64)


def same(found, expected):
    np.testing.assert_array_equal(numbers(found), numbers(expected))


def close(found, expected, most):
    off = np.abs(np.asarray(found, float) - np.asarray(expected, float))
    assert off.max(initial=0) <= most, (off.max(), int(np.argmax(off)))


def log2_grey(grey):
    """The definition of the log grey, for interpolated greys, too."""
    return 256 * np.log2((np.asarray(grey, float) + 16) / 16)


# --- votes


def cast_votes(before, after, result):
    _, _, cells, offsets, edges, first, count, every, grid, bits = before
    width, step, row = (grid[k] for k in (at.CELLS_WIDTH, at.CELLS_STEP, at.CELLS_ROW))
    outer, inner = grid[at.CELLS_OUTER], grid[at.CELLS_INNER]
    expected = list(cells)
    for edge in edges[first:count:every]:
        direction, position = edge >> 20, edge & 0xFFFFF
        y, x = divmod(position, width)
        origin = (y + step // 2) // step * row + (x + step // 2) // step
        place = direction * 2 * (outer + inner)
        for run, length in enumerate((outer, outer, inner, inner)):
            for offset in offsets[place : place + length]:
                expected[origin + offset] |= bits[4 * direction + run]
            place += length
    same(after[2], expected)
    assert result == len(edges[first:count:every]) * 2 * (outer + inner)


def list_runs(before, after, result):
    """Cells at the ends of arrows of the radii's lengths, rounded to whole cells."""
    _, _, _, _, _, run, most, first_q8, last_q8, count, half_line_q8, grid = before
    step, row, padding = (grid[k] for k in (at.CELLS_STEP, at.CELLS_ROW, at.CELLS_PADDING))
    side = 1 if run & 1 else -1
    lengths = (side * np.linspace(first_q8, last_q8, count) - half_line_q8) / step / 256
    found = numbers(after[0])
    longest = 0
    for direction in range(48):
        first = (4 * direction + run) * most
        length = after[4][4 * direction + run]
        entries = list(found[first : first + length])
        assert len(set(entries)) == length
        rows = np.round((np.array(entries) - padding * (row + 1)) / row)
        columns = np.array(entries) - padding * (row + 1) - rows * row
        turn = 2 * np.pi * direction / 48
        ends = lengths * np.exp(1j * turn)
        off = np.abs(ends[:, None] - (columns + 1j * rows)[None, :])
        close(off.min(1), np.zeros(count), 0.75)  # half a cell each way, and the roundings before
        close(off.min(0), np.zeros(length), 0.75)
        longest = max(longest, length)
    assert result == longest


def join_runs(before, after, result):
    runs, _, _, lengths, most, grid, _ = before
    expected = []
    for run in range(192):
        entries = list(runs[run * most : run * most + lengths[run]])
        wanted = grid[at.CELLS_INNER] if run & 2 else grid[at.CELLS_OUTER]
        expected += entries + entries[-1:] * (wanted - len(entries))
    same(after[6], expected)


def clear_cells(before, after, result):
    cells, first, end = before
    expected = list(cells)
    expected[first:end] = [0] * (end - first)
    for k in range(end, end + 3):  # may be cleared as well
        if k < len(cells):
            assert after[0][k] in (0, cells[k])
            expected[k] = after[0][k]
    same(after[0], expected)


def _directions(cell):
    return bin(int(cell)).count("1")


def find_windows(before, after, result):
    cells, _, row, left, right, top, bottom, _, _, least, _, capacity = before
    windows = {}
    for y in range(top, bottom):
        for x in range(left, right):
            all16 = [cells[(2 * y + dy) * row + 2 * x + dx] for dy in range(4) for dx in range(4)]
            windows[x, y] = _directions(np.bitwise_or.reduce(all16))
    listed = numbers(after[10], 3 * result).reshape(-1, 3)
    for count, x, y in listed:
        assert windows[x, y] == count >= least
    all_of_them = [(count, *place) for place, count in windows.items() if count >= least]
    if len(all_of_them) < capacity:
        assert [tuple(one) for one in listed] == all_of_them
    else:  # a full list has dropped the weaker ones
        assert result <= capacity


def rank_centres(before, after, result):
    _, _, cells, grid, windows, count, _, _, capacity = before
    row, padding, step = grid[at.CELLS_ROW], grid[at.CELLS_PADDING], grid[at.CELLS_STEP]

    def around(x, y):
        return [cells[(y + dy) * row + x + dx] for dy in (-1, 0, 1) for dx in (-1, 0, 1)]

    def score(x, y):
        nine = around(x, y)
        return 8 * _directions(np.bitwise_or.reduce(nine)) + sum(map(_directions, nine))

    def place(x, y):
        weights = [_directions(cell) ** 2 for cell in around(x, y)]
        total = sum(weights) or 1
        dx = math.floor(256 * sum(w * (k % 3 - 1) for k, w in enumerate(weights)) / total)
        dy = math.floor(256 * sum(w * (k // 3 - 1) for k, w in enumerate(weights)) / total)
        return ((x - padding) * 256 + dx) * step + 32768, ((y - padding) * 256 + dy) * step + 32768

    best = {}
    for k in range(count):
        x, y = 2 * windows[3 * k + 1] + 1, 2 * windows[3 * k + 2] + 1
        for corner in ((x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)):
            best[corner] = score(*corner)
    known = {(best[corner], *place(*corner)) for corner in best}
    found = [tuple(one) for one in numbers(after[7], 3 * result).reshape(-1, 3)]
    assert set(found) <= known
    assert [one[0] for one in found] == sorted((one[0] for one in found), reverse=True)
    assert 1 <= result <= capacity and found[0][0] == max(best.values())


# --- edges and greys


def _grid(grid):
    names = ("WIDTH", "REACH", "LEFT", "RIGHT", "TOP", "BOTTOM", "STEP", "FIRST", "END")
    return {name: grid[getattr(at, "GRID_" + name)] for name in names}


def _gradient(image, grid, position):
    reach, width = grid["REACH"], grid["WIDTH"]
    down = int(image[position + reach * width]) - int(image[position - reach * width])
    return int(image[position + reach]) - int(image[position - reach]), down


def gradient_histogram(before, after, result):
    _, _, image, grid, every, histogram = before
    grid = _grid(grid)
    step = grid["STEP"] * every
    expected = list(histogram)
    samples = shift = 0
    for y in range(grid["TOP"], grid["BOTTOM"], step):
        for x in range(grid["LEFT"] + shift, grid["RIGHT"], step):
            larger, smaller = sorted(map(abs, _gradient(image, grid, y * grid["WIDTH"] + x)), reverse=True)
            expected[min(127, (larger + 3 * smaller // 8) // 2)] += 1
            samples += 1
        shift = (shift + 5 * step // 8) % step
    same(after[5], expected)
    assert result == samples


def edge_threshold(before, after, result):
    histogram, _, _, samples, floor, median_q4, share_min, share_max = before
    seen = np.cumsum(numbers(histogram))

    def bin_with(count):
        """The first bin up to which so many were seen; as nothing is crossed by none, the default is 127."""
        reached = np.flatnonzero(seen >= count)
        return int(reached[0]) if count > 0 and len(reached) else None

    median = bin_with(samples // 2) or 0
    upper = bin_with(samples - samples * share_min // 1024)
    lower = bin_with(samples - samples * share_max // 1024)
    upper = 127 if upper is None else upper
    lower = 127 if lower is None else lower
    expected = max(floor, 2 * lower + 1, min(median * median_q4 // 8, 2 * upper + 1))
    assert result == expected
    assert not any(after[0])


def steep_positions(before, after, result):
    image, _, _, grid, field, threshold2, positions, listed, capacity = before
    grid = _grid(grid)
    step = grid["STEP"]
    expected = list(positions[:listed])
    for number, y in enumerate(range(grid["TOP"], grid["BOTTOM"], step)):
        shift = step if field and (number + field) % 2 == 0 else 0
        for x in range(grid["LEFT"] + shift, grid["RIGHT"], 2 * step if field else step):
            across, down = _gradient(image, grid, y * grid["WIDTH"] + x)
            if across * across + down * down > threshold2 and len(expected) < capacity:
                expected.append(y * grid["WIDTH"] + x)
    assert result == len(expected)
    same(after[6][:result], expected)


def thin_line_edges(before, after, result):
    image, _, _, _, positions, count, _, grid, threshold, _, probes, least2 = before
    grid = _grid(grid)
    width, reach = grid["WIDTH"], grid["REACH"]
    edges, listed = result & 32767, result >> 15
    kept = {edge & 0xFFFFF: edge >> 20 for edge in after[6][:edges]}
    others = {edge & 0xFFFFF: edge >> 20 for edge in after[6][edges:listed]}
    assert not set(kept) & set(others)
    inside = [position for position in positions[:count] if grid["FIRST"] <= position < grid["END"]]
    assert sorted(edge & 0xFFFFF for edge in after[6][:listed]) == sorted(inside)
    for position in inside:
        y, x = divmod(position, width)
        patch = [
            [int(image[(y + dy * reach) * width + x + dx * reach]) for dx in (-1, 0, 1)] for dy in (-1, 0, 1)
        ]
        patch = np.array(patch)
        gx = (patch[:, 2] - patch[:, 0]) @ (1, 2, 1)
        gy = (patch[2] - patch[0]) @ (1, 2, 1)
        direction = {**kept, **others}[position]
        turn = math.atan2(gy, gx) / (2 * math.pi) * 48 % 48 if gx or gy else 0
        off = abs((direction - turn + 24) % 48 - 24)
        assert off <= 0.75 or not (gx or gy), (position, off)
        beyond, dark, light = (
            int(image[position + probes[3 * direction + k] - 32768]) for k in range(3)
        )  # fmt: skip
        is_thin = 2 * (beyond - dark) > threshold and 3 * (beyond - dark) >= light - dark
        across, down = patch[1, 2] - patch[1, 0], patch[2, 1] - patch[0, 1]
        is_steep = not least2 or across**2 + down**2 > least2
        assert (position in kept) == (is_thin and is_steep), position


def count_greys(before, after, result):
    frame, _, _, _, width, left, top, right, bottom, step = before
    picture = numbers(frame).reshape(-1, width)[top:bottom:step, left:right:step]
    same(after[1], np.bincount(picture.ravel() >> 2, minlength=64))


# --- candidates: coarse radius and dark directions


def edge_distances(before, after, result):
    _, _, edges, _, count, radii, cx, cy, axes, _ = before
    width, reach = radii[at.RADII_WIDTH], radii[at.RADII_REACH_Q4]
    half_line, slack = radii[at.RADII_HALF_LINE_Q4], radii[at.RADII_SLACK_Q4]
    least, most = [], []  # what surely belongs, and what may by rounding
    for edge in edges[:count]:
        direction = edge >> 20
        y, x = divmod(edge & 0xFFFFF, width)
        x, y = 16 * x - cx, 16 * y - cy
        angle = 2 * math.pi * direction / 48
        along = x * math.cos(angle) + y * math.sin(angle)
        off = abs(x * math.sin(angle) - y * math.cos(angle))
        if along < 0:
            along, direction = half_line - along, (direction + 24) % 48
        else:
            along -= half_line
        near = max(abs(x), abs(y))
        if near < reach and off < slack - 2 and 2 < along < reach - 2:
            least.append((along, direction))
        if near < reach and off < slack + 2 and -2 < along < reach + 2:
            most.append((along, direction))
    found = [(value & 0xFFFF, value >> 16) for value in after[9][:result]]
    if result < radii[at.RADII_CAPACITY]:
        assert len(least) <= result <= len(most)
        for distance, direction in least:
            assert any(abs(one - distance) <= 2 and other == direction for one, other in found)
    for distance, direction in found:
        assert any(abs(one - distance) <= 2 and other == direction for one, other in most)


def choose_radius(before, after, result):
    _, _, _, radii, distances, count, _, rounds, _ = before
    if not count:
        assert result == 0
        return
    found = numbers(after[8])
    angles = 2 * np.pi * (numbers(distances, count) >> 16) / 48
    lengths = numbers(distances, count) & 0xFFFF
    if rounds == 1:  # no shift has been taken into account
        bins = np.bincount(lengths // 8, minlength=radii[at.RADII_BINS] + 3)
        kernel = (1, 1, 2, 1, 1)

        def edges_near(place):
            return int(np.minimum(255, bins[place - 2 : place + 3]) @ kernel)

        best, radius = -1, 0
        for place in range(radii[at.RADII_FIRST], radii[at.RADII_LAST] + 1):
            outer = edges_near(place)
            inner = edges_near((place * radii[at.RADII_INNER_Q10] + 512) >> 10)
            score = outer + (inner if inner <= outer else outer + (inner - outer) // 4)
            if score > best:
                best, radius = score, 8 * place + 4
        inner = (radius * radii[at.RADII_INNER_Q10] + 512) >> 10
        off = np.where(np.abs(lengths - radius) <= 40, lengths - radius, lengths - inner)
        on_outer = np.abs(lengths - radius) <= 40
        on_inner = ~on_outer & (np.abs(lengths - inner) < 32)
        on = on_outer | on_inner
        assert (found[3], found[4]) == (on_outer.sum(), on_inner.sum()) and result == on.sum()
        assert abs(found[0] - radius - off[on].mean()) <= 1
        close(
            found[1:3],
            (2 * (off[on] * np.cos(angles[on])).mean(), 2 * (off[on] * np.sin(angles[on])).mean()),
            2,
        )
    assert result == found[3] + found[4] <= count


def annulus_profile(before, after, result):
    _, _, image, _, _, _, fit, shape, profile = before
    width, height = fit[at.FIT_WIDTH], fit[at.FIT_HEIGHT]
    cx, cy = ((fit[k] - BIAS) / 1024 for k in (at.FIT_TRUE_X_Q10, at.FIT_TRUE_Y_Q10))
    if not (0 <= cx < width and 0 <= cy < height):
        assert result == 0
        return
    stride, samples = shape[at.SHAPE_AROUND_STRIDE], shape[at.SHAPE_AROUND_SAMPLES]
    radius = fit[at.FIT_RADIUS_Q8] / 256
    first, last = (radius * shape[k] / 1024 for k in (at.SHAPE_AROUND_FIRST, at.SHAPE_AROUND_LAST))
    found = numbers(after[8])
    assert result == np.count_nonzero(found)
    picture = LOG[numbers(image).reshape(height, width)]
    for slot, k in enumerate(range(0, 256, stride)):
        angle = 2 * math.pi * k / 256
        low = high = 1
        for distance in np.linspace(first, last, samples):
            x, y = cx + distance * math.cos(angle), cy + distance * math.sin(angle)
            if not (1.1 <= x < width - 2.1 and 1.1 <= y < height - 2.1):
                low = None
                break
            # rounding may take the next pixel
            columns = {math.floor(x + 0.5 + e) for e in (-0.06, 0.06)}
            rows = {math.floor(y + 0.5 + e) for e in (-0.06, 0.06)}
            seen = [picture[row, column] for row in rows for column in columns]
            low += min(seen)
            high += max(seen)
        if low is not None and found[slot]:
            assert low <= found[slot] <= high, (k, low, found[slot], high)


def dark_directions(before, after, result):
    profile, _, _, directions, near, far, apart, _, capacity, _ = before
    values = numbers(profile, directions)
    right = np.roll(values, -near) + np.roll(values, -far)
    left = np.roll(values, near) + np.roll(values, far)
    depths = np.where(values > 0, np.maximum(0, np.minimum(left, right) // 2 - values), 0)
    expected, least = [], 1
    while len(expected) < capacity and depths.max() >= least:
        where = int(np.argmax(depths))
        if not expected:
            least = 3 * int(depths[where]) // 8 + 1
        expected.append((where, int(depths[where])))
        depths[np.arange(where - apart, where + apart + 1) % directions] = 0
    assert result == len(expected)
    same(after[9][: 2 * result], [value for pick in expected for value in pick])


def quarter_phase(before, after, result):
    profile, _, _, _, directions, _ = before
    values = numbers(profile, directions)
    assert result == np.count_nonzero(values)
    wave = np.exp(-4j * 2 * np.pi * np.arange(directions) / directions)  # angles are clockwise, y points down
    expected = 16 * (values * wave).sum()
    found = complex(after[5][0] - BIAS, after[5][1] - BIAS)
    # each of the products is rounded down; which way the sine counts does not matter here
    off = min(abs(found - expected), abs(found - expected.conjugate()))
    assert off <= 2 * directions + abs(expected) / 100


def take_sample(before, after, result):
    frame, kept, _, _, step, count, _ = before
    seen = numbers(frame)[: step * (count - 1) + 1 : step]
    different = np.count_nonzero(seen != numbers(kept, count))
    same(after[6], (different, seen.min(), seen.max(), seen.sum()))
    same(after[1][:count], seen)


def code_light(before, after, result):
    positions = numbers(before[1], 8 * at.POSITION_ITEMS).reshape(8, at.POSITION_ITEMS)
    levels = positions[:, at.POSITION_LEVEL]
    between = positions[1::2, 2:4] - BIAS  # where neither line nor bit is
    guards = positions[[0, 1, 3, 5, 7], :2].sum(axis=1)
    expected = [0] * at.LIGHT_ITEMS
    expected[at.LIGHT_LEVEL] = levels.sum() // 8
    expected[at.LIGHT_THIRD] = sorted(levels)[-3]
    expected[at.LIGHT_GUARD] = max(0, guards.max())
    expected[at.LIGHT_STRAY] = np.abs(between.sum(axis=1)).max()
    expected[at.LIGHT_STRAY_HALF] = np.abs(between).max()
    expected[at.LIGHT_ROUGH] = sorted(positions[[0, 1, 3, 5, 7], at.POSITION_ROUGH])[2]
    same(after[0], expected)


# --- medians and other statistics


def median(before, after, result):
    values, _, _, first, count, _ = before
    assert result == sorted(values[first : first + count])[count // 2]


def deepest(before, after, result):
    depths, _, _, directions, apart, _ = before
    where = int(np.argmax(numbers(depths, directions)))
    others = [
        depths[k] for k in range(directions) if apart < (k - where) % directions < directions - apart
    ]  # fmt: skip
    same(after[5], (where, depths[where], max(others)))
    assert result == where


def ink_noise(before, after, result):
    ink, _, _, directions, apart = before
    values = numbers(ink, directions)
    second = np.abs(2 * values - np.roll(values, -apart) - np.roll(values, apart))
    limit = 1 << 20
    for _ in range(4):
        kept = second[second < limit]
        limit = 3 * kept.sum() // (len(kept) + 1) + 3
    assert result == kept.sum() // (len(kept) + 1)


def sector_levels(before, after, result):
    sectors, _, _, amplitude, background, least_match, wide, local, _ = before
    amplitudes, backgrounds, matches = numbers(sectors).reshape(3, 32)
    good = (matches >= least_match) & (5 * amplitudes >= 2 * amplitude) & (amplitudes <= 2 * amplitude)
    assert result == good.sum()
    for sector in range(32):
        window = np.arange(sector - wide, sector + wide + 1) % 32
        counted = window[good[window]]
        expected = (amplitude, background)
        if local and len(counted) > wide:
            expected = amplitudes[counted].sum() // len(counted), backgrounds[counted].sum() // len(counted)
        assert (after[8][sector], after[8][32 + sector]) == expected, sector


# --- rings of the direct reader


def begin_pass(before, after, result):
    fit, limit = before
    x, y = ((fit[k] - BIAS + 2) // 4 for k in (at.FIT_X_Q10, at.FIT_Y_Q10))
    radius = fit[at.FIT_RADIUS_Q8]
    inside = 0 <= x < 256 * fit[at.FIT_WIDTH] and 0 <= y < 256 * fit[at.FIT_HEIGHT]
    assert result == (inside and radius >= 1536)
    if not result:
        return
    found = after[0]
    gap = radius * fit[at.FIT_GAP_Q10] / 1024
    window = found[at.FIT_WINDOW_Q8]
    # at least 300 and at most the gap, from 640 on an eighth less, at most 14 px
    expected = max(300, gap) if gap <= 640 else min(3584, max(640, gap * 7 / 8))
    assert abs(window - expected) <= 2
    assert (found[at.FIT_X_Q8], found[at.FIT_Y_Q8]) == (x, y)
    assert abs(found[at.FIT_LIMIT_Q10] - window * limit / 64) <= 1
    line = radius * fit[at.FIT_LINE_Q10] / 1024
    area = fit[at.FIT_AREA]
    if area:
        assert abs(found[at.FIT_LEAST_AREA] - area * 3 / 8) <= 1
        assert abs(found[at.FIT_CLIP] - 32 * area / line) <= 1 + area / line
    else:
        assert found[at.FIT_CLIP] == 8 and abs(found[at.FIT_LEAST_AREA] - line * 12 / 256) <= 1


def skip_half_sectors(before, after, result):
    _, _, bits, code, least, angle, reach, outer, inner = before
    expected = [0] * 32
    marked = {outer: 0, inner: 0}
    for line in range(4 if bits else 0):
        near, far = (code[2 * line * at.POSITION_ITEMS + k] - BIAS for k in (2, 3))
        if line and near + far <= least:
            continue
        turned = (angle - line * 16384) % 65536  # counterclockwise as seen
        for k in range((turned - reach) // 2048, (turned + reach) // 2048 + 1):
            expected[k % 32] |= inner if line else outer
            marked[inner if line else outer] += 1
    same(after[0], expected)
    assert result == marked[outer] + 64 * marked[inner]


def _ring_model(ring, angles):
    a0, a1, b1, a2, b2 = (ring[k] - BIAS for k in range(5))
    model = a0 + a1 * np.cos(angles) + b1 * np.sin(angles)
    return model + a2 * np.cos(2 * angles) + b2 * np.sin(2 * angles)


def ring_harmonics(before, after, result):
    _, _, _, sectors, _, _, _, rounds, floor, _, _ = before
    angles = 2 * np.pi * (np.arange(16) + 0.5) / 16
    holds = True
    for ring, found in enumerate((after[9], after[10])):
        tried, areas, counted, sums = numbers(sectors)[64 * ring : 64 * ring + 64].reshape(16, 4).T
        inside = tried > 0
        usable = inside & (2 * counted >= tried) & (sums // np.maximum(1, counted) > 0)
        assert found[at.RING_INSIDE] == inside.sum()
        means = np.where(usable, sums // np.maximum(1, counted) - 32768, 0)
        mean_areas = np.where(inside, areas // np.maximum(1, tried) + 1, 0)
        if usable.any():
            assert found[at.RING_MEAN_AREA] == mean_areas[usable].sum() // usable.sum()
        holds = holds and found[at.RING_USED] >= 5 and 2 * found[at.RING_USED] >= inside.sum()
        assert found[at.RING_USED] <= usable.sum()
        if not usable.all() or rounds < 3:
            continue
        design = np.stack(
            (np.ones(16), np.cos(angles), np.sin(angles), np.cos(2 * angles), np.sin(2 * angles))
        )
        expected = np.linalg.lstsq(design.T, means, rcond=None)[0]
        off = np.abs(means - expected @ design)
        if off.max() < max(floor, 3.5 * off.mean()) and np.abs(means).max() < 8000:  # nothing is left out
            assert found[at.RING_USED] == 16
            scale = max(4, np.abs(means).max() // 100)  # units are 1/128, so the fit is within a percent
            close([found[k] - BIAS for k in range(5)], expected, scale)
            close(found[at.RING_DEVIATION], off.mean(), scale)
    assert result == holds
    assert not any(after[3])


def end_pass(before, after, result):
    fit, outer, inner = before
    found = after[0]
    x, y = ((outer[k] + inner[k]) / 2 - BIAS for k in (at.RING_COS, at.RING_SIN))
    assert abs(found[at.FIT_X_Q10] - BIAS - 4 * fit[at.FIT_X_Q8] - x) <= 1
    assert abs(found[at.FIT_Y_Q10] - BIAS - 4 * fit[at.FIT_Y_Q8] - y) <= 1
    growth = outer[at.RING_CONSTANT] - BIAS
    assert abs(found[at.FIT_RADIUS_Q8] - fit[at.FIT_RADIUS_Q8] - growth / 4) <= 1
    inner_growth = inner[at.RING_CONSTANT] - BIAS
    assert abs(found[at.FIT_INNER_Q8] - fit[at.FIT_INNER_Q8] - inner_growth / 4) <= 1
    assert abs(found[at.FIT_MOVED_Q10] - max(abs(growth), abs(x), abs(y))) <= 1
    assert found[at.FIT_AREA] == (outer[at.RING_MEAN_AREA] + inner[at.RING_MEAN_AREA]) // 2
    ratio = fit[at.FIT_INNER_Q10] / 1024
    for item, bulge in ((at.RING_COS_2, at.FIT_BULGE_COS), (at.RING_SIN_2, at.FIT_BULGE_SIN)):
        expected = (outer[item] - BIAS + (inner[item] - BIAS) / ratio) / 2
        assert abs(found[bulge] - fit[bulge] - expected) <= 2
    apart = [outer[k] - inner[k] for k in (at.RING_COS, at.RING_SIN)]
    assert result == (max(map(abs, apart)) < 3000)
    if not result:
        return
    deviations = [min(3200, ring[at.RING_DEVIATION]) for ring in (outer, inner)]
    noise = sum(d * d for d in deviations) * 50 / 128 + 4
    prior = (found[at.FIT_RADIUS_Q8] / 16) ** 2 * 32 / 230400
    signal = max(sum(d * d for d in apart) - noise, prior * prior)
    weight = fit[at.FIT_BEYOND_Q8] / 256 * signal / (signal + noise)
    for k, true, mean in (
        (0, at.FIT_TRUE_X_Q10, at.FIT_X_Q10),
        (1, at.FIT_TRUE_Y_Q10, at.FIT_Y_Q10),
    ):
        expected = -apart[k] * weight
        assert abs(found[true] - found[mean] - expected) <= 3 + abs(expected) / 25


# --- the model of blur


def _line_through(width, motion, sigma, distances):
    """Darkness (of 1024) at distances from the middle of a blurred line, by summing up a fine picture."""
    step = 4.0
    x = np.arange(-8192, 8193) * step
    line = (np.abs(x) <= width / 2).astype(float)
    for box in (max(1.0, motion / step),):
        cells = max(1, round(box))
        line = np.convolve(line, np.ones(cells) / cells, "same")
    reach = int(4 * sigma / step) + 1
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) * step / sigma) ** 2)
    line = np.convolve(line, kernel / kernel.sum(), "same")
    return 1024 * np.interp(distances, x, line)


def blurred_bars(before, after, result):
    _, _, _, width, motion, sigma, _, rel, step, count, slot, bars = before
    expected = numbers(bars)
    for number, one in enumerate(range(rel, 17, step)):
        across = max(256, motion * math.cos(math.pi * one / 32))
        place = slot + 24 * step * number
        profile = _line_through(width, across, sigma, np.arange(count) * 256.0)
        wide = width >= 64 and sigma >= 64  # finer than the oracle's own picture otherwise
        close(after[11][place : place + count], profile, 14 if wide else 1024)
        expected[place : place + count] = after[11][place : place + count]
    same(after[11], expected)  # nothing else is written


def _rings(bar):
    """Darkness of both rings at the units 13..28, and the derivatives of the outer and the inner one."""
    units = np.arange(13, 29)

    def ring(place, shift=0):
        return bar[np.abs(units - place + shift)]

    both = ring(24) + ring(16)
    outer = (ring(24, 1) - ring(24, -1)) // 2
    inner = (ring(16, 1) - ring(16, -1)) // 2
    return both, outer, inner


def ring_templates(before, after, result):
    bars, _, _, rel, step, _, _ = before
    for one in range(rel, 17, step):
        bar = numbers(bars)[24 * one : 24 * one + 24]
        found = numbers(after[5])[48 * one : 48 * one + 48].reshape(3, 16) - 32768
        for kind, profile in enumerate(_rings(bar)):
            close(found[kind], profile - profile.mean(), 1)
            assert found[kind].sum() == 0
            assert after[6][8 * one + kind] == (found[kind] ** 2).sum()
        assert after[6][8 * one + 3] == (found[1] * found[2]).sum() + (1 << 28)
        assert after[6][8 * one + 4] == _rings(bar)[0].sum() // 16


def fold_templates(before, after, result):
    bars, _, _, rel, step, _, _ = before
    for one in range(rel, 17, step):
        bar = numbers(bars)[24 * one : 24 * one + 24]
        both = _rings(bar)[0]
        # the unit 20 + d looks like 20 - d; 28 has no counterpart
        same(after[5][48 * one : 48 * one + 9], both[7:])
        assert after[6][8 * one + 5] == both.sum() and after[6][8 * one + 6] == both[7:].sum()
        assert abs(after[6][8 * one] - ((both - both.mean()) ** 2).sum()) <= 1


def fold_sectors(before, after, result):
    _, _, means, sectors, _, _ = before
    pairs = numbers(means, 32 * sectors).reshape(sectors, 2, 16).sum(axis=1) - 65536
    for sector in range(sectors):
        pair = pairs[sector]
        expected = [pair[7] + 16384]
        expected += [pair[7 + k] + pair[7 - k] + 16384 for k in range(1, 8)]
        expected += [pair[15] + 16384, pair.sum()]
        same(numbers(after[4])[10 * sector : 10 * sector + 9], [value & 65535 for value in expected[:9]])
        assert after[4][10 * sector + 9] == expected[9] & 65535
        assert after[5][sector] == ((pair // 2) ** 2).sum() + 16


def _match(fold, power, template, square):
    """Squared correlation (of 1024) of a folded sector with a folded template; 0 for bright rings."""
    fold = np.asarray(fold, float) - 16384
    template = np.asarray(template, float)
    weights = np.array([1] + [2] * 7 + [1])
    mean = (template * weights).sum() / 16
    # a fold adds up what belongs to the same item
    product = -(fold * (template - mean)).sum() / 2
    if product <= 0 or square <= 0:
        return 0
    return min(1024, 1024 * product * product / (square * power))


def match_sectors(before, after, result):
    _, _, folds, templates, sectors, powers, sums, rel, step, _ = before
    for one in range(rel, 17, step):
        for sector in range(sectors):
            found = after[9][one * sectors + sector]
            fold = folds[10 * sector : 10 * sector + 9]
            template = templates[48 * one : 48 * one + 9]
            expected = _match(fold, powers[sector], template, sums[8 * one])
            assert abs(found - expected) <= 24 + expected / 20, (one, sector, found, expected)


def best_direction(before, after, result):
    _, _, matches, sectors, step, offset, floor, direction, pitch, _ = before
    best = (-1, None)
    for one in range(direction, 32, pitch):
        rels = [(offset + sector * step - one) % 32 for sector in range(sectors)]
        rels = [min(rel, 32 - rel) for rel in rels]
        total = sum(max(floor, matches[rel * sectors + sector]) for sector, rel in enumerate(rels))
        if total > best[0]:
            best = total, one
    assert (result, after[9][0]) == best


def match_direction(before, after, result):
    folds, _, _, templates, sectors, powers, sums, step, offset, motion_axis, floor = before
    expected = 0
    for sector in range(sectors):
        rel = (offset + sector * step - motion_axis) % 32 if motion_axis < at.STILL else 0
        rel = min(rel, 32 - rel)
        fold = folds[10 * sector : 10 * sector + 9]
        match = _match(fold, powers[sector], templates[48 * rel : 48 * rel + 9], sums[8 * rel])
        expected += max(floor, match)
    assert abs(result - expected) <= 8 * sectors + expected / 20


# --- the blur-model reader: samples


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


# --- the blur-model reader: lines and code


def _bar(bars, entry, distance):
    """The darkness at a distance (1/256 unit) from the middle of a line."""
    distance = abs(distance) / 256
    if distance >= 23:
        return 0.0
    return float(np.interp(distance, np.arange(24), numbers(bars)[entry : entry + 24]))


def _darkness(bars, across, middle, unit, angle):
    """Of a blurred radial line (1/1024) at a unit in a direction from the line's."""
    x, y = 256 * unit * math.cos(angle), 256 * unit * math.sin(angle)
    return _bar(bars, across, y) * _bar(bars, at.ALONG, x - middle) / 1024


def line_template(before, after, result):
    bars, _, _, across, middle, _, fan, zones, zone, _, slot = before
    directions, step = fan[at.FAN_DIRECTIONS] // 2 + 1, fan[at.FAN_STEP]
    first, count = fan[at.FAN_FIRST] + zones[zone], zones[zone + 1]
    found = numbers(after[9])[slot : slot + directions]
    expected = []
    for k in range(directions):
        angle = 2 * math.pi * k * step / 256
        expected.append(np.mean([_darkness(bars, across, middle, first + i, angle) for i in range(count)]))
    ended = np.flatnonzero(found == 0)
    end = ended[0] if len(ended) else directions
    close(found[:end], expected[:end], 5)
    assert end == directions or (expected[end] < 8 and not found[end:].any())
    assert result == max(0, end - 1)


def erase_line(before, after, result):
    samples, _, _, across, middle, bars, _, fan, cosine, sine, amplitude, reach = before
    directions, step, start, first, count = fan
    turned = math.atan2(sine, cosine)
    brighter = (numbers(after[0]) - numbers(samples)) & 65535
    for k in range(directions):
        angle = 2 * math.pi * (k * step + start) / 256 - turned
        for i in range(count):
            y = 256 * (first + i) * math.sin(angle)
            expected = 0.0
            if math.cos(angle) > 0 and abs(y) < reach:
                expected = _darkness(bars, across, middle, first + i, angle) * amplitude / 1024
            off = abs(brighter[k * count + i] - expected)
            assert off <= 3 + 0.012 * amplitude, (k, i, brighter[k * count + i], expected)


def ink_profile(before, after, result):
    samples, _, _, fan, zones, zone, levels, angle, bars, motion_axis, _, _ = before
    directions, step, _, first, pitch = fan
    offset, count, slot = zones[zone : zone + 3]
    for k in range(directions):
        direction = angle + 2 * step * k
        rel = ((direction - 8 * motion_axis + 4) // 8) % 32 if motion_axis < at.STILL else 0
        rel = min(rel, 32 - rel)
        skirt = 0
        for unit in range(first + offset, first + offset + count):
            for ring in (24, 16):
                if abs(unit - ring) < 24:
                    skirt += bars[24 * rel + abs(unit - ring)]
        seen = numbers(samples)[k * pitch + offset : k * pitch + offset + count].mean()
        sector = direction // 16 % 32
        amplitude = levels[sector]
        ink = (levels[32 + sector] - seen) * 1024 / max(amplitude, 0.25) - skirt / count
        found = after[10][slot + k] - 32768
        if abs(ink) < 8000 and amplitude > 8:
            assert abs(found - ink) <= 4 + abs(ink) / 40, (k, found, ink)
        assert abs(found) <= 8191


def _template_at(templates, base, offsets):
    return numbers(templates)[base + np.abs(offsets)]


def line_depths(before, after, result):
    _, _, ink, fan, templates, angle, motion_axis, first, last, _ = before
    directions, step = fan[at.FAN_DIRECTIONS], 2 * fan[at.FAN_STEP]
    values = numbers(ink) - 32768
    for k in range(first, last + 1):
        rel = ((angle + k * step - 8 * motion_axis + 4) // 8) % 32 if motion_axis < at.STILL else 0
        base = 15 * (min(rel, 32 - rel) // 2)
        expected = -16383.0
        if 4 * values[k] >= templates[base]:
            fits = []
            for start in (-9, -2):  # to either side, and the line itself
                offsets = np.arange(start, start + 12)
                template = _template_at(templates, base, offsets)
                template = template - template.sum() // 12
                seen = values[(k + offsets) % directions]
                square = (template**2).sum() + 64
                fits.append(256 * (template * (seen - seen.mean())).sum() / square)
            expected = min(fits)
        found = after[9][k] - 32768
        expected = max(-16383, min(16383, expected))
        assert abs(found - expected) <= 8 + abs(expected) / 50, (k, found, expected)


def line_residual(before, after, result):
    ink, _, _, templates, base, half, middle, depth = before
    offsets = np.arange(-half, half + 1)
    left = numbers(ink)[middle + offsets] - 32768 - depth * _template_at(templates, base, offsets) / 256
    assert abs(result - np.abs(left - left.mean()).mean()) <= 2


def line_turn(before, after, result):
    ink, _, _, templates, base, half, middle, _ = before
    k = np.arange(1, half + 1)
    seen = numbers(ink)
    odd = (seen[middle + k] - seen[middle - k]) // 2
    slope = (_template_at(templates, base, k - 1) - _template_at(templates, base, k + 1)) // 2
    # the part of both that is no linear trend
    slope_left = slope - k * (k @ slope) / (k @ k)
    square = max(64, slope_left @ slope_left + 64)
    offsets = np.arange(-half, half + 1)
    template = _template_at(templates, base, offsets)
    template = template - template.mean()
    even = (template * (seen[middle + offsets] - 32768)).sum() * 256 / (template @ template + 64)
    step = 256 * 256 * (odd @ slope_left) / square / max(16, even)
    found = after[7][0] - 1048576
    if even > 64 and abs(step) < 60000:
        assert abs(found - step) <= 24 + abs(step) / 8, (found, step)
    assert abs(found) <= 65536


def _code_design(templates, axes, reach):
    """What each of eight lines adds to the ink of two zones of 64 directions, and a constant."""
    design = np.zeros((9, 2, 64))
    for p in range(8):
        for zone in range(2):
            for k in range(-reach, reach + 1):
                template = templates[((p % axes) * 2 + zone) * 33 + abs(k)]
                design[p, zone, (8 * p + k) % 64] = template / 256
    design[8] = 1
    return design.reshape(9, 128)


def fit_code(before, after, result):
    ink, _, _, templates, axes, reach, _, _, _, _ = before
    seen = np.clip(numbers(ink) - 32768, -2047, 2047)
    same(after[0], seen + 32768)
    amounts = numbers(after[9])[:9] - 65536
    empty = sorted(amounts[p] for p in (0, 1, 3, 5, 7))
    assert after[9][9] - 65536 == empty[2]
    design = _code_design(templates, axes, reach)
    best = np.linalg.lstsq(design.T, seen, rcond=None)[0]
    left = ((seen - amounts @ design) ** 2).sum()
    if np.abs(best).max() < 900:
        assert left <= 1.1 * ((seen - best @ design) ** 2).sum() + 128 * 16
    assert np.abs(amounts).max() <= 1023


def code_residuals(before, after, result):
    ink, _, _, templates, axes, reach, amounts, _ = before
    design = _code_design(templates, axes, reach)
    left = numbers(ink) - 32768 - (numbers(amounts)[:9] - 65536) @ design
    left = left.reshape(2, 64)
    for p in (2, 4, 6):
        cells = [
            left[zone, 8 * p - 4 + 3 * c : 8 * p - 1 + 3 * c].mean() for zone in (0, 1) for c in range(3)
        ]
        assert abs(after[7][p] - max(map(abs, cells))) <= 6, (p, after[7][p], cells)


def local_depths(before, after, result):
    area, _, angle, is_faint, means, depths = before
    hidden = {sector for sector in range(16) if not is_faint and 0 < means[16 + sector] < area // 2}
    faded = (numbers(depths) > BIAS + 154).sum() >= 4
    expected = 0
    for cell in range(24):
        degrees = 90 * (cell // 6) + (18.5, 27.5, 36.5, 53.5, 62.5, 71.5)[cell % 6]
        place = (angle / 65536 - degrees / 360) % 1 * 16
        nearest = {math.floor(place - 0.5) % 16, math.floor(place + 0.5) % 16}
        expected |= bool(nearest & hidden) << cell
        seen = [means[16 + sector] for sector in nearest if means[16 + sector]]
        share = sum(seen) / len(seen) / max(1, area) if seen else 1
        depth = depths[cell] - BIAS
        if faded and depth > -(1 << 20) and share < 15 / 16:
            depth = depth / max(share, (190 if nearest & hidden else 110) / 256)
        assert abs(after[5][cell] - BIAS - depth) <= 2 + abs(depth) / 90
    assert result == expected


def word_costs(weights, lines):
    """What each ID's word costs that has one, infinite for the others; ID 0 is the empty word."""
    told = (np.roll(numbers(weights, 24), -lines[3]) - BIAS)[None, :]
    dark = WORDS[:, None] >> np.arange(24) & 1
    costs = (np.abs(told) * (dark != (told > 0))).sum(axis=1)
    ids = np.arange(4096)
    for bit in range(3):
        line = lines[bit] - BIAS
        costs = costs + abs(line) * ((ids >> bit & 1) != (line > 0)) * (ids > 0)
    used = ((ids > 7) & (ids & 7 > 0) & (ids != 4095)) | (ids == 0)
    return np.where(used, costs, 1 << 29)


def certain_word(before, after, result):
    costs = word_costs(before[3], before[5])
    told, cost, second, contradicted, blank = numbers(after[6], 5)
    best = int(np.argmin(costs))
    if result:
        assert (told, cost) == (best, costs[best])
        assert second <= np.sort(costs)[1] and second - cost >= 192
        assert contradicted <= 1 and blank == sum(weight == BIAS for weight in before[3][:24])
    else:  # none that is beyond doubt is left to the search
        clear = all(abs(weight - BIAS) >= 64 for weight in before[3][:24])
        assert not clear or costs[best] > 0


def believed_word(before, after, result):
    """The cheaper of the word and, with lines that were read, plainness; beyond doubt of whatever else."""
    lines_id, _, turned, weights, (told, cost, second, _, _) = before
    believed = result & 4095
    costs = {told: cost}
    if lines_id:
        costs[0] = weights[25]  # even where the empty word was found, which counts each dark cell
    first = min(costs, key=lambda one: (costs[one], one))
    gap = min([second, *(costs[other] for other in costs if other != first)]) - costs[first]
    if lines_id and first == 0 < told:
        gap = cost - costs[0]
    least = 110 if not lines_id else 78 if first else 80
    if turned:
        least = 78
    quarters = 5 if first else 2
    refused = gap < least or 4 * gap < quarters * costs[first] or (turned and costs[first] > 80)
    if refused or (lines_id and first and first & 7 != lines_id):
        assert result == 0
    else:
        assert believed == first + 1
        assert result >> 12 == min(255, (gap - least) * 255 // 288)


def likeliest_words(before, after, result):
    """What is found is never cheaper than the best, the best itself where it is far from the second."""
    costs = word_costs(before[3], before[5])
    told, cost, second, _, blank = numbers(after[7], 5)
    best, next_best = np.sort(costs)[:2]
    assert cost == (costs[told] if told < 4096 else 1 << 20) and cost >= best
    if next_best - best > 192:
        assert costs[told] == best
    assert blank == sum(weight == BIAS for weight in before[3][:24])


def root(before, after, result):
    assert result == math.isqrt(before[0])


# --- candidates for the blur-model reader


def _candidates(items, count):
    """{(least, x, y): rank} of a list."""
    slots = [items[at.CANDIDATE_ITEMS * k : at.CANDIDATE_ITEMS * (k + 1)] for k in range(count)]
    where = (at.CANDIDATE_LEAST_Q8, at.CANDIDATE_X_Q8, at.CANDIDATE_Y_Q8)
    return {tuple(slot[k] for k in where): slot[at.CANDIDATE_RANK] for slot in slots}


def remember(before, after, result):
    items, _, _, count, capacity, rank, x, y, least, most, verdict = before
    expected = _candidates(items, count)
    near = [
        key for key in expected
        if key[0] == least and abs(key[1] - x) < least // 4 and abs(key[2] - y) < least // 4
    ]  # fmt: skip
    if not any(expected[key] >= rank for key in near):
        if near:
            del expected[near[-1]]
        elif count == capacity and min(expected.values()) < rank:
            del expected[min(expected, key=expected.get)]
        if len(expected) < capacity:
            expected[least, x, y] = rank
    assert _candidates(after[0], result) == expected
    slot = [
        k * at.CANDIDATE_ITEMS for k in range(result)
        if list(after[0][k * at.CANDIDATE_ITEMS :][:4]) == [rank, x, y, least]
    ]  # fmt: skip
    if slot and (least, x, y) not in _candidates(items, count):
        new = after[0][slot[0] : slot[0] + at.CANDIDATE_ITEMS]
        assert new[at.CANDIDATE_MOST_Q8] == most and new[at.CANDIDATE_VERDICT] == verdict
        assert new[at.CANDIDATE_LOOKED] == new[at.CANDIDATE_SCORE] == new[at.CANDIDATE_KIND] == 0


def next_unseen(before, after, result):
    items, _, _, count = before
    ranks = [
        -1 if items[slot + at.CANDIDATE_LOOKED] else items[slot]
        for slot in range(0, at.CANDIDATE_ITEMS * count, at.CANDIDATE_ITEMS)
    ]
    best = max(ranks, default=-1)
    assert result == (ranks.index(best) * at.CANDIDATE_ITEMS if best > 0 else -1)


# --- stream


def unstuff(before, after, result):
    """What CPython does instead, by searching and copying bytes; a CRC of binascii."""
    assert result == _cpython.unstuff(*before)
    for mine, other in zip(before[2:5], after[2:5], strict=True):
        same(mine, other)


def unpack(before, after, result):
    message, _, fields, values, count, place = before
    expected = list(values)
    for k, (size, signed, low, high) in enumerate(np.reshape(fields, (-1, 4)).tolist()):
        value = int.from_bytes(message[place : place + size], "little", signed=bool(signed))
        place += size
        if not (-low if signed else low) <= value <= high:
            assert result == 0
            return
        expected[k] = value
    assert result == 1 and count == len(expected)
    same(after[3], expected)


ORACLES = {
    "stream": (unstuff, unpack),
    "candidates": (remember, next_unseen),
    "cells": (local_depths,),
    "cell_words": (believed_word, certain_word, likeliest_words),
    "robust": (root,),
    "votes": (list_runs, join_runs, cast_votes, clear_cells, find_windows, rank_centres),
    "edges": (gradient_histogram, edge_threshold, steep_positions, thin_line_edges),
    "grey": (count_greys, take_sample),
    "coarse": (edge_distances, choose_radius),
    "directions": (annulus_profile, dark_directions, quarter_phase),
    "rings": (begin_pass, skip_half_sectors),
    "harmonics": (ring_harmonics, end_pass),
    "blur": (
        blurred_bars, ring_templates, fold_templates, fold_sectors, match_sectors, best_direction,
        match_direction,
    ),
    "polar": (polar_samples, circle_samples, mean_samples, sector_radii, line_shade),
    "code_rules": (code_light,),
    "sectors": (ring_shifts, shift_harmonics, median, sector_levels),
    "blurred_lines": (
        line_template, erase_line, ink_profile, line_depths, deepest, line_residual, ink_noise, line_turn,
    ),
    "blurred_code": (fit_code, code_residuals),
}  # fmt: skip
ORACLES = {
    "%s.%s" % (module, oracle.__name__): oracle for module, several in ORACLES.items() for oracle in several
}
