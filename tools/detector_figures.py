"""Pictures that take one frame through the detector: `python tools/detector_figures.py [FOLDER]`.

They go to docs/detector by default. What they show is what the detector's own modules hold after each step.

frame.png    the frame                       edges.png    step 1: points with a gradient, and thin dark lines
votes.png    step 2: candidate centres       rings.png    step 3: the fit of both rings
lines.png    step 4: orientation and code    cells.png    step 5: the cells
margin.png   step 6: each rule's distance    blurred.png  a frame that only the blur-model reader reads
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image

from larics.detect.detector import Detector
from larics.kernels import layouts
from larics.marker import CELL_CDEG, CELLS_OF_GROUP, GROUPS_CDEG, verdicts
from larics_host.detection.detectors import as_dict
from larics_host.images.drawing import draw_detections
from larics_host.render import render_frame

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of a backend without a screen)

ROOT = Path(__file__).resolve().parent.parent
SHARP = {"preset": "sunny", "seed": 5003, "index": 11, "family": "coded"}
BLURRED = {"preset": "double", "seed": 5001, "index": 3, "blur_px": 9.0}
RADII_PX = (25, 36)
RED, BLUE, GREEN, GREY = "#c0392b", "#1f5f9f", "#1e8449", "#888888"
RULES = (
    (
        *("outer ring: sectors that agree", "inner ring: sectors that agree", "sectors of both"),
        *("ratio of the radii", "darkness of the weaker ring", "deviation from an ellipse"),
    ),
    (
        *("second darkest direction", "line dark enough", "line not too dark", "line straight"),
        *("line without gaps", "line radial", "white beyond its end"),
    ),
    ("empty positions", "bit 1", "bit 2", "bit 3"),
)


def rendered(choice):
    """The frame of one of the choices above."""
    choice = dict(choice)
    frame, truths = render_frame(choice.pop("preset"), choice.pop("seed"), choice.pop("index"), **choice)
    return frame, truths


def closeup(frame, x, y, reach):
    """The part of a frame within `reach` px of a place, and its extent for imshow."""
    height, width = frame.shape
    left, right = max(0, int(x - reach)), min(width, int(x + reach) + 1)
    top, bottom = max(0, int(y - reach)), min(height, int(y + reach) + 1)
    return frame[top:bottom, left:right], (left - 0.5, right - 0.5, bottom - 0.5, top - 0.5)


def grey(axes, frame, extent=None):
    axes.imshow(frame, cmap="gray", vmin=0, vmax=255, extent=extent, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])


def places(positions, width):
    """x, y and direction (0..47, or what stands there) of listed positions."""
    values = np.array(positions)
    position = values & 0xFFFFF
    return position % width, position // width, values >> 20


def edges_figure(frame, scale):
    """All points that are steep enough, and those that lie on a thin dark line."""
    finder, buffer = scale.edges, memoryview(frame.tobytes())
    width = frame.shape[1]
    finder.measure_threshold(buffer)
    finder.list_steep(buffer, 0, False)
    steep = list(finder.edges[: finder.steep])
    count = finder.choose(buffer, finder.edges, finder.steep, False)
    edges = list(finder.edges[:count])
    figure = plt.figure(figsize=(10, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    grey(left, frame)
    x, y, _ = places(steep, width)
    left.plot(x, y, ".", color="#e67e22", markersize=2)
    left.set_title(
        "%d of the grid's points are steep: %d grey levels or more" % (len(steep), finder.threshold)
    )
    grey(right, frame)
    x, y, direction = places(edges, width)
    angle = direction * 2 * np.pi / 48
    right.quiver(
        x, y, np.cos(angle), np.sin(angle), angles="xy", color=RED, scale=30, width=0.0028, headwidth=3
    )
    right.set_title("%d of them lie on a thin dark line" % count)
    return figure, count


def votes_figure(frame, scale, count):
    """From how many directions edges point to each cell, and the candidates."""
    height, width = frame.shape
    votes, buffers = scale.votes, scale.votes._buffers
    centres = votes.find(scale.edges.edges, 0, count, 1, 0, width, 0, height)
    grid = votes.grid
    cells = np.array(buffers.cells[: grid.row * grid.rows]).reshape(grid.rows, grid.row)
    rows, columns = height // votes.step, width // votes.step
    inside = cells[grid.padding :, grid.padding :][:rows, :columns]
    outer = np.array([[bin(cell & 0xFFF).count("1") for cell in row] for row in inside])
    inner = np.array([[bin(cell >> 12 & 0xFFF).count("1") for cell in row] for row in inside])
    figure = plt.figure(figsize=(10, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    grey(left, frame)
    low = -votes.step / 2
    extent = (low, low + columns * votes.step, low + rows * votes.step, low)
    shown = right.imshow(outer + inner, cmap="inferno", vmin=0, vmax=24, extent=extent)
    right.set_xticks([])
    right.set_yticks([])
    right.set_title("Directions of which edges point to a cell, of 24")
    figure.colorbar(shown, ax=right, shrink=0.75)
    for index in range(centres):
        score, x, y = buffers.centres[3 * index : 3 * index + 3]
        x, y = (x - 32768) / 256, (y - 32768) / 256
        colour = GREEN if score >= votes.least_score else GREY
        left.add_patch(plt.Circle((x, y), 9, fill=False, color=colour, linewidth=1.6))
        if score >= votes.least_score:
            label = {"color": "white", "fontsize": 9, "bbox": {"fc": colour, "ec": "none", "pad": 1.5}}
            side = -1 if x > 0.85 * width else 1
            left.text(x + 13 * side, y + 3, "%d" % score, ha="left" if side > 0 else "right", **label)
        right.add_patch(plt.Circle((x, y), 9, fill=False, color="white", linewidth=1.2))
    left.set_title("Candidates with their scores; below %d none is fitted" % votes.least_score)
    return figure


def unrolled(frame, rings, radii):
    """The frame around the marker: a row for each radius (px), a column for each half degree clockwise."""
    angle = np.radians(np.arange(0, 360, 0.5))
    x = rings.true_x_q10 / 1024 + radii[:, None] * np.cos(angle)
    y = rings.true_y_q10 / 1024 + radii[:, None] * np.sin(angle)
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = x - x0, y - y0
    padded = np.pad(frame.astype(float), ((0, 1), (0, 1)), mode="edge")
    x0, y0 = np.clip(x0, 0, frame.shape[1] - 1), np.clip(y0, 0, frame.shape[0] - 1)
    top = padded[y0, x0] * (1 - fx) + padded[y0, x0 + 1] * fx
    bottom = padded[y0 + 1, x0] * (1 - fx) + padded[y0 + 1, x0 + 1] * fx
    return top * (1 - fy) + bottom * fy


def rings_figure(frame, rings):
    """The marker unrolled around its centre with the rings fitted, and what each sector leaves."""
    radius = rings.radius_q8 / 256
    inner = rings.fit[layouts.FIT_INNER_Q8] / 256
    figure = plt.figure(figsize=(10, 5.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    radii = np.linspace(0.3 * radius, 1.65 * radius, 220)
    top.imshow(
        unrolled(frame, rings, radii), cmap="gray", aspect="auto", extent=(0, 360, radii[-1], radii[0])
    )
    shift_x = (rings.fit[layouts.FIT_X_Q10] - layouts.BIAS - rings.true_x_q10) / 1024
    shift_y = (rings.fit[layouts.FIT_Y_Q10] - layouts.BIAS - rings.true_y_q10) / 1024
    bulge_cos = (rings.fit[layouts.FIT_BULGE_COS] - layouts.BIAS) / 1024
    bulge_sin = (rings.fit[layouts.FIT_BULGE_SIN] - layouts.BIAS) / 1024
    angle = np.radians(np.arange(0, 361))
    ellipse = bulge_cos * np.cos(2 * angle) + bulge_sin * np.sin(2 * angle)
    for size in (radius, inner):
        top.plot(
            np.degrees(angle),
            size + (shift_x * np.cos(angle) + shift_y * np.sin(angle) + ellipse) * size / radius,
            color=RED,
            linewidth=1,
        )
    top.set_ylabel("radius, px")
    top.set_title(
        "Unrolled around the centre (%.2f, %.2f): both rings at sub-pixel places"
        % (rings.true_x_q10 / 1024, rings.true_y_q10 / 1024)
    )
    middle = np.arange(16) * 22.5 + 11.25
    for means, name, colour, move in (
        (rings.outer_means, "outer", BLUE, -3),
        (rings.inner_means, "inner", GREEN, 3),
    ):
        residuals = (np.array(means[:16], float) - 32768) / 1024  # as the kernel stores them; 0: left out
        residuals[np.array(means[:16]) == 0] = np.nan
        bottom.bar(middle + move, residuals, 5.5, color=colour, label="%s ring" % name)
    bottom.axhline(0, color="black", linewidth=0.8)
    bottom.set_ylabel("residual, px")
    bottom.set_xlabel("angle, degrees clockwise from the right of the image")
    bottom.set_xlim(0, 360)
    bottom.set_xticks(range(0, 361, 45))
    bottom.margins(y=0.35)
    bottom.legend(loc="upper right", ncols=2, fontsize=9)
    bottom.set_title("What the 16 sectors leave after the last pass")
    return figure


def lines_figure(frame, direct):
    """Grey outside the rings by direction, with the orientation line, and the eight positions inside."""
    lines = direct.lines
    figure = plt.figure(figsize=(10, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    profile = np.array(lines.profile, float)
    angles = np.arange(len(profile)) * 360 / len(profile)
    left.plot(angles, profile, color=BLUE)
    left.axvline(lines.angle_turn16 * 360 / 65536, color=RED, linestyle="--", label="orientation line")
    left.set_xlim(0, 360)
    left.set_xticks(range(0, 361, 90))
    left.set_xlabel("angle, degrees clockwise")
    left.set_ylabel("sum of the logarithms of grey")
    left.set_title("Around the outer ring one direction is dark")
    left.legend(loc="lower right")
    items = layouts.POSITION_ITEMS
    depths = []
    for position in range(8):
        code = lines.code[position * items : (position + 1) * items]
        if position in (2, 4, 6):
            near, far = code[layouts.POSITION_NEAR_MEAN], code[layouts.POSITION_FAR_MEAN]
            depths.append((near + far) / 2 - layouts.BIAS)
        else:
            depths.append((code[layouts.POSITION_NEAR] + code[layouts.POSITION_FAR]) / 2)
    colours = [
        RED if p in (2, 4, 6) and depths[p] >= 125 else BLUE if p in (2, 4, 6) else GREY for p in range(8)
    ]
    right.bar(range(8), depths, color=colours)
    right.axhline(125, color=RED, linestyle=":", linewidth=1)
    right.text(-0.4, 129, "a line from here on", color=RED, fontsize=9)
    right.axhline(85, color=BLUE, linestyle=":", linewidth=1)
    right.text(-0.4, 89, "none up to here", color=BLUE, fontsize=9)
    names = ["%d\N{DEGREE SIGN}%s" % (45 * p, {2: "\n4", 4: "\n2", 6: "\n1"}.get(p, "")) for p in range(8)]
    right.set_xticks(range(8), names)
    right.set_xlabel("position from the orientation line; what its bit counts")
    right.set_ylabel("darkness, 256 = as dark as the rings")
    right.set_title("Inside: three bits, five positions must be empty")
    return figure


def cells_figure(frame, direct, detection):
    """The marker with its cells, and how dark each was."""
    x, y, radius = detection.x_q8 / 256, detection.y_q8 / 256, detection.radius_q8 / 256
    figure = plt.figure(figsize=(10, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(4, 6))
    grey(left, *closeup(frame, x, y, 1.8 * radius))
    depths = np.array(direct.cells.depths[:24], float)
    depths = np.where(depths == 0, np.nan, depths - layouts.BIAS)
    heading = detection.heading_cdeg / 100
    for cell in range(24):
        group, index = divmod(cell, CELLS_OF_GROUP)
        angle = np.radians(heading + (GROUPS_CDEG[group] + CELL_CDEG * (index + 0.5)) / 100)
        dark = depths[cell] > 128
        left.plot(
            x + 1.547 * radius * np.cos(angle),
            y - 1.547 * radius * np.sin(angle),
            "o",
            markersize=7,
            markerfacecolor=RED if dark else "none",
            markeredgecolor=RED if dark else BLUE,
        )
    left.set_title("Cells found dark (filled) and white")
    right.bar(range(24), depths, color=[RED if d > 128 else BLUE for d in depths])
    right.axhline(256, color=GREY, linestyle=":", linewidth=1)
    right.set_xlabel("cell, counterclockwise from the orientation line")
    right.set_ylabel("darkness, 256 = as dark as the rings tell")
    right.set_title(
        "ID %d; the next likely word costs enough more: margin %d"
        % (detection.marker_id, direct.cells.margin)
    )
    return figure


def margin_figure(direct, scale):
    """How far each rule is from its limit, 255 = without doubt."""
    acceptance, names, margins, colours = direct.acceptance, [], [], []
    decisions = (
        lambda: acceptance.rings(direct.rings, scale.radius_min_q8, scale.radius_max_q8),
        lambda: acceptance.orientation(direct.lines, direct.rings),
        lambda: acceptance.code(direct.lines, direct.rings, direct.cells, direct.is_turned),
    )
    for decide, rules, colour in zip(decisions, RULES, (BLUE, GREEN, RED), strict=True):
        verdict = decide()
        if verdict != verdicts.ACCEPTED:
            raise SystemExit("the frame of the figures is refused: %s" % verdicts.VERDICT_NAMES[verdict])
        for index, name in enumerate(rules):
            distance, doubt = acceptance._rules[2 * index] - layouts.BIAS, acceptance._rules[2 * index + 1]
            names.append(name)
            margins.append(min(255, distance * 255 // doubt))
            colours.append(colour)
    if direct.cells is not None:
        names.append("cells: second word")
        margins.append(direct.cells.margin)
        colours.append(RED)
    figure = plt.figure(figsize=(8, 5.2), layout="constrained")
    axes = figure.subplots()
    axes.barh(names, margins, color=colours)
    axes.invert_yaxis()
    axes.axvline(acceptance.margin, color="black", linestyle="--", linewidth=1)
    axes.text(acceptance.margin - 3, -0.75, "the marker's: %d" % acceptance.margin, ha="right", fontsize=9)
    axes.set_xlim(0, 260)
    axes.set_xlabel("distance from the limit, 255 = no doubt left")
    return figure


def blurred_figure():
    """A frame with motion blur: what the direct reader makes of it, and the blur-model reader."""
    frame, _ = rendered(BLURRED)
    height, width = frame.shape
    alone = Detector(width, height, *RADII_PX, second_opinion=False)
    if alone.detect(frame):
        raise SystemExit("the direct reader reads the blurred frame: choose another")
    seen = [name for name, n in zip(verdicts.VERDICT_NAMES, alone.statistics.verdicts, strict=True) if n]
    detector = Detector(width, height, *RADII_PX)
    found = [as_dict(detection) for detection in detector.detect(frame)]
    if len(found) != 1 or found[0]["id"] is None:
        raise SystemExit("the blur-model reader does not read the blurred frame: choose another")
    reader, (only,) = detector.blur_reader, found
    figure = plt.figure(figsize=(10, 4.2), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    part, extent = closeup(frame, only["x"], only["y"], 2 * only["radius"])
    grey(left, part, extent)
    left.set_title("Direct reader: %s" % ", ".join(seen).replace("_", " "), fontsize=10)
    drawn = draw_detections(frame, found, zoom=4)[:, :, ::-1]
    middle.imshow(drawn, extent=(-0.5, width - 0.5, height - 0.5, -0.5))
    middle.set_xlim(extent[0], extent[1])
    middle.set_ylim(extent[2], extent[3])
    middle.set_xticks([])
    middle.set_yticks([])
    middle.set_title("Blur-model reader: ID %d, margin %d" % (only["id"], only["margin"]), fontsize=10)
    amounts = list(reader.lines.amounts)
    colours = [(RED if amounts[p] >= 150 else BLUE) if p in (2, 4, 6) else GREY for p in range(8)]
    right.bar(range(8), amounts, color=colours)
    right.axhline(150, color=RED, linestyle=":", linewidth=1)
    right.axhline(85, color=BLUE, linestyle=":", linewidth=1)
    right.set_xticks(range(8), ["%d\N{DEGREE SIGN}" % (45 * p) for p in range(8)], fontsize=8)
    right.set_xlabel("position from the orientation line")
    right.set_title("Lines, 256 = as dark as the rings\nwould be in this blur", fontsize=10)
    return figure


def save(figure, path):
    """As a PNG of at most 128 colours, which is a third of the bytes."""
    figure.savefig(path, dpi=90)
    plt.close(figure)
    Image.open(path).convert("RGB").quantize(128, dither=Image.Dither.NONE).save(path, optimize=True)


def main(folder):
    folder.mkdir(parents=True, exist_ok=True)
    frame, _ = rendered(SHARP)
    height, width = frame.shape
    detector = Detector(width, height, *RADII_PX)
    (scale,) = detector._scales
    (detection,) = detector.detect(frame)
    x_q8, y_q8, radius_q8 = detection.x_q8, detection.y_q8, detection.radius_q8
    Image.fromarray(frame).save(folder / "frame.png", optimize=True)
    figure, count = edges_figure(frame, scale)
    save(figure, folder / "edges.png")
    save(votes_figure(frame, scale, count), folder / "votes.png")
    (detection,) = detector.track(frame, x_q8, y_q8, radius_q8)  # what the reader holds is this marker's
    save(rings_figure(frame, detector.direct.rings), folder / "rings.png")
    save(lines_figure(frame, detector.direct), folder / "lines.png")
    save(cells_figure(frame, detector.direct, detection), folder / "cells.png")
    save(margin_figure(detector.direct, scale), folder / "margin.png")
    save(blurred_figure(), folder / "blurred.png")
    for path in sorted(folder.glob("*.png")):
        print("%-60s %4d KiB" % (path, path.stat().st_size // 1024))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", metavar="FOLDER", type=Path, nargs="?", default=ROOT / "docs" / "detector")
    main(parser.parse_args().folder)
