"""The picture of the demo: frames with what was reported drawn in, and the driven path against the truth."""

import logging
import math

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it tells at length of a home that it cannot write
import matplotlib  # noqa: E402

matplotlib.use("Agg")
import cv2  # noqa: E402
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.patches import Circle, Rectangle, Wedge  # noqa: E402
from PIL import Image  # noqa: E402

from larics.marker import ARC, LINE, RING  # noqa: E402
from larics.wire import messages as m  # noqa: E402
from tools.demo import compare, drive  # noqa: E402

GREEN, ORANGE, INK, BLUE, PAPER = "#00a35c", "#f08c00", "#22303c", "#2f6fde", "#f4f5f6"
LETTERS = "abc"
OUTER_MM = 150.0
LEFT = dict(loc="left", color=INK)


def draw(frames, folder, total, path):
    """Writes the PNG: `frames` and `total` as tools.demo.compare gives them, pictures from `folder`."""
    plt.rcParams.update({"font.size": 10, "font.family": "DejaVu Sans", "axes.titlesize": 10.5})
    figure = plt.figure(figsize=(13.5, 8.6), facecolor="white")
    sides = dict(left=0.05, right=0.985)
    upper = figure.add_gridspec(1, 3, top=0.905, bottom=0.515, wspace=0.05, **sides)
    lower = figure.add_gridspec(1, 2, top=0.44, bottom=0.065, width_ratios=(1.75, 1.0), wspace=0.12, **sides)
    samples = choose(frames)
    for k, frame in enumerate(samples):
        draw_frame(figure.add_subplot(upper[0, k]), frame, LETTERS[k], folder)
    draw_map(figure.add_subplot(lower[0]), frames, samples)
    draw_errors(lower[1].subgridspec(2, 1, hspace=0.5), figure, frames, total)
    figure.suptitle(
        "A drive at %.0f cm/s under a %.0f m ceiling: %d frames, found by the firmware on MicroPython, "
        "read from its serial line" % (drive.SPEED_MM_S / 10, drive.CEILING_MM / 1000, len(frames)),
        fontsize=13,
        x=0.05,
        ha="left",
    )
    figure.savefig(path, dpi=120)
    plt.close(figure)


def choose(frames):
    """Three frames with a whole marker that was identified, spread over the drive."""
    good = [
        frame
        for frame in frames
        if any(compare.is_whole(truth) for truth in frame.truths)
        and any(record["id"] is not None for record in frame.markers)
    ] or frames
    return [good[int(share * (len(good) - 1))] for share in (0.1, 0.45, 0.8)]


def to_image(record):
    """(x px, y px, image angle deg, radius px) of a reported marker, by the camera that the demo has."""
    scale = drive.FOCAL_PX / (record["z_mm10"] / 10)
    x = (drive.WIDTH - 1) / 2 + scale * record["y_mm10"] / 10  # image right is the vehicle's left
    y = (drive.HEIGHT - 1) / 2 - scale * record["x_mm10"] / 10
    return x, y, 90 - record["heading_cdeg"] / 100, scale * OUTER_MM


