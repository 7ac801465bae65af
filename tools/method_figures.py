"""Pictures that explain the published method: `python tools/method_figures.py [FOLDER]`, docs/ by default.

method_votes.png   a frame, its Hough accumulator, and the accumulator around its maximum
                   (what figures 4 and 5 of the paper show)
method_bits.png    the local window after the threshold, and H(alpha) with the positions of equation 9
                   (figure 7)
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np

from larics.detect.paper import PaperDetector
from larics.marker import CODE_ANGLES_CDEG
from larics_host.render import render_frame

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of a backend without a screen)

ROOT = Path(__file__).resolve().parent.parent
PRESET, SEED, INDEX = "sunny", 5000, 39
RADII_PX = (25, 35)
RED, BLUE, GREY = "#c0392b", "#1f5f9f", "#888888"


def detection():
    """The frame of the figures, the detector after it, and what was found."""
    frame, _ = render_frame(PRESET, SEED, INDEX)
    detector = PaperDetector(frame.shape[1], frame.shape[0], *RADII_PX)
    (found,) = detector.detect(frame)
    return frame, detector, found


def votes_figure(frame, detector, found):
    """Frame with the detection, accumulator, and its surroundings of the maximum as a surface."""
    height, width = frame.shape
    votes = np.array(detector.accumulator).reshape(height, width)
    x, y, radius = found.x_q8 / 256, found.y_q8 / 256, found.radius_q8 / 256
    figure = plt.figure(figsize=(14, 4.2), layout="constrained")
    left, middle = figure.add_subplot(131), figure.add_subplot(132)
    left.imshow(frame, cmap="gray", vmin=0, vmax=255)
    for share in (1, 2 / 3):
        left.add_patch(plt.Circle((x, y), radius * share, fill=False, color=RED, linewidth=1.5))
    left.plot(x, y, "+", color=RED, markersize=12)
    left.set_title("Frame and the two rings found")
    shown = middle.imshow(np.sqrt(votes), cmap="inferno")
    middle.plot(x, y, "o", color="white", markersize=16, fillstyle="none")
    middle.set_title("Votes for the centre (brightness: their square root)")
    ticks = [v for v in (0, 10, 50, 100, 200, 400, 800, 1600) if v <= votes.max()]
    bar = figure.colorbar(shown, ax=middle, ticks=np.sqrt(ticks), shrink=0.8)
    bar.ax.set_yticklabels(ticks)
    for axes in (left, middle):
        axes.set_xlabel("x, px")
        axes.set_ylabel("y, px")
    right = figure.add_subplot(133, projection="3d")
    reach = 20
    rows = slice(max(0, int(y) - reach), int(y) + reach + 1)
    columns = slice(max(0, int(x) - reach), int(x) + reach + 1)
    grid_y, grid_x = np.mgrid[rows, columns]
    surface = votes[rows, columns]
    right.plot_surface(
        grid_x[: surface.shape[0], : surface.shape[1]],
        grid_y[: surface.shape[0], : surface.shape[1]],
        surface,
        cmap="inferno",
        rstride=1,
        cstride=1,
        linewidth=0,
    )
    right.invert_yaxis()
    right.set_xlabel("x, px")
    right.set_ylabel("y, px")
    right.set_title("The maximum: %d votes" % detector.votes)
    return figure


def bits_figure(detector, found):
    """Binary window with the directions that are read, and H(alpha) against Z."""
    side = detector.window_side
    half = side // 2
    window = np.frombuffer(detector.window, np.uint8)[: side * side].reshape(side, side)
    sums = np.array(detector.radial_sums)
    alpha0 = found.heading_cdeg // 100
    z = detector.z6 / 6
    figure, (left, right) = plt.subplots(1, 2, figsize=(14, 4.2), width_ratios=(1, 2.3), layout="constrained")
    left.imshow(1 - window, cmap="gray", extent=(-half - 0.5, half + 0.5, -half - 0.5, half + 0.5))
    directions = [(0, RED)] + [(angle // 100, BLUE) for angle in CODE_ANGLES_CDEG]
    for angle, colour in directions:
        turn = np.radians(alpha0 + angle)
        left.plot([0, half * np.cos(turn)], [0, half * np.sin(turn)], color=colour, linewidth=1.5)
    left.set_title("Local window: dark pixels, N = %d" % half)
    left.set_xlabel("px from the centre")
    right.plot(np.arange(360), sums, color="black", linewidth=1)
    right.axhline(z, color=GREY, linestyle="--", linewidth=1)
    right.annotate("Z = %.1f" % z, (360, z), xytext=(4, -3), textcoords="offset points", color=GREY)
    right.plot(alpha0, sums[alpha0], "v", color=RED, markersize=9)
    right.annotate(
        r"$\alpha_0$ = %d°" % alpha0,
        (alpha0, sums[alpha0]),
        xytext=(10, -3),
        textcoords="offset points",
        color=RED,
    )
    for n in range(1, 8):
        angle = (alpha0 + 45 * n) % 360
        is_bit = 4500 * n in CODE_ANGLES_CDEG
        right.plot(angle, sums[angle], "o", color=BLUE if is_bit else GREY, markersize=7)
        if is_bit:
            right.annotate(
                "bit %d is %d" % (2 - CODE_ANGLES_CDEG.index(4500 * n), sums[angle] > z),
                (angle, sums[angle]),
                xytext=(0, 12),
                textcoords="offset points",
                ha="center",
                color=BLUE,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 1},
            )
    right.set_xlim(0, 360)
    right.set_ylim(0, sums.max() * 1.15)
    right.set_xticks(range(0, 361, 45))
    right.set_xlabel(r"$\alpha$, degrees counterclockwise")
    right.set_ylabel(r"$H(\alpha)$, dark pixels")
    right.set_title("Radial sums: marker %d" % found.marker_id)
    return figure


def write(folder):
    """Writes both pictures and returns their paths."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    frame, detector, found = detection()
    paths = []
    for name, figure in (
        ("method_votes.png", votes_figure(frame, detector, found)),
        ("method_bits.png", bits_figure(detector, found)),
    ):
        figure.savefig(folder / name, dpi=80, metadata={"Software": None})
        plt.close(figure)
        paths.append(folder / name)
    return paths


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", metavar="FOLDER", type=Path, nargs="?", default=ROOT / "docs")
    for written in write(parser.parse_args().folder):
        print("wrote", written)
