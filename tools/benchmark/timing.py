"""Time per frame on the host: all methods on the same scenes, in turns, so that ratios are fair."""

import time

import numpy as np

from . import frames, methods


def host_times(names, preset, seed, count, radius_px, on_done=lambda count: None):
    """{method: (median ms a frame, median of the ratios to the first method)}.

    Every scene is drawn once for each target; the methods take turns on each scene, each twice and the
    quicker of the two counts, so that a method's ratio compares times taken within milliseconds.
    """
    detectors = {name: methods.make(name, frames.WIDTH, frames.HEIGHT, radius_px) for name in names}
    spent = {name: [] for name in names}
    for index in range(count):
        drawn = {
            target: frames.render(preset, seed, index, target, radius_px, {})[0]
            for target in {methods.target(name) for name in names}
        }
        turn = index % len(names)
        for name in names[turn:] + names[:turn]:
            detect, frame = detectors[name], drawn[methods.target(name)]
            if index == 0:
                detect(frame)  # compiles, and fills caches
            best = None
            for _ in range(2):
                start = time.perf_counter()
                detect(frame)
                elapsed = time.perf_counter() - start
                best = elapsed if best is None else min(best, elapsed)
            spent[name].append(best)
        on_done(1)
    reference = np.array(spent[names[0]])
    return {
        name: (float(np.median(times)) * 1e3, float(np.median(np.array(times) / reference)))
        for name, times in spent.items()
    }
