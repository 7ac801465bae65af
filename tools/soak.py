"""Runs the firmware for a long time on a small fixed heap, and plots heap and latency.

    python tools/soak.py [--frames 100000]

The compiled program (as on a board) processes the demo's frames, cut to the boards' usual 320x240, over and
over on real MicroPython, at full speed, and writes to a pseudo-terminal; its status messages tell the free
heap, the latency and the faults.
Output: build/soak/soak.png, run.jsonl.
"""

import argparse
import json
import os
import pathlib
import shlex
import subprocess
import sys
import time

import cv2

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "shared"), str(ROOT / "host")]

from larics_host.flash import build  # noqa: E402
from larics_host.link import SerialSource  # noqa: E402
from larics_host.pty_pair import PtyPair  # noqa: E402
from larics_host.receiver import Receiver  # noqa: E402
from tools.demo import drive  # noqa: E402

FOLDER = ROOT / "build" / "soak"
WIDTH, HEIGHT = 320, 240
PC_ONLY = ("desk.py", "uart_unix.py")


def prepare(march):
    """The compiled program and one file with all frames; returns the number of frames."""
    build.LEFT_OUT -= set(PC_ONLY)
    for name, data in build.compile_program(ROOT, march):
        path = FOLDER / "program" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    (ROOT / "build" / "demo").mkdir(parents=True, exist_ok=True)
    drive.prepare(ROOT / "build" / "demo", lambda done, total: None)
    frames = sorted((ROOT / "build" / "demo" / "frames").glob("*.pgm"))
    left, top = (drive.WIDTH - WIDTH) // 2, (drive.HEIGHT - HEIGHT) // 2
    with open(FOLDER / "frames.pgm", "wb") as file:
        for path in frames:
            frame = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
            file.write(b"P5\n%d %d\n255\n" % (WIDTH, HEIGHT))
            file.write(frame[top : top + HEIGHT, left : left + WIDTH].tobytes())
    values = dict(drive.settings(), baud=921600, rate_divider=4)
    (FOLDER / "settings.json").write_text(json.dumps(values))
    return len(frames)


def run(rounds, heap_bytes):
    """The status messages of a run, with the time of each; (statuses, exit code, seconds until the first)."""
    micropython = shlex.split(os.environ.get("MICROPYTHON", "")) or [str(ROOT / ".venv/bin/micropython")]
    main = "import desk, sys; desk.main(sys.argv[1:])"
    command = [*micropython, "-X", "heapsize=%d" % heap_bytes, "-c", main]
    with PtyPair() as cable:
        source = SerialSource(cable.device_b)
        receiver, statuses = Receiver(), []
        command += ["--frames", str(FOLDER / "frames.pgm"), "--port", cable.device_a, "--rounds", str(rounds)]
        start_s, first_s = time.monotonic(), None
        process = subprocess.Popen(
            [*command, "--settings", str(FOLDER / "settings.json")],
            env=dict(os.environ, MICROPYPATH=str(FOLDER / "program") + ":.frozen"),
        )
        quiet_s = start_s
        with open(FOLDER / "run.jsonl", "w") as log:
            while process.poll() is None or time.monotonic() - quiet_s < 1:
                data = source.read()
                now_s = time.monotonic()
                if data:
                    quiet_s = now_s
                for message in receiver.feed(data, now_s - start_s):
                    first_s = first_s or message.time_s
                    if message.name == "STATUS":
                        statuses.append(dict(message.fields, time_s=message.time_s))
                        log.write(json.dumps(statuses[-1]) + "\n")
        source.close()
    return statuses, process.returncode, first_s


def plot(statuses, heap_bytes, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    frames = [status["frames"] for status in statuses]
    figure, axes = plt.subplots(3, 1, figsize=(10, 7), sharex=True)
    axes[0].plot(frames, [status["free_bytes"] / 1024 for status in statuses], color="#2f6fde")
    axes[0].set_ylim(0, None)
    axes[0].set_ylabel("free heap, KiB")
    axes[1].plot(frames, [status["latency_us"] / 1000 for status in statuses], color="#22303c", linewidth=0.8)
    axes[1].set_ylim(0, None)
    axes[1].set_ylabel("worst latency\nin each second, ms")
    axes[2].plot(frames, [status["detect_us"] / 1000 for status in statuses], color="#00a35c", linewidth=0.8)
    axes[2].set_ylim(0, None)
    axes[2].set_ylabel("mean detection, ms")
    axes[2].set_xlabel("frames processed, heap of %d KiB" % (heap_bytes // 1024))
    for panel in axes:
        panel.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=100000)
    parser.add_argument("--heap-kib", type=int, default=256, help="beside the frame")
    parser.add_argument("--march", default="x64", help="of mpy-cross, for the interpreter that runs it")
    args = parser.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    count = prepare(args.march)
    heap_bytes = args.heap_kib * 1024 + WIDTH * HEIGHT
    statuses, code, first_s = run(-(-args.frames // count), heap_bytes)
    if code or not statuses:
        raise SystemExit("soak: the firmware ended with code %d" % code)
    free = [status["free_bytes"] for status in statuses]
    settled = free[len(free) // 10 :]
    last = statuses[-1]
    print("heap %d KiB: %d KiB beside the frame" % (heap_bytes // 1024, args.heap_kib))
    print("first message after %.2f s" % first_s)
    print("frames processed %d in %.0f s, missed %d" % (last["frames"], last["time_s"], last["missed"]))
    print("free heap %d..%d bytes, first %d, last %d" % (min(settled), max(settled), settled[0], settled[-1]))
    print("latency, worst in a second: median %.1f ms, worst %.1f ms" % (
        sorted(s["latency_us"] for s in statuses)[len(statuses) // 2] / 1000,
        max(s["latency_us"] for s in statuses) / 1000))  # fmt: skip
    print("faults %d, last code %d" % (last["faults"], last["last_fault"]))
    plot(statuses, heap_bytes, FOLDER / "soak.png")
    print("plot: build/soak/soak.png")


if __name__ == "__main__":
    main()
