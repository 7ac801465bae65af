"""Maps of simulated drives, and parts of their graphs, for tests of how maps are built."""

import numpy as np

from larics_host.mapping import build
from larics_host.mapping.collect import collect
from larics_host.mapping.graph import Reading
from tools.simulated_drives import drive, write_log
from tools.survey_drives import score, taped


def built_from(folder, world, seed, *options, distance=True):
    """(Drive, Score) of the map that `larics map build` makes of a drive; distance: with one by tape."""
    one = drive(world, seed)
    words = list(options)
    if distance:
        words += ["--distance", "%d,%d,%.1f" % taped(one, np.random.default_rng(seed))]
    return one, score(one, write_log(folder / "drive.bin", one), *words)


def solved(tmp_path, monkeypatch, world, seed):
    """(Drive, Collected, the Graph of its map)."""
    kept = []
    monkeypatch.setattr(build, "find_moves", lambda graph, places, settled: kept.append(graph) or [])
    one = drive(world, seed)
    collected = collect([write_log(tmp_path / "drive.bin", one)], False)
    first, second, mm = taped(one, np.random.default_rng(seed))
    build.build(collected, build.Request(distances=[(first, second, mm)]))
    return one, collected, kept[0]


def reading(passage, used, x_mm=0.0):
    """Of place 0, so far from the passage's middle."""
    return Reading(passage, 0, (x_mm, 0.0, 0.0), used)
