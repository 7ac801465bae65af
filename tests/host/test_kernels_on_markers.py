"""The kernels that measure rings and lines, on a marker drawn with floating point, whose truth is known."""

import math
from array import array

import numpy as np
import pytest

from larics.arith import fixed, tables
from larics.kernels import code, harmonics, layouts, lines, rings

SIZE = 160
RADIUS, WIDTH = 30.0, 3.5  # px
BIAS = layouts.BIAS


def drawn(cx, cy, angle, bits=(2, 6), line_end=46.0, code_end=16.0, shadow=1.0):
    """A frame with rings, an orientation line and coding lines (positions counterclockwise from it).

    shadow: how bright what lies clockwise of the orientation line and of the opposite direction is."""
    fine = 6
    grid = (np.arange(SIZE * fine) + 0.5) / fine - 0.5
    x, y = np.meshgrid(grid - cx, grid - cy)
    distance = np.hypot(x, y)
    dark = np.abs(distance - RADIUS) < WIDTH / 2
    dark |= np.abs(distance - RADIUS * 2 / 3) < WIDTH / 2
    for position in (0, *bits):
        turn = angle - position * math.pi / 4  # clockwise, as y points down
        along = x * math.cos(turn) + y * math.sin(turn)
        across = np.abs(y * math.cos(turn) - x * math.sin(turn))
        first, last = (5.0, code_end) if position else (RADIUS, line_end)
        dark |= (across < WIDTH / 2) & (along > first) & (along < last)
    light = np.where(y * math.cos(angle) - x * math.sin(angle) > 0, shadow, 1.0)
    picture = (np.where(dark, 60.0, 200.0) * light).reshape(SIZE, fine, SIZE, fine).mean(axis=(1, 3))
    return fixed.frame_view(picture.round().astype(np.uint8).tobytes())


def pose(cx, cy, radius=RADIUS, area=0):
    fit = array("i", [0] * layouts.FIT_ITEMS)
    for x, y in ((layouts.FIT_X_Q10, layouts.FIT_Y_Q10), (layouts.FIT_TRUE_X_Q10, layouts.FIT_TRUE_Y_Q10)):
        fit[x], fit[y] = round(cx * 1024) + BIAS, round(cy * 1024) + BIAS
    fit[layouts.FIT_RADIUS_Q8], fit[layouts.FIT_INNER_Q8] = round(radius * 256), round(radius * 256 * 2 / 3)
    fit[layouts.FIT_BULGE_COS] = fit[layouts.FIT_BULGE_SIN] = BIAS
    fit[layouts.FIT_AREA] = area
    fit[layouts.FIT_INNER_Q10], fit[layouts.FIT_LINE_Q10], fit[layouts.FIT_GAP_Q10] = 683, 119, 170
    fit[layouts.FIT_BEYOND_Q8] = 333
    fit[layouts.FIT_WIDTH] = fit[layouts.FIT_HEIGHT] = SIZE
    return fit


def ink():
    """Darkness times width of a line, log units * px, if no pixel were grey."""
    return round((fixed.log_grey(200) - fixed.log_grey(60)) * WIDTH)


def crossed(frame, fit):
    """One pass: the harmonics of both rings, and the number of crossings tried."""
    assert rings.begin_pass(fit, 256) == 1
    sectors = array("i", [0] * 128)
    tried = rings.ring_crossings(
        0, 0, 0, frame, fixed.LOG_GREY, fit, 24, fixed.ROOT, bytearray(32), sectors
    )  # fmt: skip
    outer, inner = (array("i", [0] * layouts.RING_ITEMS) for _ in range(2))
    means = array("i", [0] * 32), array("i", [0] * 32)
    assert harmonics.ring_harmonics(
        0, 0, 0, sectors, means[0], means[1], tables.HARMONICS_4, 8, 96, outer, inner
    )  # fmt: skip
    return outer, inner, tried


def fitted(frame, cx, cy):
    """The pose after two passes, the second of which knows how dark the rings are."""
    fit = pose(cx, cy)
    for _ in range(2):
        outer, inner, _ = crossed(frame, fit)
        assert harmonics.end_pass(fit, outer, inner)
    return fit


@pytest.mark.parametrize("off_x, off_y, grown", [(0, 0, 0), (0.6, -0.4, 0), (0, 0, 0.8), (-0.5, 0.7, -0.6)])
def test_crossings_tell_where_the_rings_are(off_x, off_y, grown):
    cx, cy = 80.3, 77.6
    frame = drawn(cx, cy, 1.0)
    fit = pose(cx - off_x, cy - off_y, RADIUS - grown)
    outer, inner, tried = crossed(frame, fit)
    assert tried > 100
    for ring, size in ((outer, 1.0), (inner, 2 / 3)):
        found = [(ring[k] - BIAS) / 1024 for k in range(3)]
        assert found == pytest.approx([grown * size, off_x, off_y], abs=0.08)
        assert ring[layouts.RING_INSIDE] == 16
        assert ring[layouts.RING_MEAN_AREA] == pytest.approx(ink(), rel=0.25)


