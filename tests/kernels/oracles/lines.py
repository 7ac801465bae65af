"""The blur-model reader's lines and code, and the words of cells."""

import math

import numpy as np

from larics.kernels import layouts as at

from .compare import BIAS, WORDS, close, numbers, same


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
    told, cost, second = numbers(after[6], 3)
    best = int(np.argmin(costs))
    if result:
        assert (told, cost) == (best, costs[best])
        assert second <= np.sort(costs)[1] and second - cost >= 192
    else:  # none that is beyond doubt is left to the search
        clear = all(abs(weight - BIAS) >= 64 for weight in before[3][:24])
        assert not clear or costs[best] > 0


def believed_word(before, after, result):
    """The cheaper of the word and, with lines that were read, plainness; beyond doubt of whatever else."""
    lines_id, _, turned, weights, (told, cost, second) = before
    more = max(0, 8 * (weights[27] - 4), 16 * (weights[28] - 10))
    believed = result & 4095
    costs = {told: cost}
    doubt = lines_id >> 3
    least = 110
    if 0 < doubt < 7:
        least = 78 + 2 * cost
        if told and (told ^ lines_id) & ~doubt & 7:
            assert result == 0
            return
    if doubt:
        lines_id = 0
    if lines_id:
        costs[0] = weights[25]  # even where the empty word was found, which counts each dark cell
    first = min(costs, key=lambda one: (costs[one], one))
    gap = min([second, *(costs[other] for other in costs if other != first)]) - costs[first]
    if lines_id and first == 0 < told:
        gap = cost - costs[0]
    if lines_id:
        least = min(78, 48 + costs[first]) + more if first else 45
    if turned:
        least = 78
    quarters = 7 if first else 2
    refused = gap < least or 4 * gap < quarters * costs[first] or (turned and costs[first] > 80)
    if refused or (lines_id and first and first & 7 != lines_id):
        assert result == 0
    else:
        assert believed == first + 1
        assert result >> 12 == min(255, (gap - least) * 255 // 288)


def likeliest_words(before, after, result):
    """What is found is never cheaper than the best, the best itself where it is far from the second."""
    costs = word_costs(before[3], before[5])
    told, cost, second = numbers(after[7], 3)
    best, next_best = np.sort(costs)[:2]
    assert cost == (costs[told] if told < 4096 else 1 << 20) and cost >= best
    if next_best - best > 192:
        assert costs[told] == best


def root(before, after, result):
    assert result == math.isqrt(before[0])


ORACLES = {
    "blurred_lines": (
        line_template,
        erase_line,
        ink_profile,
        line_depths,
        line_residual,
        line_turn,
    ),
    "blurred_code": (
        fit_code,
        code_residuals,
    ),
    "cells": (local_depths,),
    "cell_search": (
        certain_word,
        likeliest_words,
    ),
    "cell_words": (believed_word,),
    "robust": (root,),
}