def draw_frame(axes, frame, letter, folder):
    picture = cv2.imread(str(folder / drive.name_of(frame.index)), cv2.IMREAD_GRAYSCALE)
    axes.imshow(picture, cmap="gray", vmin=0, vmax=255)
    axes.set_xlim(-0.5, drive.WIDTH - 0.5)
    axes.set_ylim(drive.HEIGHT - 0.5, -0.5)
    axes.set_xticks([])
    axes.set_yticks([])
    texts = []
    for record in frame.markers:
        x, y, angle_deg, radius = to_image(record)
        dx, dy = math.cos(math.radians(angle_deg)), -math.sin(math.radians(angle_deg))
        for size in (1.0, 2 / 3):
            axes.add_patch(Circle((x, y), size * radius, fill=False, edgecolor=GREEN, linewidth=2.2))
        end = radius * 2.3 / 1.5
        axes.plot([x, x + dx * end], [y, y + dy * end], color=ORANGE, linewidth=2.4)
        axes.plot([x], [y], "+", color=GREEN, markersize=9, markeredgewidth=2)
        name = "?" if record["id"] is None else str(record["id"])
        shape = "circle" if len(name) < 2 else "round"
        axes.annotate(
            name,
            (x - dx * radius * 1.3, y - dy * radius * 1.3),
            color="white",
            weight="bold",
            ha="center",
            va="center",
            size=10 if len(name) < 2 else 8,
            bbox=dict(boxstyle="%s,pad=0.25" % shape, facecolor=GREEN, edgecolor="none"),
        )
        texts.append(
            "ID %s   x %+.1f  y %+.1f mm   heading %.1f°"
            % (name, record["x_mm10"] / 10, record["y_mm10"] / 10, record["heading_cdeg"] // 10 / 10)
        )
    axes.set_title("%s   %s" % (letter, "; ".join(texts)), loc="left", color=INK)


def draw_stroke(axes, center, heading_deg, kind, sizes):
    """A stroke of `Family.strokes`, lengths in mm, as the map sees it: from above, angles the other way."""
    if kind == RING:
        axes.add_patch(Circle(center, sizes[0], fill=False, edgecolor="black", linewidth=2.2))
    elif kind == LINE:
        turned = math.radians(heading_deg - sizes[0] / 10)
        along = np.array([math.cos(turned), math.sin(turned)])
        ends = np.array([center + sizes[1] * along, center + sizes[2] * along])
        axes.plot(*ends.T, color="black", linewidth=2.2, solid_capstyle="butt")
    elif kind == ARC:
        first, last, start, end = sizes
        turns = heading_deg - last / 10, heading_deg - first / 10
        axes.add_patch(Wedge(center, end, *turns, width=end - start, color="black", linewidth=0))


def draw_plate(axes, plate):
    center = np.array([plate.pose.x_mm, plate.pose.y_mm])
    axes.add_patch(Circle(center, plate.radius_mm, facecolor="white", edgecolor="#aab2ba", linewidth=1))
    for kind, *sizes in plate.family.strokes(plate.marker_id):
        draw_stroke(axes, center, plate.pose.heading_deg, kind, [size / 10 for size in sizes])
    axes.annotate(
        str(plate.marker_id),
        center + (plate.radius_mm + 95) * np.array([0.75, -0.75]),
        ha="center",
        va="center",
        weight="bold",
        color=INK,
    )


def draw_map(axes, frames, samples):
    axes.set_facecolor(PAPER)
    for plate in drive.plates():
        draw_plate(axes, plate)
    way = np.array([frame.vehicle[:2] for frame in frames])
    axes.plot(*way.T, color=INK, linewidth=6, alpha=0.22, solid_capstyle="round", label="true path")
    for state, color, name, size in (
        (m.TRACKING, GREEN, "reported: TRACKING", 4.0),
        (m.COASTING, ORANGE, "reported: COASTING", 4.0),
    ):
        points = np.array([frame.pose[:2] for frame in frames if frame.pose and frame.state == state])
        if len(points):
            axes.plot(*points.T, ".", color=color, markersize=size, label=name)
    for letter, frame in zip(LETTERS, samples, strict=True):
        draw_view(axes, frame, letter)
    axes.set_aspect("equal")
    axes.margins(0.02)
    axes.set_xlabel("map x, mm")
    axes.set_ylabel("map y, mm", labelpad=0)
    axes.grid(color="white", linewidth=1.2)
    axes.set_axisbelow(True)
    axes.legend(loc="lower right", framealpha=0.9, fontsize=9)
    axes.set_title("The drive, from the left to the right; dashed: what frames a, b, c show", **LEFT)


def draw_view(axes, frame, letter):
    """The field of view of one frame on the map."""
    x, y, heading_deg = frame.vehicle
    deep = drive.HEIGHT * drive.CEILING_MM / drive.FOCAL_PX
    wide = drive.WIDTH * drive.CEILING_MM / drive.FOCAL_PX
    view = Rectangle(
        (x - deep / 2, y - wide / 2),
        deep,
        wide,
        angle=heading_deg,
        rotation_point=(x, y),
        fill=False,
        edgecolor=BLUE,
        linewidth=1.2,
        linestyle=(0, (4, 3)),
    )
    axes.add_patch(view)
    corner = view.get_corners()[3]
    inwards = np.array([x, y]) - corner
    axes.annotate(letter, corner + 0.09 * inwards, color=BLUE, weight="bold", ha="center", va="center")


def draw_errors(grid, figure, frames, total):
    upper, lower = figure.add_subplot(grid[0]), figure.add_subplot(grid[1])
    for state, color in ((m.TRACKING, GREEN), (m.COASTING, ORANGE)):
        rows = [frame for frame in frames if frame.pose and frame.state == state]
        times = [frame.time_s for frame in rows]
        upper.plot(times, [compare.position_error(frame) for frame in rows], ".", color=color, markersize=4)
        lower.plot(
            times,
            [abs(compare.angle(frame.pose[2] - frame.vehicle[2])) for frame in rows],
            ".",
            color=color,
            markersize=4,
        )
    medians = compare.spread(total.positions_mm)[0], compare.spread(total.headings_deg)[0]
    upper.set_title("Position error in the map, mm: median %.1f" % medians[0], **LEFT)
    lower.set_title("Heading error, degrees: median %.2f" % medians[1], **LEFT)
    lower.set_xlabel(
        "time, s;   %d of %d whole markers identified, %d wrong" % (total.found, total.whole, total.wrong)
    )
    for axes in (upper, lower):
        axes.set_facecolor(PAPER)
        axes.grid(color="white", linewidth=1.2)
        axes.set_axisbelow(True)
        axes.set_xlim(0, frames[-1].time_s)
        axes.set_ylim(0, None)


def _palette():
    """Greys, and the colours of the drawing on their way to white, to dark and to grey."""
    colors = [(grey, grey, grey) for grey in [*range(0, 254, 2), 255]]
    for name in (GREEN, ORANGE, INK, BLUE):
        color = np.array([int(name[k : k + 2], 16) for k in (1, 3, 5)])
        for ground, steps in ((255, 12), (110, 8), (40, 8)):
            colors += [tuple(ground + (color - ground) * k // steps) for k in range(1, steps + 1)]
    image = Image.new("P", (1, 1))
    image.putpalette([int(part) for color in colors for part in color])
    return image


def reduce(source, target, width=1350):
    """A smaller copy with few colours, for the README."""
    image = Image.open(source).convert("RGB")
    size = (width, round(image.height * width / image.width))
    small = image.resize(size, Image.Resampling.LANCZOS)
    small.quantize(palette=_palette(), dither=Image.Dither.NONE).save(target, optimize=True)
