"""Runs methods over many frames on several processes and tallies what they find."""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import NamedTuple

from larics_host.validation.scoring import Tally

from . import frames, methods

BLOCK = 25  # frames handed to a process at a time

PHOTOGRAPHS = "photographs"  # taken for a preset here: no renderer, no marker
NEGATIVES = ("negative", PHOTOGRAPHS)  # without a marker, so the same for every method


class Job(NamedTuple):
    """Frames `start`..`start + count - 1` of a preset; `group` is the caller's name for the result."""

    group: object
    preset: str
    seed: int
    start: int
    count: int
    radius_px: float
    overrides: tuple  # of (name, value)
    names: tuple  # methods
    cache: str | None = None
    max_tilt_deg: int = 0  # that the methods are told to allow


def jobs(group, preset, seed, count, radius_px, overrides, names, cache=None, max_tilt_deg=0):
    """A measurement of `count` frames cut into jobs."""
    return [
        Job(
            group, preset, seed, start, min(BLOCK, count - start), radius_px,
            tuple(sorted(overrides.items())), tuple(names), cache, max_tilt_deg,
        )
        for start in range(0, count, BLOCK)
    ]  # fmt: skip


_detectors = {}


def detector(name, radius_px, max_tilt_deg):
    key = name, radius_px, max_tilt_deg
    if key not in _detectors:
        _detectors[key] = methods.make(name, frames.WIDTH, frames.HEIGHT, radius_px, max_tilt_deg)
    return _detectors[key]


def block(job, target):
    if job.preset == PHOTOGRAPHS:
        return [(frames.photograph(job.seed, job.start + i), []) for i in range(job.count)]
    overrides = dict(job.overrides)
    if job.cache:
        return frames.Cache(job.cache).block(
            job.preset, job.seed, job.start, job.count, target, job.radius_px, overrides
        )
    return [
        frames.render(job.preset, job.seed, job.start + i, target, job.radius_px, overrides)
        for i in range(job.count)
    ]


def run(job):
    """The job and its tallies by method."""
    tallies = {}
    by_target = {}
    for name in job.names:
        target = "larics" if job.preset in NEGATIVES else methods.target(name)
        by_target.setdefault(target, []).append(name)
    for target, names in by_target.items():
        drawn = block(job, target)
        for name in names:
            detect, tally = detector(name, job.radius_px, job.max_tilt_deg), Tally()
            for i, (frame, truths) in enumerate(drawn):
                tally.add(truths, detect(frame), (job.preset, job.seed, job.start + i))
            tallies[name] = tally
    return job, tallies


def run_all(all_jobs, processes=1, on_done=lambda count: None):
    """{group: {method: Tally}} of all jobs; `on_done(frames)` is called as blocks are finished."""
    results = {}

    def collect(job, tallies):
        group = results.setdefault(job.group, {name: Tally() for name in job.names})
        for name, tally in tallies.items():
            group[name].merge(tally)
        on_done(job.count)

    if processes <= 1:
        for job in all_jobs:
            collect(*run(job))
        return results
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(processes, mp_context=context) as pool:
        for future in as_completed([pool.submit(run, job) for job in all_jobs]):
            collect(*future.result())
    return results