def shape():
    found = array("i", [0] * layouts.SHAPE_ITEMS)
    for name, millimetres in (
        ("LINE_FIRST", 164), ("LINE_LAST", 222), ("WINDOW", 25), ("LINE", 17.5), ("IN_LINE", 190),
        ("BEYOND", 240), ("BESIDE", 19), ("CODE_FIRST", 37), ("CODE_LAST", 78),
    ):  # fmt: skip
        found[getattr(layouts, "SHAPE_" + name)] = round(millimetres * 1024 / 150)
    found[layouts.SHAPE_CODE_RADII], found[layouts.SHAPE_CODE_OPENING] = 4, 104
    return found


@pytest.mark.parametrize("degrees", [0, 17, 45, 100, 190, 305])
def test_crossings_of_the_orientation_line(degrees):
    angle = math.radians(degrees)
    frame = drawn(80.3, 77.6, angle)
    fit = fitted(frame, 80.3, 77.6)
    line = array("i", [0] * layouts.CROSSING_ITEMS)
    for off in (-2.5, 0, 2.0):
        turn16 = round((degrees + off) * 65536 / 360) % 65536
        arguments = (frame, fixed.LOG_GREY, fixed.COSINE, fit, shape(), turn16, 3, array("i", [0] * 32), line)
        assert lines.line_crossings(0, 0, 0, *arguments) >= 3
        found = line[layouts.CROSSING_ANGLE] * 360 / 65536
        assert (found - degrees + 180) % 360 - 180 == pytest.approx(0, abs=0.3), (degrees, off)
        assert line[layouts.CROSSING_AREA] == pytest.approx(256, rel=0.15)
        assert line[layouts.CROSSING_GAP] == 0 and line[layouts.CROSSING_OUTSIDE] == 0
    # nothing is there a quarter turn away
    turn16 = round((degrees + 90) * 65536 / 360) % 65536
    arguments = (frame, fixed.LOG_GREY, fixed.COSINE, fit, shape(), turn16, 1, array("i", [0] * 32), line)
    lines.line_crossings(0, 0, 0, *arguments)
    assert line[layouts.CROSSING_COUNTED] == 0 and line[layouts.CROSSING_GAP] == 256


@pytest.mark.parametrize("line_end, expected", [(46.0, 0), (60.0, 256)])
def test_what_lies_beyond_the_line(line_end, expected):
    for degrees in (10, 130, 250):
        frame = drawn(80.3, 77.6, math.radians(degrees), line_end=line_end)
        turn16 = round(degrees * 65536 / 360)
        found = lines.line_end(
            0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, pose(80.3, 77.6), shape(), turn16
        )  # fmt: skip
        assert found == pytest.approx(expected, abs=24)


@pytest.mark.parametrize("bits", [(), (2,), (4, 6), (2, 4, 6)])
def test_positions_inside_the_rings(bits):
    for degrees in (0, 33, 200):
        frame = drawn(80.3, 77.6, math.radians(degrees), bits)
        found = array("i", [0] * (8 * layouts.POSITION_ITEMS))
        turn16 = round(degrees * 65536 / 360)
        assert code.code_positions(
            0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, fitted(frame, 80.3, 77.6), shape(), turn16, found
        )  # fmt: skip
        for position in range(8):
            near, far, near_mean, far_mean, level, rough = found[6 * position : 6 * position + 6]
            for area in ((near_mean + far_mean) / 2 - BIAS, (near + far) / 2):
                if position in bits:
                    assert 170 <= area <= 300, (degrees, position, area)
                else:
                    assert -20 <= area <= 40, (degrees, position, area)
            assert level == pytest.approx(fixed.log_grey(200), abs=30)
            assert rough > 2000 if position in bits else rough < 60
    fit = pose(6, 77.6, area=ink())
    assert not code.code_positions(
        0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, fit, shape(), 0, found
    )  # fmt: skip


@pytest.mark.parametrize("code_end, shadow", [(16.0, 1.0), (28.0, 1.0), (16.0, 0.5)])
def test_what_goes_on_between_the_rings(code_end, shadow):
    between = shape()
    between[layouts.SHAPE_BEYOND] = 853
    positions = array("i", [0] * (8 * layouts.POSITION_ITEMS))
    for degrees in (0, 33, 200):
        # position 4 lies on the shadow's edge
        frame = drawn(80.3, 77.6, math.radians(degrees), (2, 4), code_end=code_end, shadow=shadow)
        turn16 = round(degrees * 65536 / 360)
        for position in (2, 4, 6):
            for slot in range(layouts.POSITION_NEAR_MEAN, len(positions), layouts.POSITION_ITEMS):
                positions[slot] = BIAS + 125
                positions[slot + 1] = BIAS + (125 if slot // layouts.POSITION_ITEMS == position else 124)
            found = code.stroke_beyond(
                0, 0, 0, frame, fixed.LOG_GREY, fixed.COSINE, pose(80.3, 77.6, area=ink()), between, turn16,
                positions,
            )  # fmt: skip
            if code_end > 20 and position < 6:
                assert 210 <= found <= 300, (degrees, position)
            else:
                assert found <= 20, (degrees, position)
