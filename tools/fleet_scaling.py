"""What one worker of a Dask cluster does in a second, and how much more two do: python -m tools.fleet_scaling

Makes logs of some size and frames, starts a scheduler and workers on loopback, runs what `larics fleet` and
`larics validate` do with them here, with one worker and with two. Figures: docs/fleet.md.
"""

import argparse
import contextlib
import hashlib
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

from larics_host.detection import batch
from larics_host.detection.options import DetectionOptions
from larics_host.fleet import engine
from larics_host.fleet.findings import examine
from larics_host.fleet.sources import blocks, list_logs
from larics_host.fleet.tally import Work, read_block, vehicles
from larics_host.render import render_frame

ROOT = pathlib.Path(__file__).resolve().parent.parent


@contextlib.contextmanager
def cluster(folder, workers):
    """(address, processes) of a scheduler with so many workers of one thread."""
    file = folder / "scheduler.json"
    file.unlink(missing_ok=True)
    paths = [str(ROOT / name) for name in ("shared", "host", ".")]
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(paths), NUMBA_NUM_THREADS="1")
    local = "--host", "127.0.0.1", "--no-dashboard"
    processes = []

    def start(*words):
        command = [sys.executable, "-m", "dask", *words, *local]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        processes.append(subprocess.Popen(command, env=environment, **quiet))

    start("scheduler", "--port", "0", "--scheduler-file", str(file))
    try:
        while not (file.exists() and file.read_text().endswith("}")):
            time.sleep(0.1)
        address = json.loads(file.read_text())["address"]
        for _ in range(workers):
            start("worker", address, "--nthreads", "1", "--no-nanny")
        yield address, processes
    finally:
        for process in reversed(processes):
            process.kill()
            process.wait()


def memory_mib(process):
    """The largest memory that a process had so far."""
    for line in pathlib.Path("/proc/%d/status" % process.pid).read_text().splitlines():
        if line.startswith("VmHWM"):
            return int(line.split()[1]) / 1024
    return 0.0


def timed(work, scheduler, workers=1):
    """(seconds, answers) of engine.run, when all that takes part has loaded and compiled what it needs."""
    function, tasks = work
    list(engine.run(function, tasks[: 2 * workers], scheduler=scheduler))
    start_s = time.perf_counter()
    answers = list(engine.run(function, tasks, scheduler=scheduler))
    return time.perf_counter() - start_s, answers


def digest(value):
    return hashlib.sha256(repr(value).encode()).hexdigest()[:12]


def log_work(folder, megabytes):
    from tests.host.fleet_logs import Vehicle  # the logs of the tests, longer

    text = Vehicle(1).write(folder / "one.jsonl", 0, 8).read_bytes()
    logs = folder / "logs"
    logs.mkdir()
    for number in range(8):
        copies = max(1, round(megabytes * 1e6 / 8 / len(text)))
        (logs / ("%d.jsonl" % number)).write_bytes(text * copies)
    work = [Work(block, (), 10) for block in blocks(list_logs([str(logs)]))]
    size = sum(path.stat().st_size for path in logs.iterdir())
    lines = size // (len(text) // text.count(b"\n"))

    def result(answers):
        tallies, counts, _ = vehicles((w.block, a) for w, a in zip(work, answers, strict=True))
        return digest(list(examine(tallies, counts)))

    return (read_block, work), size, lines, result


def frame_work(folder, frames):
    import cv2

    for index in range(200):
        frame, _ = render_frame("cloudy", 7, index)
        cv2.imwrite(str(folder / ("%04d.pgm" % index)), frame)
    paths = sorted(folder.glob("*.pgm"))
    paths = [paths[k % len(paths)] for k in range(frames)]
    options = DetectionOptions(radius_px=(25, 36))
    tasks = [(options, False, paths[k : k + 128]) for k in range(0, frames, 128)]

    def result(answers):
        return digest([(r.name, r.found) for results, _ in answers for r in results])

    return (batch._run, tasks), result


def processor_s(process):
    """Processor time that a process has taken."""
    fields = pathlib.Path("/proc/%d/stat" % process.pid).read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def report(what, unit, count, work, result, folder):
    before_s = time.process_time()
    here_s, answers = timed(work, None)
    here_cpu_s = time.process_time() - before_s
    wanted = result(answers)
    line = "%s: here %.2f s, %.3g %s/s, %.2f s of processor with warming up"
    print(line % (what, here_s, count / here_s, unit, here_cpu_s))
    one_s = None
    for workers in (1, 2):
        with cluster(folder, workers) as (address, processes):
            timed(work, address, workers)
            taken = [processor_s(process) for process in processes]
            before_s = time.process_time()
            seconds, answers = timed(work, address, workers)
            own_s = time.process_time() - before_s
            taken = [processor_s(process) - took for process, took in zip(processes, taken, strict=True)]
            assert result(answers) == wanted, "the results differ"
            most = max(memory_mib(process) for process in processes[1:])
            one_s = one_s or seconds
            line = "%s: workers %d, %.2f s, %.3g %s/s, %.2f times one; largest worker %.0f MiB; processor: "
            print(line % (what, workers, seconds, count / seconds, unit, one_s / seconds, most), end="")
            print("workers %.2f s, scheduler %.2f s, here %.2f s" % (sum(taken[1:]), taken[0], own_s))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--megabytes", type=float, default=400)
    parser.add_argument("--frames", type=int, default=12000)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        work, size, lines, result = log_work(folder, args.megabytes)
        print("logs: %.0f MB, %d lines" % (size / 1e6, lines))
        report("logs", "MB", size / 1e6, work, result, folder)
        work, result = frame_work(folder, args.frames)
        report("frames", "frames", args.frames, work, result, folder)
    print("this process: %.0f MiB" % (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))


if __name__ == "__main__":
    main()
