"""How good the product's maps of simulated drives (tools/simulated_drives.py) are.

    python -m tools.survey_drives --seeds 5000:5010 --slips 0.02 --distance -o build/drives

builds a map from each and prints how far it is off, whether its sigma can be believed, and what was noticed.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import itertools
import math
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from larics_host import cli
from larics_host.mapping.mapfile import read_map
from tools.simulated_drives import Drive, World, drive, write_log


@dataclass
class Score:
    """refused: what was said; else mm that each marker of the map is off after the best rigid motion
    (`errors`), whether x and y are within two of the map's own standard deviations (`within`), IDs of
    markers said to be moved, how many of the passages that were misread were set aside, and how many places
    the map has where no marker is (`surplus`), or lacks (`missing`)."""

    refused: str = ""
    errors: np.ndarray = field(default_factory=lambda: np.zeros(0))
    within: np.ndarray = field(default_factory=lambda: np.zeros(0))
    moved: list = field(default_factory=list)
    aside: int = 0
    surplus: int = 0
    missing: int = 0
    seconds: float = 0.0


def taped(one: Drive, rng: np.random.Generator) -> tuple[int, int, float]:
    """(ID, ID, mm) of two markers far from each other that were passed often, as measured by hand."""
    seen = Counter(marker_id for *_, sightings in one.frames for marker_id, *_ in sightings)
    often = sorted((k for k in range(len(one.hall)) if k != one.moved), key=lambda k: -seen[one.hall[k][0]])
    first, second = max(
        itertools.combinations(often[: len(often) // 2], 2),
        key=lambda pair: math.dist(one.hall[pair[0]][1:3], one.hall[pair[1]][1:3]),
    )
    mm = math.dist(one.hall[first][1:3], one.hall[second][1:3]) + rng.normal(0, 2)
    return one.hall[first][0], one.hall[second][0], mm


def score(one: Drive, log: Path, *options: str) -> Score:
    """The Score of `larics map build` on the log of a drive."""
    out = log.with_suffix(".map.json")
    said, err = io.StringIO(), io.StringIO()
    begun = time.perf_counter()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(err):
        code = cli.main(["map", "build", str(log), "-o", str(out), "--force", *options])
    seconds = time.perf_counter() - begun
    if code > 1:
        return Score(err.getvalue().strip(), seconds=seconds)
    markers = read_map(out).markers
    pairs = _matched(markers, one.hall)
    own = np.array([(marker.x_mm, marker.y_mm) for marker, _ in pairs])
    true = np.array([place[1:3] for _, place in pairs])
    a, b = own - own.mean(axis=0), true - true.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    off = a - b @ (u @ v).T  # in the axes of the map
    sigmas = np.array([[marker.sigma_mm] for marker, _ in pairs])
    text = said.getvalue()
    moved = [int(line.split()[1]) for line in text.splitlines() if " was moved by " in line]
    aside = Counter()
    for part in text.split("(read as marker ")[1:]:
        aside.update(int(word) for word in part.split(")")[0].split(", "))
    hit = sum((aside & Counter(marker_id for _, marker_id in one.misread)).values())
    met = {place for _, place in pairs}
    spare = len(markers) - len(met), len(one.hall) - len(met)
    return Score("", np.hypot(*off.T), np.abs(off) < 2 * sigmas, moved, hit, *spare, seconds)


def _matched(markers, hall):
    """[(marker of the map, place of the hall)] by the motion from one of the markers that brings most
    together."""
    best = []
    for marker in markers[:8]:
        for place in (place for place in hall if place[0] == marker.id):
            turn = math.radians(place[3] - marker.heading_deg)
            pairs = []
            for other in markers:
                dx, dy = other.x_mm - marker.x_mm, other.y_mm - marker.y_mm
                x = place[1] + math.cos(turn) * dx - math.sin(turn) * dy
                y = place[2] + math.sin(turn) * dx + math.cos(turn) * dy
                same = [one for one in hall if one[0] == other.id]
                near = min(same, key=lambda one: math.dist(one[1:3], (x, y)), default=None)
                if near and math.dist(near[1:3], (x, y)) < 1200:
                    pairs.append((other, near))
            best = max(best, pairs, key=len)
    return best


def main(argv: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seeds", default="5000:5010", metavar="FIRST:END")
    parser.add_argument("--length-m", type=float, default=200.0)
    parser.add_argument("--slips", type=float, default=0.02, help="a metre")
    parser.add_argument("--wrong", type=float, default=0.03, help="share of passages with another ID")
    parser.add_argument("--ids", type=int, default=0, help="so many different IDs, repeated")
    parser.add_argument("--carried-m", type=float, default=0.0, help="where the vehicle is carried off")
    parser.add_argument("--distance", action="store_true", help="one distance is measured by hand")
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for logs and maps")
    options = parser.parse_args(argv)
    if options.distance and options.ids:
        parser.error("--distance is of IDs that stand once each: not with --ids")
    options.output.mkdir(parents=True, exist_ok=True)
    world = World(
        length_m=options.length_m,
        slips=options.slips,
        wrong=options.wrong,
        ids=options.ids,
        carried_m=options.carried_m,
    )
    scores, named, misread = [], 0, 0
    for seed in range(*map(int, options.seeds.split(":"))):
        one = drive(world, seed)
        words = ["--repeats"] if options.ids else []
        if options.distance:
            words += ["--distance", "%d,%d,%.1f" % taped(one, np.random.default_rng(seed))]
        result = score(one, write_log(options.output / ("drive%d.bin" % seed), one), *words)
        if result.refused:
            print("%d: %s" % (seed, result.refused))
            continue
        scores.append(result)
        misread += len(one.misread)
        named += one.moved is not None and one.hall[one.moved][0] in result.moved
        print(
            "%d: median %.1f, largest %.1f mm, %.0f %% within 2 sigma; moved %s, said %s; %d of %d misread "
            "passages set aside; %d places too many, %d missing; %.1f s"
            % (
                seed,
                np.median(result.errors),
                result.errors.max(),
                100 * result.within.mean(),
                one.moved is not None and one.hall[one.moved][0],
                result.moved,
                result.aside,
                len(one.misread),
                result.surplus,
                result.missing,
                result.seconds,
            )
        )
    if scores:
        medians = [np.median(one.errors) for one in scores]
        largest = [one.errors.max() for one in scores]
        print(
            "%d maps: median error %.1f mm (worst %.1f), largest %.1f mm (90 %%: %.1f, worst %.1f), "
            "%.1f %% within 2 sigma, misread passages set aside %d of %d, moved markers named %d of %d, "
            "%d places too many, %d missing"
            % (
                *(len(scores), np.median(medians), max(medians), np.median(largest)),
                *(np.percentile(largest, 90), max(largest)),
                100 * np.mean(np.concatenate([one.within.ravel() for one in scores])),
                *(sum(one.aside for one in scores), misread, named, len(scores)),
                *(sum(one.surplus for one in scores), sum(one.missing for one in scores)),
            )
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
