"""Runs the firmware for a long time on a small fixed heap, and plots heap and latency.

    python tools/soak.py [--frames 100000]

The compiled program (as on a board) is given 400 frames a second of 320x240 on real MicroPython and writes to
a pseudo-terminal; its status messages tell the free heap, the latency and the faults. The vehicle swings to
and fro below a marker, in and out of its sight, so that no pose jumps: there must be no fault.
Output: build/soak/soak.png, run.jsonl.
"""

import argparse
import json
import math
import os
import pathlib
import shlex
import subprocess
import sys
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "shared"), str(ROOT / "host")]

from larics_host.connection.byte_sources import SerialSource  # noqa: E402
from larics_host.connection.pty_pair import PtyPair  # noqa: E402
from larics_host.connection.receiver import Receiver  # noqa: E402
from larics_host.connection.records import known  # noqa: E402
from larics_host.flash import build  # noqa: E402
from larics_host.render import render_view  # noqa: E402
from larics_host.render.camera import Camera, Motion  # noqa: E402
from larics_host.render.sensor import Sensor  # noqa: E402
from tools.demo import drive  # noqa: E402

FOLDER = ROOT / "build" / "soak"
WIDTH, HEIGHT = 320, 240
FPS = 400
SWING = 1600  # frames there and back
WAY_S = (-1.2, 2.6)  # part of the demo's drive, in its seconds


def prepare(march):
    """The compiled program and one file with all frames."""
    for name, data in build.compile_program(ROOT, march, build.PC_ONLY):
        path = FOLDER / "program" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    frames = render()
    with open(FOLDER / "frames.pgm", "wb") as file:
        for frame in frames + frames[-2:0:-1]:
            file.write(b"P5\n%d %d\n255\n" % (WIDTH, HEIGHT) + frame.tobytes())
    values = dict(drive.settings(), baud=921600, rate_divider=4, max_speed_mm_s=2000, second_opinion=False)
    (FOLDER / "settings.json").write_text(json.dumps(values))


def render():
    """The frames of the way there."""
    scene = drive.scene()
    camera = Camera(WIDTH, HEIGHT, focal_px=drive.FOCAL_PX, row_us=0.0, exposure_us=5000.0)
    sensor = Sensor(150, 30, read_noise=1.2, shot_noise=0.012, vignetting=0.25, defocus_px=0.6)
    frames = []
    for index in range(SWING // 2 + 1):
        share = (1 - math.cos(2 * math.pi * index / SWING)) / 2
        pose = drive.pose_at(WAY_S[0] + share * (WAY_S[1] - WAY_S[0]))
        rng = np.random.default_rng([drive.SEED, index])
        frames.append(render_view(scene, pose, Motion(0.0, 0.0, 0.0), camera, sensor, rng)[0])
    return frames


def run(frames, heap_bytes):
    """Runs until so many frames were processed; (status messages with the time of each, exit code or None
    when it was still running, seconds until the first message)."""
    micropython = shlex.split(os.environ.get("MICROPYTHON", "")) or [str(ROOT / ".venv/bin/micropython")]
    main = "import gc, sys; gc.threshold(4096)\n"  # as main.py for a small heap
    main += "from pc import replay_main\nreplay_main.main(sys.argv[1:])"
    command = [*micropython, "-X", "heapsize=%d" % heap_bytes, "-c", main]
    with PtyPair() as cable:
        source = SerialSource(cable.device_b)
        receiver, statuses = Receiver(), []
        command += ["--frames", str(FOLDER / "frames.pgm"), "--port", cable.device_a, "--rounds", "0"]
        command += ["--fps", str(FPS)]
        start_s, first_s = time.monotonic(), None
        process = subprocess.Popen(
            [*command, "--settings", str(FOLDER / "settings.json")],
            env=dict(os.environ, MICROPYPATH=str(FOLDER / "program") + ":.frozen"),
        )
        with open(FOLDER / "run.jsonl", "w") as log:
            while process.poll() is None and not (statuses and statuses[-1]["frames"] >= frames):
                for message in receiver.feed(source.read(), time.monotonic() - start_s):
                    first_s = first_s or message.time_s
                    if message.name == "STATUS" and known(message.fields, "latency_us"):  # not before a frame
                        statuses.append(dict(message.fields._asdict(), time_s=message.time_s))
                        log.write(json.dumps(statuses[-1]) + "\n")
        code = process.poll()
        process.kill()
        process.wait()
        source.close()
    return statuses, code, first_s


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
    parser.add_argument("--frames", type=int, default=100000, help="to be processed")
    parser.add_argument("--heap-kib", type=int, default=256, help="beside the frame")
    parser.add_argument("--march", default="x64", help="of mpy-cross, for the interpreter that runs it")
    args = parser.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    prepare(args.march)
    heap_bytes = args.heap_kib * 1024 + WIDTH * HEIGHT
    statuses, code, first_s = run(args.frames, heap_bytes)
    if code is not None:
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
