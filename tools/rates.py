"""Rates and errors of one detection method on rendered frames: one row a preset. The tool for tuning.

    python tools/rates.py --preset cloudy --frames 500 --seed 100
    python tools/rates.py --preset sunny,cloudy,harsh --method larics,paper,apriltag
    python tools/rates.py --preset sunny --set blur_px=8 --radius-px 20 --show 10
    python tools/rates.py --preset sunny --set tilt_deg=25 --max-tilt 25 --method larics,larics_sharp
    python tools/rates.py --preset negative,photographs --frames 2000
    python tools/rates.py --preset harsh --cache /tmp/larics-frames     # render once, tune many times

Columns: pose reported, ID reported and right, wrong IDs, uncertain IDs, false positives, centre and
heading error (median / 95th percentile). `--show N` lists the first N frames (preset, seed, index) that
were missed or wrong, with the verdicts on their candidates; `--save DIR` writes them as PNG. `--set` takes
any override of `larics_host.render.render_frame`. Seeds below 1000 are for tuning, the bench begins at 5000.
"""

import argparse
import ast
import sys
from pathlib import Path

import cv2
from benchmark import evaluate, frames, methods, report

from larics_host.render import PRESETS
from larics_host.render.series import OVERRIDES


def arguments(words=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--preset", default="sunny", help="presets of the renderer, and photographs")
    parser.add_argument("--method", default="larics", help="of: " + ", ".join(methods.METHODS))
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--seed", type=int, default=100)
    parser.add_argument("--radius-px", type=float, default=30.0, help="ring drawn, and expected within 15 %%")
    parser.add_argument(
        "--max-tilt", type=int, default=0, metavar="DEG", help="tilt that the detector is told to allow"
    )
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="override")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--cache", help="folder that keeps rendered frames between runs")
    parser.add_argument("--show", type=int, default=0, help="list this many failed frames a kind")
    parser.add_argument("--save", help="folder for the failed frames listed by --show")
    return parser.parse_args(words)


def override(text):
    """`name=value` -> (name, number or text)."""
    name, _, value = text.partition("=")
    try:
        return name, ast.literal_eval(value)
    except (SyntaxError, ValueError):
        return name, value


def frame_of(key, name, options, overrides):
    """The frame that a tally's key names, as the method saw it."""
    preset, seed, index = key
    if preset == evaluate.PHOTOGRAPHS:
        return frames.photograph(seed, index)
    return frames.render(preset, seed, index, methods.target(name), options.radius_px, overrides)[0]


def show(tally, name, options, overrides):
    """Lists failed frames with the verdicts on their candidates, and saves them when asked."""
    detect = methods.make(name, frames.WIDTH, frames.HEIGHT, options.radius_px, options.max_tilt)
    kinds = (("missed", tally.misses), ("wrong ID", tally.wrongs), ("false positive", tally.false_keys))
    for kind, keys in kinds:
        for key in keys[: options.show]:
            frame = frame_of(key, name, options, overrides)
            detect(frame)
            verdicts = detect.verdicts() if isinstance(detect, methods.Larics) else {}
            print(
                "  %-14s %s %d %d  %s"
                % (kind, *key, ", ".join("%d %s" % (n, v) for v, n in verdicts.items()))
            )
            if options.save:
                Path(options.save).mkdir(parents=True, exist_ok=True)
                file = "%s-%s-%d-%d.png" % (kind.replace(" ", "-"), *key)
                cv2.imwrite(str(Path(options.save) / file), frame)


def main():
    options = arguments()
    names = options.method.split(",")
    unknown = [name for name in names if name not in methods.METHODS]
    if unknown:
        sys.exit("rates: unknown method %s; use %s" % (unknown[0], ", ".join(methods.METHODS)))
    if not 0 <= options.max_tilt <= 40:
        sys.exit("rates: --max-tilt is 0 to 40 degrees, not %d" % options.max_tilt)
    known = [*PRESETS, evaluate.PHOTOGRAPHS]
    unknown = [preset for preset in options.preset.split(",") if preset not in known]
    if unknown:
        sys.exit("rates: unknown preset %s; use %s" % (unknown[0], ", ".join(known)))
    overrides = dict(override(text) for text in options.set)
    unknown = set(overrides) - set(OVERRIDES)
    if unknown:
        sys.exit("rates: unknown override %s; use %s" % (unknown.pop(), ", ".join(OVERRIDES)))
    print(report.heading("preset / method"))
    for preset in options.preset.split(","):
        todo = evaluate.jobs(
            preset, preset, options.seed, options.frames, options.radius_px, overrides, names,
            options.cache, options.max_tilt,
        )  # fmt: skip
        for name, tally in evaluate.run_all(todo, options.jobs)[preset].items():
            print(report.line("%s %s" % (preset, name), tally.row()), flush=True)
            show(tally, name, options, overrides)


if __name__ == "__main__":
    main()
