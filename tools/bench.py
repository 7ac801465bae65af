"""The bench: quality, stresses, risk, time and instructions of our method beside its peers, in one run.

    make bench                                      # some minutes on two cores
    make bench FRAMES=2000                          # for figures that are published
    make bench BENCH="--only quality,time"
    make bench FRAMES=2000 BENCH=--docs             # and brings docs/stress.md and docs/peers.md up to date
    make bench FRAMES=2000 BENCH="--methods aruco,apriltag --output /tmp/peers"
    make bench FRAMES=2000 BENCH="--methods larics,larics_coded --with /tmp/peers/results.json"
    make bench MICROPYTHON=/path/to/emulator        # also counts instructions, see benchmark/interpreter.py
    python tools/bench.py --compare build/bench/results.json older.json

Every method sees the same scenes with its own tag of equal footprint. Writes report.txt, results.json and
the plots to build/bench. FRAMES is the number of frames a preset; a point of a sweep takes a quarter.
What the peers make of a frame does not change with our code: --with takes their quality and sweeps from an
earlier run over the very same frames.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

from benchmark import (
    earlier,
    evaluate,
    frames,
    interpreter,
    methods,
    page,
    plan,
    plots,
    report,
    targets,
    timing,
    tracking,
)
from rich.progress import Progress

from larics_host.validation import scoring

DOCS = interpreter.ROOT / "docs"
PARTS = ("quality", "sweeps", "risk", "tracking", "time", "micropython")


def arguments(words=None):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", type=int, default=100, help="frames a preset (default %(default)s)")
    parser.add_argument("--seed", type=int, default=plan.FRESH_SEED)
    parser.add_argument("--only", default=",".join(PARTS), help="parts to run, of " + ",".join(PARTS))
    parser.add_argument("--methods", help="only these of: " + ",".join(methods.METHODS))
    parser.add_argument(
        "--with",
        dest="earlier",
        type=Path,
        metavar="JSON",
        help="take methods left out of quality and sweeps from this results.json",
    )
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes")
    parser.add_argument("--output", type=Path, default=interpreter.ROOT / "build" / "bench")
    parser.add_argument(
        "--docs", action="store_true", help="put what was measured into docs/stress.md and peers.md"
    )
    parser.add_argument("--compare", nargs=2, metavar="JSON", help="print where two result files differ")
    return parser.parse_args(words)


class Bench:
    """One run: its options, its results, and the report as it grows."""

    def __init__(self, options):
        self.options = options
        self.results = {"frames": options.frames, "seed": options.seed, "renderer": frames.renderer_digest()}
        self.earlier = earlier.load(options.earlier, self.results) if options.earlier else {}
        self.sections = []
        self.margins = []
        options.output.mkdir(parents=True, exist_ok=True)

    def names(self, wanted):
        """The methods of `wanted` that are to take part."""
        chosen = self.options.methods.split(",") if self.options.methods else list(methods.METHODS)
        return [name for name in wanted if name in chosen]

    def section(self, title, text):
        self.sections.append("%s\n%s\n\n%s\n" % (title, "=" * len(title), text))
        print("\n" + self.sections[-1], flush=True)
        (self.options.output / "report.txt").write_text("\n".join(self.sections), encoding="utf-8")
        (self.options.output / "results.json").write_text(json.dumps(self.results, indent=1) + "\n")

    def evaluate(self, todo, text):
        """Runs jobs with a progress bar."""
        with Progress(transient=True, disable=not sys.stderr.isatty()) as progress:
            bar = progress.add_task(text, total=sum(job.count for job in todo))
            done = evaluate.run_all(
                todo, self.options.jobs, lambda count: progress.update(bar, advance=count)
            )
        for tallies in done.values():
            for name, tally in tallies.items():
                if name == "larics":
                    self.margins.extend(tally.margins)
        return done

    def quality(self):
        names = self.names(plan.QUALITY_METHODS)
        presets = [*plan.presets(), *evaluate.NEGATIVES]
        todo = []
        for preset in presets:
            count = self.options.frames * (3 if preset in evaluate.NEGATIVES else 1)
            todo += evaluate.jobs(preset, preset, self.options.seed, count, plan.RADIUS_PX, {}, names)
        done = self.evaluate(todo, "quality")
        others = self.earlier.get("quality", {})
        rows = {
            preset: earlier.in_order(
                {**others.get(preset, {}), **{name: done[preset][name].row() for name in names}}
            )
            for preset in presets
        }
        self.results["quality"] = rows
        plots.quality({p: rows[p] for p in plan.presets()}, self.options.output / "quality.png")
        self.section("Quality by preset, R = %g px" % plan.RADIUS_PX, report.quality(rows))

    def sweeps(self):
        names = self.names(plan.SWEPT_METHODS)
        count = plan.frames_a_point(self.options.frames)
        todo = []
        for key in plan.SWEEPS:
            todo += plan.sweep_jobs(key, self.options.seed + 1, count, names)
        done = self.evaluate(todo, "sweeps")
        self.results["sweeps"] = {}
        for key, sweep in plan.SWEEPS.items():
            rows_of = {name: [done[key, value][name].row() for value in sweep.values] for name in names}
            rows_of = earlier.in_order(
                {**self.earlier.get("sweeps", {}).get(key, {}).get("methods", {}), **rows_of}
            )
            self.results["sweeps"][key] = {"values": sweep.values, "methods": rows_of}
            path = self.options.output / ("sweep_%s.png" % key)
            plots.sweep(sweep, rows_of, path)
            self.section("%s, %d frames a point" % (sweep.title, count), report.sweep(sweep, rows_of))

    def risk(self):
        """Over every detection of ours so far, and harsh frames besides."""
        count = 4 * self.options.frames
        seed = self.options.seed + 2
        todo = evaluate.jobs("risk", "harsh", seed, count, plan.RADIUS_PX, {}, ["larics"])
        harsh = self.evaluate(todo, "risk")["risk"]["larics"]
        rows = scoring.risk_by_margin(self.margins, range(0, 257, 16))
        order = scoring.ordering(self.margins)
        least = scoring.by_least_margin(harsh.margins, harsh.markers, plan.LEAST_MARGINS)
        self.results["risk"] = {"bins": rows, "ordering": order, "least": least, "markers": harsh.markers}
        plots.risk(rows, order, self.options.output / "risk.png")
        self.section("Wrong IDs by margin", report.risk(rows, order))
        title = "What margin_min trades, %d harsh markers" % harsh.markers
        self.section(title, report.least_margin(least))

    def time(self):
        names = self.names(plan.TIMED_METHODS)
        count = max(10, self.options.frames // 2)
        with Progress(transient=True, disable=not sys.stderr.isatty()) as progress:
            bar = progress.add_task("time", total=count)
            by_method = timing.host_times(
                names, "sunny", self.options.seed + 3, count, plan.RADIUS_PX,
                lambda done: progress.update(bar, advance=done),
            )  # fmt: skip
        self.results["host_time"] = by_method
        plots.times(by_method, self.options.output / "time.png")
        text = report.times(by_method)
        self.section("Time a frame on this host, %dx%d, one thread" % (frames.WIDTH, frames.HEIGHT), text)

    def tracking(self):
        count = max(10, self.options.frames // 2)
        rows = {}
        with Progress(transient=True, disable=not sys.stderr.isatty()) as progress:
            bar = progress.add_task("tracking", total=count * len(plan.ONE_MARKER))
            for preset in plan.ONE_MARKER:
                rows[preset] = tracking.compare(
                    preset, self.options.seed + 5, count, plan.RADIUS_PX,
                    lambda done: progress.update(bar, advance=done),
                )  # fmt: skip
        self.results["tracking"] = rows
        title = "Tracking from predictions wrong by up to %g px" % tracking.PREDICTION_ERROR_PX
        self.section(title, report.tracking(rows))

    def micropython(self):
        """Cost on the pinned unix interpreter, and on the one given when that is another."""
        own = interpreter.command(str(Path(sys.executable).with_name("micropython")))
        given = interpreter.command(os.environ.get("MICROPYTHON", "")) or own
        count = min(60, max(10, self.options.frames // 4))
        folder = self.options.output / "frames"
        drawn = {
            scene: interpreter.write_frames(folder, scene, self.options.seed + 4, count)
            for scene in {job.scene for job in plan.COSTS.values()}
        }
        self.results["micropython"] = {}
        for kind, command in (("unix", own), ("given", given)):
            if kind == "given" and given == own:
                continue
            costs = {}
            for name, job in plan.COSTS.items():
                paths, truths = drawn[job.scene]
                if job.track:
                    paths = interpreter.with_predictions(paths, truths, self.options.seed)
                costs[name] = interpreter.measure(
                    command, paths, job.method, job.radius_range, job.max_tilt_deg
                )
            self.results["micropython"][kind] = costs
            unit = "million instructions" if next(iter(costs.values()))["unit"] == "Minsn" else "milliseconds"
            self.section("A frame on MicroPython (%s), %s" % (kind, unit), report.cost(costs))


def chosen(text, known, what):
    """A comma-separated list of names; ends the program with one line when a name is unknown."""
    for name in text.split(","):
        if name not in known:
            sys.exit("bench: unknown %s %s; use %s" % (what, name, ", ".join(known)))
    return text.split(",")


def compare(paths):
    """Prints where two result files differ."""
    results = []
    for path in paths:
        try:
            results.append(json.loads(Path(path).read_text(encoding="utf-8")))
        except (OSError, ValueError) as error:
            sys.exit("bench: %s is no results.json: %s" % (path, error))
    print("\n".join(report.comparison(*results)) or "no difference")


def main():
    options = arguments()
    if options.compare:
        compare(options.compare)
        return
    parts = chosen(options.only, PARTS, "part")
    if options.methods:
        chosen(options.methods, list(methods.METHODS), "method")
    if options.frames < 1:
        sys.exit("bench: --frames must be at least 1")
    started = time.monotonic()
    try:
        bench = Bench(options)
    except ValueError as error:
        sys.exit("bench: %s" % error)
    for part in PARTS:
        if part in parts:
            try:
                getattr(bench, part)()
            except interpreter.InterpreterError as error:
                sys.exit("bench: %s" % error)
    reached = targets.targets(bench.results)
    if reached:
        bench.section("Targets", report.target_table(reached))
    if options.docs:
        try:
            parts = page.write(bench.results, options.output, DOCS)
        except (OSError, ValueError) as error:
            sys.exit("bench: %s: %s" % (DOCS, error))
        print("bench: in %s: %s" % (DOCS.relative_to(interpreter.ROOT), ", ".join(parts) or "nothing new"))
    elapsed = time.monotonic() - started
    print("bench: %.0f s; tables, plots and results.json in %s" % (elapsed, options.output))


if __name__ == "__main__":
    main()
